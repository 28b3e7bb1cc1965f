"""The end of a build is counted, and traced where there are traces."""

import time

from opentelemetry.sdk.trace.export import SimpleSpanProcessor
from opentelemetry.sdk.trace.export.in_memory_span_exporter import InMemorySpanExporter

from service.jobs.book import JobDocument
from service.telemetry.build_observer import BuildObserver
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
