"""Parameters of queries: one declaration for the query string, the JSON body and OpenAPI.

A parameter may be given in the query string or, for a JSON body, as a member beside the colours.
"""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from gamutcore.option_types import (
    Choice,
    Number,
    OptionType,
    Text,
    Vector,
    WholeNumber,
    WholeNumbers,
    accepted_values,
    finite_number,
    near_match,
)
from service.http.parameters import DECIMAL_PATTERN
from service.problems.problem import Problem, ProblemError

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

__all__ = ["Boolean", "Numbers", "Parameter", "query_values", "refuse", "values_of"]

_NUMBER = re.compile(rf"-?{DECIMAL_PATTERN}\Z")
_LONGEST_SHOWN = 40


@dataclass(frozen=True)
class Boolean:
    """True or false."""

    accepted = "true or false"

    def canonical(self, value: object) -> bool | None:
        """Return the value, or None."""
        return value if isinstance(value, bool) else None


@dataclass(frozen=True)
class Numbers:
    """A fixed number of finite numbers."""

    count: int

    @property
    def accepted(self) -> str:
        """What is accepted, as it follows "Give" in a message."""
        return f"{self.count} numbers"

    def canonical(self, value: object) -> tuple[float, ...] | None:
        """Return the numbers, or None."""
        if not isinstance(value, list | tuple) or len(value) != self.count:
            return None
        found = tuple(number for number in map(finite_number, value) if number is not None)
        return found if len(found) == self.count else None


ParameterType = OptionType | Boolean | Numbers


@dataclass(frozen=True)
class Parameter:
    """The declaration of a parameter.

    Attributes
    ----------
    name : str
    types : tuple of ParameterType
        A value must be of one of them.
    description : str
    default : object
        None if the parameter has no default.
    example : object
        As in JSON; None for no example.
    """

    name: str
    types: tuple[ParameterType, ...]
    description: str
    default: object = None
    example: object = None

    def checked(self, value: object, place: str) -> object:
        """Return the canonical form of a value; raises ``invalid-parameter`` if it has none."""
        for each in self.types:
            canonical = each.canonical(value)
            if canonical is not None:
                return canonical
        shown = repr(value)[:_LONGEST_SHOWN]
        accepted = " or ".join(each.accepted for each in self.types)
        names = [
            str(name) for each in self.types if isinstance(each, Choice) for name in each.values
        ]
        meant = near_match(value, names) if isinstance(value, str) else None
        remedy = f"Give {accepted}." + (f" Did you mean {meant!r}?" if meant else "")
        raise refuse(f"{self.name} is {shown}, which is not accepted.", place, self.name, remedy)

    def schema(self) -> dict[str, Any]:
        """Return the JSON schema of the values."""
        schemas = [_schema(each) for each in self.types]
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
        values[name] = known[name].checked(_from_text(text, known[name].types), "query")
    return values


def refuse(detail: str, place: str, field: str, remedy: str) -> ProblemError:
    """Return the error of an invalid parameter."""
    where = {"in": place, "field": field}
    return ProblemError(Problem("invalid-parameter", detail, where, remedy))


def _from_text(text: str, types: Iterable[ParameterType]) -> object:
    """Return the value that a text in a query string stands for, unchecked."""
    for each in types:
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
            case Vector() | WholeNumbers() | Numbers():
                parts = text.split(",")
                if len(parts) > 1 and all(_NUMBER.match(part) for part in parts):
                    return [float(part) for part in parts]
            case Choice() | Text():
                if each.canonical(text) is not None:
                    return text
    return text


def _schema(kind: ParameterType) -> dict[str, Any]:
    match kind:
        case Boolean():
            return {"type": "boolean"}
        case Choice():
            return {"type": "string", "enum": list(kind.values)}
        case Number():
            least = "exclusiveMinimum" if kind.above_least else "minimum"
            most = "exclusiveMaximum" if kind.below_most else "maximum"
            return {"type": "number", least: kind.least, most: kind.most}
        case WholeNumber():
            return {"type": "integer", "minimum": kind.least, "maximum": kind.most}
        case Vector() | Numbers():
            count = kind.count if isinstance(kind, Numbers) else 3
            item = {"type": "number"}
            return {"type": "array", "items": item, "minItems": count, "maxItems": count}
        case _:
            return {"type": "string", "description": accepted_values([kind])}
