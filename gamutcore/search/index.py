"""The index of a level: everything that searches look up, computed once.

Layout, plain arrays in a named tuple (`LevelIndex`):

- The mesh: vertices, faces and centre in float64. Levels are delivered in float32, so this is
  exact, and the answers are about the delivered mesh.
- The cones: for each face the three planes through its edges and the centre, and its own plane.
  Each is scaled so that rounding changes a product by less than 1. A product beyond ±1 therefore
  has a certain sign, and exact predicates decide the others (`gamutcore.search.containment`).
- The directions: the faces that each cell of a cube map meets (`gamutcore.geometry.cube_map`).
- Cylinders and boxes over the faces, in a tree (`gamutcore.search.face_tree`).
- The edges that may have cusps, and the faces of each sector of hues
  (`gamutcore.search.hue_tables`).
- The box around the mesh, and the radius of a ball inside; both decide most points alone.

The module also checks the arguments of all searches: shape, numbers, range. Errors name the row.
"""

from __future__ import annotations

import math
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from gamutcore.arrays import Float32Array, FloatArray, IndexArray
from gamutcore.errors import InvalidPointsError, MeshError
from gamutcore.geometry import (
    TriangleMesh,
    cross,
    direction_cells,
    dot,
    face_corners,
    faces_not_seeing_centre,
    opposite_corners,
    plus,
    row,
    scaled,
    write_row,
)
from gamutcore.kernels import kernel
from gamutcore.number_text import number_text
from gamutcore.search.face_tree import FaceTree, build_face_tree, face_boxes
from gamutcore.search.hue_tables import CuspTable, HueTable, cusp_table, hue_table

__all__ = [
    "LARGEST_COORDINATE",
    "Level",
    "LevelIndex",
    "as_index",
    "build_index",
    "checked_numbers",
    "checked_points",
    "surface_points",
]

CELLS_PER_FACE = 2.0
"""Cells of the cube map ÷ faces. With more cells, queries are hardly faster."""

MARGIN = 2.0**-47
"""Bound of the rounding error of a plane's product with a point ÷ the product of all lengths. The
steps are a difference, a vector product and a scalar product, with some ten roundings of 2⁻⁵³."""

WHOLE_SPHERE = 4.0 * math.pi

SPHERE_TOLERANCE = 1e-6
"""Accepted difference of the sum of the solid angles from the whole sphere. Twice covered spheres
differ by 4 π."""


class LevelIndex(NamedTuple):
    """A level with everything that searches look up.

    Attributes
    ----------
    vertices : (V, 3) float64
    faces : (F, 3) int32
    centre : (3,) float64
    planes : (F, 13) float64
        For each corner, the normal of the plane through the centre and the other two corners; then
        normal and offset of the face's own plane. Products with points relative to the centre are
        positive inside: n · q, or offset − n · q.
    resolution : int
        Cells along an edge of the cube map.
    cell_start : (6 resolution² + 1,) int32
    cell_faces : (m,) int32
    box : (2, 3) float64
        Smallest and largest coordinates.
    inner : float
        Radius of a ball around the centre that is inside the planes of all faces.
    tree : FaceTree
        Cylinders over the faces.
    boxes : (N, 48) float32
        Boxes of the tree's nodes (`face_boxes`).
    cusps : CuspTable
        The edges that may have cusps.
    hues : HueTable
        The faces of each sector of hues.
    """

    vertices: FloatArray
    faces: IndexArray
    centre: FloatArray
    planes: FloatArray
    resolution: int
    cell_start: IndexArray
    cell_faces: IndexArray
    box: FloatArray
    inner: float
    tree: FaceTree
    boxes: Float32Array
    cusps: CuspTable
    hues: HueTable

    @property
    def nbytes(self) -> int:
        """Memory of the arrays in bytes."""
        fields = (*self, *self.tree, *self.cusps, *self.hues)
        return sum(field.nbytes for field in fields if isinstance(field, np.ndarray))


