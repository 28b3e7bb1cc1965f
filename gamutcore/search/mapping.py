"""Mapping: colours out of gamut are moved onto a level's surface.

Axis 0 is lightness L, and hue is the angle of the two other coordinates; chroma C is their length.
All methods but ``clip-nearest`` keep the hue, with a focal point on the axis. Colours in gamut, and
those within a tolerance of it, are not changed. Other results are in gamut: they are moved inwards
by at least 2⁻⁴⁵ of the size of the gamut, until `contains` is true.

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
``sgck``           the gamut, with all colours of a source: see below
=================  =============================================================================

Where a line does not meet the gamut, ``clip-hue`` applies, and where a half-plane of hue does not,
``clip-nearest``.

SGCK is a sigmoidal lightness mapping that depends on chroma, then a knee towards the cusp:

1. Lightness. The range of the source's lightness is mapped to the part of it that the gamut has, by
   a cumulative normal distribution. Colours of high chroma keep their lightness: the sigmoid has
   the weight 1 − √(C³ ÷ (C³ + 5·10⁵)). The published curves begin where the gamut's black is 5 %
   of the range above the source's. Below, the curve is interpolated towards a straight line, so
   that equal blacks and whites have none.
2. Knee. Colours move on lines to the point on the axis that has the lightness of the cusp of their
   hue. Up to 90 % of the distance to the gamut's surface nothing changes. The rest of the way, up
   to the source's surface, is compressed linearly into the last 10 %. Lines on which the gamut
   contains the source do not change.

The constants of SGCK are for spaces whose lightness is 0 to 100, such as CIELAB.

Source: CIE 156:2004, "Guidelines for the evaluation of gamut mapping algorithms". The sigmoid is
G. Braun & M. Fairchild, "Image lightness rescaling using sigmoidal contrast enhancement functions",
Journal of Electronic Imaging 8 (1999), table 3 (images of normal lightness). The public
implementation of J. Morovič, PGMA 2.1 (2002), has the same constants and the same order of steps.
"""

from __future__ import annotations

from typing import Literal, NamedTuple, get_args

import numpy as np
from numpy.typing import ArrayLike

from gamutcore.arrays import BooleanArray, Float32Array, FloatArray, IndexArray, LongArray
from gamutcore.errors import MeshError, OptionError
from gamutcore.geometry import (
    Vector,
    dot,
    grouped,
    minus,
    plus,
    row,
    scaled,
    vector,
    write_row,
)
from gamutcore.kernels import kernel, leaf_kernel
from gamutcore.search.containment import contains, is_inside
from gamutcore.search.crossings import (
    LINE,
    SEGMENT,
    LineWorkspace,
    crossings,
    find_crossings,
)
from gamutcore.search.face_tree import STACK, WIDTH
from gamutcore.search.hue_tables import (
    RECTANGLE,
    find_cusp,
    hue_part,
    hue_sector,
    hue_turn,
    write_cusp,
)
from gamutcore.search.index import Level, LevelIndex, as_index, build_index, checked_points
from gamutcore.search.nearest import nearest
from gamutcore.search.sections import cusp_points

__all__ = ["Mapped", "MappingMethod", "map_colours"]

