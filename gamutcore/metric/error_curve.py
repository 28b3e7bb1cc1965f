"""The error of a history's levels against its full boundary, with bounds, for every build.

All levels are star-shaped about one centre, so two of them are compared exactly by cutting one
along the other (`gamutcore.metric.radial_overlay`). A coarse level is not compared with the full
boundary but with a reference, a level about 16 times finer. Volumes of symmetric differences
and distances obey the triangle inequality, so what the reference itself may be off is added: of
the volumes a sixteenth or so; of the distances that of each face, as both are seldom largest in one
place. The times of all comparisons are then a geometric series.
"""

from __future__ import annotations

from dataclasses import dataclass
from decimal import ROUND_CEILING, Context, Decimal
from typing import TYPE_CHECKING, Any

import numpy as np

from gamutcore.kernels import kernel
from gamutcore.metric.distance_bound import faces_of
from gamutcore.metric.radial_overlay import Distances, overlaid, volume_within

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from gamutcore.arrays import Float32Array, FloatArray, IndexArray
    from gamutcore.history import History
    from gamutcore.mesh import TriangleMesh
    from gamutcore.metric.distance_bound import Faces

__all__ = ["LevelError", "arranged", "curve_counts", "error_curve", "round_up"]

EVEN_UP_TO = 16
"""Up to here all levels are in the curve."""

DENSE = 2.0**0.5
"""Ratio of the counts that follow, up to a `DENSE_PART` of the full count. Levels between them are
compared when a limit asks for them (`gamutcore.metric.level_search`)."""

SPARSE = ((2_000, DENSE, 2), (20_000, 2.0, 4), (2**62, 4.0, 16))
"""From a 128th of the full count on: up to which full count, the ratio of the counts, and the full
count's part that the finest of them is. The two finest are compared with the full boundary itself,
which takes up to a tenth of the time of the decimation each if there are many triangles, and none
to speak of if there are few. With an eighth as the finest, levels at the end of the dense part have
references 16 times finer and somewhat tighter bounds, but the curve takes a third longer."""

DENSE_PART = 128
"""The dense part of the curve ends at this part of the full count."""

FINER = 16
"""How much finer than a level its reference should be: with 10 the curve takes a twentieth less,
and the mismatch of levels by `quadric`, which lose volume, is given as 4 % less than it is."""

FINER_AT_LEAST = 8
"""How much finer the finest level of the curve must be to serve in place of the full boundary."""

DIGITS = 6
"""Significant digits of errors in a description; bounds are rounded up."""


@dataclass(frozen=True)
class LevelError:
    """How far a level is from the full boundary.

    Attributes
    ----------
    triangles : int
    volume : float
        Enclosed volume, exact (cubic units of the space).
    mismatch : float
        Volume of the symmetric difference ÷ volume of the full boundary: an estimate, that
        against the level's reference. Boundaries of devices differ from their references by so
        little that it is within 3 %; it is never less than the volumes differ by, nor more than
        `mismatch_bound`.
    mismatch_bound : float
        What the mismatch of this level, and of every finer one in the curve, is at most.
    distance_bound : float
        What the distance of any point of either surface from the other is at most, for this level
        and every finer one in the curve (units of the space).
    from_full : Distances
        Of the full boundary's points from the level (units of the space). The maximum is a bound;
        the mean, which is never more, is an estimate, taken over the reference.
    to_full : Distances
        Of the level's points from the full boundary, likewise.
    """

    triangles: int
    volume: float
    mismatch: float
    mismatch_bound: float
    distance_bound: float
    from_full: Distances
    to_full: Distances

    def to_mapping(self) -> dict[str, Any]:
        """Return the errors as they are described: few digits, bounds rounded up."""
        return {
            "triangles": self.triangles,
            "volume": float(f"{self.volume:.10g}"),
            "mismatch": _rounded(self.mismatch),
            "mismatch_bound": round_up(self.mismatch_bound),
            "distance_bound": round_up(self.distance_bound),
            "from_full": _described(self.from_full),
            "to_full": _described(self.to_full),
        }


def curve_counts(full: int) -> list[int]:
    """Triangle counts of the curve of a full boundary.

    Parameters
    ----------
    full : int
        The full boundary's triangle count.

    Returns
    -------
    list of int
        Even and ascending; from 4 to `full`.
    """
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


