"""A tree over the faces of a level, eight in a node, with cylinders and boxes around them.

Eight neighbouring faces make a leaf, eight leaves a node, and so on to the root. A node stores the
enclosures of its children as a structure of arrays, so that the compiler computes several at once.

- For distances, each face, leaf and node is enclosed in a flat cylinder with its axis along the
  mean normal. On a smooth surface the cylinder is much flatter than an axis-aligned box. A box
  reaches above the surface nearby, so a search for the nearest face would enter many boxes in
  vain.
- For lines, boxes are tighter. They are rounded outwards to float32.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gamutcore.arrays import Float32Array, FloatArray, IndexArray, LongArray
from gamutcore.geometry import (
    Vector,
    cross,
    dot,
    face_corners,
    minus,
    plus,
    row,
    scaled,
    vector,
    write_row,
)
from gamutcore.kernels import inlined_kernel, kernel, leaf_kernel

__all__ = [
    "ROUNDING",
    "STACK",
    "WIDTH",
    "FaceTree",
    "Search",
    "build_face_tree",
    "face_boxes",
    "new_search",
    "set_box_gaps",
    "set_lower_bounds",
]

WIDTH = 8
"""Children of a node."""

STACK = 128
"""Most entries of a search's stack: seven for each of at most eleven levels, and one node."""

MIDDLE, AXIS, RADIUS, HEIGHT = 0, 3, 6, 7
"""First indices of the parts of a cylinder."""

PARTS = 8

ROUNDING = 2.0**-20
"""Four times the bound of the relative error of the squared length of an axis in float32."""

FINEST, KEY_BITS = 2.0**30, 32
"""Coordinates are divided into `FINEST` steps, and stored above the bits of a key that hold the
face."""


class FaceTree(NamedTuple):
    """Cylinders over the faces of a level. The root is node 0.

    `cylinders` has eight numbers for each part of a cylinder, one for each child of a node. The
    parts are x, y, z of the middle, x, y, z of the axis, the radius, and half the height. Middles
    are relative to the centre of the level. Lengths are multiplied by `scale`, and axes have length
    1 within rounding. Without a child the radius is −∞.
    """

    cylinders: Float32Array  # (N, 64)
    first: IndexArray  # (N,) first child, before the others; in leaves ~first is an index of faces
    faces: IndexArray  # (F,) in the order of the leaves
    scale: float  # 1 ÷ the reach of the level, so that no coordinate is too large for float32


def build_face_tree(position: FloatArray, faces: IndexArray, reach: float) -> FaceTree:
    """Return the tree over faces with vertices `position` (V, 3) relative to the centre.

    No vertex is farther from the centre than `reach`.
    """
    return FaceTree(*_build(position / reach, faces), 1.0 / reach)


@kernel
def _build(position: FloatArray, faces: IndexArray) -> tuple[Float32Array, IndexArray, IndexArray]:
    count = len(faces)
    middle = np.empty((count, 3))
    for face in range(count):
        one, two, three = faces[face, 0], faces[face, 1], faces[face, 2]
        for axis in range(3):
            total = position[one, axis] + position[two, axis] + position[three, axis]
            middle[face, axis] = total / 3.0
    order = _compact_order(middle)

    nodes, size = 0, count
    while True:  # the levels of the tree, from the leaves to the root
        size = (size + WIDTH - 1) // WIDTH
        nodes += size
        if size == 1:
            break
    cylinders = np.zeros((nodes, PARTS, WIDTH), np.float32)
    cylinders[:, RADIUS] = -np.inf
    first = np.empty(nodes, np.int32)
    normals = np.zeros((nodes, 3))
    size = (count + WIDTH - 1) // WIDTH
    start = nodes - size
    for place in range(count):
        node, at = start + place // WIDTH, place % WIDTH
        first[node] = ~(place - at)
        _set_face(position, faces, order[place], cylinders, normals, node, at)
    span = WIDTH
    while size > 1:
        below, below_start = size, start
        size = (size + WIDTH - 1) // WIDTH
        start -= size
        for index in range(below):
            node, at, child = start + index // WIDTH, index % WIDTH, below_start + index
            first[node] = child - at
            held = order[index * span : min((index + 1) * span, count)]
            _set_node(position, faces, held, normals[child], cylinders, node, at)
            for axis in range(3):
                normals[node, axis] += normals[child, axis]
        span *= WIDTH
    return cylinders.reshape((nodes, PARTS * WIDTH)), first, order


