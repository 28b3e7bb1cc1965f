"""Whether the service is ready, and if not, what is wrong: what ``/readyz`` answers.

A probe looks at one thing and finds it ok, degraded (some requests will fail or be slow, and
another replica would be no better off) or failed (requests had better go elsewhere). Probes that
touch the disk or the network run in threads, one at a time each, and what they found holds for a
moment, so that asking often costs nothing. A disk that hangs makes one answer late, and occupies
one thread, however often it is asked for.
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
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from service.storage.blobs import StoreFullError, StoreUnavailableError
from service.storage.local import LocalBlobs

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from service.container import Service
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
"""How long what a slow probe found holds: shorter than the interval at which balancers ask."""

TIMEOUT_SECONDS = 5.0
"""How long an answer waits for a slow probe."""

_GRACE_SECONDS = 30.0
"""How long a service that was ready stays so without a warm worker: enough to start one anew, with
the first repetitions. Meanwhile builds wait, and everything else goes on."""

Status = Literal["ok", "degraded", "failed"]


class Finding(NamedTuple):
    """What a look at one thing found."""

    status: Status
    detail: str


@dataclass(frozen=True)
class Probe:
    """One thing that is looked at, and what was found.

    Attributes
    ----------
    name : str
        What is looked at.
    status, detail : str
        What was found; the detail is for people, and names no path and no address.
    seconds : float
        How long it took.
    """

    name: str
    status: Status
    detail: str
    seconds: float = 0.0

    def document(self) -> dict[str, Any]:
        """Return the JSON of the probe, without its name."""
        return {
            "status": self.status,
            "detail": self.detail,
            "milliseconds": round(1000 * self.seconds, 3),
        }


@dataclass(frozen=True)
class Report:
    """What all probes found."""

    probes: tuple[Probe, ...]

    @property
    def ready(self) -> bool:
        """Whether requests are welcome."""
        return not any(probe.status == "failed" for probe in self.probes)

    @property
    def statuses(self) -> dict[str, Status]:
        """What is not ok, by its name."""
        return {probe.name: probe.status for probe in self.probes if probe.status != "ok"}

    @property
    def wrong(self) -> str:
        """What is wrong, in a sentence for people; empty if nothing is."""
        return "; ".join(
            f"{probe.name}: {probe.detail}" for probe in self.probes if probe.status != "ok"
        )


class _SlowProbe:
    """A look that may take long: done in a thread, and remembered for a moment."""

    def __init__(self, name: str, look: Callable[[], Finding]) -> None:
        self._name = name
        self._look = look
        self._under_way: asyncio.Task[Probe] | None = None
        self._found: tuple[float, Probe] | None = None
        self._patience = TIMEOUT_SECONDS

    async def probe(self) -> Probe:
        """Return what was found a moment ago, or is found now."""
        if self._found is not None and time.monotonic() - self._found[0] < HOLDS_SECONDS:
            return self._found[1]
        if self._under_way is None:
            self._under_way = asyncio.create_task(self._looked())
        try:
            return await asyncio.wait_for(asyncio.shield(self._under_way), self._patience)
        except TimeoutError:
            # Whoever asks next need not wait as well.
            self._patience = 0.0
            return Probe(self._name, "failed", f"no answer within {TIMEOUT_SECONDS:g} s")

    async def _looked(self) -> Probe:
        clock = time.monotonic()
        try:
            status, detail = await asyncio.to_thread(self._look)
        except Exception:
            logger.exception("the probe of %s failed", self._name)
            status, detail = "failed", "it cannot be looked at; the log says why"
        finally:
            self._under_way, self._patience = None, TIMEOUT_SECONDS
        now = time.monotonic()
        probe = Probe(self._name, status, detail, now - clock)
        self._found = now, probe
        return probe


class Readiness:
    """The probes of a service.

    Attributes
    ----------
    last : Report or None
        What was answered last.
    """

    def __init__(self) -> None:
        self._quick: dict[str, Callable[[], Finding]] = {}
        self._slow: list[_SlowProbe] = []
        self.last: Report | None = None

    def add(self, name: str, look: Callable[[], Finding]) -> None:
        """Add a look that takes no time, and is done on the event loop each time."""
        self._quick[name] = look

    def add_slow(self, name: str, look: Callable[[], Finding]) -> None:
        """Add a look that may block, and is done in a thread."""
        self._slow.append(_SlowProbe(name, look))

    async def report(self) -> Report:
        """Return what all probes find."""
        quick = [Probe(name, *look()) for name, look in self._quick.items()]
        slow = await asyncio.gather(*[probe.probe() for probe in self._slow])
        report = Report((*quick, *slow))
        before = self.last
        self.last = report
        if report.statuses != (before.statuses if before is not None else {}):
            if report.wrong:
                logger.warning("%s: %s", "degraded" if report.ready else "not ready", report.wrong)
            else:
                logger.info("nothing is wrong any more")
        return report


def service_readiness(service: Service) -> Readiness:
    """Return the probes of a service: kernels, workers, queue, store and disk space."""
    readiness = Readiness()
    readiness.add("kernels", lambda: _kernels(warm=service.warm))
    readiness.add("workers", _WorkersProbe(service))
    readiness.add("queue", lambda: _queue(service))
    readiness.add("builds", lambda: _builds(draining=service.builds.draining))
    blobs, settings = service.store.blobs, service.settings
    readiness.add_slow("store", lambda: store_probe(blobs))
    if isinstance(blobs, LocalBlobs):
        needed = settings.store_reserve_bytes + settings.max_body_bytes
        readiness.add_slow("disk", lambda: disk_probe(blobs.directory, needed))
    return readiness


def store_probe(blobs: Blobs) -> Finding:
    """Return whether something can be written into a storage and read from it."""
    content = secrets.token_bytes(32)
    try:
        same = _written_and_read(blobs, content)
    except StoreFullError:
        # What is stored is still served.
        return Finding("degraded", "it is full")
    except StoreUnavailableError as error:
        return Finding("failed", f"it cannot be used: {error}")
    except OSError as error:
        if error.errno in {errno.ENOSPC, errno.EDQUOT}:
            return Finding("degraded", "it is full")
        logger.warning("the store cannot be written: %s", error)
        return Finding("failed", f"it cannot be written: {error.strerror or type(error).__name__}")
    if not same:
        return Finding("failed", "what was written is not what is read")
    return Finding("ok", "written and read")


def disk_probe(directory: Path, needed: int) -> Finding:
    """Return whether a directory's file system has at least `needed` bytes free."""
    try:
        free = shutil.disk_usage(directory).free
    except OSError as error:
        return Finding("failed", f"it cannot be asked: {error.strerror or type(error).__name__}")
    if free < needed:
        room = f"{free / 1e6:,.0f} MB are free"
        return Finding("degraded", f"{room}, and the largest input needs {needed / 1e6:,.0f} MB")
    return Finding("ok", f"{free / 1e9:,.1f} GB are free")


def _written_and_read(blobs: Blobs, content: bytes) -> bool:
    if not blobs.remote:
        # Not a blob: nothing of it has to survive, or to be waited for until it would.
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


def _kernels(*, warm: bool) -> Finding:
    return Finding("ok", "loaded") if warm else Finding("failed", "they are being loaded")


def _builds(*, draining: bool) -> Finding:
    if draining:
        return Finding("failed", "the service is stopping")
    return Finding("ok", "new ones are welcome")


def _queue(service: Service) -> Finding:
    facts = service.builds.facts()
    if facts.fault is not None:
        return Finding("degraded", facts.fault)
    detail = f"{facts.queued} of {facts.capacity} builds wait"
    return Finding("degraded" if facts.queued >= facts.capacity else "ok", detail)


class _WorkersProbe:
    """Whether builds find a worker: strict at the start, patient when one is started anew."""

    def __init__(self, service: Service) -> None:
        self._service = service
        self._started = False
        self._none_since: float | None = None

    def __call__(self) -> Finding:
        facts = self._service.builds.facts()
        detail = f"{facts.warm_workers} of {facts.workers} are warm"
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
