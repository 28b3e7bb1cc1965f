"""Bodies of requests: receiving them within limits, forms, and strict JSON.

Nothing is admitted by what a client declares. The first 64 KiB of a body are in memory, as in the
server's own buffer of the connection. A larger body needs one of a few places, goes to an unnamed
file, and keeps the place until its content is forgotten. A client has a part of the places, and
every body has the same time to arrive. See ``docs/decisions/bodies.md``.
"""

from __future__ import annotations

import asyncio
import codecs
import contextlib
import errno
import json
import tempfile
from collections import Counter
from typing import TYPE_CHECKING, Any, NamedTuple, NoReturn

from python_multipart.multipart import parse_options_header
from starlette.datastructures import Headers, UploadFile
from starlette.formparsers import MultiPartException, MultiPartParser

from service.problems.problem import Problem, ProblemError

if TYPE_CHECKING:
    from collections.abc import AsyncGenerator, Iterator

    from starlette.requests import Request

__all__ = ["FIELD_BYTES", "IN_MEMORY", "Bodies", "Body", "Part", "check_head", "parse_json"]

IN_MEMORY = 64 * 1024
"""Bytes of a body, or of a file in a form, that stay in memory."""

FIELD_BYTES = 64 * 1024
"""Largest size of a field of a form, a hundred times that of all options."""

_MOST_FILES = 3
"""Files in a form. `file`, `options` and `name` may be files; others are refused by their names."""

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


class Bodies:
    """The bodies of all requests. One per app; belongs to the event loop's thread.

    `most_body` is the largest size of a body, and `seconds` the time for its arrival. `most_large`
    bodies may be larger than `IN_MEMORY` at the same time, `most_of_client` of one client. Their
    files are in Python's folder for temporary files, the only one that Starlette's parser has.
    """

    def __init__(
        self, *, most_body: int, most_large: int, most_of_client: int, seconds: float
    ) -> None:
        self.most_body = most_body
        self.most_of_client = most_of_client
        self.seconds = seconds
        self.places = asyncio.Semaphore(most_large)
        self.large_of: Counter[str] = Counter()
        """Large bodies of each client that are arriving, are kept, or wait for a place."""

    @property
    def large(self) -> int:
        """Number of large bodies, those that wait for a place included."""
        return self.large_of.total()

    @contextlib.contextmanager
    def body(self, request: Request, client: str) -> Iterator[Body]:
        """Yield the body of a request, which is forgotten at the end of the context."""
        body = Body(self, request, client)
        try:
            yield body
        finally:
            body.close()


