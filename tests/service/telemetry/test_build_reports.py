"""Ended builds of forked processes, counted in the process that serves the metrics."""

import os
import signal
import time

import pytest

from service.telemetry.build_reports import BuildReports
from service.telemetry.metrics import Metrics


def ended(metrics, outcome):
    """Return the number of builds with an outcome; 0 before the first."""
    return metrics.registry.get_sample_value("gamut_builds_total", {"outcome": outcome}) or 0


@pytest.fixture
def reports():
    made = BuildReports()
    yield made
    made.close()


def until(condition):
    deadline = time.monotonic() + 600
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


def test_builds_of_several_processes_are_added_whole_when_they_are_killed(reports):
    def work():
        while True:
            reports.count_build("succeeded", {"metric": 0.5, "total": 1.0})

    # forked before there are threads
    children = [forked(work) for _ in range(3)]
    metrics = Metrics()
    reports.forward(metrics.builds)
    for child in children:
        known = ended(metrics, "succeeded")
        until(lambda known=known: ended(metrics, "succeeded") > known + 50)
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
    # those that the last one has written are read, and so is what comes after them
    reports.count_build("cancelled", {"total": 1.0})
    value = metrics.registry.get_sample_value
    until(lambda: ended(metrics, "cancelled") == 1)
    until(lambda: value("gamut_build_seconds_count") == ended(metrics, "succeeded") + 1)
    assert value("gamut_builds_total", {"outcome": "failed"}) is None
    stages = value("gamut_build_stage_seconds_sum", {"stage": "metric"})
    assert stages == 0.5 * ended(metrics, "succeeded")
    assert value("gamut_build_seconds_sum") == ended(metrics, "succeeded") + 1


def test_a_pipe_that_nobody_empties_makes_no_build_wait(reports, caplog):
    for _ in range(3000):
        reports.count_build("succeeded", {"total": 1.0})
    assert "build was not counted" in caplog.text


def test_a_line_is_never_longer_than_a_pipe_takes_whole(reports):
    reports.count_build("failed", {f"stage {number}": 1.0 for number in range(1000)})
    metrics = Metrics()
    reports.forward(metrics.builds)
    until(lambda: ended(metrics, "failed") == 1)
