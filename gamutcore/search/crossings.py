"""Crossings: where segments, rays and lines pass through a level's surface, without gaps.

A line crosses a face if it passes all three edges on the same side. The sides are signs of
determinants: certain in float64, or exact and never 0. Crossings therefore enter and leave in turn,
also at edges and vertices. The faces come from the tree of boxes (`gamutcore.search.face_tree`).
Boxes are widened by the rounding errors of the line.

Where a determinant is 0, the sign is that of an infinitely small change:

1. The surface is scaled by 1 + ε about the centre, because it belongs to the gamut. A line that
   touches the surface crosses it twice, and an end on the surface is inside, as for `contains`.
2. The second point of the line is moved by (δ, δ², δ³), with δ far smaller than ε.

No line then meets an edge or a vertex. The signs follow H. Edelsbrunner & E. P. Mücke, "Simulation
of Simplicity", ACM Transactions on Graphics 9 (1990).
"""

from __future__ import annotations

from typing import Literal, NamedTuple, get_args

import numpy as np
from numpy.typing import ArrayLike

from gamutcore.arrays import BooleanArray, FloatArray, IndexArray, LongArray
from gamutcore.errors import InvalidPointsError, OptionError
from gamutcore.geometry import (
    TERMS,
    Vector,
    area,
    cross,
    dot,
    face_corners,
    minus,
    moved_orientation,
    orientation,
    plus,
    row,
    scaled,
    triple,
    vector,
    write_row,
)
from gamutcore.kernels import kernel, leaf_kernel
from gamutcore.search.containment import height_of, is_inside
from gamutcore.search.face_tree import STACK, WIDTH, set_box_gaps
from gamutcore.search.index import (
    Level,
    LevelIndex,
    as_index,
    checked_points,
    surface_points,
)

__all__ = [
    "LINE",
    "SEGMENT",
    "Crossings",
    "Kind",
    "LineWorkspace",
    "crossings",
    "find_crossings",
]

Kind = Literal["segment", "ray", "line"]

SEGMENT, RAY, LINE = 0, 1, 2

SIDE_ROUNDING = 2.0**-48
"""Bound of the rounding error of a side's determinant ÷ the product of its lengths. The steps are
differences, a vector product and a scalar product, with some ten roundings of 2⁻⁵³."""

BOX_ROUNDING = 2.0**-46
"""How far boxes are widened ÷ the distance of the line's point from the farthest vertex."""

STEEPEST = 2.0**200
"""Takes the place of 1 ÷ 0 where a line is parallel to the sides of a box."""


class Crossings(NamedTuple):
    """Crossings of lines with a surface. Those of row i are ``offsets[i]`` to ``offsets[i + 1]``.

    Attributes
    ----------
    offsets : (n + 1,) int64
    t : (m,) float64
        In increasing order for each row: 0 at the start, 1 at the end.
    entering : (m,) bool
        Whether the line goes into the gamut. Entering and leaving alternate in each row.
    points : (m, 3) float64
        On the faces.
    faces : (m,) int32
    weights : (m, 3) float64
        Barycentric coordinates in the faces, not negative, with the sum 1.
    """

    offsets: LongArray
    t: FloatArray
    entering: BooleanArray
    points: FloatArray
    faces: IndexArray
    weights: FloatArray


class LineWorkspace(NamedTuple):
    """Room for crossings, with the arrays of `Crossings`, and work arrays of the search."""

    t: FloatArray
    entering: BooleanArray
    faces: IndexArray
    weights: FloatArray
    nodes: LongArray  # (STACK,) stack of nodes and faces
    gaps: FloatArray  # (WIDTH,) lengths of a line in the boxes of a node
    terms: FloatArray  # (TERMS,) for the exact predicates

    @classmethod
    def with_room(cls, room: int) -> LineWorkspace:
        """Return arrays for a number of crossings."""
        return cls(
            np.empty(room),
            np.empty(room, np.bool_),
            np.empty(room, np.int32),
            np.empty((room, 3)),
            np.empty(STACK, np.int64),
            np.empty(WIDTH),
            np.empty(TERMS),
        )

    def with_twice_the_room(self, used: int) -> LineWorkspace:
        """Return arrays of twice the length with the same first crossings."""
        longer = LineWorkspace.with_room(2 * len(self.t))
        longer.t[:used], longer.entering[:used] = self.t[:used], self.entering[:used]
        longer.faces[:used], longer.weights[:used] = self.faces[:used], self.weights[:used]
        return longer


