"""Triangle meshes: arrays, device values, validity, grid of coordinates and corner table.

The surface of a gamut is a closed, oriented mesh of genus 0 whose faces all see the centre from
inside. `TriangleMesh.validity` checks each of these properties from the arrays alone, so it can
judge the results of all other modules.

The coordinates are whole multiples of a power of two, the step of the grid. The step is below
10⁻³ ΔE in CIELAB, and its multiples are exact in float32. A boundary rounds its points before any
test. Decimation rounds again, without effect on rounded points. Histories, levels and the validity
test therefore have the same numbers.

The corner table is the connectivity of a mesh as two flat integer arrays. Corner ``c = 3 f + i`` is
the i-th corner of face f, and ``vertex[c]`` is its vertex. ``opposite[c]`` is the corner of the
neighbouring face across the edge between the other two corners (Rossignac, Safonova & Szymczak,
"3D Compression Made Simple: Edgebreaker on a Corner-Table", 2001). Traversal is index arithmetic:
`next_corner` and `previous_corner` within a face, `swing` around a vertex.
"""

from __future__ import annotations

import math
import threading
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from gamutcore.arrays import FloatArray, IndexArray
from gamutcore.errors import MeshError
from gamutcore.geometry.curves import grouped
from gamutcore.kernels import kernel, leaf_kernel

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from gamutcore.arrays import PositionArray

__all__ = [
    "DeviceValues",
    "TriangleMesh",
    "Validity",
    "connected_components",
    "grid_step",
    "imported_trimesh",
    "mesh_grid_step",
    "nearest_grid_points",
    "next_corner",
    "opposite_corners",
    "previous_corner",
    "swing",
    "vertex_fans",
]


@dataclass(frozen=True, eq=False)
class DeviceValues:
    """The values of the channels of a device, vertex by vertex.

    Parameters
    ----------
    channels : tuple of str
        Names of the k channels (inks or lights), as in the characterisation data.
    values : (m, k) float
        From 0 to 1.

    Raises
    ------
    MeshError
        The array has another shape, or values outside 0 to 1.
    """

    channels: tuple[str, ...]
    values: PositionArray

    def __post_init__(self) -> None:
        values = np.asarray(self.values)
        if values.ndim != 2 or not 0 < values.shape[1] == len(self.channels):
            raise MeshError(
                f"Device values of {len(self.channels)} channels have the shape {values.shape}.",
                where={"field": "values"},
                remedy="Give an (m, k) array and the names of its k ≥ 1 channels.",
            )
        if values.dtype.kind != "f" or not ((values >= 0) & (values <= 1)).all():
            raise MeshError(
                "The device values are not all numbers from 0 to 1.",
                where={"field": "values"},
                remedy="Give fractions of full scale, as floats.",
            )

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, DeviceValues)
            and self.channels == other.channels
            and np.array_equal(self.values, other.values)
        )

    __hash__ = None  # type: ignore[assignment]  # arrays are mutable

    def __len__(self) -> int:
        """Return the number of vertices."""
        return len(self.values)


@dataclass(frozen=True)
class Validity:
    """The properties of a mesh, one by one.

    Attributes
    ----------
    finite : bool
        All coordinates are finite.
    closed : bool
        Every directed edge has its opposite exactly once: closed and consistently oriented.
    manifold : bool
        The faces around every vertex form a single cycle, and every vertex is used.
    connected : bool
        The mesh is one piece.
    euler_characteristic : int
        Vertices − edges + faces; 2 for genus 0.
    degenerate_faces : int
        Faces that name a vertex twice or have no area.
    duplicate_faces : int
        Faces with the same three vertices as another face.
    minimum_determinant : float or None
        Smallest det(p0 − c, p1 − c, p2 − c) of all faces; None without a centre.
    """

    finite: bool
    closed: bool
    manifold: bool
    connected: bool
    euler_characteristic: int
    degenerate_faces: int
    duplicate_faces: int
    minimum_determinant: float | None

    @property
    def star_shaped(self) -> bool:
        """Whether every face sees the centre from inside; False without a centre."""
        return self.minimum_determinant is not None and self.minimum_determinant > 0

    @property
    def is_sphere(self) -> bool:
        """Whether the mesh is a closed oriented 2-manifold of genus 0 with no faulty face."""
        return (
            self.finite
            and self.closed
            and self.manifold
            and self.connected
            and self.euler_characteristic == 2
            and self.degenerate_faces == 0
            and self.duplicate_faces == 0
        )

    @property
    def is_gamut(self) -> bool:
        """Whether the mesh is a sphere and star-shaped: all invariants of a level."""
        return self.is_sphere and self.star_shaped


