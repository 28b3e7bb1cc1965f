"""The document of a job, as `service.jobs.book` stores it."""

from __future__ import annotations

import hashlib
import json
import time
from dataclasses import asdict, dataclass, field, fields
from datetime import UTC, datetime
from typing import Any, Literal

from service.storage.blobs import seal, unseal

__all__ = ["UNHEARD", "JobDocument", "JobState", "client_mark", "now", "rfc3339"]

JobState = Literal["queued", "running", "succeeded", "failed", "cancelled", "forgotten"]

UNHEARD = "1970-01-01T00:00:00.000Z"
"""Update time of a queued job that no engine has received yet."""


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
    trace: dict[str, str] = field(default_factory=dict)
    """Header fields that carry the trace of the first request."""
    client: str = ""
    """`client_mark` of the first request's client; empty if it is unknown."""

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
