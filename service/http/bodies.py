"""Bodies of requests: receiving them within limits, forms, and strict JSON.

Nothing is admitted by what a client declares. A body takes part in a few amounts that all bodies
share: the number of bodies that are arriving, and the bytes that have arrived. Its first 64 KiB are
in memory, the rest is in an unnamed file in the store's folder for scratch files. When an amount is
used up, the slowest arriving body is cut; if none is slower, the newcomer is refused. One client
has at most a share of each amount while others compete. See ``docs/decisions/bodies.md``.
"""

from __future__ import annotations

import asyncio
import codecs
import contextlib
import errno
import json
import tempfile
import time
from collections import Counter
from enum import Enum
from typing import TYPE_CHECKING, Any, NamedTuple, NoReturn

from python_multipart.exceptions import FormParserError
from python_multipart.multipart import MultipartParser, parse_options_header
from starlette.requests import ClientDisconnect

from service.problems.problem import Problem, ProblemError

if TYPE_CHECKING:
    import io
    from collections.abc import AsyncIterator, Callable, Iterator
    from pathlib import Path

    from starlette.requests import Request
    from starlette.types import Message, Receive

__all__ = [
    "FIELD_BYTES",
    "IN_MEMORY",
    "Body",
    "Part",
    "Spool",
    "check_head",
    "decoded",
    "parse_json",
    "read_form",
]

SHARE = 0.25
"""Part of the arriving bodies, and of their bytes, that a client has in any case."""

IN_MEMORY = 64 * 1024
"""Bytes of a body that stay in memory, like the server's own buffer of a connection."""

FIELD_BYTES = 64 * 1024
"""Largest size of a field of a form, a hundred times that of all options."""

_TEXTS = frozenset({"utf-8", "ascii", "iso8859-1", "cp1252"})
"""Python's names of the accepted charsets. Many other codecs of Python are no charsets, or raise
errors of their own."""


def check_head(request: Request, most_bytes: int) -> None:
    """Refuse bodies that are declared too large, or in other charsets than the accepted ones.

    FastAPI's ``max_body_size`` would answer with plain text that no exception handler sees.
    """
    for name, value in request.scope["headers"]:
        # The server refuses lengths that are not digits, so they need no answer here.
        if name == b"content-length" and value.isdigit() and int(value) > most_bytes:
            detail = f"The body is larger than {most_bytes} bytes."
            raise ProblemError(Problem("body-too-large", detail, {"limit": most_bytes}))
        if name == b"content-type" and b"charset" in value.lower():
            # Parsed as Starlette's form parser does.
            _, parameters = parse_options_header(value)
            charset = parameters.get(b"charset", b"utf-8").decode("latin-1")
            if not _is_text(charset):
                detail = f"The body has the charset {charset[:40]!r}."
                where = {"header": "Content-Type"}
                remedy = "Send the body in UTF-8."
                raise ProblemError(Problem("unsupported-media-type", detail, where, remedy))


def _is_text(charset: str) -> bool:
    try:
        return codecs.lookup(charset).name in _TEXTS
    except (LookupError, ValueError):
        return False


class Refused(Enum):
    """Why a client cannot have more of an amount."""

    FULL = "full"
    SHARE = "share"


class SharedAmount:
    """An amount that clients take parts of. Belongs to the event loop's thread.

    A client may exceed its `share`, a part of `most`, as long as a share remains for others. So a
    single client can use most of the amount, and another client always finds some. What is taken
    alone always fits.
    """

    def __init__(self, most: int, share: float) -> None:
        self.most = most
        self.used = 0
        self._share = int(most * share)
        self._of: Counter[str] = Counter()

    def refusal(self, client: str, amount: int, own: int = 0) -> Refused | None:
        """Return why an amount cannot be taken; None if it can.

        `own` is what the same request has taken already.
        """
        if self.used == own:
            return None
        after = self.used + amount
        exceeds_share = self._of[client] + amount > self._share
        if exceeds_share and after > self.most - self._share:
            return Refused.SHARE
        return Refused.FULL if after > self.most else None

    def take(self, client: str, amount: int) -> None:
        """Take an amount, or give it back if it is negative."""
        self.used += amount
        self._of[client] += amount
        if not self._of[client]:
            del self._of[client]


