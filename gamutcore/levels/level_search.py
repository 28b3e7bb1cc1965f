"""The way to a level: a request by count or limits, and the search for the level that meets it.

A limit of the distance selects the first of fixed triangle counts whose level is within the limit.
A limit of the mismatch first gives a least count, by bisection; the search begins there. Both
depend on the history and the limit only. So looser limits never give more triangles, and the bounds
that an answer states, asked for as limits, give the same answer. See
``docs/decisions/error-curve.md``. Levels on one side are compared one by one, from coarse to fine
(module `sides`).

Evidence rejects most levels in about a microsecond, so that only few are compared as a whole. A
vertex of the full boundary that is too far from every face of a level rejects the level. It also
rejects the next finer level if it is too far from the faces that the split between them changes. A
face of a level with a point too far from the full boundary rejects all levels with this face.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import inf
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from gamutcore.arguments import finite_number
from gamutcore.arrays import Float32Array, FloatArray, IndexArray
from gamutcore.errors import OptionError
from gamutcore.geometry import Vector, row, scaled
from gamutcore.history import MINIMUM_TRIANGLES, Splits, apply_splits
from gamutcore.kernels import kernel
from gamutcore.levels.error_curve import (
    NO_ERROR,
    BoundedLevel,
    Bounds,
    FullBoundary,
    round_up,
)
from gamutcore.levels.overlay import (
    FROM_LOWER,
    FROM_POINT,
    FROM_UPPER,
    INDEX,
    TO_FACE,
    TO_LOWER,
    TO_POINT,
    TO_UPPER,
    Locations,
    Surface,
    compute_cones,
    halving_limit,
    nearest_face,
    new_bounds,
    squared_distance,
)
from gamutcore.levels.sides import SIDES, Side, SidedCurve

if TYPE_CHECKING:
    from gamutcore.history import History
    from gamutcore.levels.error_curve import LevelError

DEFAULT_TRIANGLES = 1000
"""Triangle count of a request with neither a count nor a limit: 23 kB as GLB, and smooth."""

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

CACHED_LEVELS = 2048
"""Most levels in a search's cache."""

ROW_BYTES = 400
"""Approximate memory per level of a curve or of the cache."""

SAME = 1e-9
"""Points within this distance, relative to that from the full boundary, are the same."""

UNBOUNDED = 1e300
"""A slack with which no distance is improved."""

NO_POINTS, NO_FACES = np.empty((0, 3)), np.empty(0, np.int32)


@dataclass(frozen=True, slots=True)
class LevelRequest:
    """A level by its triangle count or limits of its error, and its side of the full boundary.

    Parameters
    ----------
    triangles : int, optional
        Largest triangle count; `DEFAULT_TRIANGLES` unless a limit is given.
    max_error : float, optional
        Largest distance from the full boundary, in both directions, in units of the space.
    max_mismatch : float, optional
        Largest volume of the symmetric difference ÷ volume of the full boundary.
    side : {'both', 'inside', 'outside'}, optional
        As for `sided_level`.

    Raises
    ------
    OptionError
        A count and a limit are given, a limit is not a number of at least 0, or there is no such
        side. Only a gamut can tell whether it has a level of the count.
    """

    triangles: int | None = None
    max_error: float | None = None
    max_mismatch: float | None = None
    side: Side = "both"

    def __post_init__(self) -> None:
        if self.side not in SIDES:
            raise OptionError.refusal("side", self.side, f"one of {', '.join(SIDES)}")
        for name, limit in (("max_error", self.max_error), ("max_mismatch", self.max_mismatch)):
            if limit is not None:
                number = finite_number(limit)
                if number is None or number < 0.0:
                    raise OptionError.refusal(name, limit, "a number of at least 0")
        if self.triangles is not None and self.limits is not None:
            raise OptionError.not_applicable(
                "triangles", self.triangles, "a limit of the error is given", "Give one of them."
            )

    @property
    def limits(self) -> Bounds | None:
        """The limits of the error; None if there are none."""
        if self.max_error is None and self.max_mismatch is None:
            return None
        return Bounds(
            inf if self.max_error is None else self.max_error,
            inf if self.max_mismatch is None else self.max_mismatch,
        )

    def count(self, full: int) -> int:
        """Return the requested triangle count for a full boundary of `full` triangles."""
        return min(DEFAULT_TRIANGLES, full) if self.triangles is None else self.triangles

    def or_default(
        self, triangles: int | None = None, max_error: float | None = None
    ) -> LevelRequest:
        """Return the request, or one for a default level if it has neither a count nor a limit."""
        if self.triangles is not None or self.limits is not None:
            return self
        return LevelRequest(triangles, max_error, side=self.side)


