"""Performs one job at a time with one worker process: claim, input, build, publish, finish.

It is the same for a slot of `service.building.embedded` and for a worker on another machine. All
that it knows comes from the store, and all that becomes of the job goes there. All methods block.
"""

from __future__ import annotations

import contextlib
import logging
import os
import secrets
import socket
import time
from dataclasses import asdict, dataclass, field, replace
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from service.building.interruption import Interrupted, Interruption
from service.building.lease_renewer import ClaimKeeper
from service.building.process import (
    WORKER_COMMAND,
    BuildProcess,
    BuildTimeoutError,
    MemoryExceededError,
    ProcessDiedError,
)
from service.jobs.book import JobCancelledError, JobDocument, LeaseLostError, now
from service.problems.problem import Problem, sentence
from service.storage.blobs import BlobNotFoundError, StoreUnavailableError
from service.storage.records import Record

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from pathlib import Path

    from service.building.engine import BuildReport
    from service.jobs.book import Claim, JobBook
    from service.settings import Settings
    from service.storage.gamuts import GamutStore

__all__ = ["HEARTBEAT_SECONDS", "LEASE_SECONDS", "Outcome", "Performer", "owner_name"]

logger = logging.getLogger(__name__)

LEASE_SECONDS = 20.0
"""How long a claim holds without being renewed: what a build waits after its host was lost."""

HEARTBEAT_SECONDS = 4.0
"""Between two renewals of a claim, where its progress is known from memory besides."""


def owner_name() -> str:
    """Return a new name for who builds: host, process, and chance, since both come again."""
    return f"{socket.gethostname()}:{os.getpid()}:{secrets.token_hex(4)}"


@dataclass(frozen=True)
class Outcome:
    """What became of a job that was given to a performer.

    Attributes
    ----------
    state : str
        ``succeeded``, ``failed`` and ``cancelled`` are what the job is; ``released``: it was given
        back; ``elsewhere``: somebody else has it, or it was over before; ``unwritten``: it is over
        here, but the store could not take that, so it has to be done again.
    document : JobDocument or None
        The job as it is now; None if it is unknown.
    built : bool
        Whether a gamut was built, and not found built.
    seconds : dict
        By stage of the build.
    """

    state: Literal["succeeded", "failed", "cancelled", "released", "elsewhere", "unwritten"]
    document: JobDocument | None
    built: bool = False
    seconds: dict[str, float] = field(default_factory=dict)


class _Built(NamedTuple):
    """What came of one run of the process."""

    problem: Problem | None
    built: bool
    seconds: dict[str, float]


