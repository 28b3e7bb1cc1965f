"""The truth about jobs: one small document each in the store, changed by compare-and-swap only.

A job has the id of the gamut that it builds, so identical requests meet in it, on every replica.
Whoever builds *claims* the job: the claim carries a fencing token that grows with every claim, and
a lease that has to be renewed. A claim that was lost, because its lease ran out and somebody took
over or because the job was cancelled, can change nothing any more. See ``docs/decisions/jobs.md``.

All methods of `JobBook` block on the store: the event loop calls them in threads.
"""

from __future__ import annotations

import logging
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from itertools import islice
from typing import TYPE_CHECKING, Any, Literal

from service.jobs.documents import UNHEARD, JobDocument, JobState, now, rfc3339
from service.problems.problem import Problem
from service.storage.blobs import BlobDamagedError, BlobNotFoundError, StoreUnavailableError
from service.storage.records import id_of

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping

    from service.storage.blobs import Blobs

__all__ = [
    "ABANDONED_SECONDS",
    "Claim",
    "JobBook",
    "JobCancelledError",
    "JobDocument",
    "JobState",
    "LeaseLostError",
    "now",
]

logger = logging.getLogger(__name__)

ABANDONED_SECONDS = 60.0
"""How long a job may wait without a sign of life before a new request for it has it queued anew:
whoever was to do that may have died in between, and a job that is queued twice is claimed once."""


_REMOVAL_SECONDS = 600.0
"""After which the removal of a forgotten job is given up for dead: longer than a request to delete
can be under way, with all its repetitions."""

_REMOVAL_WAIT = 2.0
"""Seconds that a new request waits for a removal, which takes milliseconds; then it is refused with
``store-unavailable``, and may come again."""

_READERS = 16
"""Documents of a remote store that are read at the same time."""


class LeaseLostError(Exception):
    """A claim is not valid any more: somebody else has the job, or it is over."""


class JobCancelledError(LeaseLostError):
    """A claim is not valid any more, because its job was cancelled."""


@dataclass(frozen=True)
class Claim:
    """The right to do a job, as long as nobody has taken it away.

    Attributes
    ----------
    document : JobDocument
        The job as the claim's last change has left it.
    version : str
        The version of its blob.
    lease : float
        Seconds for which the claim holds without being renewed.
    """

    document: JobDocument
    version: str
    lease: float


