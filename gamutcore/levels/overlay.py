"""Overlay of two surfaces that are star-shaped about one centre: volumes and distances.

Every ray from the centre meets each surface once. The faces of one surface are clipped by the
planes through the centre and the edges of the other. Each piece is then seen through a single face
of the other surface, whose plane is N · p = 1. On the ray through a point p, the other surface is
1 ÷ (N · p) times as far from the centre. N · p is linear on the piece, so volumes are closed forms.
Most faces are seen through one face or cross a single edge; the others are clipped as polygons.

Data layout: the closed forms have ten divisions, and a special case for triangles that the face
cuts, which is half of them. Triangles are pushed to a queue. A full queue is integrated in one loop
without branches. The compiler vectorises the loop, which then takes a third of the time. Results
are added to the sums of the faces in the order of the queue, so they do not depend on the batches.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.geometry import cross, dot, minus, row
from gamutcore.kernels import inlined_kernel, leaf_kernel
from gamutcore.levels.cones import (
    INDEX,
    MOVES,
    Clipping,
    Cones,
    Locations,
    Surface,
    breadth_first,
    clipping_workspace,
    compute_cones,
    find_crossing,
    locate,
    pop_piece,
    push_face,
    star_shaped_surface,
)
from gamutcore.levels.distances import (
    FROM_UPPER,
    SLACK,
    STACK,
    TO_UPPER,
    halving_limit,
    new_bounds,
    raise_bounds,
    raise_lower_bounds,
    set_corner,
    set_crossing,
)

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from gamutcore.geometry import TriangleMesh

CAPACITY = 256
"""Triangles in a queue. With their integrals they take 20 kB, which fit into the L1 cache."""

ONE, TWO, THREE, FOUR, FIVE, SIX = (INDEX(row * CAPACITY) for row in range(1, 7))
"""First indices of the rows of a queue after the first."""


@dataclass(frozen=True)
class Distances:
    """Distances of the points of one surface from another surface.

    Attributes
    ----------
    mean : float
        Mean over the area of the distance from the plane of the other surface's face on the same
        ray. It is close to the mean distance from the surface if the surfaces are close.
    maximum : float
        Upper bound of the largest distance from the surface, usually within a few per cent.
    """

    mean: float
    maximum: float


@dataclass(frozen=True)
class RadialDifference:
    """Difference of two surfaces.

    Attributes
    ----------
    volume : float
        Volume within the reference.
    other_volume : float
        Volume within the other surface.
    difference : float
        Volume of the symmetric difference, exact except for rounding.
    from_reference : Distances
        Distances of the points of the reference from the other surface.
    to_reference : Distances
        Distances of the points of the other surface from the reference.
    """

    volume: float
    other_volume: float
    difference: float
    from_reference: Distances
    to_reference: Distances

    @property
    def mismatch(self) -> float:
        """Volume of the symmetric difference ÷ volume of the reference."""
        return self.difference / self.volume


def radial_difference(
    reference: TriangleMesh, other: TriangleMesh, centre: ArrayLike
) -> RadialDifference:
    """Compare two surfaces that are star-shaped about the same centre.

    Parameters
    ----------
    reference, other : TriangleMesh
        Closed, oriented, of genus 0, and star-shaped about the centre.
    centre : (3,) array_like

    Returns
    -------
    RadialDifference

    Raises
    ------
    MeshError
        If a mesh is not star-shaped about the centre.
    """
    origin = np.asarray(centre, np.float64)
    one, two = star_shaped_surface(reference, origin), star_shaped_surface(other, origin)
    # clipping the finer surface by the coarser one is faster than the reverse
    swapped = len(two.corner) > len(one.corner)
    if swapped:
        one, two = two, one
    result, _ = compare_surfaces(one, two, *breadth_first(one))
    if not swapped:
        return result
    return RadialDifference(
        volume=result.other_volume,
        other_volume=result.volume,
        difference=result.difference,
        from_reference=result.to_reference,
        to_reference=result.from_reference,
    )


def compare_surfaces(
    reference: Surface,
    other: Surface,
    order: IndexArray,
    near: IndexArray,
    *,
    bounds: FloatArray | None = None,
    moves: int = MOVES,
) -> tuple[RadialDifference, FloatArray]:
    """Compare two surfaces that are star-shaped about the origin; the reference is the finer one.

    A finer `other` gives the same result in more time. `order` and `near` (V,) are those of
    `locate` for the reference's vertices. `bounds` come from `new_bounds` and are updated; by
    default distances are within 3 %. Largest distances, and the returned deviations (F,) of the
    other surface's faces, refer to the surface that the reference represents.
    """
    cones = compute_cones(other)
    locations = locate(reference.position, order, near, cones, moves)
    if bounds is None:
        bounds = new_bounds(halving_limit(reference), SLACK)
    deviation, sums = np.zeros(len(other.deviation)), np.zeros((len(other.deviation), 3))
    raise_lower_bounds(reference, other, locations, order, bounds)
    waiting = _Queue(np.zeros(7 * CAPACITY), np.zeros(CAPACITY, np.int32), np.zeros(3 * CAPACITY))
    volume, area = _integrate_surfaces(
        reference,
        other,
        cones,
        locations,
        _Workspace(clipping_workspace(), waiting, np.empty(STACK)),
        bounds,
        sums,
        deviation,
        moves,
    )
    difference, first, second = sums.sum(axis=0).tolist()
    other_volume, other_area = _volume_and_area(other)
    result = RadialDifference(
        volume=volume,
        other_volume=other_volume,
        difference=difference,
        from_reference=Distances(first / area, float(bounds[FROM_UPPER])),
        to_reference=Distances(second / other_area, float(bounds[TO_UPPER])),
    )
    return result, deviation


def enclosed_volume(surface: Surface) -> float:
    """Return the volume within a surface that is star-shaped about the origin."""
    return _volume_and_area(surface)[0]


@leaf_kernel
def _volume_and_area(surface: Surface) -> tuple[float, float]:
    """Volume and area."""
    position, corner = surface.position, surface.corner
    volume, area = 0.0, 0.0
    for face in range(len(corner) // 3):
        one, two, three = _corners(corner, face)
        part, whole = _face_extent(position, one, two, three)
        volume += part
        area += whole
    return volume, area


@leaf_kernel
def _face_extent(position: FloatArray, one: int, two: int, three: int) -> tuple[float, float]:
    """Volume between a face and the centre, and the area of the face."""
    a = row(position, one, 0)
    across = cross(minus(row(position, two, 0), a), minus(row(position, three, 0), a))
    return dot(a, across) / 6.0, 0.5 * np.sqrt(dot(across, across))


@inlined_kernel
def _corners(corner: IndexArray, face: int) -> tuple[Any, Any, Any]:
    """Vertices of a face, as `INDEX`."""
    at = INDEX(3 * face)
    return INDEX(corner[at]), INDEX(corner[at + INDEX(1)]), INDEX(corner[at + INDEX(2)])


class _Queue(NamedTuple):
    """A queue of triangles, and room for their integrals."""

    # (7 `CAPACITY`,) seven rows: N · p − 1 at the three corners, the weights of the three
    # integrals, and the length of N
    triangle: FloatArray
    face: IndexArray  # (`CAPACITY`,) the face that each triangle is seen through
    integral: FloatArray  # (3 `CAPACITY`,) three rows of results of `_integrate`


class _Workspace(NamedTuple):
    """Work space for `_integrate_surfaces`. The queue `waiting` is empty between calls."""

    clipping: Clipping
    waiting: _Queue
    stack: FloatArray


@leaf_kernel
def _integrate_surfaces(  # noqa: C901, PLR0912  # the time is in these branches
    reference: Surface,
    other: Surface,
    cones: Cones,
    locations: Locations,
    workspace: _Workspace,
    bounds: FloatArray,
    sums: FloatArray,
    deviation: FloatArray,
    moves: int,
) -> tuple[float, float]:
    """Integrate over the pieces of all faces; return volume and area of the reference.

    `locations` has the reference's vertices in `cones`, those of the other surface. `bounds` (see
    `new_bounds`), `sums` and `deviation` (F,) are updated. `sums` (F, 3) has, for each face of the
    other surface, integrals over the pieces seen through it: the volume of the symmetric
    difference, and distances from the planes over the reference and over the other surface.
    """
    work, waiting, stack = workspace
    position, corner, triangle = reference.position, reference.corner, work.triangle
    beyond, along, slope = locations.beyond, locations.along, cones.slope
    volume, area = 0.0, 0.0
    queued = 0
    for face in range(len(corner) // 3):
        if queued > CAPACITY - 3:
            _flush(waiting, queued, sums)
            queued = 0
        one, two, three = _corners(corner, face)
        # rotate the corners so that the first two share a cone if any two do
        if locations.face[two] == locations.face[three]:
            one, two, three = two, three, one
        elif locations.face[three] == locations.face[one]:
            one, two, three = three, one, two
        through, last = locations.face[one], locations.face[three]
        part, whole = _face_extent(position, one, two, three)
        volume += part
        area += whole
        # weight of the third integral, per volume below the piece
        weight = 3.0 * part * (3.0 * part / whole)
        d1, d2, d3 = beyond[one], beyond[two], beyond[three]
        own = reference.deviation[face]
        pending = own + max(along[one], along[two], along[three])
        weights = (part, whole, weight)
        if through == last == locations.face[two]:
            queued = _push(waiting, queued, through, (d1, d2, d3), weights, slope[INDEX(through)])
            if pending > min(bounds[FROM_UPPER], bounds[TO_UPPER]):
                set_corner(triangle, 0, position, one, d1)
                set_corner(triangle, 1, position, two, d2)
                set_corner(triangle, 2, position, three, d3)
                raise_bounds(triangle, stack, reference, face, other, through, bounds, deviation)
            else:
                deviation[INDEX(through)] = max(deviation[INDEX(through)], pending)
            continue
        a, b, c = row(position, one, 0), row(position, two, 0), row(position, three, 0)
        radius = np.sqrt(max(dot(a, a), dot(b, b), dot(c, c)))
        if through == locations.face[two]:
            single, from_two, from_one = find_crossing(
                position, one, two, three, through, last, cones
            )
            if single:
                at, beside = INDEX(through), INDEX(last)
                d = dot(row(cones.normal, at, 0), c) - 1.0
                d4, d5 = d2 + from_two * (d - d2), d1 + from_one * (d - d1)
                away = own + radius * max(abs(d4) / (1.0 + d4), abs(d5) / (1.0 + d5))
                close = max(pending, away) <= min(bounds[FROM_UPPER], bounds[TO_UPPER])
                share, corners = from_two, (d1, d2, d4)
                queued = _push_part(waiting, queued, through, corners, share, weights, slope[at])
                share, corners = from_one * (1.0 - from_two), (d1, d4, d5)
                queued = _push_part(waiting, queued, through, corners, share, weights, slope[at])
                if close:
                    deviation[at] = max(deviation[at], own + along[one], own + along[two], away)
                else:
                    set_corner(triangle, 0, position, one, d1)
                    set_corner(triangle, 1, position, two, d2)
                    set_crossing(triangle, 2, position, two, three, from_two, d4)
                    raise_bounds(
                        triangle, stack, reference, face, other, through, bounds, deviation
                    )
                    set_crossing(triangle, 1, position, one, three, from_one, d5)
                    raise_bounds(
                        triangle, stack, reference, face, other, through, bounds, deviation
                    )
                share, corners = (1.0 - from_two) * (1.0 - from_one), (d4, d3, d5)
                queued = _push_part(waiting, queued, last, corners, share, weights, slope[beside])
                if close:
                    deviation[beside] = max(deviation[beside], own + along[three], away)
                else:
                    set_crossing(triangle, 2, position, two, three, from_two, d4)
                    set_crossing(triangle, 1, position, one, three, from_one, d5)
                    set_corner(triangle, 0, position, three, d3)
                    raise_bounds(triangle, stack, reference, face, other, last, bounds, deviation)
                continue
        top = push_face(work, position, one, two, three, through)
        piece, frame = work.piece, work.frame
        while True:
            through, count, top = pop_piece(work, top, cones, radius, moves)
            if through < 0:
                break
            largest, least = 0.0, np.inf
            for index in range(count):
                largest = max(largest, abs(piece[INDEX(index), 2]))
                least = min(least, piece[INDEX(index), 2])
            # a cheap upper bound first; it mostly changes nothing
            pending = own + radius * (largest / (1.0 + least))
            accepted = min(bounds[FROM_UPPER], bounds[TO_UPPER])
            at = INDEX(through)
            if not pending <= min(accepted, deviation[at]):
                pending = 0.0
                for index in range(count):
                    pending = max(pending, abs(piece[index, 2]) / (1.0 + piece[index, 2]))
                pending = own + radius * pending
                if pending <= accepted:
                    deviation[at] = max(deviation[at], pending)
            for index in range(1, count - 1):
                share = (piece[index, 0] - piece[0, 0]) * (piece[index + 1, 1] - piece[0, 1]) - (
                    piece[index, 1] - piece[0, 1]
                ) * (piece[index + 1, 0] - piece[0, 0])
                if queued == CAPACITY:
                    _flush(waiting, queued, sums)
                    queued = 0
                corners = (piece[0, 2], piece[index, 2], piece[index + 1, 2])
                queued = _push_part(waiting, queued, through, corners, share, weights, slope[at])
                if pending > min(bounds[FROM_UPPER], bounds[TO_UPPER]):
                    for side in range(3):
                        number = 0 if side == 0 else index + side - 1
                        u, v = piece[number, 0], piece[number, 1]
                        for axis in range(3):
                            triangle[side, axis] = (
                                frame[axis] + u * frame[3 + axis] + v * frame[6 + axis]
                            )
                        triangle[side, 3] = piece[number, 2]
                    raise_bounds(
                        triangle, stack, reference, face, other, through, bounds, deviation
                    )
    _flush(waiting, queued, sums)
    return volume, area


@inlined_kernel
def _push(
    waiting: _Queue,
    count: int,
    face: int,
    corners: tuple[float, float, float],
    weights: tuple[float, float, float],
    slope: float,
) -> int:
    """Push a triangle to a queue with `count` < `CAPACITY` triangles; return the new count.

    The triangle is seen through `face`. `corners` are N · p − 1, and `weights` are factors of the
    three integrals. The second integral is also divided by the length of N, `slope`; the third is
    multiplied.
    """
    triangle, at = waiting.triangle, INDEX(count)
    triangle[at], triangle[at + ONE], triangle[at + TWO] = corners
    triangle[at + THREE], triangle[at + FOUR], triangle[at + FIVE] = weights
    triangle[at + SIX] = slope
    waiting.face[at] = face
    return count + 1


@inlined_kernel
def _push_part(
    waiting: _Queue,
    count: int,
    face: int,
    corners: tuple[float, float, float],
    share: float,
    weights: tuple[float, float, float],
    slope: float,
) -> int:
    """Push a part of a triangle with a `share` of its area, as `_push`."""
    one, two, three = weights
    return _push(waiting, count, face, corners, (share * one, share * two, share * three), slope)


@leaf_kernel
def _flush(waiting: _Queue, count: int, sums: FloatArray) -> None:
    """Integrate the triangles of a queue, and add the weighted results to sums (F, 3) of faces."""
    _integrate(waiting, count)
    triangle, integral = waiting.triangle, waiting.integral
    for index in range(count):
        at, face = INDEX(index), INDEX(waiting.face[INDEX(index)])
        slope = triangle[at + SIX]
        sums[face, 0] += triangle[at + THREE] * integral[at]
        sums[face, 1] += triangle[at + FOUR] * integral[at + ONE] / slope
        sums[face, 2] += triangle[at + FIVE] * integral[at + TWO] * slope


@leaf_kernel
def _integrate(waiting: _Queue, count: int) -> None:
    """Compute the integrals of triangles of a queue, each ÷ volume between triangle and centre.

    Let d = N · p − 1 and t = 1 ÷ (N · p) at its corners. The other surface's part of the same cone
    has t₁ t₂ t₃ times the volume. The integrals are

    - the volume between the triangle and the face;
    - the mean of |d| over the triangle;
    - the mean of |t − 1| over the part of the face that the triangle is seen through, times t₁ t₂
      t₃.
    """
    triangle, integral = waiting.triangle, waiting.integral
    for index in range(count):
        at = INDEX(index)
        one, two, three = triangle[at], triangle[at + ONE], triangle[at + TWO]
        t1, t2, t3 = 1.0 + one, 1.0 + two, 1.0 + three
        product = 1.0 / (t1 * t2 * t3)
        t_sum = product * (t2 * t3 + t1 * t3 + t1 * t2)
        # rotate the corners so that the first is alone on its side of the face; d = 0 on the cut
        up1, up2, up3 = one >= 0.0, two >= 0.0, three >= 0.0
        third = up1 == up2
        second = (up1 == up3) & (not third)
        whole = third & (up2 == up3)
        a = three if third else (two if second else one)
        b = one if third else (three if second else two)
        c = two if third else (one if second else three)
        mean = (a + b + c) / 3.0
        part = a * a / ((a - b) * (a - c))
        t = 1.0 / (1.0 + a)
        volume_cut = part * (1.0 - t)
        mean_cut = part * a / 3.0
        a, b, c = a * t, b / (1.0 + b), c / (1.0 + c)
        back_cut = a * a * a / ((a - b) * (a - c) * 3.0)
        gap = abs(1.0 - product - volume_cut) + abs(volume_cut)
        here = abs(mean - mean_cut) + abs(mean_cut)
        back = product * (abs((a + b + c) / 3.0 - back_cut) + abs(back_cut))
        integral[at] = abs(1.0 - product) if whole else gap
        integral[at + ONE] = abs(one + two + three) / 3.0 if whole else here
        integral[at + TWO] = product * abs(t_sum - 3.0) / 3.0 if whole else back