class Body:
    """A body that arrives, or has arrived. `Spool.body` makes it; `size` is what `write` kept."""

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

        Raise ``body-too-large`` after `most` bytes, and ``request-timeout`` if the body is cut.
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

        Raise ``spool-full``, ``share-exceeded`` or ``scratch-full`` if there is no room.
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

    Belongs to the event loop's thread. `folder` returns the folder of scratch files, `most_body` is
    the largest size of a body, and `most_bytes` that of all. `most_decoded` is the memory for
    bodies that are decoded and for what is made of them, which a single body may exceed.
    """

    def __init__(
        self,
        folder: Callable[[], Path],
        *,
        most_body: int,
        most_bodies: int,
        most_bytes: int,
        most_decoded: int,
    ) -> None:
        self.folder = folder
        self.most_body = most_body
        self._arriving: set[Body] = set()
        self._places = SharedAmount(most_bodies, SHARE)
        self._bytes = SharedAmount(most_bytes, SHARE)
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

        Raise ``share-exceeded`` if too many bodies of the client are arriving.
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

        Raise ``share-exceeded`` or ``spool-full``.
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


class Part(NamedTuple):
    """A part of a form, and where its content is in the body. `file` is None for a field."""

    name: str
    file: str | None
    start: int
    size: int


class _FormReader:
    """Receives the events of the parser."""

    def __init__(self, charset: str, most_fields: int, check: Callable[[str], None]) -> None:
        self.parts: list[Part] = []
        self._part = Part("", None, 0, 0)
        self.content = bytearray()
        """What the parser has found and nobody has kept yet."""
        self._kept = 0
        self._charset = charset
        self._fields_left = self._most_fields = most_fields
        self._check = check
        self._headers: list[tuple[bytes, bytes]] = []
        self._name = self._value = b""

    def take(self) -> bytes:
        """Return the content of parts since the last call."""
        content = bytes(self.content)
        self._kept += len(content)
        self.content.clear()
        return content

    def on_header_field(self, data: bytes, start: int, end: int) -> None:
        self._name += data[start:end]

    def on_header_value(self, data: bytes, start: int, end: int) -> None:
        self._value += data[start:end]

    def on_header_end(self) -> None:
        self._headers.append((self._name.lower(), self._value))
        self._name = self._value = b""

    def on_headers_finished(self) -> None:
        _, options = parse_options_header(dict(self._headers).get(b"content-disposition", b""))
        self._headers.clear()
        if b"name" not in options:
            _refuse_form('The Content-Disposition header field "name" must be provided.')
        name, file = decoded(options[b"name"], self._charset), None
        if b"filename" in options:
            file = decoded(options[b"filename"], self._charset)
        elif not self._fields_left:
            most = self._most_fields
            raise _too_large(f"Too many fields. Maximum number of fields is {most}.", most)
        else:
            self._fields_left -= 1
        self._check(name)
        self._part = Part(name, file, self._kept + len(self.content), 0)

    def on_part_data(self, data: bytes, start: int, end: int) -> None:
        part = self._part = self._part._replace(size=self._part.size + end - start)
        if part.file is None and part.size > FIELD_BYTES:
            detail = f"Part exceeded maximum size of {FIELD_BYTES // 1024}KB."
            raise _too_large(detail, FIELD_BYTES)
        self.content += memoryview(data)[start:end]

    def on_part_end(self) -> None:
        self.parts.append(self._part)


async def read_form(
    body: Body, content_type: str, *, most: int, most_fields: int, check: Callable[[str], None]
) -> tuple[list[Part], str]:
    """Keep the content of a form's parts in its body; return the parts and the charset of texts.

    `most` limits the bytes. `check` is called with the name of every part when its header has
    arrived, so a part that nobody wants ends the request there. Starlette's parser reads all of it.
    """
    _, parameters = parse_options_header(content_type)
    boundary = parameters.get(b"boundary")
    if not boundary:
        _refuse_form("Missing boundary in multipart.")
    charset = parameters.get(b"charset", b"utf-8").decode("latin-1")
    reader = _FormReader(charset, most_fields, check)
    names = (name for name in dir(reader) if name.startswith("on_"))
    callbacks: Any = {name: getattr(reader, name) for name in names}
    try:
        parser = MultipartParser(boundary, callbacks)  # refuses long boundaries
        async for piece in body.pieces(most):
            parser.write(piece)
            if reader.content:
                await body.write(reader.take())
        parser.finalize()
    except FormParserError:
        _refuse_form("Invalid multipart data.")
    return reader.parts, charset


def decoded(text: bytes, charset: str) -> str:
    """Return a text of a form, in a charset that `check_head` accepts."""
    try:
        return text.decode(charset)
    except UnicodeDecodeError:
        return text.decode("latin-1")


def _too_large(detail: str, limit: int) -> ProblemError:
    remedy = "Send the data as the part `file` with a file name, and options as fields."
    detail = f"The form is too large: {detail}"
    return ProblemError(Problem("body-too-large", detail, {"limit": limit}, remedy))


def _refuse_form(detail: str) -> NoReturn:
    detail = f"The multipart body cannot be parsed: {detail}"
    raise ProblemError(Problem("malformed-body", detail))


def parse_json(text: bytes | bytearray, place: dict[str, Any] | None = None) -> Any:  # noqa: ANN401 - JSON before its shape is known
    """Return the value of a JSON text; `place` is where the text is, for problems.

    Raise ``malformed-body`` if it is no JSON, constants beyond RFC 8259 included, and
    ``invalid-body`` if the name of a member is repeated.
    """
    place = place or {}
    try:
        return json.loads(
            text.decode(), parse_constant=_refuse_constant, object_pairs_hook=_unique_members
        )
    except json.JSONDecodeError as error:
        where = {**place, "line": error.lineno, "column": error.colno}
        problem = Problem("malformed-body", f"The JSON is broken: {error.msg}.", where)
    except UnicodeDecodeError as error:
        where = {**place, "byte": error.start}
        problem = Problem("malformed-body", "The JSON is not UTF-8.", where)
    except (ValueError, RecursionError):
        detail = "The JSON is nested too deeply, or a number is out of range."
        problem = Problem("malformed-body", detail, place)
    raise ProblemError(problem)


def _unique_members(members: list[tuple[str, Any]]) -> dict[str, Any]:
    """Return an object; refuse repeated names, as RFC 7493 (I-JSON), section 2.3.

    The service cannot know which value was intended.
    """
    found = dict(members)
    if len(found) < len(members):
        seen: set[str] = set()
        for name, _ in members:
            if name in seen:
                detail = f"There is more than one member named {name[:80]!r}."
                remedy = "Give every member of a JSON object once."
                raise ProblemError(Problem("invalid-body", detail, {"field": name[:80]}, remedy))
            seen.add(name)
    return found


def _refuse_constant(name: str) -> NoReturn:
    raise ProblemError(Problem("malformed-body", f"{name} is not a number in JSON."))
