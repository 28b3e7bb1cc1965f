"""A mesh, its axes and their labels before a fixed camera, as coloured triangles.

The camera looks at the gamut from a hue and an elevation, in parallel projection. Lightness is
upwards. The floor has the two other axes and circles of constant chroma, and is at the lower end of
lightness.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from gamutcore.arrays import Float32Array, FloatArray, PositionArray
from gamutcore.colours.spaces import ColourSpace, linear_srgb
from gamutcore.export.rendering.strokes import HEIGHT, text_strokes
from gamutcore.geometry import TriangleMesh

__all__ = ["VIEWS", "Triangles", "camera", "scene_triangles"]

VIEWS = {
    "standard": (305.0, 25.0),
    "front": (270.0, 0.0),
    "right": (0.0, 0.0),
    "back": (90.0, 0.0),
    "left": (180.0, 0.0),
    "top": (270.0, 90.0),
    "bottom": (270.0, -90.0),
}
"""Hue and elevation of the camera in degrees. In CIELAB, `front` has a* to the right and `right`
has b* to the right."""

MARGIN = 0.03
"""Empty part of the picture at each edge."""

SHADOW = 0.3
"""Part of its light that a face loses if it is seen from the side."""

GREY = 0.25
"""Linear light of axes and labels, the sRGB value 137."""

LINE = 0.003
"""Width of lines ÷ size of the picture."""

LABEL = 0.026
"""Height of labels ÷ size of the picture."""

CIRCLES = 1.8
"""Circles of chroma within the reach of the gamut, at least."""

FORESHORTENED = 0.4
"""Axes that appear shorter than this share of their length get no labels."""

CIRCLE = 96
"""Segments of a circle."""


class Triangles(NamedTuple):
    """Coloured triangles: corners (n, 3, 3) and their colours in linear sRGB (n, 3, 3)."""

    corners: FloatArray
    colours: Float32Array


def camera(azimuth: float, elevation: float) -> FloatArray:
    """Return the directions to the right, upwards and towards the viewer as rows of (3, 3).

    The azimuth is the hue from which the viewer looks, and the elevation the angle above the floor,
    both in degrees.
    """
    hue, angle = math.radians(azimuth), math.radians(elevation)
    right = np.array([-math.sin(hue), math.cos(hue), 0.0])
    towards = np.array(
        [
            math.cos(angle) * math.cos(hue),
            math.cos(angle) * math.sin(hue),
            math.sin(angle),
        ]
    )
    return np.stack([right, np.cross(towards, right), towards])


def scene_triangles(
    mesh: TriangleMesh, space: ColourSpace, directions: FloatArray, size: int, *, axes: bool
) -> Triangles:
    """Return a mesh with axes as triangles in the coordinates of the picture.

    Those are x to the right and y downwards in pixels, and the height towards the viewer. The
    directions are those of `camera`.
    """
    place = _upright(mesh.vertices, space)
    lines = _Lines(place, space) if axes else None
    extent = place @ directions.T
    if lines is not None:
        extent = np.vstack([extent, lines.ends() @ directions.T])
    lowest, highest = extent.min(axis=0), extent.max(axis=0)
    room = MARGIN + (1.5 * LABEL if axes else 0.0)
    scale = size * (1.0 - 2.0 * room) / max((highest - lowest)[:2].max(), 1e-30)
    middle = (lowest + highest) / 2.0

    def shown(points: FloatArray) -> FloatArray:
        relative = (points @ directions.T - middle) * (scale, -scale, scale)
        placed: FloatArray = np.add(relative, (size / 2.0, size / 2.0, 0.0))
        return placed

    corners = shown(place)[mesh.faces]
    light = linear_srgb(space.appearance_lab(mesh.vertices))[mesh.faces]
    colours = light * _shading(corners)[:, np.newaxis, np.newaxis]
    if lines is None:
        return Triangles(corners, np.ascontiguousarray(colours, np.float32))
    drawn = lines.triangles(shown, directions, size)
    grey = np.full(drawn.shape, GREY)
    return Triangles(
        np.concatenate([corners, drawn]),
        np.concatenate([colours, grey]).astype(np.float32),
    )


def _upright(vertices: PositionArray, space: ColourSpace) -> FloatArray:
    """Return coordinates with lightness last, and the others in the order that is right-handed."""
    lightness = space.definition.lightness
    order = [(lightness + 1) % 3, (lightness + 2) % 3, lightness]
    return np.asarray(vertices, np.float64)[:, order]


def _shading(corners: FloatArray) -> FloatArray:
    """Return the light of faces: all if the viewer looks at them straight."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normals, axis=1)
    facing = np.abs(normals[:, 2]) / np.where(length > 0.0, length, 1.0)
    shading: FloatArray = 1.0 - SHADOW * (1.0 - facing)
    return shading


