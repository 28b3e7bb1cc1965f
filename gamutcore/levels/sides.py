"""Levels on one side of the full boundary: contained in it, or containing it.

All surfaces are star-shaped about the same centre, so containment is a comparison of radii. A level
keeps its topology and the directions of its vertices; vertex i moves from p to p ÷ u. Let x be a
point of the full boundary in the cone of a face, with x = Σ wᵢ pᵢ. The new level meets the ray of x
at x ÷ Σ wᵢ uᵢ. The level is inside where Σ wᵢ uᵢ ≥ 1 and outside where it is at most 1. Each u in
turn moves towards the limit that the others set. That ends within about a tenth of the optimum of
the linear programme for the volume.

Both surfaces are linear on the pieces of their overlay, so the corners of all pieces decide. The
result is checked after rounding to float32, with a margin above all rounding errors. If vertices of
a very thin body cannot be rounded, the whole level is scaled, and if that fails, a coarser level is
taken.

For limits of the error, the levels have fixed triangle counts. Each is computed when a limit first
needs it, from coarse to fine, and the answer is the first that keeps the limit. A looser limit
therefore never has more triangles, and the bounds that an answer states, asked for as limits, give
the same answer. Both hold in whatever order limits are asked for.
"""

from __future__ import annotations

import threading
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.errors import TriangleCountError
from gamutcore.geometry import TriangleMesh, dot, faces_not_seeing_centre, grouped, row
from gamutcore.history import MINIMUM_TRIANGLES
from gamutcore.kernels import kernel
from gamutcore.levels.error_curve import (
    NO_ERROR,
    BoundedLevel,
    Bounds,
    FullBoundary,
    LevelError,
)
from gamutcore.levels.overlay import (
    MOVES,
    Clipping,
    Cones,
    Distances,
    Locations,
    Surface,
    clipping_workspace,
    compute_cones,
    enclosed_volume,
    make_surface,
    pop_piece,
    push_face,
)

if TYPE_CHECKING:
    from gamutcore.history import History

Side = Literal["both", "inside", "outside"]

SIDES: tuple[Side, ...] = ("both", "inside", "outside")
"""Sides of the full boundary that a level may be on; `both` is the level of the history."""

ROUNDS = (((0.5, 5), (1.0, 3)), ((0.5, 5), (1.0, 20)))
"""Sweeps of the descent: the share of the way that each u moves, and the largest number of sweeps.
Moves of a half lead to better ends, because no vertex takes all the room of its neighbours. Between
the rounds, the level withdraws by its mean depth. The second round ends at a better place: the
mismatch of 1,000 triangles falls by 2 to 18 % (FOGRA39L, Canon)."""

CONVERGED = 1e-6
"""A series of sweeps ends when no u changes by more than this."""

MARGIN = 1e-9
"""Part of the radius by which the level keeps clear of the full boundary. Rounding errors of the
check are below 1e-12. A gamut of 100 units loses 1e-7 units, less than the step of float32."""

REPAIRS = 10
"""Most repairs after rounding. Each moves the vertices around a fault by the depth of the fault and
a step of float32; two or three are usual."""

SCALINGS = 12
"""Most scalings of the whole level after that. The first is by a step of float32 relative to the
least radius, and each by four times as much as the one before."""

COARSER = 4
"""If all of that fails, the next try has this part of the triangles."""

EVEN_UP_TO = 16
"""All levels up to this triangle count are in the curve."""

DENSE, DENSE_UP_TO = 2.0**0.5, 2048
"""Ratio and largest of the following counts; 15 to 150 ms each for 130,000 triangles."""

SPARSE, SPARSE_UP_TO = 2.0, 8192
"""Ratio and largest of the last counts. The finest takes half a second."""

ROW_BYTES = 1000
"""Approximate memory per level of the curve."""


def sided_level(history: History, triangles: int, side: Side) -> TriangleMesh:
    """Return a level that is contained in the full boundary, or contains it.

    Parameters
    ----------
    history : History
    triangles : int
        As for `History.level`.
    side : {'both', 'inside', 'outside'}
        `inside`: every point of the level is within the full boundary. `outside`: every point of
        the full boundary is within the level. `both`: the level of the history.

    Returns
    -------
    TriangleMesh
        float32 positions, with the faces of the level of the history. Star-shaped about the centre
        of the history. Containment holds for the positions as they are. Levels of bodies that are
        not much thicker than the step of float32 may have fewer triangles.

    Raises
    ------
    TriangleCountError
        If there is no such level, or no level on this side: the body is too thin for float32.
    """
    level = history.level(triangles)
    if side == "both" or level.triangles == history.triangles:
        return level
    return _SidedLevels(history, side).level(triangles)


