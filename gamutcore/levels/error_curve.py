"""Errors of the levels of a history against its full boundary, with certain bounds.

All levels are star-shaped about one centre, so two levels are compared exactly (module `overlay`).
A coarse level is not compared with the full boundary but with a reference: a level about 16 times
finer. The triangle inequality holds for volumes of symmetric differences and for distances, so the
error of the reference is added. For volumes the addition is about a sixteenth; for distances it is
the deviation of each face. The times of all comparisons form a geometric series.
"""

from __future__ import annotations

from dataclasses import dataclass
from decimal import ROUND_CEILING, Context, Decimal
from math import inf
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from gamutcore.kernels import kernel
from gamutcore.levels.overlay import (
    Distances,
    compare_surfaces,
    enclosed_volume,
    locate,
    make_surface,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from gamutcore.arrays import Float32Array, FloatArray, IndexArray
    from gamutcore.geometry import TriangleMesh
    from gamutcore.history import History
    from gamutcore.levels.overlay import Cones, Locations, RadialDifference, Surface

EVEN_UP_TO = 16
"""All levels up to this triangle count are in the curve."""

DENSE = 2.0**0.5
"""Ratio of the following counts, up to full count ÷ `DENSE_PART`. Levels in between are compared
when a limit needs them (module `level_search`)."""

SPARSE = ((2_000, DENSE, 2), (20_000, 2.0, 4), (2**62, 4.0, 16))
"""Counts above full count ÷ `DENSE_PART`. Each row: largest full count that the row applies to,
ratio of the counts, full count ÷ finest of these counts. The two finest levels are compared with
the full boundary; each takes up to a tenth of the time of the decimation. A finest level of an
eighth would give slightly tighter bounds, but the curve would take a third longer."""

DENSE_PART = 128
"""The dense part of the curve ends at full count ÷ this number."""

FINER = 16
"""Wanted ratio of the counts of a reference and its level. With 10 the curve takes a twentieth less
time, and the mismatch of levels by `quadric`, which lose volume, is 4 % too small."""

FINER_AT_LEAST = 8
"""Least ratio at which the finest level of the curve serves as reference."""

DIGITS = 6
"""Significant digits of errors in a description. Bounds are rounded up."""


class Bounds(NamedTuple):
    """Upper bounds of the error of a level, or limits for it; infinite where there is none.

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
        Bounds of this level only; a finer level may have larger errors. Infinite if not known.
    """

    triangles: int
    bounds: Bounds = Bounds()


@dataclass(frozen=True)
class LevelError:
    """Error of a level against the full boundary.

    Attributes
    ----------
    triangles : int
    volume : float
        Enclosed volume, exact (cubic units of the space).
    mismatch : float
        Volume of the symmetric difference ÷ volume of the full boundary. An estimate from the
        level's reference, within 3 % on device gamuts. It is at least the relative difference of
        the volumes and at most `mismatch_bound`.
    mismatch_bound : float
        Upper bound of the mismatch of this level and of every finer level in the curve.
    distance_bound : float
        Upper bound of the distance of any point of either surface from the other (units of the
        space). It holds for this level and every finer level in the curve.
    from_full : Distances
        Distances of the points of the full boundary from the level. The maximum is a bound. The
        mean is an estimate over the reference, and at most the maximum.
    to_full : Distances
        Distances of the points of the level from the full boundary, likewise.
    """

    triangles: int
    volume: float
    mismatch: float
    mismatch_bound: float
    distance_bound: float
    from_full: Distances
    to_full: Distances

    @property
    def bounds(self) -> Bounds:
        """Both bounds, rounded up as in a description."""
        return Bounds(round_up(self.distance_bound), round_up(self.mismatch_bound))

    def to_mapping(self) -> dict[str, Any]:
        """Return the errors for a description: few digits, bounds rounded up."""
        return {
            "triangles": self.triangles,
            "volume": float(f"{self.volume:.10g}"),
            "mismatch": _rounded(self.mismatch),
            "mismatch_bound": round_up(self.mismatch_bound),
            "distance_bound": round_up(self.distance_bound),
            "from_full": _described(self.from_full),
            "to_full": _described(self.to_full),
        }


def round_up(bound: float) -> float:
    """Return a bound rounded up to `DIGITS` significant digits."""
    return float(Context(DIGITS, ROUND_CEILING).create_decimal(Decimal(bound)))


def _rounded(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")


def _described(distances: Distances) -> dict[str, float]:
    return {"mean": _rounded(distances.mean), "maximum": round_up(distances.maximum)}


def curve_counts(full: int) -> list[int]:
    """Return the triangle counts of the error curve: even, ascending, from 4 to the full count."""
    counts = {*range(4, min(EVEN_UP_TO, full) + 1, 2), full}
    count = EVEN_UP_TO * DENSE
    while count <= full / DENSE_PART:
        counts.add(_even(count))
        count *= DENSE
    _, ratio, part = next(row for row in SPARSE if full <= row[0])
    count = full / part
    while count >= max(full / DENSE_PART, EVEN_UP_TO):
        counts.add(_even(count))
        count /= ratio
    return sorted(counts)


def _even(count: float) -> int:
    return int(count) // 2 * 2


def error_curve(
    history: History, counts: Iterable[int], *, progress: Callable[[float], None] | None = None
) -> list[LevelError]:
    """Compute the errors of several levels against the full boundary, by ascending triangle count.

    Bounds of a level also hold for the finer levels among `counts`, and the levels are each other's
    references. `progress` is called after each level with the completed share, up to 1. A count
    without a level raises TriangleCountError.
    """
    full = history.full()
    none = Distances(0.0, 0.0)
    surfaces = {full.triangles: surface_in_preorder(full, history)}
    volume = enclosed_volume(surfaces[full.triangles][0])
    curve = {full.triangles: LevelError(full.triangles, volume, 0.0, 0.0, 0.0, none, none)}
    mismatch_bound = distance_bound = 0.0
    level_counts = sorted({history.level_triangles(count) for count in counts})
    work = sum(count for count in level_counts if count < full.triangles)
    done = 0
    for count in reversed(level_counts):
        if count == full.triangles:
            continue
        level, parents = surface_in_preorder(history.level(count), history)
        reference = _reference(count, level_counts, full.triangles)
        finer, near = surfaces[reference]
        comparison, deviation = compare_surfaces(
            finer, level, np.arange(len(near), dtype=np.int32), near
        )
        surfaces[count] = level._replace(deviation=deviation), parents
        from_full, to_full = (
            _limit_mean(comparison.from_reference),
            _limit_mean(comparison.to_reference),
        )
        against_reference = comparison.difference / volume
        mismatch_bound = max(mismatch_bound, against_reference + curve[reference].mismatch_bound)
        # if the reference itself has lost volume, as on spiky bodies, the volumes are more accurate
        lost = abs(comparison.other_volume - volume) / volume
        distance_bound = max(distance_bound, from_full.maximum, to_full.maximum)
        curve[count] = LevelError(
            triangles=count,
            volume=comparison.other_volume,
            mismatch=min(max(against_reference, lost), mismatch_bound),
            mismatch_bound=mismatch_bound,
            distance_bound=distance_bound,
            from_full=from_full,
            to_full=to_full,
        )
        done += count
        if progress is not None:
            progress(done / work)
    return [curve[count] for count in level_counts]


def _reference(count: int, counts: list[int], full: int) -> int:
    """Triangle count of the reference of a level."""
    finest = max(other for other in counts if other < full)
    finer = [other for other in counts if other >= FINER * count]
    if finest >= FINER * count:
        return min(finer)
    return finest if finest >= FINER_AT_LEAST * count else full


def _limit_mean(distances: Distances) -> Distances:
    """Return distances with the estimated mean limited to the bound."""
    return Distances(min(distances.mean, distances.maximum), distances.maximum)


class FullBoundary:
    """The full boundary of a history about the origin, with which levels are compared as a whole.

    The whole history is unpacked.
    """

    def __init__(self, history: History) -> None:
        self.history = history
        self.centre = np.asarray(history.centre, np.float64)
        self.full, self._near = surface_in_preorder(history.full(), history)
        self._order = np.arange(len(self._near), dtype=np.int32)

    def surface(self, level: TriangleMesh) -> Surface:
        """Return a level as a surface about the origin."""
        position = np.ascontiguousarray(level.vertices.astype(np.float64) - self.centre)
        return make_surface(position, np.ascontiguousarray(level.faces, np.int32).ravel())

    def locate(self, cones: Cones) -> Locations:
        """Locate the vertices of the full boundary in the cones of a level."""
        return locate(self.full.position, self._order, self._near, cones)

    def compare(self, level: Surface, bounds: FloatArray | None = None) -> RadialDifference:
        """Compare a level with the full boundary; `bounds` as for `compare_surfaces`."""
        difference, _ = compare_surfaces(self.full, level, self._order, self._near, bounds=bounds)
        return difference


def surface_in_preorder(level: TriangleMesh, history: History) -> tuple[Surface, IndexArray]:
    """Return a level as a surface about the origin, with neighbours in space close in memory.

    Vertices are in preorder of the forest of splits. The second result (V,) is the parent of each
    vertex, which precedes it; 0 for the roots.
    """
    position, corner, near = _in_preorder(
        level.vertices, np.asarray(history.centre, np.float64), level.faces, history.splits.parent
    )
    return make_surface(position, corner), near


@kernel
def _in_preorder(
    vertices: Float32Array, centre: FloatArray, faces: IndexArray, parent: IndexArray
) -> tuple[FloatArray, IndexArray, IndexArray]:
    """Sort slots in preorder: each slot is followed by all slots that were split from it.

    Each slot from 4 on adds two faces; `parent` has the parents from there. The result is the
    positions (V, 3) relative to the centre, the corners (3 F,), and the parent of each vertex; 0
    for the roots.
    """
    count = len(vertices)
    size = np.ones(count, np.int32)
    for slot in range(count - 1, 3, -1):
        size[parent[slot - 4]] += size[slot]
    rank, filled = np.empty(count, np.int32), np.empty(count, np.int32)
    position, near = np.empty((count, 3)), np.zeros(count, np.int32)
    corner = np.empty(3 * len(faces), np.int32)
    free = 0
    for slot in range(count):
        if slot < 4:
            rank[slot] = free
            free += size[slot]
        else:
            above = parent[slot - 4]
            rank[slot] = filled[above]
            filled[above] += size[slot]
            near[rank[slot]] = rank[above]
        filled[slot] = rank[slot] + 1
        for axis in range(3):
            position[rank[slot], axis] = np.float64(vertices[slot, axis]) - centre[axis]
    # one face with each of the first four slots, two with each later slot
    slot_of_rank = np.empty(count, np.int32)
    for slot in range(count):
        slot_of_rank[rank[slot]] = slot
    written = 0
    for index in range(count):
        slot = slot_of_rank[index]
        first, last = (slot, slot + 1) if slot < 4 else (2 * slot - 4, 2 * slot - 2)
        for face in range(first, last):
            for side in range(3):
                corner[written] = rank[faces[face, side]]
                written += 1
    return position, corner, near