class _Lines:
    """Axes, circles and labels of a gamut, in upright coordinates."""

    def __init__(self, place: FloatArray, space: ColourSpace) -> None:
        lightness = space.definition.lightness
        self.names = [space.axes[(lightness + step) % 3] for step in (1, 2, 3)]
        low, high = place.min(axis=0), place.max(axis=0)
        self.floor, self.roof = min(low[2], 0.0), high[2] + 0.08 * (high[2] - min(low[2], 0.0))
        reach = float(np.abs(np.concatenate([low[:2], high[:2]])).max())
        self.step = _round_step(reach / CIRCLES)
        self.reach = self.step * math.ceil(reach / self.step)

    def ends(self) -> FloatArray:
        """Return points that the picture must contain."""
        turn = np.linspace(0.0, 2.0 * math.pi, CIRCLE, endpoint=False)
        rim = self.reach * np.stack([np.cos(turn), np.sin(turn)], axis=1)
        floor = np.column_stack([rim, np.full(CIRCLE, self.floor)])
        return np.vstack([floor, [(0.0, 0.0, self.roof)]])

    def triangles(
        self, shown: Callable[[FloatArray], FloatArray], directions: FloatArray, size: int
    ) -> FloatArray:
        """Return lines and labels as triangles in the coordinates of the picture."""
        reach, floor = self.reach, self.floor
        turn = np.linspace(0.0, 2.0 * math.pi, CIRCLE + 1)
        paths = [
            np.array([(-reach, 0.0, floor), (reach, 0.0, floor)]),
            np.array([(0.0, -reach, floor), (0.0, reach, floor)]),
            np.array([(0.0, 0.0, floor), (0.0, 0.0, self.roof)]),
        ]
        ends = [(reach, 0.0, floor), (0.0, reach, floor), (0.0, 0.0, self.roof)]
        seen = np.hypot(directions[0], directions[1]) > FORESHORTENED
        labels = {
            name: end for name, end, shows in zip(self.names, ends, seen, strict=True) if shows
        }
        # numbers are at the negative half of an axis, which comes towards the viewer if possible
        numbered = 1 if seen[1] and (directions[2, 1] < 0.0 or not seen[0]) else 0
        opposite = -np.eye(3)[numbered]
        for number in range(1, round(reach / self.step) + 1):
            radius = number * self.step
            circle = np.stack([np.cos(turn), np.sin(turn)], axis=1) * radius
            paths.append(np.column_stack([circle, np.full(CIRCLE + 1, floor)]))
            labels[f"{radius:.3g}"] = tuple(radius * opposite + (0.0, 0.0, floor))
        strokes = [_stroke(shown(path), LINE * size) for path in paths]
        centre = shown(np.array([(0.0, 0.0, (floor + self.roof) / 2.0)]))[0]
        for text, point in labels.items():
            at = shown(np.array([point]))[0]
            outwards = at[:2] - centre[:2]
            outwards /= max(float(np.hypot(*outwards)), 1e-9)
            at[:2] += outwards * LABEL * size * 0.8
            at[2] += size  # in front of everything
            for stroke in text_strokes(text):
                flat = stroke * (LABEL * size / HEIGHT) * (1.0, -1.0) + at[:2]
                points = np.column_stack([flat, np.full(len(flat), at[2])])
                strokes.append(_stroke(points, LINE * size))
        return np.concatenate(strokes)


def _stroke(points: FloatArray, width: float) -> FloatArray:
    """Return a polyline as two triangles for each segment, each longer by half the width."""
    start, end = points[:-1], points[1:]
    along = (end - start)[:, :2]
    length = np.hypot(along[:, 0], along[:, 1])[:, np.newaxis]
    along = np.where(length > 0.0, along / np.maximum(length, 1e-12), (1.0, 0.0))
    along *= width / 2.0
    forwards = np.column_stack([along, np.zeros(len(along))])
    across = np.column_stack([-along[:, 1], along[:, 0], np.zeros(len(along))])
    a, b = start - forwards - across, end + forwards - across
    c, d = end + forwards + across, start - forwards + across
    return np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])


def _round_step(least: float) -> float:
    """Return the largest 1, 2 or 5 times a power of ten that is at most `least`."""
    power = 10.0 ** math.floor(math.log10(max(least, 1e-12)))
    return max(power * part for part in (1.0, 2.0, 5.0) if power * part <= least * (1.0 + 1e-9))
