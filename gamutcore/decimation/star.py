"""The geometry of one collapse: which positions of the new vertex keep the mesh star-shaped.

Positions are relative to the centre, so a face (p0, p1, p2) sees the centre from inside when
det(p0, p1, p2) > 0. A collapse changes only the faces around the two ends of its edge. The next
level is valid if the link condition holds (Dey, Edelsbrunner, Guha & Nekhayev, "Topology Preserving
Edge Contraction", 1999) and every face around the new vertex has a positive determinant. The
determinants depend on the direction of the new vertex only, not on its radius.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray, LongArray
from gamutcore.corner_table import following, preceding, swing
from gamutcore.kernels import kernel, leaf_kernel
from gamutcore.star_shape import sees_centre

__all__ = [
    "DEFICIT_LARGEST",
    "DEFICIT_NOW",
    "LARGEST_LINK",
    "Surface",
    "find_inner_direction",
    "keeps_star_shape",
    "link_condition_holds",
    "scale_to_preserve_volume",
    "squared_length",
    "star_volume",
    "surface_of",
    "write_edge_link",
    "write_vertex_link",
    "write_volume_gradient",
]

DEFICIT_NOW = 0
"""Index into `Surface.deficit`: volume missing at the present level."""

DEFICIT_LARGEST = 1
"""Index into `Surface.deficit`: largest absolute value so far."""

LARGEST_LINK = 64
"""Longer links are not collapsed in sweeps, evaluated by samples, or moved: they take too long, and
their edges would not be among the cheapest."""

MAXIMUM_STEPS = 200
"""Steps of the perceptron rule before the search for an inner direction ends."""


class Surface(NamedTuple):
    """A mesh while it is decimated.

    Attributes
    ----------
    position : (V, 3) float64
        Positions relative to the centre.
    vertex, opposite : (3 F,) int32
        The corner table.
    swung : (3 F,) int32
        The next corner around the same vertex: `swing` of every corner. A walk around a vertex
        waits for each of its steps, so the value is stored.
    corner_at : (V,) int32
        Some corner at each vertex.
    degree : (V,) int32
        Number of edges at each vertex.
    edge_of : (3 F,) int32
        The edge that a corner faces.
    corner_facing : (E,) int32
        One of the two corners that face an edge; −1 if the edge has been removed.
    mark : (V,) int64
        Scratch: the last query that visited a vertex.
    deficit : (2,) float64
        Six times the volume that the level lacks. Indexed by `DEFICIT_NOW`, `DEFICIT_LARGEST`.
    """

    position: FloatArray
    vertex: IndexArray
    opposite: IndexArray
    swung: IndexArray
    corner_at: IndexArray
    degree: IndexArray
    edge_of: IndexArray
    corner_facing: IndexArray
    mark: LongArray
    deficit: FloatArray


@kernel
def surface_of(positions: FloatArray, faces: IndexArray, opposite: IndexArray) -> Surface:
    """Return a closed mesh with the connectivity that decimation needs.

    Parameters
    ----------
    positions : (V, 3) float64
        Relative to the centre.
    faces : (F, 3) int32
    opposite : (3 F,) int32
        Opposite corners of a closed mesh: no −1.

    Returns
    -------
    Surface
    """
    vertex = faces.copy().ravel()
    corner_at = np.empty(len(positions), np.int32)
    edge_of = np.empty(vertex.size, np.int32)
    corner_facing = np.empty(vertex.size // 2, np.int32)
    swung = np.empty(vertex.size, np.int32)
    edges = 0
    degree = np.zeros(len(positions), np.int32)
    for corner in range(vertex.size):
        corner_at[vertex[corner]] = corner
        degree[vertex[corner]] += 1
        swung[corner] = swing(opposite, corner)
        if corner < opposite[corner]:
            edge_of[corner] = edges
            edge_of[opposite[corner]] = edges
            corner_facing[edges] = corner
            edges += 1
    mark = np.full(len(positions), -1, np.int64)
    return Surface(
        positions.copy(),
        vertex,
        opposite.copy(),
        swung,
        corner_at,
        degree,
        edge_of,
        corner_facing,
        mark,
        np.zeros(2, np.float64),
    )


@leaf_kernel
def squared_length(surface: Surface, corner: int) -> float:
    """Squared length of the edge that a corner faces."""
    position = surface.position
    one, two = surface.vertex[following(corner)], surface.vertex[preceding(corner)]
    x = position[one, 0] - position[two, 0]
    y = position[one, 1] - position[two, 1]
    z = position[one, 2] - position[two, 2]
    return x * x + y * y + z * z


@leaf_kernel
def link_condition_holds(surface: Surface, kept: int, dead: int, query: int) -> bool:
    """Whether the ends of an edge have exactly two common neighbours.

    Parameters
    ----------
    surface : Surface
    kept, dead : int
        The ends of the edge.
    query : int
        A number that no query has used before, for `Surface.mark`.

    Returns
    -------
    bool
    """
    mark, vertex = surface.mark, surface.vertex
    first = int(surface.corner_at[kept])
    corner = first
    while True:
        mark[vertex[following(corner)]] = query
        corner = int(surface.swung[np.uint64(corner)])
        if corner == first:
            break
    common = 0
    first = int(surface.corner_at[dead])
    corner = first
    while True:
        if mark[vertex[following(corner)]] == query:
            common += 1
        corner = int(surface.swung[np.uint64(corner)])
        if corner == first:
            break
    return common == 2


@leaf_kernel
def write_edge_link(surface: Surface, kept: int, dead: int, link: IndexArray) -> int:
    """Write the directed link of an edge: the vertex pairs that form faces with the new vertex.

    Parameters
    ----------
    surface : Surface
    kept, dead : int
        The ends of the edge.
    link : (m, 2) int32
        Receives the pairs, in no particular order. It must have room for the degrees of both ends.

    Returns
    -------
    int
        Number of pairs.
    """
    vertex = surface.vertex
    count = 0
    for end in range(2):
        centre, other = (kept, dead) if end == 0 else (dead, kept)
        first = int(surface.corner_at[centre])
        corner = first
        while True:
            one, two = vertex[following(corner)], vertex[preceding(corner)]
            if one != other and two != other:
                link[count, 0] = one
                link[count, 1] = two
                count += 1
            corner = int(surface.swung[np.uint64(corner)])
            if corner == first:
                break
    return count


@leaf_kernel
def write_vertex_link(surface: Surface, centre: int, link: IndexArray) -> int:
    """Write the directed link of a vertex. Parameters and result are as in `write_edge_link`."""
    count = 0
    first = int(surface.corner_at[centre])
    corner = first
    while True:
        link[count, 0] = surface.vertex[following(corner)]
        link[count, 1] = surface.vertex[preceding(corner)]
        count += 1
        corner = int(surface.swung[np.uint64(corner)])
        if corner == first:
            break
    return count


@leaf_kernel
def keeps_star_shape(
    position: FloatArray, link: IndexArray, count: int, x: float, y: float, z: float
) -> bool:
    """Whether all faces between a new vertex at (x, y, z) and its link see the centre."""
    for pair in range(count):
        one, two = link[pair, 0], link[pair, 1]
        ax, ay, az = position[one, 0], position[one, 1], position[one, 2]
        bx, by, bz = position[two, 0], position[two, 1], position[two, 2]
        if not sees_centre(ax, ay, az, bx, by, bz, x, y, z):
            return False
    return True


@leaf_kernel
def write_volume_gradient(
    position: FloatArray, link: IndexArray, count: int, gradient: FloatArray
) -> None:
    """Write the vector g such that a vertex at x encloses the volume g·x ÷ 6 with its link.

    Parameters
    ----------
    position : (V, 3) float64
    link : (m, 2) int32
        A directed link of `count` pairs.
    count : int
    gradient : (3,) float64
        Receives the sum of the pairs' cross products.
    """
    gx, gy, gz = 0.0, 0.0, 0.0
    for pair in range(count):
        one, two = link[pair, 0], link[pair, 1]
        ax, ay, az = position[one, 0], position[one, 1], position[one, 2]
        bx, by, bz = position[two, 0], position[two, 1], position[two, 2]
        gx += ay * bz - az * by
        gy += az * bx - ax * bz
        gz += ax * by - ay * bx
    gradient[0], gradient[1], gradient[2] = gx, gy, gz


@leaf_kernel
def star_volume(surface: Surface, kept: int, dead: int) -> float:
    """Six times the volume between the centre and the faces around an edge."""
    position, vertex = surface.position, surface.vertex
    total = 0.0
    for end in range(2):
        centre, other = (kept, dead) if end == 0 else (dead, kept)
        x, y, z = position[centre, 0], position[centre, 1], position[centre, 2]
        first = int(surface.corner_at[centre])
        corner = first
        while True:
            one, two = vertex[following(corner)], vertex[preceding(corner)]
            # both stars contain the two faces at the edge: they are counted with `kept` only
            if end == 0 or (one != other and two != other):
                ax, ay, az = position[one, 0], position[one, 1], position[one, 2]
                bx, by, bz = position[two, 0], position[two, 1], position[two, 2]
                total += x * (ay * bz - az * by) + y * (az * bx - ax * bz) + z * (ax * by - ay * bx)
            corner = int(surface.swung[np.uint64(corner)])
            if corner == first:
                break
    return total


@leaf_kernel
def scale_to_preserve_volume(
    surface: Surface, kept: int, dead: int, gradient: FloatArray, point: FloatArray
) -> bool:
    """Move a new vertex along its radius to the point where the collapse preserves the volume.

    The volume of a star is linear in the radius of its vertex, so exactly one such point exists.
    It lies in front of the centre for every direction that keeps the star shape. A deficit of more
    than half the volume of the star is left to other collapses.

    Parameters
    ----------
    surface : Surface
    kept, dead : int
        The ends of the edge that the vertex replaces.
    gradient : (3,) float64
        Volume gradient of the edge's link.
    point : (3,) float64
        A position relative to the centre; scaled.

    Returns
    -------
    bool
        False if no such point exists. `point` is then unchanged.
    """
    volume = point[0] * gradient[0] + point[1] * gradient[1] + point[2] * gradient[2]
    whole = star_volume(surface, kept, dead)
    wanted = whole + surface.deficit[DEFICIT_NOW]
    scale = (wanted if wanted > 0.5 * whole else whole) / volume
    if not (scale > 0.0 and scale < np.inf):
        return False
    point[0], point[1], point[2] = scale * point[0], scale * point[1], scale * point[2]
    return True


@leaf_kernel
def find_inner_direction(
    position: FloatArray, link: IndexArray, count: int, direction: FloatArray
) -> bool:
    """Find a direction well inside the cone of directions that keep the star shape.

    The cone is the intersection of the half-spaces n·x > 0 with n = a × b for each directed pair
    (a, b) of the link. Its deepest direction maximises the smallest n·x / |n|. The perceptron rule
    with diminishing steps approaches it: each step goes towards the most violated half-space. It
    converges whenever the cone has an interior (Rosenblatt 1962; Novikoff 1962 for the bound).

    Parameters
    ----------
    position : (V, 3) float64
    link : (m, 2) int32
    count : int
    direction : (3,) float64
        Starting direction; receives the unit vector found.

    Returns
    -------
    bool
        Whether a direction was found.
    """
    x, y, z = direction[0], direction[1], direction[2]
    best = 0.0
    for step in range(MAXIMUM_STEPS):
        length = np.sqrt(x * x + y * y + z * z)
        if not length > 0.0:
            return best > 0.0
        x, y, z = x / length, y / length, z / length
        least, nx, ny, nz = np.inf, 0.0, 0.0, 0.0
        for pair in range(count):
            one, two = link[pair, 0], link[pair, 1]
            ax, ay, az = position[one, 0], position[one, 1], position[one, 2]
            bx, by, bz = position[two, 0], position[two, 1], position[two, 2]
            cx, cy, cz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
            norm = np.sqrt(cx * cx + cy * cy + cz * cz)
            if not norm > 0.0:
                return False
            depth = (x * cx + y * cy + z * cz) / norm
            if depth < least:
                least, nx, ny, nz = depth, cx / norm, cy / norm, cz / norm
        if least > best:
            best = least
            direction[0], direction[1], direction[2] = x, y, z
        # a small overshoot beyond the most violated plane ends inside the cone, not on its side
        stride = max(-2.0 * least, 0.5 / (step + 2.0))
        x, y, z = x + stride * nx, y + stride * ny, z + stride * nz
    return best > 0.0
