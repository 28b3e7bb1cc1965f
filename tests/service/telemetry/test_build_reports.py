"""Builds of forked processes are counted by the one that forked them, whatever becomes of those."""

import os
import signal
import time

import pytest

from service.telemetry.build_reports import BuildReports
from service.telemetry.metrics import BuildFigures


@pytest.fixture
def reports():
    made = BuildReports()
    yield made
    made.close()


def until(condition):
    deadline = time.monotonic() + 30
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.01)


def forked(work):
    """Return the id of a process that does something and ends, as a worker's slots are made."""
    child = os.fork()
    if child == 0:
        try:
            work()
        finally:
            os._exit(0)
    return child


def test_builds_of_several_processes_are_added(reports):
    # forked before there are threads
    children = [
        forked(lambda: reports.ended("succeeded", {"metric": 0.5, "total": 1.0})) for _ in range(4)
    ]
    figures = BuildFigures()
    reports.forward(figures)
    until(lambda: figures.outcomes == {"succeeded": 4})
    assert figures.stages["metric"].sum == 2.0
    assert figures.seconds.sum == 4.0
    for child in children:
        os.waitpid(child, 0)


def test_processes_that_are_killed_in_the_middle_garble_nothing(reports):
    def work():
        while True:
            reports.ended("succeeded", dict.fromkeys(("boundary", "total"), 0.123456))

    children = [forked(work) for _ in range(3)]
    figures = BuildFigures()
    reports.forward(figures)
    for child in children:
        until(lambda: figures.outcomes.get("succeeded", 0) > 50)
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
    # those that the last one has written are read, and so is what comes after them
    reports.ended("cancelled", {"total": 1.0})
    until(lambda: figures.outcomes.get("cancelled") == 1)
    assert set(figures.outcomes) == {"succeeded", "cancelled"}


def test_a_pipe_that_nobody_empties_makes_no_build_wait(reports, caplog):
    clock = time.monotonic()
    for _ in range(3000):
        reports.ended("succeeded", {"total": 1.0})
    assert time.monotonic() - clock < 10
    assert "a build is not counted" in caplog.text


def test_a_line_is_never_longer_than_a_pipe_takes_whole(reports):
    reports.ended("failed", {f"stage {number}": 1.0 for number in range(1000)})
    figures = BuildFigures()
    reports.forward(figures)
    until(lambda: figures.outcomes == {"failed": 1})
