"""Traces: from the client's request to the stages of the build, whoever builds; off by default."""

import asyncio
import json
import logging
import os
import signal
import subprocess
import sys
import time

import pytest
from opentelemetry.sdk.trace.export import SimpleSpanProcessor
from opentelemetry.sdk.trace.export.in_memory_span_exporter import InMemorySpanExporter
from opentelemetry.trace import SpanKind, StatusCode

from gamutcore.building import STAGES
from service.jobs.book import JobDocument
from service.telemetry.build_observer import BuildObserver, BuildReports
from service.telemetry.logs import JsonLines
from service.telemetry.metrics import Metrics
from service.telemetry.request_observer import MatchedRoute, RequestObserver
from service.telemetry.traces import (
    Traces,
    TracesUnavailableError,
    propagation_headers,
    traces_of,
)

PARENT = "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01"  # the example of W3C's document
TRACE_ID, PARENT_ID = int(PARENT.split("-")[1], 16), int(PARENT.split("-")[2], 16)
ENDPOINT = "OTEL_EXPORTER_OTLP_ENDPOINT"


@pytest.fixture(autouse=True)
def plain_environment(monkeypatch):
    for name in (
        "OTEL_SDK_DISABLED",
        "OTEL_TRACES_EXPORTER",
        "OTEL_SERVICE_NAME",
        "OTEL_RESOURCE_ATTRIBUTES",
        ENDPOINT,
        "OTEL_EXPORTER_OTLP_TRACES_ENDPOINT",
    ):
        monkeypatch.delenv(name, raising=False)


@pytest.fixture
def exporter():
    return InMemorySpanExporter()


@pytest.fixture
def made(exporter):
    return Traces(SimpleSpanProcessor(exporter))


def answer(made, app, headers=(), query=b""):
    """Send a request through the layer that makes spans."""
    scope = {
        "type": "http",
        "method": "GET",
        "path": "/v1/gamuts/7/mesh",
        "query_string": query,
        "headers": list(headers),
    }

    async def send(_message):
        pass

    layer = RequestObserver(app, Metrics().requests, access_log=False, traces=made)
    asyncio.run(layer(scope, None, send))


def answering(status, seen=None):
    async def app(scope, _receive, send):
        scope["route"] = MatchedRoute("/v1/gamuts/{gamut_id}/mesh")
        if seen is not None:
            line = json.loads(JsonLines().format(logging.makeLogRecord({})))
            seen.append((line, propagation_headers()))
        await send({"type": "http.response.start", "status": status, "headers": []})
        await send({"type": "http.response.body", "body": b""})

    return app


class TestRequests:
    def test_a_request_is_a_span_of_its_client_s_trace(self, made, exporter):
        fields = [(b"traceparent", PARENT.encode()), (b"x-api-key", b"hidden-value")]
        answer(made, answering(200), fields, b"token=hidden-value")
        (span,) = exporter.get_finished_spans()
        assert "hidden-value" not in span.to_json()
        assert span.name == "GET /v1/gamuts/{gamut_id}/mesh"
        assert span.kind is SpanKind.SERVER
        assert (span.context.trace_id, span.parent.span_id) == (TRACE_ID, PARENT_ID)
        assert span.attributes["http.response.status_code"] == 200
        assert span.status.status_code is StatusCode.UNSET

    @pytest.mark.parametrize("field", [b"", b"nonsense", b"00-" + b"0" * 32 + b"-1-01", b"\xff"])
    def test_a_wrong_field_begins_a_trace(self, made, exporter, field):
        answer(made, answering(200), [(b"traceparent", field)])
        (span,) = exporter.get_finished_spans()
        assert span.parent is None
        assert span.context.is_valid

    def test_a_client_s_error_is_none_of_ours_and_a_defect_is(self, made, exporter):
        async def defect(_scope, _receive, _send):
            raise ArithmeticError("with a secret: hidden-value")

        answer(made, answering(404))
        with pytest.raises(ArithmeticError):
            answer(made, defect)
        client, ours = exporter.get_finished_spans()
        assert client.status.status_code is StatusCode.UNSET
        assert ours.status.status_code is StatusCode.ERROR
        assert ours.attributes["http.response.status_code"] == 500
        assert "hidden-value" not in ours.to_json()