MappingMethod = Literal[
    "clip-nearest", "clip-hue", "clip-lightness", "clip-chroma", "clip-focal", "sgck"
]

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
    method: MappingMethod,
    *,
    focus: ArrayLike | Literal["cusp"] | None = None,
    source: Level | None = None,
    white: float = 100.0,
    tolerance: float = 0.0,
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
    white : float, optional
        Lightness of white in the space. The constants of ``sgck`` are for 100.
    tolerance : float, optional
        Distance up to which colours outside of the level count as in gamut, as for `contains`.

    Returns
    -------
    Mapped

    Raises
    ------
    InvalidPointsError
        A point is not three finite numbers; ``where["row"]`` names it.
    OptionError
        There is no such method, or `focus` or `source` does not apply or is missing.

    Examples
    --------
    >>> corners = np.vstack([np.zeros(3), 100 * np.eye(3)]) - (0, 20, 20)
    >>> tetrahedron = (corners, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)], (20, 0, 0))
    >>> map_colours([(30, 10, 0), (20, 90, 0)], tetrahedron, "clip-chroma").points.round(6).tolist()
    [[30.0, 10.0, 0.0], [20.0, 40.0, 0.0]]
    """
    if method not in get_args(MappingMethod):
        raise OptionError.refusal("method", method, f"one of {', '.join(get_args(MappingMethod))}")
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
    colours, index = checked_points(points), as_index(level)
    if source is not None:
        mapped = _compress(colours, index, as_index(source), white, tolerance)
        result = _clip_points(mapped, colours, index, NEAREST, None, tolerance)
        rest = np.flatnonzero(
            np.linalg.norm(result.points - mapped, axis=1) > SURFACE_ERROR * white
        )
        clipped = _clip_points(mapped[rest], colours[rest], index, HUE, None, tolerance)
        result.points[rest], result.moved[rest] = clipped.points, clipped.moved
        result.faces[rest], result.weights[rest] = clipped.faces, clipped.weights
        return result
    focal = None
    if method == "clip-focal" and not (focus is None or isinstance(focus, str)):
        focal = checked_points(np.reshape(np.asarray(focus), (1, -1)), "focus")[0]
    elif isinstance(focus, str) and focus != "cusp":
        raise OptionError.refusal("focus", focus, "a point or cusp")
    return _clip_points(
        colours, colours, index, get_args(MappingMethod).index(method), focal, tolerance
    )


def _clip_points(
    points: FloatArray,
    originals: FloatArray,
    index: LevelIndex,
    method: int,
    focal: FloatArray | None,
    tolerance: float,
) -> Mapped:
    """Clip points that are out of gamut; `moved` tells which differ from the original colours."""
    result = Mapped(
        points.copy(),
        np.full(len(points), -1, np.int32),
        np.full((len(points), 3), np.nan),
        np.zeros(len(points), np.bool_),
    )
    rows = np.flatnonzero(~contains(points, index, tolerance))
    if len(rows):
        clipped = _clip_outside_points(points[rows], index, method, focal)
        result.points[rows], result.faces[rows] = clipped.points, clipped.faces
        result.weights[rows] = clipped.weights
    changed = result.points != originals
    result.moved[:] = changed[:, 0] | changed[:, 1] | changed[:, 2]
    return result


def _clip_outside_points(
    points: FloatArray, index: LevelIndex, method: int, focal: FloatArray | None
) -> Mapped:
    """Clip points outside of the level."""
    work = LineWorkspace.with_room(len(index.faces))
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
        point, direction = row(points, rows[place], 0), row(towards, place, 0)
        write_row(points, rows[place], 0, _inwards(point, direction, index, terms))


@leaf_kernel
def _inwards(point: Vector, direction: Vector, index: LevelIndex, terms: FloatArray) -> Vector:
    """Return a point in gamut near a point on the surface: along a direction, or to the centre."""
    (x, y, z), length = point, np.sqrt(dot(direction, direction))
    step = INWARDS * (1.0 / index.tree.scale + abs(x) + abs(y) + abs(z))
    if length > 0.0:
        along = step / length
        for _ in range(TRIES):
            moved = plus(point, scaled(along, direction))
            if is_inside(moved, index, terms):
                return moved
            along *= 4.0
    centre, share = vector(index.centre), INWARDS
    while share < 1.0:
        moved = plus(point, scaled(share, minus(centre, point)))
        if is_inside(moved, index, terms):
            return moved
        share *= 4.0
    return centre


@kernel
def _clip(  # noqa: PLR0912  # a branch for each method
    given: FloatArray,
    index: LevelIndex,
    method: int,
    focus: FloatArray,
    ends: FloatArray,
    work: LineWorkspace,
    points: FloatArray,
    faces: IndexArray,
    weights: FloatArray,
    moved: BooleanArray,
) -> None:
    bounds = np.empty(STACK)
    for number in _order_by_hue(given):
        start = row(given, number, 0)
        if is_inside(start, index, work.terms):
            continue
        moved[number] = True
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
            end = vector(focus)
            if np.isnan(end[0]):
                end = find_cusp(ca, cb, index.cusps)[1], 0.0, 0.0
            target, place = _towards(start, end, index, work)
        if place >= 0:
            faces[number] = work.faces[place]
            for corner in range(3):
                weights[number, corner] = work.weights[place, corner]
        else:
            face, lightness, target_chroma = _nearest_of_hue(
                start[0],
                chroma,
                ca,
                cb,
                index,
                work.nodes,
                bounds,
                work.gaps,
                weights[number],
            )
            if face < 0:
                continue
            faces[number] = face
            target = lightness, target_chroma * ca, target_chroma * cb
        inwards = _inwards(target, minus(target, start), index, work.terms)
        write_row(points, number, 0, inwards)


@kernel
def _order_by_hue(points: FloatArray) -> IndexArray:
    """Return an order of points by hue, in which consecutive searches share cached data."""
    sector = np.empty(len(points), np.int32)
    for number in range(len(points)):
        sector[number] = hue_sector(points[number, 1], points[number, 2], HUES)
    return grouped(sector, HUES)[1]


@leaf_kernel
def _towards(
    start: Vector, end: Vector, index: LevelIndex, work: LineWorkspace
) -> tuple[Vector, int]:
    """Return the first crossing of a segment, and its index in `work`; −1 without one."""
    if not (np.isfinite(end[0]) and find_crossings(start, end, SEGMENT, index, 0, work) > 0):
        return start, -1
    t = work.t[0]
    return plus(start, scaled(t, minus(end, start))), 0


@leaf_kernel
def _by_lightness(start: Vector, index: LevelIndex, work: LineWorkspace) -> tuple[Vector, int]:
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
    chroma: float, ca: float, cb: float, index: LevelIndex, work: LineWorkspace
) -> tuple[Vector, int]:
    """Return the cusp of a hue, and its index, if the chroma is larger; otherwise −1."""
    most, lightness, edge, share = find_cusp(ca, cb, index.cusps)
    if edge < 0 or chroma < most:
        return (lightness, 0.0, 0.0), -1
    work.faces[0] = write_cusp(index.cusps, edge, share, work.weights, 0)
    return (lightness, most * ca, most * cb), 0


FARTHEST = 1e300
"""Limit of squared distances; those of empty boxes are infinite."""

RECTANGLE_ROUNDING = 2.0**-44
"""Widening of rectangles ÷ the largest coordinate."""


@leaf_kernel
def _nearest_of_hue(
    lightness: float,
    chroma: float,
    ca: float,
    cb: float,
    index: LevelIndex,
    nodes: LongArray,
    bounds: FloatArray,
    squares: FloatArray,
    weights: FloatArray,
) -> tuple[int, float, float]:
    """Return face, lightness and chroma of the surface point of a hue that is nearest to a colour.

    `ca` and `cb` are cosine and sine of the hue angle. The face is −1 if no face meets the
    half-plane. `weights` (3,) receives the barycentric coordinates. `nodes` and `bounds` (STACK,)
    and `squares` (WIDTH,) are work arrays.
    """
    table, middle, scale = index.hues, index.centre[0], index.tree.scale
    margin = RECTANGLE_ROUNDING * (1.0 + scale * (abs(lightness) + chroma + abs(middle)))
    best, best_lightness, best_chroma, square = -1, np.nan, np.nan, np.inf
    limit = FARTHEST
    sectors = len(table.roots)
    turn = 0.25 * sectors * hue_turn(ca, cb)
    sector = min(int(turn), sectors - 1)
    part = hue_part(turn - sector)
    nodes[0], bounds[0] = table.roots[sector], 0.0
    height = 1 if nodes[0] >= 0 else 0
    while height > 0:
        height -= 1
        if bounds[height] > limit:
            continue
        node = nodes[height]
        _set_bounds(scale * (lightness - middle), scale * chroma, table.rectangles, node, squares)
        first = table.first[node]
        bottom = height
        child = first if first >= 0 else ~first
        near = height
        for at in range(WIDTH):  # without branches, which processors cannot predict here
            nodes[near], bounds[near] = child + at, squares[at]
            near += squares[at] <= limit
        if first >= 0:
            height = near
            nearest = bottom
            for at in range(bottom, near):
                nearest = at if bounds[at] < bounds[nearest] else nearest
            if near > bottom:  # the nearest on top
                nodes[nearest], nodes[near - 1] = nodes[near - 1], nodes[nearest]
                bounds[nearest], bounds[near - 1] = bounds[near - 1], bounds[nearest]
            continue
        for at in range(bottom, near):
            place = nodes[at]
            if part < table.spans[place, 0] or part > table.spans[place, 1]:
                continue
            face = table.faces[place]
            closer, lower, lower_chroma = _nearest_of_face(
                lightness, chroma, ca, cb, index.vertices, index.faces, face, square, weights
            )
            if closer < square:
                best, best_lightness, best_chroma, square = face, lower, lower_chroma, closer
                limit = (scale * np.sqrt(square) + margin) ** 2
    return best, best_lightness, best_chroma


@leaf_kernel
def _set_bounds(
    x: float, y: float, rectangles: Float32Array, node: int, squares: FloatArray
) -> None:
    """Set `squares` (8,) to the squared distances of a point to the rectangles of a node.

    The point is lightness relative to the centre, and chroma. Point and result are scaled. The
    result is infinite without a child.
    """
    row = np.uint64(node)
    # a loop whose length the compiler knows is unrolled first, and then not vectorised
    for each in range(rectangles.shape[1] // RECTANGLE):
        at = np.uint64(each)
        u = max(rectangles[row, at] - x, x - rectangles[row, at + np.uint64(16)], 0.0)
        v = max(
            rectangles[row, at + np.uint64(8)] - y, y - rectangles[row, at + np.uint64(24)], 0.0
        )
        squares[at] = u * u + v * v


@leaf_kernel
def _nearest_of_face(
    lightness: float,
    chroma: float,
    ca: float,
    cb: float,
    vertices: FloatArray,
    faces: IndexArray,
    face: int,
    limit: float,
    weights: FloatArray,
) -> tuple[float, float, float]:
    """Return squared distance, lightness and chroma of the nearest point of a face's section.

    The distance is infinite without a section. Weights are set only below the limit.
    """
    a, b, c = faces[face, 0], faces[face, 1], faces[face, 2]
    side_a = ca * vertices[a, 2] - cb * vertices[a, 1]
    side_b = ca * vertices[b, 2] - cb * vertices[b, 1]
    side_c = ca * vertices[c, 2] - cb * vertices[c, 1]
    left_a, left_b, left_c = side_a >= 0.0, side_b >= 0.0, side_c >= 0.0
    if left_a == left_b and left_b == left_c:
        return np.inf, np.nan, np.nan
    # the corner that is alone on its side comes first
    place = 0
    if left_a == left_c:
        a, b, c, side_a, side_b, side_c, place = b, c, a, side_b, side_c, side_a, 1
    elif left_a == left_b:
        a, b, c, side_a, side_b, side_c, place = c, a, b, side_c, side_a, side_b, 2
    s, t = side_a / (side_a - side_b), side_a / (side_a - side_c)
    chroma_a = ca * vertices[a, 1] + cb * vertices[a, 2]
    one = chroma_a + s * (ca * vertices[b, 1] + cb * vertices[b, 2] - chroma_a)
    two = chroma_a + t * (ca * vertices[c, 1] + cb * vertices[c, 2] - chroma_a)
    if one < 0.0 and two < 0.0:
        return np.inf, np.nan, np.nan
    low = vertices[a, 0] + s * (vertices[b, 0] - vertices[a, 0])
    high = vertices[a, 0] + t * (vertices[c, 0] - vertices[a, 0])
    rise, run = high - low, two - one
    length = rise * rise + run * run
    share = ((lightness - low) * rise + (chroma - one) * run) / length if length > 0.0 else 0.0
    share = min(max(share, 0.0), 1.0)
    if one < 0.0:  # not beyond the axis
        share = max(share, -one / run)
    elif two < 0.0:
        share = min(share, -one / run)
    near, near_chroma = low + share * rise, max(one + share * run, 0.0)
    square = (near - lightness) ** 2 + (near_chroma - chroma) ** 2
    if square < limit:
        weights[place] = (1.0 - share) * (1.0 - s) + share * (1.0 - t)
        weights[(place + 1) % 3] = (1.0 - share) * s
        weights[(place + 2) % 3] = share * t
    return square, near, near_chroma


DARKEST = (5.0, 10.0, 15.0, 20.0)
"""Lowest lightness of the gamut for which Braun & Fairchild give a sigmoid: per cent of the
source's range above its black. Their sources begin at L* 0."""

