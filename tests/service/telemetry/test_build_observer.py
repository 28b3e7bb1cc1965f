"""The end of a build is counted, and traced where there are traces."""

import os
import signal
import time

import pytest
from opentelemetry.sdk.trace.export import SimpleSpanProcessor
from opentelemetry.sdk.trace.export.in_memory_span_exporter import InMemorySpanExporter

from service.jobs.book import JobDocument
from service.telemetry.build_observer import BuildObserver, BuildReports
from service.telemetry.metrics import BuildFigures
from service.telemetry.traces import Traces

JOB = JobDocument("f" * 64, {}, trace={"traceparent": f"00-{'a' * 32}-{'b' * 16}-01"})
SECONDS = {"boundary": 0.5, "decimation": 0.25, "total": 1.0}


def test_a_build_is_counted_without_traces():
    figures = BuildFigures()
    BuildObserver(figures, None)("succeeded", SECONDS, JOB)
    assert figures.outcomes == {"succeeded": 1}
    assert figures.stages["boundary"].sum == 0.5


def test_a_build_ended_now_and_began_its_seconds_ago():
    exporter = InMemorySpanExporter()
    BuildObserver(BuildFigures(), Traces(SimpleSpanProcessor(exporter)))("succeeded", SECONDS, JOB)
    spans = {span.name: span for span in exporter.get_finished_spans()}
    assert set(spans) == {"build", "build boundary", "build decimation"}
    build = spans["build"]
    assert abs(build.end_time / 1e9 - time.time()) < 5
    assert round((build.end_time - build.start_time) / 1e9, 6) == 1.0
    assert build.context.trace_id == int("a" * 32, 16)
    assert build.attributes["gamut.id"] == JOB.id


def test_a_crash_that_tells_no_times_is_a_span_all_the_same():
    exporter = InMemorySpanExporter()
    BuildObserver(BuildFigures(), Traces(SimpleSpanProcessor(exporter)))("build-crashed", {}, JOB)
    (span,) = exporter.get_finished_spans()
    assert span.attributes["gamut.build.outcome"] == "build-crashed"
    assert not span.status.is_ok


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
        forked(lambda: reports.count_build("succeeded", {"metric": 0.5, "total": 1.0}))
        for _ in range(4)
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
            reports.count_build("succeeded", dict.fromkeys(("boundary", "total"), 0.123456))

    children = [forked(work) for _ in range(3)]
    figures = BuildFigures()
    reports.forward(figures)
    for child in children:
        until(lambda: figures.outcomes.get("succeeded", 0) > 50)
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
    # those that the last one has written are read, and so is what comes after them
    reports.count_build("cancelled", {"total": 1.0})
    until(lambda: figures.outcomes.get("cancelled") == 1)
    assert set(figures.outcomes) == {"succeeded", "cancelled"}


def test_a_pipe_that_nobody_empties_makes_no_build_wait(reports, caplog):
    clock = time.monotonic()
    for _ in range(3000):
        reports.count_build("succeeded", {"total": 1.0})
    assert time.monotonic() - clock < 10
    assert "build was not counted" in caplog.text


def test_a_line_is_never_longer_than_a_pipe_takes_whole(reports):
    reports.count_build("failed", {f"stage {number}": 1.0 for number in range(1000)})
    figures = BuildFigures()
    reports.forward(figures)
    until(lambda: figures.outcomes == {"failed": 1})