class LevelSearch:
    """The levels of one gamut that meet requests, with a cache; any thread may use it.

    `curve` is the error curve from a description (`levels`), with the full boundary as last level.
    Curves of old descriptions have no bounds. The same limits then hold, but may take more
    triangles. A search keeps no history, so that it can outlive the history in memory.
    """

    def __init__(self, curve: Sequence[Mapping[str, Any]]) -> None:
        self._curve = [
            BoundedLevel(
                int(row["triangles"]),
                Bounds(
                    float(row.get("distance_bound", inf)), float(row.get("mismatch_bound", inf))
                ),
            )
            for row in curve[:-1]
        ]
        self._curve.append(BoundedLevel(int(curve[-1]["triangles"]), NO_ERROR))
        full = self._curve[-1].triangles
        self._sides: dict[Side, SidedCurve] = {
            side: SidedCurve(full, side) for side in SIDES if side != "both"
        }
        # results of searches by request; compared levels by the request of their count
        self._cache: dict[LevelRequest, BoundedLevel] = {}

    @property
    def nbytes(self) -> int:
        """Approximate memory in bytes."""
        sides = sum(curve.nbytes for curve in self._sides.values())
        return ROW_BYTES * (1 + len(self._curve) + len(self._cache)) + sides

    def bounds(self, triangles: int) -> Bounds:
        """Return the bounds of a level in the error curve; infinite for all other levels."""
        return next(
            (level.bounds for level in self._curve if level.triangles == triangles), Bounds()
        )

    def largest_count(self, request: LevelRequest) -> int:
        """Return a count that the result of `find` does not exceed, without a search.

        A requested count is returned unchanged, even if there is no such level.
        """
        full = self._curve[-1].triangles
        if request.limits is None:
            return request.count(full)
        known = self.find_known(request)
        if known is not None:
            return known.triangles
        return self._find_bound(request.limits).triangles if request.side == "both" else full

    def find_known(self, request: LevelRequest) -> BoundedLevel | None:
        """Return the result of `find` without a search; None if it needs one or does not exist."""
        limits = request.limits
        if limits is None:
            full = self._curve[-1].triangles
            count = request.count(full)
            return (
                self._level_at(count, request.side) if MINIMUM_TRIANGLES <= count <= full else None
            )
        if request in self._cache:
            return self._cache[request]
        if request.side != "both":
            return self._sides[request.side].find_known(limits)
        level = self._find_bound(limits)
        is_first = level.triangles == self._curve[0].triangles
        return level if is_first or min(limits) <= 0.0 else None

    def find(self, history: History, request: LevelRequest) -> BoundedLevel:
        """Return the level of a request, from the history of the search's gamut.

        For limits, it is the smallest level of fixed triangle counts that keeps them, with its
        bounds. The full boundary is the result if no other level is within the limits, as for
        limits of zero. For a count, bounds are known if the level is in the error curve.

        Raises
        ------
        TriangleCountError
            There is no level of the count.
        HistoryFileError
            The history file is damaged.
        """
        if request.limits is None:
            return self._level_at(
                history.level_triangles(request.count(history.triangles)), request.side
            )
        level = self.find_known(request)
        if level is None:
            if request.side == "both":
                level = self._search(history, request.limits)
            else:
                level = self._sides[request.side].find(history, request.limits)
            self._remember(request, level)
        return level

    def find_error_bound(self, triangles: int) -> float | None:
        """Return the result of `error_bound` if it needs no comparison; else None."""
        compared = self._cache.get(LevelRequest(triangles))
        bounds = self.bounds(triangles) if compared is None else compared.bounds
        return bounds.distance if bounds.distance < inf else None

    def error_bound(self, history: History, triangles: int) -> float:
        """Return an upper bound of the distance between an existing level and the full boundary.

        The first call for a level outside the error curve compares the level with the full
        boundary, which takes up to 0.1 s.
        """
        known = self.find_error_bound(triangles)
        if known is None:
            (level,) = error_bounds(history, [triangles])
            self._remember(LevelRequest(triangles), level)
            known = level.bounds.distance
        return known

    def known_curve(self, side: Side) -> list[LevelError] | None:
        """Return the result of `curve` if it was computed, else None."""
        return self._sides[side].known_curve

    def curve(self, history: History, side: Side) -> list[LevelError]:
        """Return the error curve of one side, `inside` or `outside`, and of the full boundary.

        Bounds hold for a level and all finer levels of the curve. A damaged history file raises
        HistoryFileError.
        """
        return self._sides[side].curve(history)

    def _level_at(self, triangles: int, side: Side) -> BoundedLevel:
        count = triangles // 2 * 2  # closed meshes have even counts
        return BoundedLevel(count, self.bounds(count) if side == "both" else Bounds())

    def _remember(self, request: LevelRequest, level: BoundedLevel) -> None:
        if len(self._cache) >= CACHED_LEVELS:
            self._cache = {}
        self._cache[request] = level

    def _find_bound(self, limits: Bounds) -> BoundedLevel:
        """Return the smallest level of the error curve within limits; `find` has no larger one."""
        within = (level for level in self._curve if level.bounds.within(limits))
        return next(within, self._curve[-1])

    def _search(self, history: History, limits: Bounds) -> BoundedLevel:
        most = self._find_bound(limits)
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
        bounded_level = _first_within(comparison, counts, limits, similar[-1:])
        if bounded_level is None:
            return most
        if limits.mismatch == inf:
            coarser = (level for level in self._curve if level.triangles <= bounded_level.triangles)
            mismatch = min(level.bounds.mismatch for level in coarser)
        # the stated mismatch is at least the one at which the search began: as a limit, it gives
        # this level again
        if mismatch < inf:
            mismatch = max(mismatch, bounded_level.bounds.mismatch)
            bounded_level = bounded_level._replace(
                bounds=bounded_level.bounds._replace(mismatch=mismatch)
            )
        return bounded_level

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