@dataclass(frozen=True, eq=False)
class TriangleMesh:
    """Vertices, and triangles that are counter-clockwise seen from outside.

    Parameters
    ----------
    vertices : (m, 3) float
        Coordinates in the order of the colour space, (L*, a*, b*) for CIELAB.
    faces : (n, 3) int
        Indices of vertices.
    device : DeviceValues, optional
        Device values of the colours at the m vertices.

    Raises
    ------
    MeshError
        The arrays have other shapes, or an index is out of range.

    Examples
    --------
    >>> corners = np.vstack([np.zeros(3), np.eye(3)])
    >>> faces = np.array([(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)])
    >>> mesh = TriangleMesh(corners, faces)
    >>> round(6 * mesh.volume, 9), mesh.validity((0.1, 0.1, 0.1)).is_gamut
    (1.0, True)
    """

    vertices: PositionArray
    faces: IndexArray
    device: DeviceValues | None = None

    def __post_init__(self) -> None:
        vertices, faces = np.asarray(self.vertices), np.asarray(self.faces)
        if vertices.ndim != 2 or vertices.shape[1] != 3 or vertices.dtype.kind not in "fiu":
            raise MeshError(
                f"The vertices have the shape {vertices.shape} and the type {vertices.dtype}.",
                where={"field": "vertices"},
                remedy="Give an (m, 3) array of numbers.",
            )
        if faces.ndim != 2 or faces.shape[1] != 3 or faces.dtype.kind not in "iu":
            raise MeshError(
                f"The faces have the shape {faces.shape} and the type {faces.dtype}.",
                where={"field": "faces"},
                remedy="Give an (n, 3) array of vertex indices.",
            )
        if faces.size and (faces.min() < 0 or faces.max() >= len(vertices)):
            raise MeshError(
                f"A face names a vertex outside 0 to {len(vertices) - 1}.",
                where={"field": "faces"},
                remedy="Give indices of the vertices.",
            )
        if self.device is not None and len(self.device) != len(vertices):
            raise MeshError(
                f"The device values have {len(self.device)} rows for {len(vertices)} vertices.",
                where={"field": "device"},
                remedy="Give one row for each vertex.",
            )
        if vertices.dtype.kind != "f":
            object.__setattr__(self, "vertices", vertices.astype(np.float64))

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, TriangleMesh)
            and np.array_equal(self.vertices, other.vertices)
            and np.array_equal(self.faces, other.faces)
            and self.device == other.device
        )

    __hash__ = None  # type: ignore[assignment]  # arrays are mutable

    @property
    def triangles(self) -> int:
        """Number of faces."""
        return len(self.faces)

    def corners(self, origin: ArrayLike = (0.0, 0.0, 0.0)) -> tuple[FloatArray, ...]:
        """Return the positions of the three corners of every face relative to an origin.

        Parameters
        ----------
        origin : (3,) array_like
            Subtracted in double precision.

        Returns
        -------
        tuple of three (n, 3) float64 arrays
        """
        relative = self.vertices.astype(np.float64) - np.asarray(origin, np.float64)
        return relative[self.faces[:, 0]], relative[self.faces[:, 1]], relative[self.faces[:, 2]]

    def determinants(self, centre: ArrayLike) -> FloatArray:
        """Return det(p0 − c, p1 − c, p2 − c) of every face about a centre c.

        A determinant is six times the signed volume of the tetrahedron of the face and the centre.

        Parameters
        ----------
        centre : (3,) array_like

        Returns
        -------
        (n,) float64
        """
        a, b, c = self._corner_columns(centre)
        return np.asarray(
            a[0] * (b[1] * c[2] - b[2] * c[1])
            + a[1] * (b[2] * c[0] - b[0] * c[2])
            + a[2] * (b[0] * c[1] - b[1] * c[0])
        )

    def _corner_columns(self, origin: ArrayLike) -> tuple[FloatArray, ...]:
        """Return `corners` as three (3, n) arrays, on which sums take a quarter of the time."""
        relative = self.vertices.astype(np.float64) - np.asarray(origin, np.float64)
        columns = np.ascontiguousarray(relative.T)
        one, two, three = (np.take(columns, corner, axis=1) for corner in self.faces.T)
        return one, two, three

    @property
    def volume(self) -> float:
        """Enclosed volume in cubic units; positive if the faces are oriented outwards."""
        origin = (
            self.vertices.astype(np.float64).mean(axis=0) if len(self.vertices) else np.zeros(3)
        )
        return float(self.determinants(origin).sum() / 6.0)

    @property
    def area(self) -> float:
        """Surface area in square units."""
        first, second, third = self._corner_columns((0.0, 0.0, 0.0))
        second -= first
        third -= first
        square = np.zeros(self.triangles)
        for i, j in ((1, 2), (2, 0), (0, 1)):
            square += (second[i] * third[j] - second[j] * third[i]) ** 2
        return float(np.sqrt(square).sum() / 2.0)

    @property
    def bounds(self) -> FloatArray:
        """Smallest and largest coordinates, (2, 3)."""
        columns = np.ascontiguousarray(self.vertices.T, np.float64)  # for a fast search in each
        return np.stack([columns.min(axis=1), columns.max(axis=1)])

    def validity(self, centre: ArrayLike | None = None) -> Validity:
        """Return which invariants of a level hold, judged from the arrays alone.

        Parameters
        ----------
        centre : (3,) array_like, optional
            Point about which the mesh should be star-shaped.

        Returns
        -------
        Validity
        """
        faces = self.faces.astype(np.int64)
        count = len(self.vertices)
        starts, ends = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
        forward, backward = starts * count + ends, ends * count + starts
        by_edge, by_opposite = np.argsort(forward), np.argsort(backward)
        edges = forward[by_edge]
        closed = bool(
            len(edges) > 0
            and (np.diff(edges) > 0).all()
            and np.array_equal(edges, backward[by_opposite])
        )
        manifold, connected = False, False
        if closed:
            opposite = np.empty_like(by_edge)
            opposite[by_opposite] = by_edge
            manifold, connected = _vertex_cycles(faces, count, opposite)
        first, second, third = self.corners()
        areas = np.linalg.norm(np.cross(second - first, third - first), axis=1)
        named_twice = (faces == np.roll(faces, -1, axis=1)).any(axis=1)
        low, middle, high = np.sort(faces, axis=1).T
        pairs = low * count + middle
        by_corners = np.lexsort((high, pairs))
        same = (np.diff(pairs[by_corners]) == 0) & (np.diff(high[by_corners]) == 0)
        return Validity(
            finite=bool(np.isfinite(self.vertices).all()),
            closed=closed,
            manifold=manifold,
            connected=connected,
            euler_characteristic=count - len(edges) // 2 + len(faces),
            degenerate_faces=int((named_twice | ~(areas > 0)).sum()),
            duplicate_faces=int(same.sum()),
            minimum_determinant=(
                None if centre is None else float(self.determinants(centre).min(initial=np.inf))
            ),
        )

    def to_trimesh(self) -> Any:  # noqa: ANN401  # trimesh has no type stubs
        """Return a `trimesh.Trimesh` of the same vertices and faces, none merged or reordered."""
        return imported_trimesh().Trimesh(self.vertices, self.faces, process=False, validate=False)


