"""Reads the body of ``POST /v1/gamuts``: characterisation data and options, in one of two forms.

``multipart/form-data`` has the part ``file``. Options are members of the part ``options`` (JSON),
form fields of their own, or both.
``application/json`` is an object whose member ``options`` is taken out; the rest is the
characterisation itself, written down canonically (sorted members, no white space), so that the same
samples give the same gamut id.
"""

from __future__ import annotations

import asyncio
import contextlib
import hashlib
import json
from dataclasses import dataclass
from tempfile import SpooledTemporaryFile
from typing import TYPE_CHECKING, Any, BinaryIO, NoReturn, TypeAlias, cast

from starlette.datastructures import FormData, UploadFile
from starlette.formparsers import MultiPartException, MultiPartParser

from gamutcore.characterisation.json_samples import MAX_JSON_SAMPLES, json_samples
from gamutcore.gamut import Options, gamut_id
from gamutcore.option_types import near_match
from gamutcore.options import OPTIONS, find_option, option_value
from service.problems.problem import Problem, ProblemError
from service.telemetry.server_timing import timed

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable
    from pathlib import Path

    from fastapi import Request

    from service.settings import Settings

__all__ = ["Submission", "submission"]

_MOST_VALUES = 8_000_000
"""Values in a JSON body at most: decoded, each takes up to 32 bytes."""

_OPTIONS_BYTES = 64 * 1024
"""Size of the part ``options``: a hundred times what all options take."""

_PARTS = ("file", "options")
"""Parts of a form besides the fields of single options."""

_CHECKED_BYTES = 16 * 1024
"""Inline samples up to this size are read at once, which takes a millisecond, and not by the build
alone: so those who do not wait for it are told as well what is wrong."""


@dataclass(frozen=True)
class Submission:
    """What a client wants to have built.

    Attributes
    ----------
    data : bytes
        The characterisation, in any format that `gamutcore` reads.
    options : Options
        Checked, with explicit defaults.
    sha256 : str
        SHA-256 of the data, hexadecimal.
    """

    data: bytes
    options: Options
    sha256: str

    @property
    def gamut_id(self) -> str:
        """The id of the gamut that the data and the options define."""
        return gamut_id(self.options, self.sha256)


_Pairs: TypeAlias = "list[tuple[str, Any]]"
"""Names and values of options."""

_Read: TypeAlias = "Callable[[UploadFile | str], Awaitable[bytes]]"
"""Reads the part with the data into memory."""


class _Parser(MultiPartParser):
    """Starlette's parser, with files that grow on the disk of the store and have no name there.

    A body that never ends, or is refused at last, so takes no memory; /tmp may be read-only, or in
    memory itself.
    """

    spool_max_size = 1024 * 1024
    """Bytes of a file that are kept in memory."""

    scratch: Path

    def on_headers_finished(self) -> None:
        """Begin a part."""
        super().on_headers_finished()
        upload = self._current_part.file
        if upload is not None:
            self._files_to_close_on_error.pop().close()
            file = SpooledTemporaryFile[bytes](max_size=self.spool_max_size, dir=str(self.scratch))
            self._files_to_close_on_error.append(file)
            upload.file = cast("BinaryIO", file)


@contextlib.asynccontextmanager
async def submission(
    request: Request, settings: Settings, scratch: Path, large: asyncio.Semaphore
) -> AsyncIterator[Submission]:
    """Give the characterisation and options in a request, for as long as they are needed.

    Parameters
    ----------
    request : Request
    settings : Settings
    scratch : Path
        Directory where large files may be while they arrive.
    large : Semaphore
        Held from when a large file is read into memory until its data is needed no more: any number
        of clients may send large files at the same time, but few have them in memory.

    Raises
    ------
    ProblemError
        The media type, the syntax or the parts of the body are not accepted.
    OptionError
        An option is unknown or has a value that is not accepted.
    GamutError
        A few samples in the body are none; of many, and of files, the build tells.
    """
    async with contextlib.AsyncExitStack() as held:

        async def read(file: UploadFile | str) -> bytes:
            if isinstance(file, UploadFile) and (file.size or 0) > _Parser.spool_max_size:
                await held.enter_async_context(large)
            return await _content(file)

        with timed("body"):
            posted = await _submission(request, settings, scratch, read)
        yield posted