class _Comparison(FullBoundary):
    """Compares levels of a history by their counts."""

    def evidence(self, triangles: int, limit: float) -> _Evidence:
        """Return evidence from vertices that a level exceeds a limit of the distance, if any.

        It has up to one point for each face of the level, and faces with a point that is too far.
        """
        level = self.surface(self.history.level(triangles))
        locations = self.locate(compute_cones(level))
        points, faces = _find_evidence(self.full, level, locations, limit)
        return _Evidence(self.full.position[points], faces)

    def bounds(self, triangles: int, limit: float) -> tuple[Bounds, _Evidence]:
        """Return the error of a level, and evidence if its distance exceeds a limit."""
        level = self.surface(self.history.level(triangles))
        distances = new_bounds(halving_limit(self.full, HALVINGS), SLACK)
        difference = self.compare(level, distances)
        point, faces = NO_POINTS, NO_FACES
        if distances[FROM_LOWER] > limit:
            point = distances[np.newaxis, FROM_POINT : FROM_POINT + 3].copy()
        if distances[TO_LOWER] > limit:
            # at a corner it is also on the other faces there
            corners = level.corner.reshape(-1, 3)
            away = level.position - distances[TO_POINT : TO_POINT + 3]
            is_there = np.linalg.norm(away, axis=1) <= SAME * distances[TO_LOWER]
            beyond = is_there[corners].any(axis=1)
            beyond[int(distances[TO_FACE])] = True
            faces = np.flatnonzero(beyond).astype(np.int32)
        distance = round_up(max(distances[FROM_UPPER], distances[TO_UPPER]))
        return Bounds(distance, round_up(difference.mismatch)), _Evidence(point, faces)

    def mismatch(self, triangles: int) -> float:
        """Return the mismatch of a level, without bounds of distances, which take half the time."""
        level = self.surface(self.history.level(triangles))
        return round_up(self.compare(level, new_bounds(0.0, UNBOUNDED)).mismatch)


