"""The smallest level of a history whose error is within limits.

A limit of the distance selects the first of fixed triangle counts whose level is within the limit.
A limit of the mismatch first gives a least count, by bisection; the search begins there. Both
depend on the history and the limit only. So looser limits never give more triangles, and no answer
promises what a smaller answer promises as well. See ``docs/decisions/error-curve.md``.

Evidence rejects most levels in about a microsecond, so that only few are compared as a whole. A
vertex of the full boundary that is too far from every face of a level rejects the level. It also
rejects the next finer level if it is too far from the faces that the split between them changes. A
face of a level with a point too far from the full boundary rejects all levels with this face.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from math import inf
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from gamutcore.arrays import Float32Array, FloatArray, IndexArray
from gamutcore.history import apply_splits, fine_columns
from gamutcore.kernels import kernel
from gamutcore.levels.cones import INDEX, Locations, Surface, compute_cones, locate, make_surface
from gamutcore.levels.distances import (
    FROM_LOWER,
    FROM_POINT,
    FROM_UPPER,
    TO_FACE,
    TO_LOWER,
    TO_POINT,
    TO_UPPER,
    halving_limit,
    nearest_face,
    new_bounds,
    squared_distance,
)
from gamutcore.levels.error_curve import round_up, surface_in_preorder
from gamutcore.levels.overlay import compare_surfaces

if TYPE_CHECKING:
    from gamutcore.history import History

EVEN_UP_TO = 2048
"""All levels up to this triangle count are considered. The distance stays nearly constant over long
ranges of counts and then falls by half within one split."""

RATIO = 2.0 ** (1 / 8)
"""Ratio of the following counts, and of the counts among which a mismatch is bisected. The mismatch
falls steadily, so the answer exceeds the triangles needed by at most this factor."""

FINE_UP_TO = 65_536
"""Largest count with this ratio."""

SPARSE = 2.0
"""Ratio of the last counts."""

SLACK = 1.00002
"""Ratio of a bound to an attained distance. With more slack, far fewer triangles than promised
would keep a limit just above the attained distance."""

HALVINGS = 100_000.0
"""Halvings of a level in addition to a quarter of the faces. Levels of ellipsoids 60 times as
wide as high take up to 53,000 (0.1 s); 600 times as wide, up to 130,000 (0.6 s)."""

SIMILAR = 1.2
"""Evidence comes first from a level of the curve whose bound is this many times the limit. Bounds
of the curve are 8 % too large on average."""

KEPT = 256
"""Most levels in a search's cache."""

ROW_BYTES = 200
"""Approximate memory per level of a curve."""

SAME = 1e-9
"""Points within this distance, relative to that from the full boundary, are the same."""

UNBOUNDED = 1e300
"""A slack with which no distance is improved."""

NO_POINTS, NO_FACES = np.empty((0, 3)), np.empty(0, np.int32)


class Bounds(NamedTuple):
    """Upper bounds of the error of a level, or limits for it.

    Attributes
    ----------
    distance : float
        Distance of any point of either surface from the other (units of the space).
    mismatch : float
        Volume of the symmetric difference ÷ volume of the full boundary.
    """

    distance: float = inf
    mismatch: float = inf

    def within(self, limits: Bounds) -> bool:
        """Whether both bounds are at most the limits."""
        return self.distance <= limits.distance and self.mismatch <= limits.mismatch


NO_ERROR = Bounds(0.0, 0.0)
"""Bounds of the full boundary."""


class BoundedLevel(NamedTuple):
    """A level and the bounds of its error.

    Attributes
    ----------
    triangles : int
    bounds : Bounds
        Bounds of this level only; a finer level may have larger errors.
    """

    triangles: int
    bounds: Bounds


