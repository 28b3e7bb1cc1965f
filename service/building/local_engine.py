"""The build engine of a single machine: a queue in memory, and builders that take jobs from it.

Clients with waiting jobs take turns. A builder is a thread with one worker process. Nothing here is
durable: accepted jobs are in the job book and are queued again at the start. See
``docs/decisions/builds-in-a-worker-process.md``.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import math
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from datetime import datetime
from itertools import count

from service.building.engine import BuildReport, Engine, EngineFacts, FairQueue, queue_full
from service.building.job_runner import (
    LEASE_SECONDS,
    Interrupted,
    Interruption,
    JobRunner,
    Outcome,
)
from service.building.process import WORKER_COMMAND, BuildProcess, ProcessDiedError
from service.jobs.book import JobBook, JobDocument
from service.settings import Settings
from service.storage.blobs import StoreUnavailableError
from service.storage.gamut_store import GamutStore

__all__ = ["LocalEngine"]

logger = logging.getLogger(__name__)

_RESTART_DELAYS = (0.0, 1.0, 5.0, 30.0)
"""Seconds before a worker that died during its start is started again, by failures in a row."""

_RECOVERY_DELAYS = (1.0, 2.0, 5.0, 15.0, 60.0)
"""Seconds before unfinished jobs are looked up again in an unavailable store."""

_FIRST_GUESS = 5.0
"""Assumed seconds of a build before the first measurement: a press profile on one core."""

_WEIGHT = 0.2
"""Weight of the newest build in the moving mean of build times."""


@dataclass(eq=False)
class _Run:
    """A job that a builder has taken."""

    document: JobDocument
    interruption: Interruption = field(default_factory=Interruption)


class LocalEngine(Engine):
    """Builds in worker processes of this machine.

    With `sole_owner`, the store belongs to this process alone, so all earlier owners of jobs are
    gone. `on_build` is called at the end of every build, in some thread.
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
        self._runners = [
            JobRunner(settings, store, book, command=command, on_build=on_build)
            for _ in range(settings.build_workers)
        ]
        self._threads = ThreadPoolExecutor(settings.build_workers, thread_name_prefix="build")
        self._waiting = FairQueue()
        self._idle: set[asyncio.Future[bool]] = set()
        self._runs: dict[str, _Run] = {}
        self._builders: list[asyncio.Task[None]] = []
        self._recovery: asyncio.Task[None] | None = None
        self._timers: set[asyncio.TimerHandle] = set()
        self._closing = Interruption()
        self._draining = asyncio.Event()
        self._completed = 0
        self._mean_seconds = _FIRST_GUESS

    async def start(self, changed: Callable[[JobDocument], None]) -> None:
        """Start the workers in the background, and queue the jobs of an earlier process."""
        self._changed = changed
        self._builders = [
            asyncio.create_task(self._run_builder(runner), name=f"builder {number}")
            for number, runner in enumerate(self._runners)
        ]
        self._recovery = asyncio.create_task(self._recover(), name="recovery of jobs")

    def drain(self) -> None:
        """Start no more builds, and give back those that do not end in time."""
        if self._draining.is_set():
            return
        self._draining.set()
        self._wake_builders()
        for timer in self._timers:
            timer.cancel()
        self._closing.release()
        if self._runs:
            logger.info("waiting for %d builds", len(self._runs))
        asyncio.get_running_loop().call_later(self._settings.drain_seconds, self._give_back)

    async def stop(self) -> None:
        """Finish builds that end in time, give the others back to the book, and end."""
        self.drain()
        if self._recovery is not None:
            self._recovery.cancel()
        await asyncio.gather(*self._builders, return_exceptions=True)
        self._threads.shutdown(wait=True)

    async def check_admission(self, arriving: int) -> None:
        """Raise ``queue-full`` if there is no room for a new build."""
        waiting = len(self._waiting) + arriving
        if waiting >= self._settings.build_queue:
            raise queue_full(waiting, self.facts().retry_after)

    async def enqueue(self, document: JobDocument, *, joined: bool = False) -> None:
        """Queue a job of the book. A job that is queued or running already is ignored."""
        if not joined and self.document(document.id) is None:
            self._put(document)

    async def cancel(self, job_id: str) -> None:
        """End a job's build now, if it runs here. The book already has the job as cancelled."""
        self._waiting.discard(job_id)
        run = self._runs.pop(job_id, None)
        if run is not None:
            run.interruption.cancel()

    def document(self, job_id: str) -> JobDocument | None:
        """Return a job that is known here, newer than in the book; None for other jobs."""
        run = self._runs.get(job_id)
        if run is not None:
            return run.document
        # In a shared store another process may have started or ended a waiting job.
        return self._waiting.find(job_id) if self._sole_owner else None

    def facts(self) -> EngineFacts:
        """Return the state of the engine."""
        oldest = self._waiting.oldest
        accepted = None if oldest is None else datetime.fromisoformat(oldest.created).timestamp()
        return EngineFacts(
            queued=len(self._waiting),
            running=len(self._runs),
            workers=len(self._runners),
            warm_workers=sum(runner.process is not None for runner in self._runners),
            completed=self._completed,
            capacity=self._settings.build_queue,
            oldest=0.0 if accepted is None else max(0.0, time.time() - accepted),
            worker_starts=sum(runner.starts for runner in self._runners),
            retry_after=math.ceil(self._mean_seconds / len(self._runners)),
        )

    def _put(self, document: JobDocument) -> None:
        self._waiting.put(document)
        self._wake_builders()

    def _wake_builders(self) -> None:
        for signal in self._idle:
            _resolve(signal, True)

    def _give_back(self) -> None:
        for run in self._runs.values():
            run.interruption.release()

    async def _recover(self) -> None:
        """Queue the unfinished jobs of the book, the oldest first."""
        for attempt in count():
            try:
                documents = await asyncio.to_thread(self._unfinished)
                break
            except (OSError, StoreUnavailableError) as error:
                seconds = _RECOVERY_DELAYS[min(attempt, len(_RECOVERY_DELAYS) - 1)]
                message = "unfinished jobs could not be read, next try in %g s: %s"
                logger.error(message, seconds, error)  # noqa: TRY400 - no defect
                await asyncio.sleep(seconds)
        if documents:
            logger.info("%d unfinished jobs are queued again", len(documents))
        for document in documents:
            self._enqueue_after(document, _seconds_until_free(document))

    def _unfinished(self) -> list[JobDocument]:
        own = {runner.owner for runner in self._runners}
        documents = []
        for document in self._book.unfinished():
            if document.owner in own:
                continue
            current: JobDocument | None = document
            if self._sole_owner and document.state == "running":
                current = self._book.requeue(document.id, document.token)
            if current is not None and not current.final:
                documents.append(current)
        return sorted(documents, key=lambda document: document.created)

    def _enqueue_after(self, document: JobDocument, seconds: float) -> None:
        """Queue a job after some seconds, unless it is here by then."""

        def enqueue() -> None:
            self._timers.discard(timer)
            if not self._draining.is_set() and self.document(document.id) is None:
                self._put(document)

        timer = asyncio.get_running_loop().call_later(seconds, enqueue)
        self._timers.add(timer)

    async def _run_builder(self, runner: JobRunner) -> None:
        """Keep a worker process, and run jobs with it until the engine stops."""
        loop = asyncio.get_running_loop()
        failures = 0
        try:
            while not self._draining.is_set():
                with contextlib.suppress(TimeoutError):
                    delay = _RESTART_DELAYS[min(failures, len(_RESTART_DELAYS) - 1)]
                    await asyncio.wait_for(self._draining.wait(), delay)
                try:
                    process = await loop.run_in_executor(
                        self._threads, runner.warm, self._closing.check
                    )
                    failures = 0
                    while runner.process is process and (document := await self._next(process)):
                        await self._run_job(runner, _Run(document))
                    if not self._draining.is_set():
                        logger.warning("build worker %d ended", process.pid)
                except Interrupted:
                    return
                except (ProcessDiedError, OSError) as error:
                    failures += 1
                    logger.error("build worker did not start: %s", error)  # noqa: TRY400 - no defect
                except Exception:
                    # Any error: a builder that ended would leave its builds unprocessed.
                    failures += 1
                    logger.exception("build worker failed unexpectedly")
                    await loop.run_in_executor(self._threads, runner.close)
        finally:
            await loop.run_in_executor(self._threads, runner.close)

    async def _next(self, process: BuildProcess) -> JobDocument | None:
        """Return the job whose turn it is; None if the process ends or the engine stops."""
        loop = asyncio.get_running_loop()
        while not self._draining.is_set():
            if (document := self._waiting.take()) is not None:
                return document
            signal: asyncio.Future[bool] = loop.create_future()
            self._idle.add(signal)
            loop.add_reader(process, _resolve, signal, False)
            try:
                if not await signal:
                    break
            finally:
                loop.remove_reader(process)
                self._idle.discard(signal)
        return None

    async def _run_job(self, runner: JobRunner, run: _Run) -> None:
        """Run one job and report the outcome."""
        job_id = run.document.id
        self._runs[job_id] = run
        loop = asyncio.get_running_loop()

        def changed(document: JobDocument) -> None:
            loop.call_soon_threadsafe(self._report_progress, run, document)

        clock = time.monotonic()
        outcome: Outcome | None = None
        delay = 0.0
        try:
            outcome = await loop.run_in_executor(
                self._threads, runner.run, job_id, run.interruption, changed
            )
        except StoreUnavailableError as error:
            delay = LEASE_SECONDS
            logger.error("job %s could not be claimed: %s", job_id, error)  # noqa: TRY400 - no defect
        finally:
            # A cancelled job has left, and may have been queued again.
            here = self._runs.get(job_id) is run
            if here:
                del self._runs[job_id]
            if outcome is not None:
                self._record_end(outcome, time.monotonic() - clock, here=here)
            elif here:
                self._enqueue_after(run.document, delay)

    def _record_end(self, outcome: Outcome, seconds: float, *, here: bool) -> None:
        document = outcome.document
        self._completed += outcome.built
        if outcome.built or outcome.state == "failed":
            self._mean_seconds += _WEIGHT * (seconds - self._mean_seconds)
        if not here or document is None:
            return
        self._changed(document)
        if outcome.state == "unwritten":
            # After the lease, when the store may work again.
            self._enqueue_after(document, LEASE_SECONDS + 1)
        elif outcome.state == "elsewhere" and not document.final:
            self._enqueue_after(document, _seconds_until_free(document))

    def _report_progress(self, run: _Run, document: JobDocument) -> None:
        if self._runs.get(document.id) is run:
            run.document = document
            self._changed(document)


def _resolve(signal: asyncio.Future[bool], value: bool) -> None:
    if not signal.done():
        signal.set_result(value)


def _seconds_until_free(document: JobDocument) -> float:
    """Return the estimated seconds until a job can be claimed."""
    if document.state != "running":
        return 0.0
    return max(0.0, (document.lease_until or 0.0) - time.time()) + 1.0