def error_curve(
    history: History,
    counts: Iterable[int],
    *,
    progress: Callable[[float], None] | None = None,
) -> list[LevelError]:
    """Errors of several levels against the full boundary.

    Parameters
    ----------
    history : History
    counts : iterable of int
        Triangle counts that the history has. The promise of a level holds for the finer ones among
        these as well, and the levels among them are each other's references.
    progress : callable, optional
        Called after each level with the part of the work that is done.

    Returns
    -------
    list of LevelError
        By ascending triangle count; the full boundary is in it if it was asked for.

    Raises
    ------
    TriangleCountError
        If there is no such level.
    """
    full = history.full()
    none = Distances(0.0, 0.0)
    surfaces = {full.triangles: arranged(full, history)}
    volume = volume_within(surfaces[full.triangles][0])
    curve = {full.triangles: LevelError(full.triangles, volume, 0.0, 0.0, 0.0, none, none)}
    mismatch_bound = distance_bound = 0.0
    asked = sorted({history.level_triangles(count) for count in counts})
    work = sum(count for count in asked if count < full.triangles)
    done = 0
    for count in reversed(asked):
        if count == full.triangles:
            continue
        level, parents = arranged(history.level(count), history)
        reference = _reference(count, asked, full.triangles)
        finer, near = surfaces[reference]
        found, off = overlaid(finer, level, np.arange(len(near), dtype=np.int32), near)
        surfaces[count] = level._replace(off=off), parents
        from_full, to_full = _at_most(found.from_reference), _at_most(found.to_reference)
        against_reference = found.difference / volume
        mismatch_bound = max(mismatch_bound, against_reference + curve[reference].mismatch_bound)
        # where the reference has lost volume itself, as on spiky bodies, the volumes tell more
        lost = abs(found.other_volume - volume) / volume
        distance_bound = max(distance_bound, from_full.maximum, to_full.maximum)
        curve[count] = LevelError(
            triangles=count,
            volume=found.other_volume,
            mismatch=min(max(against_reference, lost), mismatch_bound),
            mismatch_bound=mismatch_bound,
            distance_bound=distance_bound,
            from_full=from_full,
            to_full=to_full,
        )
        done += count
        if progress is not None:
            progress(done / work)
    return [curve[count] for count in asked]


def arranged(level: TriangleMesh, history: History) -> tuple[Faces, IndexArray]:
    """Return a level as `overlaid` takes it, with what is near in space near in memory.

    Parameters
    ----------
    level : TriangleMesh
        A level of the history.
    history : History

    Returns
    -------
    surface : Faces
        About the origin, its vertices in preorder of the forest of splits.
    near : (V,) int32
        The parent of each vertex, which comes before it; 0 of the first ones.
    """
    position, corner, near = _in_preorder(
        level.vertices, np.asarray(history.centre, np.float64), level.faces, history.splits.parent
    )
    return faces_of(position, corner), near


def round_up(bound: float) -> float:
    """Return a bound in as many digits as a description has of it, never less than it is."""
    return float(Context(DIGITS, ROUND_CEILING).create_decimal(Decimal(bound)))


def _even(count: float) -> int:
    return int(count) // 2 * 2


@kernel
def _in_preorder(
    vertices: Float32Array, centre: FloatArray, faces: IndexArray, parent: IndexArray
) -> tuple[FloatArray, IndexArray, IndexArray]:
    """Put each slot before those that were split from it, and these before all others.

    Parameters
    ----------
    vertices : (V, 3) float32
    centre : (3,) float64
    faces : (F, 3) int32
        Of a level: two of them are added with each slot from 4 on.
    parent : (≥ V − 4,) int32
        The slots that these were split from.

    Returns
    -------
    position : (V, 3) float64
        About the centre.
    corner : (3 F,) int32
    near : (V,) int32
        The parent of each vertex, which comes before it; 0 of the first ones.
    """
    count = len(vertices)
    size = np.ones(count, np.int32)
    for slot in range(count - 1, 3, -1):
        size[parent[slot - 4]] += size[slot]
    place, filled = np.empty(count, np.int32), np.empty(count, np.int32)
    position, near = np.empty((count, 3)), np.zeros(count, np.int32)
    corner = np.empty(3 * len(faces), np.int32)
    free = 0
    for slot in range(count):
        if slot < 4:
            place[slot] = free
            free += size[slot]
        else:
            above = parent[slot - 4]
            place[slot] = filled[above]
            filled[above] += size[slot]
            near[place[slot]] = place[above]
        filled[slot] = place[slot] + 1
        for axis in range(3):
            position[place[slot], axis] = np.float64(vertices[slot, axis]) - centre[axis]
    # the first four faces with the first four slots, two with each other one
    slot_at = np.empty(count, np.int32)
    for slot in range(count):
        slot_at[place[slot]] = slot
    written = 0
    for index in range(count):
        slot = slot_at[index]
        first, last = (slot, slot + 1) if slot < 4 else (2 * slot - 4, 2 * slot - 2)
        for face in range(first, last):
            for side in range(3):
                corner[written] = place[faces[face, side]]
                written += 1
    return position, corner, near


def _reference(count: int, counts: list[int], full: int) -> int:
    """Count of the level that one is compared with."""
    finest = max(other for other in counts if other < full)
    finer = [other for other in counts if other >= FINER * count]
    if finest >= FINER * count:
        return min(finer)
    return finest if finest >= FINER_AT_LEAST * count else full


def _at_most(distances: Distances) -> Distances:
    """Return distances whose mean, an estimate, is not more than their bound."""
    return Distances(min(distances.mean, distances.maximum), distances.maximum)


def _described(distances: Distances) -> dict[str, float]:
    return {"mean": _rounded(distances.mean), "maximum": round_up(distances.maximum)}


def _rounded(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")
