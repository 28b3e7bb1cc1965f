"""What two surfaces that are star-shaped about one centre differ by.

Every ray from the centre meets each of the two once. The faces of one are cut along the planes
through the centre and the edges of the other, so that each piece is seen through a single face of
the other, whose plane is N · p = 1. For a point p of the piece the other surface is 1 ÷ (N · p)
times as far from the centre: N · p is linear on the piece, so volumes are closed forms, and exact.
Most faces are seen through one face or cross a single edge; the rest is cut as polygons.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.kernels import inlined_kernel, kernel, leaf_kernel
from gamutcore.metric.clipping import Clipping, begin, clipping, next_piece
from gamutcore.metric.cones import INDEX, MOVES, Cones, Places, cones_of, crossing, located
from gamutcore.metric.distance_bound import (
    SLACK,
    STACK,
    Faces,
    halvings_for,
    nearest_face,
    raise_bound,
    squared_distance,
    star_shaped_faces,
)
from gamutcore.metric.integrals import CAPACITY, Queue, drained, put, put_three, queue

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from gamutcore.mesh import TriangleMesh

__all__ = ["Distances", "RadialDifference", "overlaid", "radial_difference", "volume_within"]


@dataclass(frozen=True)
class Distances:
    """Distances of the points of one surface from another.

    Attributes
    ----------
    mean : float
        Over the area of the one surface, the mean distance from the plane of the face of the other
        that the same ray passes: nearly that from the surface, if the surfaces are close.
    maximum : float
        An upper bound of the largest distance from the surface, usually within a few per cent.
    """

    mean: float
    maximum: float


@dataclass(frozen=True)
class RadialDifference:
    """How two surfaces differ.

    Attributes
    ----------
    volume : float
        Volume within the reference.
    other_volume : float
        Volume within the other surface.
    difference : float
        Volume of the symmetric difference, exact but for rounding.
    from_reference : Distances
        Of the reference's points from the other surface.
    to_reference : Distances
        Of the other surface's points from the reference.
    """

    volume: float
    other_volume: float
    difference: float
    from_reference: Distances
    to_reference: Distances

    @property
    def mismatch(self) -> float:
        """Volume of the symmetric difference, as a part of the reference's volume."""
        return self.difference / self.volume


