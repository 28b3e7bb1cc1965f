"""Job runner: one job at a time with one worker process: claim, input, build, publish, finish.

The slots of `service.building.embedded` and the workers of a broker use the same runner. Its state
comes from the store and goes back to the store. All methods block.
"""

from __future__ import annotations

import contextlib
import logging
import os
import secrets
import socket
import time
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from service.building.lease_renewer import LeaseRenewer
from service.building.process import (
    WORKER_COMMAND,
    BuildProcess,
    BuildTimeoutError,
    MemoryExceededError,
    ProcessDiedError,
)
from service.jobs.book import JobCancelledError, JobDocument, LeaseLostError, now
from service.openapi.models import StoredDescription
from service.problems.problem import Problem, sentence
from service.storage.blobs import BlobNotFoundError, StoreUnavailableError
from service.storage.published import PublishedGamut

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from pathlib import Path

    from service.building.engine import BuildReport
    from service.jobs.book import Claim, JobBook
    from service.settings import Settings
    from service.storage.gamuts import GamutStore

__all__ = [
    "HEARTBEAT_SECONDS",
    "LEASE_SECONDS",
    "Interrupted",
    "Interruption",
    "JobRunner",
    "Outcome",
    "owner_name",
]

logger = logging.getLogger(__name__)

LEASE_SECONDS = 20.0
"""Validity of a claim without renewal, which is the delay after the loss of a host."""

HEARTBEAT_SECONDS = 4.0
"""Interval of renewals, if the progress is also known from memory."""


def owner_name() -> str:
    """Return a unique name for a builder: host, process id and random digits (the others recur)."""
    return f"{socket.gethostname()}:{os.getpid()}:{secrets.token_hex(4)}"


class Interrupted(Exception):  # noqa: N818 - not an error
    """A build was told to end.

    The reason ``cancel`` means that the build is not wanted any more, and ``release`` that another
    builder takes over.
    """

    def __init__(self, reason: Literal["cancel", "release"]) -> None:
        super().__init__(reason)
        self.reason = reason


class Interruption:
    """A signal from another thread that a build checks regularly."""

    def __init__(self) -> None:
        self._reason: Literal["cancel", "release"] | None = None

    def cancel(self) -> None:
        """End the build because it is not wanted any more."""
        self._reason = "cancel"

    def release(self) -> None:
        """Hand the build over to another builder. A cancelled build stays cancelled."""
        self._reason = self._reason or "release"

    def check(self) -> None:
        """Raise `Interrupted` if the build must end."""
        if self._reason is not None:
            raise Interrupted(self._reason)


@dataclass(frozen=True)
class Outcome:
    """Outcome of running a job.

    Attributes
    ----------
    state
        ``succeeded``, ``failed`` and ``cancelled`` are states of the job. ``released``: the job was
        given back. ``elsewhere``: another builder has the job, or it had ended before.
        ``unwritten``: the store did not accept the result, so the job must run again.
    document
        None if the job is unknown.
    built
        Whether a gamut was built, and not found.
    seconds
        Seconds by stage.
    """

    state: Literal["succeeded", "failed", "cancelled", "released", "elsewhere", "unwritten"]
    document: JobDocument | None
    built: bool = False
    seconds: dict[str, float] = field(default_factory=dict)


class _Built(NamedTuple):
    """Result of one run of the process."""

    problem: Problem | None
    built: bool
    seconds: dict[str, float]


