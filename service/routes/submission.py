"""Reads the body of ``POST /v1/gamuts``: characterisation data and options.

``multipart/form-data`` has the part ``file`` and optionally ``options`` (JSON).
``application/json`` is an object; its member ``options`` is removed, and the rest is the
characterisation. It is serialised canonically (sorted members, no white space), so the same samples
give the same gamut id.
"""

from __future__ import annotations

import asyncio
import contextlib
import hashlib
import json
from dataclasses import dataclass
from tempfile import SpooledTemporaryFile
from typing import TYPE_CHECKING, Any, BinaryIO, NoReturn, TypeAlias, cast

from starlette.datastructures import UploadFile
from starlette.formparsers import MultiPartException, MultiPartParser

from gamutcore.characterisation.json_samples import MAX_JSON_SAMPLES, json_samples
from gamutcore.errors import OptionError
from gamutcore.gamut import Options, gamut_id
from gamutcore.option_types import check_option
from gamutcore.options import OPTIONS, option_name, option_value
from service.problems.problem import Problem, ProblemError
from service.telemetry.server_timing import timed

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable, Iterable
    from pathlib import Path

    from fastapi import Request

    from service.settings import Settings

__all__ = ["Submission", "submission"]

_MOST_VALUES = 8_000_000
"""Largest number of values in a JSON body. A decoded value takes up to 32 bytes."""

_OPTIONS_BYTES = 64 * 1024
"""Largest size of the part ``options``, a hundred times that of all options."""

_CHECKED_BYTES = 16 * 1024
"""Inline samples up to this size are validated before the answer, in about a millisecond. So
clients that do not wait for the build also get errors."""