def radial_difference(
    reference: TriangleMesh, other: TriangleMesh, centre: ArrayLike
) -> RadialDifference:
    """Compare two surfaces that are star-shaped about the same centre.

    Parameters
    ----------
    reference, other : TriangleMesh
        Closed, oriented, of genus 0; all faces see the centre from inside.
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
    one, two = star_shaped_faces(reference, origin), star_shaped_faces(other, origin)
    # the finer one is cut by the coarser one, which is cheaper than the other way round
    swapped = len(two.corner) > len(one.corner)
    if swapped:
        one, two = two, one
    found, _ = overlaid(one, two, *_breadth_first(one))
    if not swapped:
        return found
    return RadialDifference(
        volume=found.other_volume,
        other_volume=found.volume,
        difference=found.difference,
        from_reference=found.to_reference,
        to_reference=found.from_reference,
    )


def overlaid(
    reference: Faces,
    other: Faces,
    order: IndexArray,
    near: IndexArray,
    *,
    halvings: float | None = None,
    moves: int = MOVES,
) -> tuple[RadialDifference, FloatArray]:
    """Compare two surfaces that are star-shaped about the origin.

    Parameters
    ----------
    reference : Faces
        The finer one. Distances are those from what it stands for.
    other : Faces
        The coarser one. The result does not depend on which is finer, but the time does.
    order, near : (V,) int32
        For the reference's vertices, as for `located`.
    halvings : float, optional
        How often pieces may be halved for tight distances; `halvings_for` the reference.
    moves : int
        As for `located`.

    Returns
    -------
    difference : RadialDifference
        The largest distances are from and to what the reference stands for.
    off : (F,) float64
        Of the other surface's faces, with which it can stand for the same.
    """
    cones = cones_of(other)
    places = located(reference.position, order, near, cones, moves)
    halvings = halvings_for(reference) if halvings is None else halvings
    bounds = np.array([0.0, 0.0, 0.0, 0.0, halvings])
    off = np.zeros(len(other.off))
    volume, area, difference, first, second = _overlaid(
        reference, other, cones, places, clipping(), queue(), np.empty(STACK), bounds, off, moves
    )
    other_volume, other_area = _size(other)
    found = RadialDifference(
        volume=volume,
        other_volume=other_volume,
        difference=difference,
        from_reference=Distances(first / area, float(bounds[1])),
        to_reference=Distances(second / other_area, float(bounds[3])),
    )
    return found, off


@kernel
def _breadth_first(surface: Faces) -> tuple[IndexArray, IndexArray]:
    """Vertices in an order in which each is next to one before it, and which one that is."""
    count = len(surface.position)
    order, near = np.zeros(count, np.int32), np.full(count, -1, np.int32)
    near[0] = 0
    filled = 1
    for index in range(count):
        vertex = order[index]
        for entry in range(
            surface.fan_end[vertex - 1] if vertex > 0 else 0, surface.fan_end[vertex]
        ):
            for place in range(3):
                beside = surface.corner[3 * surface.fan[entry] + place]
                if near[beside] < 0:
                    near[beside] = vertex
                    order[filled] = beside
                    filled += 1
    return order, near


def volume_within(surface: Faces) -> float:
    """Volume within a surface that is star-shaped about the origin."""
    return _volume(surface)


@leaf_kernel
def _volume(surface: Faces) -> float:
    volume = 0.0
    for face in range(len(surface.corner) // 3):
        volume += _extent(surface.position, *_corners(surface.corner, face))[0]
    return volume


@leaf_kernel
def _size(surface: Faces) -> tuple[float, float]:
    """Volume and area."""
    position, corner = surface.position, surface.corner
    volume, area = 0.0, 0.0
    for face in range(len(corner) // 3):
        one, two, three = _corners(corner, face)
        part, whole = _extent(position, one, two, three)
        volume += part
        area += whole
    return volume, area


@inlined_kernel
def _corners(corner: IndexArray, face: int) -> tuple[Any, Any, Any]:
    """Vertices of a face, unsigned: a number that may be negative takes more instructions."""
    at = INDEX(3 * face)
    return INDEX(corner[at]), INDEX(corner[at + INDEX(1)]), INDEX(corner[at + INDEX(2)])


@leaf_kernel
def _square(position: FloatArray, vertex: int) -> float:
    x, y, z = position[vertex, 0], position[vertex, 1], position[vertex, 2]
    return x * x + y * y + z * z


@leaf_kernel
def _extent(position: FloatArray, one: int, two: int, three: int) -> tuple[float, float]:
    """Volume between a face and the centre, and the face's area."""
    ax, ay, az = position[one, 0], position[one, 1], position[one, 2]
    bx, by, bz = position[two, 0] - ax, position[two, 1] - ay, position[two, 2] - az
    cx, cy, cz = position[three, 0] - ax, position[three, 1] - ay, position[three, 2] - az
    x, y, z = by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx
    return (ax * x + ay * y + az * z) / 6.0, 0.5 * np.sqrt(x * x + y * y + z * z)


@leaf_kernel
def _attained(reference: Faces, other: Faces, places: Places, bounds: FloatArray) -> float:
    """Set lower bounds by the reference's vertices and the points of the other on the same rays.

    Returns the largest distance of a vertex from the centre.
    """
    position, reach, off = reference.position, 0.0, reference.off
    for vertex in range(len(position)):
        x, y, z = position[vertex, 0], position[vertex, 1], position[vertex, 2]
        reach = max(reach, x * x + y * y + z * z)
        face = reference.fan[INDEX(reference.fan_end[vertex] - 1)]
        own = off[INDEX(face)]
        if places.along[vertex] + own > bounds[0]:
            _, squared = nearest_face(x, y, z, other, places.face[vertex])
            bounds[0] = max(bounds[0], np.sqrt(squared) + own)
        if places.along[vertex] + own > bounds[2]:
            t = 1.0 / (1.0 + places.beyond[vertex])
            face, squared = nearest_face(t * x, t * y, t * z, reference, face)
            bounds[2] = max(bounds[2], np.sqrt(squared) + off[face])
    bounds[1], bounds[3] = SLACK * bounds[0], SLACK * bounds[2]
    return float(np.sqrt(reach))