class TestBuilds:
    def test_a_trace_goes_through_the_job_to_another_process(self, made, exporter):
        seen = []
        answer(made, answering(202, seen), [(b"traceparent", PARENT.encode())])
        ((line, carried),) = seen
        assert line["trace_id"] == f"{TRACE_ID:032x}"
        # what a job's document holds: text, as JSON keeps it
        carried = json.loads(json.dumps(carried))
        assert carried["traceparent"].split("-")[1] == f"{TRACE_ID:032x}"

        elsewhere = InMemorySpanExporter()
        Traces(SimpleSpanProcessor(elsewhere)).write_build(
            "f" * 64,
            "succeeded",
            {"boundary": 2.0, "decimation": 1.0},
            started=1000.0,
            finished=1003.5,
            trace=carried,
        )
        (request,) = exporter.get_finished_spans()
        spans = {span.name: span for span in elsewhere.get_finished_spans()}
        build = spans["build"]
        assert build.context.trace_id == request.context.trace_id == TRACE_ID
        assert build.parent.span_id == request.context.span_id
        assert build.attributes["gamut.id"] == "f" * 64
        assert (build.start_time, build.end_time) == (1000 * 10**9, 10035 * 10**8)
        boundary, decimation = spans["build boundary"], spans["build decimation"]
        assert boundary.parent.span_id == decimation.parent.span_id == build.context.span_id
        assert (boundary.start_time, boundary.end_time) == (1000 * 10**9, 1002 * 10**9)
        assert (decimation.start_time, decimation.end_time) == (1002 * 10**9, 1003 * 10**9)

    @pytest.mark.parametrize("trace", [{}, {"traceparent": "nonsense"}])
    def test_a_build_without_a_trace_begins_one(self, made, exporter, trace):
        made.write_build("a", "build-timeout", {}, started=1.0, finished=2.0, trace=trace)
        (span,) = exporter.get_finished_spans()
        assert span.parent is None
        assert span.status.status_code is StatusCode.ERROR
        assert span.attributes["error.type"] == "build-timeout"


class TestSetting:
    def test_there_are_none_by_default_and_nothing_is_loaded(self):
        code = (
            "import sys; from service.telemetry.traces import traces_of;"
            "assert traces_of('auto') is None;"
            "assert traces_of('off') is None;"
            "print([name for name in sys.modules if name.startswith('opentelemetry')])"
        )
        ended = subprocess.run(
            [sys.executable, "-c", code], capture_output=True, text=True, check=True
        )
        assert ended.stdout.strip() == "[]"
        assert propagation_headers() == {}

    @pytest.mark.parametrize(
        ("setting", "environment", "there"),
        [
            ("auto", {ENDPOINT: "http://127.0.0.1:9"}, True),
            ("auto", {"OTEL_TRACES_EXPORTER": "otlp"}, True),
            ("auto", {ENDPOINT: "http://127.0.0.1:9", "OTEL_SDK_DISABLED": "true"}, False),
            ("auto", {ENDPOINT: "http://127.0.0.1:9", "OTEL_TRACES_EXPORTER": "none"}, False),
            ("on", {}, True),
            ("on", {"OTEL_SDK_DISABLED": "true"}, False),
            ("off", {ENDPOINT: "http://127.0.0.1:9"}, False),
        ],
    )
    def test_the_setting_and_the_environment_decide(self, monkeypatch, setting, environment, there):
        for name, value in environment.items():
            monkeypatch.setenv(name, value)
        made = traces_of(setting)
        assert (made is not None) is there
        if made is not None:
            made.close()

    @pytest.mark.parametrize("missing", ["the package", "its parent"])
    def test_without_the_packages_on_is_an_error_and_auto_is_off(self, monkeypatch, missing):
        def find_spec(name):
            if missing == "its parent":
                raise ModuleNotFoundError(name)

        monkeypatch.setattr("importlib.util.find_spec", find_spec)
        monkeypatch.setenv(ENDPOINT, "http://127.0.0.1:9")
        assert traces_of("auto") is None
        with pytest.raises(TracesUnavailableError, match=r"gamut-boundary-service\[otel\]"):
            traces_of("on")

    def test_an_exporter_that_there_is_not_is_named(self, monkeypatch):
        monkeypatch.setenv("OTEL_TRACES_EXPORTER", "zipkin")
        with pytest.raises(TracesUnavailableError, match="zipkin"):
            traces_of("on")

    @pytest.mark.parametrize("stated", ["OTEL_SERVICE_NAME", "OTEL_RESOURCE_ATTRIBUTES"])
    def test_the_operator_names_the_service(self, monkeypatch, exporter, stated):
        name = "colour" if stated == "OTEL_SERVICE_NAME" else "service.name=colour"
        monkeypatch.setenv(stated, name)
        Traces(SimpleSpanProcessor(exporter)).write_build(
            "a", "succeeded", {}, started=1.0, finished=2.0, trace={}
        )
        (span,) = exporter.get_finished_spans()
        assert span.resource.attributes["service.name"] == "colour"


