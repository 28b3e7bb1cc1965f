"""The colour space that a mesh file declares, compared with the requested space.

Exports of this package declare their space with all its parameters. Such a mesh is a boundary in
that space only, because its faces would not be plane in another space. It is therefore accepted
only if exactly that space is requested. A mesh without a declaration is taken to be in the
requested space.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gamutcore.arguments import canonical, finite_number
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
"""No colour has a larger coordinate in any space of scale 1."""

SMALLEST_CIELAB = 5.0
"""A gamut with a smaller extent is hardly in CIELAB, but in a space such as Oklab or XYZ, whose
coordinates are about 1."""


def declared_luminance(notes: Mapping[str, str]) -> float | None:
    """Return the luminance of the device's white in cd/m² that a file's notes declare.

    Names of notes are in lower case.
    """
    try:
        return finite_number(float(notes["white_luminance"]))
    except (KeyError, ValueError):
        return None


def declared_space(notes: Mapping[str, str]) -> ColourSpace | None:
    """Return the space that the notes of a mesh file declare; None if they name no space.

    Names are in lower case: ``space``, and the parameters of spaces by their names. An unknown
    space or parameter raises `MeshError`.
    """
    if "space" not in notes:
        return None
    name = " ".join(notes["space"].split())
    space = canonical(name, SPACE)
    if not isinstance(space, str):
        raise MeshError(
            f"The mesh is in the colour space {name[:40]!r}.",
            where={"field": "space"},
            remedy=f"Send a mesh in one of {', '.join(SPACES)}.",
        )
    allowed = {"reference_white", "adaptation", "scale", *SPACES[space].parameters}
    given = {
        parameter: _value(notes[parameter])
        for parameter in SPACE_PARAMETERS
        if parameter in allowed and parameter in notes
    }
    if given.get("adaptation") not in tuple(ADAPTATIONS):
        given.pop("adaptation", None)  # a sentence on the colours, in exports of this package
    try:
        parameters = space_parameters(space, given)
        if parameters["luminance"] == MEASURED:
            parameters["luminance"] = measured_luminance(declared_luminance(notes))
    except OptionError as error:
        raise MeshError(
            f"The mesh declares an invalid parameter of the space {space}: {error.message}",
            where=dict(error.where),
            remedy=error.remedy,
        ) from None
    return ColourSpace(space, **parameters)  # type: ignore[arg-type]  # checked above


def _value(text: str) -> object:
    """A number, three numbers, or the text."""
    try:
        numbers = [float(word) for word in text.split()]
    except ValueError:
        return text.strip()
    return numbers[0] if len(numbers) == 1 else numbers


def refuse_other_space(declared: ColourSpace, requested: ColourSpace) -> None:
    """Refuse a mesh that declares another space than the requested one.

    The error names the first differing option, and all that are needed.
    """
    if declared.is_icc_cielab and requested.is_icc_cielab:
        return  # no adaptation is involved
    given, wanted = _all_parameters(declared), _all_parameters(requested)
    names = [name for name in given if not _same(given[name], wanted.get(name))]
    if not names:
        return
    first = names[0]
    defaults = _all_parameters(ColourSpace(declared.name))
    needed = {
        name: value
        for name, value in given.items()
        if name == "space" or not _same(value, defaults[name])
    }
    raise OptionError(
        f"{first} is {_text_of(wanted.get(first))}, and {_text_of(given[first])} in the file.",
        where={"field": first},
        remedy="A mesh is a boundary in its own space only. Give "
        + ", ".join(f"{name} {_text_of(value)}" for name, value in needed.items())
        + ".",
    )


def _all_parameters(space: ColourSpace) -> dict[str, object]:
    """All that coordinates depend on, by the names of the options."""
    given = {name: getattr(space, name) for name in SPACE_PARAMETERS}
    settled = space_parameters(space.name, given)
    # the defaults of CIELAB are None
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


def _text_of(value: object) -> str:
    return repr(list(value) if isinstance(value, tuple) else value)


def refuse_far_vertices(vertices: FloatArray, space: ColourSpace) -> None:
    """Refuse vertices (v, 3) beyond any colour of a space."""
    beyond = (np.abs(vertices) > LARGEST_COORDINATE * (space.scale or 1.0)).any(axis=1)
    if beyond.any():
        vertex = int(np.argmax(beyond))
        raise InvalidPointsError(
            f"Vertex {vertex} is at {[float(value) for value in vertices[vertex]]}.",
            where={"field": "vertices", "vertex": vertex},
            remedy=f"Send coordinates of colours in {space.name}, multiplied by its scale.",
        )


def assumption_warnings(vertices: FloatArray, space: ColourSpace) -> list[str]:
    """Return a warning if a mesh without a declared space is hardly in the assumed one."""
    extent = float(np.ptp(vertices, axis=0).max())
    if space.name != "CIELAB" or extent >= SMALLEST_CIELAB * (space.scale or 1.0):
        return []
    warning = (
        f"The file declares no colour space and was taken as CIELAB, but its extent is only "
        f"{extent:.3g} units. Give its space with the option space."
    )
    return [warning]