Level: TypeAlias = LevelIndex | tuple[ArrayLike, ArrayLike, ArrayLike]
"""A level: its index, or its vertices, faces and centre."""


def as_index(level: Level) -> LevelIndex:
    """Return the index of a level, computed unless given; errors are those of `build_index`."""
    return level if isinstance(level, LevelIndex) else build_index(*level)


def build_index(vertices: ArrayLike, faces: ArrayLike, centre: ArrayLike) -> LevelIndex:
    """Compute the index of a level.

    Parameters
    ----------
    vertices : (V, 3) array_like
        Colour coordinates.
    faces : (F, 3) array_like of int
        Counter-clockwise from outside.
    centre : (3,) array_like
        The point about which the mesh is star-shaped.

    Returns
    -------
    LevelIndex

    Raises
    ------
    InvalidPointsError
        A coordinate is not finite.
    MeshError
        The mesh is not closed, or not star-shaped about the centre. ``where["row"]`` is a face.

    Examples
    --------
    >>> corners = np.vstack([np.zeros(3), np.eye(3)])
    >>> index = build_index(corners, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)], (0.1, 0.1, 0.1))
    >>> index.faces.shape, index.box.tolist()
    ((4, 3), [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]])
    """
    corner = checked_points(vertices, "vertices")
    mesh = TriangleMesh(corner, np.asarray(faces))
    triangles = np.ascontiguousarray(mesh.faces, np.int32)
    middle = checked_points(np.reshape(np.asarray(centre), (1, -1)), "centre")[0]
    position = corner - middle
    hidden = faces_not_seeing_centre(position, triangles)
    if len(hidden):
        raise _not_star_shaped(f"Face {hidden[0]} does not see it from inside.", int(hidden[0]))
    opposite = opposite_corners(triangles, len(position))
    if (opposite < 0).any() or not len(opposite):
        face = int(np.argmax(opposite < 0)) // 3 if len(opposite) else 0
        raise MeshError(
            "The mesh is not closed: an edge does not have one face on each side.",
            where={"field": "faces", "row": face},
            remedy="Give a closed mesh, whose faces are all counter-clockwise from outside.",
        )
    box = mesh.bounds
    reach = float(np.linalg.norm(np.maximum(abs(box[0] - middle), abs(box[1] - middle))))
    planes, angle, inner = _cones(position, triangles, reach)
    if abs(angle - WHOLE_SPHERE) > SPHERE_TOLERANCE:
        raise _not_star_shaped("The faces cover some directions several times.", 0)
    resolution = max(1, round(math.sqrt(CELLS_PER_FACE * len(triangles) / 6.0)))
    start, cells = direction_cells(position, triangles, resolution)
    tree = build_face_tree(position, triangles, reach)
    cusps = cusp_table(corner, triangles, opposite)
    boxes = face_boxes(position, triangles, tree)
    hues = hue_table(corner, triangles, middle[0], tree.scale)
    return LevelIndex(
        corner,
        triangles,
        middle,
        planes,
        resolution,
        start,
        cells,
        box,
        inner,
        tree,
        boxes,
        cusps,
        hues,
    )


def _not_star_shaped(why: str, face: int) -> MeshError:
    return MeshError(
        f"The mesh is not star-shaped about the centre. {why}",
        where={"field": "faces", "row": face},
        remedy="Give the centre of the gamut that the level belongs to.",
    )