def connected_components(
    left: NDArray[np.int64], right: NDArray[np.int64], count: int
) -> tuple[int, NDArray[np.int32]]:
    """Return the number of connected components of an undirected graph, and each node's label.

    `left` and `right` (e,) are the nodes of each edge, from 0 to `count` − 1.
    """
    from scipy.sparse import coo_array, csgraph  # noqa: PLC0415  # 0.2 s and 15 MB; builds need it

    graph = coo_array((np.ones(len(left), np.int8), (left, right)), shape=(count, count))
    components, label = csgraph.connected_components(graph, directed=False)
    return int(components), label


def _vertex_cycles(
    faces: NDArray[np.int64], count: int, opposite: NDArray[np.int64]
) -> tuple[bool, bool]:
    """Whether the corners at each vertex form one cycle, and whether the faces form one piece.

    An edge starts at each corner; `opposite` is the start corner of the same edge in the other
    direction. The next corner around a vertex is that of the edge that ends here.
    """
    corners = np.arange(faces.size).reshape(faces.shape)
    following = opposite[np.roll(corners, 1, axis=1).ravel()]
    used = np.zeros(count, np.bool_)
    used[faces] = True
    manifold = bool(used.all()) and _cycle_count(following) == count
    # every face has three neighbours, each of which has it as a neighbour
    from scipy.sparse import csgraph, csr_array  # noqa: PLC0415  # see `connected_components`

    neighbours = opposite // 3, np.arange(0, faces.size + 1, 3)
    weights = np.ones(faces.size, np.float64)
    graph: csr_array[np.float64, tuple[int, int]] = csr_array(
        (weights, *neighbours), shape=(len(faces), len(faces))
    )
    graph.sum_duplicates()  # faces that share two edges; the search would not end
    pieces, _ = csgraph.connected_components(graph, connection="strong")
    return manifold, int(pieces) == 1


