"""OpenTelemetry traces: a span for every request, and one for every build with its stages.

They are an extra (``otel``), off unless the setting or the ``OTEL_...`` variables ask for them, and
nothing of the SDK is loaded before. A job carries the context of the request that began it as
`propagation_headers` (W3C Trace Context), so a trace goes on in whatever process builds, on either
side of a queue. Spans carry ids, routes and counts, and neither queries nor header fields.
See ``docs/decisions/traces.md``.
"""

from __future__ import annotations

import contextlib
import importlib.util
import os
from contextvars import ContextVar
from typing import TYPE_CHECKING, Any

from gamutcore.version import __version__

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from opentelemetry.sdk.trace import SpanProcessor, TracerProvider
    from opentelemetry.trace import Span
    from starlette.types import Scope

__all__ = [
    "Traces",
    "TracesUnavailableError",
    "current_trace",
    "propagation_headers",
    "traces_of",
    "traces_wanted",
]

_ENDPOINTS = ("OTEL_EXPORTER_OTLP_TRACES_ENDPOINT", "OTEL_EXPORTER_OTLP_ENDPOINT")

_FLUSH_MILLISECONDS = 3000
"""How long a stopping process tries to send the last spans."""

_current: ContextVar[tuple[str, str] | None] = ContextVar("trace", default=None)


class TracesUnavailableError(RuntimeError):
    """Traces are asked for, and cannot be had."""


def current_trace() -> tuple[str, str] | None:
    """Return the ids of the trace and the span under way, hexadecimal; None if there is none."""
    return _current.get()


def propagation_headers() -> dict[str, str]:
    """Return what another process needs to go on with the trace under way; empty if there is none.

    Returns
    -------
    dict of str
        The fields of W3C Trace Context, ``traceparent`` and, where the client sent one,
        ``tracestate``.
    """
    if _current.get() is None:
        return {}
    from opentelemetry.trace.propagation.tracecontext import (  # noqa: PLC0415 - only with traces
        TraceContextTextMapPropagator,
    )

    carrier: dict[str, str] = {}
    TraceContextTextMapPropagator().inject(carrier)
    return carrier


def traces_wanted(setting: str) -> bool:
    """Return whether the setting and the environment ask for traces that can be had.

    Parameters
    ----------
    setting : str
        `Settings.traces`.

    Raises
    ------
    TracesUnavailableError
        The setting is ``on``, and the packages are not there; or the environment asks for an
        exporter that there is not.
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
            "GAMUT_TRACES is on, and OpenTelemetry is not installed: "
            "install the extra, gamut-boundary-service[otel], or set GAMUT_TRACES=off"
        )
        raise TracesUnavailableError(message)
    if not disabled and exporter != "otlp":
        message = f"OTEL_TRACES_EXPORTER={exporter}: there are only otlp and none"
        raise TracesUnavailableError(message)
    return not disabled


def traces_of(setting: str) -> Traces | None:
    """Return the traces that are wanted (see `traces_wanted`); None for none.

    They have a thread, so they are made where no process is forked any more.
    """
    if not traces_wanted(setting):
        return None
    from opentelemetry.exporter.otlp.proto.http.trace_exporter import (  # noqa: PLC0415
        OTLPSpanExporter,
    )
    from opentelemetry.sdk.trace.export import BatchSpanProcessor  # noqa: PLC0415

    return Traces(BatchSpanProcessor(OTLPSpanExporter()))


class Traces:
    """Makes the spans of one process.

    Parameters
    ----------
    processor : SpanProcessor
        Where ended spans go.
    """

    def __init__(self, processor: SpanProcessor) -> None:
        from opentelemetry.trace.propagation.tracecontext import (  # noqa: PLC0415
            TraceContextTextMapPropagator,
        )

        self._propagator = TraceContextTextMapPropagator()
        self._provider = _provider(processor)
        self._tracer = self._provider.get_tracer("gamut-boundary-service", __version__)

    @contextlib.contextmanager
    def request(self, scope: Scope, request_id: str) -> Iterator[Span]:
        """Have a request's span under way; its name and outcome are added by `answered`.

        Parameters
        ----------
        scope : ASGI scope
            Of the request, whose ``traceparent`` the span continues.
        request_id : str
            Kept as an attribute, so that lines of the log are found.
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
                "url.path": scope["path"],
                "gamut.request_id": request_id,
            },
        )
        # What an exception says may hold anything, so it is left to the log.
        under_way = use_span(
            span, end_on_exit=True, record_exception=False, set_status_on_exception=False
        )
        with under_way, _as_current(span):
            yield span

    @staticmethod
    def answered(span: Span, method: str, route: str, status: int) -> None:
        """Say of a request's span what it was and how it ended."""
        from opentelemetry.trace import StatusCode  # noqa: PLC0415

        span.update_name(f"{method} {route}")
        span.set_attribute("http.route", route)
        span.set_attribute("http.response.status_code", status)
        if status >= 500:
            span.set_attribute("error.type", str(status))
            span.set_status(StatusCode.ERROR)

    def build_ended(
        self,
        gamut_id: str,
        outcome: str,
        seconds: Mapping[str, float],
        *,
        started: float,
        finished: float,
        trace: Mapping[str, str],
    ) -> None:
        """Write the spans of a build that has ended: its own, and one for each stage within it.

        Parameters
        ----------
        gamut_id : str
            What was built.
        outcome : str
            ``succeeded``, ``cancelled`` or the code of a problem.
        seconds : mapping
            Seconds by stage, in the order of the stages.
        started, finished : float
            Seconds since the epoch: when a worker was given the build, and when it had ended.
        trace : mapping
            The `propagation_headers` of the request that began it; may be empty.
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
        """Send what is left, within a few seconds."""
        self._provider.force_flush(_FLUSH_MILLISECONDS)
        self._provider.shutdown()


def _installed() -> bool:
    names = ("opentelemetry.sdk", "opentelemetry.exporter.otlp.proto.http")
    try:
        return all(importlib.util.find_spec(name) is not None for name in names)
    except ModuleNotFoundError:
        # raised where a parent of the name is not there
        return False


def _provider(processor: SpanProcessor) -> TracerProvider:
    from opentelemetry.sdk.resources import Resource  # noqa: PLC0415
    from opentelemetry.sdk.trace import TracerProvider  # noqa: PLC0415

    attributes: dict[str, Any] = {"service.version": __version__}
    named = os.environ.get("OTEL_RESOURCE_ATTRIBUTES", "")
    # What is given here goes before what the environment says.
    if not os.environ.get("OTEL_SERVICE_NAME") and "service.name=" not in named:
        attributes["service.name"] = "gamut-boundary-service"
    # One of our own, not the process's: FastAPI and other libraries would write to that as well.
    provider = TracerProvider(resource=Resource.create(attributes), shutdown_on_exit=False)
    provider.add_span_processor(processor)
    return provider


@contextlib.contextmanager
def _as_current(span: Span) -> Iterator[None]:
    context = span.get_span_context()
    token = _current.set((f"{context.trace_id:032x}", f"{context.span_id:016x}"))
    try:
        yield
    finally:
        _current.reset(token)


def _nanoseconds(seconds: float) -> int:
    return int(seconds * 1e9)
