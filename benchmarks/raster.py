"""Pictures of meshes in their own colours, drawn with a depth buffer.

Every pixel gets the sRGB appearance of the colour that its point of the surface stands for, with a
little shading by the direction of the face and a thin line along the edges, so that triangles are
seen as triangles. Lightness points upwards; the view is a parallel projection.
"""

from __future__ import annotations

import numpy as np

from benchmarks.devices import FloatArray
from gamutcore.colours.spaces.srgb import srgb
from gamutcore.mesh import TriangleMesh

__all__ = ["View", "picture"]

SAMPLES = 3
"""Samples along each side of a pixel."""

LIGHT = np.array([-0.35, 0.55, 0.75])
"""Towards the light: from the left, above, and from the viewer (right, up, towards the eye)."""

EDGE = 0.9
"""Width of the line that each of two faces draws along their edge, in pixels."""


class View:
    """A direction to look along, and what of space the picture shows.

    Parameters
    ----------
    mesh : TriangleMesh
        What the picture is made to fit.
    azimuth, elevation : float, optional
        Where the eye is: turned from a* towards b*, and above the plane of equal lightness, in
        degrees.
    width : int, optional
        Pixels from left to right; the height follows from the mesh.
    """

    def __init__(
        self, mesh: TriangleMesh, azimuth: float = -60.0, elevation: float = 18.0, width: int = 420
    ) -> None:
        turn, rise = np.radians([azimuth, elevation])
        eye = np.array([np.sin(rise), np.cos(rise) * np.cos(turn), np.cos(rise) * np.sin(turn)])
        right = np.array([0.0, -np.sin(turn), np.cos(turn)])
        self.axes = np.stack([right, np.cross(eye, right), eye])
        placed = mesh.vertices.astype(np.float64) @ self.axes.T
        low, high = placed[:, :2].min(axis=0), placed[:, :2].max(axis=0)
        self.origin = (low + high) / 2
        extent = high - low
        # coarse levels reach beyond the full boundary
        self.scale = 0.9 * width / float(extent[0])
        self.width, self.height = width, int(self.scale * float(extent[1]) + 0.12 * width)

    def placed(self, positions: FloatArray) -> FloatArray:
        """Positions in pixels to the right and downwards, and towards the eye; (n, 3)."""
        seen = positions @ self.axes.T
        flat = (seen[:, :2] - self.origin) * self.scale * [1, -1]
        flat += [self.width / 2, self.height / 2]
        return np.column_stack([flat, seen[:, 2] * self.scale])


def picture(mesh: TriangleMesh, view: View) -> FloatArray:
    """Draw a closed mesh of CIELAB colours.

    Parameters
    ----------
    mesh : TriangleMesh
    view : View

    Returns
    -------
    (height, width, 4) float64
        sRGB and coverage, 0 to 1, the colours not multiplied by the coverage.
    """
    wide, high = view.width * SAMPLES, view.height * SAMPLES
    positions = mesh.vertices.astype(np.float64)
    screen = view.placed(positions) * [SAMPLES, SAMPLES, 1]
    depth = np.full((high, wide), -np.inf)
    colour, light, line = np.zeros((high, wide, 3)), np.zeros((high, wide)), np.zeros((high, wide))
    first, second, third = mesh.corners()
    normals = np.cross(second - first, third - first)
    normals /= np.linalg.norm(normals, axis=1)[:, np.newaxis]
    brightness = (normals @ view.axes.T) @ (LIGHT / np.linalg.norm(LIGHT))
    facing = np.flatnonzero(normals @ view.axes[2] > 0)
    for face in facing:
        corners = screen[mesh.faces[face]]
        flat = corners[:, :2]
        left, top = np.maximum(np.floor(flat.min(axis=0)).astype(int), 0)
        right, bottom = np.minimum(np.ceil(flat.max(axis=0)).astype(int) + 1, (wide, high))
        across = np.arange(left, right)[np.newaxis, :] + 0.5
        down = np.arange(top, bottom)[:, np.newaxis] + 0.5
        edges = np.roll(flat, -2, axis=0) - np.roll(flat, -1, axis=0)
        area = edges[2, 0] * edges[0, 1] - edges[2, 1] * edges[0, 0]
        if area == 0:
            continue
        # barycentric coordinates, each the part of the height above the side opposite its corner
        shares = np.stack(
            [
                (edge[0] * (down - start[1]) - edge[1] * (across - start[0])) / area
                for edge, start in zip(edges, np.roll(flat, -1, axis=0), strict=True)
            ]
        )
        inside = (shares >= 0).all(axis=0)
        near = np.tensordot(corners[:, 2], shares, 1)
        window = np.s_[top:bottom, left:right]
        seen = inside & (near > depth[window])
        if not seen.any():
            continue
        depth[window][seen] = near[seen]
        colour[window][seen] = shares[:, seen].T @ positions[mesh.faces[face]]
        light[window][seen] = brightness[face]
        heights = abs(area) / np.linalg.norm(edges, axis=1) / SAMPLES
        from_edge = (shares * heights[:, np.newaxis, np.newaxis]).min(axis=0)
        # lines would cover small triangles: they fade with the triangle's height
        strength = np.clip(heights.min() / 10.0, 0.0, 1.0)
        line[window][seen] = strength * np.clip(EDGE - from_edge[seen], 0.0, 1.0)
    covered = depth > -np.inf
    shown = np.zeros((high, wide, 4))
    shown[..., 3] = covered
    painted = srgb(colour[covered])
    painted *= (0.80 + 0.20 * np.clip(light[covered], -1, 1))[:, np.newaxis]
    # dark lines on light faces, light lines on dark ones
    lightness = painted @ [0.2126, 0.7152, 0.0722]
    ink = np.where(lightness > 0.28, 0.0, 0.62)
    weight = 0.6 * line[covered]
    painted += weight[:, np.newaxis] * (ink[:, np.newaxis] - painted)
    shown[covered, :3] = painted
    parts = shown.reshape(view.height, SAMPLES, view.width, SAMPLES, 4)
    coverage = parts[..., 3].mean(axis=(1, 3))
    summed = (parts[..., :3] * parts[..., 3:]).mean(axis=(1, 3))
    return np.dstack([summed / np.maximum(coverage, 1e-9)[..., np.newaxis], coverage])
