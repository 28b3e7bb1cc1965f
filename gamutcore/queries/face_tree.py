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
from gamutcore.kernels import kernel, leaf_kernel

__all__ = [
    "ROUNDING",
    "STACK",
    "WIDTH",
    "FaceTree",
    "build_face_tree",
    "face_boxes",
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

    @property
    def nbytes(self) -> int:
        """Memory of the arrays in bytes."""
        return self.cylinders.nbytes + self.first.nbytes + self.faces.nbytes


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
    for row in range(count):
        order[row] = row
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
            row = order[place]
            x, y, z = points[row, 0], points[row, 1], points[row, 2]
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
    one, two, three = faces[face, 0], faces[face, 1], faces[face, 2]
    ax, ay, az = position[one, 0], position[one, 1], position[one, 2]
    bx, by, bz = position[two, 0], position[two, 1], position[two, 2]
    cx, cy, cz = position[three, 0], position[three, 1], position[three, 2]
    nx = (by - ay) * (cz - az) - (bz - az) * (cy - ay)
    ny = (bz - az) * (cx - ax) - (bx - ax) * (cz - az)
    nz = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    normals[node, 0] += nx
    normals[node, 1] += ny
    normals[node, 2] += nz
    share = 1.0 / np.sqrt(nx * nx + ny * ny + nz * nz)
    nx, ny, nz = (
        float(np.float32(share * nx)),
        float(np.float32(share * ny)),
        float(np.float32(share * nz)),
    )
    x = float(np.float32((ax + bx + cx) / 3.0))
    y = float(np.float32((ay + by + cy) / 3.0))
    z = float(np.float32((az + bz + cz) / 3.0))
    square = height = 0.0
    for u, v, w in ((ax - x, ay - y, az - z), (bx - x, by - y, bz - z), (cx - x, cy - y, cz - z)):
        square = max(square, u * u + v * v + w * w)
        height = max(height, abs(u * nx + v * ny + w * nz))
    cylinders[node, MIDDLE, at] = x
    cylinders[node, MIDDLE + 1, at] = y
    cylinders[node, MIDDLE + 2, at] = z
    cylinders[node, AXIS, at] = nx
    cylinders[node, AXIS + 1, at] = ny
    cylinders[node, AXIS + 2, at] = nz
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
    nx, ny, nz = normal[0], normal[1], normal[2]
    length = max(np.sqrt(nx * nx + ny * ny + nz * nz), 1e-300)
    nx = float(np.float32(nx / length))
    ny = float(np.float32(ny / length))
    nz = float(np.float32(nz / length))
    if nx * nx + ny * ny + nz * nz < 0.5:  # a whole closed surface
        nx, ny, nz = 1.0, 0.0, 0.0
    ux, uy, uz = (0.0, nz, -ny) if abs(nx) < 0.6 else (-nz, 0.0, nx)
    share = 1.0 / np.sqrt(ux * ux + uy * uy + uz * uz)
    ux, uy, uz = share * ux, share * uy, share * uz
    vx, vy, vz = ny * uz - nz * uy, nz * ux - nx * uz, nx * uy - ny * ux
    low_n = low_u = low_v = np.inf
    high_n = high_u = high_v = -np.inf
    for face in held:
        for corner in range(3):
            vertex = faces[face, corner]
            x, y, z = position[vertex, 0], position[vertex, 1], position[vertex, 2]
            along = x * nx + y * ny + z * nz
            low_n, high_n = min(low_n, along), max(high_n, along)
            along = x * ux + y * uy + z * uz
            low_u, high_u = min(low_u, along), max(high_u, along)
            along = x * vx + y * vy + z * vz
            low_v, high_v = min(low_v, along), max(high_v, along)
    n, u, v = 0.5 * (low_n + high_n), 0.5 * (low_u + high_u), 0.5 * (low_v + high_v)
    x0 = float(np.float32(n * nx + u * ux + v * vx))
    y0 = float(np.float32(n * ny + u * uy + v * vy))
    z0 = float(np.float32(n * nz + u * uz + v * vz))
    square = height = 0.0
    for face in held:
        for corner in range(3):
            vertex = faces[face, corner]
            x, y, z = position[vertex, 0] - x0, position[vertex, 1] - y0, position[vertex, 2] - z0
            along = x * nx + y * ny + z * nz
            whole = x * x + y * y + z * z
            square = max(square, (1.0 + ROUNDING) * whole - along * along)
            height = max(height, abs(along))
    cylinders[node, MIDDLE, at] = x0
    cylinders[node, MIDDLE + 1, at] = y0
    cylinders[node, MIDDLE + 2, at] = z0
    cylinders[node, AXIS, at] = nx
    cylinders[node, AXIS + 1, at] = ny
    cylinders[node, AXIS + 2, at] = nz
    cylinders[node, RADIUS, at] = np.sqrt(square) * (1.0 + ROUNDING)
    cylinders[node, HEIGHT, at] = height * (1.0 + ROUNDING)


@leaf_kernel
def set_lower_bounds(
    x: float, y: float, z: float, cylinders: Float32Array, node: int, squares: FloatArray
) -> None:
    """Set `squares` (8,) to lower bounds of a point's squared distances to the children of a node.

    The point is relative to the centre, and scaled, as the bounds are. They are infinite without a
    child.
    """
    row = np.uint64(node)
    # a loop whose length the compiler knows is unrolled first, and then not vectorised
    for each in range(cylinders.shape[1] // PARTS):
        at = np.uint64(each)
        u = x - cylinders[row, at]
        v = y - cylinders[row, at + np.uint64(8)]
        w = z - cylinders[row, at + np.uint64(16)]
        along = (
            u * cylinders[row, at + np.uint64(24)]
            + v * cylinders[row, at + np.uint64(32)]
            + w * cylinders[row, at + np.uint64(40)]
        )
        whole = u * u + v * v + w * w
        across = np.sqrt(max(whole - along * along - ROUNDING * whole, 0.0))
        across = max(across - cylinders[row, at + np.uint64(48)], 0.0)
        above = max(abs(along) * (1.0 - ROUNDING) - cylinders[row, at + np.uint64(56)], 0.0)
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
    origin: tuple[float, float, float],
    slope: tuple[float, float, float],
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
    row = np.uint64(node)
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
            (boxes[row, near_x + at] - (x + p)) * u,
            (boxes[row, near_y + at] - (y + q)) * v,
            (boxes[row, near_z + at] - (z + r)) * w,
            low,
        )
        last = min(
            (boxes[row, far_x + at] - (x - p)) * u,
            (boxes[row, far_y + at] - (y - q)) * v,
            (boxes[row, far_z + at] - (z - r)) * w,
            high,
        )
        gaps[at] = last - first
