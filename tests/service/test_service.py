"""What importing the package does, in fresh processes."""

import os
import subprocess
import sys

import pytest

THREADS = """
import service.server, threadpoolctl
print({each["num_threads"] for each in threadpoolctl.threadpool_info()})
"""


@pytest.mark.slow
@pytest.mark.parametrize(("given", "threads"), [(None, "{1}"), ("2", "{2}")])
def test_linear_algebra_has_one_thread_unless_the_operator_gives_more(given, threads):
    environment = {name: text for name, text in os.environ.items() if "NUM_THREADS" not in name}
    if given is not None:
        environment["OPENBLAS_NUM_THREADS"] = given
    printed = subprocess.check_output([sys.executable, "-c", THREADS], env=environment, text=True)
    assert printed.strip() == threads