class JobRunner:
    """One worker process that runs jobs; `starts` counts the processes that became warm.

    A claim is valid for `lease` seconds and renewed every `heartbeat` seconds; each renewal stores
    the progress. `on_build` is called at the end of every run of the process.
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
        """The process if it is warm; else None."""
        process = self._process
        return process if process is not None and process.alive else None

    def warm(self, interruption: Interruption | None = None) -> BuildProcess:
        """Return the warm process, after starting it if needed.

        Raise `ProcessDiedError` or OSError if the process cannot be started, and `Interrupted` if
        the start was interrupted.
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

    def run(
        self,
        job_id: str,
        interruption: Interruption | None = None,
        changed: Callable[[JobDocument], None] | None = None,
    ) -> Outcome:
        """Run a job if it can be claimed, and return the outcome.

        `interruption` ends the build from another thread, and `changed` receives the job's progress
        in this thread. `ProcessDiedError`, OSError and `StoreUnavailableError` mean that the job
        was not claimed.
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
            outcome = self._attempt(claim, interruption, changed or _ignore)
            if outcome is not None:
                return outcome

    def _attempt(
        self,
        claim: Claim,
        interruption: Interruption,
        changed: Callable[[JobDocument], None],
    ) -> Outcome | None:
        """Return the outcome of one attempt; None if the process died and attempts are left."""
        document = claim.document
        logger.info("build of %s started, attempt %d", document.id, document.attempts)
        clock = time.monotonic()
        renewer = LeaseRenewer(self._book, claim, self._heartbeat)
        try:
            with renewer:
                result = self._build(renewer, interruption, changed)
            return self._finish(renewer.claim, result, time.monotonic() - clock)
        except Interrupted as interrupted:
            return self._handle_interruption(renewer.claim, interrupted, time.monotonic() - clock)
        except JobCancelledError:
            return self._record_cancellation(document, time.monotonic() - clock)
        except LeaseLostError:
            logger.warning("build of %s: another builder has the job", document.id)
            return Outcome("elsewhere", self._read_job(document.id))
        except ProcessDiedError as error:
            logger.warning("worker died during the build of %s: %s", document.id, error)
            self._report("crashed", {"total": time.monotonic() - clock}, document)
            problem = Problem(
                "build-crashed",
                f"The process that built this gamut died, {document.attempts} times in a row "
                f"(the last time: {error}).",
            )
            return self._record_failure(renewer.claim, problem)
        except StoreUnavailableError as error:
            logger.warning("build of %s: the store is unavailable: %s", document.id, error)
            return self._record_failure(renewer.claim, Problem.store_unavailable())

    def _build(
        self,
        renewer: LeaseRenewer,
        interruption: Interruption,
        changed: Callable[[JobDocument], None],
    ) -> _Built:
        """Build a claimed job, publish the gamut, and return the result."""
        job_id = renewer.document.id
        scratch: list[Path] = []

        def check() -> None:
            interruption.check()
            renewer.check()

        def progress(stage: str, fraction: float) -> None:
            renewer.note(stage, fraction)
            changed(renewer.document)

        try:
            # An identical request may have ended since this one looked into the store.
            if self._store.is_stored(job_id):
                return _Built(None, False, {})
            try:
                source = self._store.input_path(job_id)
            except BlobNotFoundError:
                detail = "The data for this gamut is not stored any more."
                return _Built(Problem("build-input-lost", detail), False, {})
            scratch += [source, self._store.scratch(".gamut")]
            process = self.warm(interruption)
            limits = self._settings.data_limits
            event = process.result(
                {
                    "id": job_id,
                    "input": str(scratch[0]),
                    "output": str(scratch[1]),
                    "options": renewer.document.options,
                    "limits": {"samples": limits.samples, "pixels": limits.pixels},
                    "memory": self._settings.build_memory_bytes,
                    "seconds": self._settings.build_timeout,
                },
                timeout=self._settings.build_timeout,
                progress=progress,
                check=check,
            )
            self._replace_if_large(process)
            problem = self._problem_of(event)
            if problem is None:
                check()
                description = event["description"]
                StoredDescription.model_validate(description)
                record = PublishedGamut(
                    job_id, event["sha256"], event["nbytes"], now(), description
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
            # Only this build may fail: neither the process nor the waiters of the job.
            problem = _failure_problem(
                getattr(error, "errno", None), remote=self._store.blobs.remote
            )
            if _is_service_fault(problem):
                logger.warning(
                    "build of %s failed, the store or the machine refused: %s", job_id, error
                )
            else:
                logger.exception("build of %s ended unexpectedly", job_id)
            return _Built(problem, False, {})
        finally:
            # Temporary files of a worker that was ended begin with the name of the output.
            left = [each for path in scratch[1:] for each in path.parent.glob(f"{path.name}.*")]
            for path in [*scratch, *left]:
                # Leftover files are removed at the next start.
                with contextlib.suppress(OSError):
                    path.unlink(missing_ok=True)

    def _finish(self, claim: Claim, result: _Built, seconds: float) -> Outcome:
        """Store the result of a build that ended by itself, and return the outcome."""
        job_id, problem = claim.document.id, result.problem
        state: Literal["succeeded", "failed"] = "succeeded" if problem is None else "failed"
        result_name = state if problem is None else f"failed ({problem.code})"
        logger.info("build of %s %s after %.2f s", job_id, result_name, seconds)
        if result.built or problem is not None:
            self._report(
                state if problem is None else problem.code,
                {**result.seconds, "total": seconds},
                claim.document,
            )
        try:
            if problem is not None:
                # Before the end of the job, because its input may then belong to a new job.
                claim = self._book.heartbeat(claim, claim.document.stage, claim.document.fraction)
                # If the data is not at fault, another attempt with the same data may succeed.
                if not _is_service_fault(problem):
                    self._store.drop_input(job_id)
            document = self._book.finish(claim, state, problem)
        except (OSError, StoreUnavailableError) as error:
            return self._unwritten(claim, problem, error)
        return Outcome(state, document, result.built, result.seconds)

    def _handle_interruption(
        self, claim: Claim, interrupted: Interrupted, seconds: float
    ) -> Outcome:
        if interrupted.reason == "cancel":
            return self._record_cancellation(claim.document, seconds)
        logger.info("build of %s is given back", claim.document.id)
        try:
            return Outcome("released", self._book.release(claim))
        except LeaseLostError:
            return Outcome("elsewhere", self._read_job(claim.document.id))
        except (OSError, StoreUnavailableError) as error:
            return self._unwritten(claim, None, error)

    def _record_cancellation(self, document: JobDocument, seconds: float) -> Outcome:
        logger.info("build of %s cancelled after %.2f s", document.id, seconds)
        self._report("cancelled", {"total": seconds}, document)
        return Outcome("cancelled", self._read_job(document.id))

    def _record_failure(self, claim: Claim, problem: Problem) -> Outcome | None:
        """Record a failed attempt; return the outcome, or None if another attempt is left."""
        try:
            document = self._book.record_crash(claim, problem)
        except LeaseLostError:
            return Outcome("elsewhere", self._read_job(claim.document.id))
        except (OSError, StoreUnavailableError) as error:
            return self._unwritten(claim, problem, error)
        if not document.final:
            return None
        logger.warning("build of %s failed finally (%s)", document.id, problem.code)
        self._report(problem.code, {}, document)
        return Outcome("failed", document)

    def _unwritten(self, claim: Claim, problem: Problem | None, error: Exception) -> Outcome:
        """Return the outcome for local waiters; the store does not have it."""
        logger.error("the result of %s could not be stored: %s", claim.document.id, error)
        document = claim.document
        if problem is not None:
            document = replace(
                document, state="failed", finished=now(), problem=problem.to_mapping()
            )
        return Outcome("unwritten", document)

    def _problem_of(self, event: dict[str, Any]) -> Problem | None:
        """Return the problem that the process reported; None if it built the gamut."""
        if event["event"] == "refused":
            return Problem(
                event["code"],
                sentence(event["message"]),
                where=event["where"],
                remedy=event["remedy"],
            )
        if event["event"] == "exhausted":
            return self._memory_problem()
        if event["event"] == "failed":
            return _failure_problem(event["errno"], remote=self._store.blobs.remote)
        if event["event"] == "outdated":
            return Problem(
                "build-outdated",
                "The job was accepted under another version of the algorithm, whose gamuts this "
                "version cannot build.",
            )
        return None

    def _replace_if_large(self, process: BuildProcess) -> None:
        """End a process that keeps much memory, so that the next build has its full limit."""
        limit, in_use, idle = (
            self._settings.build_memory_bytes,
            process.private_bytes(),
            process.idle_bytes,
        )
        if not limit or in_use is None or idle is None:
            return
        if in_use > (idle + limit) / 2:
            logger.info("build worker %d still uses %d bytes and is replaced", process.pid, in_use)
            self.close()

    def _read_job(self, job_id: str) -> JobDocument | None:
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
            "The build was ended because it used more than "
            f"{self._settings.build_memory_bytes} bytes of memory.",
            where={"field": "surface_samples"},
        )


def _failure_problem(number: int | None, *, remote: bool) -> Problem:
    """Return the problem for a system error number, or for none."""
    problem = Problem.from_errno(number, remote=remote)
    return problem or Problem("build-failed", "The build ended with an unexpected error.")


def _is_service_fault(problem: Problem) -> bool:
    """Return whether an operator must fix the cause, such as a full or broken disk."""
    return problem.kind.status >= 500


def _ignore(_document: JobDocument) -> None:
    """Ignore a change."""