async def _submission(
    request: Request, settings: Settings, scratch: Path, read: _Read
) -> Submission:
    coding = request.headers.get("content-encoding", "").strip().lower()
    if coding not in {"", "identity"}:
        detail = f"The body is in the content coding {coding[:40]!r}."
        raise ProblemError(
            Problem(
                "unsupported-media-type",
                detail,
                {"header": "Content-Encoding"},
                "Send the body as it is.",
                {"Accept-Encoding": "identity"},  # RFC 9110, 12.5.3
            )
        )
    media_type = request.headers.get("content-type", "").partition(";")[0].strip().lower()
    if media_type == "multipart/form-data":
        data, pairs = await _multipart(request, settings.max_form_parts, scratch, read)
    elif media_type == "application/json":
        body = await _inline_body(request, settings.max_inline_bytes)
        data, pairs = await asyncio.to_thread(_inline, body)
    else:
        detail = f"The body is {media_type[:100] or 'of no stated media type'}."
        raise ProblemError(Problem("unsupported-media-type", detail, {"header": "Content-Type"}))
    options = Options.from_pairs(pairs)
    if options.surface_samples > settings.max_surface_samples:
        raise ProblemError(
            Problem(
                "invalid-option",
                f"surface_samples is {options.surface_samples}, more than this service accepts.",
                {"field": "surface_samples"},
                f"Ask for at most {settings.max_surface_samples}.",
            )
        )
    if media_type == "application/json" and len(data) <= _CHECKED_BYTES:
        await asyncio.to_thread(json_samples, data.decode(), condition=options.condition)
    # The only hash of the data until a build reads the data back.
    digest = await asyncio.to_thread(hashlib.sha256, data)
    return Submission(data, options, digest.hexdigest())


async def _inline_body(request: Request, limit: int) -> bytes:
    """Return a body that is small enough to be decoded while others wait."""
    body = bytearray()
    async for chunk in request.stream():
        body += chunk
        if len(body) > limit:
            raise ProblemError(
                Problem(
                    "body-too-large",
                    f"The JSON is larger than {limit} bytes.",
                    {"limit": limit},
                    "Send larger data as a file: multipart/form-data with a part `file`, which "
                    "may hold the same JSON.",
                )
            )
    return bytes(body)


async def _multipart(
    request: Request, most_parts: int, scratch: Path, read: _Read
) -> tuple[bytes, _Pairs]:
    parser = _Parser(
        request.headers,
        request.stream(),
        max_files=most_parts,
        max_fields=most_parts,
        max_part_size=_OPTIONS_BYTES,
    )
    parser.scratch = scratch
    try:
        form = await parser.parse()
    except MultiPartException as error:
        if error.message.startswith(("Too many", "Part exceeded")):
            raise ProblemError(
                Problem(
                    "body-too-large",
                    f"The form is too large: {error.message}",
                    {"limit": most_parts if error.message[0] == "T" else _OPTIONS_BYTES},
                    "Send the data as a part `file` with a file name, and options as fields.",
                )
            ) from error
        raise ProblemError(
            Problem("malformed-body", f"The multipart body cannot be parsed: {error.message}")
        ) from error
    try:
        return await _parts(form, read)
    finally:
        await form.close()


async def _parts(form: FormData, read: _Read) -> tuple[bytes, _Pairs]:
    """Return the file and the options of a form."""
    parts = form.multi_items()
    for name, part in parts:
        if name not in _PARTS and find_option(name) is None:
            _refuse_part(name)
        large = isinstance(part, UploadFile) and (part.size or 0) > _OPTIONS_BYTES
        if large and name != "file":
            _refuse(f"The part {name} is larger than {_OPTIONS_BYTES} bytes.", name)
    for name in _PARTS:
        if sum(part == name for part, _ in parts) > 1:
            _refuse(f"There is more than one part named {name}.", name)
    if "file" not in form:
        _refuse("There is no part named file.", "file")
    pairs = _options(_decoded(await _content(form.get("options", "{}")), "options"))
    for name, part in parts:
        if name not in _PARTS:
            text = (await _content(part)).decode(errors="replace")
            pairs.append((name, option_value(name, text)))
    return await read(form["file"]), pairs


