"""A small picture of a gamut as SVG, drawn without a plotting library.

The faces of a coarse level are projected along a fixed direction and filled with their own colours.
Faces that look away are left out. The others are drawn from back to front.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gamutcore.colours.spaces import srgb

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray, PositionArray
    from gamutcore.colours.spaces import ColourSpace
    from gamutcore.geometry import TriangleMesh

__all__ = ["face_colours", "svg_picture", "upright"]

AZIMUTH, ELEVATION = np.radians(-35.0), np.radians(25.0)
"""Direction of the viewer: in front of the blue and purple hues, from above."""


def upright(vertices: PositionArray, space: ColourSpace) -> FloatArray:
    """Return coordinates with lightness as the last axis: (a*, b*, L*) for CIELAB.

    Parameters
    ----------
    vertices : (n, 3) float
    space : ColourSpace

    Returns
    -------
    (n, 3) float64
    """
    lightness = space.definition.lightness
    others = [axis for axis in range(3) if axis != lightness]
    return np.asarray(vertices, np.float64)[:, [*others, lightness]]


def face_colours(mesh: TriangleMesh, space: ColourSpace) -> FloatArray:
    """Return the sRGB colour of the middle of each face, (n, 3) from 0 to 1."""
    middles = mesh.vertices[mesh.faces].astype(np.float64).mean(axis=1)
    return srgb(space.appearance_lab(middles))


def svg_picture(mesh: TriangleMesh, space: ColourSpace, size: int = 220) -> str:
    """Return a picture of a mesh as SVG.

    Parameters
    ----------
    mesh : TriangleMesh
        Star-shaped; a few hundred faces.
    space : ColourSpace
        Of its vertices.
    size : int, optional
        Width and height in pixels.

    Returns
    -------
    str
    """
    place = upright(mesh.vertices, space)
    sine, cosine = np.sin(AZIMUTH), np.cos(AZIMUTH)
    right = place[:, 0] * cosine - place[:, 1] * sine
    back = place[:, 0] * sine + place[:, 1] * cosine
    up = place[:, 2] * np.cos(ELEVATION) + back * np.sin(ELEVATION)
    depth = back * np.cos(ELEVATION) - place[:, 2] * np.sin(ELEVATION)
    flat = np.stack([right, -up], axis=1)
    lowest, highest = flat.min(axis=0), flat.max(axis=0)
    flat = size * (0.5 + 0.96 * (flat - (lowest + highest) / 2) / (highest - lowest).max())
    corners = flat[mesh.faces]
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    turn = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    seen = np.flatnonzero(turn < 0 if _is_right_handed(space) else turn > 0)
    seen = seen[np.argsort(-depth[mesh.faces[seen]].mean(axis=1), kind="stable")]
    colours = np.rint(255 * face_colours(mesh, space)).astype(int)
    shapes = []
    for face in seen:
        points = " ".join(f"{px:.1f},{py:.1f}" for px, py in corners[face])
        fill = "#{:02x}{:02x}{:02x}".format(*colours[face])
        shapes.append(f'<polygon points="{points}" fill="{fill}" stroke="{fill}"/>')
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{size}" height="{size}" '
        f'viewBox="0 0 {size} {size}" stroke-width="0.5">{"".join(shapes)}</svg>'
    )


def _is_right_handed(space: ColourSpace) -> bool:
    """Whether `upright` keeps the orientation: moving the second axis to the end reverses it."""
    return space.definition.lightness != 1
