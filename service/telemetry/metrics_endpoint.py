"""The figures of a process in the formats that Prometheus reads: ``/metrics``.

Every process tells of itself: each replica of the service is asked by itself, and so is a worker
on another machine, by `serve_build_figures`. Names follow Prometheus' conventions; what they mean
is in ``docs/operations.md``. The library that writes the formats is loaded when it is needed first.
"""

from __future__ import annotations

import platform
from typing import TYPE_CHECKING, Any

from gamutcore.version import ALGORITHM_VERSION, __version__
from service.telemetry.processes import descendants_usage

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from prometheus_client.core import Metric

    from service.building.engine import EngineFacts
    from service.caching.byte_bounded_cache import ByteBoundedCache
    from service.container import Service
    from service.storage.gamuts import GamutStore
    from service.telemetry.metrics import BuildFigures, Distribution, RequestFigures

__all__ = ["exposition", "serve_build_figures"]


def exposition(service: Service, accept: str) -> tuple[bytes, str]:
    """Return the figures of a service, and the media type that they are written in.

    Takes some milliseconds, and may be called in any thread.

    Parameters
    ----------
    service : Service
        Whose figures.
    accept : str
        The value of ``Accept``: OpenMetrics for who asks for it, else Prometheus' own format.
    """
    from prometheus_client.exposition import choose_encoder  # noqa: PLC0415

    encoder, media_type = choose_encoder(accept)
    registry: Any = _registry(lambda: _service_families(service))
    return encoder(registry), media_type


def serve_build_figures(
    figures: BuildFigures, host: str, port: int, process: str = "self"
) -> tuple[int, Callable[[], None]]:
    """Serve the figures of builds that no service has had done, in a thread.

    Parameters
    ----------
    figures : BuildFigures
        Counts the builds.
    host : str
        Address to listen on.
    port : int
        Port to listen on; 0 takes a free one.
    process : str
        Id of the process that is told of beside them, with those that it has started.

    Returns
    -------
    int
        The port.
    callable
        Ends it.

    Raises
    ------
    OSError
        The port is not free.
    """
    from prometheus_client import start_http_server  # noqa: PLC0415

    registry: Any = _registry(lambda: _build_families(figures), process)
    server, thread = start_http_server(port, host, registry)

    def stop() -> None:
        server.shutdown()
        server.server_close()
        thread.join()

    return server.server_port, stop


def _registry(families: Callable[[], Iterable[Metric]], process: str = "self") -> object:
    """Return what the library's encoders ask for figures, those of the process included."""
    from prometheus_client import CollectorRegistry, ProcessCollector  # noqa: PLC0415
    from prometheus_client.registry import Collector  # noqa: PLC0415

    class Figures(Collector):
        def collect(self) -> Iterator[Metric]:
            yield from _common_families(process)
            yield from families()

        def describe(self) -> Iterable[Metric]:
            # Without it, the library would collect once more, only to know the names.
            return []

    told = CollectorRegistry()
    told.register(Figures())
    ProcessCollector(pid=lambda: process, registry=told)
    return told


def _common_families(process: str) -> Iterator[Metric]:
    labels = {
        "version": __version__,
        "algorithm": str(ALGORITHM_VERSION),
        "python": platform.python_version(),
    }
    yield _labelled("gauge", "gamut_build_info", "Which program this is.", [(labels, 1)])
    usage = descendants_usage(process)
    if usage is not None:
        yield _gauge(
            "gamut_worker_processes",
            "Processes that this one has started.",
            usage.processes,
        )
        yield _gauge(
            "gamut_worker_resident_memory_bytes", "Memory that they use.", usage.resident_bytes
        )
        yield _counter(
            "gamut_worker_cpu_seconds", "CPU time of these processes.", usage.cpu_seconds
        )


def _service_families(service: Service) -> Iterator[Metric]:
    yield from _request_families(service.metrics.requests)
    yield from _build_families(service.metrics.builds)
    yield from _engine_families(service.builds.facts())
    yield _gauge("gamut_event_streams", "Clients that follow a job.", service.events.count)
    choices = service.meshes.choices
    yield _gauge(
        "gamut_level_searches",
        "Levels that are searched for a limit, but one all waiting.",
        choices.searches,
    )
    yield from _cache_families(
        {"gamuts": service.library.cache, "meshes": service.meshes.cache, **choices.caches}
    )
    yield from _store_families(service.store)
    ready = service.readiness.last
    if ready is not None:
        yield _gauge("gamut_ready", "Whether the last answer of /readyz was yes.", int(ready.ready))
        yield _labelled(
            "gauge",
            "gamut_probe_ok",
            "Whether a probe of /readyz found nothing wrong.",
            [({"probe": probe.name}, int(probe.status == "ok")) for probe in ready.probes],
        )