class LevelSearch:
    """Search for levels within limits, with a cache of the results; any thread may use it.

    `curve` is the error curve from a description (`levels`), with the full boundary as last level.
    Curves of old descriptions have no bounds. The same limits then hold, but may take more
    triangles.
    """

    def __init__(self, curve: Sequence[Mapping[str, Any]]) -> None:
        bounds = [
            Bounds(row.get("distance_bound", inf), row.get("mismatch_bound", inf)) for row in curve
        ]
        self._curve = [
            BoundedLevel(row["triangles"], bound)
            for row, bound in zip(curve[:-1], bounds, strict=False)
        ]
        self._curve.append(BoundedLevel(curve[-1]["triangles"], NO_ERROR))
        self._found: dict[Bounds, BoundedLevel] = {}

    @property
    def nbytes(self) -> int:
        """Approximate memory in bytes."""
        return ROW_BYTES * (1 + len(self._curve) + len(self._found))

    def find_bound(self, limits: Bounds) -> BoundedLevel:
        """Return the smallest level of the error curve within limits; `find` has no larger one."""
        within = (level for level in self._curve if level.bounds.within(limits))
        return next(within, self._curve[-1])

    def find_known(self, limits: Bounds) -> BoundedLevel | None:
        """Return the result of `find` if it is cached or needs no comparison, else None."""
        if limits in self._found:
            return self._found[limits]
        level = self.find_bound(limits)
        is_first = level.triangles == self._curve[0].triangles
        return level if is_first or min(limits) <= 0.0 else None

    def find(self, history: History, limits: Bounds) -> BoundedLevel:
        """Return the smallest level of the curve's history within upper limits of its bounds.

        The result is one of `search_counts`, or a smaller level of the curve. The full boundary is
        the result if no other level is within the limits, as for limits of zero. A damaged history
        file raises HistoryFileError.
        """
        level = self.find_known(limits)
        if level is not None:
            return level
        level = self._search(history, limits)
        if len(self._found) == KEPT:
            self._found = {}
        self._found[limits] = level
        return level

    def _search(self, history: History, limits: Bounds) -> BoundedLevel:
        most = self.find_bound(limits)
        comparison = _Comparison(history)
        least, mismatch = self._least_count(comparison, limits.mismatch)
        counts = [
            count
            for count in search_counts(self._curve[-1].triangles)
            if least <= count < most.triangles
        ]
        if not counts:
            return most
        similar = [
            level.triangles
            for level in self._curve
            if counts[0] < level.triangles < most.triangles
            and level.bounds.distance > SIMILAR * limits.distance
        ]
        found = _first_within(comparison, counts, limits, similar[-1:])
        if found is None:
            return most
        if limits.mismatch == inf:
            coarser = (level for level in self._curve if level.triangles <= found.triangles)
            mismatch = min(level.bounds.mismatch for level in coarser)
        # a level is found for the mismatch that it promises
        if mismatch < inf:
            mismatch = max(mismatch, found.bounds.mismatch)
            found = found._replace(bounds=found.bounds._replace(mismatch=mismatch))
        return found

    def _least_count(self, comparison: _Comparison, mismatch: float) -> tuple[int, float]:
        """Return the least triangle count to consider for a limit of the mismatch, and its bound.

        The counts between two levels of the curve are bisected in a fixed order, so a looser limit
        never gives a larger count.
        """
        above = next(
            index for index, level in enumerate(self._curve) if level.bounds.mismatch <= mismatch
        )
        triangles, (_, bound) = self._curve[above]
        if above > 0:
            # bounds of the curve are a little too large: the level before may be within the limit
            before = self._curve[above - 1].triangles
            exact = comparison.mismatch(before)
            if exact <= mismatch:
                above, triangles, bound = above - 1, before, exact
        if above == 0:
            return triangles, bound
        low, high = self._curve[above - 1].triangles, triangles
        counts = [
            count for count in _spread_counts(self._curve[-1].triangles) if low < count < high
        ]
        while counts:
            middle = len(counts) // 2
            exact = comparison.mismatch(counts[middle])
            if exact <= mismatch:
                triangles, bound, counts = counts[middle], exact, counts[:middle]
            else:
                counts = counts[middle + 1 :]
        return triangles, bound


def search_counts(full: int) -> list[int]:
    """Return the triangle counts that a search considers: even, ascending, below the full count."""
    counts = list(range(4, min(EVEN_UP_TO + 1, full), 2))
    return counts + [count for count in _spread_counts(full) if count > EVEN_UP_TO]


