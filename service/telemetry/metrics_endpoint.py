"""Metrics in Prometheus' text formats, for ``/metrics`` and for workers.

Every process reports its own metrics: each replica at ``/metrics``, and a worker on another machine
by `serve_build_figures`. Names follow Prometheus' conventions; ``docs/operations.md`` explains
them. The client library is imported at the first use.
"""

from __future__ import annotations

import os
import platform
from typing import TYPE_CHECKING, Any

from gamutcore.version import ALGORITHM_VERSION, __version__
from service.telemetry.processes import descendants_usage

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from prometheus_client.core import Metric

    from service.telemetry.metrics import BuildFigures, Distribution, QueryFigures, RequestFigures

__all__ = [
    "build_families",
    "counter",
    "exposition",
    "gauge",
    "metric_family",
    "query_families",
    "request_families",
    "serve_build_figures",
]


def exposition(families: Callable[[], Iterable[Metric]], accept: str) -> tuple[bytes, str]:
    """Return metric families and those of the process as text, and the text's media type.

    ``Accept`` selects OpenMetrics or Prometheus' own format. The function takes some milliseconds
    and may be called in any thread.
    """
    from prometheus_client.exposition import choose_encoder  # noqa: PLC0415

    encoder, media_type = choose_encoder(accept)
    registry: Any = _registry(families)
    return encoder(registry), media_type


def serve_build_figures(
    figures: BuildFigures,
    host: str,
    port: int,
    process: str = "self",
    descriptors: int | None = None,
) -> tuple[int, Callable[[], None]]:
    """Serve a worker's build metrics in a thread; return the port and a function that stops it.

    The resource use of `process` and its descendants is reported. `descriptors` is the open folder
    of that process's descriptors in ``/proc``, which only that process may open
    (`service.building.confinement.hide_memory`).
    """
    from prometheus_client import start_http_server  # noqa: PLC0415

    registry: Any = _registry(lambda: build_families(figures), process, descriptors)
    server, thread = start_http_server(port, host, registry)

    def stop() -> None:
        server.shutdown()
        server.server_close()
        thread.join()

    return server.server_port, stop


def _registry(
    families: Callable[[], Iterable[Metric]], process: str = "self", descriptors: int | None = None
) -> object:
    """Return a registry for the library's encoders, process metrics included."""
    from prometheus_client import CollectorRegistry, ProcessCollector  # noqa: PLC0415
    from prometheus_client.registry import Collector  # noqa: PLC0415

    class Figures(Collector):
        def collect(self) -> Iterator[Metric]:
            yield from _common_families(process)
            yield from families()

        def describe(self) -> Iterable[Metric]:
            # Otherwise the library would collect all metrics to learn the names.
            return []

    class Process(ProcessCollector):
        def collect(self) -> Iterator[Metric]:
            found = list(super().collect())
            yield from found
            if descriptors is not None and all(each.name != "process_open_fds" for each in found):
                number = len(os.listdir(descriptors))  # noqa: PTH208 - a descriptor is no path
                yield gauge("process_open_fds", "Number of open file descriptors.", number)

    collectors = CollectorRegistry()
    collectors.register(Figures())
    Process(pid=lambda: process, registry=collectors)
    return collectors


def _common_families(process: str) -> Iterator[Metric]:
    labels = {
        "version": __version__,
        "algorithm": str(ALGORITHM_VERSION),
        "python": platform.python_version(),
    }
    yield metric_family("gauge", "gamut_build_info", "Version of the program.", [(labels, 1)])
    usage = descendants_usage(process)
    if usage is not None:
        yield gauge(
            "gamut_worker_processes",
            "Worker processes of this process.",
            usage.processes,
        )
        yield gauge(
            "gamut_worker_resident_memory_bytes",
            "Resident memory of the worker processes.",
            usage.resident_bytes,
        )
        yield counter(
            "gamut_worker_cpu_seconds",
            "CPU time of these processes, ended ones included.",
            usage.cpu_seconds,
        )


def request_families(figures: RequestFigures) -> Iterator[Metric]:
    """Return the metrics of requests."""
    yield metric_family(
        "counter",
        "gamut_http_requests",
        "Answered requests by method, route template and status.",
        [
            ({"method": method, "route": route, "status": str(status)}, count)
            for (method, route, status), count in list(figures.counts.items())
        ],
    )
    yield metric_family(
        "counter",
        "gamut_http_refusals",
        "Answers of the server without the app, by code of the problem.",
        [({"problem": code}, count) for code, count in list(figures.refusals.items())],
    )
    yield _distributions(
        "gamut_http_response_seconds",
        "Time from the arrival of a request to the start of its response.",
        "route",
        figures.seconds,
    )
    yield gauge("gamut_http_requests_in_progress", "Requests under way.", figures.in_progress)
    yield counter("gamut_http_sent_bytes", "Bytes of content in responses.", figures.sent_bytes)


def build_families(figures: BuildFigures) -> Iterator[Metric]:
    """Return the metrics of builds."""
    yield metric_family(
        "counter",
        "gamut_builds",
        "Ended builds: succeeded, cancelled, crashed (one attempt), or a problem's code.",
        [({"outcome": outcome}, count) for outcome, count in list(figures.outcomes.items())],
    )
    yield _distributions(
        "gamut_build_seconds", "Time of whole builds.", None, {"": figures.seconds}
    )
    yield _distributions(
        "gamut_build_stage_seconds", "Time of the stages of builds.", "stage", figures.stages
    )


def query_families(figures: QueryFigures, rows_under_way: int) -> Iterator[Metric]:
    """Return the metrics of queries."""
    yield metric_family(
        "counter",
        "gamut_query_rows",
        "Answered rows of queries by operation.",
        [({"operation": name}, rows) for name, rows in list(figures.rows.items())],
    )
    yield _distributions(
        "gamut_query_seconds",
        "Time to compute the rows of a query, or a piece of them, by operation.",
        "operation",
        figures.seconds,
    )
    yield gauge("gamut_query_rows_in_progress", "Rows of queries under way.", rows_under_way)


def _bound(value: float) -> str:
    # The canonical form of OpenMetrics: always a decimal point, and a sign for infinity.
    return "+Inf" if value == float("inf") else str(float(value))


def gauge(name: str, meaning: str, value: float) -> Metric:
    """Return a gauge without labels."""
    return metric_family("gauge", name, meaning, [({}, value)])


def counter(name: str, meaning: str, value: float) -> Metric:
    """Return a counter without labels."""
    return metric_family("counter", name, meaning, [({}, value)])


def metric_family(
    kind: str, name: str, meaning: str, samples: Iterable[tuple[dict[str, str], float]]
) -> Metric:
    """Return a metric family with samples; `kind` is ``gauge`` or ``counter``."""
    from prometheus_client.core import Metric  # noqa: PLC0415

    family = Metric(name, meaning, kind)
    suffix = "_total" if kind == "counter" else ""
    for labels, value in samples:
        family.add_sample(name + suffix, labels, value)
    return family


def _distributions(
    name: str, meaning: str, label: str | None, distributions: dict[str, Distribution]
) -> Metric:
    from prometheus_client.core import HistogramMetricFamily  # noqa: PLC0415

    family = HistogramMetricFamily(name, meaning, labels=[] if label is None else [label])
    for value, distribution in list(distributions.items()):
        buckets = [(_bound(bound), count) for bound, count in distribution.cumulative()]
        family.add_metric([] if label is None else [value], buckets, distribution.sum)
    return family
