"""Server-sent events of jobs (WHATWG HTML, section 9.2).

A stream sends the job now and after every change (``progress``), and the finished job at the end
(``finished``). Event ids depend on the content only, so a client that reconnects to any replica
with ``Last-Event-ID`` gets only what is new.
"""

from __future__ import annotations

import contextlib
import json
from collections.abc import AsyncIterator, Iterator
from typing import Any

from service.jobs.book import JobDocument

__all__ = ["HEARTBEAT_SECONDS", "MEDIA_TYPE", "EventStreams", "event_id", "stream_of_events"]

MEDIA_TYPE = "text/event-stream"

HEARTBEAT_SECONDS = 15.0
"""Interval of comments that keep the connection open. Proxies close silent ones after 30 to 60
s."""

_RETRY = b"retry: 2000\n\n"
"""Milliseconds after which a browser reconnects."""

MOST_STREAMS = 256
"""Open streams of events. Each has a connection and a task, and clients can poll instead."""


class EventStreams:
    """The open streams, `limit` at most."""

    def __init__(self, limit: int = MOST_STREAMS) -> None:
        self.limit = limit
        self.count = 0

    @property
    def full(self) -> bool:
        """Whether the limit is reached."""
        return self.count >= self.limit

    @contextlib.contextmanager
    def one(self) -> Iterator[None]:
        """Count one stream while it is open."""
        self.count += 1
        try:
            yield
        finally:
            self.count -= 1


def event_id(document: JobDocument) -> str:
    """Return the id of the event that describes this state of a job."""
    parts = (document.token, document.attempts, document.state, document.stage or "-")
    return ".".join(map(str, parts)) + f".{round(1000 * document.fraction)}"


async def stream_of_events(
    changes: AsyncIterator[tuple[JobDocument, dict[str, Any]] | None], known: str | None
) -> AsyncIterator[bytes]:
    """Iterate over the bytes of a stream; `known` is the id of the last event that the client has.

    `changes` gives the job with its JSON, or None for a heartbeat.
    """
    yield _RETRY
    async for change in changes:
        if change is None:
            yield b": alive\n\n"
            continue
        document, content = change
        name = event_id(document)
        if name == known and not document.final:
            continue
        known = name
        kind = "finished" if document.final else "progress"
        data = json.dumps(content, ensure_ascii=True, allow_nan=False, separators=(",", ":"))
        yield f"id: {name}\nevent: {kind}\ndata: {data}\n\n".encode()
