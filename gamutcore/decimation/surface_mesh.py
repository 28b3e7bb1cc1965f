"""The mesh that is decimated, and which positions of a new vertex keep it star-shaped.

Positions are relative to the centre, so a face (p0, p1, p2) sees the centre from inside when
det(p0, p1, p2) > 0. A collapse changes only the faces around the two ends of its edge. The next
level is valid under two conditions. The link condition holds (Dey, Edelsbrunner, Guha & Nekhayev,
"Topology Preserving _Edge Contraction", 1999), and every face around the new vertex has a positive
determinant. The determinants depend on the direction of the new vertex only, not on its radius.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray, LongArray
from gamutcore.geometry import (
    Vector,
    cross,
    dot,
    minus,
    next_corner,
    plus,
    previous_corner,
    row,
    sees_centre,
    swing,
    triple,
)
from gamutcore.kernels import kernel, leaf_kernel

DEFICIT_NOW, DEFICIT_LARGEST = range(2)
"""Indices into `SurfaceMesh.deficit`: volume missing at this level; its largest value so far."""


class SurfaceMesh(NamedTuple):
    """A closed mesh while it is decimated: V vertices, F faces and E edges of the first level."""

    position: FloatArray  # (V, 3), relative to the centre
    vertex: IndexArray  # (3 F,) corner table: the vertex at a corner
    opposite: IndexArray  # (3 F,) corner table: the corner across the facing edge
    # (3 F,) the next corner around the same vertex, `swing` of every corner; stored because a walk
    # around a vertex waits for each of its steps
    swing: IndexArray
    corner_at: IndexArray  # (V,) some corner at each vertex
    degree: IndexArray  # (V,) number of edges at each vertex
    edge_of: IndexArray  # (3 F,) the edge that a corner faces
    corner_facing: IndexArray  # (E,) one of the two corners that face an edge; −1 if it is removed
    mark: LongArray  # (V,) scratch: the last query of the link condition that visited a vertex
    queries: LongArray  # (1,) number of these queries
    deficit: FloatArray  # (2,) six times the volume that the level lacks, by `DEFICIT_…`


@kernel
def surface_of(positions: FloatArray, faces: IndexArray, opposite: IndexArray) -> SurfaceMesh:
    """Return a closed mesh (`opposite` has no −1) with the connectivity that decimation needs."""
    vertex = faces.copy().ravel()
    corner_at = np.empty(len(positions), np.int32)
    edge_of = np.empty(vertex.size, np.int32)
    corner_facing = np.empty(vertex.size // 2, np.int32)
    swings = np.empty(vertex.size, np.int32)
    edges = 0
    degree = np.zeros(len(positions), np.int32)
    for corner in range(vertex.size):
        corner_at[vertex[corner]] = corner
        degree[vertex[corner]] += 1
        swings[corner] = swing(opposite, corner)
        if corner < opposite[corner]:
            edge_of[corner] = edges
            edge_of[opposite[corner]] = edges
            corner_facing[edges] = corner
            edges += 1
    return SurfaceMesh(
        positions.copy(),
        vertex,
        opposite.copy(),
        swings,
        corner_at,
        degree,
        edge_of,
        corner_facing,
        np.zeros(len(positions), np.int64),
        np.zeros(1, np.int64),
        np.zeros(2, np.float64),
    )


@leaf_kernel
def edge_ends(surface: SurfaceMesh, edge: int) -> tuple[int, int, int]:
    """Return one of the two corners that face an edge, and the two ends of the edge."""
    corner = int(surface.corner_facing[edge])
    return (
        corner,
        int(surface.vertex[next_corner(corner)]),
        int(surface.vertex[previous_corner(corner)]),
    )


@leaf_kernel
def squared_length(surface: SurfaceMesh, corner: int) -> float:
    """Squared length of the edge that a corner faces."""
    one, two = surface.vertex[next_corner(corner)], surface.vertex[previous_corner(corner)]
    along = minus(row(surface.position, one, 0), row(surface.position, two, 0))
    return dot(along, along)


LARGEST_LINK = 64
"""Longer links are not collapsed in sweeps, evaluated by samples, or moved: they take too long, and
their edges would not be among the cheapest."""


@leaf_kernel
def link_condition_holds(surface: SurfaceMesh, kept: int, dead: int) -> bool:
    """Whether the ends of an edge have exactly two common neighbours."""
    mark, vertex = surface.mark, surface.vertex
    surface.queries[0] += 1
    query, common = surface.queries[0], 0
    corner = int(surface.corner_at[kept])
    for _ in range(surface.degree[kept]):
        mark[vertex[next_corner(corner)]] = query
        corner = int(surface.swing[np.uint64(corner)])
    corner = int(surface.corner_at[dead])
    for _ in range(surface.degree[dead]):
        if mark[vertex[next_corner(corner)]] == query:
            common += 1
        corner = int(surface.swing[np.uint64(corner)])
    return common == 2


@leaf_kernel
def _append_link(
    surface: SurfaceMesh, centre: int, other: int, link: IndexArray, count: int
) -> int:
    """Append the pairs of the faces around `centre` that do not contain `other`."""
    vertex, corner = surface.vertex, int(surface.corner_at[centre])
    for _ in range(surface.degree[centre]):
        one, two = vertex[next_corner(corner)], vertex[previous_corner(corner)]
        if one != other and two != other:
            link[count, 0] = one
            link[count, 1] = two
            count += 1
        corner = int(surface.swing[np.uint64(corner)])
    return count


@leaf_kernel
def write_edge_link(surface: SurfaceMesh, kept: int, dead: int, link: IndexArray) -> int:
    """Write the directed link of an edge, and return its number of pairs.

    The link is the vertex pairs that form faces with the new vertex, in no particular order. It
    needs room for the degrees of both ends.
    """
    return _append_link(surface, dead, kept, link, _append_link(surface, kept, dead, link, 0))


@leaf_kernel
def write_vertex_link(surface: SurfaceMesh, centre: int, link: IndexArray) -> int:
    """Write the directed link of a vertex, in order around it; return its number of pairs."""
    return _append_link(surface, centre, -1, link, 0)


@leaf_kernel
def keeps_star_shape(
    position: FloatArray, link: IndexArray, count: int, x: float, y: float, z: float
) -> bool:
    """Whether all faces between a new vertex at (x, y, z) and its link see the centre."""
    for pair in range(count):
        a, b = row(position, link[pair, 0], 0), row(position, link[pair, 1], 0)
        if not sees_centre(a, b, (x, y, z)):
            return False
    return True


@leaf_kernel
def volume_gradient(position: FloatArray, link: IndexArray, count: int) -> Vector:
    """Return the vector g such that a vertex at x encloses the volume g·x ÷ 6 with its link."""
    total = (0.0, 0.0, 0.0)
    for pair in range(count):
        side = cross(row(position, link[pair, 0], 0), row(position, link[pair, 1], 0))
        total = plus(total, side)
    return total


@leaf_kernel
def star_volume(surface: SurfaceMesh, kept: int, dead: int) -> float:
    """Six times the volume between the centre and the faces around an edge."""
    position, vertex = surface.position, surface.vertex
    total = 0.0
    for end in range(2):
        centre = kept if end == 0 else dead
        at = row(position, centre, 0)
        corner = int(surface.corner_at[centre])
        for _ in range(surface.degree[centre]):
            one, two = vertex[next_corner(corner)], vertex[previous_corner(corner)]
            # both stars contain the two faces at the edge: they are counted with `kept` only
            if end == 0 or (one != kept and two != kept):
                total += triple(row(position, one, 0), row(position, two, 0), at)
            corner = int(surface.swing[np.uint64(corner)])
    return total


@leaf_kernel
def scale_to_preserve_volume(
    surface: SurfaceMesh, kept: int, dead: int, link: IndexArray, count: int, point: FloatArray
) -> bool:
    """Move a new vertex along its radius to the point where the collapse preserves the volume.

    The volume of a star is linear in the radius of its vertex, so exactly one such point exists. It
    lies in front of the centre for every direction that keeps the star shape; otherwise the result
    is False. A deficit of more than half the volume of the star is left to other collapses.
    """
    gradient = volume_gradient(surface.position, link, count)
    whole = star_volume(surface, kept, dead)
    wanted = whole + surface.deficit[DEFICIT_NOW]
    volume = dot((point[0], point[1], point[2]), gradient)
    scale = (wanted if wanted > 0.5 * whole else whole) / volume
    if not (scale > 0.0 and scale < np.inf):
        return False
    for axis in range(3):
        point[axis] *= scale
    return True


MAXIMUM_STEPS = 200
"""Steps of the perceptron rule before the search for an inner direction ends."""


@leaf_kernel
def find_inner_direction(
    position: FloatArray, link: IndexArray, count: int, direction: FloatArray
) -> bool:
    """Find a direction well inside the cone of directions that keep the star shape; False if none.

    The cone is the intersection of half-spaces n·x > 0. Each directed pair (a, b) of the link has
    one, with n = a × b. The deepest direction maximises the smallest n·x / |n|. The perceptron rule
    with diminishing steps approaches it from `direction`: each step goes towards the most violated
    half-space. It converges whenever the cone has an interior (Rosenblatt 1962; Novikoff 1962 for
    the bound).
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
            side = cross(row(position, link[pair, 0], 0), row(position, link[pair, 1], 0))
            norm = np.sqrt(dot(side, side))
            if not norm > 0.0:
                return False
            depth = dot((x, y, z), side) / norm
            if depth < least:
                least, nx, ny, nz = depth, side[0] / norm, side[1] / norm, side[2] / norm
        if least > best:
            best = least
            direction[0], direction[1], direction[2] = x, y, z
        # a small overshoot beyond the most violated plane ends inside the cone, not on its side
        stride = max(-2.0 * least, 0.5 / (step + 2.0))
        x, y, z = x + stride * nx, y + stride * ny, z + stride * nz
    return best > 0.0