def crossings(
    starts: ArrayLike, ends: ArrayLike, level: Level, kind: Kind = "segment"
) -> Crossings:
    """Find all crossings of segments, rays or lines with the surface of a level.

    Parameters
    ----------
    starts, ends : (n, 3) array_like
        Two points of each line, in the colour space of the level. Rays begin at the start and go
        beyond the end; lines go beyond both.
    level : LevelIndex or (vertices, faces, centre)
    kind : {"segment", "ray", "line"}, optional

    Returns
    -------
    Crossings
        The faces, and whether they are entered, are exact for the given floats, if their magnitudes
        are 0 or at least 1e-80. A line has an even number of crossings. A segment has an odd
        number if just one of its ends is in gamut. A line that touches the surface crosses it twice
        or not at all.

    Raises
    ------
    InvalidPointsError
        A point is not three finite numbers, or a ray or line has two equal points;
        ``where["row"]`` names them. Or the numbers of starts and ends differ.
    OptionError
        There is no such kind.

    Examples
    --------
    >>> corners = np.vstack([np.zeros(3), np.eye(3)])
    >>> tetrahedron = (corners, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)], (0.1, 0.1, 0.1))
    >>> line_crossings = crossings([(0.25, 0.25, -1.0)], [(0.25, 0.25, 1.0)], tetrahedron)
    >>> line_crossings.t.tolist(), line_crossings.entering.tolist(), line_crossings.points.tolist()
    ([0.5, 0.75], [True, False], [[0.25, 0.25, 0.0], [0.25, 0.25, 0.5]])
    """
    if kind not in get_args(Kind):
        raise OptionError.refusal("kind", kind, "segment, ray or line")
    first, second = checked_points(starts, "starts"), checked_points(ends, "ends")
    if len(first) != len(second):
        raise InvalidPointsError(
            f"There are {len(first)} starts and {len(second)} ends.",
            where={"field": "ends"},
            remedy="Give one end for each start.",
        )
    if kind != "segment":
        equal = (first == second).all(axis=1)
        if equal.any():
            row = int(np.argmax(equal))
            raise InvalidPointsError(
                f"Start and end of row {row} are equal, so a {kind} has no direction.",
                where={"field": "ends", "row": row},
                remedy="Give two different points.",
            )
    index = as_index(level)
    number = get_args(Kind).index(kind)
    offsets = np.zeros(len(first) + 1, np.int64)
    work = LineWorkspace.with_room(64 + len(first))
    row = _cross(first, second, number, index, 0, offsets, work)
    while row < len(first):
        work = work.with_twice_the_room(int(offsets[row]))
        row = _cross(first, second, number, index, row, offsets, work)
    # views: memory that nothing was written to is not occupied
    last = offsets[-1]
    faces, weights = work.faces[:last], work.weights[:last]
    points = surface_points(index, faces, weights)
    return Crossings(offsets, work.t[:last], work.entering[:last], points, faces, weights)


@kernel
def _cross(
    starts: FloatArray,
    ends: FloatArray,
    kind: int,
    index: LevelIndex,
    number: int,
    offsets: LongArray,
    work: LineWorkspace,
) -> int:
    """Find the crossings of rows until the arrays are full, and return the first row without."""
    while number < len(starts):
        start, end = row(starts, number, 0), row(ends, number, 0)
        filled = find_crossings(start, end, kind, index, offsets[number], work)
        if filled < 0:
            break
        number += 1
        offsets[number] = filled
    return number


