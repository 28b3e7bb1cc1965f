"""The job book: one document per job in the store, changed by compare-and-swap only.

A job has the id of the gamut that it builds, so identical requests share it on every replica. A
builder *claims* a job. The claim has a fencing token, which grows with every claim, and a lease,
which must be renewed. A lost claim can change nothing. See ``docs/decisions/jobs.md``.

All methods of `JobBook` block on the store; the event loop calls them in threads.
"""

from __future__ import annotations

import hashlib
import json
import logging
import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, fields, replace
from datetime import UTC, datetime
from itertools import islice
from typing import Any, Literal

from service.problems.problem import Problem
from service.storage.blobs import (
    BlobDamagedError,
    BlobNotFoundError,
    Blobs,
    StoreUnavailableError,
    seal,
    unseal,
)
from service.storage.gamut_store import GamutStore
from service.storage.published import id_of

__all__ = [
    "ABANDONED_SECONDS",
    "NEVER_QUEUED",
    "Claim",
    "JobBook",
    "JobCancelledError",
    "JobDocument",
    "JobState",
    "LeaseLostError",
    "client_mark",
    "now",
    "rfc3339",
]

logger = logging.getLogger(__name__)

JobState = Literal["queued", "running", "succeeded", "failed", "cancelled", "forgotten"]

NEVER_QUEUED = "1970-01-01T00:00:00.000Z"
"""Update time of a queued job that no engine has received yet."""

ABANDONED_SECONDS = 60.0
"""Age after which a new request queues a waiting job again. The process that should have queued it
may have died, and a job that is queued twice is claimed once."""

_ATTEMPTS = 3
"""Number of attempts of a build whose process, service or host dies. An input that kills its
builder does so each time; losses of hosts are too rare to hit one build three times."""

_REMOVAL_SECONDS = 600.0
"""Age after which the removal of a forgotten job counts as failed. No delete request lasts longer,
retries included."""

_REMOVAL_WAIT = 2.0
"""Seconds that a new request waits for a removal, which usually takes milliseconds. After that the
request fails with ``store-unavailable``."""

_READERS = 16
"""Number of documents that are read from a remote store at the same time."""


def now() -> str:
    """Return the current time in RFC 3339, UTC, with milliseconds."""
    return rfc3339(time.time())


def rfc3339(seconds: float) -> str:
    """Return a time of the Unix epoch in RFC 3339, UTC, with milliseconds."""
    moment = datetime.fromtimestamp(seconds, UTC)
    return moment.isoformat(timespec="milliseconds").replace("+00:00", "Z")


def client_mark(client: str) -> str:
    """Return 16 bits of a hash of a client's name, by which builds are shared out.

    Clients with the same mark share a turn, which costs little. A mark does not reveal an address.
    """
    return hashlib.sha256(client.encode()).hexdigest()[:4]


@dataclass(frozen=True)
class JobDocument:
    """One build, from acceptance to end.

    Times are in RFC 3339. ``succeeded``, ``failed`` and ``cancelled`` are final states. A
    ``forgotten`` job is about to be removed and counts as absent.
    """

    id: str
    options: dict[str, Any]
    state: JobState = "queued"
    stage: str = ""
    """Stage of `gamutcore`."""
    fraction: float = 0.0
    """Finished part of the stage, 0 to 1."""
    attempts: int = 0
    """Number of starts since the last acceptance."""
    created: str = ""
    updated: str = ""
    started: str | None = None
    finished: str | None = None
    problem: dict[str, Any] | None = None
    """Argument of `Problem.from_mapping`: why the job failed or was cancelled."""
    owner: str | None = None
    """The builder."""
    token: int = 0
    """The builder's fencing token, which grows with every claim."""
    lease_until: float | None = None
    """End of the builder's lease in seconds of the Unix epoch."""
    client: str = ""
    """`client_mark` of the first request's client; empty if it is unknown."""
    gamut: str = ""
    """Id of the gamut, if another version of the algorithm accepted the job; otherwise empty."""

    @property
    def gamut_id(self) -> str:
        """Id of the gamut that the job builds."""
        return self.gamut or self.id

    @property
    def final(self) -> bool:
        """Whether the job has ended. A new request for the gamut may start it again."""
        return self.state in {"succeeded", "failed", "cancelled"}

    def to_bytes(self) -> bytes:
        """Return the document as a blob."""
        return seal(json.dumps(asdict(self), separators=(",", ":")).encode())

    @classmethod
    def from_bytes(cls, data: bytes) -> JobDocument:
        """Return the document in a blob; raises `BlobDamagedError` if it is damaged."""
        values = json.loads(unseal(data))
        names = {each.name for each in fields(cls)}
        # Members of later versions are ignored.
        return cls(**{name: value for name, value in values.items() if name in names})


