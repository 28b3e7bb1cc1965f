"""The gamut boundary in an iccMAX profile: tags gbd0 to gbd3, one for each intent.

The type gamutBoundaryDescType (ICC.2:2019, 10.2.11) has triangles, vertices in the connection space
as 32-bit floats, and optionally their device values.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gamutcore.characterisation.gamut_mesh import gamut_mesh, refuse_too_many
from gamutcore.characterisation.icc import IccProfile
from gamutcore.errors import OptionError

if TYPE_CHECKING:
    from gamutcore.arrays import LongArray
    from gamutcore.characterisation.gamut_mesh import GamutMesh

__all__ = ["GAMUT_BOUNDARY_TAGS", "described_boundary"]

GAMUT_BOUNDARY_TAGS = {
    "perceptual": "gbd0",
    "relative": "gbd1",
    "saturation": "gbd2",
    "absolute": "gbd3",
}
"""The tag of each intent (ICC.2:2019, 9.2.80 to 9.2.83)."""

_HEAD = 20
_KIND = "gbd "
_SPACES = {"Lab": "CIELAB", "XYZ": "CIEXYZ"}


def described_boundary(data: object, intent: str) -> GamutMesh:
    """Return the gamut boundary of a profile for an intent.

    Parameters
    ----------
    data : object
        Characterisation data. Only an `IccProfile` is accepted.
    intent : str
        One of `GAMUT_BOUNDARY_TAGS`.

    Raises
    ------
    OptionError
        The data is not a profile, or has no boundary for this intent.
    MalformedProfileError
        The tag is malformed; ``where["tag"]`` names it.
    SampleLimitError, MalformedFileError, InvalidPointsError
        As for `gamutcore.characterisation.gamut_mesh.gamut_mesh`.
    """
    if not isinstance(data, IccProfile):
        raise OptionError(
            "source is 'boundary', but the data is not an ICC profile.",
            where={"field": "source"},
            remedy="Leave source out: a mesh is always used as the boundary.",
        )
    tag = GAMUT_BOUNDARY_TAGS[intent]
    if tag not in data.tags:
        others = [name for name, other in GAMUT_BOUNDARY_TAGS.items() if other in data.tags]
        raise OptionError(
            f"source is 'boundary', but the profile has none for the intent {intent}.",
            where={"field": "intent" if others else "source", "tag": tag},
            remedy=f"Ask for the intent {' or '.join(others)}."
            if others
            else "Leave it out: the profile has no gamut boundary description (gbd0 to gbd3).",
        )
    element = data.element(tag)
    if element.kind != _KIND:
        raise element.malformed(f"is of the type {element.kind!r}", f"Its type is {_KIND!r}.")
    channels, inks = element.unsigned(8, 2), element.unsigned(10, 2)
    count, triangles = element.unsigned(12, 4), element.unsigned(16, 4)
    if channels != 3:
        raise element.malformed(
            f"has {channels} channels of the connection space", f"{data.pcs} has 3."
        )
    refuse_too_many(count, triangles, where={"tag": tag})
    corners = element.raw(_HEAD, 12 * triangles)
    faces = np.frombuffer(corners, ">u4").astype(np.int64).reshape(-1, 3)
    start = _HEAD + 12 * triangles
    vertices = element.floats(start, 3 * count).reshape(-1, 3)
    if inks:  # device values are not used, but must be complete
        element.raw(start + 12 * count, 4 * inks * count)
    faces, warnings = _from_zero(faces, count)
    return gamut_mesh(
        "icc",
        vertices,
        faces,
        space=_SPACES[data.pcs],
        space_notes={"space": "CIELAB"},
        clockwise=True,  # ICC.2:2019, 10.2.11
        provenance={
            **data.provenance,
            "source": "boundary",
            "tag": tag,
            "intent": intent,
            "illuminant": "D50",
            "observer": "2°",
        },
        warnings=[*data.warnings, *warnings],
    )


def _from_zero(faces: LongArray, count: int) -> tuple[LongArray, list[str]]:
    """Return faces with indices from 0 (ICC.2:2019, 10.2.11), and warnings."""
    # The ICC's example in XML counts from 1.
    if faces.size and faces.min() == 1 and faces.max() == count:
        return faces - 1, ["The boundary counts vertices from 1 instead of 0."]
    return faces, []