class Line(NamedTuple):
    """A line for which crossings are searched."""

    start: Vector
    end: Vector
    along: Vector  # from start to end
    kind: int  # SEGMENT, RAY or LINE
    origin: Vector  # the start or the end, whichever is nearer to the centre
    shift: float  # t of the origin: 0 or 1
    uncertain: float  # determinants up to this may have the wrong sign


@leaf_kernel
def find_crossings(
    start: Vector, end: Vector, kind: int, index: LevelIndex, begin: int, work: LineWorkspace
) -> int:
    """Write the crossings of one line in order from index `begin`; return the end, or −1 if full.

    `kind` is SEGMENT, RAY or LINE. Equal points have no crossing.
    """
    tree, nodes, gaps = index.tree, work.nodes, work.gaps
    along = minus(end, start)
    square = dot(along, along)
    if square == 0.0:
        return begin
    # coordinates are relative to the point that is nearer to the centre, for less rounding
    centre = vector(index.centre)
    origin, shift, near = start, 0.0, minus(start, centre)
    other = minus(end, centre)
    if dot(near, near) > dot(other, other):
        origin, shift, near = end, 1.0, other
    length, scale = np.sqrt(square), tree.scale
    reach = np.sqrt(dot(near, near)) + 1.0 / scale
    line = Line(start, end, along, kind, origin, shift, SIDE_ROUNDING * length * reach * reach)
    (dx, dy, dz), least = along, length / STEEPEST
    slope = (
        1.0 / (scale * (dx if abs(dx) > least else least)),
        1.0 / (scale * (dy if abs(dy) > least else least)),
        1.0 / (scale * (dz if abs(dz) > least else least)),
    )
    low = -shift if kind != LINE else -np.inf
    high = 1.0 - shift if kind == SEGMENT else np.inf
    margin = BOX_ROUNDING * scale * reach

    filled = begin
    nodes[0] = 0
    waiting = 1
    while waiting > 0:
        waiting -= 1
        node = nodes[waiting]
        set_box_gaps(scaled(scale, near), slope, low, high, margin, index.boxes, node, gaps)
        child = tree.first[node]
        first = child if child >= 0 else ~child
        above = waiting
        for at in range(WIDTH):  # without branches, which processors cannot predict here
            nodes[above] = first + at
            above += gaps[at] >= 0.0
        if child >= 0:
            waiting = above
            continue
        for at in range(waiting, above):
            filled = _add_crossing(line, index, tree.faces[nodes[at]], begin, filled, work)
            if filled < 0:
                return -1
    if filled - begin > 1:
        _alternate(start, kind, index, begin, filled, work)
    return filled


@leaf_kernel
def _add_crossing(
    line: Line, index: LevelIndex, face: int, begin: int, filled: int, work: LineWorkspace
) -> int:
    """Add the crossing of a line with a face, if any; return the new end of crossings."""
    start, end, direction, kind, origin, shift, uncertain = line
    a, b, c = face_corners(index.vertices, index.faces, face)
    a, b, c = minus(a, origin), minus(b, origin), minus(c, origin)
    across = cross(direction, a)
    side_a, side_b, side_c = triple(direction, b, c), -dot(across, c), dot(across, b)
    smallest, largest = min(side_a, side_b, side_c), max(side_a, side_b, side_c)
    if smallest < -uncertain and largest > uncertain:
        return filled
    outwards = smallest > uncertain
    if not outwards and largest >= -uncertain:
        leaving, side_a, side_b, side_c = _exact_sides(start, end, index, face, work.terms)
        if leaving == 0:
            return filled
        outwards = leaving > 0
    if kind != LINE and _is_below(start, index, face, work.terms) != outwards:
        return filled  # before the start
    if kind == SEGMENT and _is_below(end, index, face, work.terms) == outwards:
        return filled  # after the end
    if filled == len(work.t):
        return -1
    share = 1.0 / (side_a + side_b + side_c)
    weights = share * side_a, share * side_b, share * side_c
    point = plus(plus(scaled(weights[0], a), scaled(weights[1], b)), scaled(weights[2], c))
    time = shift + dot(point, direction) / dot(direction, direction)
    if kind != LINE:
        time = max(time, 0.0)
    if kind == SEGMENT:
        time = min(time, 1.0)
    place = filled
    while place > begin and work.t[place - 1] > time:
        work.t[place] = work.t[place - 1]
        _copy(work, place - 1, place)
        place -= 1
    work.t[place], work.faces[place], work.entering[place] = time, face, not outwards
    write_row(work.weights, place, 0, weights)
    return filled + 1


