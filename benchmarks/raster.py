"""Draw meshes in their own colours with a depth buffer.

Each pixel shows the sRGB appearance of its point's CIELAB coordinates. Slight shading and thin
edge lines make the triangles visible. Lightness points upwards, and the projection is parallel.
"""

from __future__ import annotations

import numpy as np

from benchmarks.common import FloatArray
from gamutcore.colours.spaces.srgb import srgb
from gamutcore.mesh import TriangleMesh

__all__ = ["View", "picture"]

SAMPLES = 3
"""Samples along each side of a pixel."""

LIGHT = np.array([-0.35, 0.55, 0.75])
"""Direction towards the light, in the axes of the view: right, up, towards the eye."""

EDGE = 0.9
"""Width of an edge line on each of its two faces, in pixels."""


class View:
    """A parallel projection that fits a mesh.

    Parameters
    ----------
    mesh : TriangleMesh
    azimuth, elevation : float, optional
        Position of the eye in degrees: rotated from a* towards b*, and above the plane of equal
        lightness.
    width : int, optional
        Width of the picture in pixels. The height follows from the mesh.
    """

    def __init__(
        self, mesh: TriangleMesh, azimuth: float = -60.0, elevation: float = 18.0, width: int = 420
    ) -> None:
        turn, rise = np.radians([azimuth, elevation])
        eye = np.array([np.sin(rise), np.cos(rise) * np.cos(turn), np.cos(rise) * np.sin(turn)])
        right = np.array([0.0, -np.sin(turn), np.cos(turn)])
        self.axes = np.stack([right, np.cross(eye, right), eye])
        projected = mesh.vertices.astype(np.float64) @ self.axes.T
        low, high = projected[:, :2].min(axis=0), projected[:, :2].max(axis=0)
        self.origin = (low + high) / 2
        extent = high - low
        # The margin is for coarse levels, which extend beyond the full boundary.
        self.scale = 0.9 * width / float(extent[0])
        self.width, self.height = width, int(self.scale * float(extent[1]) + 0.12 * width)

    def screen_positions(self, positions: FloatArray) -> FloatArray:
        """Return positions in pixels to the right, downwards, and towards the eye; (n, 3)."""
        projected = positions @ self.axes.T
        flat = (projected[:, :2] - self.origin) * self.scale * [1, -1]
        flat += [self.width / 2, self.height / 2]
        return np.column_stack([flat, projected[:, 2] * self.scale])


def picture(mesh: TriangleMesh, view: View) -> FloatArray:
    """Draw a closed mesh of CIELAB colours.

    Returns
    -------
    (height, width, 4) float64
        sRGB and coverage, 0 to 1, with colours that are not premultiplied.
    """
    wide, high = view.width * SAMPLES, view.height * SAMPLES
    positions = mesh.vertices.astype(np.float64)
    screen = view.screen_positions(positions) * [SAMPLES, SAMPLES, 1]
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
        # Barycentric coordinates: fraction of the height above the opposite side.
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
        # Edge lines fade with the height of the triangle, so small triangles stay visible.
        strength = np.clip(heights.min() / 10.0, 0.0, 1.0)
        line[window][seen] = strength * np.clip(EDGE - from_edge[seen], 0.0, 1.0)
    covered = depth > -np.inf
    shown = np.zeros((high, wide, 4))
    shown[..., 3] = covered
    painted = srgb(colour[covered])
    painted *= (0.80 + 0.20 * np.clip(light[covered], -1, 1))[:, np.newaxis]
    # Dark lines on light faces, light lines on dark faces.
    lightness = painted @ [0.2126, 0.7152, 0.0722]
    ink = np.where(lightness > 0.28, 0.0, 0.62)
    weight = 0.6 * line[covered]
    painted += weight[:, np.newaxis] * (ink[:, np.newaxis] - painted)
    shown[covered, :3] = painted
    parts = shown.reshape(view.height, SAMPLES, view.width, SAMPLES, 4)
    coverage = parts[..., 3].mean(axis=(1, 3))
    summed = (parts[..., :3] * parts[..., 3:]).mean(axis=(1, 3))
    return np.dstack([summed / np.maximum(coverage, 1e-9)[..., np.newaxis], coverage])