@kernel
def _cones(
    position: FloatArray, faces: IndexArray, reach: float
) -> tuple[FloatArray, float, float]:
    """Return the faces' planes, the sum of their solid angles, and the radius of a ball inside."""
    planes = np.empty((len(faces), 13))
    angle = 0.0
    inner = np.inf
    for face in range(len(faces)):
        a, b, c = face_corners(position, faces, face)
        to_a, to_b, to_c = np.sqrt(dot(a, a)), np.sqrt(dot(b, b)), np.sqrt(dot(c, c))
        u, v, w = cross(b, c), cross(c, a), cross(a, b)
        determinant = dot(a, u)
        # Van Oosterom & Strackee, "The solid angle of a plane triangle", IEEE Trans. Biomedical
        # Engineering 30 (1983), equation 8
        cosines = to_a * to_b * to_c + dot(a, b) * to_c
        cosines += dot(b, c) * to_a + dot(c, a) * to_b
        angle += 2.0 * np.arctan2(determinant, cosines)
        rounding = 4.0 * MARGIN * reach * (to_a * to_b + to_b * to_c + to_c * to_a)
        normal = plus(plus(u, v), w)
        inner = min(inner, (determinant - rounding) / np.sqrt(dot(normal, normal)))
        write_row(planes, face, 0, scaled(1.0 / (MARGIN * reach * to_b * to_c), u))
        write_row(planes, face, 3, scaled(1.0 / (MARGIN * reach * to_c * to_a), v))
        write_row(planes, face, 6, scaled(1.0 / (MARGIN * reach * to_a * to_b), w))
        write_row(planes, face, 9, scaled(1.0 / rounding, normal))
        planes[face, 12] = (1.0 / rounding) * determinant
    return planes, angle, max(inner, 0.0)


@kernel
def surface_points(index: LevelIndex, faces: IndexArray, weights: FloatArray) -> FloatArray:
    """Return the points (n, 3) of barycentric coordinates (n, 3) in faces."""
    points = np.empty((len(faces), 3))
    for number in range(len(faces)):
        a, b, c = face_corners(index.vertices, index.faces, faces[number])
        u, v, w = row(weights, number, 0)
        write_row(points, number, 0, plus(plus(scaled(u, a), scaled(v, b)), scaled(w, c)))
    return points


LARGEST_COORDINATE = 1e60
"""Largest accepted magnitude of a coordinate. Products of five coordinates must stay finite."""


def checked_points(points: ArrayLike, name: str = "points", width: int = 3) -> FloatArray:
    """Return points as an (n, width) array in double precision.

    Another shape, or a coordinate that is not within ±1e60, raises InvalidPointsError.
    ``where["row"]`` is the first such row, counted from 0, and `name` is the argument in the
    message.
    """
    remedy = f"Give an (n, {width}) array of numbers."
    try:
        array = np.ascontiguousarray(points)
    except ValueError as error:
        message = f"The rows of {name} do not have the same number of values."
        raise InvalidPointsError(message, where={"field": name}, remedy=remedy) from error
    if array.ndim != 2 or array.shape[1] != width or array.dtype.kind not in "fiu":
        raise InvalidPointsError(
            f"{name} has the shape {array.shape} and the type {array.dtype}.",
            where={"field": name},
            remedy=remedy,
        )
    # A read-only or unaligned array is of another type for the compiler, which would compile anew.
    array = np.require(array, np.float64, ["C", "ALIGNED", "WRITEABLE"])
    valid = np.abs(array) <= LARGEST_COORDINATE  # false for NaN
    if not valid.all():
        at = int(np.argmin(valid.all(axis=1)))
        raise InvalidPointsError(
            f"Row {at} of {name} is {array[at].tolist()}.",
            where={"field": name, "row": at},
            remedy=f"Give finite coordinates within ±{number_text(LARGEST_COORDINATE)}.",
        )
    return array


def checked_numbers(numbers: ArrayLike, name: str) -> FloatArray:
    """Return finite numbers, such as hue angles, as an (n,) array in double precision.

    Errors are as for `checked_points`.
    """
    try:
        array = np.asarray(numbers)
    except ValueError:
        array = np.empty((0, 0))  # rows of different lengths
    if array.ndim != 1 or array.dtype.kind not in "fiu":
        raise InvalidPointsError(
            f"{name} are not one list of numbers.",
            where={"field": name},
            remedy="Give an (n,) array of numbers.",
        )
    array = np.ascontiguousarray(array, np.float64)
    if not np.isfinite(array).all():
        at = int(np.argmin(np.isfinite(array)))
        raise InvalidPointsError(
            f"Row {at} of {name} is {array[at]}.",
            where={"field": name, "row": at},
            remedy="Give finite numbers.",
        )
    return array