@kernel
def _compact_order(points: FloatArray) -> IndexArray:
    """Return an order of points in which the points of every node are consecutive.

    Points are divided near the median along the longest side of their box, recursively. The first
    part has eight times a power of two, so that nodes are full.
    """
    count = len(points)
    order = np.empty(count, np.int32)
    for point in range(count):
        order[point] = point
    keys = np.empty(count, np.int64)
    begins, ends = np.empty(64, np.int64), np.empty(64, np.int64)
    begins[0], ends[0] = 0, count
    height = 1
    while height > 0:
        height -= 1
        begin, end = begins[height], ends[height]
        if end - begin <= WIDTH:
            continue
        least_x = least_y = least_z = np.inf
        most_x = most_y = most_z = -np.inf
        for place in range(begin, end):
            x, y, z = row(points, order[place], 0)
            least_x, most_x = min(least_x, x), max(most_x, x)
            least_y, most_y = min(least_y, y), max(most_y, y)
            least_z, most_z = min(least_z, z), max(most_z, z)
        axis, least, longest = 0, least_x, most_x - least_x
        if most_y - least_y > longest:
            axis, least, longest = 1, least_y, most_y - least_y
        if most_z - least_z > longest:
            axis, least, longest = 2, least_z, most_z - least_z
        scale = FINEST / longest if longest > 0.0 else 0.0
        for place in range(begin, end):
            along = np.int64(scale * (points[order[place], axis] - least))
            keys[place] = (along << KEY_BITS) | order[place]
        half = WIDTH
        while 2 * half < end - begin:
            half *= 2
        _select(keys, begin, end - 1, begin + half)
        for place in range(begin, end):
            order[place] = keys[place] & ((1 << KEY_BITS) - 1)
        begins[height], ends[height] = begin, begin + half
        begins[height + 1], ends[height + 1] = begin + half, end
        height += 2
    return order


@leaf_kernel
def _select(keys: LongArray, first: int, last: int, place: int) -> None:
    """Reorder different numbers so that those before `place` are smaller than those after.

    Source: C. A. R. Hoare, "Algorithm 65: Find", Communications of the ACM 4 (1961), with a loop
    without branches, which processors cannot predict here.
    """
    while first < last:
        middle = (first + last) // 2
        one, two, three = keys[first], keys[middle], keys[last]
        pivot = max(min(one, two), min(max(one, two), three))
        chosen = first if pivot == one else (middle if pivot == two else last)
        keys[chosen], keys[last] = three, pivot
        below = first
        for at in range(first, last):
            key = keys[at]
            keys[at] = keys[below]
            keys[below] = key
            below += key < pivot
        keys[last], keys[below] = keys[below], pivot
        if place < below:
            last = below - 1
        elif place > below:
            first = below + 1
        else:
            return


@leaf_kernel
def _set_face(
    position: FloatArray,
    faces: IndexArray,
    face: int,
    cylinders: Float32Array,
    normals: FloatArray,
    node: int,
    at: int,
) -> None:
    """Set the cylinder of a face, and add its normal, twice as long as its area, to the node's."""
    a, b, c = face_corners(position, faces, face)
    normal = cross(minus(b, a), minus(c, a))
    write_row(normals, node, 0, plus(row(normals, node, 0), normal))
    axis = _in_float32(scaled(1.0 / np.sqrt(dot(normal, normal)), normal))
    x, y, z = plus(plus(a, b), c)
    middle = _in_float32((x / 3.0, y / 3.0, z / 3.0))
    square = height = 0.0
    for corner in (minus(a, middle), minus(b, middle), minus(c, middle)):
        square = max(square, dot(corner, corner))
        height = max(height, abs(dot(corner, axis)))
    _set_cylinder(cylinders, node, at, middle, axis, square, height)


@inlined_kernel
def _in_float32(a: Vector) -> Vector:
    """Return a vector rounded to float32."""
    return float(np.float32(a[0])), float(np.float32(a[1])), float(np.float32(a[2]))


