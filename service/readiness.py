"""Readiness probes: the answer of ``/readyz``.

A probe checks one thing. ``ok``: no fault. ``degraded``: some requests fail or are slow, and
another replica would not be better. ``failed``: requests should go elsewhere. Probes that touch the
disk or the network run in threads, one thread per probe. Their results stay valid for a moment, so
frequent requests are cheap and a hanging disk occupies one thread only.
"""

from __future__ import annotations

import asyncio
import contextlib
import errno
import logging
import secrets
import shutil
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, NamedTuple

from service.storage.blobs import StoreFullError, StoreUnavailableError
from service.storage.local import LocalBlobs

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from service.building.builds import Builds
    from service.building.kernels import Kernels
    from service.storage.blobs import Blobs

__all__ = [
    "Finding",
    "Probe",
    "Readiness",
    "Report",
    "disk_probe",
    "service_readiness",
    "store_probe",
]

logger = logging.getLogger(__name__)

HOLDS_SECONDS = 2.0
"""Validity of a slow probe's result, shorter than the interval of load balancers."""

TIMEOUT_SECONDS = 5.0
"""Time limit of waiting for a slow probe."""

SHARED_TIMEOUT_SECONDS = 1.0
"""Time limit of waiting for a shared store. HAProxy gives a check 2 s, and the Helm chart 3 s."""

_GRACE_SECONDS = 30.0
"""How long a service stays ready without a warm worker: enough for a restart with retries. Builds
wait meanwhile, and everything else works."""

Status = Literal["ok", "degraded", "failed"]


class Finding(NamedTuple):
    """Result of a check."""

    status: Status
    detail: str


@dataclass(frozen=True)
class Probe:
    """A named check with its result and its duration in seconds.

    `detail` contains no path and no address.
    """

    name: str
    status: Status
    detail: str
    seconds: float = 0.0


@dataclass(frozen=True)
class Report:
    """Results of all probes."""

    probes: tuple[Probe, ...]

    @property
    def ready(self) -> bool:
        """Whether no probe failed."""
        return not any(probe.status == "failed" for probe in self.probes)

    @property
    def statuses(self) -> dict[str, Status]:
        """Statuses other than ok, by name."""
        return {probe.name: probe.status for probe in self.probes if probe.status != "ok"}

    @property
    def wrong(self) -> str:
        """Faults as one sentence for people; empty if there are none."""
        return "; ".join(
            f"{probe.name}: {probe.detail}" for probe in self.probes if probe.status != "ok"
        )


class _SlowProbe:
    """A check that may block: it runs in a thread, and its result is kept for a moment."""

    def __init__(self, name: str, look: Callable[[], Finding], *, shared: bool) -> None:
        self._name = name
        self._look = look
        self._shared = shared
        self._under_way: asyncio.Task[Probe] | None = None
        self._found: tuple[float, Probe] | None = None
        self._patience = self._timeout

    @property
    def _timeout(self) -> float:
        return SHARED_TIMEOUT_SECONDS if self._shared else TIMEOUT_SECONDS

    async def probe(self) -> Probe:
        """Return a recent or a new result."""
        if self._found is not None and time.monotonic() - self._found[0] < HOLDS_SECONDS:
            return self._found[1]
        if self._under_way is None:
            self._under_way = asyncio.create_task(self._run())
        try:
            return await asyncio.wait_for(asyncio.shield(self._under_way), self._patience)
        except TimeoutError:
            # The next caller does not wait again.
            self._patience = 0.0
            status: Status = "degraded" if self._shared else "failed"
            return Probe(self._name, status, f"no answer within {self._timeout:g} s")

    async def _run(self) -> Probe:
        clock = time.monotonic()
        try:
            status, detail = await asyncio.to_thread(self._look)
        except Exception:
            logger.exception("probe of %s failed", self._name)
            status, detail = "failed", "the check failed; see the log"
        finally:
            self._under_way, self._patience = None, self._timeout
        now = time.monotonic()
        probe = Probe(self._name, status, detail, now - clock)
        self._found = now, probe
        return probe


class Readiness:
    """The probes of a service; `last` is the previous report."""

    def __init__(self) -> None:
        self._quick: dict[str, Callable[[], Finding]] = {}
        self._slow: list[_SlowProbe] = []
        self.last: Report | None = None

    def add(self, name: str, look: Callable[[], Finding]) -> None:
        """Add a check that runs on the event loop at every report."""
        self._quick[name] = look

    def add_slow(self, name: str, look: Callable[[], Finding], *, shared: bool = False) -> None:
        """Add a check that may block and runs in a thread.

        `shared` tells that all replicas use the checked part. Its silence is then no reason to
        prefer another replica.
        """
        self._slow.append(_SlowProbe(name, look, shared=shared))

    async def report(self) -> Report:
        """Run all probes and return their results."""
        quick = [Probe(name, *look()) for name, look in self._quick.items()]
        slow = await asyncio.gather(*[probe.probe() for probe in self._slow])
        report = Report((*quick, *slow))
        before = self.last
        self.last = report
        if report.statuses != (before.statuses if before is not None else {}):
            if report.wrong:
                logger.warning("%s: %s", "degraded" if report.ready else "not ready", report.wrong)
            else:
                logger.info("all probes are ok again")
        return report


