"""The engine of a service on one machine: a queue in memory, and a worker process for each slot.

Nothing here needs to be durable. What was accepted is in the job book, and is taken up again from
there at the start. See ``docs/decisions/builds-in-a-worker-process.md``.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import math
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from itertools import count
from typing import TYPE_CHECKING, ParamSpec, TypeVar

from service.building.engine import EngineFacts, queue_full, shutting_down
from service.building.interruption import Interrupted, Interruption
from service.building.job_runner import LEASE_SECONDS, Performer, owner_name
from service.building.process import WORKER_COMMAND, ProcessDiedError
from service.storage.blobs import StoreUnavailableError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from service.building.engine import BuildReport
    from service.building.job_runner import Outcome
    from service.building.process import BuildProcess
    from service.jobs.book import JobBook, JobDocument
    from service.settings import Settings
    from service.storage.gamuts import GamutStore

__all__ = ["EmbeddedEngine"]

logger = logging.getLogger(__name__)

P = ParamSpec("P")
T = TypeVar("T")

_RESTART_DELAYS = (0.0, 1.0, 5.0, 30.0)
"""Seconds before a worker is started again that died before it was ready, by failures in a row."""

_RECOVERY_DELAYS = (1.0, 2.0, 5.0, 15.0, 60.0)
"""Seconds before unfinished jobs are looked up again in a store that could not be used."""

_FIRST_GUESS = 5.0
"""Seconds that a build is thought to take before one was measured: a press profile on one core."""

_WEIGHT = 0.2
"""Of the newest build in the mean of their seconds: the last five say what the next will take."""


@dataclass(eq=False)
class _Run:
    """A job that a slot is busy with."""

    document: JobDocument
    interruption: Interruption = field(default_factory=Interruption)


class EmbeddedEngine:
    """Builds in worker processes of this machine.

    Parameters
    ----------
    settings : Settings
        Workers, queue length, seconds to drain, and what a `Performer` takes from them.
    store : GamutStore
        Where inputs are and gamuts go.
    book : JobBook
        The jobs.
    sole_owner : bool
        Whether the store belongs to this process alone, so that whoever had claimed a job before
        its start is gone.
    command : sequence of str
        The command line of a worker process.
    on_build : callable, optional
        Told of the end of every build, in some thread.
    """

    def __init__(
        self,
        settings: Settings,
        store: GamutStore,
        book: JobBook,
        *,
        sole_owner: bool,
        command: Sequence[str] = WORKER_COMMAND,
        on_build: BuildReport | None = None,
    ) -> None:
        self._settings = settings
        self._book = book
        self._sole_owner = sole_owner
        self._owner = owner_name()
        self._performers = [
            Performer(settings, store, book, owner=self._owner, command=command, on_build=on_build)
            for _ in range(settings.build_workers)
        ]
        self._threads = ThreadPoolExecutor(settings.build_workers, thread_name_prefix="build")
        self._queue: asyncio.Queue[str] = asyncio.Queue()
        self._waiting: dict[str, JobDocument] = {}
        self._runs: dict[str, _Run] = {}
        self._slots: list[asyncio.Task[None]] = []
        self._recovery: asyncio.Task[None] | None = None
        self._timers: set[asyncio.TimerHandle] = set()
        self._closing = Interruption()
        self._draining = asyncio.Event()
        self._listener: Callable[[JobDocument], None] = _unheard
        self._completed = 0
        self._mean_seconds = _FIRST_GUESS

    def listen(self, listener: Callable[[JobDocument], None]) -> None:
        """Have every change of a job that is here told, in the event loop's thread."""
        self._listener = listener

    async def start(self) -> None:
        """Start the workers, in the background, and queue what an earlier process left."""
        self._slots = [
            asyncio.create_task(self._slot(performer), name=f"build slot {number}")
            for number, performer in enumerate(self._performers)
        ]
        self._recovery = asyncio.create_task(self._recover(), name="recovery of jobs")

    def drain(self) -> None:
        """Begin no build any more, and give back those that are not finished in time."""
        if self._draining.is_set():
            return
        self._draining.set()
        for timer in self._timers:
            timer.cancel()
        self._closing.release()
        if self._runs:
            logger.info("waiting for %d builds", len(self._runs))
        asyncio.get_running_loop().call_later(self._settings.drain_seconds, self._give_back)

    async def stop(self) -> None:
        """Finish what can be finished in time, give the rest back to the book, and end."""
        self.drain()
        if self._recovery is not None:
            self._recovery.cancel()
        await asyncio.gather(*self._slots, return_exceptions=True)
        self._threads.shutdown(wait=True)

    async def check_admission(self, arriving: int = 0) -> None:
        """Raise the problem that a new build would be refused with, if there is one."""
        if self._draining.is_set():
            raise shutting_down()
        waiting = len(self._waiting) + arriving
        if waiting >= self._settings.build_queue:
            raise queue_full(waiting, self.retry_after())

    async def enqueue(self, document: JobDocument, *, joined: bool = False) -> None:
        """Queue a job of the book; harmless if it is queued or running already."""
        if not joined and self.document(document.id) is None:
            self._waiting[document.id] = document
            self._queue.put_nowait(document.id)

    async def cancel(self, job_id: str) -> None:
        """End a job's build now, if it is here; the book says that it is cancelled already."""
        self._waiting.pop(job_id, None)
        run = self._runs.pop(job_id, None)
        if run is not None:
            run.interruption.cancel()

    def document(self, job_id: str) -> JobDocument | None:
        """Return a job as far as it is known here, fresher than the book; None if it is not."""
        run = self._runs.get(job_id)
        if run is not None:
            return run.document
        # Of what waits in a shared store the book knows more: another may have begun or ended it.
        return self._waiting.get(job_id) if self._sole_owner else None

    def facts(self) -> EngineFacts:
        """Return what the engine is doing."""
        return EngineFacts(
            queued=len(self._waiting),
            running=len(self._runs),
            workers=len(self._performers),
            warm_workers=sum(performer.process is not None for performer in self._performers),
            completed=self._completed,
            capacity=self._settings.build_queue,
            worker_starts=sum(performer.starts for performer in self._performers),
        )

    def retry_after(self, queued: int = 0) -> int:
        """Return in how many seconds a worker is expected to have done `queued` builds and one."""
        return math.ceil(self._mean_seconds * (queued + 1) / len(self._performers))

    def _give_back(self) -> None:
        for run in self._runs.values():
            run.interruption.release()

    async def _recover(self) -> None:
        """Queue what is unfinished in the book, the oldest first."""
        for attempt in count():
            try:
                documents = await asyncio.to_thread(self._unfinished)
                break
            except (OSError, StoreUnavailableError) as error:
                seconds = _RECOVERY_DELAYS[min(attempt, len(_RECOVERY_DELAYS) - 1)]
                message = "unfinished jobs could not be looked up, again in %g s: %s"
                logger.error(message, seconds, error)  # noqa: TRY400 - no defect
                await asyncio.sleep(seconds)
        if documents:
            logger.info("%d unfinished jobs are taken up again", len(documents))
        for document in documents:
            self._enqueue_after(document, _seconds_until_free(document))

    def _unfinished(self) -> list[JobDocument]:
        found = []
        for document in self._book.unfinished():
            if document.owner == self._owner:
                continue
            current: JobDocument | None = document
            if self._sole_owner and document.state == "running":
                current = self._book.requeue(document.id, document.token)
            if current is not None and not current.final:
                found.append(current)
        return sorted(found, key=lambda document: document.created)

    def _enqueue_after(self, document: JobDocument, seconds: float) -> None:
        """Queue a job after a while, unless it is here by then."""

        def enqueue() -> None:
            self._timers.discard(timer)
            if not self._draining.is_set() and self.document(document.id) is None:
                self._waiting[document.id] = document
                self._queue.put_nowait(document.id)

        timer = asyncio.get_running_loop().call_later(seconds, enqueue)
        self._timers.add(timer)

    async def _slot(self, performer: Performer) -> None:
        failures = 0
        try:
            while not self._draining.is_set():
                await self._pause(_RESTART_DELAYS[min(failures, len(_RESTART_DELAYS) - 1)])
                try:
                    process = await self._in_thread(performer.warm, self._closing)
                    failures = 0
                    await self._serve(performer, process)
                except Interrupted:
                    return
                except (ProcessDiedError, OSError) as error:
                    failures += 1
                    logger.error("a build worker did not start: %s", error)  # noqa: TRY400 - no defect
                except Exception:
                    # Whatever it was, a slot that ends would leave its builds to nobody.
                    failures += 1
                    logger.exception("a build worker is given up")
                    await self._in_thread(performer.close)
        finally:
            await self._in_thread(performer.close)

    async def _serve(self, performer: Performer, process: BuildProcess) -> None:
        """Give jobs to a performer until its process is gone, or the engine stops."""
        while performer.process is process:
            job_id = await self._next(process)
            if job_id is None:
                break
            document = self._waiting.pop(job_id, None)
            if document is not None:
                await self._perform(performer, _Run(document))
        if not self._draining.is_set():
            logger.warning("build worker %d is gone", process.pid)

    async def _next(self, process: BuildProcess) -> str | None:
        """Return the next job of the queue; None if the process ends or the engine stops before."""
        loop = asyncio.get_running_loop()
        ended_process = asyncio.Event()
        loop.add_reader(process, ended_process.set)
        ended = asyncio.create_task(ended_process.wait())
        taking = asyncio.create_task(self._queue.get())
        draining = asyncio.create_task(self._draining.wait())
        try:
            await asyncio.wait({taking, draining, ended}, return_when=asyncio.FIRST_COMPLETED)
            if self._draining.is_set():
                return None
            return taking.result() if taking.done() else None
        finally:
            loop.remove_reader(process)
            for waiting in (taking, draining, ended):
                waiting.cancel()

    async def _perform(self, performer: Performer, run: _Run) -> None:
        """Have one job done, and tell those who wait what became of it."""
        job_id = run.document.id
        self._runs[job_id] = run
        loop = asyncio.get_running_loop()

        def changed(document: JobDocument) -> None:
            loop.call_soon_threadsafe(self._progressed, run, document)

        clock = time.monotonic()
        outcome: Outcome | None = None
        delay = 0.0
        try:
            outcome = await self._in_thread(performer.perform, job_id, run.interruption, changed)
        except StoreUnavailableError as error:
            delay = LEASE_SECONDS
            logger.error("job %s could not be claimed: %s", job_id, error)  # noqa: TRY400 - no defect
        finally:
            # A cancelled job is not here any more, and may be here anew.
            here = self._runs.get(job_id) is run
            if here:
                del self._runs[job_id]
            if outcome is not None:
                self._ended(outcome, time.monotonic() - clock, here=here)
            elif here:
                self._enqueue_after(run.document, delay)

    def _ended(self, outcome: Outcome, seconds: float, *, here: bool) -> None:
        if outcome.built:
            self._completed += 1
        if outcome.built or outcome.state == "failed":
            self._mean_seconds += _WEIGHT * (seconds - self._mean_seconds)
        if not here:
            return
        document = outcome.document
        if document is not None:
            self._listener(document)
            if outcome.state == "unwritten":
                # When the store may work again, and nobody's lease is in the way.
                self._enqueue_after(document, LEASE_SECONDS + 1)
            elif outcome.state == "elsewhere" and not document.final:
                self._enqueue_after(document, _seconds_until_free(document))

    def _progressed(self, run: _Run, document: JobDocument) -> None:
        if self._runs.get(document.id) is run:
            run.document = document
            self._listener(document)

    async def _pause(self, seconds: float) -> None:
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(self._draining.wait(), seconds)

    async def _in_thread(self, function: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        loop = asyncio.get_running_loop()
        return await loop.run_in_executor(self._threads, lambda: function(*args, **kwargs))


def _seconds_until_free(document: JobDocument) -> float:
    """Return when a job can be claimed, as far as it can be told."""
    if document.state != "running":
        return 0.0
    return max(0.0, (document.lease_until or 0.0) - time.time()) + 1.0


def _unheard(_document: JobDocument) -> None:
    """Tell nobody."""
