"""Reads the body of ``POST /v1/gamuts``: characterisation data and options.

``multipart/form-data`` has the part ``file`` and optionally ``options`` (JSON) and ``name``.
``application/json`` is an object. Its members ``options`` and ``name`` are removed, and the rest is
the characterisation, or names a reference gamut. It is serialised canonically (sorted members, no
white space), so the same samples give the same gamut id.
"""

from __future__ import annotations

import asyncio
import contextlib
import hashlib
import json
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple, NoReturn, TypeAlias

from gamutcore.arguments import check_option
from gamutcore.building import gamut_id
from gamutcore.characterisation.samples import json_samples
from gamutcore.errors import OptionError
from gamutcore.options import OPTIONS, Options, option_name, option_value
from gamutcore.references import find_reference, parse_definition
from service.access.rate_limits import client_of
from service.admission import Work
from service.http.bodies import FIELD_BYTES, IN_MEMORY, parse_json
from service.http.request_context import timed
from service.problems.problem import Problem, ProblemError
from service.storage.gamut_names import InvalidNameError, checked_name

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable, Iterable

    from fastapi import Request

    from service.container import ServiceContainer
    from service.http.bodies import Bodies, Body, Part
    from service.settings import Settings

__all__ = [
    "INLINE_BYTES",
    "MOST_SURFACE_SAMPLES",
    "Submission",
    "check_surface_samples",
    "submission",
    "submitted_name",
]

INLINE_BYTES = 1024 * 1024
"""Largest JSON body with inline samples. Decoding blocks other requests for about 0.1 s per MiB, so
larger data must be sent as a file."""

MOST_SURFACE_SAMPLES = 1_000_000
"""Largest value of the option. Its build takes 0.7 GB."""

_FORM_PARTS = 40
"""Largest number of fields in a form: all options, a file and a name are fewer."""

_SINGLE = frozenset({"file", "options", "name"})
"""Parts of a form that occur once. Others are options."""

_DECODED_SIZE = 30
"""Bytes of memory for a byte of JSON while it is decoded. The worst are short members: an entry of
a dictionary, its name, and the pair that it is made of."""

_AS_FILE = (
    "Send larger data as a file: multipart/form-data with a part `file`, which may hold the same "
    "JSON."
)

_NAME_BYTES = 8 * 1024
"""Largest body with a name; 200 characters may be 2,400 bytes of escapes."""

_CHECKED_BYTES = 16 * 1024
"""Inline samples up to this size are validated before the answer, in about a millisecond. So
clients that do not wait for the build also get errors."""


@dataclass(frozen=True)
class Submission:
    """A validated request to build a gamut: data in any format of `gamutcore`, and options.

    `sha256` is the hexadecimal digest of the data, `name` what the client calls the gamut, and
    `file` the name of the file; empty if it has none.
    """

    data: bytes
    options: Options
    sha256: str
    name: str | None = None
    file: str = ""

    @cached_property
    def gamut_id(self) -> str:
        """The id of the gamut that the data and the options define."""
        return gamut_id(self.options, self.sha256)


class SubmittedParts(NamedTuple):
    """The parts of a body before validation: data, options, names of the gamut and of the file."""

    data: bytes
    options: dict[str, Any]
    name: str | None
    file: str = ""


HoldMemory: TypeAlias = "Callable[[int], Awaitable[None]]"
"""Holds memory for data that is read from the disk."""


@contextlib.asynccontextmanager
async def submission(request: Request, service: ServiceContainer) -> AsyncIterator[Submission]:
    """Yield the characterisation data and the options of a request.

    Memory for the data is held until the end of the context. So many clients may send large data at
    once, but little of it is in memory. Raise `ProblemError` for the form of the body,
    `OptionError` for an option, and `GamutError` for a few inline samples that are invalid. Large
    data is validated by the build.
    """
    client, admission = client_of(request.scope), service.admission
    # Not by client, as answers are: nothing waits for the client to read it.
    data = admission.hold("answers", 0)

    async def hold(nbytes: int) -> None:
        if nbytes > IN_MEMORY:
            nbytes = min(nbytes, admission.most)  # a single body may exceed the budget
            with await admission.place(Work.VIEW, client, lambda: nbytes, nbytes):
                data.resize(nbytes)  # without a place, so that a slow store stops no other work

    try:
        with service.bodies.body(request, client) as body:
            posted = await _read_submission(request, service.settings, body, hold)
        yield posted
    finally:
        data.resize(0)