def _spread_counts(full: int) -> list[int]:
    """Return the counts of `search_counts` among which a mismatch is bisected."""
    counts, count = set(), 4.0
    while count < full:
        counts.add(int(count) // 2 * 2)
        count *= RATIO if count < FINE_UP_TO else SPARSE
    return sorted(counts)


def error_bounds(history: History, counts: Iterable[int]) -> list[BoundedLevel]:
    """Return the errors of levels below the full boundary, each compared with it as a whole.

    The results are in the order of `counts`. A comparison takes 15 to 60 ms.
    """
    comparison = _Comparison(history)
    return [BoundedLevel(count, comparison.bounds(count, inf)[0]) for count in counts]


class _Evidence(NamedTuple):
    """Evidence that rejects a level and some finer ones."""

    # (k, 3) points of the full boundary, relative to the centre: each rejects the levels without a
    # face within the limit
    points: FloatArray
    faces: IndexArray  # (m,) faces of the level: each rejects the levels that have the face


class _Comparison:
    """Compares levels of a history with its full boundary; unpacks the whole history."""

    def __init__(self, history: History) -> None:
        self.history = history
        self._full, self._near = surface_in_preorder(history.full(), history)
        self._order = np.arange(len(self._near), dtype=np.int32)
        self._centre = np.asarray(history.centre, np.float64)

    def evidence(self, triangles: int, limit: float) -> _Evidence | None:
        """Return evidence from vertices that a level exceeds a limit of the distance, or None.

        It has up to one point for each face of the level, and faces with a point that is too far.
        """
        level = self._surface(triangles)
        locations = locate(self._full.position, self._order, self._near, compute_cones(level))
        points, faces = _find_evidence(self._full, level, locations, limit)
        if len(points) == len(faces) == 0:
            return None
        return _Evidence(self._full.position[points], faces)

    def bounds(self, triangles: int, limit: float) -> tuple[Bounds, _Evidence]:
        """Return the error of a level, and evidence if its distance exceeds a limit."""
        level = self._surface(triangles)
        found = new_bounds(halving_limit(self._full, HALVINGS), SLACK)
        difference, _ = compare_surfaces(self._full, level, self._order, self._near, bounds=found)
        point, faces = NO_POINTS, NO_FACES
        if found[FROM_LOWER] > limit:
            point = found[np.newaxis, FROM_POINT : FROM_POINT + 3].copy()
        if found[TO_LOWER] > limit:
            # at a corner it is also on the other faces there
            corners = level.corner.reshape(-1, 3)
            away = level.position - found[TO_POINT : TO_POINT + 3]
            is_there = np.linalg.norm(away, axis=1) <= SAME * found[TO_LOWER]
            beyond = is_there[corners].any(axis=1)
            beyond[int(found[TO_FACE])] = True
            faces = np.flatnonzero(beyond).astype(np.int32)
        distance = round_up(max(found[FROM_UPPER], found[TO_UPPER]))
        return Bounds(distance, round_up(difference.mismatch)), _Evidence(point, faces)

    def mismatch(self, triangles: int) -> float:
        """Return the mismatch of a level, without bounds of distances, which take half the time."""
        found, _ = compare_surfaces(
            self._full,
            self._surface(triangles),
            self._order,
            self._near,
            bounds=new_bounds(0.0, UNBOUNDED),
        )
        return round_up(found.mismatch)

    def _surface(self, triangles: int) -> Surface:
        level = self.history.level(triangles)
        position = np.ascontiguousarray(level.vertices.astype(np.float64) - self._centre)
        return make_surface(position, np.ascontiguousarray(level.faces, np.int32).ravel())


def _first_within(
    comparison: _Comparison, counts: list[int], limits: Bounds, similar: list[int]
) -> BoundedLevel | None:
    """Return the first level within limits, by ascending counts.

    `similar` has at most one level, whose distance is about the limit.
    """
    limit = limits.distance
    walk = _LevelWalk(comparison.history, np.array(counts, np.int32))
    for triangles in similar:
        ahead = comparison.evidence(triangles, limit)
        if ahead is not None:
            walk.skip(ahead._replace(faces=NO_FACES), limit)
    while walk.index < len(counts):
        index, triangles = walk.index, counts[walk.index]
        evidence = comparison.evidence(triangles, limit)
        if evidence is not None:
            walk.skip(evidence, limit)
        if walk.index == index:
            bounds, evidence = comparison.bounds(triangles, limit)
            if bounds.within(limits):
                return BoundedLevel(triangles, bounds)
            walk.skip(evidence, limit)
        if walk.index == index:
            walk.advance()
    return None


@kernel
def _find_evidence(
    full: Surface, level: Surface, locations: Locations, limit: float
) -> tuple[IndexArray, IndexArray]:
    """Return vertices of the full boundary and faces of the level that are evidence.

    `locations` has the vertices in the cones of the level. Each face examines only its furthest
    vertex along the ray.
    """
    faces = len(level.corner) // 3
    furthest = np.full(faces, -1, np.int32)
    for vertex in range(len(full.position)):
        face = locations.face[INDEX(vertex)]
        before = furthest[INDEX(face)]
        if before < 0 or locations.along[INDEX(vertex)] > locations.along[INDEX(before)]:
            furthest[INDEX(face)] = vertex
    is_far, is_beyond = np.zeros(faces, np.uint8), np.zeros(faces, np.uint8)
    for face in range(faces):
        vertex = furthest[face]
        if vertex < 0 or locations.along[vertex] <= limit:
            continue
        x, y, z = full.position[vertex, 0], full.position[vertex, 1], full.position[vertex, 2]
        _, squared = nearest_face(x, y, z, level, face)
        is_far[face] = np.sqrt(squared) > limit
        if not is_far[face]:
            t = 1.0 / (1.0 + locations.beyond[vertex])
            start = full.fan[INDEX(full.fan_end[vertex] - 1)]
            _, squared = nearest_face(t * x, t * y, t * z, full, start)
            is_beyond[face] = np.sqrt(squared) > limit
    return furthest[is_far != 0], np.nonzero(is_beyond)[0].astype(np.int32)


class _LevelWalk:
    """A walk through levels from coarse to fine, past those that evidence rejects.

    `counts` (n,) are the ascending triangle counts of the levels.
    """

    def __init__(self, history: History, counts: IndexArray) -> None:
        level = history.level(int(counts[0]))
        vertices = int(counts[-1]) // 2 + 2
        self._counts = counts
        self._centre = np.asarray(history.centre, np.float64)
        self._columns = fine_columns(history.splits)
        self._positions = np.zeros((vertices, 3), np.float32)
        self._positions[: len(level.vertices)] = level.vertices
        corner = np.empty(6 * vertices - 12, np.int32)
        corner[: 3 * level.triangles] = level.faces.ravel()
        none = np.empty(0, np.int32)
        self._surface = Surface(self._positions - self._centre, corner, none, none, np.empty(0))
        self.index = 0

    def skip(self, evidence: _Evidence, limit: float) -> None:
        """Go to the first level, from the present one on, that evidence does not reject.

        `index` becomes its index in `counts`, or their number if all are rejected. The evidence has
        faces of the present level, and `limit` is the largest accepted distance.
        """
        self._walk(evidence, limit, stop=False)

    def advance(self) -> None:
        """Go to the next level."""
        self._walk(_Evidence(np.empty((0, 3)), np.empty(0, np.int32)), 0.0, stop=True)

    def _walk(self, evidence: _Evidence, limit: float, *, stop: bool) -> None:
        self.index = _walk(
            self._counts, self.index, self._positions, self._surface, self._centre,
            *evidence, limit, stop, *self._columns,
        )  # fmt: skip


@kernel
def _walk(  # noqa: C901, PLR0912  # one pass, so that nothing is copied
    counts: IndexArray,
    index: int,
    positions: Float32Array,
    level: Surface,
    centre: FloatArray,
    points: FloatArray,
    faces: IndexArray,
    limit: float,
    stop: bool,
    parent: IndexArray,
    fine: Float32Array,
    added: Float32Array,
    split_faces: IndexArray,
    moved_end: IndexArray,
    moved: IndexArray,
    shifted_end: IndexArray,
    shifted: IndexArray,
    shifted_fine: Float32Array,
) -> int:
    """Return the index of the first level that is not rejected; `level` becomes that level.

    With `stop`, return the index of the next level.
    """
    position, corner = level.position, level.corner
    kept = np.zeros(len(corner) // 3, np.uint8)
    for face in faces:
        kept[face] = 1
    left = len(faces)
    changed = np.zeros(len(position), np.uint8)
    # the next point, and whether it is known to be too far from the present level
    point, is_far = 0, False
    while True:
        present = counts[index]
        if left == 0 and not stop:
            while not is_far and point < len(points):
                is_far = _is_far(points[point], level, present, limit)
                point += 0 if is_far else 1
            if not is_far:
                return index
        index += 1
        if index == len(counts):
            return index
        start, end = present // 2 + 2, counts[index] // 2 + 2
        apply_splits(
            positions, corner, start, end, parent, fine, added, split_faces,
            moved_end, moved, shifted_end, shifted, shifted_fine,
        )  # fmt: skip
        for split in range(start - 4, end - 4):
            changed[parent[split]], changed[split + 4] = 1, 1
            for entry in range(shifted_end[split - 1] if split > 0 else 0, shifted_end[split]):
                changed[shifted[entry]] = 1
        for vertex in range(end):
            if changed[INDEX(vertex)] != 0:
                for axis in range(3):
                    position[vertex, axis] = np.float64(positions[vertex, axis]) - centre[axis]
        for face in range(counts[index]):
            at = INDEX(3 * face)
            one, two, three = corner[at], corner[at + INDEX(1)], corner[at + INDEX(2)]
            if changed[INDEX(one)] | changed[INDEX(two)] | changed[INDEX(three)]:
                left -= kept[face]
                kept[face] = 0
                if is_far:
                    x, y, z = points[point, 0], points[point, 1], points[point, 2]
                    is_far = np.sqrt(squared_distance(x, y, z, level, face)) > limit
        changed[:end] = 0
        if stop:
            return index


@kernel
def _is_far(point: FloatArray, level: Surface, faces: int, limit: float) -> bool:
    """Whether a point is further than the limit from all of the first `faces` faces."""
    for face in range(faces):
        if np.sqrt(squared_distance(point[0], point[1], point[2], level, face)) <= limit:
            return False
    return True