@dataclass(frozen=True)
class Submission:
    """A validated request to build a gamut.

    Attributes
    ----------
    data : bytes
        Characterisation data in any format of `gamutcore`.
    options : Options
        With explicit defaults.
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


_Read: TypeAlias = "Callable[[UploadFile | str], Awaitable[bytes]]"
"""Reads the part with the data into memory."""


class _Parser(MultiPartParser):
    """Starlette's parser with unnamed temporary files in the store's directory.

    Large bodies therefore take no memory. /tmp may be read-only, or in memory.
    """

    spool_max_size = 1024 * 1024
    """Bytes of a file that stay in memory."""

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
    """Yield the characterisation data and the options of a request.

    Parameters
    ----------
    request : Request
    settings : Settings
    scratch : Path
        Directory of temporary files.
    large : Semaphore
        Held while a large file is in memory. Many clients may send large files at once, but few
        files are in memory.

    Raises
    ------
    ProblemError
        The media type, the syntax or the parts of the body are not accepted.
    OptionError
        An option is unknown or has an invalid value.
    GamutError
        A few inline samples are invalid. Large data is validated by the build.
    """
    async with contextlib.AsyncExitStack() as held:

        async def read(file: UploadFile | str) -> bytes:
            if isinstance(file, UploadFile) and (file.size or 0) > _Parser.spool_max_size:
                await held.enter_async_context(large)
            return await _read_part(file)

        with timed("body"):
            posted = await _read_submission(request, settings, scratch, read)
        yield posted


async def _read_submission(
    request: Request, settings: Settings, scratch: Path, read: _Read
) -> Submission:
    coding = request.headers.get("content-encoding", "").strip().lower()
    if coding not in {"", "identity"}:
        detail = f"The body has the content coding {coding[:40]!r}."
        raise ProblemError(
            Problem(
                "unsupported-media-type",
                detail,
                {"header": "Content-Encoding"},
                "Send the body without a content coding.",
                {"Accept-Encoding": "identity"},  # RFC 9110, 12.5.3
            )
        )
    media_type = request.headers.get("content-type", "").partition(";")[0].strip().lower()
    if media_type == "multipart/form-data":
        data, mapping = await _multipart(request, settings.max_form_parts, scratch, read)
    elif media_type == "application/json":
        body = await _inline_body(request, settings.max_inline_bytes)
        data, mapping = await asyncio.to_thread(_inline, body)
    else:
        detail = f"The media type of the body is {media_type[:100] or 'not given'}."
        raise ProblemError(Problem("unsupported-media-type", detail, {"header": "Content-Type"}))
    options = Options.from_mapping(mapping)
    if options.surface_samples > settings.max_surface_samples:
        raise ProblemError(
            Problem(
                "invalid-option",
                f"surface_samples is {options.surface_samples}, over the limit of this service.",
                {"field": "surface_samples"},
                f"Give at most {settings.max_surface_samples}.",
            )
        )
    if media_type == "application/json" and len(data) <= _CHECKED_BYTES:
        await asyncio.to_thread(json_samples, data.decode(), condition=options.condition)
    # The only hash of the data until a build reads the data back.
    digest = await asyncio.to_thread(hashlib.sha256, data)
    return Submission(data, options, digest.hexdigest())


async def _inline_body(request: Request, limit: int) -> bytes:
    """Return a body that is small enough to be decoded on the event loop."""
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
) -> tuple[bytes, dict[str, Any]]:
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
                    "Send the data as the part `file` with a file name, and options as fields.",
                )
            ) from error
        raise ProblemError(
            Problem("malformed-body", f"The multipart body cannot be parsed: {error.message}")
        ) from error
    try:
        parts = form.multi_items()
        for name in ("file", "options"):
            if sum(part == name for part, _ in parts) > 1:
                _refuse(f"There is more than one part named {name}.", name)
        fields = [
            _option_field(name, part) for name, part in parts if name not in {"file", "options"}
        ]
        file = form.get("file")
        if file is None:
            _refuse("There is no part named file.", "file")
        options = form.get("options", "{}")
        if isinstance(options, UploadFile) and (options.size or 0) > _OPTIONS_BYTES:
            _refuse(f"The options are larger than {_OPTIONS_BYTES} bytes.", "options")
        mapping = _options(_parse_json(await _read_part(options), "options"))
        given = [(option_name(name), value) for name, value in mapping.items()]
        given += fields
        return await read(file), _merge_options(given)
    finally:
        await form.close()


def _merge_options(given: Iterable[tuple[str, object]]) -> dict[str, object]:
    """Return options by name. An option may occur several times with the same value."""
    options: dict[str, object] = {}
    for name, value in given:
        other = options.setdefault(name, value)
        if other != value:
            types = OPTIONS[name].types
            if check_option(name, other, *types) != check_option(name, value, *types):
                shown = f"as {str(other)[:40]!r} and as {str(value)[:40]!r}"
                _refuse(f"The option {name} is given with different values: {shown}.", name)
    return options


def _option_field(given: str, part: UploadFile | str) -> tuple[str, object]:
    """Return the name and the value of an option that is a form field of its own."""
    try:
        name = option_name(given)
    except OptionError as error:
        detail = f"There is a part named {given[:80]!r}."
        remedy = f"Parts are file, options, and options by their names. {error.remedy}"
        problem = Problem("invalid-body", detail, {"field": given[:80]}, remedy)
        raise ProblemError(problem) from error
    if isinstance(part, UploadFile):
        _refuse(f"The part {name} is a file.", name)
    return name, option_value(name, part)


async def _read_part(part: UploadFile | str) -> bytes:
    return await part.read() if isinstance(part, UploadFile) else part.encode()


def _inline(body: bytes) -> tuple[bytes, dict[str, Any]]:
    document = _parse_json(body)
    if not isinstance(document, dict):
        _refuse("The JSON is not an object.", "samples")
    if "samples" not in document:
        _refuse("The JSON object has no member samples.", "samples")
    mapping = _options(document.pop("options", {}))
    for name in document:
        if name in OPTIONS:
            # It would count as a measurement condition, and the option would keep its default.
            detail = f"The option {name} is beside `options`, not inside."
            remedy = (
                f'Send {{"samples": [...], "options": {{"{name}": ...}}}}. Send a measurement '
                "condition of this name in `conditions`."
            )
            raise ProblemError(Problem("invalid-body", detail, {"field": name}, remedy))
    try:
        canonical = json.dumps(
            document, sort_keys=True, separators=(",", ":"), ensure_ascii=True, allow_nan=False
        )
    except ValueError as error:
        # 1e999 is valid JSON, but infinite as a double.
        problem = Problem("malformed-body", "A number in the JSON is out of range.")
        raise ProblemError(problem) from error
    return canonical.encode(), mapping


def _options(mapping: object) -> dict[str, Any]:
    if isinstance(mapping, dict):
        return mapping
    raise ProblemError(
        Problem(
            "invalid-option",
            "The options are not a JSON object.",
            {"field": "options"},
            'Send an object such as {"gamma": 0.2}.',
        )
    )


def _parse_json(text: bytes, part: str | None = None) -> Any:  # noqa: ANN401 - JSON before its shape is known
    place: dict[str, Any] = {} if part is None else {"field": part}
    # Decoding makes an object of two or three bytes, so the number is limited before.
    structures = text.count(b"[") + text.count(b"{")
    if structures > MAX_JSON_SAMPLES + 100 or text.count(b",") > _MOST_VALUES:
        detail = f"The JSON has more than {MAX_JSON_SAMPLES} samples."
        raise ProblemError(Problem("too-many-samples", detail, place))
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


def _refuse(detail: str, name: str) -> NoReturn:
    raise ProblemError(Problem("invalid-body", detail, {"field": name}))
