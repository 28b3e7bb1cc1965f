"""Colours of data frames, found by the names of the columns.

pandas, polars and others have `columns`, and a column by its name. Neither is imported.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from gamutcore.errors import InvalidPointsError, MissingColumnError
from gamutcore.tables.columns import (
    axes_of,
    find_columns,
    on_full_scale,
    space_named,
)
from gamutcore.tables.css_colours import css_colour

__all__ = ["FrameColours", "frame_colours"]


class FrameColours(NamedTuple):
    """Colours (n, 3), and their space."""

    points: Any
    space: str


def frame_colours(
    frame: object, space: str | None, own: str, *, limits: bool = True
) -> FrameColours | None:
    """Return the colours of a data frame; None if an object is none, or has no names of columns.

    Parameters
    ----------
    frame : object
    space : str or None
        The space that the caller names.
    own : str
        Space of the gamut, whose coordinates come first.
    limits : bool, optional
        Whether coordinates outside the scale of the gamut's space are refused.

    Raises
    ------
    MissingColumnError
        There are no columns of a colour, or several sets of them.
    InvalidPointsError
        Values are no numbers, are outside the scale, or fit several scales.
    """
    titles = getattr(frame, "columns", None)
    if titles is None or not hasattr(frame, "__getitem__"):
        return None
    names = list(titles)
    if not names or not all(isinstance(name, str) for name in names):
        return None
    given = None if space is None else space_named(space)
    try:
        found = find_columns(names, space=given, own=own)
    except MissingColumnError:
        if given is not None and len(names) == 3:  # the caller says what three columns are
            return None
        raise
    if found.space == own and not limits:
        found = replace(found, kind="")
    picked = [np.asarray(frame[names[place]]) for place in found.places]
    if found.kind == "TEXT":
        colours = [css_colour(str(text), bare_hex=True) for text in picked[0].tolist()]
        if any(each is None or each[0] != "sRGB" for each in colours):
            row = next(at for at, each in enumerate(colours) if each is None or each[0] != "sRGB")
            raise InvalidPointsError(
                f"Row {row} of the column {names[found.places[0]]} is "
                f"{str(picked[0][row])[:40]!r}, which is no colour of sRGB.",
                where={"field": names[found.places[0]], "row": row},
                remedy="Give colours such as #e4002b, or columns of numbers.",
            )
        points = np.array([each[1] for each in colours if each]).reshape(-1, 3)
        return FrameColours(points, "sRGB")
    try:
        values = np.stack([np.asarray(column, np.float64) for column in picked], axis=1)
    except (ValueError, TypeError):
        raise InvalidPointsError(
            f"The columns {', '.join(axes_of(found.space))} of the table are not numbers.",
            where={"field": names[found.places[0]]},
            remedy="Convert the columns to numbers.",
        ) from None
    finite = np.isfinite(values)
    if not finite.all():
        row = int(np.argmin(finite.all(axis=1)))
        raise InvalidPointsError(
            f"Row {row} of the colours is {values[row].tolist()}.",
            where={"field": "colours", "row": row},
            remedy="Give finite numbers. Leave out rows without a colour.",
        )
    scale = 1.0 if given is not None and found.space in {"sRGB", "CIEXYZ"} else None
    points, _ = on_full_scale(
        found,
        values,
        scale,
        [names[place] for place in found.places],
        lambda row: {"row": row},
        stated=given is not None or found.space == own,
    )
    return FrameColours(points, found.space)
