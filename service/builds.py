"""Builds in worker processes: one per gamut however many ask, with a deadline and a bounded queue.

A `Job` has the id of the gamut that it builds, so that identical requests meet in it and every
client can find it. Each of the `Builds` slots owns one worker process (`service.worker`), keeps it
warm, ends it when a build exceeds its deadline, and starts another whenever one is gone. A build
whose worker died is started again a few times, because the input may not have been the reason.
See ``docs/decisions/builds-in-a-worker-process.md``.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import logging
import sys
import time
from collections import OrderedDict
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any, Literal

from service.problems import Problem, ProblemError
from service.storage.gamuts import GamutNotStoredError
from service.storage.records import Record

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from pathlib import Path

    from service.settings import Settings
    from service.storage.gamuts import GamutStore

__all__ = ["WORKER_COMMAND", "Builds", "Job", "now"]

logger = logging.getLogger(__name__)

WORKER_COMMAND = (sys.executable, "-m", "service.worker")
"""How a worker is started: a process of its own, which shares nothing with this one."""

_LINE_LIMIT = 16 * 1024 * 1024
"""Bytes of the longest event: a description with its whole error curve is well below 1 MB."""

_RESTART_DELAYS = (0.0, 1.0, 5.0, 30.0)
"""Seconds before a worker is started again that died before it was ready, by failures in a row."""


class _WorkerDiedError(Exception):
    """The worker process ended while it was needed."""


def now() -> str:
    """Return the time in RFC 3339, UTC, to the millisecond."""
    return datetime.now(UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")


@dataclass(eq=False)
class Job:
    """One build, from its acceptance to its end.

    Attributes
    ----------
    id : str
        The id of the gamut that is built.
    options : dict
        The gamut's options, all of them.
    source : Path
        The input, a file in the store's temporary folder until the job is done.
    state : str
        What the names say. A succeeded job's gamut is in the store.
    stage, fraction : str, float
        How far a running build is: a stage of `gamutcore` and the part of it that is done, 0..1.
    attempts : int
        How often a worker was given the build.
    problem : Problem, optional
        Why the job failed.
    done : asyncio.Event
        Set when the state is final.
    """

    id: str
    options: dict[str, Any]
    source: Path
    state: Literal["queued", "running", "succeeded", "failed"] = "queued"
    stage: str = ""
    fraction: float = 0.0
    attempts: int = 0
    created: str = field(default_factory=now)
    started: str | None = None
    finished: str | None = None
    problem: Problem | None = None
    done: asyncio.Event = field(default_factory=asyncio.Event)

    async def wait(self, seconds: float) -> bool:
        """Wait until the job is done, at most `seconds`; whether it is."""
        if seconds > 0:
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(self.done.wait(), seconds)
        return self.done.is_set()


class _Worker:
    """A running worker process, seen from the service."""

    def __init__(self, process: asyncio.subprocess.Process) -> None:
        self.process = process

    @classmethod
    async def started(cls, command: Sequence[str]) -> _Worker:
        """Start a process and wait until its kernels are compiled."""
        process = await asyncio.create_subprocess_exec(
            *command,
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
            limit=_LINE_LIMIT,
        )
        worker = cls(process)
        try:
            await worker.event()
        except BaseException:
            worker.kill()
            raise
        return worker

    async def event(self) -> dict[str, Any]:
        """Return the worker's next event; `_WorkerDiedError` if it ends instead."""
        assert self.process.stdout is not None  # noqa: S101 - a pipe was asked for
        try:
            line = await self.process.stdout.readline()
            if line.endswith(b"\n"):
                event: dict[str, Any] = json.loads(line)
                return event
        except ValueError as error:
            raise _WorkerDiedError(f"an unreadable event: {error}") from error
        raise _WorkerDiedError(f"exit status {await self.process.wait()}")

    async def result(
        self, request: dict[str, Any], progress: Callable[[str, float], None]
    ) -> dict[str, Any]:
        """Have one gamut built and return the final event; `_WorkerDiedError` if there is none."""
        assert self.process.stdin is not None  # noqa: S101 - a pipe was asked for
        try:
            self.process.stdin.write(json.dumps(request).encode() + b"\n")
            await self.process.stdin.drain()
        except ConnectionError as error:
            raise _WorkerDiedError(str(error)) from error
        while True:
            event = await self.event()
            if event["event"] != "progress":
                return event
            progress(event["stage"], event["fraction"])

    def kill(self) -> None:
        """End the process now, whatever it is doing."""
        with contextlib.suppress(ProcessLookupError):
            self.process.kill()


