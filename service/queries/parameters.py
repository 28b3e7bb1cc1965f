"""Parameters of queries: one declaration for the query string, the JSON body and OpenAPI.

A parameter may be given in the query string or, for a JSON body, as a member beside the colours.
"""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

from gamutcore.arguments import (
    Array,
    Boolean,
    Choice,
    Mark,
    Number,
    Text,
    WholeNumber,
    canonical,
    check_option,
    marks,
)
from gamutcore.errors import OptionError
from service.http.parameters import DECIMAL_PATTERN
from service.problems.problem import Problem, ProblemError

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

__all__ = ["Parameter", "query_values", "refuse", "values_of"]

_NUMBER = re.compile(rf"-?{DECIMAL_PATTERN}\Z")
_LONGEST_SHOWN = 40


@dataclass(frozen=True)
class Parameter:
    """The declaration of a parameter.

    Attributes
    ----------
    name : str
    kind : annotation
        The type of the values, as `gamutcore.arguments` has them.
    description : str
    default : object
        None if the parameter has no default.
    example : object
        As in JSON; None for no example.
    """

    name: str
    kind: Any
    description: str
    default: object = None
    example: object = None

    def checked(self, value: object, place: str) -> object:
        """Return the canonical form of a value; raises ``invalid-parameter`` if it has none."""
        try:
            return check_option(self.name, value, self.kind)
        except OptionError as error:
            detail = f"{self.name} is {repr(value)[:_LONGEST_SHOWN]}, which is not accepted."
            raise refuse(detail, place, self.name, error.remedy) from None

    def schema(self) -> dict[str, Any]:
        """Return the JSON schema of the values."""
        schemas = [_schema(each) for each in marks(self.kind)]
        schema = schemas[0] if len(schemas) == 1 else {"anyOf": schemas}
        if self.default is not None:
            schema = {**schema, "default": self.default}
        return schema

    def member(self) -> dict[str, Any]:
        """Return the JSON schema of the member of a JSON body."""
        return {**self.schema(), "description": self.description}

    def documentation(self) -> dict[str, Any]:
        """Return the parameter of the query string as OpenAPI describes it."""
        entry: dict[str, Any] = {
            "name": self.name,
            "in": "query",
            "required": False,
            "description": self.description,
            "schema": self.schema(),
        }
        if self.example is not None:
            entry["example"] = self.example
        return entry


def values_of(
    parameters: Iterable[Parameter], query: Mapping[str, object], body: Mapping[str, object]
) -> dict[str, Any]:
    """Return the values of all parameters, with the defaults.

    Parameters
    ----------
    parameters : iterable of Parameter
    query : mapping
        Values in the query string, as `query_values` returns them.
    body : mapping
        Members of a JSON body.

    Raises
    ------
    ProblemError
        A value is not accepted, or a parameter is given in both places.
    """
    values: dict[str, Any] = {}
    for each in parameters:
        if each.name in query and each.name in body:
            fault = f"{each.name} is given in the query string and in the body."
            raise refuse(fault, "query", each.name, "Give each parameter once.")
        if each.name in query:
            values[each.name] = query[each.name]
        elif each.name in body:
            values[each.name] = each.checked(body[each.name], "body")
        else:
            values[each.name] = each.default
    return values


def query_values(
    parameters: Iterable[Parameter], query: Iterable[tuple[str, str]]
) -> dict[str, Any]:
    """Return the checked values in a query string.

    Parameters
    ----------
    parameters : iterable of Parameter
    query : iterable of (str, str)
        Names and texts.

    Raises
    ------
    ProblemError
        A name is unknown or repeated, or a value is not accepted.
    """
    known = {each.name: each for each in parameters}
    items = list(query)
    values = {}
    for name, count in Counter(name for name, _ in items).items():
        shown = name[:_LONGEST_SHOWN]
        names = ", ".join(known)
        if name not in known:
            fault = f"There is no parameter {shown!r} here."
            raise refuse(fault, "query", shown, f"Give each at most once: {names}.")
        if count > 1:
            fault = f"The parameter {shown!r} is given {count} times."
            raise refuse(fault, "query", shown, f"Give each at most once: {names}.")
    for name, text in items:
        values[name] = known[name].checked(_from_text(text, known[name].kind), "query")
    return values


def refuse(detail: str, place: str, field: str, remedy: str) -> ProblemError:
    """Return the error of an invalid parameter."""
    where = {"in": place, "field": field}
    return ProblemError(Problem("invalid-parameter", detail, where, remedy))


def _from_text(text: str, kind: object) -> object:
    """Return the value that a text in a query string stands for, unchecked."""
    for each in marks(kind):
        match each:
            case Boolean():
                if text in {"true", "false"}:
                    return text == "true"
            case WholeNumber():
                if text.isascii() and text.isdigit() and len(text) <= 12:
                    return int(text)
            case Number():
                if _NUMBER.match(text):
                    return float(text)
            case Array():
                parts = text.split(",")
                if len(parts) > 1 and all(_NUMBER.match(part) for part in parts):
                    return [float(part) for part in parts]
            case Choice() | Text():
                if canonical(text, Annotated[str, each]) is not None:
                    return text
    return text


def _schema(mark: Mark) -> dict[str, Any]:
    match mark:
        case Boolean():
            return {"type": "boolean"}
        case Choice():
            return {"type": "string", "enum": list(mark.values)}
        case Number():
            least = "exclusiveMinimum" if mark.above_least else "minimum"
            most = "exclusiveMaximum" if mark.below_most else "maximum"
            return {"type": "number", least: mark.least, most: mark.most}
        case WholeNumber():
            return {"type": "integer", "minimum": mark.least, "maximum": mark.most}
        case Array():
            item, count = {"type": "number"}, mark.length
            return {"type": "array", "items": item, "minItems": count, "maxItems": count}
        case Text():
            return {"type": "string", "description": mark.accepted}