class JobBook:
    """The jobs of a deployment.

    Parameters
    ----------
    blobs : Blobs
        Where the documents are, under ``jobs/``.
    attempts : int
        How often a build is started before it is given up.
    clock : callable
        Seconds of the Unix epoch. The hosts of a deployment have to agree on it to within a lease.
    lost_options : callable, optional
        Told the id of a job whose document is damaged, it returns the options that the gamut has
        to be built with all the same; None if there is nothing to build (from).
    on_damaged : callable, optional
        Told the id of a job whose document was damaged, by whoever replaced or removed it: once
        for each damage, however many read it.
    """

    def __init__(
        self,
        blobs: Blobs,
        attempts: int = 3,
        clock: Callable[[], float] = time.time,
        lost_options: Callable[[str], Mapping[str, Any] | None] | None = None,
        on_damaged: Callable[[str], None] | None = None,
    ) -> None:
        self._blobs = blobs
        self._attempts = attempts
        self._clock = clock
        self._lost_options = lost_options
        self._on_damaged = on_damaged or (lambda _: None)

    def accept(
        self, job_id: str, options: Mapping[str, Any], trace: Mapping[str, str] | None = None
    ) -> tuple[JobDocument, bool]:
        """Return the job that builds a gamut: the one under way, else a new one.

        Returns
        -------
        document : JobDocument
            Queued or running.
        new : bool
            Whether the caller has to queue it: it is new, or whoever was to build it is gone.
        """
        while True:
            time_ = self._now()
            fresh = JobDocument(
                job_id, dict(options), created=time_, updated=time_, trace=dict(trace or {})
            )
            found = self._found(job_id)
            if found is None:
                if self._blobs.create(_key(job_id), fresh.to_bytes()) is not None:
                    return fresh, True
                instead = self._instead_of_forgotten(fresh)
                if instead is not None:
                    return instead, True
                continue
            document, version = found
            if not document.final:
                return document, self._abandoned(document, ABANDONED_SECONDS)
            # The token goes on, so that whoever was late with the old build stays fenced off.
            renewed = replace(fresh, token=document.token)
            if self._replace(renewed, version) is not None:
                return renewed, True

    def read(self, job_id: str) -> JobDocument | None:
        """Return a job; None if there is none."""
        found = self._found(job_id)
        return None if found is None else found[0]

    def claim(self, job_id: str, owner: str, lease: float) -> Claim | None:
        """Return the right to do a job, if it is to be had; it counts as an attempt.

        A job that was attempted as often as allowed, without an end, fails here.

        Parameters
        ----------
        job_id : str
            Which job.
        owner : str
            Who asks.
        lease : float
            Seconds until the claim ends unless it is renewed.

        Returns
        -------
        Claim or None
            None if the job is over or unknown, or if somebody else's lease holds.
        """
        while True:
            found = self._found(job_id)
            if found is None or found[0].final:
                return None
            document, version = found
            if document.state == "running" and (document.lease_until or 0.0) > self._clock():
                return None
            if document.attempts >= self._attempts:
                self._replace(self._given_up(document, None), version)
                continue
            time_ = self._now()
            claimed = replace(
                document,
                state="running",
                stage="",
                fraction=0.0,
                attempts=document.attempts + 1,
                updated=time_,
                started=document.started or time_,
                owner=owner,
                token=document.token + 1,
                lease_until=self._clock() + lease,
            )
            new_version = self._replace(claimed, version)
            if new_version is not None:
                return Claim(claimed, new_version, lease)

    def heartbeat(self, claim: Claim, stage: str, fraction: float) -> Claim:
        """Return the claim, renewed, after writing down how far the build is.

        Raises
        ------
        JobCancelledError
            The job was cancelled.
        LeaseLostError
            Somebody else has the job.
        """
        return self._changed(
            claim,
            replace(
                claim.document,
                stage=stage,
                fraction=fraction,
                updated=self._now(),
                lease_until=self._clock() + claim.lease,
            ),
        )

    def finish(
        self, claim: Claim, state: Literal["succeeded", "failed"], problem: Problem | None = None
    ) -> JobDocument:
        """Return the job, ended; `LeaseLostError` if the claim was lost."""
        document = self._ended(claim.document, state, problem)
        return self._changed(claim, document).document

    def crashed(self, claim: Claim, problem: Problem) -> JobDocument:
        """Return the job whose process died: queued again, or failed after the last attempt.

        Raises
        ------
        LeaseLostError
            The claim was lost.
        """
        document = claim.document
        if document.attempts >= self._attempts:
            return self._changed(claim, self._given_up(document, problem)).document
        return self._changed(claim, self._queued(document, document.attempts)).document

    def release(self, claim: Claim) -> JobDocument:
        """Return the job, given back unfinished: queued again, and not counted as an attempt.

        Raises
        ------
        LeaseLostError
            The claim was lost.
        """
        document = claim.document
        return self._changed(claim, self._queued(document, document.attempts - 1)).document

    def request_cancel(self, job_id: str) -> JobDocument | None:
        """Return the job, cancelled unless it was over; None if there is none.

        Whoever is building it learns of it with the next heartbeat, and can change nothing.
        """
        detail = "The build was cancelled before it was finished."
        problem = Problem("build-cancelled", detail)
        return self._ended_while(("queued", "running"), job_id, "cancelled", problem)

    def withdraw(self, job_id: str, problem: Problem) -> JobDocument | None:
        """Return the job, failed if nobody had begun it: what it needs could not be stored."""
        return self._ended_while(("queued",), job_id, "failed", problem)

    def requeue(self, job_id: str, token: int) -> JobDocument | None:
        """Return the job, queued again if this claim has it: its owner is known to be gone.

        Only for a store that belongs to one process, at its start: everybody else waits for the
        lease to end. The attempt stays counted, so an input that takes the whole service down is
        given up as well.
        """
        while True:
            found = self._found(job_id)
            if found is None or found[0].state != "running" or found[0].token != token:
                return None if found is None else found[0]
            changed = self._queued_or_given_up(found[0])
            if self._replace(changed, found[1]) is not None:
                return changed

    def revived(self, job_id: str, silence: float) -> JobDocument | None:
        """Return a job that was lost, queued anew; the caller, and nobody else, has to send it.

        Lost is a running one whose lease has ended, and a queued one of which nothing was heard
        for `silence` seconds. None if it is not lost, if somebody else has just revived it, or if
        it was attempted as often as allowed, and has failed now.
        """
        found = self._found(job_id)
        if found is None or found[0].final or not self._abandoned(found[0], silence):
            return None
        changed = self._queued_or_given_up(found[0])
        if self._replace(changed, found[1]) is None or changed.final:
            return None
        return changed

    def unfinished(self) -> Iterator[JobDocument]:
        """Iterate over the jobs that are queued or running."""
        for document in self._documents(""):
            if not document.final:
                yield document

    def page(self, after: str, limit: int) -> list[JobDocument]:
        """Return up to `limit` jobs in the order of their ids, from the first after `after`."""
        return list(islice(self._documents(after), limit))

    def forget_finished(self, older_than: float) -> list[str]:
        """Remove the jobs that were over `older_than` seconds ago, and return their ids.

        A blob cannot be removed by compare-and-swap. So it is first marked as forgotten, which can:
        who renewed the job before is seen, and who wants to afterwards waits until it is removed.
        """
        limit = rfc3339(self._clock() - older_than)
        forgotten = []
        for key in self._blobs.keys("jobs/"):
            job_id = id_of(key)
            found = self._kept(job_id)
            if found is None:
                continue
            document, version = found
            over = document.final and (document.finished or "") < limit
            if not over and not self._removal_given_up(document):
                continue
            mark = replace(document, state="forgotten", updated=self._now())
            if self._replace(mark, version) is not None:
                self._blobs.delete(key)
                forgotten.append(job_id)
        return forgotten

    def _removal_given_up(self, document: JobDocument) -> bool:
        """Whether a job was to be removed by somebody who cannot do it any more."""
        limit = rfc3339(self._clock() - _REMOVAL_SECONDS)
        return document.state == "forgotten" and document.updated < limit

    def _instead_of_forgotten(self, fresh: JobDocument) -> JobDocument | None:
        """Return a job that took the place of a forgotten one; None if that is removed (by now)."""
        deadline = time.monotonic() + _REMOVAL_WAIT
        while (found := self._kept(fresh.id)) is not None and found[0].state == "forgotten":
            document, version = found
            if self._removal_given_up(document):
                renewed = replace(fresh, token=document.token)
                return None if self._replace(renewed, version) is None else renewed
            if time.monotonic() > deadline:
                message = f"the job {fresh.id} is being removed"
                raise StoreUnavailableError(message)
            time.sleep(0.02)
        return None

    def _documents(self, after: str) -> Iterator[JobDocument]:
        """Iterate over the jobs after one, several being read at a time where that takes long."""
        keys = iter(self._blobs.keys("jobs/", _key(after) if after else ""))
        readers = _READERS if self._blobs.remote else 1
        with ThreadPoolExecutor(readers, thread_name_prefix="jobs") as threads:
            while batch := [id_of(key) for key in islice(keys, readers)]:
                found = threads.map(self.read, batch) if readers > 1 else map(self.read, batch)
                yield from (document for document in found if document is not None)

    def _found(self, job_id: str) -> tuple[JobDocument, str] | None:
        found = self._kept(job_id)
        return None if found is None or found[0].state == "forgotten" else found

    def _kept(self, job_id: str) -> tuple[JobDocument, str] | None:
        """Return the document and its version, forgotten or not; None if there is none."""
        while True:
            try:
                blob = self._blobs.read(_key(job_id))
            except BlobNotFoundError:
                return None
            try:
                return JobDocument.from_bytes(blob.data), blob.version
            except (BlobDamagedError, TypeError) as error:
                logger.error("the document of job %s is damaged: %s", job_id, error)  # noqa: TRY400 - no defect
            options = None if self._lost_options is None else self._lost_options(job_id)
            if options is None:
                # What it was about cannot be told any more; whoever wants the gamut posts again.
                if self._blobs.delete(_key(job_id)):
                    self._on_damaged(job_id)
                return None
            # A token greater than any before fences off whoever had claimed the damaged one.
            token = int(1000 * self._clock())
            fresh = JobDocument(
                job_id, dict(options), created=self._now(), updated=UNHEARD, token=token
            )
            version = self._replace(fresh, blob.version)
            if version is not None:
                self._on_damaged(job_id)
                logger.warning("job %s is queued anew, from the input that is kept", job_id)
                return fresh, version

    def _replace(self, document: JobDocument, version: str) -> str | None:
        return self._blobs.replace(_key(document.id), document.to_bytes(), version)

    def _changed(self, claim: Claim, document: JobDocument) -> Claim:
        """Return the claim after its document was changed, if it still holds."""
        version: str | None = claim.version
        while version is not None:
            new_version = self._replace(document, version)
            if new_version is not None:
                return replace(claim, document=document, version=new_version)
            version = self._version_of(claim, refused=version)
        raise LeaseLostError(claim.document.id)

    def _version_of(self, claim: Claim, refused: str) -> str | None:
        """Return the version of a claim's document if the claim holds, after a refused change.

        A change may have been made and its answer lost on the way; then the document is the
        claim's own in another version.
        """
        found = self._found(claim.document.id)
        if found is None:
            return None
        document, version = found
        if document.state == "cancelled" and document.token == claim.document.token:
            raise JobCancelledError(document.id)
        if document.state != "running" or document.token != claim.document.token:
            return None
        return None if version == refused else version

    def _queued_or_given_up(self, document: JobDocument) -> JobDocument:
        """Return a job whose owner is gone, to be begun anew unless that was the last attempt."""
        if document.state == "running" and document.attempts >= self._attempts:
            return self._given_up(document, None)
        return self._queued(document, document.attempts)

    def _queued(self, document: JobDocument, attempts: int) -> JobDocument:
        return replace(
            document,
            state="queued",
            stage="",
            fraction=0.0,
            attempts=attempts,
            updated=self._now(),
            owner=None,
            lease_until=None,
        )

    def _given_up(self, document: JobDocument, problem: Problem | None) -> JobDocument:
        return self._ended(
            document,
            "failed",
            problem
            or Problem(
                "build-crashed",
                f"Whoever built this gamut died in the middle, {document.attempts} times.",
            ),
        )

    def _ended(
        self, document: JobDocument, state: JobState, problem: Problem | None
    ) -> JobDocument:
        time_ = self._now()
        return replace(
            document,
            state=state,
            stage="" if state == "succeeded" else document.stage,
            fraction=1.0 if state == "succeeded" else document.fraction,
            updated=time_,
            finished=time_,
            problem=None if problem is None else problem.to_mapping(),
            owner=None,
            lease_until=None,
        )

    def _ended_while(
        self, states: tuple[JobState, ...], job_id: str, state: JobState, problem: Problem
    ) -> JobDocument | None:
        """Return a job, ended if it was in one of these states; None if there is none."""
        while True:
            found = self._found(job_id)
            if found is None or found[0].state not in states:
                return None if found is None else found[0]
            ended = self._ended(found[0], state, problem)
            if self._replace(ended, found[1]) is not None:
                return ended

    def _abandoned(self, document: JobDocument, silence: float) -> bool:
        """Whether nobody has been heard of who would do a job."""
        if document.state == "running":
            return (document.lease_until or 0.0) < self._clock()
        return document.updated < rfc3339(self._clock() - silence)

    def _now(self) -> str:
        return rfc3339(self._clock())


def _key(job_id: str) -> str:
    return f"jobs/{job_id[:2]}/{job_id}.job"