@leaf_kernel
def _set_cylinder(
    cylinders: Float32Array,
    node: int,
    at: int,
    middle: Vector,
    axis: Vector,
    square: float,
    height: float,
) -> None:
    """Set a child's cylinder, given the square of its radius and half its height."""
    for coordinate in range(3):
        cylinders[node, MIDDLE + coordinate, at] = middle[coordinate]
        cylinders[node, AXIS + coordinate, at] = axis[coordinate]
    cylinders[node, RADIUS, at] = np.sqrt(square) * (1.0 + ROUNDING)
    cylinders[node, HEIGHT, at] = height * (1.0 + ROUNDING)


@leaf_kernel
def _set_node(
    position: FloatArray,
    faces: IndexArray,
    held: IndexArray,
    normal: FloatArray,
    cylinders: Float32Array,
    node: int,
    at: int,
) -> None:
    """Set the cylinder of the faces of a child, with the axis along their normal.

    It encloses the corners, and its middle is that of a box with one side along the axis. Cylinders
    of cylinders would be up to twice as wide at the root.
    """
    mean = vector(normal)
    axis = _in_float32(scaled(1.0 / max(np.sqrt(dot(mean, mean)), 1e-300), mean))
    if dot(axis, axis) < 0.5:  # a whole closed surface
        axis = 1.0, 0.0, 0.0
    across = (0.0, axis[2], -axis[1]) if abs(axis[0]) < 0.6 else (-axis[2], 0.0, axis[0])
    across = scaled(1.0 / np.sqrt(dot(across, across)), across)
    third = cross(axis, across)
    low_n = low_u = low_v = np.inf
    high_n = high_u = high_v = -np.inf
    for face in held:
        for corner in range(3):
            point = row(position, faces[face, corner], 0)
            n, u, v = dot(point, axis), dot(point, across), dot(point, third)
            low_n, high_n = min(low_n, n), max(high_n, n)
            low_u, high_u = min(low_u, u), max(high_u, u)
            low_v, high_v = min(low_v, v), max(high_v, v)
    n, u, v = 0.5 * (low_n + high_n), 0.5 * (low_u + high_u), 0.5 * (low_v + high_v)
    middle = _in_float32(plus(plus(scaled(n, axis), scaled(u, across)), scaled(v, third)))
    square = height = 0.0
    for face in held:
        for corner in range(3):
            point = minus(row(position, faces[face, corner], 0), middle)
            along = dot(point, axis)
            square = max(square, (1.0 + ROUNDING) * dot(point, point) - along * along)
            height = max(height, abs(along))
    _set_cylinder(cylinders, node, at, middle, axis, square, height)


class Search(NamedTuple):
    """Work arrays of a search in a tree."""

    nodes: LongArray  # (STACK,) the nodes still to be searched
    bounds: FloatArray  # (STACK,) lower bounds of their squared distances
    squares: FloatArray  # (WIDTH,) those of the children of a node


def new_search() -> Search:
    """Return work arrays for a search."""
    return Search(np.empty(STACK, np.int64), np.empty(STACK), np.empty(WIDTH))