class Body:
    """A body of `Bodies`. `size` is the number of bytes that have arrived."""

    def __init__(self, bodies: Bodies, request: Request, client: str) -> None:
        self.size = 0
        self._bodies = bodies
        self._request = request
        self._client = client
        self._waits = False
        self._held = contextlib.ExitStack()
        """The place of a large body, and the files."""
        self._file = self._held.enter_context(tempfile.SpooledTemporaryFile(IN_MEMORY))  # noqa: SIM115 - it is one

    @property
    def in_memory(self) -> bool:
        """Whether nothing is on the disk."""
        return self.size <= IN_MEMORY

    async def receive(self, most: int, remedy: str = "") -> None:
        """Keep all of the body. Raise the problems of `form` but ``malformed-body``."""
        with _scratch():
            async with self._deadline():
                async for piece in self._pieces(most, remedy):
                    if self.in_memory:
                        self._file.write(piece)
                    else:
                        await asyncio.to_thread(self._file.write, piece)

    async def form(self, most: int, most_fields: int) -> list[Part]:
        """Return the parts of a form in order.

        Raise ``body-too-large`` after `most` bytes, ``request-timeout`` if the body is slow,
        ``queries-busy`` or ``overloaded`` if there is no place, ``scratch-full`` if the disk is
        full, and ``malformed-body`` for whatever the parser refuses.
        """
        pieces = self._pieces(most, "")
        content_type = self._request.headers.get("content-type", "")
        _, parameters = parse_options_header(content_type)
        if not parameters.get(b"boundary"):  # the parser takes an empty one
            raise _form_problem("Missing boundary in multipart.", most_fields)
        parser = _FormParser(
            # The last charset counts. This one keeps the bytes of texts, in which a file may be.
            Headers({"content-type": f"{content_type}; charset=latin-1"}),
            pieces,
            max_files=_MOST_FILES,
            max_fields=most_fields,
            max_part_size=FIELD_BYTES,
        )
        try:
            with _scratch():
                async with self._deadline(), contextlib.aclosing(pieces):
                    items = (await parser.parse()).multi_items()
            self._held.callback(_close_files, [part for _, part in items])
            charset = parameters.get(b"charset", b"utf-8").decode("latin-1")
            return [_part(name, part, charset) for name, part in items]
        except MultiPartException as error:
            raise _form_problem(error.message, most_fields) from error
        except (ValueError, LookupError) as error:  # of fields that the parser does not foresee
            raise _form_problem("Invalid multipart data.", most_fields) from error

    def content(self) -> bytearray:
        """Return a copy of all bytes that were received."""
        content = bytearray(self.size)
        self._file.seek(0)
        self._file.readinto(content)  # all of it, because it is buffered
        return content

    def read(self, start: int, size: int) -> bytes:
        """Return some of the bytes that were received."""
        self._file.seek(start)
        return self._file.read(size)

    def close(self) -> None:
        """Forget the content. May be called again."""
        with contextlib.suppress(OSError):  # a full disk, which the last bytes did not fit on
            self._held.close()

    async def _pieces(self, most: int, remedy: str) -> AsyncGenerator[bytes, None]:
        """Iterate over the body as it arrives."""
        if most >= self._bodies.most_body:
            most, remedy = self._bodies.most_body, ""
        async for piece in self._request.stream():
            was_in_memory = self.in_memory
            self.size += len(piece)
            if self.size > most:
                detail = f"The body is larger than {most} bytes."
                raise ProblemError(Problem("body-too-large", detail, {"limit": most}, remedy))
            if was_in_memory and not self.in_memory:
                await self._take_place()
            yield piece

    async def _take_place(self) -> None:
        bodies, client = self._bodies, self._client
        if bodies.large_of[client] >= bodies.most_of_client:
            detail = f"The client has {bodies.most_of_client} large bodies that are not answered."
            raise ProblemError(Problem("queries-busy", detail, headers={"Retry-After": "2"}))
        bodies.large_of[client] += 1
        self._held.callback(self._uncount)
        self._waits = True
        await bodies.places.acquire()
        self._waits = False
        self._held.callback(bodies.places.release)

    def _uncount(self) -> None:
        large_of = self._bodies.large_of
        large_of[self._client] -= 1
        if not large_of[self._client]:
            del large_of[self._client]

    @contextlib.asynccontextmanager
    async def _deadline(self) -> AsyncGenerator[None, None]:
        """End the body if it does not arrive in time."""
        try:
            async with asyncio.timeout(self._bodies.seconds) as limit:
                yield
        except TimeoutError:
            if not limit.expired():
                raise
            seconds = f"{self._bodies.seconds:g} s"
            if self._waits:
                detail = f"No large body of another request ended within {seconds}."
                remedy = "Try again after the time in Retry-After."
                fields = {"Retry-After": "5"}
                problem = Problem("overloaded", detail, remedy=remedy, headers=fields)
            else:
                detail = f"{self.size} bytes of the body arrived within {seconds}."
                # Otherwise the server would wait for the rest on the same connection.
                problem = Problem("request-timeout", detail, headers={"Connection": "close"})
            raise ProblemError(problem) from None


class Part(NamedTuple):
    """A part of a form: the content of a field, or a file on the disk with its name."""

    name: str
    content: bytes
    text: str
    file: UploadFile | None = None
    file_name: str = ""


def _part(name: str, value: str | UploadFile, charset: str) -> Part:
    """Return a part whose texts were decoded as ISO-8859-1."""

    def decoded(text: str) -> str:
        content = text.encode("latin-1")
        try:
            return content.decode(charset)
        except UnicodeDecodeError:
            return text

    if isinstance(value, UploadFile):
        return Part(decoded(name), b"", "", value, decoded(value.filename or ""))
    return Part(decoded(name), value.encode("latin-1"), decoded(value))


def _close_files(parts: list[str | UploadFile]) -> None:
    for part in parts:
        if isinstance(part, UploadFile):
            part.file.close()


class _FormParser(MultiPartParser):
    """Starlette's parser, with less of a file in memory."""

    spool_max_size = IN_MEMORY


def _form_problem(message: str, most_fields: int) -> ProblemError:
    """Return the problem of whatever Starlette's parser refuses."""
    limits = {"Part": FIELD_BYTES, "Too many fields": most_fields, "Too many files": _MOST_FILES}
    for start, limit in limits.items():
        if message.startswith(start):
            detail = f"The form is too large: {message}"
            remedy = "Send the data as the part `file` with a file name, and options as fields."
            return ProblemError(Problem("body-too-large", detail, {"limit": limit}, remedy))
    return ProblemError(
        Problem("malformed-body", f"The multipart body cannot be parsed: {message}")
    )


@contextlib.contextmanager
def _scratch() -> Iterator[None]:
    """Raise ``scratch-full`` if there is no space for a body."""
    try:
        yield
    except OSError as error:
        if error.errno in {errno.ENOSPC, errno.EDQUOT}:
            detail = "There is no space left for bodies that are arriving."
            raise ProblemError(Problem("scratch-full", detail)) from error
        raise


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
    document = dict(members)
    if len(document) < len(members):
        seen: set[str] = set()
        for name, _ in members:
            if name in seen:
                detail = f"There is more than one member named {name[:80]!r}."
                remedy = "Give every member of a JSON object once."
                raise ProblemError(Problem("invalid-body", detail, {"field": name[:80]}, remedy))
            seen.add(name)
    return document


def _refuse_constant(name: str) -> NoReturn:
    raise ProblemError(Problem("malformed-body", f"{name} is not a number in JSON."))
