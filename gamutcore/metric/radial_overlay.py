"""Difference of two surfaces that are star-shaped about one centre.

Every ray from the centre meets each surface once. The faces of one surface are clipped by the
planes through the centre and the edges of the other. Each piece is then seen through a single face
of the other surface, whose plane is N · p = 1. On the ray through a point p, the other surface is
1 ÷ (N · p) times as far from the centre. N · p is linear on the piece, so volumes are closed forms.
Most faces are seen through one face or cross a single edge; the others are clipped as polygons.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.kernels import inlined_kernel, leaf_kernel
from gamutcore.metric.clipping import Clipping, clipping_workspace, pop_piece, push_face
from gamutcore.metric.cones import (
    INDEX,
    MOVES,
    Cones,
    Locations,
    compute_cones,
    find_crossing,
    locate,
)
from gamutcore.metric.distance_bound import (
    SLACK,
    STACK,
    Surface,
    breadth_first,
    halving_limit,
    star_shaped_surface,
)
from gamutcore.metric.integrals import CAPACITY, Queue, empty_queue, flush, push, push_part
from gamutcore.metric.overlay_distances import (
    FROM_UPPER,
    TO_UPPER,
    new_bounds,
    raise_bounds,
    raise_lower_bounds,
    set_corner,
    set_crossing,
)

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from gamutcore.mesh import TriangleMesh

__all__ = [
    "Distances",
    "RadialDifference",
    "compare_surfaces",
    "enclosed_volume",
    "integrate_surfaces",
    "overlay_workspace",
    "radial_difference",
]


class Workspace(NamedTuple):
    """Work space for `integrate_surfaces`. The queue `waiting` is empty between calls."""

    clipping: Clipping
    waiting: Queue
    stack: FloatArray


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
    volume, area = integrate_surfaces(
        reference,
        other,
        cones,
        locations,
        overlay_workspace(),
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


def overlay_workspace() -> Workspace:
    """Return work space for `integrate_surfaces`."""
    return Workspace(clipping_workspace(), empty_queue(), np.empty(STACK))


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


@inlined_kernel
def _corners(corner: IndexArray, face: int) -> tuple[Any, Any, Any]:
    """Vertices of a face, as `INDEX`."""
    at = INDEX(3 * face)
    return INDEX(corner[at]), INDEX(corner[at + INDEX(1)]), INDEX(corner[at + INDEX(2)])


@leaf_kernel
def _squared_radius(position: FloatArray, vertex: int) -> float:
    x, y, z = position[vertex, 0], position[vertex, 1], position[vertex, 2]
    return x * x + y * y + z * z


@leaf_kernel
def _face_extent(position: FloatArray, one: int, two: int, three: int) -> tuple[float, float]:
    """Volume between a face and the centre, and the area of the face."""
    ax, ay, az = position[one, 0], position[one, 1], position[one, 2]
    bx, by, bz = position[two, 0] - ax, position[two, 1] - ay, position[two, 2] - az
    cx, cy, cz = position[three, 0] - ax, position[three, 1] - ay, position[three, 2] - az
    x, y, z = by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx
    return (ax * x + ay * y + az * z) / 6.0, 0.5 * np.sqrt(x * x + y * y + z * z)


@leaf_kernel
def integrate_surfaces(  # noqa: C901, PLR0912  # the time is in these branches
    reference: Surface,
    other: Surface,
    cones: Cones,
    locations: Locations,
    workspace: Workspace,
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
            flush(waiting, queued, sums)
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
            queued = push(waiting, queued, through, (d1, d2, d3), weights, slope[INDEX(through)])
            if pending > min(bounds[FROM_UPPER], bounds[TO_UPPER]):
                set_corner(triangle, 0, position, one, d1)
                set_corner(triangle, 1, position, two, d2)
                set_corner(triangle, 2, position, three, d3)
                raise_bounds(triangle, stack, reference, face, other, through, bounds, deviation)
            else:
                deviation[INDEX(through)] = max(deviation[INDEX(through)], pending)
            continue
        radius = np.sqrt(
            max(
                _squared_radius(position, one),
                _squared_radius(position, two),
                _squared_radius(position, three),
            )
        )
        if through == locations.face[two]:
            single, from_two, from_one = find_crossing(
                position, one, two, three, through, last, cones
            )
            if single:
                at, beside = INDEX(through), INDEX(last)
                x, y, z = position[three, 0], position[three, 1], position[three, 2]
                normal = cones.normal
                d = normal[at, 0] * x + normal[at, 1] * y + normal[at, 2] * z - 1.0
                d4, d5 = d2 + from_two * (d - d2), d1 + from_one * (d - d1)
                away = own + radius * max(abs(d4) / (1.0 + d4), abs(d5) / (1.0 + d5))
                close = max(pending, away) <= min(bounds[FROM_UPPER], bounds[TO_UPPER])
                share, corners = from_two, (d1, d2, d4)
                queued = push_part(waiting, queued, through, corners, share, weights, slope[at])
                share, corners = from_one * (1.0 - from_two), (d1, d4, d5)
                queued = push_part(waiting, queued, through, corners, share, weights, slope[at])
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
                queued = push_part(waiting, queued, last, corners, share, weights, slope[beside])
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
                    flush(waiting, queued, sums)
                    queued = 0
                corners = (piece[0, 2], piece[index, 2], piece[index + 1, 2])
                queued = push_part(waiting, queued, through, corners, share, weights, slope[at])
                if pending > min(bounds[FROM_UPPER], bounds[TO_UPPER]):
                    for row in range(3):
                        number = 0 if row == 0 else index + row - 1
                        u, v = piece[number, 0], piece[number, 1]
                        for axis in range(3):
                            triangle[row, axis] = (
                                frame[axis] + u * frame[3 + axis] + v * frame[6 + axis]
                            )
                        triangle[row, 3] = piece[number, 2]
                    raise_bounds(
                        triangle, stack, reference, face, other, through, bounds, deviation
                    )
    flush(waiting, queued, sums)
    return volume, area