def _refuse_part(name: str) -> NoReturn:
    known = (*_PARTS, *OPTIONS)
    meant = near_match(name, known)
    remedy = f"Did you mean {meant}? " if meant else ""
    raise ProblemError(
        Problem(
            "invalid-body",
            f"There is neither a part nor an option named {name[:80]!r}.",
            {"field": name[:80]},
            f"{remedy}A form has the part file and options: as fields of their own or, as JSON, in "
            f"the part options. Options are {', '.join(OPTIONS)}.",
        )
    )


async def _content(part: UploadFile | str) -> bytes:
    return await part.read() if isinstance(part, UploadFile) else part.encode()


def _inline(body: bytes) -> tuple[bytes, _Pairs]:
    document = _decoded(body)
    if not isinstance(document, dict):
        _refuse("The JSON is not an object.", "samples")
    if "samples" not in document:
        _refuse("The JSON object has no member samples.", "samples")
    pairs = _options(document.pop("options", {}))
    for name in document:
        if name in OPTIONS:
            # It would be taken for a condition of the measurement, and the option for its default.
            detail = f"The option {name} stands beside `options` and not in it."
            remedy = (
                f'Send it as in {{"samples": [...], "options": {{"{name}": ...}}}}; a condition of '
                "the measurement that has this name, in `conditions`."
            )
            raise ProblemError(Problem("invalid-body", detail, {"field": name}, remedy))
    try:
        canonical = json.dumps(
            document, sort_keys=True, separators=(",", ":"), ensure_ascii=True, allow_nan=False
        )
    except ValueError as error:
        # 1e999 is a number in JSON, and infinite once it is read.
        problem = Problem("malformed-body", "The JSON holds a number that is out of range.")
        raise ProblemError(problem) from error
    return canonical.encode(), pairs


def _options(mapping: object) -> _Pairs:
    if isinstance(mapping, dict):
        return list(mapping.items())
    raise ProblemError(
        Problem(
            "invalid-option",
            "The options are not a JSON object.",
            {"field": "options"},
            'Send them as in {"gamma": 0.2}.',
        )
    )


def _decoded(text: bytes, part: str | None = None) -> Any:  # noqa: ANN401 - JSON before its shape is known
    place: dict[str, Any] = {} if part is None else {"field": part}
    # Decoding makes an object of two or three bytes, so their number is bounded before.
    structures = text.count(b"[") + text.count(b"{")
    if structures > MAX_JSON_SAMPLES + 100 or text.count(b",") > _MOST_VALUES:
        detail = f"The JSON is larger than {MAX_JSON_SAMPLES} samples need."
        raise ProblemError(Problem("too-many-samples", detail, place))
    try:
        return json.loads(
            text.decode(), parse_constant=_refuse_constant, object_pairs_hook=_unrepeated
        )
    except json.JSONDecodeError as error:
        where = {**place, "line": error.lineno, "column": error.colno}
        problem = Problem("malformed-body", f"The JSON is broken: {error.msg}.", where)
    except UnicodeDecodeError as error:
        where = {**place, "byte": error.start}
        problem = Problem("malformed-body", "The JSON is not UTF-8.", where)
    except (ValueError, RecursionError):
        detail = "The JSON is nested too deeply, or has a number that is out of range."
        problem = Problem("malformed-body", detail, place)
    raise ProblemError(problem)


def _unrepeated(members: list[tuple[str, Any]]) -> dict[str, Any]:
    """Return an object, refusing names that come twice, as RFC 7493 (I-JSON), 2.3 does.

    Which of two values was meant is not ours to say, and the gamut's id would hide the choice.
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


def _refuse(detail: str, name: str) -> NoReturn:
    raise ProblemError(Problem("invalid-body", detail, {"field": name}))
