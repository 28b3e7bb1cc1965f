"""Strict JSON: no repeated members, no constants beyond RFC 8259, and problems with their place."""

from __future__ import annotations

import json
from typing import Any, NoReturn

from service.problems.problem import Problem, ProblemError

__all__ = ["parse_json"]


def parse_json(text: bytes | bytearray, place: dict[str, Any] | None = None) -> Any:  # noqa: ANN401 - JSON before its shape is known
    """Return the value of a JSON text.

    Parameters
    ----------
    text : bytes or bytearray
    place : dict, optional
        Where the text is, for problems.

    Raises
    ------
    ProblemError
        ``malformed-body`` if it is no JSON; ``invalid-body`` if the name of a member is repeated.
    """
    place = place or {}
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