@leaf_kernel
def set_lower_bounds(
    point: Vector, cylinders: Float32Array, node: int, squares: FloatArray
) -> None:
    """Set `squares` (8,) to lower bounds of a point's squared distances to the children of a node.

    The point is relative to the centre, and scaled, as the bounds are. They are infinite without a
    child.
    """
    (x, y, z), parent = point, np.uint64(node)
    # a loop whose length the compiler knows is unrolled first, and then not vectorised
    for each in range(cylinders.shape[1] // PARTS):
        at = np.uint64(each)
        u = x - cylinders[parent, at]
        v = y - cylinders[parent, at + np.uint64(8)]
        w = z - cylinders[parent, at + np.uint64(16)]
        along = (
            u * cylinders[parent, at + np.uint64(24)]
            + v * cylinders[parent, at + np.uint64(32)]
            + w * cylinders[parent, at + np.uint64(40)]
        )
        whole = u * u + v * v + w * w
        across = np.sqrt(max(whole - along * along - ROUNDING * whole, 0.0))
        across = max(across - cylinders[parent, at + np.uint64(48)], 0.0)
        above = max(abs(along) * (1.0 - ROUNDING) - cylinders[parent, at + np.uint64(56)], 0.0)
        squares[at] = across * across + above * above


SIDES = 6
"""Smallest x, y, z, and largest x, y, z."""

FLOAT32_ROUNDING, FLOAT32_SMALLEST = 2.0**-23, 2.0**-126
"""Twice the relative rounding error of float32, and its smallest normal number."""


@kernel
def face_boxes(position: FloatArray, mesh: IndexArray, tree: FaceTree) -> Float32Array:
    """Return the boxes (N, 48) of all nodes' children, relative to the centre, scaled as the tree.

    Each of the six sides has eight numbers. Without a child the box is empty: from ∞ to −∞.
    `position` (V, 3) is relative to the centre.
    """
    first, scale = tree.first, tree.scale
    boxes = np.empty((len(first), SIDES * WIDTH), np.float32)
    boxes[:, : 3 * WIDTH] = np.inf
    boxes[:, 3 * WIDTH :] = -np.inf
    for node in range(len(first) - 1, -1, -1):  # children come after their node
        for at in range(WIDTH):
            if tree.cylinders[node, RADIUS * WIDTH + at] < 0.0:
                break  # no child
            if first[node] < 0:
                face = tree.faces[~first[node] + at]
                one, two, three = mesh[face, 0], mesh[face, 1], mesh[face, 2]
                for axis in range(3):
                    p, q, r = position[one, axis], position[two, axis], position[three, axis]
                    boxes[node, axis * WIDTH + at] = _rounded_down(scale * min(p, q, r))
                    boxes[node, (3 + axis) * WIDTH + at] = -_rounded_down(-scale * max(p, q, r))
            else:
                child = first[node] + at
                for axis in range(3):
                    low, high = boxes[child, axis * WIDTH], boxes[child, (3 + axis) * WIDTH]
                    for each in range(1, WIDTH):
                        low = min(low, boxes[child, axis * WIDTH + each])
                        high = max(high, boxes[child, (3 + axis) * WIDTH + each])
                    boxes[node, axis * WIDTH + at] = low
                    boxes[node, (3 + axis) * WIDTH + at] = high
    return boxes


@leaf_kernel
def _rounded_down(value: float) -> np.float32:
    """Return a float32 that is below a number, by about its rounding."""
    return np.float32(value - (FLOAT32_ROUNDING * abs(value) + FLOAT32_SMALLEST))


@leaf_kernel
def set_box_gaps(
    origin: Vector,
    slope: Vector,
    low: float,
    high: float,
    margin: float,
    boxes: Float32Array,
    node: int,
    gaps: FloatArray,
) -> None:
    """Set `gaps` (8,) to the lengths of a line in a node's boxes; negative if the line misses.

    `origin` is a point of the line, relative to the centre, and scaled; `slope` is 1 ÷ its
    direction, finite. `low` and `high` are ends in units of the direction. The boxes are widened by
    `margin`, which covers the rounding errors of the line.
    """
    x, y, z = origin
    u, v, w = slope
    parent = np.uint64(node)
    a, d = (0, 3 * WIDTH) if u > 0.0 else (3 * WIDTH, 0)
    b, e = (WIDTH, 4 * WIDTH) if v > 0.0 else (4 * WIDTH, WIDTH)
    c, f = (2 * WIDTH, 5 * WIDTH) if w > 0.0 else (5 * WIDTH, 2 * WIDTH)
    near_x, near_y, near_z = np.uint64(a), np.uint64(b), np.uint64(c)
    far_x, far_y, far_z = np.uint64(d), np.uint64(e), np.uint64(f)
    p, q, r = np.copysign(margin, u), np.copysign(margin, v), np.copysign(margin, w)
    # a loop whose length the compiler knows is unrolled first, and then not vectorised
    for each in range(boxes.shape[1] // SIDES):
        at = np.uint64(each)
        first = max(
            (boxes[parent, near_x + at] - (x + p)) * u,
            (boxes[parent, near_y + at] - (y + q)) * v,
            (boxes[parent, near_z + at] - (z + r)) * w,
            low,
        )
        last = min(
            (boxes[parent, far_x + at] - (x - p)) * u,
            (boxes[parent, far_y + at] - (y - q)) * v,
            (boxes[parent, far_z + at] - (z - r)) * w,
            high,
        )
        gaps[at] = last - first