@leaf_kernel
def _raise_bounds(
    triangle: FloatArray,
    stack: FloatArray,
    reference: Faces,
    face: int,
    other: Faces,
    through: int,
    bounds: FloatArray,
    off: FloatArray,
) -> None:
    """Raise the bounds so that they hold for a triangle of the reference, seen through a face.

    A corner's distance along its ray is at least its distance from the face, in either direction,
    and the largest of the corners' distances holds for the whole triangle. So it does for `off`,
    which is as for `_overlaid`.
    """
    furthest, own = 0.0, reference.off[face]
    for row in range(3):
        x, y, z = triangle[row, 0], triangle[row, 1], triangle[row, 2]
        shift = 1.0 - 1.0 / (1.0 + triangle[row, 3])
        furthest = max(furthest, shift * shift * (x * x + y * y + z * z))
    furthest = np.sqrt(furthest) + own
    if furthest > off[through]:
        # of steep faces the distance along rays is far more than that from the face
        squared = 0.0
        for row in range(3):
            x, y, z = triangle[row, 0], triangle[row, 1], triangle[row, 2]
            squared = max(squared, squared_distance(x, y, z, other, through))
            t = 1.0 / (1.0 + triangle[row, 3])
            squared = max(squared, squared_distance(t * x, t * y, t * z, reference, face))
        off[through] = max(off[through], own + np.sqrt(squared))
    if furthest > bounds[1]:
        for row in range(3):
            for axis in range(3):
                stack[0, 3 * row + axis] = triangle[row, axis]
        bounds[0], bounds[1], bounds[4] = raise_bound(
            stack, other, through, own, bounds[0], bounds[1], bounds[4]
        )
    if furthest > bounds[3]:
        for row in range(3):
            for axis in range(3):
                stack[0, 3 * row + axis] = triangle[row, axis] / (1.0 + triangle[row, 3])
        bounds[2], bounds[3], bounds[4] = raise_bound(
            stack, reference, face, 0.0, bounds[2], bounds[3], bounds[4]
        )


@leaf_kernel
def _corner(triangle: FloatArray, row: int, position: FloatArray, vertex: int, d: float) -> None:
    for axis in range(3):
        triangle[row, axis] = position[vertex, axis]
    triangle[row, 3] = d


@leaf_kernel
def _between(
    triangle: FloatArray, row: int, position: FloatArray, one: int, two: int, share: float, d: float
) -> None:
    for axis in range(3):
        start = position[one, axis]
        triangle[row, axis] = start + share * (position[two, axis] - start)
    triangle[row, 3] = d


