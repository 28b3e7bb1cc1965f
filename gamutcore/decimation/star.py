"""The geometry of one collapse: which positions of the new vertex keep the mesh star-shaped.

Positions here are relative to the centre, so a face (p0, p1, p2) sees the centre from inside when
det(p0, p1, p2) > 0. Replacing an edge by one vertex changes only the faces around its two ends: the
next level is valid if the link condition holds (Dey, Edelsbrunner, Guha & Nekhayev, "Topology
Preserving Edge Contraction", 1999) and every face that remains around the new vertex has a
positive determinant. Only the direction of the new vertex matters for that, not its radius.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray, LongArray
from gamutcore.corner_table import following, preceding, swing
from gamutcore.kernels import kernel, leaf_kernel
from gamutcore.star_shape import sees_centre

__all__ = [
    "Surface",
    "keeps_star_shape",
    "kernel_direction",
    "link_condition_holds",
    "ring_faces",
    "scale_to_preserve_volume",
    "star_volume",
    "surface_of",
    "vertex_ring",
    "volume_slope",
]


class Surface(NamedTuple):
    """A mesh while it is being decimated.

    Attributes
    ----------
    position : (V, 3) float64
        Positions relative to the centre.
    vertex, opposite : (3 F,) int32
        The corner table.
    swung : (3 F,) int32
        The next corner around the same vertex: `swing` of every corner, because a walk around a
        vertex waits for each of its steps.
    corner_at : (V,) int32
        Some corner at each vertex.
    degree : (V,) int32
        Number of edges at each vertex.
    edge_of : (3 F,) int32
        The edge that a corner faces.
    corner_facing : (E,) int32
        One of the two corners that face an edge; −1: the edge is gone.
    mark : (V,) int64
        Scratch: the last query that touched a vertex.
    deficit : (2,) float64
        Six times the volume that is missing to the one to be preserved: now, and at most so far,
        whether too little or too much.
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
    """Arrange a closed mesh for decimation.

    Parameters
    ----------
    positions : (V, 3) float64
        Relative to the centre.
    faces : (F, 3) int32
    opposite : (3 F,) int32
        Of a closed mesh: no −1.

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
def link_condition_holds(surface: Surface, kept: int, dead: int, query: int) -> bool:
    """Whether the ends of an edge have exactly the two neighbours in common that its faces name.

    `query` is a number not used before, for marking.
    """
    mark, vertex = surface.mark, surface.vertex
    first = surface.corner_at[kept]
    corner = first
    while True:
        mark[vertex[following(corner)]] = query
        corner = surface.swung[np.uint64(corner)]
        if corner == first:
            break
    common = 0
    first = surface.corner_at[dead]
    corner = first
    while True:
        if mark[vertex[following(corner)]] == query:
            common += 1
        corner = surface.swung[np.uint64(corner)]
        if corner == first:
            break
    return common == 2


@leaf_kernel
def ring_faces(surface: Surface, kept: int, dead: int, ring: IndexArray) -> int:
    """Write the directed link of an edge: vertex pairs that the new vertex will form faces with.

    Parameters
    ----------
    surface : Surface
    kept, dead : int
        The ends of the edge.
    ring : (m, 2) int32
        Receives the pairs, in no particular order. Pairs beyond m are not written.

    Returns
    -------
    int
        Number of pairs; more than m if the ring was too short for them.
    """
    vertex = surface.vertex
    count = 0
    for end in range(2):
        centre, other = (kept, dead) if end == 0 else (dead, kept)
        first = surface.corner_at[centre]
        corner = first
        while True:
            one, two = vertex[following(corner)], vertex[preceding(corner)]
            if one != other and two != other:
                if count < len(ring):
                    ring[count, 0] = one
                    ring[count, 1] = two
                count += 1
            corner = surface.swung[np.uint64(corner)]
            if corner == first:
                break
    return count


@leaf_kernel
def vertex_ring(surface: Surface, centre: int, ring: IndexArray) -> int:
    """Write the directed link of a vertex; parameters and result as for `ring_faces`."""
    count = 0
    first = surface.corner_at[centre]
    corner = first
    while True:
        if count < len(ring):
            ring[count, 0] = surface.vertex[following(corner)]
            ring[count, 1] = surface.vertex[preceding(corner)]
        count += 1
        corner = surface.swung[np.uint64(corner)]
        if corner == first:
            break
    return count


@leaf_kernel
def keeps_star_shape(
    position: FloatArray, ring: IndexArray, count: int, x: float, y: float, z: float
) -> bool:
    """Whether all faces between a new vertex at (x, y, z) and the ring's pairs see the centre."""
    for pair in range(count):
        one, two = ring[pair, 0], ring[pair, 1]
        ax, ay, az = position[one, 0], position[one, 1], position[one, 2]
        bx, by, bz = position[two, 0], position[two, 1], position[two, 2]
        if not sees_centre(ax, ay, az, bx, by, bz, x, y, z):
            return False
    return True


