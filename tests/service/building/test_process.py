import contextlib
import mmap
import os
import resource
import signal
import sys
import time

import pytest

from service.building.process import (
    BuildProcess,
    BuildTimeoutError,
    MemoryExceededError,
    ProcessDiedError,
    private_bytes,
)

MEBIBYTE = 1 << 20


def nothing(*_arguments):
    pass


@pytest.fixture
def process(scripted_worker):
    started = BuildProcess(scripted_worker)
    started.wait_until_ready(nothing)
    yield started
    started.kill()


@pytest.fixture
def result(process, tmp_path):
    """Have the process do what a text says, and return its final event."""

    def run(text, timeout=20.0, memory=0, progress=nothing, check=nothing):
        (tmp_path / "input").write_text(text)
        request = {
            "input": str(tmp_path / "input"),
            "output": str(tmp_path / "output"),
            "options": {"gamma": 1},
            "memory": memory,
        }
        return process.result(request, timeout=timeout, progress=progress, check=check)

    return run


def is_gone(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return True
    return False


@pytest.fixture
def many_open_files():
    """Have descriptors of up to three digits, and some more, in use, as by as many connections."""
    limits = resource.getrlimit(resource.RLIMIT_NOFILE)
    if 0 <= limits[1] < 1200:
        pytest.skip("the system does not let as many files be open")
    resource.setrlimit(resource.RLIMIT_NOFILE, (limits[1], limits[1]))
    with contextlib.ExitStack() as stack:
        while (descriptor := os.open(os.devnull, os.O_RDONLY)) < 1100:
            stack.callback(os.close, descriptor)
        stack.callback(os.close, descriptor)
        yield
    resource.setrlimit(resource.RLIMIT_NOFILE, limits)


@pytest.mark.usefixtures("many_open_files")
def test_a_process_is_spoken_to_however_many_files_are_open(process, result):
    assert process.fileno() > 1024
    assert result("build")["event"] == "built"


def test_builds_follow_one_another_in_one_process(process, result):
    stages = []
    for _ in range(3):
        event = result("build", progress=lambda stage, fraction: stages.append((stage, fraction)))
        assert event["event"] == "built"
    assert stages == [(f"pid {process.pid}", 0.5)] * 3
    assert process.alive


@pytest.mark.slow
def test_the_deadline_ends_the_process(process, result):
    clock = time.monotonic()
    with pytest.raises(BuildTimeoutError):
        result("hang", timeout=0.3)
    assert time.monotonic() - clock < 10
    assert not process.alive
    assert is_gone(process.pid)


@pytest.mark.slow
def test_a_build_that_fills_the_memory_is_ended_in_time(process, result):
    limit = process.private_bytes() + 100 * MEBIBYTE
    seen = []
    with pytest.raises(MemoryExceededError):
        result("swell", memory=limit, check=lambda: seen.append(process.private_bytes()))
    assert max(seen) > 50 * MEBIBYTE
    assert max(seen) < limit + 300 * MEBIBYTE
    assert is_gone(process.pid)


def test_what_the_caller_finds_ends_the_process(process, result):
    class FoundError(Exception):
        pass

    looks = []

    def check():
        looks.append(1)
        if len(looks) > 3:
            raise FoundError

    with pytest.raises(FoundError):
        result("hang", check=check)
    assert is_gone(process.pid)


@pytest.mark.parametrize(("text", "reason"), [("die", "exit status 3"), ("garble", "unreadable")])
def test_a_process_that_dies_or_babbles_is_dead(process, result, text, reason):
    with pytest.raises(ProcessDiedError, match=reason):
        result(text)
    assert is_gone(process.pid)


def test_a_process_that_is_killed_is_told_by_its_signal(process, result):
    def kill(*_arguments):
        os.kill(process.pid, signal.SIGKILL)

    with pytest.raises(ProcessDiedError, match="signal 9"):
        result("hang", progress=kill)


def test_a_process_that_died_while_idle_is_noticed(process, result):
    os.kill(process.pid, signal.SIGKILL)
    with pytest.raises(ProcessDiedError):
        result("build")


@pytest.mark.parametrize(
    "script", ["raise SystemExit(1)", "print('hello', flush=True)", "print(1)"]
)
def test_what_is_no_worker_does_not_start(script):
    process = BuildProcess((sys.executable, "-S", "-c", script))
    with pytest.raises(ProcessDiedError):
        process.wait_until_ready(nothing)
    assert is_gone(process.pid)


def test_starting_can_be_given_up():
    process = BuildProcess((sys.executable, "-S", "-c", "import time; time.sleep(1000)"))

    def check():
        raise InterruptedError

    with pytest.raises(InterruptedError):
        process.wait_until_ready(check)
    assert is_gone(process.pid)


@pytest.mark.slow
def test_a_stopped_process_holds_nobody_up(process, result):
    os.kill(process.pid, signal.SIGSTOP)
    with pytest.raises(BuildTimeoutError):
        result("build", timeout=0.3)
    assert is_gone(process.pid)


@pytest.mark.slow
def test_only_what_was_touched_and_belongs_to_the_process_counts(tmp_path):
    size = 64 << 20
    (tmp_path / "file").write_bytes(bytes(size))
    before = private_bytes("self")
    with (tmp_path / "file").open("rb") as file:
        mapped = mmap.mmap(file.fileno(), size, access=mmap.ACCESS_READ)
        assert sum(mapped[::4096]) == 0
        assert private_bytes(os.getpid()) - before < size / 2
        mapped.close()
    reserved = mmap.mmap(-1, size, mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
    assert private_bytes("self") - before < size / 2
    for place in range(0, size, 4096):
        reserved[place] = 1
    assert private_bytes("self") - before > size * 0.9
    reserved.close()


@pytest.mark.parametrize("process", [0, "none"])
def test_of_no_process_nothing_is_known(process):
    assert private_bytes(process) is None
