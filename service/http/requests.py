"""Requests as a whole: HEAD for every GET, plain paths, and validation of parameters.

The operations under ``/v1`` refuse unknown parameters, because an ignored misspelling would answer
another question. Messages state the accepted form, which pydantic's messages do not.
"""

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Annotated

from fastapi import Query, Request
from fastapi.dependencies.utils import get_flat_params
from fastapi.exceptions import RequestValidationError
from fastapi.params import Header, Path
from pydantic import BeforeValidator, ValidationError
from pydantic_core import PydanticCustomError
from starlette.routing import BaseRoute, Match
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from gamutcore.levels import Side
from gamutcore.names import near_match
from gamutcore.references import REFERENCES
from service.problems.problem import Problem, ProblemError

__all__ = [
    "DECIMAL_NUMBER",
    "DECIMAL_PATTERN",
    "GAMUT_ID",
    "GAMUT_IDS",
    "GAMUT_PATTERN",
    "ID",
    "ID_OR_NOTHING",
    "ID_PATTERN",
    "LARGEST_WHOLE",
    "LONGEST_SHOWN",
    "POSITIVE_NUMBER",
    "WHOLE_NUMBER",
    "ControlCharacters",
    "HeadAsGet",
    "SideName",
    "check_items",
    "check_names",
    "check_query",
    "invalid_parameter",
    "request_error",
]

LARGEST_WHOLE = 10**12 - 1
"""Largest number of twelve digits."""

DECIMAL_PATTERN = r"[0-9]{1,12}(?:\.[0-9]{1,20})?(?:[eE]-?[0-9]{1,2})?"
"""A decimal number without sign, infinity or NaN, with up to the digits of a double."""

ID_PATTERN = "[0-9a-f]{64}"
"""Id of a gamut and of its job: a digest."""

_CONTROL = re.compile(r"[\x00-\x1f\x7f]")

_PARTIAL = frozenset({b"range", b"if-range"})
"""Header fields that ask for a part of the content."""

LONGEST_SHOWN = 40
"""Number of characters of a name or value that a problem repeats."""


def _of_form(pattern: str, form: str, remedy: str, names: Iterable[str] = ()) -> BeforeValidator:
    """Return a validator that refuses text that does not match `pattern`.

    The message suggests the nearest of `names`.
    """
    whole = re.compile(rf"(?:{pattern})\Z")

    def checked(value: object) -> object:
        if isinstance(value, str) and not whole.match(value):
            shown = repr(value[:LONGEST_SHOWN])
            meant = near_match(value.rpartition(",")[2], names)
            said = f"Did you mean {meant}? {remedy}" if meant else remedy
            context = {"shown": shown, "form": form, "remedy": said}
            raise PydanticCustomError("form", "{shown} is not {form}", context)
        return value

    return BeforeValidator(checked)


WHOLE_NUMBER = _of_form(
    "[0-9]{1,12}",
    "a whole number of 1 to 12 decimal digits",
    "Give a plain whole number, such as 1000.",
)
"""Annotation of an integer parameter: ASCII digits without a sign."""

POSITIVE_NUMBER = _of_form(
    r"(?=[0-9]{1,12}\Z)0*[1-9][0-9]*",
    "a whole number from 1 on, of 1 to 12 decimal digits",
    "Give a plain whole number, such as 100.",
)
"""Annotation of an integer parameter greater than 0."""

DECIMAL_NUMBER = _of_form(
    DECIMAL_PATTERN,
    "a plain decimal number from 0 on",
    "Give a number such as 0.5 or 1e-4.",
)
"""Annotation of a non-negative decimal parameter."""

_AN_ID = "an id, which is 64 hexadecimal digits in lower case"

ID = _of_form(ID_PATTERN, _AN_ID, "Give an `id` from POST /v1/gamuts or from a list.")
"""Annotation of the id of a job."""

_GAMUT = f"(?:{ID_PATTERN}|{'|'.join(REFERENCES)})"

GAMUT_ID = _of_form(
    _GAMUT,
    f"{_AN_ID}, or the slug of a reference gamut",
    "Give an `id` from POST /v1/gamuts or from a list, or a slug from /v1/references.",
    REFERENCES,
)
"""Annotation of the id of a gamut, or the slug of a reference gamut."""

GAMUT_PATTERN = "[0-9a-z]+(-[0-9a-z]+)*"
"""Id of a gamut, or slug of a reference gamut."""