@leaf_kernel
def _copy(work: LineWorkspace, source: int, target: int) -> None:
    """Copy a crossing, except t."""
    work.faces[target] = work.faces[source]
    work.entering[target] = work.entering[source]
    for corner in range(3):
        work.weights[target, corner] = work.weights[source, corner]


@leaf_kernel
def _alternate(
    start: Vector, kind: int, index: LevelIndex, begin: int, end: int, work: LineWorkspace
) -> None:
    """Reorder crossings whose t differ by rounding, so that entering and leaving alternate."""
    entries = 0
    for place in range(begin, end):
        entries += work.entering[place]
    if 2 * entries == end - begin:
        expected = kind != SEGMENT or not is_inside(start, index, work.terms)
    else:
        expected = 2 * entries > end - begin
    for place in range(begin, end):
        other = place
        while other < end and work.entering[other] != expected:
            other += 1
        while place < other < end:
            work.faces[other], work.faces[other - 1] = work.faces[other - 1], work.faces[other]
            work.entering[other - 1], work.entering[other] = expected, not expected
            for corner in range(3):
                moved = work.weights[other, corner]
                work.weights[other, corner] = work.weights[other - 1, corner]
                work.weights[other - 1, corner] = moved
            other -= 1
        expected = not expected


@leaf_kernel
def _exact_sides(
    start: Vector, end: Vector, index: LevelIndex, face: int, terms: FloatArray
) -> tuple[int, float, float, float]:
    """Return the direction in which a line crosses a face, and its determinants with the edges.

    The direction is 1 if the line leaves the gamut, −1 if it enters, 0 if it misses the face. For
    the edge p, q opposite to each corner, the determinant is det(end − start, p − start, q −
    start).
    """
    a, b, c = face_corners(index.vertices, index.faces, face)
    side_a, sign_a = _exact_side(start, end, b, c, index, terms)
    side_b, sign_b = _exact_side(start, end, c, a, index, terms)
    if sign_a != sign_b:
        return 0, side_a, side_b, 0.0
    side_c, sign_c = _exact_side(start, end, a, b, index, terms)
    return (sign_a if sign_a == sign_c else 0), side_a, side_b, side_c


@leaf_kernel
def _exact_side(
    start: Vector, end: Vector, p: Vector, q: Vector, index: LevelIndex, terms: FloatArray
) -> tuple[float, int]:
    """Return det(end − start, p − start, q − start), and its sign, which is not 0."""
    side = orientation(end, p, q, start, terms)
    determinant = side
    if determinant == 0.0:
        # the coefficients of ε; δ, δ², δ³; ε δ, ε δ², ε δ³, of which one is not 0
        centre = vector(index.centre)
        determinant = moved_orientation(end, start, p, q, centre, terms)
        for origin in (start, centre):
            for axis in range(3):
                if determinant == 0.0:
                    determinant = area(p, q, origin, axis, terms)
    return side, (1 if determinant > 0.0 else -1)


@leaf_kernel
def _is_below(point: Vector, index: LevelIndex, face: int, terms: FloatArray) -> bool:
    """Whether a point is on the plane of a face, or on its inner side."""
    relative = minus(point, vector(index.centre))
    height = dot(row(index.planes, face, 9), relative) - index.planes[face, 12]
    # the planes are scaled for points in the box
    size = abs(relative[0]) + abs(relative[1]) + abs(relative[2])
    if abs(height) > 1.0 + size * index.tree.scale:
        return height < 0.0
    return height_of(point, index, face, terms) >= 0.0
