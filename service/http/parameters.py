"""What all operations ask of their parameters: known names, each once, plain numbers, whole ids.

A misspelt parameter that is ignored gives an answer to another question, without a word; the
operations under ``/v1`` refuse it instead and name those that they know. A value that is refused is
told with what would be right, which pydantic's own messages do not say to a client.
"""

import re
from collections import Counter

from fastapi import Request
from pydantic import BeforeValidator
from pydantic_core import PydanticCustomError

from service.problems.problem import Problem, ProblemError

__all__ = [
    "DECIMAL_NUMBER",
    "DECIMAL_PATTERN",
    "ID",
    "IDS",
    "ID_OR_NOTHING",
    "ID_PATTERN",
    "LARGEST_WHOLE",
    "POSITIVE_NUMBER",
    "WHOLE_NUMBER",
    "check_query",
]

LARGEST_WHOLE = 10**12 - 1
"""What twelve digits can say: more than any count here needs."""

DECIMAL_PATTERN = r"[0-9]{1,12}(?:\.[0-9]{1,20})?(?:[eE]-?[0-9]{1,2})?"
"""No sign, no infinity, no NaN; as many digits as a double is written with."""

ID_PATTERN = "[0-9a-f]{64}"
"""An id of a gamut and of its job: a digest."""

_LONGEST_SHOWN = 40
"""Characters of a parameter's name or value that a problem repeats."""


def _of_form(pattern: str, form: str, remedy: str) -> BeforeValidator:
    """Return what refuses texts that do not match, and says what they are not."""
    whole = re.compile(rf"(?:{pattern})\Z")

    def checked(value: object) -> object:
        if isinstance(value, str) and not whole.match(value):
            shown = repr(value[:_LONGEST_SHOWN])
            context = {"shown": shown, "form": form, "remedy": remedy}
            raise PydanticCustomError("form", "{shown} is not {form}", context)
        return value

    return BeforeValidator(checked)


WHOLE_NUMBER = _of_form(
    "[0-9]{1,12}",
    "a whole number of 1 to 12 decimal digits",
    "Give a plain whole number, such as 1000.",
)
"""Annotation of an integer in a query: decimal digits of ASCII only, without a sign."""

POSITIVE_NUMBER = _of_form(
    r"(?=[0-9]{1,12}\Z)0*[1-9][0-9]*",
    "a whole number from 1 on, of 1 to 12 decimal digits",
    "Give a plain whole number, such as 100.",
)
"""Annotation of an integer in a query that is not 0 either."""

DECIMAL_NUMBER = _of_form(
    DECIMAL_PATTERN,
    "a plain decimal number from 0 on",
    "Give a number such as 0.5 or 1e-4.",
)
"""Annotation of a number in a query: decimal digits of ASCII, not negative."""

_AN_ID = "an id, which is 64 hexadecimal digits in lower case"

ID = _of_form(ID_PATTERN, _AN_ID, "Give the `id` that POST /v1/gamuts or a list answered with.")
"""Annotation of the id of a gamut or job."""

ID_OR_NOTHING = _of_form(
    f"({ID_PATTERN})?", _AN_ID, "Give the `id` of the last entry, or follow `next`."
)
"""Annotation of where a page of a list begins."""

IDS = _of_form(
    f"{ID_PATTERN}(,{ID_PATTERN})*",
    "a list of ids, each of 64 hexadecimal digits in lower case",
    "Give ids of gamuts with a comma between them, as /v1/gamuts lists them.",
)
"""Annotation of one id or several."""


async def check_query(request: Request) -> None:
    """Refuse parameters that the request's operation does not have, and repeated ones.

    Raises
    ------
    ProblemError
        ``invalid-parameter``, with the operation's parameters.
    """
    known = [field.alias for field in request.scope["route"].dependant.query_params]
    for name, count in Counter(name for name, _ in request.query_params.multi_items()).items():
        shown = name[:_LONGEST_SHOWN]
        if name not in known:
            fault = f"There is no parameter {shown!r} here."
        elif count > 1:
            fault = f"The parameter {shown!r} is given {count} times."
        else:
            continue
        names = ", ".join(known)
        remedy = f"Give each at most once: {names}." if known else "Leave the query out."
        where = {"in": "query", "field": shown, "known": known}
        raise ProblemError(Problem("invalid-parameter", fault, where, remedy))