ID_OR_NOTHING = _of_form(
    f"({ID_PATTERN})?", _AN_ID, "Give the `id` of the last entry, or follow `next`."
)
"""Annotation of the start of a page of a list."""

GAMUT_IDS = _of_form(
    f"{_GAMUT}(,{_GAMUT})*",
    "a list of ids, each of 64 hexadecimal digits in lower case, or of slugs of reference gamuts",
    "Give ids from /v1/gamuts or slugs from /v1/references, separated by commas.",
    REFERENCES,
)
"""Annotation of one or more ids of gamuts or slugs."""

SideName = Annotated[
    Side,
    Query(
        alias="side",
        description="`inside`: the mesh is contained in the full boundary. `outside`: it contains "
        "the full boundary. `both`: the most accurate mesh, which crosses the full boundary. On "
        "one side, device values are those of the vertices before they were moved there. Very "
        "thin bodies may get fewer triangles than requested.",
        examples=["both"],
    ),
]
"""A query parameter of the operations on levels."""


async def check_query(request: Request) -> None:
    """Refuse unknown and repeated query parameters."""
    check_items(request, request.query_params.multi_items())


def check_items(
    request: Request, items: list[tuple[str, str]], options: Iterable[str] = ()
) -> None:
    """Refuse unknown and repeated parameters among `items` of the query.

    Raise ``invalid-parameter``, with the names that the operation accepts, and with `options`.
    """
    if not items:
        return
    parameters = get_flat_params(request.scope["route"].dependant)
    # Fields of a model of the query have no class of FastAPI.
    known = [each.alias for each in parameters if not isinstance(each.field_info, Path | Header)]
    check_names(items, (*known, *options))


def check_names(items: Iterable[tuple[str, str]], known: Sequence[str]) -> None:
    """Refuse names of a query that are not among `known`, or repeated."""
    for name, count in Counter(name for name, _ in items).items():
        shown = name[:LONGEST_SHOWN]
        if name not in known:
            fault = f"There is no parameter {shown!r} here."
        elif count > 1:
            fault = f"The parameter {shown!r} is given {count} times."
        else:
            continue
        remedy = f"Give each at most once: {', '.join(known)}." if known else "Leave the query out."
        where = {"in": "query", "field": shown, "known": list(known)}
        raise ProblemError(Problem("invalid-parameter", fault, where, remedy))


def invalid_parameter(detail: str, place: str, field: str, remedy: str) -> ProblemError:
    """Return the error of an invalid parameter in the query, the path or the body."""
    where = {"in": place, "field": field}
    return ProblemError(Problem("invalid-parameter", detail, where, remedy))


def request_error(error: ValidationError, *place: str) -> RequestValidationError:
    """Return the error that FastAPI raises, of a value that the service validates itself."""
    faults = error.errors(include_url=False, include_input=False)
    return RequestValidationError([{**fault, "loc": (*place, *fault["loc"])} for fault in faults])


class HeadAsGet:
    """Answer HEAD as GET without the content (RFC 9110, section 9.3.2)."""

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass HEAD on as GET and drop the content of the answer."""
        if scope["type"] != "http" or scope["method"] != "HEAD":
            await self.app(scope, receive, send)
            return

        async def send_without_content(message: Message) -> None:
            # End the answer after the header fields. Generators of long content then see a
            # disconnect.
            if message["type"] == "http.response.start":
                await send(message)
                await send({"type": "http.response.body", "body": b""})

        # Ranges are defined for GET only (section 14.2).
        headers = [field for field in scope["headers"] if field[0] not in _PARTIAL]
        as_get = {**scope, "method": "GET", "headers": headers}
        try:
            await self.app(as_get, receive, send_without_content)
        finally:
            # The outer middleware needs the matched route.
            scope["route"] = as_get.get("route")


class ControlCharacters(BaseRoute):
    """Answers paths with control characters with ``not-found``, ahead of all other routes.

    Their patterns end in ``$``, which also matches before a final newline.
    """

    def matches(self, scope: Scope) -> tuple[Match, Scope]:
        """Match paths with control characters."""
        match = scope["type"] == "http" and _CONTROL.search(scope["path"])
        return (Match.FULL if match else Match.NONE), {}

    async def handle(self, scope: Scope, receive: Receive, send: Send) -> None:  # noqa: ARG002
        """Raise the problem."""
        detail = "There is nothing at a path with control characters."
        raise ProblemError(Problem("not-found", detail))
