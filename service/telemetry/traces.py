"""OpenTelemetry traces: one span per request, and one per build with its stages.

Traces need the extra ``otel``, and are off unless the setting or the ``OTEL_...`` variables enable
them; the SDK is not imported before. A job carries the trace context of its first request (W3C
Trace Context), so the trace continues in the process that builds. Spans contain ids, routes and
counts, but no queries and no header fields. See ``docs/decisions/traces.md``.
"""

from __future__ import annotations

import contextlib
import importlib.util
import os
from typing import TYPE_CHECKING, Any

from gamutcore.version import __version__
from service.http.request_context import current_trace
from service.telemetry.logs import without_secrets

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from opentelemetry.sdk.trace import SpanProcessor, TracerProvider
    from opentelemetry.trace import Span
    from starlette.types import Scope

    from service.http.request_context import RequestContext

__all__ = [
    "Traces",
    "TracesUnavailableError",
    "propagation_headers",
    "traces_enabled",
    "traces_of",
]

_ENDPOINTS = ("OTEL_EXPORTER_OTLP_TRACES_ENDPOINT", "OTEL_EXPORTER_OTLP_ENDPOINT")

_FLUSH_MILLISECONDS = 3000
"""Time limit of sending the last spans when the process stops."""


class TracesUnavailableError(RuntimeError):
    """Traces are requested but not available."""


def propagation_headers() -> dict[str, str]:
    """Return the header fields that let another process continue the current trace.

    The fields are ``traceparent`` and, if the client sent it, ``tracestate``. Without a trace there
    are none.
    """
    if current_trace() is None:
        return {}
    from opentelemetry.trace.propagation.tracecontext import (  # noqa: PLC0415 - only with traces
        TraceContextTextMapPropagator,
    )

    carrier: dict[str, str] = {}
    TraceContextTextMapPropagator().inject(carrier)
    return carrier


def traces_enabled(setting: str) -> bool:
    """Return whether the setting `Settings.traces` and the environment enable traces.

    Raise `TracesUnavailableError` if the setting is ``on`` without the packages, or if the
    environment selects an unknown exporter.
    """
    if setting == "off":
        return False
    environment = {name: value for name, value in os.environ.items() if value}
    exporter = environment.get("OTEL_TRACES_EXPORTER", "otlp").lower()
    disabled = environment.get("OTEL_SDK_DISABLED", "").lower() == "true" or exporter == "none"
    named = any(name in environment for name in (*_ENDPOINTS, "OTEL_TRACES_EXPORTER"))
    if setting == "auto" and (disabled or not named or not _installed()):
        return False
    if not _installed():
        message = (
            "GAMUT_TRACES is on, but OpenTelemetry is not installed. "
            "Install gamut-boundary-service[otel], or set GAMUT_TRACES=off."
        )
        raise TracesUnavailableError(message)
    if not disabled and exporter != "otlp":
        message = f"OTEL_TRACES_EXPORTER={exporter} is not supported. Use otlp or none."
        raise TracesUnavailableError(message)
    return not disabled


def traces_of(setting: str) -> Traces | None:
    """Return the traces if they are enabled (see `traces_enabled`); else None.

    They start a thread, so they must be made after the last fork.
    """
    if not traces_enabled(setting):
        return None
    from opentelemetry.exporter.otlp.proto.http.trace_exporter import (  # noqa: PLC0415
        OTLPSpanExporter,
    )
    from opentelemetry.sdk.trace.export import BatchSpanProcessor  # noqa: PLC0415

    return Traces(BatchSpanProcessor(OTLPSpanExporter()))


