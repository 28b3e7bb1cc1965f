"""Traces: from the client's request to the stages of the build, whoever builds; off by default."""

import asyncio
import json
import logging
import re
import subprocess
import sys
import time

import pytest
from opentelemetry.sdk.trace.export import SimpleSpanProcessor
from opentelemetry.sdk.trace.export.in_memory_span_exporter import InMemorySpanExporter
from opentelemetry.trace import SpanKind, StatusCode

from gamutcore.building import STAGES
from service.telemetry import traces
from service.telemetry.logs import JsonLines
from service.telemetry.metrics import RequestFigures
from service.telemetry.request_observer import MatchedRoute, RequestObserver
from service.telemetry.traces import (
    Traces,
    TracesUnavailableError,
    current_trace,
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

    layer = RequestObserver(app, RequestFigures(), access_log=False, traces=made)
    asyncio.run(layer(scope, None, send))


def answering(status, seen=None):
    async def app(scope, _receive, send):
        scope["route"] = MatchedRoute("/v1/gamuts/{gamut_id}/mesh")
        if seen is not None:
            seen.append((current_trace(), propagation_headers()))
        await send({"type": "http.response.start", "status": status, "headers": []})
        await send({"type": "http.response.body", "body": b""})

    return app


class TestRequests:
    def test_a_request_is_a_span_of_its_client_s_trace(self, made, exporter):
        answer(made, answering(200), [(b"traceparent", PARENT.encode())])
        (span,) = exporter.get_finished_spans()
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

    def test_neither_queries_nor_header_fields_are_told(self, made, exporter):
        fields = [(b"authorization", b"Bearer hidden-value"), (b"x-api-key", b"hidden-value")]
        answer(made, answering(200), fields, b"token=hidden-value")
        (span,) = exporter.get_finished_spans()
        assert "hidden-value" not in span.to_json()

    def test_a_line_of_the_log_names_the_trace(self, made):
        lines = []

        async def app(_scope, _receive, _send):
            record = logging.LogRecord("a", logging.INFO, __file__, 1, "line", (), None)
            lines.append(json.loads(JsonLines().format(record)))

        answer(made, app, [(b"traceparent", PARENT.encode())])
        assert lines[0]["trace_id"] == f"{TRACE_ID:032x}"
        assert re.fullmatch(r"[0-9a-f]{16}", lines[0]["span_id"])


class TestBuilds:
    def test_a_trace_goes_through_the_job_to_another_process(self, made, exporter):
        seen = []
        answer(made, answering(202, seen), [(b"traceparent", PARENT.encode())])
        (_, carried) = seen[0]
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

    def test_without_the_packages_on_is_an_error_and_auto_is_off(self, monkeypatch):
        monkeypatch.setattr(traces, "_installed", lambda: False)
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


def test_spans_arrive_at_a_collector(monkeypatch, collector):
    monkeypatch.setenv(ENDPOINT, collector.url)
    made = traces_of("auto")
    made.write_build("5a" * 32, "succeeded", {}, started=1.0, finished=2.0, trace={})
    made.close()
    (span,) = (
        span
        for span in collector.spans
        if any(pair.value.string_value == "5a" * 32 for pair in span.attributes)
    )
    assert span.name == "build"
    assert collector.paths == {"/v1/traces"}


@pytest.mark.slow
def test_a_collector_that_is_not_there_holds_up_nobody(monkeypatch, caplog):
    caplog.set_level(logging.CRITICAL)
    monkeypatch.setenv(ENDPOINT, "http://127.0.0.1:9")
    monkeypatch.setenv("OTEL_EXPORTER_OTLP_TIMEOUT", "1")
    made = traces_of("auto")
    clock = time.monotonic()
    answer(made, answering(200))
    assert time.monotonic() - clock < 1
    made.close()
    assert time.monotonic() - clock < traces._FLUSH_MILLISECONDS / 1000 + 7


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