@leaf_kernel
def _overlaid(  # noqa: C901, PLR0912  # the time is in these branches
    reference: Faces,
    other: Faces,
    cones: Cones,
    places: Places,
    work: Clipping,
    waiting: Queue,
    stack: FloatArray,
    bounds: FloatArray,
    off: FloatArray,
    moves: int,
) -> tuple[float, float, float, float, float]:
    """Sum over all pieces.

    Parameters
    ----------
    places : Places
        Where the reference's vertices are in the other's cones.
    waiting : Queue
        Work space, empty.
    bounds : (5,) float64
        Written: lower and upper bound of the distances from the reference, and to it. Last, how
        often pieces may be halved.
    off : (F,) float64
        For the faces of the other surface, zeros. Written: the `off` of `Faces` with which it can
        stand for what the reference stands for.

    Returns
    -------
    volume, area : float
        Of the reference.
    difference : float
        Volume of the symmetric difference.
    first, second : float
        Integrals of the distances from planes over the reference and over the other surface.
    """
    position, corner, triangle = reference.position, reference.corner, work.triangle
    beyond, along, slope = places.beyond, places.along, cones.slope
    reach = _attained(reference, other, places, bounds)
    volume, area, difference, first, second = 0.0, 0.0, 0.0, 0.0, 0.0
    queued = 0
    for face in range(len(corner) // 3):
        if queued > CAPACITY - 3:
            difference, first, second = drained(waiting, queued, difference, first, second)
            queued = 0
        one, two, three = _corners(corner, face)
        # turned so that the first two are seen through the same face if any two are
        if places.face[two] == places.face[three]:
            one, two, three = two, three, one
        elif places.face[three] == places.face[one]:
            one, two, three = three, one, two
        through, last = places.face[one], places.face[three]
        part, whole = _extent(position, one, two, three)
        volume += part
        area += whole
        # of the integral over a piece, per volume below it and per plane that it is seen through
        weight = 3.0 * part * (3.0 * part / whole)
        d1, d2, d3 = beyond[one], beyond[two], beyond[three]
        own = reference.off[face]
        pending = own + max(along[one], along[two], along[three])
        if through == last == places.face[two]:
            weights = (part, whole, weight)
            queued = put(waiting, queued, (d1, d2, d3), weights, slope[INDEX(through)])
            if pending > min(bounds[1], bounds[3]):
                _corner(triangle, 0, position, one, d1)
                _corner(triangle, 1, position, two, d2)
                _corner(triangle, 2, position, three, d3)
                _raise_bounds(triangle, stack, reference, face, other, through, bounds, off)
            else:
                off[INDEX(through)] = max(off[INDEX(through)], pending)
            continue
        radius = np.sqrt(
            max(_square(position, one), _square(position, two), _square(position, three))
        )
        if through == places.face[two]:
            single, from_two, from_one = crossing(position, one, two, three, through, last, cones)
            if single:
                x, y, z = position[three, 0], position[three, 1], position[three, 2]
                normal = cones.normal
                at = INDEX(through)
                d = normal[at, 0] * x + normal[at, 1] * y + normal[at, 2] * z - 1.0
                d4, d5 = d2 + from_two * (d - d2), d1 + from_one * (d - d1)
                queued = put_three(
                    waiting,
                    queued,
                    (d1, d2, d3, d4, d5),
                    (from_two, from_one * (1.0 - from_two), (1.0 - from_two) * (1.0 - from_one)),
                    (part, whole, weight),
                    (slope[at], slope[INDEX(last)]),
                )
                away = own + radius * max(abs(d4) / (1.0 + d4), abs(d5) / (1.0 + d5))
                pending = max(pending, away)
                if pending > min(bounds[1], bounds[3]):
                    _corner(triangle, 0, position, one, d1)
                    _corner(triangle, 1, position, two, d2)
                    _between(triangle, 2, position, two, three, from_two, d4)
                    _raise_bounds(triangle, stack, reference, face, other, through, bounds, off)
                    _between(triangle, 1, position, one, three, from_one, d5)
                    _raise_bounds(triangle, stack, reference, face, other, through, bounds, off)
                    _corner(triangle, 0, position, three, d3)
                    _raise_bounds(triangle, stack, reference, face, other, last, bounds, off)
                else:
                    off[at] = max(off[at], own + along[one], own + along[two], away)
                    at = INDEX(last)
                    off[at] = max(off[at], own + along[three], away)
                continue
        top = begin(work, position, one, two, three, through)
        piece, frame = work.piece, work.frame
        while True:
            through, count, top = next_piece(work, top, cones, reach, moves)
            if through < 0:
                break
            largest, least = 0.0, np.inf
            for index in range(count):
                largest = max(largest, abs(piece[INDEX(index), 2]))
                least = min(least, piece[INDEX(index), 2])
            # at least as much as is found below; mostly that already changes nothing
            pending = own + radius * (largest / (1.0 + least))
            accepted = min(bounds[1], bounds[3])
            at = INDEX(through)
            if not pending <= min(accepted, off[at]):
                pending = 0.0
                for index in range(count):
                    pending = max(pending, abs(piece[index, 2]) / (1.0 + piece[index, 2]))
                pending = own + radius * pending
                if pending <= accepted:
                    off[at] = max(off[at], pending)
            for index in range(1, count - 1):
                share = (piece[index, 0] - piece[0, 0]) * (piece[index + 1, 1] - piece[0, 1]) - (
                    piece[index, 1] - piece[0, 1]
                ) * (piece[index + 1, 0] - piece[0, 0])
                if queued == CAPACITY:
                    difference, first, second = drained(waiting, queued, difference, first, second)
                    queued = 0
                corners = (piece[0, 2], piece[index, 2], piece[index + 1, 2])
                weights = (part * share, whole * share, weight * share)
                queued = put(waiting, queued, corners, weights, slope[at])
                if pending > min(bounds[1], bounds[3]):
                    for row in range(3):
                        number = 0 if row == 0 else index + row - 1
                        u, v = piece[number, 0], piece[number, 1]
                        for axis in range(3):
                            triangle[row, axis] = (
                                frame[axis] + u * frame[3 + axis] + v * frame[6 + axis]
                            )
                        triangle[row, 3] = piece[number, 2]
                    _raise_bounds(triangle, stack, reference, face, other, through, bounds, off)
    difference, first, second = drained(waiting, queued, difference, first, second)
    return volume, area, difference, first, second
