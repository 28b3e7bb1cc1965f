"""Metrics of this process in Prometheus' formats."""

import asyncio
import contextlib
import shutil
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from fastapi import APIRouter, Request
from fastapi.responses import Response
from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily, Metric

from service.admission import Work
from service.building.engine import EngineFacts
from service.container import ServiceContainer, service_of
from service.library import ByteBoundedCache
from service.openapi.documentation import header, problems
from service.storage.gamut_store import GamutStore
from service.storage.local import LocalBlobs
from service.telemetry.metrics import exposition

__all__ = ["router", "state_families"]

router = APIRouter(tags=["state"])

_THREAD = ThreadPoolExecutor(1, thread_name_prefix="metrics")
"""A thread of its own: the shared threads may all wait for an unresponsive store, which is when
metrics are needed."""

_EXAMPLE = """\
# HELP gamut_builds_total Ended builds: succeeded, cancelled, crashed (one attempt), or a \
problem's code.
# TYPE gamut_builds_total counter
gamut_builds_total{outcome="succeeded"} 12.0
"""


def _content(example: str) -> dict[str, object]:
    return {"schema": {"type": "string"}, "examples": {"counter": {"value": example}}}


@router.get(
    "/metrics",
    operation_id="readMetrics",
    summary="Read the metrics of this process",
    description="Prometheus' text format, or OpenMetrics if `Accept` asks for it. "
    "Each replica reports its own metrics.",
    response_class=Response,
    responses={
        200: {
            "description": "The metrics.",
            "content": {
                "text/plain": _content(_EXAMPLE),
                "application/openmetrics-text": _content(
                    _EXAMPLE.replace("gamut_builds_total B", "gamut_builds B").replace(
                        "gamut_builds_total counter", "gamut_builds counter"
                    )
                    + "# EOF\n"
                ),
            },
            "headers": {"Cache-Control": header("The state changes.", "no-store")},
        },
        **problems(),
    },
)
async def read_metrics(request: Request) -> Response:
    """Read the metrics of this process."""
    accept = ",".join(request.headers.getlist("accept"))
    service = service_of(request)
    loop = asyncio.get_running_loop()
    body, media_type = await loop.run_in_executor(
        _THREAD, exposition, service.metrics.registry, accept
    )
    headers = {"Cache-Control": "no-store", "Vary": "Accept", "Content-Type": media_type}
    return Response(body, headers=headers)


def state_families(service: ServiceContainer) -> Iterator[Metric]:
    """Return the metrics that are read from the state of a service."""
    gauge, counter = GaugeMetricFamily, CounterMetricFamily
    yield from _engine_families(service.builds.facts())
    yield gauge(
        "gamut_large_bodies", "Bodies over 64 KiB that are not parsed.", service.bodies.large
    )
    yield gauge("gamut_event_streams", "Open event streams of jobs.", service.events.count)
    library = service.library
    yield from _cache_families(library.caches)
    admission = service.admission
    yield _labelled(
        gauge("gamut_work_running", "Requests that are computed, by class.", labels=("work",)),
        {work.value: admission.running[work] for work in Work},
    )
    yield _labelled(
        gauge("gamut_work_waiting", "Requests that wait, by class.", labels=("work",)),
        {work.value: count for work, count in admission.waiting.items()},
    )
    meaning = "Requests refused because their client has too many waiting, or for lack of memory."
    yield counter("gamut_work_refusals", meaning, admission.refused)
    yield gauge("gamut_memory_budget_bytes", "Largest memory beside the process.", admission.budget)
    yield _labelled(
        gauge(
            "gamut_memory_charged_bytes",
            "Memory of open gamuts, encoded meshes, answers that are not read, and work, by kind.",
            labels=("kind",),
        ),
        {**dict(sorted(admission.held.items())), "work": admission.granted.total()},
    )
    yield from _store_families(service.store)
    yield _labelled(
        gauge(
            "gamut_kernels_compiled",
            "Whether a group of kernels is compiled. Builds that need another group wait for it.",
            labels=("group",),
        ),
        {group: state == "compiled" for group, state in service.kernels.states.items()},
    )
    ready = service.readiness.last
    if ready is not None:
        meaning = "Whether the last answer of /readyz was ready."
        yield gauge("gamut_ready", meaning, int(ready.ready))
        yield _labelled(
            gauge("gamut_probe_ok", "Whether a probe of /readyz was ok.", labels=("probe",)),
            {probe.name: probe.status == "ok" for probe in ready.probes},
        )


def _engine_families(facts: EngineFacts) -> Iterator[Metric]:
    gauge = GaugeMetricFamily
    yield gauge("gamut_builds_queued", "Builds that wait for a worker.", facts.queued)
    if facts.oldest is not None:
        yield gauge(
            "gamut_build_oldest_seconds",
            "Time since the oldest waiting build was accepted; 0 if none waits.",
            facts.oldest,
        )
    yield gauge("gamut_builds_running", "Builds under way.", facts.running)
    yield gauge("gamut_build_queue_capacity", "Largest number of waiting builds.", facts.capacity)
    yield gauge("gamut_build_workers", "Configured workers.", facts.workers)
    yield gauge("gamut_build_workers_warm", "Workers ready to build.", facts.warm_workers)
    yield CounterMetricFamily(
        "gamut_build_worker_starts",
        "Worker processes that became ready, restarts included.",
        facts.worker_starts,
    )


def _cache_families(caches: dict[str, ByteBoundedCache[Any, Any]]) -> Iterator[Metric]:
    counter, gauge = CounterMetricFamily, GaugeMetricFamily
    for kind, name, attribute, meaning in (
        (counter, "gamut_cache_hits", "hits", "Values found in memory."),
        (counter, "gamut_cache_misses", "misses", "Values that had to be computed."),
        (counter, "gamut_cache_evictions", "evictions", "Values removed for lack of space."),
        (gauge, "gamut_cache_bytes", "nbytes", "Memory of the values."),
        (gauge, "gamut_cache_capacity_bytes", "capacity", "Largest memory of the values."),
    ):
        values = {name: getattr(cache, attribute) for name, cache in caches.items()}
        yield _labelled(kind(name, meaning, labels=("cache",)), values)


def _store_families(store: GamutStore) -> Iterator[Metric]:
    gauge, counter = GaugeMetricFamily, CounterMetricFamily
    yield counter("gamut_store_hits", "Requested gamuts that exist.", store.hits)
    yield counter("gamut_store_misses", "Requested gamuts that do not exist.", store.misses)
    yield counter("gamut_store_evictions", "Gamuts evicted for lack of space.", store.evictions)
    yield counter("gamut_store_corruptions", "Damaged files found.", store.corruptions)
    if store.nbytes is not None:
        yield gauge("gamut_store_bytes", "Bytes stored.", store.nbytes)
    if isinstance(store.blobs, LocalBlobs):
        with contextlib.suppress(OSError):
            free = shutil.disk_usage(store.blobs.directory).free
            yield gauge("gamut_store_free_bytes", "Free bytes on the disk of the store.", free)
    limit = getattr(store.blobs, "limit", 0)
    if limit:
        yield gauge("gamut_store_capacity_bytes", "Largest number of bytes stored.", limit)


def _labelled(
    family: GaugeMetricFamily | CounterMetricFamily, values: Mapping[str, float]
) -> Metric:
    """Add a sample for each value of the family's label, and return the family."""
    for label, value in values.items():
        family.add_metric((label,), value)
    return family