class Traces:
    """Makes the spans of one process; `processor` receives ended spans."""

    def __init__(self, processor: SpanProcessor) -> None:
        from opentelemetry.trace.propagation.tracecontext import (  # noqa: PLC0415
            TraceContextTextMapPropagator,
        )

        self._propagator = TraceContextTextMapPropagator()
        self._provider = _provider(processor)
        self._tracer = self._provider.get_tracer("gamut-boundary-service", __version__)

    @contextlib.contextmanager
    def request(self, scope: Scope, request: RequestContext) -> Iterator[Span]:
        """Open the span of a request, which continues its ``traceparent``.

        The request id is an attribute, to find the log lines. `set_outcome` adds name and outcome.
        """
        from opentelemetry.trace import SpanKind, use_span  # noqa: PLC0415

        carrier = {
            name.decode("latin-1"): value.decode("latin-1")
            for name, value in scope["headers"]
            if name in {b"traceparent", b"tracestate"}
        }
        span = self._tracer.start_span(
            scope["method"],
            context=self._propagator.extract(carrier),
            kind=SpanKind.SERVER,
            attributes={
                "http.request.method": scope["method"],
                "url.scheme": scope.get("scheme", "http"),
                "url.path": without_secrets(scope["path"]),
                "gamut.request_id": without_secrets(request.id),
            },
        )
        # The text of an exception may contain secrets, so only the log has it.
        under_way = use_span(
            span, end_on_exit=True, record_exception=False, set_status_on_exception=False
        )
        context = span.get_span_context()
        request.trace = f"{context.trace_id:032x}", f"{context.span_id:016x}"
        with under_way:
            yield span

    @staticmethod
    def set_outcome(span: Span, method: str, route: str, status: int) -> None:
        """Add the route and the status to a request's span."""
        from opentelemetry.trace import StatusCode  # noqa: PLC0415

        span.update_name(f"{method} {route}")
        span.set_attribute("http.route", route)
        span.set_attribute("http.response.status_code", status)
        if status >= 500:
            span.set_attribute("error.type", str(status))
            span.set_status(StatusCode.ERROR)

    def write_build(
        self,
        gamut_id: str,
        outcome: str,
        seconds: Mapping[str, float],
        *,
        started: float,
        finished: float,
        trace: Mapping[str, str],
    ) -> None:
        """Write the spans of an ended build: its own, and one per stage.

        The outcome is ``succeeded``, ``cancelled`` or the code of a problem. `started` and
        `finished` are seconds of the Unix epoch, and `trace` holds the `propagation_headers` of the
        first request.
        """
        from opentelemetry.trace import SpanKind, StatusCode, set_span_in_context  # noqa: PLC0415

        span = self._tracer.start_span(
            "build",
            context=self._propagator.extract(dict(trace)),
            kind=SpanKind.CONSUMER,
            attributes={"gamut.id": gamut_id, "gamut.build.outcome": outcome},
            start_time=_nanoseconds(started),
        )
        within = set_span_in_context(span)
        moment = started
        for stage, duration in seconds.items():
            part = self._tracer.start_span(
                f"build {stage}", context=within, start_time=_nanoseconds(moment)
            )
            moment += duration
            part.end(_nanoseconds(moment))
        if outcome not in {"succeeded", "cancelled"}:
            span.set_status(StatusCode.ERROR)
            span.set_attribute("error.type", outcome)
        span.end(_nanoseconds(max(finished, moment)))

    def close(self) -> None:
        """Send the remaining spans, within a few seconds."""
        self._provider.force_flush(_FLUSH_MILLISECONDS)
        self._provider.shutdown()


def _installed() -> bool:
    names = ("opentelemetry.sdk", "opentelemetry.exporter.otlp.proto.http")
    try:
        return all(importlib.util.find_spec(name) is not None for name in names)
    except ModuleNotFoundError:
        # A parent package is missing.
        return False


def _provider(processor: SpanProcessor) -> TracerProvider:
    from opentelemetry.sdk.resources import Resource  # noqa: PLC0415
    from opentelemetry.sdk.trace import TracerProvider  # noqa: PLC0415

    attributes: dict[str, Any] = {"service.version": __version__}
    named = os.environ.get("OTEL_RESOURCE_ATTRIBUTES", "")
    # These attributes override the environment.
    if not os.environ.get("OTEL_SERVICE_NAME") and "service.name=" not in named:
        attributes["service.name"] = "gamut-boundary-service"
    # A provider of our own: libraries would write to the global one.
    provider = TracerProvider(resource=Resource.create(attributes), shutdown_on_exit=False)
    provider.add_span_processor(processor)
    return provider


def _nanoseconds(seconds: float) -> int:
    return int(seconds * 1e9)