def service_readiness(
    builds: Builds,
    blobs: Blobs,
    kernels: Kernels,
    *,
    stopping: Callable[[], bool],
    needed_bytes: int,
) -> Readiness:
    """Return the probes of a service: kernels, workers, queue, builds, store and disk.

    `stopping` tells whether the service must stop, and `needed_bytes` is the free disk space that
    the largest input needs.
    """
    readiness = Readiness()
    readiness.add("kernels", lambda: _kernels(kernels))
    readiness.add("workers", _WorkersProbe(builds))
    readiness.add("queue", lambda: _queue(builds))
    accepted, refused = Finding("ok", "accepted"), Finding("failed", "the service is stopping")
    readiness.add("builds", lambda: refused if stopping() else accepted)
    readiness.add_slow("store", lambda: store_probe(blobs), shared=blobs.remote)
    if isinstance(blobs, LocalBlobs):
        readiness.add_slow("disk", lambda: disk_probe(blobs.directory, needed_bytes))
    return readiness


def store_probe(blobs: Blobs) -> Finding:
    """Check that a storage can be written and read.

    A bucket that does not answer makes the service degraded: every replica uses the same bucket,
    and each still serves what it has in memory.
    """
    content = secrets.token_bytes(32)
    try:
        same = _write_and_read(blobs, content)
    except StoreFullError:
        # Existing gamuts are still served.
        return Finding("degraded", "full")
    except StoreUnavailableError as error:
        return Finding("degraded" if blobs.remote else "failed", f"unavailable: {error}")
    except OSError as error:
        if error.errno in {errno.ENOSPC, errno.EDQUOT}:
            return Finding("degraded", "full")
        logger.warning("store cannot be written: %s", error)
        return Finding("failed", f"not writable: {error.strerror or type(error).__name__}")
    if not same:
        return Finding("failed", "read other content than was written")
    return Finding("ok", "written and read")


def disk_probe(directory: Path, needed: int) -> Finding:
    """Check that a directory's file system has at least `needed` bytes free."""
    try:
        free = shutil.disk_usage(directory).free
    except OSError as error:
        return Finding("failed", f"free space is unknown: {error.strerror or type(error).__name__}")
    if free < needed:
        room = f"{free / 1e6:,.0f} MB are free"
        return Finding("degraded", f"{room}; the largest input needs {needed / 1e6:,.0f} MB")
    return Finding("ok", f"{free / 1e9:,.1f} GB are free")


def _write_and_read(blobs: Blobs, content: bytes) -> bool:
    if not blobs.remote:
        # A scratch file instead of a blob, because the content need not be durable.
        path = blobs.scratch(".probe")
        try:
            path.write_bytes(content)
            return path.read_bytes() == content
        finally:
            with contextlib.suppress(OSError):
                path.unlink(missing_ok=True)
    key = f"probes/{secrets.token_hex(16)}"
    blobs.create(key, content)
    try:
        return blobs.read(key).data == content
    finally:
        blobs.delete(key)


def _kernels(kernels: Kernels) -> Finding:
    return Finding("ok" if kernels.loaded else "failed", kernels.detail)


def _queue(builds: Builds) -> Finding:
    facts = builds.facts()
    if facts.fault is not None:
        return Finding("degraded", facts.fault)
    detail = f"{facts.queued} of {facts.capacity} builds are waiting"
    return Finding("degraded" if facts.queued >= facts.capacity else "ok", detail)


class _WorkersProbe:
    """Checks the workers: strict at the start, tolerant of restarts later."""

    def __init__(self, builds: Builds) -> None:
        self._builds = builds
        self._started = False
        self._none_since: float | None = None

    def __call__(self) -> Finding:
        facts = self._builds.facts()
        detail = f"{facts.warm_workers} of {facts.workers} workers are warm"
        if facts.warm_workers >= facts.workers:
            self._started, self._none_since = True, None
            return Finding("ok", detail)
        if not self._started:
            return Finding("failed", detail)
        if facts.warm_workers:
            self._none_since = None
            return Finding("degraded", detail)
        if self._none_since is None:
            self._none_since = time.monotonic()
        late = time.monotonic() - self._none_since > _GRACE_SECONDS
        return Finding("failed" if late else "degraded", detail)