class Builds:
    """The jobs of one service and the workers that do them.

    Parameters
    ----------
    settings : Settings
        Workers, queue length, deadline, attempts.
    store : GamutStore
        Where inputs wait and finished gamuts go.
    command : sequence of str
        The command line of a worker, which speaks the protocol of `service.worker`.
    """

    def __init__(
        self, settings: Settings, store: GamutStore, command: Sequence[str] = WORKER_COMMAND
    ) -> None:
        self._settings = settings
        self._store = store
        self._command = command
        self._active: dict[str, Job] = {}
        self._finished: OrderedDict[str, Job] = OrderedDict()
        self._queue: asyncio.Queue[Job] = asyncio.Queue(settings.build_queue)
        self._slots: list[asyncio.Task[None]] = []
        self._stopping = False
        self.first_warm = asyncio.Event()
        self.warm_workers = 0
        self.completed = 0

    @property
    def warm(self) -> bool:
        """Whether every worker is ready to build at once."""
        return self.warm_workers == self._settings.build_workers

    @property
    def running(self) -> int:
        """The number of builds that a worker is busy with."""
        return len(self._active) - self._queue.qsize()

    @property
    def queued(self) -> int:
        """The number of builds that wait for a worker."""
        return self._queue.qsize()

    def start(self) -> None:
        """Start the workers, in the background."""
        self._slots = [
            asyncio.create_task(self._slot(), name=f"build slot {number}")
            for number in range(self._settings.build_workers)
        ]

    async def stop(self) -> None:
        """Refuse new builds, let the accepted ones finish for a while, end the workers."""
        self._stopping = True
        pending = [asyncio.create_task(job.done.wait()) for job in self._active.values()]
        if pending:
            logger.info("waiting for %d builds", len(pending))
            _, late = await asyncio.wait(pending, timeout=self._settings.drain_seconds)
            for waiter in late:
                waiter.cancel()
            if late:
                logger.warning("%d builds were given up", len(late))
        for slot in self._slots:
            slot.cancel()
        await asyncio.gather(*self._slots, return_exceptions=True)

    def active(self, gamut_id: str) -> Job | None:
        """Return the job that is building this gamut, if there is one."""
        return self._active.get(gamut_id)

    def job(self, gamut_id: str) -> Job | None:
        """Return the job of a gamut: the one under way, else the one that ended last."""
        return self._active.get(gamut_id) or self._finished.get(gamut_id)

    def check_admission(self) -> None:
        """Raise the problem that a new build would be refused with: stopping, or a full queue."""
        if self._stopping:
            raise ProblemError(
                Problem(
                    "shutting-down",
                    "The service is stopping and accepts no new builds.",
                    headers={"Retry-After": "5"},
                )
            )
        if self._queue.full():
            raise ProblemError(
                Problem(
                    "queue-full",
                    f"{self._queue.qsize()} builds are waiting already.",
                    headers={"Retry-After": "5"},
                )
            )

    def submit(self, gamut_id: str, options: dict[str, Any], source: Path) -> Job:
        """Return the job that builds this gamut: the one under way, else a new one.

        Parameters
        ----------
        gamut_id : str
            Id of the gamut; identical requests have the same.
        options : dict
            The gamut's options, all of them.
        source : Path
            The input in the store's temporary folder; the job removes it.

        Raises
        ------
        ProblemError
            ``queue-full`` or ``shutting-down``.
        """
        job = self._active.get(gamut_id)
        if job is not None:
            source.unlink(missing_ok=True)
            return job
        try:
            self.check_admission()
        except ProblemError:
            source.unlink(missing_ok=True)
            raise
        job = Job(gamut_id, options, source)
        self._active[gamut_id] = job
        self._queue.put_nowait(job)
        return job

    async def _slot(self) -> None:
        failures = 0
        unfinished: Job | None = None
        while True:
            try:
                await asyncio.sleep(_RESTART_DELAYS[min(failures, len(_RESTART_DELAYS) - 1)])
                worker = await _Worker.started(self._command)
            except (_WorkerDiedError, OSError) as error:
                failures += 1
                logger.error("a build worker did not start: %s", error)  # noqa: TRY400 - no defect
                continue
            except Exception:
                failures += 1
                logger.exception("a build worker did not start")
                continue
            failures = 0
            self.warm_workers += 1
            self.first_warm.set()
            logger.info("build worker %d is warm", worker.process.pid)
            try:
                unfinished = await self._serve(worker, unfinished)
                logger.warning("build worker %d is gone", worker.process.pid)
            except Exception:
                # Whatever it was, a slot that ends would leave its builds to nobody.
                logger.exception("build worker %d is given up", worker.process.pid)
            finally:
                self.warm_workers -= 1
                worker.kill()
                await worker.process.wait()

    async def _serve(self, worker: _Worker, unfinished: Job | None) -> Job | None:
        """Give jobs to a worker until it is gone, and return the one that died with it."""
        death = asyncio.create_task(worker.process.wait())
        try:
            while True:
                job = unfinished or await self._next(death)
                if job is None:
                    return None
                unfinished = None
                try:
                    if not await self._run(job, worker):
                        return None
                except _WorkerDiedError as error:
                    logger.warning("the worker died in the build of %s: %s", job.id, error)
                    return None if self._given_up(job) else job
        finally:
            death.cancel()

    async def _next(self, death: asyncio.Task[int]) -> Job | None:
        """Return the next job of the queue; None if the worker ends before there is one."""
        taking = asyncio.create_task(self._queue.get())
        try:
            await asyncio.wait({taking, death}, return_when=asyncio.FIRST_COMPLETED)
            return taking.result() if taking.done() else None
        finally:
            taking.cancel()

    async def _run(self, job: Job, worker: _Worker) -> bool:
        """Do one job; whether the worker can be given another."""
        output = self._store.scratch(".gamut")
        idle = True
        request = {"input": str(job.source), "output": str(output), "options": job.options}

        def progress(stage: str, fraction: float) -> None:
            job.stage, job.fraction = stage, fraction

        try:
            # An identical request may have been finished between this one's look into the store
            # and its arrival here.
            if await asyncio.to_thread(self._is_stored, job.id):
                self._finish(job)
                return True
            job.state, job.stage, job.fraction = "running", "", 0.0
            job.started = job.started or now()
            job.attempts += 1
            clock = time.monotonic()
            logger.info("build of %s started, attempt %d", job.id, job.attempts)
            idle = False
            async with asyncio.timeout(self._settings.build_timeout):
                event = await worker.result(request, progress)
            idle = True
            problem = await self._outcome(job, event, output)
            seconds = time.monotonic() - clock
            outcome = "succeeded" if problem is None else f"failed ({problem.code})"
            logger.info("build of %s %s after %.2f s", job.id, outcome, seconds)
            self._finish(job, problem)
        except TimeoutError:
            logger.warning("build of %s exceeded its deadline", job.id)
            self._finish(job, self._timeout_problem())
        except _WorkerDiedError:
            raise
        except Exception as error:
            # It must cost this build only: neither the slot nor those who wait for the job.
            logger.exception("build of %s ended unexpectedly", job.id)
            self._finish(job, _failure_problem(getattr(error, "errno", None)))
        finally:
            with contextlib.suppress(OSError):
                output.unlink(missing_ok=True)
        return idle

    def _given_up(self, job: Job) -> bool:
        """Whether a job whose worker died was tried often enough; if so, it has failed."""
        if job.attempts < self._settings.build_attempts:
            return False
        detail = f"The process that built this gamut died, {job.attempts} times in a row."
        self._finish(job, Problem("build-crashed", detail))
        return True

    async def _outcome(self, job: Job, event: dict[str, Any], output: Path) -> Problem | None:
        if event["event"] == "refused":
            return Problem(
                event["code"], event["message"], where=event["where"], remedy=event["remedy"]
            )
        if event["event"] == "failed":
            return _failure_problem(event["errno"])
        record = Record(job.id, event["sha256"], event["nbytes"], now(), event["description"])
        try:
            await asyncio.to_thread(self._store.publish, record, output)
        except OSError as error:
            logger.exception("gamut %s could not be published", job.id)
            return _failure_problem(error.errno)
        self.completed += 1
        return None

    def _finish(self, job: Job, problem: Problem | None = None) -> None:
        job.state = "succeeded" if problem is None else "failed"
        job.problem = problem
        job.finished = now()
        self._active.pop(job.id, None)
        self._finished.pop(job.id, None)
        self._finished[job.id] = job
        if len(self._finished) > self._settings.finished_jobs:
            self._finished.popitem(last=False)
        job.done.set()
        # What stays in the temporary folder is removed at the next start.
        with contextlib.suppress(OSError):
            job.source.unlink(missing_ok=True)

    def _is_stored(self, gamut_id: str) -> bool:
        try:
            self._store.record(gamut_id)
        except GamutNotStoredError:
            return False
        return True

    def _timeout_problem(self) -> Problem:
        return Problem(
            "build-timeout",
            f"The build was ended after {self._settings.build_timeout:g} s.",
            where={"field": "surface_samples"},
        )


def _failure_problem(number: int | None) -> Problem:
    """Return the problem of a build that failed with an error number of the system, or none."""
    problem = Problem.from_errno(number)
    return problem or Problem("build-failed", "The build ended with an unexpected error.")
