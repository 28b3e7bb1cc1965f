"""Tables of colours as CSV: read as everywhere, with the space and the scale of the API."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gamutcore.errors import (
    MalformedFileError,
    MissingColumnError,
    SampleLimitError,
    UnrecognisedFormatError,
)
from gamutcore.tables import read_table
from service.problems.problem import Problem, ProblemError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from gamutcore.colours.spaces.conversion import ColourConversion
    from gamutcore.tables import ColourTable

__all__ = ["read_colours"]

_SCALED = frozenset({"sRGB", "CIEXYZ"})
"""Spaces that tables have on several scales. That of the API is 0 to 1."""


def read_colours(
    content: bytearray, names: Sequence[str], given: ColourConversion, most: int
) -> ColourTable:
    """Return the table in a body.

    Parameters
    ----------
    content : bytearray
    names : sequence of str
        Names of the colours of a row. With several, columns have them as a prefix: ``from_L``.
    given : ColourConversion
        From the space of the colours.
    most : int
        Largest number of rows.

    Raises
    ------
    ProblemError
        There are no such columns, the table is malformed, or there are too many rows.
    InvalidPointsError
        A cell is not a number, or outside the scale of the space.
    """
    try:
        return read_table(
            bytes(content),
            space=given.name,
            names=names,
            scale=1.0 if given.name in _SCALED else None,
            most=most,
            limits=given.unscaled,
        )
    except SampleLimitError as error:
        raise ProblemError(Problem("too-many-rows", error.message, {"limit": most})) from error
    except (MissingColumnError, MalformedFileError, UnrecognisedFormatError) as error:
        raise ProblemError(
            Problem("invalid-body", error.message, error.where, error.remedy)
        ) from error