MEANS = (53.7, 56.8, 58.2, 60.6)
"""The mean of the normal distribution for each of them."""

DEVIATIONS = (43.0, 40.0, 35.0, 34.5)
"""The standard deviation for each of them."""

CHROMA_CUBED = 5e5
"""The cube of the chroma at which the weight of the sigmoid is 1 − √½ (CIE 156:2004)."""

KNEE = 0.9
"""Share of the distance to the gamut's surface that is not compressed (CIE 156:2004)."""

SURFACE_ERROR = 1e-3
"""Distance, relative to the lightness of white, up to which colours outside count as on the
surface: the default error of levels."""

GAP = 0.01
"""Part of a line by which gaps in it may differ, where a surface is not star-shaped from the focal
point. Samplings of one surface have gaps that differ by their errors."""


def _compress(
    points: FloatArray, index: LevelIndex, source: LevelIndex, white: float, tolerance: float
) -> FloatArray:
    """Return colours (n, 3) of `source` compressed into `index` by SGCK, in gamut within rounding.

    Exceptions are colours outside the source, and lines that do not begin in gamut. Lines on which
    the gamut contains the source have no knee. Otherwise, the knee ends at the source's surface
    after the mapping of lightness. If the centre does not see all of that surface, the knee ends at
    the surface before the mapping.
    """
    if contains(source.vertices, index, max(SURFACE_ERROR * white, tolerance)).all():
        return points.copy()
    ranges = (*source.box[:, 0].tolist(), *index.box[:, 0].tolist(), white)
    scaled = _map_lightness(points, ranges)
    hues = np.degrees(np.arctan2(points[:, 2], points[:, 1]))
    focus = np.zeros_like(points)
    focus[:, 0] = cusp_points(hues, index).points[:, 0]
    rows = _order_by_hue(points)
    rows = rows[np.isfinite(focus[rows, 0]) & (scaled[rows] != focus[rows]).any(axis=1)]
    focus, target = focus[rows], scaled[rows]
    # distances from the focus ÷ that of the colour
    into = _Rays.of(focus, target, index)
    origin = _Rays.of(focus, target, _source_after_lightness(source, ranges))
    surface, limit = into.distances(0), origin.distances(-1)
    with np.errstate(invalid="ignore", divide="ignore"):
        knee = KNEE * surface
        slope = (surface - knee) / (limit - knee)
        share = np.minimum(knee + slope * (1.0 - knee), surface)
    # NaN compares as false
    share[~((knee < 1.0) & (limit > surface)) | into.shares_gaps_with(origin)] = 1.0
    scaled[rows] = focus + share[:, np.newaxis] * (target - focus)
    return scaled


