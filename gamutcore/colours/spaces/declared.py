"""The colour space that a mesh file states, and whether it is the one that is asked for.

Exports of this package state their space and all that its coordinates depend on. Such a mesh is a
boundary in that space and in no other: its faces would not be plane elsewhere. So it is accepted
where exactly that space is asked for, and a mesh that states nothing is taken to be in whichever.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gamutcore.colours.spaces.definitions import SPACES, ColourSpace
from gamutcore.colours.spaces.parameters import (
    MEASURED,
    SPACE,
    SPACE_PARAMETERS,
    measured_luminance,
    space_parameters,
)
from gamutcore.colours.spaces.white_points import ADAPTATIONS
from gamutcore.errors import InvalidPointsError, MeshError, OptionError
from gamutcore.option_types import finite_number

if TYPE_CHECKING:
    from collections.abc import Mapping

    from gamutcore.arrays import FloatArray

__all__ = [
    "assumption_warnings",
    "declared_luminance",
    "declared_space",
    "refuse_far_vertices",
    "refuse_other_space",
]

LARGEST_COORDINATE = 1e4
"""No colour has a coordinate beyond this in any space of scale 1."""

SMALLEST_CIELAB = 5.0
"""A gamut within so many units of CIELAB in every direction is rather one of Oklab, XYZ or the
like, whose coordinates are about 1."""


def declared_luminance(said: Mapping[str, str]) -> float | None:
    """Return the luminance of the device's white in cd/m² that notes of a file state, or None.

    Parameters
    ----------
    said : mapping of str to str
        Names in lower case.

    Returns
    -------
    float or None
    """
    try:
        return finite_number(float(said["white_luminance"]))
    except (KeyError, ValueError):
        return None


def declared_space(said: Mapping[str, str]) -> ColourSpace | None:
    """Return the space that the notes of a mesh file state.

    Parameters
    ----------
    said : mapping of str to str
        Names in lower case, to text: ``space``, and the options of spaces by their names.

    Returns
    -------
    ColourSpace or None
        None where the notes name no space.

    Raises
    ------
    MeshError
        There is no such space, or it has no such parameter.
    """
    if "space" not in said:
        return None
    name = " ".join(said["space"].split())
    space = SPACE.canonical(name)
    if not isinstance(space, str):
        raise MeshError(
            f"The mesh is in the colour space {name[:40]!r}.",
            where={"field": "space"},
            remedy=f"Meshes are read in {', '.join(SPACES)}.",
        )
    allowed = {"reference_white", "adaptation", "scale", *SPACES[space].parameters}
    given = {
        parameter: _value(said[parameter])
        for parameter in SPACE_PARAMETERS
        if parameter in allowed and parameter in said
    }
    if given.get("adaptation") not in tuple(ADAPTATIONS):
        given.pop("adaptation", None)  # a sentence on how the colours were found
    try:
        parameters = space_parameters(space, given)
        if parameters["luminance"] == MEASURED:
            parameters["luminance"] = measured_luminance(declared_luminance(said))
    except OptionError as error:
        raise MeshError(
            f"The mesh states what the space {space} cannot have: {error.message}.",
            where=dict(error.where),
            remedy=error.remedy,
        ) from None
    return ColourSpace(space, **parameters)  # type: ignore[arg-type]  # checked above


def _value(text: str) -> object:
    """Return a number, three numbers, or the text."""
    try:
        numbers = [float(word) for word in text.split()]
    except ValueError:
        return text.strip()
    return numbers[0] if len(numbers) == 1 else numbers


def refuse_other_space(stated: ColourSpace, asked: ColourSpace) -> None:
    """Refuse to take a mesh for one in another space than it states.

    Parameters
    ----------
    stated, asked : ColourSpace

    Raises
    ------
    OptionError
        They differ; the error names the first option that does, and all that would be right.
    """
    if stated.is_icc_cielab and asked.is_icc_cielab:
        return  # no adaptation takes part
    told, wanted = _settled(stated), _settled(asked)
    names = [name for name in told if not _same(told[name], wanted.get(name))]
    if not names:
        return
    first = names[0]
    defaults = _settled(ColourSpace(stated.name))
    needed = {
        name: value
        for name, value in told.items()
        if name == "space" or not _same(value, defaults[name])
    }
    raise OptionError(
        f"{first} is {_shown(wanted.get(first))}, and the file says {_shown(told[first])}",
        where={"field": first},
        remedy="a mesh is a boundary in its own space only: ask for "
        + ", ".join(f"{name} {_shown(value)}" for name, value in needed.items()),
    )


def _settled(space: ColourSpace) -> dict[str, object]:
    """Return all that coordinates depend on, by the names of the options."""
    given = {name: getattr(space, name) for name in SPACE_PARAMETERS}
    settled = space_parameters(space.name, given)
    # those of CIELAB have None for their defaults
    settled["reference_white"] = settled["reference_white"] or space.definition.white
    settled["adaptation"] = settled["adaptation"] or "Bradford"
    settled["scale"] = settled["scale"] or 1.0
    return {"space": space.name, **settled}


def _same(one: object, other: object) -> bool:
    whites = [value for value in (one, other) if isinstance(value, tuple)]
    if not whites or one is None or other is None:
        return one == other
    first, second = (
        ColourSpace(reference_white=value).white  # type: ignore[arg-type]  # checked as an option
        for value in (one, other)
    )
    return bool(np.allclose(first, second, rtol=0, atol=1e-12))


def _shown(value: object) -> str:
    return repr(list(value) if isinstance(value, tuple) else value)


def refuse_far_vertices(vertices: FloatArray, space: ColourSpace) -> None:
    """Refuse vertices beyond any colour of a space.

    Parameters
    ----------
    vertices : (v, 3) float
    space : ColourSpace

    Raises
    ------
    InvalidPointsError
    """
    beyond = (np.abs(vertices) > LARGEST_COORDINATE * (space.scale or 1.0)).any(axis=1)
    if beyond.any():
        vertex = int(np.argmax(beyond))
        raise InvalidPointsError(
            f"Vertex {vertex} is at {[float(value) for value in vertices[vertex]]}.",
            where={"field": "vertices", "vertex": vertex},
            remedy=f"Coordinates of colours in {space.name}, times its scale.",
        )


def assumption_warnings(vertices: FloatArray, space: ColourSpace) -> list[str]:
    """Return a warning if a mesh that states no space is hardly in the one that is assumed.

    Parameters
    ----------
    vertices : (v, 3) float
    space : ColourSpace

    Returns
    -------
    list of str
    """
    extent = float(np.ptp(vertices, axis=0).max())
    if space.name != "CIELAB" or extent >= SMALLEST_CIELAB * (space.scale or 1.0):
        return []
    warning = (
        f"The file states no colour space and was taken for CIELAB, but extends over {extent:.3g} "
        "units only; ask for its space with the option space."
    )
    return [warning]