def _first_within(
    comparison: _Comparison, counts: list[int], limits: Bounds, similar: list[int]
) -> BoundedLevel | None:
    """Return the first level within limits, by ascending counts.

    `similar` has at most one level, whose distance is about the limit.
    """
    limit = limits.distance
    walk = _LevelWalk(comparison.history, np.array(counts, np.int32))
    for triangles in similar:
        walk.skip(comparison.evidence(triangles, limit)._replace(faces=NO_FACES), limit)
    while walk.index < len(counts):
        index, triangles = walk.index, counts[walk.index]
        walk.skip(comparison.evidence(triangles, limit), limit)
        if walk.index == index:
            bounds, evidence = comparison.bounds(triangles, limit)
            if bounds.within(limits):
                return BoundedLevel(triangles, bounds)
            walk.skip(evidence, limit)
        if walk.index == index:
            walk.skip(_Evidence(NO_POINTS, NO_FACES), limit, stop=True)
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
        point = row(full.position, vertex, 0)
        _, squared = nearest_face(point, level, face)
        is_far[face] = np.sqrt(squared) > limit
        if not is_far[face]:
            t = 1.0 / (1.0 + locations.beyond[vertex])
            start = full.fan[INDEX(full.fan_start[vertex + 1] - 1)]
            _, squared = nearest_face(scaled(t, point), full, start)
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
        self._splits = history.splits
        self._positions = np.zeros((vertices, 3), np.float32)
        self._positions[: len(level.vertices)] = level.vertices
        corner = np.empty(6 * vertices - 12, np.int32)
        corner[: 3 * level.triangles] = level.faces.ravel()
        none = np.empty(0, np.int32)
        self._surface = Surface(self._positions - self._centre, corner, none, none, np.empty(0))
        self.index = 0

    def skip(self, evidence: _Evidence, limit: float, *, stop: bool = False) -> None:
        """Go to the first level, from the present one on, that evidence does not reject.

        `index` becomes its index in `counts`, or their number if all are rejected. The evidence has
        faces of the present level, and `limit` is the largest accepted distance. With `stop`, go
        to the next level.
        """
        self.index = _skip_levels(
            self._counts, self.index, self._positions, self._surface, self._centre,
            evidence, limit, stop, self._splits,
        )  # fmt: skip


@kernel
def _skip_levels(  # noqa: C901, PLR0912  # one pass, so that nothing is copied
    counts: IndexArray,
    index: int,
    positions: Float32Array,
    level: Surface,
    centre: FloatArray,
    evidence: _Evidence,
    limit: float,
    stop: bool,
    splits: Splits,
) -> int:
    """Return the index of the first level that is not rejected; `level` becomes that level.

    With `stop`, return the index of the next level.
    """
    position, corner = level.position, level.corner
    points, faces = evidence
    shifted_end, shifted = splits.shifted_end, splits.shifted
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
                is_far = _is_far(row(points, point, 0), level, present, limit)
                point += 0 if is_far else 1
            if not is_far:
                return index
        index += 1
        if index == len(counts):
            return index
        start, end = present // 2 + 2, counts[index] // 2 + 2
        apply_splits(
            positions, corner, start, end, splits.parent, splits.fine, splits.added, splits.faces,
            splits.moved_end, splits.moved, shifted_end, shifted, splits.shifted_fine,
        )  # fmt: skip
        for split in range(start - 4, end - 4):
            changed[splits.parent[split]], changed[split + 4] = 1, 1
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
                    squared = squared_distance(row(points, point, 0), level, face)
                    is_far = np.sqrt(squared) > limit
        changed[:end] = 0
        if stop:
            return index


@kernel
def _is_far(point: Vector, level: Surface, faces: int, limit: float) -> bool:
    """Whether a point is further than the limit from all of the first `faces` faces."""
    for face in range(faces):
        squared = squared_distance(point, level, face)
        if np.sqrt(squared) <= limit:
            return False
    return True