def _sigmoid_lightness(
    lightness: FloatArray, chroma: FloatArray, ranges: tuple[float, float, float, float, float]
) -> FloatArray:
    """Return the lightness after the sigmoid and before the knee.

    `ranges` has the lowest and highest lightness of the source, of the gamut, and that of white.
    """
    from scipy.special import ndtr  # noqa: PLC0415  # 15 MB; only this method needs it

    low, high, lowest, highest, white = ranges
    # a wider range than that of the source is not used
    darkest, lightest = max(low, lowest), min(high, highest)
    if darkest >= lightest:
        darkest, lightest = lowest, highest
    dark = 100.0 * (darkest - low) / (high - low)
    mean, deviation = np.interp(dark, DARKEST, MEANS), np.interp(dark, DARKEST, DEVIATIONS)
    part = (lightness - low) / (high - low)
    shares = np.asarray(ndtr((100.0 * part - mean) / deviation))
    least, most = ndtr((np.array([0.0, 100.0]) - mean) / deviation)
    bend = min(dark / DARKEST[0], 1.0)
    shares = bend * (shares - least) / (most - least) + (1.0 - bend) * part
    sigmoid = darkest + (lightest - darkest) * shares
    cubed = (100.0 * chroma / white) ** 3
    weight = 1.0 - np.sqrt(cubed / (cubed + CHROMA_CUBED))
    mapped: FloatArray = weight * sigmoid + (1.0 - weight) * lightness
    return mapped


