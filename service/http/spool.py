"""Bodies of requests, from the first byte until they are parsed.

Nothing is admitted by what a client declares. A body takes part in a few amounts that all bodies
share: the number of bodies that are arriving, and the bytes that have arrived. Its first 64 KiB are
in memory, the rest is in an unnamed file in the store's folder for scratch files. When an amount is
used up, the slowest arriving body is cut; if none is slower, the newcomer is refused. One client
has at most a share of each amount while others compete. See ``docs/decisions/bodies.md``.
"""

from __future__ import annotations

import asyncio
import contextlib
import errno
import tempfile
import time
from typing import TYPE_CHECKING

from starlette.requests import ClientDisconnect

from service.http.shares import Refused, SharedAmount
from service.problems.problem import Problem, ProblemError

if TYPE_CHECKING:
    import io
    from collections.abc import AsyncIterator, Callable, Iterator
    from pathlib import Path

    from starlette.requests import Request
    from starlette.types import Message, Receive

__all__ = ["IN_MEMORY", "Body", "Spool"]

IN_MEMORY = 64 * 1024
"""Bytes of a body that stay in memory, like the server's own buffer of a connection."""


class Body:
    """A body that arrives, or has arrived. `Spool.body` makes it.

    Attributes
    ----------
    size : int
        Bytes that `write` kept.
    """

    def __init__(self, spool: Spool, receive: Receive, client: str) -> None:
        self.size = 0
        self.client = client
        self._spool = spool
        self._receive = receive
        self._since = time.monotonic()
        self._arrived = 0
        self._charged = 0
        self._is_cut = False
        self._wait: asyncio.Timeout | None = None
        self._buffer = bytearray()
        self._file: io.BufferedRandom | None = None

    async def receive(self, most: int, remedy: str = "") -> None:
        """Keep all of the body; see `pieces`."""
        async for piece in self.pieces(most, remedy):
            await self.write(piece)

    async def pieces(self, most: int, remedy: str = "") -> AsyncIterator[bytes]:
        """Iterate over the body as it arrives, without keeping it.

        Raises
        ------
        ProblemError
            ``body-too-large``: there are more than `most` bytes. ``request-timeout``: the body was
            cut, because it arrived more slowly than others.
        """
        if most >= self._spool.most_body:
            most, remedy = self._spool.most_body, ""
        more = True
        while more:
            message = await self._next()
            if message["type"] == "http.disconnect":
                raise ClientDisconnect
            more = message.get("more_body", False)
            piece: bytes = message.get("body", b"")
            self._arrived += len(piece)
            if self._arrived > most:
                detail = f"The body is larger than {most} bytes."
                raise ProblemError(Problem("body-too-large", detail, {"limit": most}, remedy))
            if not more:
                self._spool.end_wait(self)
            if piece:
                yield piece

    async def write(self, data: bytes) -> None:
        """Keep some bytes: in memory, or on the disk if they are more than a few.

        Raises
        ------
        ProblemError
            ``spool-full`` or ``share-exceeded``: too many bytes of bodies are kept.
            ``scratch-full``: there is no space on the disk.
        """
        self._spool.charge(self, len(data), self._charged)
        self._charged += len(data)
        self.size += len(data)
        self._buffer += data
        if len(self._buffer) > IN_MEMORY:
            await asyncio.to_thread(self._flush)

    @property
    def in_memory(self) -> bool:
        """Whether nothing is on the disk."""
        return self._file is None

    def content(self) -> bytearray:
        """Return all bytes that were kept; a copy only if some are on the disk."""
        if self._file is None:
            return self._buffer
        content = bytearray(self.size)
        self._flush()
        self._file.seek(0)
        self._file.readinto(content)  # all of it, because it is buffered
        return content

    def read(self, start: int, size: int) -> bytes:
        """Return some of the bytes that were kept."""
        if self._file is None:
            return bytes(memoryview(self._buffer)[start : start + size])
        self._flush()
        self._file.seek(start)
        return self._file.read(size)

    @property
    def rate(self) -> float:
        """Bytes per second so far. A body that has just begun is not slow."""
        return (self._arrived + IN_MEMORY) / max(time.monotonic() - self._since, 1e-6)

    def cut(self) -> None:
        """End the wait for the body, and give back what it has taken."""
        self._is_cut = True
        self._spool.end_wait(self)
        self._give_back()
        if self._wait is not None:
            self._wait.reschedule(asyncio.get_running_loop().time())

    def close(self) -> None:
        """Forget the content."""
        self._spool.end_wait(self)
        self._give_back()
        if self._file is not None:
            with contextlib.suppress(OSError):  # a full disk, which the last bytes did not fit on
                self._file.close()

    async def _next(self) -> Message:
        """Return the next message of the server, unless the body is cut meanwhile."""
        # A request is waited for by its own task, so a timeout of that task can end the wait.
        with contextlib.suppress(TimeoutError):
            if not self._is_cut:
                async with asyncio.timeout(None) as wait:
                    self._wait = wait
                    try:
                        return await self._receive()
                    finally:
                        self._wait = None
        detail = f"{self._arrived} bytes of the body arrived, more slowly than those of others."
        remedy = "Try again after the time in Retry-After, and send the body faster."
        headers = {"Retry-After": "5"}
        raise ProblemError(Problem("request-timeout", detail, remedy=remedy, headers=headers))

    def _give_back(self) -> None:
        self._spool.give_back(self, self._charged)
        self._charged = 0

    def _flush(self) -> None:
        """Move the bytes in memory to the disk."""
        try:
            if self._file is None:
                self._file = tempfile.TemporaryFile(dir=self._spool.folder())  # noqa: SIM115
            self._file.write(self._buffer)
            self._file.flush()
        except OSError as error:
            if error.errno in {errno.ENOSPC, errno.EDQUOT}:
                detail = "There is no space left for bodies that are arriving."
                raise ProblemError(Problem("scratch-full", detail)) from error
            raise
        self._buffer = bytearray()