def _request_families(figures: RequestFigures) -> Iterator[Metric]:
    yield _labelled(
        "counter",
        "gamut_http_requests",
        "Requests answered, by the template of their route.",
        [
            ({"method": method, "route": route, "status": str(status)}, count)
            for (method, route, status), count in list(figures.counts.items())
        ],
    )
    yield _labelled(
        "counter",
        "gamut_http_refusals",
        "Answers of the server to what never became a request, or not a whole one.",
        [({"problem": code}, count) for code, count in list(figures.refusals.items())],
    )
    yield _distributions(
        "gamut_http_response_seconds",
        "From the arrival of a request to the beginning of its response.",
        "route",
        figures.seconds,
    )
    yield _gauge("gamut_http_requests_in_progress", "Requests under way.", figures.in_progress)
    yield _counter("gamut_http_sent_bytes", "Bytes of content in responses.", figures.sent_bytes)


def _build_families(figures: BuildFigures) -> Iterator[Metric]:
    yield _labelled(
        "counter",
        "gamut_builds",
        "Builds that ended: succeeded, cancelled, crashed (an attempt), or a problem's code.",
        [({"outcome": outcome}, count) for outcome, count in list(figures.outcomes.items())],
    )
    yield _distributions("gamut_build_seconds", "Of whole builds.", None, {"": figures.seconds})
    yield _distributions(
        "gamut_build_stage_seconds", "Of the stages of builds.", "stage", figures.stages
    )


def _engine_families(facts: EngineFacts) -> Iterator[Metric]:
    yield _gauge("gamut_builds_queued", "Builds that wait for a worker.", facts.queued)
    yield _gauge("gamut_builds_running", "Builds that a worker is busy with.", facts.running)
    yield _gauge("gamut_build_queue_capacity", "Builds that may wait.", facts.capacity)
    yield _gauge("gamut_build_workers", "Workers that there should be.", facts.workers)
    yield _gauge("gamut_build_workers_warm", "Workers ready to build.", facts.warm_workers)
    yield _counter(
        "gamut_build_worker_starts",
        "Worker processes that became ready; more than there are workers were restarts.",
        facts.worker_starts,
    )


def _cache_families(caches: dict[str, ByteBoundedCache[Any, Any]]) -> Iterator[Metric]:
    for kind, name, attribute, meaning in (
        ("counter", "gamut_cache_hits", "hits", "Values that were found in memory."),
        ("counter", "gamut_cache_misses", "misses", "Values that had to be made."),
        ("counter", "gamut_cache_evictions", "evictions", "Values that had to go for others."),
        ("gauge", "gamut_cache_bytes", "nbytes", "Memory that values take."),
        ("gauge", "gamut_cache_capacity_bytes", "capacity", "Memory that values may take."),
    ):
        samples = [({"cache": cache}, getattr(caches[cache], attribute)) for cache in caches]
        yield _labelled(kind, name, meaning, samples)


def _store_families(store: GamutStore) -> Iterator[Metric]:
    yield _counter("gamut_store_hits", "Gamuts that were asked for and were there.", store.hits)
    yield _counter("gamut_store_misses", "Gamuts that were asked for and were not.", store.misses)
    yield _counter("gamut_store_evictions", "Gamuts that went for others.", store.evictions)
    yield _counter("gamut_store_corruptions", "Damaged files that were found.", store.corruptions)
    if store.nbytes is not None:
        yield _gauge("gamut_store_bytes", "Bytes of all that is stored.", store.nbytes)
    limit = getattr(store.blobs, "limit", 0)
    if limit:
        yield _gauge("gamut_store_capacity_bytes", "Bytes that may be stored.", limit)


def _bound(value: float) -> str:
    # OpenMetrics has a canonical form: a point in all, and infinity with its sign.
    return "+Inf" if value == float("inf") else str(float(value))


def _gauge(name: str, meaning: str, value: float) -> Metric:
    return _labelled("gauge", name, meaning, [({}, value)])


def _counter(name: str, meaning: str, value: float) -> Metric:
    return _labelled("counter", name, meaning, [({}, value)])


def _labelled(
    kind: str, name: str, meaning: str, samples: Iterable[tuple[dict[str, str], float]]
) -> Metric:
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
