"""Mapping: colours out of gamut are moved onto a level's surface.

Axis 0 is lightness L, and hue is the angle of the two other coordinates; chroma C is their length.
All methods but ``clip-nearest`` keep the hue, with a focal point on the axis. Colours in gamut are
not changed. Results are in gamut: they are moved inwards by at least 2⁻⁴⁵ of the size of the
gamut, until `contains` is true.

=================  =============================================================================
method             the colour goes to
=================  =============================================================================
``clip-nearest``   the nearest point of the surface
``clip-hue``       the nearest point of its hue (HPMINDE, CIE 156:2004)
``clip-lightness`` the nearest lightness that its hue and chroma have in gamut; to the cusp of its
                   hue if its chroma is larger
``clip-chroma``    the axis, at its lightness, until it is in gamut; to the end of the axis in
                   gamut if it is lighter or darker
``clip-focal``     a focal point, until it is in gamut
``sgck``           see `gamutcore.queries.sgck`
=================  =============================================================================

Where a line does not meet the gamut, ``clip-hue`` applies, and where a half-plane of hue does not,
``clip-nearest``.
"""

from __future__ import annotations

from typing import Literal, NamedTuple, get_args

import numpy as np
from numpy.typing import ArrayLike

from gamutcore.arrays import BooleanArray, FloatArray, IndexArray, LongArray
from gamutcore.errors import OptionError
from gamutcore.kernels import kernel, leaf_kernel
from gamutcore.queries.containment import is_inside
from gamutcore.queries.crossings import LINE, SEGMENT, Work, crossings, find_crossings
from gamutcore.queries.cusp_table import find_cusp, hue_sector
from gamutcore.queries.face_tree import STACK
from gamutcore.queries.index import Level, LevelIndex, as_index
from gamutcore.queries.leaf_search import nearest_of_hue
from gamutcore.queries.line_sides import Point
from gamutcore.queries.nearest import nearest
from gamutcore.queries.rows import checked_points
from gamutcore.queries.sgck import compress

__all__ = ["Mapped", "Method", "map_colours"]

Method = Literal["clip-nearest", "clip-hue", "clip-lightness", "clip-chroma", "clip-focal", "sgck"]

NEAREST, HUE, LIGHTNESS, CHROMA, FOCAL = 0, 1, 2, 3, 4

INWARDS = 2.0**-45
"""First step inwards ÷ the size of the gamut: some hundred times the rounding of coordinates."""

HUES = 1024
"""Sectors of hues by which rows are ordered."""

TRIES = 8
"""Steps inwards, each four times the last; after them the point moves towards the centre."""


class Mapped(NamedTuple):
    """Mapped colours.

    Attributes
    ----------
    points : (n, 3) float64
    faces : (n,) int32
        The faces of the points before the step inwards. −1 where a colour is not on the surface: it
        was in gamut, or was mapped by ``sgck``.
    weights : (n, 3) float64
        Barycentric coordinates in the faces; NaN without a face.
    moved : (n,) bool
        Whether the colour was changed.
    """

    points: FloatArray
    faces: IndexArray
    weights: FloatArray
    moved: BooleanArray


def map_colours(
    points: ArrayLike,
    level: Level,
    method: Method,
    *,
    focus: ArrayLike | Literal["cusp"] | None = None,
    source: Level | None = None,
) -> Mapped:
    """Map colours into a level.

    Parameters
    ----------
    points : (n, 3) array_like
        Lightness and two chromatic coordinates, in the colour space of the level.
    level : LevelIndex or (vertices, faces, centre)
    method : {"clip-nearest", "clip-hue", "clip-lightness", "clip-chroma", "clip-focal", "sgck"}
    focus : (3,) array_like or "cusp", optional
        The focal point of ``clip-focal``. ``cusp``, the default, is the point on the axis with the
        lightness of the cusp of the colour's hue.
    source : LevelIndex or (vertices, faces, centre), optional
        The gamut that ``sgck`` maps from.

    Returns
    -------
    Mapped

    Raises
    ------
    InvalidPointsError
        A point is not three finite numbers; ``where["row"]`` names it.
    OptionError
        There is no such method, or `focus` or `source` does not apply or is missing.
    MeshError
        As for `build_index`.

    Examples
    --------
    >>> corners = np.vstack([np.zeros(3), 100 * np.eye(3)]) - (0, 20, 20)
    >>> tetrahedron = (corners, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)], (20, 0, 0))
    >>> map_colours([(30, 10, 0), (20, 90, 0)], tetrahedron, "clip-chroma").points.round(6).tolist()
    [[30.0, 10.0, 0.0], [20.0, 40.0, 0.0]]
    """
    if method not in get_args(Method):
        raise OptionError.refusal("method", method, f"one of {', '.join(get_args(Method))}")
    if focus is not None and method != "clip-focal":
        raise OptionError.not_applicable("focus", focus, "only clip-focal has a focal point")
    if source is not None and method != "sgck":
        message = "only sgck has a source gamut"
        raise OptionError.not_applicable("source", "of another gamut", message)
    if source is None and method == "sgck":
        raise OptionError(
            "The method sgck maps from a source gamut, and none is given.",
            where={"field": "source"},
            remedy="Give the gamut that the colours come from as source.",
        )
    found, index = checked_points(points), as_index(level)
    if source is not None:
        mapped = compress(found, index, as_index(source))
        return _clipped(mapped, found, index, FOCAL, None)
    focal = None
    if method == "clip-focal" and not (focus is None or isinstance(focus, str)):
        focal = checked_points(np.reshape(np.asarray(focus), (1, -1)), "focus")[0]
    elif isinstance(focus, str) and focus != "cusp":
        raise OptionError.refusal("focus", focus, "a point or cusp")
    return _clipped(found, found, index, get_args(Method).index(method), focal)


