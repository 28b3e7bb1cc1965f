"""Job runner: one job at a time with one worker process: claim, input, build, publish, finish.

The builders of `service.building.local_engine` and the workers of a broker use the same runner. Its
state comes from the store and goes back to the store. All methods block.
"""

from __future__ import annotations

import contextlib
import logging
import os
import secrets
import socket
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, Self

from gamutcore.limits import Limits
from service.building.engine import BuildReport
from service.building.process import WORKER_COMMAND, BuildProcess, ProcessDiedError
from service.jobs.book import Claim, JobBook, JobCancelledError, JobDocument, LeaseLostError, now
from service.openapi.models import StoredDescription
from service.problems.problem import Problem, sentence
from service.settings import Settings
from service.storage.blobs import BlobNotFoundError, StoreUnavailableError
from service.storage.gamut_store import GamutStore
from service.storage.published import PublishedGamut

__all__ = ["LEASE_SECONDS", "Interrupted", "Interruption", "JobRunner", "Outcome"]

logger = logging.getLogger(__name__)

LEASE_SECONDS = 20.0
"""Validity of a claim without renewal, which is the delay after the loss of a host. If a bucket
does not answer a renewal, four attempts take 18.6 s (`service.storage.cloud`), which is in time."""

_HEARTBEAT_SECONDS = 4.0
"""Interval of renewals, if the progress is also known from memory."""


class Interrupted(Exception):  # noqa: N818 - not an error
    """A build was told to end, so that another builder takes over."""


class Interruption:
    """A signal from another thread that a build checks regularly."""

    def __init__(self) -> None:
        self._cancelled = self._released = False

    def cancel(self) -> None:
        """End the build because it is not wanted any more."""
        self._cancelled = True

    def release(self) -> None:
        """Hand the build over to another builder. A cancelled build stays cancelled."""
        self._released = True

    def check(self) -> None:
        """Raise `JobCancelledError` or `Interrupted` if the build must end."""
        if self._cancelled:
            raise JobCancelledError
        if self._released:
            raise Interrupted


@dataclass(frozen=True)
class Outcome:
    """Outcome of running a job. `document` is None if the job is unknown.

    ``succeeded``, ``failed`` and ``cancelled`` are states of the job. ``released``: the job was
    given back. ``elsewhere``: another builder has the job, or it had ended before. ``unwritten``:
    the store did not accept the result, so the job must run again. `built` tells whether a gamut
    was built, and not found.
    """

    state: Literal["succeeded", "failed", "cancelled", "released", "elsewhere", "unwritten"]
    document: JobDocument | None
    built: bool = False


class _HeldClaim:
    """A claim that a thread renews every `interval` seconds inside a context, with the progress.

    The building thread cannot renew it, because a download may last longer than a lease. Several
    intervals must fit into a lease.
    """

    def __init__(
        self,
        book: JobBook,
        claim: Claim,
        interval: float,
        interruption: Interruption,
        changed: Callable[[JobDocument], None],
    ) -> None:
        self._book = book
        self._claim = claim
        self._interval = interval
        self._interruption = interruption
        self._changed = changed
        self._stage, self._fraction = claim.document.stage, claim.document.fraction
        self.gamut = ""
        """Id of the gamut that was built, if it is not that of the job."""
        self._lost: LeaseLostError | None = None
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._renew, name="lease renewer", daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_error: object) -> None:
        self._ended.set()
        self._thread.join()

    @property
    def document(self) -> JobDocument:
        """The job with its newest progress, stored or not."""
        return replace(self._claim.document, stage=self._stage, fraction=self._fraction)

    @property
    def claim(self) -> Claim:
        """The newest claim, for use after the context."""
        return replace(self._claim, document=self.document)

    def progress(self, stage: str, fraction: float) -> None:
        """Report the progress. The next renewal stores it."""
        self._stage, self._fraction = stage, fraction
        self._changed(self.document)

    def check(self) -> None:
        """Raise an exception if the build must end: an interruption, or `LeaseLostError`."""
        self._interruption.check()
        if self._lost is not None:
            raise self._lost

    def _renew(self) -> None:
        while not self._ended.wait(self._interval):
            try:
                self._claim = self._book.heartbeat(self._claim, self._stage, self._fraction)
            except LeaseLostError as error:
                self._lost = error
                return
            except (OSError, StoreUnavailableError) as error:
                # A lease has room for more renewals. If all fail, another builder takes over.
                logger.warning("lease of %s was not renewed: %s", self.document.id, error)


