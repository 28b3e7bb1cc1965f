"""Parameters of questions in HTTP: texts of query strings, members of bodies, OpenAPI, problems.

`gamutcore.questions` declares them. A parameter may be given in the query string or, for a JSON
body, as a member beside the colours.
"""

from __future__ import annotations

import re
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
from service.http.requests import DECIMAL_PATTERN, LONGEST_SHOWN, check_names
from service.problems.problem import Problem, ProblemError

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from gamutcore.questions import Parameter, Question

__all__ = [
    "check_alternatives",
    "description",
    "documentation",
    "query_values",
    "refuse",
    "schema",
    "values_of",
]

_NUMBER = re.compile(rf"-?{DECIMAL_PATTERN}\Z")

_NOTES = {
    "space": " In the query string of a slug, `space` is the option of the build instead.",
}
"""What is particular to HTTP about a parameter."""


def checked(parameter: Parameter, value: object, place: str) -> object:
    """Return the canonical form of a value; raises ``invalid-parameter`` if it has none."""
    name = parameter.name
    try:
        return check_option(name, value, parameter.kind)
    except OptionError as error:
        detail = f"{name} is {repr(value)[:LONGEST_SHOWN]}, which is not accepted."
        raise refuse(detail, place, name, error.remedy) from None


def check_alternatives(question: Question, values: Mapping[str, object]) -> None:
    """Refuse none or several of parameters of which one is needed."""
    names = question.alternatives
    arguments = [name for name in names if values[name] is not None]
    if names and len(arguments) != 1:
        verb = "are" if len(arguments) > 1 else "is"
        fault = f"{' and '.join(arguments) or f'No {names[-1]}'} {verb} given."
        remedy = f"Give one of {', '.join(names[:-1])} and {names[-1]}."
        raise refuse(fault, "query", arguments[1] if arguments else names[0], remedy)


def schema(parameter: Parameter) -> dict[str, Any]:
    """Return the JSON schema of the values."""
    schemas = [_schema(each) for each in marks(parameter.kind)]
    values = schemas[0] if len(schemas) == 1 else {"anyOf": schemas}
    if parameter.default is not None:
        values = {**values, "default": parameter.default}
    return values


def description(parameter: Parameter) -> str:
    """Return the description for clients of the service."""
    return parameter.description + _NOTES.get(parameter.name, "")


def documentation(parameters: Iterable[Parameter]) -> list[dict[str, Any]]:
    """Return the parameters of a query string as OpenAPI describes them."""
    return [
        {
            "name": each.name,
            "in": "query",
            "required": False,
            "description": description(each),
            "schema": schema(each),
            **({} if each.example is None else {"example": each.example}),
        }
        for each in parameters
    ]


def values_of(
    parameters: Iterable[Parameter], query: Mapping[str, object], body: Mapping[str, object]
) -> dict[str, Any]:
    """Return the values of all parameters, with the defaults.

    `query` has values as `query_values` returns them, and `body` the members of a JSON body. Raise
    ``invalid-parameter`` if a member is not accepted, or a parameter is given in both places.
    """
    values: dict[str, Any] = {}
    for each in parameters:
        if each.name in query and each.name in body:
            fault = f"{each.name} is given in the query string and in the body."
            raise refuse(fault, "query", each.name, "Give each parameter once.")
        if each.name in query:
            values[each.name] = query[each.name]
        elif each.name in body:
            values[each.name] = checked(each, body[each.name], "body")
        else:
            values[each.name] = each.default
    return values


def query_values(
    parameters: Iterable[Parameter], query: Iterable[tuple[str, str]]
) -> dict[str, Any]:
    """Return the checked values in a query string, from names and texts.

    Raise ``invalid-parameter`` if a name is unknown or repeated, or a value is not accepted.
    """
    known = {each.name: each for each in parameters}
    items = list(query)
    check_names(items, list(known))
    return {
        name: checked(known[name], _from_text(text, known[name].kind), "query")
        for name, text in items
    }


def refuse(detail: str, place: str, field: str, remedy: str) -> ProblemError:
    """Return the error of an invalid parameter."""
    where = {"in": place, "field": field}
    return ProblemError(Problem("invalid-parameter", detail, where, remedy))


def _from_text(text: str, kind: object) -> object:
    """Return the value that a text in a query string stands for, unchecked."""
    for each in sorted(marks(kind), key=lambda mark: isinstance(mark, Text)):  # a number is a text
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
