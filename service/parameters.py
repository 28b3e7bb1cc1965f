"""What all operations ask of the parameters in a query: known names, each once, plain numbers.

A misspelt parameter that is ignored gives an answer to another question, without a word; the
operations under ``/v1`` refuse it instead and name those that they know.
"""

import re
from collections import Counter

from fastapi import Request
from pydantic import BeforeValidator
from pydantic_core import PydanticCustomError

from service.problems import Problem, ProblemError

__all__ = ["DECIMAL_NUMBER", "DECIMAL_PATTERN", "LARGEST_WHOLE", "WHOLE_NUMBER", "check_query"]

_DIGITS = re.compile(r"[0-9]{1,12}\Z")
"""No sign, no space, no other script's digits; twelve are more than any count here needs."""

LARGEST_WHOLE = 10**12 - 1
"""What these digits can say."""

DECIMAL_PATTERN = r"[0-9]{1,12}(?:\.[0-9]{1,20})?(?:[eE]-?[0-9]{1,2})?"
"""No sign, no infinity, no NaN; as many digits as a double is written with."""

_DECIMAL = re.compile(DECIMAL_PATTERN + r"\Z")

_LONGEST_NAME = 40
"""Characters of a parameter's name that a problem repeats."""


def _digits(value: object) -> object:
    if isinstance(value, str) and not _DIGITS.match(value):
        raise PydanticCustomError(
            "whole_number", "The value is not a whole number of 1 to 12 decimal digits"
        )
    return value


WHOLE_NUMBER = BeforeValidator(_digits)
"""Annotation of an integer in a query: decimal digits of ASCII only."""


def _decimal(value: object) -> object:
    if isinstance(value, str) and not _DECIMAL.match(value):
        raise PydanticCustomError(
            "decimal_number", "The value is not a decimal number from 0 on, such as 0.5 or 1e-4"
        )
    return value


DECIMAL_NUMBER = BeforeValidator(_decimal)
"""Annotation of a number in a query: decimal digits of ASCII, not negative."""


async def check_query(request: Request) -> None:
    """Refuse parameters that the request's operation does not have, and repeated ones.

    Raises
    ------
    ProblemError
        ``invalid-parameter``, with the operation's parameters.
    """
    known = [field.alias for field in request.scope["route"].dependant.query_params]
    for name, count in Counter(name for name, _ in request.query_params.multi_items()).items():
        shown = name[:_LONGEST_NAME]
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