@leaf_kernel
def volume_slope(position: FloatArray, ring: IndexArray, count: int, slope: FloatArray) -> None:
    """Write the vector g: a vertex at x encloses the volume g·x ÷ 6 with the ring and the centre.

    Parameters
    ----------
    position : (V, 3) float64
    ring : (m, 2) int32
        The directed link, `count` pairs of it.
    count : int
    slope : (3,) float64
        Receives the sum of the pairs' cross products.
    """
    gx, gy, gz = 0.0, 0.0, 0.0
    for pair in range(count):
        one, two = ring[pair, 0], ring[pair, 1]
        ax, ay, az = position[one, 0], position[one, 1], position[one, 2]
        bx, by, bz = position[two, 0], position[two, 1], position[two, 2]
        gx += ay * bz - az * by
        gy += az * bx - ax * bz
        gz += ax * by - ay * bx
    slope[0], slope[1], slope[2] = gx, gy, gz


@leaf_kernel
def star_volume(surface: Surface, kept: int, dead: int) -> float:
    """Six times the volume between the centre and the faces around an edge."""
    position, vertex = surface.position, surface.vertex
    total = 0.0
    for end in range(2):
        centre, other = (kept, dead) if end == 0 else (dead, kept)
        x, y, z = position[centre, 0], position[centre, 1], position[centre, 2]
        first = surface.corner_at[centre]
        corner = first
        while True:
            one, two = vertex[following(corner)], vertex[preceding(corner)]
            # the two faces at the edge itself belong to both stars: counted once, with `kept`
            if end == 0 or (one != other and two != other):
                ax, ay, az = position[one, 0], position[one, 1], position[one, 2]
                bx, by, bz = position[two, 0], position[two, 1], position[two, 2]
                total += x * (ay * bz - az * by) + y * (az * bx - ax * bz) + z * (ax * by - ay * bx)
            corner = surface.swung[np.uint64(corner)]
            if corner == first:
                break
    return total


@leaf_kernel
def scale_to_preserve_volume(
    surface: Surface,
    kept: int,
    dead: int,
    slope: FloatArray,
    place: FloatArray,
) -> bool:
    """Move a new vertex along its radius to where the enclosed volume is the one to be preserved.

    The star's volume is linear in the radius of its vertex, so there is exactly one such place;
    it lies in front of the centre for every direction that keeps the star shape. A deficit that is
    more than half of the star's volume cannot be paid back here, and is left to others.

    Parameters
    ----------
    surface : Surface
    kept, dead : int
        The ends of the edge that the vertex replaces.
    slope : (3,) float64
        `volume_slope` of the edge's link.
    place : (3,) float64
        A position relative to the centre; scaled.

    Returns
    -------
    bool
        Whether there is such a place; `place` is left alone if not.
    """
    volume = place[0] * slope[0] + place[1] * slope[1] + place[2] * slope[2]
    whole = star_volume(surface, kept, dead)
    wanted = whole + surface.deficit[0]
    scale = (wanted if wanted > 0.5 * whole else whole) / volume
    if not (scale > 0.0 and scale < np.inf):
        return False
    place[0], place[1], place[2] = scale * place[0], scale * place[1], scale * place[2]
    return True


@leaf_kernel
def kernel_direction(
    position: FloatArray, ring: IndexArray, count: int, direction: FloatArray
) -> bool:
    """Find a direction well inside the cone of those that keep the star shape.

    The cone is the intersection of the half-spaces n·x > 0 with n = a × b for each directed pair
    (a, b) of the ring. Its deepest direction maximises the smallest n·x / |n|; it is approached by
    the perceptron's rule with diminishing steps, each towards the most violated half-space, which
    converges whenever the cone has an inside (Rosenblatt 1962; Novikoff 1962 for the bound).

    Parameters
    ----------
    position : (V, 3) float64
    ring : (m, 2) int32
    count : int
    direction : (3,) float64
        Starting direction; receives the unit vector found.

    Returns
    -------
    bool
        Whether one was found.
    """
    x, y, z = direction[0], direction[1], direction[2]
    best = 0.0
    for step in range(200):
        length = np.sqrt(x * x + y * y + z * z)
        if not length > 0.0:
            return best > 0.0
        x, y, z = x / length, y / length, z / length
        least, nx, ny, nz = np.inf, 0.0, 0.0, 0.0
        for pair in range(count):
            one, two = ring[pair, 0], ring[pair, 1]
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
        # overshooting the most violated plane a little leads inside instead of onto it
        stride = max(-2.0 * least, 0.5 / (step + 2.0))
        x, y, z = x + stride * nx, y + stride * ny, z + stride * nz
    return best > 0.0
