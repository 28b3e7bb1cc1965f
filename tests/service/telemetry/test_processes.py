"""What processes use, compared with what they are known to do."""

import subprocess
import sys
import time

import pytest

from service.telemetry.processes import descendants_usage

WORK = """
import sys
block = bytearray(50_000_000)
for place in range(0, len(block), 4096):
    block[place] = 1
import time
end = time.process_time() + 0.3
while time.process_time() < end:
    pass
print("done", flush=True)
sys.stdin.read()
"""


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux has /proc")
@pytest.mark.slow
def test_memory_and_time_of_children_are_told_and_time_is_kept():
    before = descendants_usage()
    with subprocess.Popen(
        [sys.executable, "-c", WORK], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as child:
        assert child.stdout.readline() == b"done\n"
        during = descendants_usage()
        child.stdin.close()
        child.wait()
    assert during.processes == before.processes + 1
    assert during.resident_bytes - before.resident_bytes > 50_000_000
    assert during.cpu_seconds - before.cpu_seconds >= 0.28
    deadline = time.monotonic() + 5
    while descendants_usage().processes > before.processes and time.monotonic() < deadline:
        time.sleep(0.01)
    after = descendants_usage()
    assert after.processes == before.processes
    # as a counter has to: a process that ends takes nothing with it
    assert after.cpu_seconds >= during.cpu_seconds - 0.02


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux has /proc")
def test_those_that_they_have_started_are_among_them():
    code = (
        "import subprocess, sys;"
        "child = subprocess.Popen([sys.executable, '-c', 'import sys; sys.stdin.read()'],"
        " stdin=subprocess.PIPE); print('started', flush=True); sys.stdin.read();"
        "child.stdin.close(); child.wait()"
    )
    before = descendants_usage()
    with subprocess.Popen(
        [sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as child:
        assert child.stdout.readline() == b"started\n"
        assert descendants_usage().processes == before.processes + 2
        child.stdin.close()
