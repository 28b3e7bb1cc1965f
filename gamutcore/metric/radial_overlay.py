"""Difference of two surfaces that are star-shaped about one centre.

Every ray from the centre meets each surface once. The faces of one surface are clipped by the
planes through the centre and the edges of the other. Each piece is then seen through a single face
of the other surface, whose plane is N · p = 1. On the ray through a point p, the other surface is
1 ÷ (N · p) times as far from the centre. N · p is linear on the piece, so volumes are closed forms.
Most faces are seen through one face or cross a single edge; the others are clipped as polygons.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

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
    nearest_face,
    raise_bound,
    squared_distance,
    star_shaped_surface,
)
from gamutcore.metric.integrals import CAPACITY, Queue, empty_queue, flush, push, push_three

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from gamutcore.mesh import TriangleMesh

__all__ = [
    "Distances",
    "RadialDifference",
    "compare_surfaces",
    "enclosed_volume",
    "radial_difference",
]


FROM_LOWER, FROM_UPPER, TO_LOWER, TO_UPPER, HALVINGS_LEFT = range(5)
"""Elements of the array of bounds: lower and upper bound of the distances from the reference to the
other surface, the same from the other surface to the reference, and the number of halvings left."""


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
    halvings: float | None = None,
    moves: int = MOVES,
) -> tuple[RadialDifference, FloatArray]:
    """Compare two surfaces that are star-shaped about the origin.

    Parameters
    ----------
    reference : Surface
        The finer surface. Largest distances refer to the surface that it represents.
    other : Surface
        The coarser surface. A finer one gives the same result in more time.
    order, near : (V,) int32
        For the vertices of the reference, as for `locate`.
    halvings : float, optional
        Most halvings for tight distances; by default the `halving_limit` of the reference.
    moves : int
        As for `locate`.

    Returns
    -------
    difference : RadialDifference
        Largest distances are from and to the surface that the reference represents.
    deviation : (F,) float64
        Deviations of the faces of the other surface from that surface.
    """
    cones = compute_cones(other)
    locations = locate(reference.position, order, near, cones, moves)
    halvings = halving_limit(reference) if halvings is None else halvings
    bounds = np.array([0.0, 0.0, 0.0, 0.0, halvings])
    deviation = np.zeros(len(other.deviation))
    volume, area, difference, first, second = _integrate_surfaces(
        reference,
        other,
        cones,
        locations,
        clipping_workspace(),
        empty_queue(),
        np.empty(STACK),
        bounds,
        deviation,
        moves,
    )
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


@inlined_kernel
def _corners(corner: IndexArray, face: int) -> tuple[Any, Any, Any]:
    """Vertices of a face, as `INDEX`."""
    at = INDEX(3 * face)
    return INDEX(corner[at]), INDEX(corner[at + INDEX(1)]), INDEX(corner[at + INDEX(2)])


@leaf_kernel
def _square(position: FloatArray, vertex: int) -> float:
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
def _set_lower_bounds(
    reference: Surface, other: Surface, locations: Locations, bounds: FloatArray
) -> float:
    """Set lower bounds from the vertices of the reference and the other surface on their rays.

    Return the largest distance of a vertex from the centre.
    """
    position, reach, deviation = reference.position, 0.0, reference.deviation
    for vertex in range(len(position)):
        x, y, z = position[vertex, 0], position[vertex, 1], position[vertex, 2]
        reach = max(reach, x * x + y * y + z * z)
        face = reference.fan[INDEX(reference.fan_end[vertex] - 1)]
        own = deviation[INDEX(face)]
        if locations.along[vertex] + own > bounds[FROM_LOWER]:
            _, squared = nearest_face(x, y, z, other, locations.face[vertex])
            bounds[FROM_LOWER] = max(bounds[FROM_LOWER], np.sqrt(squared) + own)
        if locations.along[vertex] + own > bounds[TO_LOWER]:
            t = 1.0 / (1.0 + locations.beyond[vertex])
            face, squared = nearest_face(t * x, t * y, t * z, reference, face)
            bounds[TO_LOWER] = max(bounds[TO_LOWER], np.sqrt(squared) + deviation[face])
    bounds[FROM_UPPER], bounds[TO_UPPER] = SLACK * bounds[FROM_LOWER], SLACK * bounds[TO_LOWER]
    return float(np.sqrt(reach))


@leaf_kernel
def _raise_bounds(
    triangle: FloatArray,
    stack: FloatArray,
    reference: Surface,
    face: int,
    other: Surface,
    through: int,
    bounds: FloatArray,
    deviation: FloatArray,
) -> None:
    """Raise the bounds so that they hold for a triangle of the reference, seen through a face.

    The distance of a corner along its ray is at least its distance from the face, in both
    directions. The largest distance of a corner holds for the whole triangle, also for `deviation`.
    """
    furthest, own = 0.0, reference.deviation[face]
    for row in range(3):
        x, y, z = triangle[row, 0], triangle[row, 1], triangle[row, 2]
        shift = 1.0 - 1.0 / (1.0 + triangle[row, 3])
        furthest = max(furthest, shift * shift * (x * x + y * y + z * z))
    furthest = np.sqrt(furthest) + own
    if furthest > deviation[through]:
        # on steep faces the distance along rays is far larger than the distance from the face
        squared = 0.0
        for row in range(3):
            x, y, z = triangle[row, 0], triangle[row, 1], triangle[row, 2]
            squared = max(squared, squared_distance(x, y, z, other, through))
            t = 1.0 / (1.0 + triangle[row, 3])
            squared = max(squared, squared_distance(t * x, t * y, t * z, reference, face))
        deviation[through] = max(deviation[through], own + np.sqrt(squared))
    if furthest > bounds[FROM_UPPER]:
        for row in range(3):
            for axis in range(3):
                stack[0, 3 * row + axis] = triangle[row, axis]
        bounds[FROM_LOWER], bounds[FROM_UPPER], bounds[HALVINGS_LEFT] = raise_bound(
            stack,
            other,
            through,
            own,
            bounds[FROM_LOWER],
            bounds[FROM_UPPER],
            bounds[HALVINGS_LEFT],
        )
    if furthest > bounds[TO_UPPER]:
        for row in range(3):
            for axis in range(3):
                stack[0, 3 * row + axis] = triangle[row, axis] / (1.0 + triangle[row, 3])
        bounds[TO_LOWER], bounds[TO_UPPER], bounds[HALVINGS_LEFT] = raise_bound(
            stack, reference, face, 0.0, bounds[TO_LOWER], bounds[TO_UPPER], bounds[HALVINGS_LEFT]
        )


@leaf_kernel
def _set_corner(
    triangle: FloatArray, row: int, position: FloatArray, vertex: int, d: float
) -> None:
    for axis in range(3):
        triangle[row, axis] = position[vertex, axis]
    triangle[row, 3] = d


@leaf_kernel
def _set_crossing(
    triangle: FloatArray, row: int, position: FloatArray, one: int, two: int, share: float, d: float
) -> None:
    for axis in range(3):
        start = position[one, axis]
        triangle[row, axis] = start + share * (position[two, axis] - start)
    triangle[row, 3] = d


@leaf_kernel
def _integrate_surfaces(  # noqa: C901, PLR0912  # the time is in these branches
    reference: Surface,
    other: Surface,
    cones: Cones,
    locations: Locations,
    work: Clipping,
    waiting: Queue,
    stack: FloatArray,
    bounds: FloatArray,
    deviation: FloatArray,
    moves: int,
) -> tuple[float, float, float, float, float]:
    """Integrate over all pieces.

    Parameters
    ----------
    locations : Locations
        Locations of the vertices of the reference in the cones of the other surface.
    waiting : Queue
        An empty queue.
    bounds : (5,) float64
        Indexed by `FROM_LOWER` and so on; updated.
    deviation : (F,) float64
        Zeros; become the deviations of the faces of the other surface.

    Returns
    -------
    volume, area : float
        Volume and area of the reference.
    difference : float
        Volume of the symmetric difference.
    first, second : float
        Integrals of the distances from the planes over the reference and over the other surface.
    """
    position, corner, triangle = reference.position, reference.corner, work.triangle
    beyond, along, slope = locations.beyond, locations.along, cones.slope
    reach = _set_lower_bounds(reference, other, locations, bounds)
    volume, area, difference, first, second = 0.0, 0.0, 0.0, 0.0, 0.0
    queued = 0
    for face in range(len(corner) // 3):
        if queued > CAPACITY - 3:
            difference, first, second = flush(waiting, queued, difference, first, second)
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
        if through == last == locations.face[two]:
            weights = (part, whole, weight)
            queued = push(waiting, queued, (d1, d2, d3), weights, slope[INDEX(through)])
            if pending > min(bounds[FROM_UPPER], bounds[TO_UPPER]):
                _set_corner(triangle, 0, position, one, d1)
                _set_corner(triangle, 1, position, two, d2)
                _set_corner(triangle, 2, position, three, d3)
                _raise_bounds(triangle, stack, reference, face, other, through, bounds, deviation)
            else:
                deviation[INDEX(through)] = max(deviation[INDEX(through)], pending)
            continue
        radius = np.sqrt(
            max(_square(position, one), _square(position, two), _square(position, three))
        )
        if through == locations.face[two]:
            single, from_two, from_one = find_crossing(
                position, one, two, three, through, last, cones
            )
            if single:
                x, y, z = position[three, 0], position[three, 1], position[three, 2]
                normal = cones.normal
                at = INDEX(through)
                d = normal[at, 0] * x + normal[at, 1] * y + normal[at, 2] * z - 1.0
                d4, d5 = d2 + from_two * (d - d2), d1 + from_one * (d - d1)
                queued = push_three(
                    waiting,
                    queued,
                    (d1, d2, d3, d4, d5),
                    (from_two, from_one * (1.0 - from_two), (1.0 - from_two) * (1.0 - from_one)),
                    (part, whole, weight),
                    (slope[at], slope[INDEX(last)]),
                )
                away = own + radius * max(abs(d4) / (1.0 + d4), abs(d5) / (1.0 + d5))
                pending = max(pending, away)
                if pending > min(bounds[FROM_UPPER], bounds[TO_UPPER]):
                    _set_corner(triangle, 0, position, one, d1)
                    _set_corner(triangle, 1, position, two, d2)
                    _set_crossing(triangle, 2, position, two, three, from_two, d4)
                    _raise_bounds(
                        triangle, stack, reference, face, other, through, bounds, deviation
                    )
                    _set_crossing(triangle, 1, position, one, three, from_one, d5)
                    _raise_bounds(
                        triangle, stack, reference, face, other, through, bounds, deviation
                    )
                    _set_corner(triangle, 0, position, three, d3)
                    _raise_bounds(triangle, stack, reference, face, other, last, bounds, deviation)
                else:
                    deviation[at] = max(deviation[at], own + along[one], own + along[two], away)
                    at = INDEX(last)
                    deviation[at] = max(deviation[at], own + along[three], away)
                continue
        top = push_face(work, position, one, two, three, through)
        piece, frame = work.piece, work.frame
        while True:
            through, count, top = pop_piece(work, top, cones, reach, moves)
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
                    difference, first, second = flush(waiting, queued, difference, first, second)
                    queued = 0
                corners = (piece[0, 2], piece[index, 2], piece[index + 1, 2])
                weights = (part * share, whole * share, weight * share)
                queued = push(waiting, queued, corners, weights, slope[at])
                if pending > min(bounds[FROM_UPPER], bounds[TO_UPPER]):
                    for row in range(3):
                        number = 0 if row == 0 else index + row - 1
                        u, v = piece[number, 0], piece[number, 1]
                        for axis in range(3):
                            triangle[row, axis] = (
                                frame[axis] + u * frame[3 + axis] + v * frame[6 + axis]
                            )
                        triangle[row, 3] = piece[number, 2]
                    _raise_bounds(
                        triangle, stack, reference, face, other, through, bounds, deviation
                    )
    difference, first, second = flush(waiting, queued, difference, first, second)
    return volume, area, difference, first, second