def test_a_collector_that_is_not_there_holds_up_nobody(monkeypatch, caplog):
    caplog.set_level(logging.CRITICAL)
    monkeypatch.setenv(ENDPOINT, "http://127.0.0.1:9")
    monkeypatch.setenv("OTEL_EXPORTER_OTLP_TIMEOUT", "1")
    made = traces_of("auto")
    answer(made, answering(200))
    made.close()


def test_a_build_in_a_worker_belongs_to_the_trace_of_its_client(observed_server, collector, sphere):
    trace_id = "1f" * 16
    posted = observed_server.client.post(
        "/v1/gamuts",
        json={"samples": sphere(seed=61)},
        headers={"traceparent": f"00-{trace_id}-{'2e' * 8}-01"},
    )
    assert posted.status_code == 201

    def arrived():
        spans = {span.name: span for span in collector.spans if span.trace_id.hex() == trace_id}
        return spans if {"POST /v1/gamuts", "build"} <= set(spans) else None

    spans = observed_server.wait_for(arrived)
    request, build = spans["POST /v1/gamuts"], spans["build"]
    assert request.parent_span_id.hex() == "2e" * 8
    assert build.parent_span_id == request.span_id
    for stage in STAGES:
        assert spans[f"build {stage}"].parent_span_id == build.span_id
    within = request.start_time_unix_nano, request.end_time_unix_nano
    assert within[0] <= build.start_time_unix_nano + 10**6
    # the log names the trace too
    about = [json.loads(line) for line in observed_server.log().splitlines() if trace_id in line]
    assert any(line["logger"] == "service.access" for line in about)


JOB = JobDocument("f" * 64, {}, trace={"traceparent": f"00-{'a' * 32}-{'b' * 16}-01"})
SECONDS = {"boundary": 0.5, "decimation": 0.25, "total": 1.0}


def ended(metrics, outcome):
    """Return the number of builds with an outcome; 0 before the first."""
    return metrics.registry.get_sample_value("gamut_builds_total", {"outcome": outcome}) or 0


def observed(outcome, seconds):
    """Return the spans after a build, which is counted without traces as well."""
    exporter = InMemorySpanExporter()
    metrics, alone = Metrics(), Metrics()
    BuildObserver(metrics.builds, Traces(SimpleSpanProcessor(exporter)))(outcome, seconds, JOB)
    BuildObserver(alone.builds, None)(outcome, seconds, JOB)
    assert ended(metrics, outcome) == ended(alone, outcome) == 1
    return {span.name: span for span in exporter.get_finished_spans()}


def test_a_build_ended_now_and_began_its_seconds_ago():
    began = time.time()
    spans = observed("succeeded", SECONDS)
    ended = time.time()
    assert set(spans) == {"build", "build boundary", "build decimation"}
    build = spans["build"]
    assert began <= build.end_time / 1e9 + 1e-6
    assert build.end_time / 1e9 <= ended + 1e-6
    assert round((build.end_time - build.start_time) / 1e9, 6) == 1.0
    assert build.context.trace_id == int("a" * 32, 16)
    assert build.attributes["gamut.id"] == JOB.id


def test_a_crash_that_tells_no_times_is_a_span_all_the_same():
    spans = observed("build-crashed", {})
    assert set(spans) == {"build"}
    assert spans["build"].attributes["gamut.build.outcome"] == "build-crashed"
    assert not spans["build"].status.is_ok


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