class Performer:
    """One worker process, and the jobs that it is given.

    Parameters
    ----------
    settings : Settings
        Deadline and memory of a build.
    store : GamutStore
        Where inputs are and gamuts go.
    book : JobBook
        The jobs.
    owner : str
        In whose name jobs are claimed.
    heartbeat : float
        Seconds between two renewals of a claim, which write down the progress.
    lease : float
        Seconds for which a claim holds without being renewed.
    command : sequence of str
        The command line of the process.
    on_build : callable, optional
        Told of the end of every run of the process.

    Attributes
    ----------
    starts : int
        Processes that became warm, one after the other.
    """

    def __init__(
        self,
        settings: Settings,
        store: GamutStore,
        book: JobBook,
        *,
        owner: str | None = None,
        heartbeat: float = HEARTBEAT_SECONDS,
        lease: float = LEASE_SECONDS,
        command: Sequence[str] = WORKER_COMMAND,
        on_build: BuildReport | None = None,
    ) -> None:
        self._settings = settings
        self._store = store
        self._book = book
        self._owner = owner or owner_name()
        self._heartbeat = heartbeat
        self._lease = lease
        self._command = command
        self._on_build = on_build
        self._process: BuildProcess | None = None
        self.starts = 0

    @property
    def process(self) -> BuildProcess | None:
        """The process if it is warm; None if there is none."""
        process = self._process
        return process if process is not None and process.alive else None

    def warm(self, interruption: Interruption | None = None) -> BuildProcess:
        """Return the process, started and warm.

        Raises
        ------
        ProcessDiedError, OSError
            It cannot be started.
        Interrupted
            It was told not to wait for it.
        """
        if self.process is None:
            self.close()
            process = BuildProcess(self._command)
            process.wait_until_ready((interruption or Interruption()).check)
            self._process = process
            self.starts += 1
            logger.info("build worker %d is warm", process.pid)
        assert self._process is not None  # noqa: S101 - started if there was none
        return self._process

    def close(self) -> None:
        """End the process."""
        if self._process is not None:
            self._process.kill()
            self._process = None

    def perform(
        self,
        job_id: str,
        interruption: Interruption | None = None,
        changed: Callable[[JobDocument], None] | None = None,
    ) -> Outcome:
        """Return what became of a job, after doing it if it is to be had.

        Parameters
        ----------
        job_id : str
            Which job.
        interruption : Interruption, optional
            Ends it from another thread.
        changed : callable, optional
            Told how far the build is, in this thread.

        Raises
        ------
        ProcessDiedError, OSError
            The process cannot be started. The job was not claimed.
        StoreUnavailableError
            The job could not be claimed.
        """
        interruption = interruption or Interruption()
        while True:
            try:
                self.warm(interruption)
            except Interrupted:
                return Outcome("released", self._book.read(job_id))
            claim = self._book.claim(job_id, self._owner, self._lease)
            if claim is None:
                return Outcome("elsewhere", self._book.read(job_id))
            if changed is not None:
                changed(claim.document)
            outcome = self._attempted(claim, interruption, changed or _ignored)
            if outcome is not None:
                return outcome

    def _attempted(
        self,
        claim: Claim,
        interruption: Interruption,
        changed: Callable[[JobDocument], None],
    ) -> Outcome | None:
        """Return what became of one attempt; None if the process died and there is another."""
        document = claim.document
        logger.info("build of %s started, attempt %d", document.id, document.attempts)
        clock = time.monotonic()
        keeper = ClaimKeeper(self._book, claim, self._heartbeat)
        try:
            with keeper:
                result = self._result(keeper, interruption, changed)
            return self._finished(keeper.claim, result, time.monotonic() - clock)
        except Interrupted as interrupted:
            return self._interrupted(keeper.claim, interrupted, time.monotonic() - clock)
        except JobCancelledError:
            return self._cancelled(document, time.monotonic() - clock)
        except LeaseLostError:
            logger.warning("build of %s: somebody else has it by now", document.id)
            return Outcome("elsewhere", self._known(document.id))
        except ProcessDiedError as error:
            logger.warning("the worker died in the build of %s: %s", document.id, error)
            self._report("crashed", {"total": time.monotonic() - clock}, document)
            problem = Problem(
                "build-crashed",
                f"The process that built this gamut died, {document.attempts} times in a row "
                f"(the last time: {error}).",
            )
            return self._tried_in_vain(keeper.claim, problem)
        except StoreUnavailableError as error:
            logger.warning("build of %s: the store cannot be used: %s", document.id, error)
            return self._tried_in_vain(keeper.claim, Problem.store_unavailable())

    def _result(
        self,
        keeper: ClaimKeeper,
        interruption: Interruption,
        changed: Callable[[JobDocument], None],
    ) -> _Built:
        """Return what came of building a claimed job, and publish the gamut."""
        job_id = keeper.document.id
        scratch: list[Path] = []

        def check() -> None:
            interruption.check()
            keeper.check()

        def progress(stage: str, fraction: float) -> None:
            keeper.note(stage, fraction)
            changed(keeper.document)

        try:
            # An identical request may have been finished between this one's look into the store
            # and its arrival here.
            if self._store.stored(job_id):
                return _Built(None, False, {})
            try:
                source = self._store.input_path(job_id)
            except BlobNotFoundError:
                detail = "The data that this gamut was to be built from is not stored any more."
                return _Built(Problem("build-input-lost", detail), False, {})
            scratch += [source, self._store.scratch(".gamut")]
            process = self.warm(interruption)
            event = process.result(
                {
                    "input": str(scratch[0]),
                    "output": str(scratch[1]),
                    "options": keeper.document.options,
                    "limits": asdict(self._settings.data_limits),
                    "memory": self._settings.build_memory_bytes,
                },
                timeout=self._settings.build_timeout,
                progress=progress,
                check=check,
            )
            self._renew_if_swollen(process)
            problem = self._problem_of(event)
            if problem is None:
                check()
                record = Record(
                    job_id, event["sha256"], event["nbytes"], now(), event["description"]
                )
                self._store.publish(record, scratch[1])
            return _Built(problem, problem is None, event.get("seconds", {}))
        except BuildTimeoutError:
            return _Built(self._timeout_problem(), False, {})
        except MemoryExceededError:
            return _Built(self._memory_problem(), False, {})
        except (Interrupted, LeaseLostError, ProcessDiedError, StoreUnavailableError):
            raise
        except Exception as error:
            # It must cost this build only: neither the process nor those who wait for the job.
            problem = _failure_problem(getattr(error, "errno", None))
            if _is_of_the_service(problem):
                logger.warning("build of %s: the store or the machine refused: %s", job_id, error)
            else:
                logger.exception("build of %s ended unexpectedly", job_id)
            return _Built(problem, False, {})
        finally:
            for path in scratch:
                # What stays is removed at the next start.
                with contextlib.suppress(OSError):
                    path.unlink(missing_ok=True)

    def _finished(self, claim: Claim, result: _Built, seconds: float) -> Outcome:
        """Return the outcome of a claim whose build has ended by itself, after writing it down."""
        job_id, problem = claim.document.id, result.problem
        state: Literal["succeeded", "failed"] = "succeeded" if problem is None else "failed"
        told = state if problem is None else f"failed ({problem.code})"
        logger.info("build of %s %s after %.2f s", job_id, told, seconds)
        if result.built or problem is not None:
            self._report(
                state if problem is None else problem.code,
                {**result.seconds, "total": seconds},
                claim.document,
            )
        try:
            if problem is not None:
                # Before the job is over: after that, its input may be that of a new one. Whose
                # claim was lost is told so here: the input is another's by now.
                claim = self._book.heartbeat(claim, claim.document.stage, claim.document.fraction)
                # What is no fault of the data may go better the next time, with the same data.
                if not _is_of_the_service(problem):
                    self._store.drop_input(job_id)
            document = self._book.finish(claim, state, problem)
        except (OSError, StoreUnavailableError) as error:
            return self._unwritten(claim, problem, error)
        return Outcome(state, document, result.built, result.seconds)

    def _interrupted(self, claim: Claim, interrupted: Interrupted, seconds: float) -> Outcome:
        if interrupted.reason == "cancel":
            return self._cancelled(claim.document, seconds)
        logger.info("build of %s is given back", claim.document.id)
        try:
            return Outcome("released", self._book.release(claim))
        except LeaseLostError:
            return Outcome("elsewhere", self._known(claim.document.id))
        except (OSError, StoreUnavailableError) as error:
            return self._unwritten(claim, None, error)

    def _cancelled(self, document: JobDocument, seconds: float) -> Outcome:
        logger.info("build of %s cancelled after %.2f s", document.id, seconds)
        self._report("cancelled", {"total": seconds}, document)
        return Outcome("cancelled", self._known(document.id))

    def _tried_in_vain(self, claim: Claim, problem: Problem) -> Outcome | None:
        """Return the outcome of a claim that came to nothing; None if there is another attempt."""
        try:
            document = self._book.crashed(claim, problem)
        except LeaseLostError:
            return Outcome("elsewhere", self._known(claim.document.id))
        except (OSError, StoreUnavailableError) as error:
            return self._unwritten(claim, problem, error)
        if not document.final:
            return None
        logger.warning("build of %s is given up (%s)", document.id, problem.code)
        self._report(problem.code, {}, document)
        return Outcome("failed", document)

    def _unwritten(self, claim: Claim, problem: Problem | None, error: Exception) -> Outcome:
        """Return the outcome that those who wait here are told, and the store does not know."""
        logger.error("what became of %s could not be written: %s", claim.document.id, error)
        document = claim.document
        if problem is not None:
            document = replace(
                document, state="failed", finished=now(), problem=problem.to_mapping()
            )
        return Outcome("unwritten", document)

    def _problem_of(self, event: dict[str, Any]) -> Problem | None:
        """Return what the process found wrong; None if it has built the gamut."""
        if event["event"] == "refused":
            return Problem(
                event["code"],
                sentence(event["message"]),
                where=event["where"],
                remedy=sentence(event["remedy"]),
            )
        if event["event"] == "exhausted":
            return self._memory_problem()
        if event["event"] == "failed":
            return _failure_problem(event["errno"])
        return None

    def _renew_if_swollen(self, process: BuildProcess) -> None:
        """End a process that a large build has left large, so that the next one has its due."""
        limit, in_use, idle = (
            self._settings.build_memory_bytes,
            process.private_bytes(),
            process.idle_bytes,
        )
        if not limit or in_use is None or idle is None:
            return
        if in_use > (idle + limit) / 2:
            logger.info("build worker %d keeps %d bytes and is replaced", process.pid, in_use)
            self.close()

    def _known(self, job_id: str) -> JobDocument | None:
        with contextlib.suppress(OSError, StoreUnavailableError):
            return self._book.read(job_id)
        return None

    def _report(self, outcome: str, seconds: dict[str, float], document: JobDocument) -> None:
        if self._on_build is not None:
            self._on_build(outcome, seconds, document)

    def _timeout_problem(self) -> Problem:
        return Problem(
            "build-timeout",
            f"The build was ended after {self._settings.build_timeout:g} s.",
            where={"field": "surface_samples"},
        )

    def _memory_problem(self) -> Problem:
        return Problem(
            "build-out-of-memory",
            "The build was ended because it took more than "
            f"{self._settings.build_memory_bytes} bytes of memory.",
            where={"field": "surface_samples"},
        )


def _failure_problem(number: int | None) -> Problem:
    """Return the problem of a build that failed with an error number of the system, or none."""
    problem = Problem.from_errno(number)
    return problem or Problem("build-failed", "The build ended with an unexpected error.")


def _is_of_the_service(problem: Problem) -> bool:
    """Whether a build failed for something that an operator mends: a full store, a bad disk."""
    return problem.kind.status >= 500


def _ignored(_document: JobDocument) -> None:
    """Take no notice."""