def _clipped(
    points: FloatArray,
    given: FloatArray,
    index: LevelIndex,
    method: int,
    focal: FloatArray | None,
) -> Mapped:
    """Clip points, and compare them with the given colours."""
    work = Work.with_room(len(index.faces))
    axis = np.array([[index.box[0, 0] - 1.0, 0.0, 0.0], [index.box[1, 0] + 1.0, 0.0, 0.0]])
    ends = crossings(axis[:1], axis[1:], index, "line").points[:, 0]
    # NaN if the axis does not meet the level
    ends = np.array([ends[0], ends[-1]]) if len(ends) else np.full(2, np.nan)
    focus = np.full(3, np.nan) if focal is None else focal
    result = Mapped(
        points.copy(),
        np.full(len(points), -1, np.int32),
        np.full((len(points), 3), np.nan),
        np.zeros(len(points), np.bool_),
    )
    _clip(points, index, method, focus, ends, work, *result)
    # those that no section of the hue could map
    rest = np.flatnonzero(result.moved & (result.faces < 0))
    if len(rest):
        near = nearest(points[rest], index)
        result.points[rest], result.faces[rest] = near.points, near.faces
        result.weights[rest] = near.weights
        towards = near.points - points[rest]
        _move_inwards(result.points, rest, towards, index, work.terms)
    changed = result.points != given
    result.moved[:] = changed[:, 0] | changed[:, 1] | changed[:, 2]
    return result


@kernel
def _move_inwards(
    points: FloatArray,
    rows: LongArray,
    towards: FloatArray,
    index: LevelIndex,
    terms: FloatArray,
) -> None:
    """Move points on the surface inwards along directions."""
    for place in range(len(rows)):
        row = rows[place]
        point = points[row, 0], points[row, 1], points[row, 2]
        direction = towards[place, 0], towards[place, 1], towards[place, 2]
        points[row, 0], points[row, 1], points[row, 2] = _inwards(point, direction, index, terms)


@leaf_kernel
def _inwards(point: Point, direction: Point, index: LevelIndex, terms: FloatArray) -> Point:
    """Return a point in gamut near a point on the surface: along a direction, or to the centre."""
    x, y, z = point
    u, v, w = direction
    length = np.sqrt(u * u + v * v + w * w)
    step = INWARDS * (1.0 / index.tree.scale + abs(x) + abs(y) + abs(z))
    if length > 0.0:
        along = step / length
        for _ in range(TRIES):
            px, py, pz = x + along * u, y + along * v, z + along * w
            if is_inside(px, py, pz, index, terms):
                return px, py, pz
            along *= 4.0
    share = INWARDS
    while share < 1.0:
        px = x + share * (index.centre[0] - x)
        py = y + share * (index.centre[1] - y)
        pz = z + share * (index.centre[2] - z)
        if is_inside(px, py, pz, index, terms):
            return px, py, pz
        share *= 4.0
    return index.centre[0], index.centre[1], index.centre[2]