def _map_lightness(
    points: FloatArray, ranges: tuple[float, float, float, float, float]
) -> FloatArray:
    low, high, lowest, highest, _ = ranges
    if lowest <= low and high <= highest:
        return points.copy()
    chroma = np.hypot(points[:, 1], points[:, 2])
    return np.column_stack([_sigmoid_lightness(points[:, 0], chroma, ranges), points[:, 1:]])


def _source_after_lightness(
    source: LevelIndex, ranges: tuple[float, float, float, float, float]
) -> LevelIndex:
    """Return the source after the mapping of lightness."""
    low, high, lowest, highest, _ = ranges
    if lowest <= low and high <= highest:
        return source
    vertices = _map_lightness(source.vertices, ranges)
    centre = _map_lightness(source.centre[np.newaxis], ranges)[0]
    try:
        return build_index(vertices, source.faces, centre)
    except MeshError:
        return source  # the centre does not see all faces any more


class _Rays(NamedTuple):
    """Distances t at which rays cross a level, those of each ray after those of the last.

    `offsets` (n + 1,) has the first of each ray.
    """

    t: FloatArray
    offsets: LongArray

    @classmethod
    def of(cls, start: FloatArray, target: FloatArray, index: LevelIndex) -> _Rays:
        """Return the crossings of rays from starts, at t = 0, through targets, at t = 1."""
        ray_crossings = crossings(start, target, index, "ray")
        return cls(ray_crossings.t, ray_crossings.offsets)

    def distances(self, which: int) -> FloatArray:
        """Return t where rays leave first (0) or last (−1); NaN if they do not begin inside."""
        begin, end = self.offsets[:-1], self.offsets[1:]
        inside = np.flatnonzero((end - begin) % 2 == 1)
        distances = np.full(len(begin), np.nan)
        distances[inside] = self.t[begin[inside] if which == 0 else end[inside] - 1]
        return distances

    def shares_gaps_with(self, other: _Rays) -> BooleanArray:
        """Whether each ray has gaps, and the same ones as in another level, within `GAP`."""
        counts, others = np.diff(self.offsets), np.diff(other.offsets)
        same = np.zeros(len(counts), np.bool_)
        for count in range(3, int(counts.max(initial=0)) + 1, 2):
            rows = np.flatnonzero((counts == count) & (others == count))
            places = np.arange(count)
            own = self.t[self.offsets[rows][:, np.newaxis] + places]
            rest = other.t[other.offsets[rows][:, np.newaxis] + places]
            beyond = np.where(places % 2 == 0, rest - own, own - rest)
            same[rows] = (beyond <= GAP * own).all(axis=1)
        return same