async def _read_submission(
    request: Request, settings: Settings, body: Body, hold: HoldMemory
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
    content_type = request.headers.get("content-type", "")
    media_type = content_type.partition(";")[0].strip().lower()
    if media_type == "multipart/form-data":
        sent = await _multipart(settings, body, hold)
    elif media_type == "application/json":
        with timed("body"):
            await body.receive(INLINE_BYTES, _AS_FILE)
        if not body.in_memory:
            await hold(body.size * _DECODED_SIZE)
        sent = await asyncio.to_thread(lambda: _inline(body.content()))
    else:
        detail = f"The media type of the body is {media_type[:100] or 'not given'}."
        raise ProblemError(Problem("unsupported-media-type", detail, {"header": "Content-Type"}))
    data, options = sent.data, Options.from_mapping(sent.options)
    check_surface_samples(options)
    if media_type == "application/json" and len(data) <= _CHECKED_BYTES:
        await asyncio.to_thread(_check_inline, data.decode(), options)
    # The data is not hashed again before a build reads it back.
    digest = await asyncio.to_thread(hashlib.sha256, data)
    return Submission(data, options, digest.hexdigest(), sent.name, sent.file)


def check_surface_samples(options: Options) -> None:
    """Raise a problem if more surface samples are requested than the service allows."""
    if options.surface_samples > MOST_SURFACE_SAMPLES:
        raise ProblemError(
            Problem(
                "invalid-option",
                f"surface_samples is {options.surface_samples}, over the limit of this service.",
                {"field": "surface_samples"},
                f"Give at most {MOST_SURFACE_SAMPLES}.",
            )
        )


async def submitted_name(request: Request, bodies: Bodies) -> str:
    """Return the name in the body of a request, an object with the member ``name``."""
    media_type = request.headers.get("content-type", "").partition(";")[0].strip().lower()
    if media_type != "application/json":
        detail = f"The media type of the body is {media_type[:100] or 'not given'}."
        remedy = 'Send application/json, such as {"name": "Coated offset"}.'
        where = {"header": "Content-Type"}
        raise ProblemError(Problem("unsupported-media-type", detail, where, remedy))
    with bodies.body(request, client_of(request.scope)) as body:
        await body.receive(_NAME_BYTES)
        document = _parse_json(body.content())
    if not isinstance(document, dict) or set(document) != {"name"}:
        raise ProblemError(
            Problem(
                "invalid-body",
                "The JSON is not an object with the member name alone.",
                {"field": "name"},
                'Send an object such as {"name": "Coated offset"}.',
            )
        )
    return _name_or_problem(document["name"])


async def _multipart(settings: Settings, body: Body, hold: HoldMemory) -> SubmittedParts:
    with timed("body"):
        parts = await body.form(settings.max_body_bytes, _FORM_PARTS)
    single: dict[str, Part] = {}
    fields: list[tuple[str, str]] = []
    for part in parts:
        if part.name in single:
            _refuse(f"There is more than one part named {part.name}.", part.name)
        if part.name in _SINGLE:
            single[part.name] = part
            continue
        option = _form_option(part.name)
        if part.file is not None:
            _refuse(f"The part {option} is a file.", option)
        fields.append((option, part.text))
    if "file" not in single:
        _refuse("There is no part named file.", "file")
    content = b"{}"
    if "options" in single:
        content = single["options"].text.encode()
        if single["options"].file is not None:
            content = await single["options"].file.read(FIELD_BYTES + 1)
        if len(content) > FIELD_BYTES:
            _refuse(f"The options are larger than {FIELD_BYTES} bytes.", "options")

    def stated_options() -> list[tuple[str, object]]:
        mapping = _options(_parse_json(content, "options"))
        options = [(option_name(name), value) for name, value in mapping.items()]
        return options + [(name, option_value(name, text)) for name, text in fields]

    options = _merge_options(await asyncio.to_thread(stated_options))
    name = None
    if "name" in single:
        name = _name_or_problem(None if single["name"].file is not None else single["name"].text)
    data, file = single["file"].content, single["file"].file
    if file is not None:
        await hold(file.size or 0)
        data = await file.read()
    return SubmittedParts(data, options, name, single["file"].file_name)


def _merge_options(pairs: Iterable[tuple[str, object]]) -> dict[str, object]:
    """Return options by name. An option may occur several times with the same value."""
    options: dict[str, object] = {}
    for name, value in pairs:
        other = options.setdefault(name, value)
        if other != value:
            kind = OPTIONS[name].kind
            if check_option(name, other, kind) != check_option(name, value, kind):
                shown = f"as {str(other)[:40]!r} and as {str(value)[:40]!r}"
                _refuse(f"The option {name} is given with different values: {shown}.", name)
    return options


def _form_option(name: str) -> str:
    """Return the name of the option that a form field is."""
    try:
        return option_name(name)
    except OptionError as error:
        detail = f"There is a part named {name[:80]!r}."
        remedy = f"Parts are file, name, options, and options by their names. {error.remedy}"
        problem = Problem("invalid-body", detail, {"field": name[:80]}, remedy)
        raise ProblemError(problem) from error


def _check_inline(text: str, options: Options) -> None:
    """Raise the error of a few inline samples, or of the options of a reference gamut."""
    if parse_definition(text) is None:
        json_samples(text, condition=options.condition)
    else:
        options.check_data("reference")


def _inline(text: bytearray) -> SubmittedParts:
    document = _parse_json(text)
    if not isinstance(document, dict):
        _refuse("The JSON is not an object.", "samples")
    if "reference" in document and "samples" not in document:
        return _inline_reference(document)
    if "samples" not in document:
        _refuse("The JSON object has no member samples.", "samples")
    mapping = _options(document.pop("options", {}))
    named = _name_or_problem(document.pop("name")) if "name" in document else None
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
    return SubmittedParts(canonical.encode(), mapping, named)


def _inline_reference(document: dict[str, Any]) -> SubmittedParts:
    """Return the definition of a reference gamut: the same data for all of its names."""
    for name in document:
        if name not in {"reference", "options"}:
            _refuse(f"There is a member {name[:80]!r} beside reference and options.", name[:80])
    if not isinstance(document["reference"], str):
        _refuse("The member reference is not the slug of a reference gamut.", "reference")
    reference = find_reference(document["reference"])
    return SubmittedParts(reference.data, _options(document.get("options", {})), None)


def _name_or_problem(text: object) -> str:
    """Return a name in its canonical form; raises the problem if it is none."""
    try:
        return checked_name(text)
    except InvalidNameError as error:
        raise ProblemError(Problem("invalid-name", str(error), {"field": "name"})) from error


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


def _parse_json(text: bytes | bytearray, part: str | None = None) -> Any:  # noqa: ANN401 - JSON before its shape is known
    place: dict[str, Any] = {} if part is None else {"field": part}
    return parse_json(text, place)


def _refuse(detail: str, name: str) -> NoReturn:
    raise ProblemError(Problem("invalid-body", detail, {"field": name}))
