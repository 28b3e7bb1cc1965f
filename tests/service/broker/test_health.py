import json
import os
import re
import subprocess
import sys
import tempfile
import time

import pytest

from service.broker import health


@pytest.fixture(autouse=True)
def _own_folder(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))


@pytest.fixture
def signs(tmp_path):
    def files():
        return sorted(tmp_path.glob("gamut-workers-*/*"))

    return files


def test_a_worker_with_a_warm_process_is_well_and_any_other_is_named(signs):
    (fault,) = health.faults()
    assert "no worker that is connected" in fault
    health.sign(0, 2)
    (fault,) = health.faults()
    assert f"worker {os.getpid()}: none of its 2 processes is warm" in fault
    health.sign(1, 2)
    assert health.faults() == []
    assert [path.name for path in signs()] == [f"{os.getpid()}.json"]
    health.leave()
    assert signs() == []
    health.leave()


def test_a_worker_that_was_not_heard_of_or_whose_sign_is_unreadable_is_named(signs):
    health.sign(1, 1)
    (path,) = signs()
    path.write_text(json.dumps({**json.loads(path.read_text()), "time": time.time() - 6000}))
    (fault,) = health.faults()
    assert re.search(r"no heartbeat for 6\d\d\d s", fault)
    path.write_text("{")
    (fault,) = health.faults()
    assert str(path) in fault


def test_the_sign_of_a_worker_that_was_killed_is_removed(signs):
    ended = subprocess.Popen([sys.executable, "-c", ""])
    ended.wait()
    health.sign(1, 1)
    (path,) = signs()
    path.rename(path.with_name(f"{ended.pid}.json"))
    (fault,) = health.faults()
    assert "no worker that is connected" in fault
    assert signs() == []


def test_the_check_says_what_is_wrong_and_needs_nothing_but_the_standard_library(tmp_path):
    code = (
        "import sys; from service.broker.health import main; status = main();"
        "print([name for name in sys.modules if name.partition('.')[0] in"
        " {'pydantic', 'numpy', 'celery', 'fastapi'}]); sys.exit(status)"
    )
    answer = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, "TMPDIR": str(tmp_path)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert answer.returncode == 1
    fault, loaded = answer.stdout.splitlines()
    assert "no worker that is connected" in fault
    assert loaded == "[]"