class LeaseLostError(Exception):
    """The claim is not valid any more: another builder has the job, or the job has ended."""


class JobCancelledError(LeaseLostError):
    """The claim is not valid any more, because the job was cancelled."""


@dataclass(frozen=True)
class Claim:
    """The right to build a job, valid for `lease` seconds without renewal.

    `document` is the job after the claim's last change, and `version` the version of its blob.
    """

    document: JobDocument
    version: str
    lease: float


class JobBook:
    """The jobs of a deployment under ``jobs/``, on hosts whose clocks agree to within a lease.

    For a damaged document, `lost_options` gives the build's options by the job's id, or None if
    there is nothing to build. The process that replaces or removes the document calls `on_damaged`
    with the id.
    """

    def __init__(
        self,
        blobs: Blobs,
        clock: Callable[[], float] = time.time,
        lost_options: Callable[[str], Mapping[str, Any] | None] = lambda _: None,
        on_damaged: Callable[[str], None] = lambda _: None,
    ) -> None:
        self._blobs = blobs
        self._clock = clock
        self._lost_options = lost_options
        self._on_damaged = on_damaged

    @classmethod
    def of_store(cls, store: GamutStore) -> JobBook:
        """Return the jobs of a gamut store, which recovers and counts damaged documents."""
        return cls(
            store.blobs,
            lost_options=store.options_of_damaged_job,
            on_damaged=store.count_damaged_job,
        )

    def accept(
        self,
        job_id: str,
        options: Mapping[str, Any],
        client: str = "",
    ) -> tuple[JobDocument, bool]:
        """Return the job that builds a gamut: the current job, or a new one for a client's mark.

        The second value tells whether the caller must queue the job: it is new, or its builder is
        gone.
        """
        while True:
            time_, options = self._now(), dict(options)
            fresh = JobDocument(job_id, options, created=time_, updated=time_, client=client)
            stored = self._read(job_id)
            if stored is None:
                if self._blobs.create(_key(job_id), fresh.to_bytes()) is not None:
                    return fresh, True
                instead = self._replace_forgotten(fresh)
                if instead is not None:
                    return instead, True
                continue
            document, version = stored
            if not document.final:
                return document, self._is_abandoned(document, ABANDONED_SECONDS)
            # The token keeps growing, which fences off a late builder of the old job.
            renewed = replace(fresh, token=document.token)
            if self._replace(renewed, version) is not None:
                return renewed, True

    def read(self, job_id: str) -> JobDocument | None:
        """Return a job; None if there is none."""
        stored = self._read(job_id)
        return None if stored is None else stored[0]

    def claim(self, job_id: str, owner: str, lease: float) -> Claim | None:
        """Claim a job for `owner`, valid for `lease` seconds without renewal; count an attempt.

        The result is None if the job is unknown or has ended, or if another lease is valid. A job
        without attempts left is marked as failed.
        """
        while True:
            stored = self._read(job_id)
            if stored is None or stored[0].final:
                return None
            document, version = stored
            if document.state == "running" and (document.lease_until or 0.0) > self._clock():
                return None
            if document.attempts >= _ATTEMPTS:
                self._replace(self._give_up(document), version)
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
        """Renew a claim, store the progress, and return the new claim.

        Raise `JobCancelledError` if the job was cancelled, and `LeaseLostError` if another builder
        has it.
        """
        until, document = self._clock() + claim.lease, replace(claim.document, updated=self._now())
        progress = replace(document, stage=stage, fraction=fraction, lease_until=until)
        return self._change(claim, progress)

    def finish(
        self,
        claim: Claim,
        state: Literal["succeeded", "failed"],
        problem: Problem | None = None,
        gamut: str = "",
    ) -> JobDocument:
        """End a job and return it; raises `LeaseLostError` if the claim was lost.

        `gamut` is the id of the gamut, if it is not that of the job.
        """
        ended = replace(self._end(claim.document, state, problem), gamut=gamut)
        return self._change(claim, ended).document

    def record_crash(self, claim: Claim, problem: Problem) -> JobDocument:
        """Queue a job again whose process died, or fail it after the last attempt.

        Raise `LeaseLostError` if the claim was lost.
        """
        return self._change(claim, self._queue_or_give_up(claim.document, problem)).document

    def release(self, claim: Claim) -> JobDocument:
        """Give an unfinished job back: queue it again without counting the attempt.

        Raise `LeaseLostError` if the claim was lost.
        """
        document = claim.document
        return self._change(claim, self._queue_again(document, document.attempts - 1)).document

    def request_cancel(self, job_id: str) -> JobDocument | None:
        """Cancel a job unless it has ended, and return it; None if there is none.

        Its builder notices at the next heartbeat and can change nothing.
        """
        detail = "The build was cancelled before it was finished."
        problem = Problem("build-cancelled", detail)
        return self._update(
            job_id, lambda job: None if job.final else self._end(job, "cancelled", problem)
        )

    def withdraw(self, job_id: str, problem: Problem) -> JobDocument | None:
        """Fail a job that nobody has started, because its input could not be stored."""
        return self._update(
            job_id, lambda job: self._end(job, "failed", problem) if job.state == "queued" else None
        )

    def requeue(self, job_id: str, token: int) -> JobDocument | None:
        """Queue a running job again if it still has this token: its owner is known to be gone.

        Only a store that belongs to one process calls this, at its start. The attempt stays
        counted, so an input that ends the whole service is given up as well.
        """

        def change(job: JobDocument) -> JobDocument | None:
            held = job.state == "running" and job.token == token
            return self._queue_or_give_up(job) if held else None

        return self._update(job_id, change)

    def revive(self, job_id: str, silence: float) -> JobDocument | None:
        """Queue a lost job again; return it to the one caller that must send it, else None.

        A running job is lost when its lease has ended, a queued job after `silence` seconds without
        an update. A lost job without attempts left is failed.
        """
        stored = self._read(job_id)
        if stored is None or stored[0].final or not self._is_abandoned(stored[0], silence):
            return None
        changed = self._queue_or_give_up(stored[0])
        if self._replace(changed, stored[1]) is None or changed.final:
            return None
        return changed

    def unfinished(self) -> Iterator[JobDocument]:
        """Iterate over the jobs that are queued or running."""
        return (document for document in self._documents("") if not document.final)

    def page(self, after: str, limit: int) -> list[JobDocument]:
        """Return up to `limit` jobs after the id `after`, in the order of their ids."""
        return list(islice(self._documents(after), limit))

    def forget_finished(self, older_than: float) -> list[str]:
        """Remove the jobs that ended `older_than` seconds ago, and return their ids.

        Blobs cannot be removed by compare-and-swap. So the job is first marked as forgotten by
        compare-and-swap, and a request that wants to renew it waits for the removal.
        """
        limit = rfc3339(self._clock() - older_than)
        forgotten = []
        for key in self._blobs.keys("jobs/"):
            job_id = id_of(key)
            stored = self._read_any(job_id)
            if stored is None:
                continue
            document, version = stored
            over = document.final and (document.finished or "") < limit
            if not over and not self._removal_failed(document):
                continue
            mark = replace(document, state="forgotten", updated=self._now())
            if self._replace(mark, version) is not None:
                self._blobs.delete(key)
                forgotten.append(job_id)
        return forgotten

    def _removal_failed(self, document: JobDocument) -> bool:
        """Return whether the process that should remove a forgotten job is gone."""
        limit = rfc3339(self._clock() - _REMOVAL_SECONDS)
        return document.state == "forgotten" and document.updated < limit

    def _replace_forgotten(self, fresh: JobDocument) -> JobDocument | None:
        """Return a job that replaced a forgotten one; None if the latter has been removed."""
        deadline = time.monotonic() + _REMOVAL_WAIT
        while (stored := self._read_any(fresh.id)) is not None and stored[0].state == "forgotten":
            document, version = stored
            if self._removal_failed(document):
                renewed = replace(fresh, token=document.token)
                return None if self._replace(renewed, version) is None else renewed
            if time.monotonic() > deadline:
                message = f"job {fresh.id} is being removed"
                raise StoreUnavailableError(message)
            time.sleep(0.02)
        return None

    def _documents(self, after: str) -> Iterator[JobDocument]:
        """Iterate over the jobs after an id. Remote stores are read in parallel."""
        keys = iter(self._blobs.keys("jobs/", _key(after) if after else ""))
        readers = _READERS if self._blobs.remote else 1
        with ThreadPoolExecutor(readers, thread_name_prefix="jobs") as threads:
            while batch := [id_of(key) for key in islice(keys, readers)]:
                documents = threads.map(self.read, batch) if readers > 1 else map(self.read, batch)
                yield from (each for each in documents if each is not None)

    def _read(self, job_id: str) -> tuple[JobDocument, str] | None:
        stored = self._read_any(job_id)
        return None if stored is None or stored[0].state == "forgotten" else stored

    def _read_any(self, job_id: str) -> tuple[JobDocument, str] | None:
        """Return the document and its version, forgotten or not; None if there is none."""
        while True:
            try:
                blob = self._blobs.read(_key(job_id))
            except BlobNotFoundError:
                return None
            try:
                return JobDocument.from_bytes(blob.data), blob.version
            except (BlobDamagedError, TypeError) as error:
                logger.error("document of job %s is damaged: %s", job_id, error)  # noqa: TRY400 - no defect
            options = self._lost_options(job_id)
            if options is None:
                # The options are lost. A client that wants the gamut must post the data again.
                if self._blobs.delete(_key(job_id)):
                    self._on_damaged(job_id)
                return None
            # A token greater than all before fences off the owner of the damaged document.
            token = int(1000 * self._clock())
            fresh = JobDocument(
                job_id, dict(options), created=self._now(), updated=NEVER_QUEUED, token=token
            )
            version = self._replace(fresh, blob.version)
            if version is not None:
                self._on_damaged(job_id)
                logger.warning("job %s is queued again from its stored input", job_id)
                return fresh, version

    def _replace(self, document: JobDocument, version: str) -> str | None:
        return self._blobs.replace(_key(document.id), document.to_bytes(), version)

    def _change(self, claim: Claim, document: JobDocument) -> Claim:
        """Store a claim's document and return the new claim."""
        version: str | None = claim.version
        while version is not None:
            new_version = self._replace(document, version)
            if new_version is not None:
                return replace(claim, document=document, version=new_version)
            version = self._version_of(claim, refused=version)
        raise LeaseLostError(claim.document.id)

    def _version_of(self, claim: Claim, refused: str) -> str | None:
        """Return the version of a claim's document if the claim is still valid.

        A change may have succeeded although its answer was lost. The document is then the claim's
        own, in another version.
        """
        stored = self._read(claim.document.id)
        if stored is None:
            return None
        document, version = stored
        if document.state == "cancelled" and document.token == claim.document.token:
            raise JobCancelledError(document.id)
        if document.state != "running" or document.token != claim.document.token:
            return None
        return None if version == refused else version

    def _queue_or_give_up(
        self, document: JobDocument, problem: Problem | None = None
    ) -> JobDocument:
        """Return a job whose builder is gone as queued, or as failed after the last attempt."""
        if document.state == "running" and document.attempts >= _ATTEMPTS:
            return self._give_up(document, problem)
        return self._queue_again(document, document.attempts)

    def _queue_again(self, document: JobDocument, attempts: int) -> JobDocument:
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

    def _give_up(self, document: JobDocument, problem: Problem | None = None) -> JobDocument:
        detail = f"The builder of this gamut died, {document.attempts} times."
        return self._end(document, "failed", problem or Problem("build-crashed", detail))

    def _end(self, document: JobDocument, state: JobState, problem: Problem | None) -> JobDocument:
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

    def _update(
        self, job_id: str, change: Callable[[JobDocument], JobDocument | None]
    ) -> JobDocument | None:
        """Change a job, unless `change` gives None, and return it; None if there is none."""
        while (stored := self._read(job_id)) is not None:
            changed = change(stored[0])
            if changed is None:
                return stored[0]
            if self._replace(changed, stored[1]) is not None:
                return changed
        return None

    def _is_abandoned(self, document: JobDocument, silence: float) -> bool:
        """Return whether nobody works on a job: its lease has ended, or it was queued long ago."""
        if document.state == "running":
            return (document.lease_until or 0.0) < self._clock()
        return document.updated < rfc3339(self._clock() - silence)

    def _now(self) -> str:
        return rfc3339(self._clock())


def _key(job_id: str) -> str:
    return f"jobs/{job_id[:2]}/{job_id}.job"