class Spool:
    """The bodies that are arriving, or have arrived and are not parsed. One per app.

    Belongs to the event loop's thread.

    Parameters
    ----------
    folder : callable
        Returns the folder of scratch files.
    most_body : int
        Largest size of a body.
    most_bodies : int
        Largest number of arriving bodies.
    most_bytes : int
        Largest number of bytes of all bodies.
    most_decoded : int
        Bytes of memory for bodies that are decoded and for what is made of them. A single body may
        exceed it.
    share : float
        The part of the numbers that belongs to one client if others compete.
    """

    def __init__(
        self,
        folder: Callable[[], Path],
        *,
        most_body: int,
        most_bodies: int,
        most_bytes: int,
        most_decoded: int,
        share: float,
    ) -> None:
        self.folder = folder
        self.most_body = most_body
        self._arriving: set[Body] = set()
        self._places = SharedAmount(most_bodies, share)
        self._bytes = SharedAmount(most_bytes, share)
        self._most_decoded = most_decoded
        self._decoded = 0
        self._turn = asyncio.Lock()
        self._freed = asyncio.Event()

    @property
    def arriving(self) -> int:
        """Number of arriving bodies."""
        return self._places.used

    @property
    def nbytes(self) -> int:
        """Bytes of all bodies."""
        return self._bytes.used

    @contextlib.contextmanager
    def body(self, request: Request, client: str) -> Iterator[Body]:
        """Yield the body of a request, which is forgotten at the end of the context.

        Raises
        ------
        ProblemError
            ``share-exceeded``: too many bodies of the client are arriving.
        """
        body = Body(self, request.receive, client)
        match self._places.refusal(client, 1):
            case Refused.SHARE:
                raise _exceeded("bodies that are arriving")
            case Refused.FULL:
                min(self._arriving, key=lambda each: each.rate).cut()
        self._places.take(client, 1)
        self._arriving.add(body)
        try:
            yield body
        finally:
            body.close()

    def end_wait(self, body: Body) -> None:
        """Give the place of an arriving body to others. May be called again."""
        if body in self._arriving:
            self._arriving.remove(body)
            self._places.take(body.client, -1)

    def charge(self, body: Body, nbytes: int, own: int) -> None:
        """Count bytes of a body that has `own` so far. Slower bodies make room for them.

        Raises
        ------
        ProblemError
            ``share-exceeded`` or ``spool-full``.
        """
        while refused := self._bytes.refusal(body.client, nbytes, own):
            if refused is Refused.SHARE:
                raise _exceeded("bytes of bodies")
            slowest = min(self._arriving, key=lambda each: each.rate, default=body)
            if slowest is body or slowest.rate > body.rate:
                detail = f"The bodies of other requests take {self._bytes.used - own} bytes."
                raise ProblemError(Problem("spool-full", detail, headers={"Retry-After": "5"}))
            slowest.cut()
        self._bytes.take(body.client, nbytes)

    def give_back(self, body: Body, nbytes: int) -> None:
        """Give bytes of a body to others."""
        self._bytes.take(body.client, -nbytes)

    @contextlib.asynccontextmanager
    async def decoding(self, nbytes: int) -> AsyncIterator[None]:
        """Hold memory for a body that is decoded, in the order of the requests."""
        async with self._turn:
            while self._decoded and self._decoded + nbytes > self._most_decoded:
                self._freed.clear()
                await self._freed.wait()
            self._decoded += nbytes
        try:
            yield
        finally:
            self._decoded -= nbytes
            self._freed.set()


def _exceeded(what: str) -> ProblemError:
    detail = f"The client has more than its share of the {what}."
    return ProblemError(Problem("share-exceeded", detail, headers={"Retry-After": "1"}))
