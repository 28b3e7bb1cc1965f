"""Jobs as server-sent events (WHATWG HTML, 9.2): an extra beside polling, which is the contract.

A stream tells the job as it is and after every change (``progress``), and at last the finished job
(``finished``); then it ends. Ids say what was told, not when: whoever comes back with the id of the
last event, to whichever replica, is told only what is new.
"""

from __future__ import annotations

import contextlib
import json
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterator

    from service.jobs.book import JobDocument

__all__ = ["HEARTBEAT_SECONDS", "MEDIA_TYPE", "EventStreams", "event_id", "stream_of_events"]

MEDIA_TYPE = "text/event-stream"

HEARTBEAT_SECONDS = 15.0
"""Between two signs of life: proxies close what is silent for 30 to 60 s."""

_RETRY = b"retry: 2000\n\n"
"""Milliseconds after which a browser comes back when the connection was lost."""


class EventStreams:
    """The number of open streams, which is bounded.

    Parameters
    ----------
    limit : int
        The most of them.
    """

    def __init__(self, limit: int) -> None:
        self.limit = limit
        self.count = 0

    @property
    def full(self) -> bool:
        """Whether there may be no more of them."""
        return self.count >= self.limit

    @contextlib.contextmanager
    def one(self) -> Iterator[None]:
        """Count a stream as long as it is open."""
        self.count += 1
        try:
            yield
        finally:
            self.count -= 1


def event_id(document: JobDocument) -> str:
    """Return the id of the event that tells this of a job."""
    parts = (document.token, document.attempts, document.state, document.stage or "-")
    return ".".join(map(str, parts)) + f".{round(1000 * document.fraction)}"


async def stream_of_events(
    changes: AsyncIterator[tuple[JobDocument, dict[str, Any]] | None], known: str | None
) -> AsyncIterator[bytes]:
    """Iterate over the bytes of a stream.

    Parameters
    ----------
    changes : async iterator
        The job and the JSON that it is told as; None for a sign of life.
    known : str, optional
        The id of the last event that the client has got, as it says.
    """
    yield _RETRY
    async for change in changes:
        if change is None:
            yield b": alive\n\n"
            continue
        document, told = change
        name = event_id(document)
        if name == known and not document.final:
            continue
        known = name
        kind = "finished" if document.final else "progress"
        data = json.dumps(told, ensure_ascii=True, allow_nan=False, separators=(",", ":"))
        yield f"id: {name}\nevent: {kind}\ndata: {data}\n\n".encode()