@kernel
def _clip(  # noqa: PLR0912  # a branch for each method
    given: FloatArray,
    index: LevelIndex,
    method: int,
    focus: FloatArray,
    ends: FloatArray,
    work: Work,
    points: FloatArray,
    faces: IndexArray,
    weights: FloatArray,
    moved: BooleanArray,
) -> None:
    bounds = np.empty(STACK)
    order = _order_by_hue(given)
    for turn in range(len(given)):
        row = order[turn]
        start = given[row, 0], given[row, 1], given[row, 2]
        if is_inside(start[0], start[1], start[2], index, work.terms):
            continue
        moved[row] = True
        if method == NEAREST:
            continue
        chroma = np.sqrt(start[1] * start[1] + start[2] * start[2])
        ca, cb = (start[1] / chroma, start[2] / chroma) if chroma > 0.0 else (1.0, 0.0)
        # achromatic colours stay so
        rule = LIGHTNESS if method == HUE and chroma == 0.0 else method
        place = -1
        target = start
        if rule == LIGHTNESS:
            target, place = _by_lightness(start, index, work)
            if place < 0:
                target, place = _to_cusp(chroma, ca, cb, index, work)
        elif rule == CHROMA:
            grey = start[0], 0.0, 0.0
            if ends[0] <= start[0] <= ends[1]:
                target, place = _towards(start, grey, index, work)
            elif ends[0] <= ends[1]:
                target, place = _by_lightness(grey, index, work)
        elif rule == FOCAL:
            end = focus[0], focus[1], focus[2]
            if np.isnan(end[0]):
                end = find_cusp(ca, cb, index.cusps)[1], 0.0, 0.0
            target, place = _towards(start, end, index, work)
        if place >= 0:
            faces[row] = work.faces[place]
            for corner in range(3):
                weights[row, corner] = work.weights[place, corner]
        else:
            face, lightness, found = nearest_of_hue(
                given[row, 0],
                chroma,
                ca,
                cb,
                index,
                work.nodes,
                bounds,
                work.gaps,
                weights[row],
            )
            if face < 0:
                continue
            faces[row] = face
            target = lightness, found * ca, found * cb
        direction = target[0] - given[row, 0], target[1] - given[row, 1], target[2] - given[row, 2]
        points[row, 0], points[row, 1], points[row, 2] = _inwards(
            target, direction, index, work.terms
        )


@kernel
def _order_by_hue(points: FloatArray) -> IndexArray:
    """Return an order of points by hue, in which consecutive searches share cached data."""
    sectors, place = np.empty(len(points), np.int32), np.zeros(HUES + 1, np.int32)
    for row in range(len(points)):
        sectors[row] = hue_sector(points[row, 1], points[row, 2], HUES)
        place[sectors[row] + 1] += 1
    for sector in range(HUES):
        place[sector + 1] += place[sector]
    order = np.empty(len(points), np.int32)
    for row in range(len(points)):
        order[place[sectors[row]]] = row
        place[sectors[row]] += 1
    return order


@leaf_kernel
def _towards(start: Point, end: Point, index: LevelIndex, work: Work) -> tuple[Point, int]:
    """Return the first crossing of a segment, and its index in `work`; −1 without one."""
    if not (np.isfinite(end[0]) and find_crossings(start, end, SEGMENT, index, 0, work) > 0):
        return start, -1
    t = work.t[0]
    return (
        start[0] + t * (end[0] - start[0]),
        start[1] + t * (end[1] - start[1]),
        start[2] + t * (end[2] - start[2]),
    ), 0


@leaf_kernel
def _by_lightness(start: Point, index: LevelIndex, work: Work) -> tuple[Point, int]:
    """Return the crossing of nearest lightness, and its index in `work`; −1 without one."""
    size = 1.0 / index.tree.scale
    end = start[0] + size, start[1], start[2]
    count = find_crossings(start, end, LINE, index, 0, work)
    best, place = np.inf, -1
    for each in range(count):
        if abs(work.t[each]) < abs(best):
            best, place = work.t[each], each
    return (
        start[0] + (best * (end[0] - start[0]) if place >= 0 else 0.0),
        start[1],
        start[2],
    ), place


@leaf_kernel
def _to_cusp(
    chroma: float, ca: float, cb: float, index: LevelIndex, work: Work
) -> tuple[Point, int]:
    """Return the cusp of a hue, and its index, if the chroma is larger; otherwise −1."""
    most, lightness, edge, share = find_cusp(ca, cb, index.cusps)
    if edge < 0 or chroma < most:
        return (lightness, 0.0, 0.0), -1
    face, at = divmod(index.cusps.corners[edge], 3)
    work.faces[0] = face
    work.weights[0, at] = 0.0
    work.weights[0, (at + 1) % 3], work.weights[0, (at + 2) % 3] = 1.0 - share, share
    return (lightness, most * ca, most * cb), 0
