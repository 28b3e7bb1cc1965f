"""``multipart/form-data`` (RFC 7578), whose parts are checked as they arrive.

Starlette's parser keeps fields and the start of every file in memory, and hands over the form when
all of it has arrived. Here all parts share one `Body`, so a form takes as much memory as any other
body, and a part that nobody wants ends the request at its header.
"""

from __future__ import annotations

import codecs
from typing import TYPE_CHECKING, Any, NamedTuple, NoReturn

from python_multipart.exceptions import FormParserError
from python_multipart.multipart import MultipartParser, parse_options_header

from service.problems.problem import Problem, ProblemError

if TYPE_CHECKING:
    from collections.abc import Callable

    from service.http.spool import Body

__all__ = ["FIELD_BYTES", "Part", "read_form"]

FIELD_BYTES = 64 * 1024
"""Largest size of a field, a hundred times that of all options."""


class Part(NamedTuple):
    """A part of a form.

    Attributes
    ----------
    name : str
    file : str or None
        Name of the file; None if the part is a field.
    start, size : int
        Position of the content in the body that was kept.
    """

    name: str
    file: str | None
    start: int
    size: int


class _Reader:
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
            _refuse('The Content-Disposition header field "name" must be provided.')
        name, file = self._text(options[b"name"]), None
        if b"filename" in options:
            file = self._text(options[b"filename"])
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

    def _text(self, value: bytes) -> str:
        return decoded(value, self._charset)


async def read_form(
    body: Body, content_type: str, *, most: int, most_fields: int, check: Callable[[str], None]
) -> tuple[list[Part], str]:
    """Keep the content of a form's parts in its body; return the parts and the charset of texts.

    Parameters
    ----------
    body : Body
    content_type : str
        Header field of the request.
    most : int
        Largest size of the form in bytes.
    most_fields : int
        Largest number of fields.
    check : callable
        Called with the name of every part when its header has arrived. May raise.

    Raises
    ------
    ProblemError
        ``malformed-body`` or ``body-too-large``.
    """
    _, parameters = parse_options_header(content_type)
    boundary = parameters.get(b"boundary")
    if not boundary:
        _refuse("Missing boundary in multipart.")
    charset = _charset(parameters.get(b"charset", b"utf-8").decode("latin-1"))
    reader = _Reader(charset, most_fields, check)
    names = (name for name in dir(reader) if name.startswith("on_"))
    callbacks: Any = {name: getattr(reader, name) for name in names}
    parser = MultipartParser(boundary, callbacks)
    try:
        async for piece in body.pieces(most):
            parser.write(piece)
            if reader.content:
                await body.write(reader.take())
        parser.finalize()
    except FormParserError:
        _refuse("Invalid multipart data.")
    return reader.parts, charset


def _charset(name: str) -> str:
    try:
        return codecs.lookup(name).name
    except LookupError:
        return "latin-1"


def decoded(text: bytes, charset: str) -> str:
    """Return the text of a form."""
    try:
        return text.decode(charset)
    except (UnicodeDecodeError, LookupError):
        return text.decode("latin-1")
    except ValueError:
        _refuse(f"The charset {charset} is not supported.")


def _too_large(detail: str, limit: int) -> ProblemError:
    remedy = "Send the data as the part `file` with a file name, and options as fields."
    detail = f"The form is too large: {detail}"
    return ProblemError(Problem("body-too-large", detail, {"limit": limit}, remedy))


def _refuse(detail: str) -> NoReturn:
    detail = f"The multipart body cannot be parsed: {detail}"
    raise ProblemError(Problem("malformed-body", detail))
