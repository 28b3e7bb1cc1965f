"""Metrics in Prometheus' text formats, for ``/metrics`` and for workers.

Every process reports its own metrics: each replica at ``/metrics``, and a worker on another machine
by `serve_metrics`. Builds run in other processes and are counted by the process that started them.
Names follow Prometheus' conventions; ``docs/operations.md`` explains them. See
``docs/decisions/metrics.md``.
"""

from __future__ import annotations

import platform
from typing import TYPE_CHECKING

from prometheus_client import (
    CollectorRegistry,
    Counter,
    Gauge,
    Histogram,
    ProcessCollector,
    disable_created_metrics,
    start_http_server,
)
from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily
from prometheus_client.exposition import choose_encoder
from prometheus_client.registry import Collector

from gamutcore.version import ALGORITHM_VERSION, __version__
from service.telemetry.processes import descendants_usage

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping

    from prometheus_client.core import Metric

__all__ = [
    "TOTAL",
    "BuildMetrics",
    "Metrics",
    "QueryMetrics",
    "RequestMetrics",
    "StateCollector",
    "exposition",
    "serve_metrics",
]

TOTAL = "total"
"""Key of the seconds of a whole build, publication included."""

_RESPONSE_BOUNDS = (
    *(0.0005, 0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1),
    *(0.25, 0.5, 1, 2.5, 5, 10, 30),
)
"""Seconds. A cached mesh is in the first bucket, a request that waits for a build in the last."""

_BUILD_BOUNDS = (0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1, 2.5, 5, 10, 30, 60, 120, 300)
"""Seconds of a build or a stage, from reading a small file to the largest deadline."""

_METHODS = frozenset(
    {"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS", "TRACE", "CONNECT"}
)

disable_created_metrics()  # type: ignore[no-untyped-call] # no series of times of creation


class RequestMetrics:
    """Requests by method, route and status; seconds until the response starts, by route.

    A route is the template of the path, such as ``/v1/gamuts/{gamut_id}/mesh``, so clients cannot
    create new series.
    """

    def __init__(self, registry: CollectorRegistry) -> None:
        self._answers = Counter(
            "gamut_http_requests",
            "Answered requests by method, route template and status.",
            ("method", "route", "status"),
            registry=registry,
        )
        self._seconds = Histogram(
            "gamut_http_response_seconds",
            "Time from the arrival of a request to the start of its response.",
            ("route",),
            buckets=_RESPONSE_BOUNDS,
            registry=registry,
        )
        self.in_progress = Gauge(
            "gamut_http_requests_in_progress", "Requests under way.", registry=registry
        )
        self._sent_bytes = Counter(
            "gamut_http_sent_bytes", "Bytes of content in responses.", registry=registry
        )

    def count_answer(
        self, method: str, route: str, status: int, seconds: float, nbytes: int = 0
    ) -> None:
        """Count a request."""
        self._answers.labels(method if method in _METHODS else "other", route, status).inc()
        self._seconds.labels(route).observe(seconds)
        self._sent_bytes.inc(nbytes)


class BuildMetrics:
    """Builds of this process by outcome, and seconds of builds and of their stages."""

    def __init__(self, registry: CollectorRegistry) -> None:
        self._outcomes = Counter(
            "gamut_builds",
            "Ended builds: succeeded, cancelled, crashed (one attempt), or a problem's code.",
            ("outcome",),
            registry=registry,
        )
        self._seconds = Histogram(
            "gamut_build_seconds",
            "Time of whole builds.",
            buckets=_BUILD_BOUNDS,
            registry=registry,
        )
        self._stages = Histogram(
            "gamut_build_stage_seconds",
            "Time of the stages of builds.",
            ("stage",),
            buckets=_BUILD_BOUNDS,
            registry=registry,
        )

    def count_build(self, outcome: str, seconds: Mapping[str, float]) -> None:
        """Count an ended build.

        The outcome is ``succeeded``, ``cancelled``, ``crashed`` (one attempt) or the code of a
        problem. `seconds` are by stage, if known, and of the whole build as ``total``.
        """
        self._outcomes.labels(outcome).inc()
        for stage, duration in seconds.items():
            if stage == TOTAL:
                self._seconds.observe(duration)
            else:
                self._stages.labels(stage).observe(duration)


class QueryMetrics:
    """Answered rows and seconds of computation by operation.

    Large queries are answered piece by piece, and every piece counts.
    """

    def __init__(self, registry: CollectorRegistry) -> None:
        self._rows = Counter(
            "gamut_query_rows",
            "Answered rows of queries by operation.",
            ("operation",),
            registry=registry,
        )
        self._seconds = Histogram(
            "gamut_query_seconds",
            "Time to compute the rows of a query, or a piece of them, by operation.",
            ("operation",),
            buckets=_RESPONSE_BOUNDS,
            registry=registry,
        )

    def count(self, operation: str, rows: int, seconds: float) -> None:
        """Count answered rows and the time of their computation."""
        self._rows.labels(operation).inc(rows)
        self._seconds.labels(operation).observe(seconds)


class Metrics:
    """All metrics of a process that serves."""

    def __init__(self) -> None:
        self.registry = _process_registry()
        self.requests = RequestMetrics(self.registry)
        self.builds = BuildMetrics(self.registry)
        self.queries = QueryMetrics(self.registry)


class StateCollector(Collector):
    """Reads metrics from the state of the program whenever they are asked for."""

    def __init__(self, families: Callable[[], Iterable[Metric]]) -> None:
        self._families = families

    def collect(self) -> Iterable[Metric]:
        """Return the metrics."""
        return self._families()

    def describe(self) -> Iterable[Metric]:
        """Return nothing: otherwise the registry would collect all metrics to learn the names."""
        return ()


def exposition(registry: CollectorRegistry, accept: str) -> tuple[bytes, str]:
    """Return the metrics as text, and the text's media type.

    ``Accept`` selects OpenMetrics or Prometheus' own format. The function takes some milliseconds
    and may be called in any thread.
    """
    encoder, media_type = choose_encoder(accept)
    return encoder(registry), media_type


def serve_metrics(host: str, port: int) -> tuple[BuildMetrics, int, Callable[[], None]]:
    """Serve the metrics of a worker's process and builds in a thread.

    Port 0 takes a free one. Return the metrics of builds, the port, and a function that stops the
    server.
    """
    registry = _process_registry()
    metrics = BuildMetrics(registry)
    server, thread = start_http_server(port, host, registry)

    def stop() -> None:
        server.shutdown()
        server.server_close()
        thread.join()

    return metrics, server.server_port, stop


def _process_registry() -> CollectorRegistry:
    """Return a registry with the metrics that every process reports."""
    registry = CollectorRegistry()
    registry.register(StateCollector(_common_families))
    ProcessCollector(registry=registry)
    return registry


def _common_families() -> Iterator[Metric]:
    labels = ("version", "algorithm", "python")
    info = GaugeMetricFamily("gamut_build_info", "Version of the program.", labels=labels)
    info.add_metric((__version__, str(ALGORITHM_VERSION), platform.python_version()), 1)
    yield info
    usage = descendants_usage()
    if usage is not None:
        yield GaugeMetricFamily(
            "gamut_worker_processes", "Worker processes of this process.", usage.processes
        )
        yield GaugeMetricFamily(
            "gamut_worker_resident_memory_bytes",
            "Resident memory of the worker processes.",
            usage.resident_bytes,
        )
        yield CounterMetricFamily(
            "gamut_worker_cpu_seconds",
            "CPU time of these processes, ended ones included.",
            usage.cpu_seconds,
        )