def sided_counts(full: int) -> list[int]:
    """Return the triangle counts of the error curve of one side, even and ascending.

    The curve does not contain the full boundary, whose count is `full`.
    """
    counts = list(range(4, min(EVEN_UP_TO, full), 2))
    count = float(EVEN_UP_TO)
    while count < min(full, SPARSE_UP_TO + 1):
        counts.append(round(count) // 2 * 2)
        count *= DENSE if count < DENSE_UP_TO - 1 else SPARSE
    return counts


class SidedCurve:
    """Error curve of the levels on one side, computed as far as it is needed; threads may share it.

    `triangles` is the count of the full boundary, and `side` is ``inside`` or ``outside``.
    `find_known` and `known_curve` wait for no other thread.
    """

    def __init__(self, triangles: int, side: Side) -> None:
        self._full = triangles
        self._side = side
        self._left = sided_counts(triangles)
        self._errors: list[LevelError] = []
        self._bounds: list[BoundedLevel] = []
        self._curve: list[LevelError] | None = None
        self._lock = threading.Lock()

    @property
    def nbytes(self) -> int:
        """Approximate memory in bytes."""
        return ROW_BYTES * len(self._errors)

    @property
    def known_curve(self) -> list[LevelError] | None:
        """The result of `curve` if it was computed, else None."""
        return self._curve

    def find_known(self, limits: Bounds) -> BoundedLevel | None:
        """Return the result of `find` if it needs no further level, else None."""
        whole = not self._left
        if min(limits) > 0.0:
            for level in self._bounds:
                if level.bounds.within(limits):
                    return level
            if not whole:
                return None
        return BoundedLevel(self._full, NO_ERROR)

    def find(self, history: History, limits: Bounds) -> BoundedLevel:
        """Return the smallest level of the curve within upper limits of its bounds.

        The full boundary is the result if no level is within the limits, as for limits of zero.
        """
        with self._lock:
            level = self.find_known(limits)
            if level is None:
                levels = _SidedLevels(history, self._side)
                while level is None:
                    self._compare_next(levels)
                    level = self.find_known(limits)
            return level

    def curve(self, history: History) -> list[LevelError]:
        """Return the errors of all levels of the curve and of the full boundary, coarse to fine.

        Bounds hold for a level and all finer levels of the curve.
        """
        with self._lock:
            if self._curve is None:
                levels = _SidedLevels(history, self._side)
                while self._left:
                    self._compare_next(levels)
                none, volume = Distances(0.0, 0.0), enclosed_volume(levels.full)
                curve = [LevelError(self._full, volume, 0.0, 0.0, 0.0, none, none)]
                for error in reversed(self._errors):
                    mismatch = max(error.mismatch_bound, curve[-1].mismatch_bound)
                    distance = max(error.distance_bound, curve[-1].distance_bound)
                    curve.append(replace(error, mismatch_bound=mismatch, distance_bound=distance))
                self._curve = curve[::-1]
            return self._curve

    def _compare_next(self, levels: _SidedLevels) -> None:
        """Compute the error of the next level, with bounds for this level only.

        Levels of bodies that are too thin for float32 may be missing or repeated.
        """
        with suppress(TriangleCountError):
            level = levels.level(self._left[0])
            if not self._errors or level.triangles > self._errors[-1].triangles:
                self._errors.append(levels.error(level))
                self._bounds.append(BoundedLevel(level.triangles, self._errors[-1].bounds))
        del self._left[0]


class _SidedLevels(FullBoundary):
    """The levels of a history on one side."""

    def __init__(self, history: History, side: Side) -> None:
        super().__init__(history)
        self._sign = 1.0 if side == "inside" else -1.0

    def level(self, triangles: int) -> TriangleMesh:
        """Return a level, as `sided_level` does; `triangles` is below that of the full boundary."""
        count = self.history.level_triangles(triangles)
        while True:
            level = self._moved_level(count)
            if level is not None:
                return level
            if count == MINIMUM_TRIANGLES:
                raise TriangleCountError(
                    f"There is no level of up to {triangles} triangles on one side: the body is"
                    " too thin for the precision of its coordinates.",
                    where={"field": "side"},
                    remedy="Ask for both sides.",
                )
            count = self.history.level_triangles(max(count // COARSER, MINIMUM_TRIANGLES))

    def error(self, level: TriangleMesh) -> LevelError:
        """Return the error of a level, with bounds for this level only."""
        comparison = self.compare(self.surface(level))
        return LevelError(
            triangles=level.triangles,
            volume=comparison.other_volume,
            mismatch=comparison.mismatch,
            mismatch_bound=comparison.mismatch,
            distance_bound=max(comparison.from_reference.maximum, comparison.to_reference.maximum),
            from_full=comparison.from_reference,
            to_full=comparison.to_reference,
        )

    def _moved_level(self, triangles: int) -> TriangleMesh | None:
        """Return a level moved to the side, or None if it cannot be rounded."""
        level, sign = self.history.level(triangles), self._sign
        surface = self.surface(level)
        position, corner = surface.position, surface.corner
        u = self._inverse_radii(surface)
        scaling = 0.0
        for attempt in range(REPAIRS + SCALINGS):
            rounded = (position / u[:, np.newaxis] + self.centre).astype(np.float32)
            moved = rounded.astype(np.float64) - self.centre
            wrong = np.ones(len(level.faces), np.bool_)
            lowest = highest = np.zeros(len(level.faces))
            if not len(faces_not_seeing_centre(moved, level.faces)):
                lowest, highest = self._extremes(make_surface(moved, corner))
                wrong = lowest < MARGIN if sign > 0 else highest > -MARGIN
                if not wrong.any():
                    return TriangleMesh(rounded, level.faces)
            step = float(np.spacing(np.abs(rounded).max())) / np.linalg.norm(moved, axis=1).min()
            if attempt < REPAIRS:
                lowest = np.where(wrong, np.minimum(lowest, 0.0) - MARGIN - step, 0.0)
                highest = np.where(wrong, np.maximum(highest, 0.0) + MARGIN + step, 0.0)
                u = _moved(u, corner, sign, lowest, highest)
            else:
                scaling = max(4.0 * scaling, step)
                u = u * (1.0 + scaling) ** sign
        return None

    def _inverse_radii(self, surface: Surface) -> FloatArray:
        """Return the inverse radius u of each vertex of a level before rounding."""
        sign, position, corner = self._sign, surface.position, surface.corner
        cones = compute_cones(surface)
        corners, location = self._piece_corners(cones)
        weights = _weights(corners, location, cones, position, corner)
        start, points = grouped(location, len(corner) // 3)
        # every face is moved by its furthest point; then all points are on the side
        extremes = _extremes(corners, location, cones)
        u = _moved(np.ones(len(position)), corner, sign, *extremes)
        for number, sweeps in enumerate(ROUNDS):
            if number > 0:
                u *= 1.0 + (u - 1.0).mean()
            for share, most in sweeps:
                _descend(u, surface, start, points, weights, sign, share, most, CONVERGED)
        return u

    def _extremes(self, surface: Surface) -> tuple[FloatArray, FloatArray]:
        """Return the extremes of N · p − 1 over the full boundary in the cone of each face."""
        cones = compute_cones(surface)
        return _extremes(*self._piece_corners(cones), cones)

    def _piece_corners(self, cones: Cones) -> tuple[FloatArray, IndexArray]:
        """Return the corners of all pieces of the full boundary, and the faces of their cones.

        They are the vertices of the full boundary and the points where its edges cross cones.
        """
        locations = self.locate(cones)
        crossings, through = _crossings(self.full, locations, cones, clipping_workspace(), MOVES)
        corners = np.concatenate([self.full.position, crossings])
        return corners, np.concatenate([locations.face, through])


def _moved(
    u: FloatArray, corner: IndexArray, sign: float, lowest: FloatArray, highest: FloatArray
) -> FloatArray:
    """Return u with all points on the side, from the extremes of Σ w u − 1 in each face's cone."""
    inside = sign > 0
    depth = np.minimum(lowest, 0.0) if inside else np.maximum(highest, 0.0)
    factor = np.ones(len(u))
    (np.maximum if inside else np.minimum).at(factor, corner, np.repeat(1.0 / (1.0 + depth), 3))
    return u * factor


@kernel
def _weights(
    points: FloatArray, location: IndexArray, cones: Cones, position: FloatArray, corner: IndexArray
) -> FloatArray:
    """Return the weights of each point by the corners of the face whose cone it is in."""
    weights = np.empty((len(points), 3))
    for point in range(len(points)):
        face = location[point]
        for place in range(3):
            vertex = corner[3 * face + place]
            plane = row(cones.planes, face, 3 * place)
            height = dot(plane, row(position, vertex, 0))
            weights[point, place] = max(dot(plane, row(points, point, 0)) / height, 0.0)
    return weights


@kernel
def _descend(
    u: FloatArray,
    level: Surface,
    start: IndexArray,
    points: IndexArray,
    weights: FloatArray,
    sign: float,
    share: float,
    sweeps: int,
    converged: float,
) -> None:
    """Relax the inverse radius u of each vertex towards the bound that its one-ring sets.

    `points` has the rows of `weights` in the cone of each face, from `start` on. `share` is the
    part of the way to the bound. The sweeps end when no u changes by more than `converged`.
    """
    corner, fan_start, fan = level.corner, level.fan_start, level.fan
    for _ in range(sweeps):
        largest = 0.0
        for vertex in range(len(u)):
            best = 0.0 if sign > 0.0 else np.inf
            for entry in range(fan_start[vertex], fan_start[vertex + 1]):
                face = fan[entry]
                place = 0
                while corner[3 * face + place] != vertex:
                    place += 1
                one, two = (place + 1) % 3, (place + 2) % 3
                u_one, u_two = u[corner[3 * face + one]], u[corner[3 * face + two]]
                for index in range(start[face], start[face + 1]):
                    point = points[index]
                    weight = weights[point, place]
                    if weight < 1e-6:
                        continue
                    needed = (
                        1.0 - weights[point, one] * u_one - weights[point, two] * u_two
                    ) / weight
                    best = max(best, needed) if sign > 0.0 else min(best, needed)
            if best <= 0.0 or best == np.inf or (best - u[vertex]) * sign >= 0.0:
                continue
            largest = max(largest, abs(best - u[vertex]))
            u[vertex] += share * (best - u[vertex])
        if largest < converged:
            return


@kernel
def _crossings(
    full: Surface, locations: Locations, cones: Cones, work: Clipping, moves: int
) -> tuple[FloatArray, IndexArray]:
    """Return the corners of the pieces of faces in several cones, and the faces of the cones."""
    corner, position, frame = full.corner, full.position, work.frame
    found, location = np.empty((1024, 3)), np.empty(1024, np.int32)
    filled = 0
    for face in range(len(corner) // 3):
        one, two, three = corner[3 * face], corner[3 * face + 1], corner[3 * face + 2]
        through = locations.face[one]
        if through == locations.face[two] and through == locations.face[three]:
            continue
        reach = 0.0
        for vertex in (one, two, three):
            point = row(position, vertex, 0)
            reach = max(reach, np.sqrt(dot(point, point)))
        top = push_face(work, position, one, two, three, through)
        while True:
            through, count, top = pop_piece(work, top, cones, reach, moves)
            if through < 0:
                break
            if filled + count > len(found):
                found = np.concatenate((found, np.empty_like(found)))
                location = np.concatenate((location, np.empty_like(location)))
            for index in range(count):
                u, v = work.piece[index, 0], work.piece[index, 1]
                for axis in range(3):
                    found[filled, axis] = frame[axis] + u * frame[3 + axis] + v * frame[6 + axis]
                location[filled] = through
                filled += 1
    return found[:filled].copy(), location[:filled].copy()


@kernel
def _extremes(
    points: FloatArray, location: IndexArray, cones: Cones
) -> tuple[FloatArray, FloatArray]:
    """Return the extremes of N · p − 1 over the points in the cone of each face of a level."""
    lowest, highest = np.full(len(cones.slope), np.inf), np.full(len(cones.slope), -np.inf)
    for point in range(len(points)):
        face = location[point]
        beyond = dot(row(cones.normal, face, 0), row(points, point, 0)) - 1.0
        lowest[face], highest[face] = min(lowest[face], beyond), max(highest[face], beyond)
    return lowest, highest