def _cycle_count(following: NDArray[np.int64]) -> int:
    """Return the number of cycles of a permutation.

    After k rounds, `least` is the least of 2ᵏ consecutive elements. Once a round changes nothing,
    it is the least of the whole cycle.
    """
    itself = np.arange(len(following))
    least, ahead = np.minimum(itself, following), following
    while True:
        ahead = ahead[ahead]
        further = np.minimum(least, least[ahead])
        if np.array_equal(further, least):
            return int((least == itself).sum())
        least = further


_IMPORTING = threading.Lock()


def imported_trimesh() -> Any:  # noqa: ANN401  # trimesh has no type stubs
    """Return the module trimesh, a heavy import that only the exchange of meshes needs.

    Its modules import one another. Two threads that begin with different modules would meet
    incomplete ones, so one thread imports all.
    """
    with _IMPORTING:
        import trimesh.exchange.obj  # noqa: PLC0415
        import trimesh.exchange.ply  # noqa: PLC0415
        import trimesh.exchange.stl  # noqa: PLC0415

        return trimesh


STEPS_PER_EXTENT = 18
"""Binary logarithm of the number of steps in the power of two that is not below the extent.
Lightness extends over 64 to 128 units in gamuts of devices, which gives a step of 2⁻¹² to 2⁻¹¹ <
10⁻³ ΔE. Thinner sets of points have finer steps, because a shift changes their volume more."""

MIDDLE = 0.9
"""Share of the points that determines the extent along an axis. A few outliers must not coarsen the
grid of the other points."""

MANTISSA = 24
"""Bits of the mantissa of a float32: whole numbers up to 2²⁴ are exact."""

ROOM = 2
"""Spare bits for vertices that decimation moves outside the original surface. The last four
triangles of a sphere reach to three times its radius."""

FINEST = 2.0**-149
"""The smallest positive float32."""


def grid_step(points: ArrayLike) -> float:
    """Return the step of the grid for at least one finite point (n, 3).

    It is 2⁻¹⁸ of the power of two that is not below the smallest extent along an axis. Where
    float32 resolves only coarser steps at the largest coordinate, the finest of these is the step.
    """
    array = np.asarray(points, np.float64)
    lowest, highest = np.quantile(array, ((1 - MIDDLE) / 2, (1 + MIDDLE) / 2), axis=0)
    extent = float((highest - lowest).min())
    return max(_power_of_two_above(extent) * 2.0**-STEPS_PER_EXTENT, _float32_step(array))


def mesh_grid_step(vertices: ArrayLike) -> float:
    """Return the step of the grid for vertices (m, 3) that may be on a grid already.

    It is `grid_step`, or the largest power of two that divides all coordinates if that is smaller.
    It is never finer than float32 resolves at four times the largest coordinate.
    """
    array = np.asarray(vertices, np.float64)
    finest = _float32_step(array)
    bits = int(np.bitwise_or.reduce(np.rint(array / finest).astype(np.int64), axis=None))
    own = finest * (bits & -bits)
    return min(grid_step(array), own) if own > 0 else grid_step(array)


