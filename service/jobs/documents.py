"""One document of a job, as it is kept in the store by `service.jobs.book`."""

from __future__ import annotations

import json
import time
from dataclasses import asdict, dataclass, field, fields
from datetime import UTC, datetime
from typing import Any, Literal

from service.storage.blobs import sealed, unsealed

__all__ = ["UNHEARD", "JobDocument", "JobState", "now", "rfc3339"]

JobState = Literal["queued", "running", "succeeded", "failed", "cancelled", "forgotten"]

UNHEARD = "1970-01-01T00:00:00.000Z"
"""When a job was updated that is queued and has been given to nobody yet."""


def now() -> str:
    """Return the time in RFC 3339, UTC, to the millisecond."""
    return rfc3339(time.time())


def rfc3339(seconds: float) -> str:
    """Return a time, given in seconds of the Unix epoch, as `now` does."""
    moment = datetime.fromtimestamp(seconds, UTC)
    return moment.isoformat(timespec="milliseconds").replace("+00:00", "Z")


@dataclass(frozen=True)
class JobDocument:
    """One build, from its acceptance to its end, as it is kept in the store.

    Attributes
    ----------
    id : str
        The id of the gamut that is built.
    options : dict
        The gamut's options, all of them.
    state : str
        What the names say. ``succeeded``, ``failed`` and ``cancelled`` are final; one that is
        ``forgotten`` is about to be removed, and counts as none.
    stage, fraction : str, float
        How far a running build is: a stage of `gamutcore` and the part of it that is done, 0..1.
    attempts : int
        How often the build was started, since it was last accepted.
    created, updated, started, finished : str
        Times in RFC 3339; the last two may be None.
    problem : dict, optional
        Why the job failed or was cancelled: what `Problem.from_mapping` takes.
    owner : str, optional
        Who is building.
    token : int
        Grows with every claim of this job.
    lease_until : float, optional
        When the owner's claim ends unless it is renewed, seconds of the Unix epoch.
    trace : dict
        Header fields that carry the trace of the request which began the job.
    """

    id: str
    options: dict[str, Any]
    state: JobState = "queued"
    stage: str = ""
    fraction: float = 0.0
    attempts: int = 0
    created: str = ""
    updated: str = ""
    started: str | None = None
    finished: str | None = None
    problem: dict[str, Any] | None = None
    owner: str | None = None
    token: int = 0
    lease_until: float | None = None
    trace: dict[str, str] = field(default_factory=dict)

    @property
    def final(self) -> bool:
        """Whether nothing changes any more, unless the gamut is asked for anew."""
        return self.state in {"succeeded", "failed", "cancelled"}

    def to_bytes(self) -> bytes:
        """Return the document's blob."""
        return sealed(json.dumps(asdict(self), separators=(",", ":")).encode())

    @classmethod
    def from_bytes(cls, data: bytes) -> JobDocument:
        """Return the document in a blob; `BlobDamagedError` if anything about it is wrong."""
        values = json.loads(unsealed(data))
        names = {each.name for each in fields(cls)}
        # A later version may have more to say; this one says nothing about what it does not know.
        return cls(**{name: value for name, value in values.items() if name in names})