class JobRunner:
    """One worker process that runs jobs; `starts` counts the processes that became warm.

    A claim is valid for `LEASE_SECONDS` and renewed every `heartbeat` seconds; each renewal stores
    the progress. `on_build` is called at the end of every run of the process.
    """

    def __init__(
        self,
        settings: Settings,
        store: GamutStore,
        book: JobBook,
        *,
        heartbeat: float = _HEARTBEAT_SECONDS,
        command: Sequence[str] = WORKER_COMMAND,
        on_build: BuildReport | None = None,
    ) -> None:
        self._settings = settings
        self._store = store
        self._book = book
        self._heartbeat = heartbeat
        self._command = command
        self._report: BuildReport = on_build or (lambda *_: None)
        self._problems = _build_problems(settings)
        self._process: BuildProcess | None = None
        # Host and process id recur.
        self.owner = f"{socket.gethostname()}:{os.getpid()}:{secrets.token_hex(4)}"
        self.starts = 0

    @property
    def process(self) -> BuildProcess | None:
        """The process if it is warm; else None."""
        process = self._process
        return process if process is not None and process.alive else None

    def warm(self, check: Callable[[], None] = lambda: None) -> BuildProcess:
        """Return the warm process, after starting it if needed. An exception of `check` ends it.

        Raise `ProcessDiedError` or OSError if the process cannot be started.
        """
        process = self.process
        if process is None:
            self.close()
            process = BuildProcess(self._command)
            process.wait_until_ready(check)
            self._process = process
            self.starts += 1
            logger.info("build worker %d is warm", process.pid)
        return process

    def close(self) -> None:
        """End the process."""
        if self._process is not None:
            self._process.kill()
            self._process = None

    def run(
        self,
        job_id: str,
        interruption: Interruption | None = None,
        changed: Callable[[JobDocument], None] = lambda _: None,
    ) -> Outcome:
        """Run a job if it can be claimed, and return the outcome.

        `interruption` ends the build from another thread, and `changed` receives the job's progress
        in this thread. `ProcessDiedError`, OSError and `StoreUnavailableError` mean that the job
        was not claimed.
        """
        interruption = interruption or Interruption()
        while True:
            try:
                self.warm(interruption.check)
            except (Interrupted, JobCancelledError):
                return Outcome("released", self._book.read(job_id))
            claim = self._book.claim(job_id, self.owner, LEASE_SECONDS)
            if claim is None:
                return Outcome("elsewhere", self._book.read(job_id))
            changed(claim.document)
            outcome = self._attempt(claim, interruption, changed)
            if outcome is not None:
                return outcome

    def _attempt(
        self, claim: Claim, interruption: Interruption, changed: Callable[[JobDocument], None]
    ) -> Outcome | None:
        """Return the outcome of one attempt; None if the process died and attempts are left."""
        document = claim.document
        logger.info("build of %s started, attempt %d", document.id, document.attempts)
        clock = time.monotonic()
        held = _HeldClaim(self._book, claim, self._heartbeat, interruption, changed)
        try:
            with held:
                problem, stages = self._build(held)
            seconds = time.monotonic() - clock
            return self._finish(held.claim, problem, stages, seconds, held.gamut)
        except Interrupted:
            logger.info("build of %s is given back", document.id)
            return self._give_back(held.claim, None)
        except JobCancelledError:
            seconds = time.monotonic() - clock
            logger.info("build of %s cancelled after %.2f s", document.id, seconds)
            self._report("cancelled", {"total": seconds})
            return Outcome("cancelled", self._read_job(document.id))
        except LeaseLostError:
            logger.warning("build of %s: another builder has the job", document.id)
            return Outcome("elsewhere", self._read_job(document.id))
        except ProcessDiedError as error:
            logger.warning("worker died during the build of %s: %s", document.id, error)
            self._report("crashed", {"total": time.monotonic() - clock})
            problem = Problem(
                "build-crashed",
                f"The process that built this gamut died, {document.attempts} times in a row "
                f"(the last time: {error}).",
            )
            return self._give_back(held.claim, problem)
        except StoreUnavailableError as error:
            logger.warning("build of %s: the store is unavailable: %s", document.id, error)
            return self._give_back(held.claim, Problem.store_unavailable())

    def _build(self, held: _HeldClaim) -> tuple[Problem | None, dict[str, float] | None]:
        """Build a claimed job and publish the gamut.

        Return the problem, if any, and the seconds by stage: None if the gamut was stored already.
        A job of another version of the algorithm gets the gamut of this version, whose id
        `held.gamut` is then.
        """
        job_id = held.document.id
        scratch: list[Path] = []
        try:
            # An identical request may have ended since this one looked into the store.
            if self._store.is_stored(job_id):
                return None, None
            try:
                source = self._store.input_path(job_id)
            except BlobNotFoundError:
                detail = "The data for this gamut is not stored any more."
                return Problem("build-input-lost", detail), {}
            scratch.append(source)
            output = self._store.scratch(".gamut")
            scratch.append(output)
            limits = Limits()
            request = {
                "id": job_id,
                "input": str(source),
                "output": str(output),
                "options": held.document.options,
                "limits": {"samples": limits.samples, "pixels": limits.pixels},
                "memory": self._settings.build_memory_bytes,
                "seconds": self._settings.build_timeout,
            }
            process = self.warm(held.check)
            event = process.result(request, progress=held.progress, check=held.check)
            problem = self._problem_of(event)
            if problem is None:
                held.check()
                description = event["description"]
                StoredDescription.model_validate(description)
                held.gamut = event.get("id", "")
                record = PublishedGamut(
                    held.gamut or job_id, event["sha256"], event["nbytes"], now(), description
                )
                if held.gamut:
                    self._store.copy_submission(job_id, held.gamut)
                self._store.publish(record, output)
            return problem, event.get("seconds", {})
        except (Interrupted, LeaseLostError, ProcessDiedError, StoreUnavailableError):
            raise
        except Exception as error:
            # Only this build may fail: neither the process nor the waiters of the job.
            problem = self._failure(getattr(error, "errno", None))
            if _is_service_fault(problem):
                message = "build of %s failed, the store or the machine refused: %s"
                logger.warning(message, job_id, error)
            else:
                logger.exception("build of %s ended unexpectedly", job_id)
            return problem, {}
        finally:
            # Temporary files of a worker that was ended begin with the name of the output.
            left = [each for path in scratch[1:] for each in path.parent.glob(f"{path.name}.*")]
            for path in [*scratch, *left]:
                # Leftover files are removed at the next start.
                with contextlib.suppress(OSError):
                    path.unlink(missing_ok=True)

    def _finish(
        self,
        claim: Claim,
        problem: Problem | None,
        stages: dict[str, float] | None,
        seconds: float,
        gamut: str,
    ) -> Outcome:
        """Store the result of a build that ended by itself, and return the outcome."""
        job_id = claim.document.id
        state: Literal["succeeded", "failed"] = "succeeded" if problem is None else "failed"
        result_name = state if problem is None else f"failed ({problem.code})"
        logger.info("build of %s %s after %.2f s", job_id, result_name, seconds)
        if stages is not None:
            word = state if problem is None else problem.code
            self._report(word, {**stages, "total": seconds})
        try:
            if problem is not None:
                # Before the end of the job, because its input may then belong to a new job.
                claim = self._book.heartbeat(claim, claim.document.stage, claim.document.fraction)
                # If the data is not at fault, another attempt with the same data may succeed.
                if not _is_service_fault(problem):
                    self._store.drop_input(job_id)
            document = self._book.finish(claim, state, problem, gamut)
            if gamut:
                self._store.drop_submission(job_id)
        except (OSError, StoreUnavailableError) as error:
            return self._unwritten(claim, problem, error)
        return Outcome(state, document, problem is None and stages is not None)

    def _give_back(self, claim: Claim, problem: Problem | None) -> Outcome | None:
        """Queue a job again: it is handed over, or its attempt failed with a problem.

        Return the outcome, or None if another attempt is left for this runner.
        """
        try:
            if problem is None:
                return Outcome("released", self._book.release(claim))
            document = self._book.record_crash(claim, problem)
        except LeaseLostError:
            return Outcome("elsewhere", self._read_job(claim.document.id))
        except (OSError, StoreUnavailableError) as error:
            return self._unwritten(claim, problem, error)
        if not document.final:
            return None
        logger.warning("build of %s failed finally (%s)", document.id, problem.code)
        self._report(problem.code, {})
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
        """Return the problem that an event reports; None if the gamut was built."""
        if event["event"] == "refused":
            message, remedy = sentence(event["message"]), event["remedy"]
            return Problem(event["code"], message, event["where"], remedy)
        if event["event"] == "failed":
            return self._failure(event["errno"])
        return self._problems.get(event["event"])

    def _failure(self, number: int | None) -> Problem:
        """Return the problem for a system error number, or for none."""
        problem = Problem.from_errno(number, remote=self._store.blobs.remote)
        return problem or Problem("build-failed", "The build ended with an unexpected error.")

    def _read_job(self, job_id: str) -> JobDocument | None:
        with contextlib.suppress(OSError, StoreUnavailableError):
            return self._book.read(job_id)
        return None


def _build_problems(settings: Settings) -> dict[str, Problem]:
    """Return the problem of each event that always has the same one."""
    return {
        "timeout": Problem(
            "build-timeout",
            f"The build was ended after {settings.build_timeout:g} s.",
            {"field": "surface_samples"},
        ),
        "exhausted": Problem(
            "build-out-of-memory",
            "The build was ended because it used more than "
            f"{settings.build_memory_bytes} bytes of memory.",
            {"field": "surface_samples"},
        ),
    }


def _is_service_fault(problem: Problem) -> bool:
    """Return whether an operator must fix the cause, such as a full or broken disk."""
    return problem.kind.status >= 500
