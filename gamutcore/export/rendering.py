"""Pictures of a mesh in three dimensions as PNG, computed without graphics hardware.

The camera looks at the gamut from a hue and an elevation, in parallel projection. Lightness is
upwards. The floor has the two other axes and circles of constant chroma, and is at the lower end of
lightness. Mesh, axes and labels become coloured triangles, which are filled with a depth buffer.

Colours are linear, so the mean of the samples of a pixel is the light of the pixel. Samples lie in
the middles of a fine grid. The picture is computed in bands of rows, which bounds the memory.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from gamutcore.arguments import finite_number
from gamutcore.arrays import Float32Array, FloatArray, PositionArray
from gamutcore.colours.spaces import CIELAB, ColourSpace, linear_srgb
from gamutcore.errors import OptionError
from gamutcore.export.picture_file import png
from gamutcore.geometry import TriangleMesh
from gamutcore.kernels import kernel, leaf_kernel

__all__ = [
    "BACKGROUNDS",
    "DEFAULT_SIZE",
    "LARGEST_PICTURE",
    "PICTURE_TRIANGLES",
    "SMALLEST_PICTURE",
    "VIEWS",
    "camera",
    "mesh_picture",
    "rasterise",
    "scene_triangles",
]

SMALLEST_PICTURE, LARGEST_PICTURE = 16, 2048
"""Width and height in pixels."""

SAMPLES = 3
"""Samples of a pixel in each direction; one less above `SMOOTH_SIZE`."""

SMOOTH_SIZE = 1024

DEFAULT_SIZE = 800

PICTURE_TRIANGLES = 20_000
"""Triangles of a picture: no pixel shows an edge of them."""

BACKGROUNDS = ("white", "transparent")

SPEED = 3
"""Level of the compression: half the time of level 6, for pictures that are 5 % larger."""


def mesh_picture(
    mesh: TriangleMesh,
    space: ColourSpace = CIELAB,
    *,
    size: int = DEFAULT_SIZE,
    view: str | Sequence[float] = "standard",
    background: str = "white",
    axes: bool = True,
    texts: Mapping[str, str] | None = None,
) -> bytes:
    """Return a picture of a mesh as PNG.

    Parameters
    ----------
    mesh : TriangleMesh
        Closed.
    space : ColourSpace, optional
        Of its vertices.
    size : int, optional
        Width and height in pixels, 16 to 2048.
    view : str or (float, float), optional
        A key of `VIEWS`, or the hue and the elevation of the camera in degrees.
    background : {'white', 'transparent'}, optional
    axes : bool, optional
        Whether there are axes with labels.
    texts : mapping, optional
        Textual data of the file, as for `gamutcore.export.png.png`.

    Returns
    -------
    bytes
        The colours are those of the surface, as sRGB shows them; faces seen from the side are a
        little darker. The same mesh gives the same bytes on one platform.

    Raises
    ------
    OptionError
        An option is not accepted.
    """
    if not (isinstance(size, int) and SMALLEST_PICTURE <= size <= LARGEST_PICTURE):
        accepted = f"a whole number from {SMALLEST_PICTURE} to {LARGEST_PICTURE}"
        raise OptionError.refusal("size", size, accepted)
    if background not in BACKGROUNDS:
        raise OptionError.refusal("background", background, " or ".join(BACKGROUNDS))
    corners, colours = scene_triangles(mesh, space, camera(*_angles(view)), size, axes=axes)
    samples = SAMPLES if size <= SMOOTH_SIZE else SAMPLES - 1
    light = rasterise(corners, colours, size, samples)
    coverage = light[..., 3:]
    if background == "white":
        return png(_encoded(light[..., :3] + (1.0 - coverage)), SPEED, texts)
    pixels = _encoded(light[..., :3] / np.where(coverage > 0.0, coverage, 1.0))
    alpha = np.rint(255.0 * coverage).astype(np.uint8)
    return png(np.concatenate([pixels, alpha], axis=2), SPEED, texts)


def _angles(view: object) -> tuple[float, float]:
    """Return the hue and the elevation of the camera."""
    if isinstance(view, str) and view in VIEWS:
        return VIEWS[view]
    if isinstance(view, tuple | list) and len(view) == 2:
        azimuth, elevation = map(finite_number, view)
        if azimuth is not None and elevation is not None and abs(elevation) <= 90.0:
            return azimuth % 360.0, elevation
    accepted = f"{', '.join(VIEWS)}, or a hue and an elevation from -90 to 90 degrees"
    raise OptionError.refusal("view", view, accepted)


def _encoded(linear: NDArray[np.floating]) -> NDArray[np.uint8]:
    """Return 8-bit sRGB (IEC 61966-2-1) of linear light."""
    steps = np.rint(np.clip(linear, 0.0, 1.0) * (len(_ENCODED) - 1)).astype(np.uint16)
    encoded: NDArray[np.uint8] = _ENCODED[steps]
    return encoded


def _table() -> NDArray[np.uint8]:
    linear = np.linspace(0.0, 1.0, 2**16)
    encoded = np.where(
        linear <= 0.0031308, 12.92 * linear, 1.055 * np.power(linear, 1.0 / 2.4) - 0.055
    )
    return np.rint(255.0 * encoded).astype(np.uint8)


_ENCODED = _table()


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
) -> tuple[FloatArray, Float32Array]:
    """Return a mesh with axes as triangles: corners (n, 3, 3), and their linear sRGB (n, 3, 3).

    Corners are x to the right and y downwards in pixels, and the height towards the viewer. The
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
        return corners, np.ascontiguousarray(colours, np.float32)
    drawn = lines.triangles(shown, directions, size)
    grey = np.full(drawn.shape, GREY)
    return (
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


HEIGHT = 6.0
ADVANCE = 5.5
"""Distance between the left edges of neighbouring letters."""

_PATHS = {
    "0": "10 30 41 45 36 16 05 01 10",
    "1": "04 26 20;00 40",
    "2": "05 16 36 45 44 00 40",
    "3": "06 46 24 34 43 41 30 10 01",
    "4": "30 36 02 42",
    "5": "46 06 03 33 42 41 30 10 01",
    "6": "46 16 05 01 10 30 41 42 33 03",
    "7": "06 46 10",
    "8": "13 04 05 16 36 45 44 33 13 02 01 10 30 41 42 33",
    "9": "00 30 41 45 36 16 05 04 13 43",
    "-": "03 43",
    "+": "03 43;21 25",
    ".": "20 20",
    "'": "26 24",
    "*": "26 23;05 44;45 04",
    "C": "45 36 16 05 01 10 30 41",
    "I": "20 26;10 30;16 36",
    "J": "46 41 30 10 01",
    "L": "06 00 40",
    "P": "00 06 36 45 44 33 03",
    "T": "20 26;06 46",
    "X": "00 46;06 40",
    "Y": "06 23 46;23 20",
    "Z": "06 46 00 40",
    "a": "40 44;43 34 14 03 01 10 30 41",
    "b": "06 00;01 10 30 41 43 34 14 03",
    "o": "10 30 41 43 34 14 03 01 10",
    "p": "04 0b;01 10 30 41 43 34 14 03",
    "t": "26 21 30 40;04 44",
    "u": "04 01 10 30 41;44 40",
    "v": "04 20 44",
    "z": "04 44 00 40",
}
"""Points as two digits, x and y; ``b`` is −2. A semicolon lifts the pen."""


def _points(path: str) -> FloatArray:
    rows = [(float(at[0]), -2.0 if at[1] == "b" else float(at[1])) for at in path.split()]
    return np.array(rows, np.float64)


GLYPHS = {name: [_points(path) for path in paths.split(";")] for name, paths in _PATHS.items()}
"""Polylines by character."""


def text_strokes(text: str) -> list[FloatArray]:
    """Return the polylines (n, 2) of a text, centred at the origin.

    Characters without a glyph leave a gap.
    """
    middle = np.array([(ADVANCE * len(text) - (ADVANCE - 4.0)) / 2.0, HEIGHT / 2.0])
    return [
        np.add(stroke, (ADVANCE * place, 0.0)) - middle
        for place, character in enumerate(text)
        for stroke in GLYPHS.get(character, [])
    ]


SLACK = 1.0
"""Samples by which the ends of a row are extended before each sample is tested."""

TOLERANCE = 1e-9
"""Largest negative weight of a sample that counts as on the edge."""

BAND_SAMPLES = 2**21
"""Samples of a band: 34 MB of depths and colours."""


def rasterise(corners: FloatArray, colours: Float32Array, size: int, samples: int) -> Float32Array:
    """Return red, green and blue times coverage, and coverage, (size, size, 4), of every pixel.

    `corners` (n, 3, 3) are x to the right, y downwards, both in pixels, and the height towards the
    viewer. Triangles may have any orientation; of several, the highest is seen. `colours` (n, 3, 3)
    are linear. A pixel has `samples` samples in each direction.
    """
    rows = max(1, BAND_SAMPLES // (size * samples * samples))
    fine = np.ascontiguousarray(corners * (samples, samples, 1.0))
    pixels = np.empty((size, size, 4), np.float32)
    for first in range(0, size, rows):
        band = pixels[first : first + rows]
        _fill_band(fine, colours, first, samples, band)
    return pixels


@leaf_kernel
def _cut(
    left: float,
    right: float,
    x0: float,
    y0: float,
    x1: float,
    y1: float,
    y: float,
    area: float,
) -> tuple[float, float]:
    """Cut the part of a row that is on the inner side of an edge.

    Without it, the time for thin triangles would be that of the boxes around them.
    """
    rise = y1 - y0
    if rise == 0.0:
        return left, right
    crossing = x0 + (y - y0) * (x1 - x0) / rise
    if (rise > 0.0) == (area > 0.0):
        return left, min(right, crossing)
    return max(left, crossing), right


@kernel
def _fill_band(
    corners: FloatArray, colours: Float32Array, first: int, samples: int, band: Float32Array
) -> None:
    rows, columns = band.shape[0] * samples, band.shape[1] * samples
    top = first * samples
    depth = np.full((rows, columns), -np.inf, np.float32)
    light = np.zeros((rows, columns, 3), np.float32)
    for triangle in range(len(corners)):
        x0, y0, z0 = corners[triangle, 0]
        x1, y1, z1 = corners[triangle, 1]
        x2, y2, z2 = corners[triangle, 2]
        area = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)
        if area == 0.0:
            continue
        # samples have their middles at half numbers
        low_row = max(int(np.ceil(min(y0, y1, y2) - 0.5)) - top, 0)
        high_row = min(int(np.floor(max(y0, y1, y2) - 0.5)) - top, rows - 1)
        leftmost, rightmost = min(x0, x1, x2), max(x0, x1, x2)
        for row in range(low_row, high_row + 1):
            y = row + top + 0.5
            left, right = leftmost, rightmost
            left, right = _cut(left, right, x1, y1, x2, y2, y, area)
            left, right = _cut(left, right, x2, y2, x0, y0, y, area)
            left, right = _cut(left, right, x0, y0, x1, y1, y, area)
            low_column = max(int(np.ceil(left - SLACK)), 0)
            high_column = min(int(np.floor(right + SLACK)), columns - 1)
            for column in range(low_column, high_column + 1):
                x = column + 0.5
                first_weight = ((x1 - x) * (y2 - y) - (x2 - x) * (y1 - y)) / area
                second_weight = ((x2 - x) * (y0 - y) - (x0 - x) * (y2 - y)) / area
                third_weight = 1.0 - first_weight - second_weight
                if min(first_weight, second_weight, third_weight) < -TOLERANCE:
                    continue
                height = np.float32(first_weight * z0 + second_weight * z1 + third_weight * z2)
                if height > depth[row, column]:
                    depth[row, column] = height
                    for channel in range(3):
                        light[row, column, channel] = (
                            first_weight * colours[triangle, 0, channel]
                            + second_weight * colours[triangle, 1, channel]
                            + third_weight * colours[triangle, 2, channel]
                        )
    share = np.float32(1.0 / (samples * samples))
    for row in range(band.shape[0]):
        for column in range(band.shape[1]):
            covered, red, green, blue = 0, 0.0, 0.0, 0.0
            for down in range(row * samples, (row + 1) * samples):
                for right in range(column * samples, (column + 1) * samples):
                    if depth[down, right] > -np.inf:
                        covered += 1
                        red += light[down, right, 0]
                        green += light[down, right, 1]
                        blue += light[down, right, 2]
            band[row, column, 0] = red * share
            band[row, column, 1] = green * share
            band[row, column, 2] = blue * share
            band[row, column, 3] = covered * share
