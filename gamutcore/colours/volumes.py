"""Volumes of a gamut with both intents, and as multiples of sRGB's volume in the same space.

The volume of the other intent is that of the same boundary with its vertices converted: exact for
the vertices, and linear between them as the boundary itself.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from gamutcore.colours.spaces.cielab import ICC_D50, xyz_to_lab
from gamutcore.colours.spaces.conversion import ColourConversion
from gamutcore.errors import InvalidPointsError
from gamutcore.geometry import TriangleMesh

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray, IndexArray
    from gamutcore.characterisation.samples import JSON
    from gamutcore.colours.device.surface import AbsoluteColours
    from gamutcore.colours.spaces import ColourSpace

__all__ = ["described_volumes", "medium_white_lab", "srgb_volume"]

CELLS = 64
"""Cells along an edge of sRGB's cube. The volume is extrapolated from this number and half of it;
the error is below 0.001 % of the volume in all spaces (tests compare with 512 cells)."""


def described_volumes(
    mesh: TriangleMesh, space: ColourSpace, intent: object, absolute: AbsoluteColours | None
) -> dict[str, JSON]:
    """Return the volumes of a boundary for its description.

    Parameters
    ----------
    mesh : TriangleMesh
        The boundary, in the space.
    space : ColourSpace
    intent : str
        Of its colours.
    absolute : AbsoluteColours or None
        The way between both intents, if there is one.

    Returns
    -------
    dict
        ``srgb``: the volume of sRGB in the space, relative to its white. ``relative`` and
        ``absolute``: mappings of ``volume`` and ``times_srgb``; ``own`` instead of both for colours
        without such intents. An intent whose colours have no coordinates in the space is left out.
    """
    srgb = srgb_volume(space)
    volumes = {"own": mesh.volume}
    if absolute is not None and intent in {"relative", "absolute"}:
        volumes = {"relative": mesh.volume, "absolute": mesh.volume}
        other = "absolute" if intent == "relative" else "relative"
        converted = _converted_volume(mesh, space, absolute, other)
        if converted is None:
            del volumes[other]
        else:
            volumes[other] = converted
    return {
        "srgb": srgb,
        **{
            name: {"volume": volume, "times_srgb": round(volume / srgb, 6)}
            for name, volume in volumes.items()
        },
    }


def medium_white_lab(absolute: AbsoluteColours) -> list[JSON]:
    """Return L*, a*, b* of the medium's white with the intent absolute, relative to D50."""
    return [round(float(value), 3) + 0.0 for value in xyz_to_lab(absolute.matrix @ ICC_D50)]


@lru_cache(maxsize=64)
def srgb_volume(space: ColourSpace) -> float:
    """Return the volume of sRGB in a space, media-relative: its white is the white of the space.

    Examples
    --------
    >>> from gamutcore.colours.spaces import ColourSpace
    >>> round(srgb_volume(ColourSpace("CIELAB")), -3)
    833000.0
    """
    fine, coarse = (_cube_volume(space, cells) for cells in (CELLS, CELLS // 2))
    return (4.0 * fine - coarse) / 3.0  # the error falls with the square of the size of a cell


def _cube_volume(space: ColourSpace, cells: int) -> float:
    """Return the volume within triangles between the colours of a grid on the cube's faces."""
    steps = np.linspace(0.0, 1.0, cells + 1) ** 2  # dense near black, where PQ is steep
    one, two = (each.ravel() for each in np.meshgrid(steps, steps, indexing="ij"))
    corner = (np.arange(cells)[:, np.newaxis] * (cells + 1) + np.arange(cells)).ravel()
    down, right, across = corner + cells + 1, corner + 1, corner + cells + 2
    patch = np.concatenate(
        [np.stack([corner, down, across], axis=1), np.stack([corner, across, right], axis=1)]
    )
    points: list[FloatArray] = []
    faces: list[IndexArray] = []
    for axis in range(3):
        for end in (0.0, 1.0):
            values = np.empty((len(one), 3))
            values[:, axis], values[:, axis - 2], values[:, axis - 1] = end, one, two
            faces.append((patch if end else patch[:, ::-1]) + len(points) * len(one))
            points.append(values)
    colours = ColourConversion("sRGB", space).to_gamut(np.concatenate(points))
    return abs(TriangleMesh(colours, np.concatenate(faces)).volume)


def _converted_volume(
    mesh: TriangleMesh, space: ColourSpace, absolute: AbsoluteColours, intent: str
) -> float | None:
    """Return the volume of a boundary of the other intent; None without coordinates for it."""
    matrix, as_measured = absolute.matrix, absolute.as_measured
    if absolute.own is not None and as_measured and not space.is_icc_cielab:
        matrix = absolute.own
    if intent == "relative":
        matrix = np.linalg.inv(matrix).astype(np.float64)
    to_absolute = intent == "absolute"
    xyz = space.tristimulus(mesh.vertices, as_measured=as_measured and not to_absolute)
    try:
        points, _ = space.from_tristimulus(xyz @ matrix.T, as_measured=as_measured and to_absolute)
    except InvalidPointsError:
        return None
    volume = TriangleMesh(points, mesh.faces).volume
    return volume if np.isfinite(volume) else None