def nearest_grid_points(points: ArrayLike, step: float) -> FloatArray:
    """Return the nearest points on a grid, exact in float32 if the step is that of `grid_step`.

    Halves round to even, and there are no negative zeros.
    """
    return np.asarray(np.rint(np.asarray(points, np.float64) / step) * step + 0.0)


def _float32_step(points: FloatArray) -> float:
    """Finest step at which float32 is exact up to four times the largest coordinate."""
    return max(_power_of_two_above(float(np.abs(points).max())) * 2.0 ** (ROOM - MANTISSA), FINEST)


def _power_of_two_above(value: float) -> float:
    """Smallest power of two that is not below a value; 0 for 0."""
    if value == 0.0:
        return 0.0
    mantissa, exponent = math.frexp(value)
    return math.ldexp(1.0, exponent - 1 if mantissa == 0.5 else exponent)


UNKNOWN, TWICE = -1, -2
"""Marks of an edge without a known counterpart, and of an edge with several."""

ZERO, TWO, THREE = np.uint64(0), np.uint64(2), np.uint64(3)
"""Unsigned, because the remainder of a signed number takes three times the instructions."""


@leaf_kernel
def next_corner(corner: int) -> int:
    """Return the next corner of the same face, counter-clockwise."""
    return corner - 2 if np.uint64(corner) % THREE == TWO else corner + 1


@leaf_kernel
def previous_corner(corner: int) -> int:
    """Return the previous corner of the same face."""
    return corner + 2 if np.uint64(corner) % THREE == ZERO else corner - 1


@leaf_kernel
def swing(opposite: IndexArray, corner: int) -> int:
    """Return the corner at the same vertex in the next face around it."""
    return next_corner(opposite[next_corner(corner)])


@leaf_kernel
def _counterpart(end_of: IndexArray, facing: IndexArray, begin: int, end: int, start: int) -> int:
    """Corner facing the only edge, among the edges from a vertex, that ends at `start`; or −1."""
    found, matches = -1, 0
    for edge in range(begin, end):
        if end_of[edge] == start:
            found = facing[edge]
            matches += 1
    return found if matches == 1 else -1


@kernel
def vertex_fans(corner: IndexArray, vertices: int) -> tuple[IndexArray, IndexArray]:
    """Return the faces around each vertex as start (vertices + 1,) and faces (3 F,), ascending.

    `corner` (3 F,) has the vertex of every corner.
    """
    start, corners = grouped(corner, vertices)
    return start, corners // np.int32(3)


@kernel
def opposite_corners(faces: IndexArray, vertex_count: int) -> IndexArray:
    """Return the opposite corner (3 n,) of every corner of a closed, oriented mesh.

    It is −1 where an edge has no counterpart in the opposite direction, or several. The mesh is
    then not a closed, oriented manifold.
    """
    count, vertex = 3 * len(faces), np.ascontiguousarray(faces).reshape(-1)
    # edges grouped by their start vertex: the end vertex and the corner facing the edge
    offset, facing = grouped(vertex, vertex_count)
    end_of = np.empty(count, np.int32)
    for edge in range(count):
        end_of[edge] = vertex[next_corner(facing[edge])]
        facing[edge] = previous_corner(facing[edge])
    opposite = np.full(count, UNKNOWN, np.int32)
    for start in range(vertex_count):
        here = offset[start + 1] - offset[start]
        for edge in range(offset[start], offset[start + 1]):
            end = end_of[edge]
            # search at the end with fewer edges: a vertex with many would be searched many times
            there = offset[end + 1] - offset[end]
            if there > here or (there == here and end < start):  # found from the other end
                continue
            found = _counterpart(end_of, facing, offset[end], offset[end + 1], start)
            if found >= 0:
                opposite[facing[edge]] = found
                # an edge used twice in one direction is found twice from its counterpart
                known = opposite[found] != UNKNOWN and found != facing[edge]
                opposite[found] = TWICE if known else facing[edge]
    for corner in range(count):
        if opposite[corner] < 0 or opposite[opposite[corner]] != corner:
            opposite[corner] = -1
    return opposite
