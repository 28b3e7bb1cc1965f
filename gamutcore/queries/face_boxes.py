"""Bounding boxes of the nodes of the face tree, for tests of lines.

The cylinders of `gamutcore.queries.face_tree` are tight for distances; boxes are tighter for lines.
The boxes of a node's children are a structure of arrays, so that the compiler tests eight at once.
They are rounded outwards to float32.
"""

from __future__ import annotations

import numpy as np

from gamutcore.arrays import Float32Array, FloatArray, IndexArray
from gamutcore.kernels import kernel, leaf_kernel
from gamutcore.queries.face_tree import RADIUS, WIDTH, FaceTree

__all__ = ["face_boxes", "set_box_gaps"]

SIDES = 6
"""Smallest x, y, z, and largest x, y, z."""

ROUNDING, SMALLEST = 2.0**-23, 2.0**-126
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
    return np.float32(value - (ROUNDING * abs(value) + SMALLEST))


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
