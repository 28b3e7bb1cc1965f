"""The nearest point in a plane of constant hue.

The section of a level by the half-plane of a hue has a segment for each face that it meets. The
search descends the tree of the hue's sector (`gamutcore.queries.hue_table`), nearest rectangle
first. It skips rectangles that are farther than the best segment.
"""

from __future__ import annotations

import numpy as np

from gamutcore.arrays import Float32Array, FloatArray, IndexArray, LongArray
from gamutcore.kernels import leaf_kernel
from gamutcore.queries.cusp_table import hue_turn
from gamutcore.queries.face_tree import WIDTH
from gamutcore.queries.hue_table import RECTANGLE, hue_part
from gamutcore.queries.index import LevelIndex

__all__ = ["nearest_of_hue"]

FARTHEST = 1e300
"""Limit of squared distances; those of empty boxes are infinite."""

ROUNDING = 2.0**-44
"""Widening of rectangles ÷ the largest coordinate."""


@leaf_kernel
def nearest_of_hue(
    lightness: float,
    chroma: float,
    ca: float,
    cb: float,
    index: LevelIndex,
    nodes: LongArray,
    bounds: FloatArray,
    squares: FloatArray,
    weights: FloatArray,
) -> tuple[int, float, float]:
    """Return face, lightness and chroma of the surface point of a hue that is nearest to a colour.

    `ca` and `cb` are cosine and sine of the hue angle. The face is −1 if no face meets the
    half-plane. `weights` (3,) receives the barycentric coordinates. `nodes` and `bounds` (STACK,)
    and `squares` (WIDTH,) are work arrays.
    """
    table, middle, scale = index.hues, index.centre[0], index.tree.scale
    margin = ROUNDING * (1.0 + scale * (abs(lightness) + chroma + abs(middle)))
    best, found, found_chroma, square = -1, np.nan, np.nan, np.inf
    limit = FARTHEST
    sectors = len(table.roots)
    turn = 0.25 * sectors * hue_turn(ca, cb)
    sector = min(int(turn), sectors - 1)
    part = hue_part(turn - sector)
    nodes[0], bounds[0] = table.roots[sector], 0.0
    height = 1 if nodes[0] >= 0 else 0
    while height > 0:
        height -= 1
        if bounds[height] > limit:
            continue
        node = nodes[height]
        _set_bounds(scale * (lightness - middle), scale * chroma, table.rectangles, node, squares)
        first = table.first[node]
        bottom = height
        child = first if first >= 0 else ~first
        near = height
        for at in range(WIDTH):  # without branches, which processors cannot predict here
            nodes[near], bounds[near] = child + at, squares[at]
            near += squares[at] <= limit
        if first >= 0:
            height = near
            nearest = bottom
            for at in range(bottom, near):
                nearest = at if bounds[at] < bounds[nearest] else nearest
            if near > bottom:  # the nearest on top
                nodes[nearest], nodes[near - 1] = nodes[near - 1], nodes[nearest]
                bounds[nearest], bounds[near - 1] = bounds[near - 1], bounds[nearest]
            continue
        for at in range(bottom, near):
            place = nodes[at]
            if part < table.spans[place, 0] or part > table.spans[place, 1]:
                continue
            face = table.faces[place]
            closer, lower, lower_chroma = _nearest_of_face(
                lightness, chroma, ca, cb, index.vertices, index.faces, face, square, weights
            )
            if closer < square:
                best, found, found_chroma, square = face, lower, lower_chroma, closer
                limit = (scale * np.sqrt(square) + margin) ** 2
    return best, found, found_chroma


@leaf_kernel
def _set_bounds(
    x: float, y: float, rectangles: Float32Array, node: int, squares: FloatArray
) -> None:
    """Set `squares` (8,) to the squared distances of a point to the rectangles of a node.

    The point is lightness relative to the centre, and chroma. Point and result are scaled. The
    result is infinite without a child.
    """
    row = np.uint64(node)
    # a loop whose length the compiler knows is unrolled first, and then not vectorised
    for each in range(rectangles.shape[1] // RECTANGLE):
        at = np.uint64(each)
        u = max(rectangles[row, at] - x, x - rectangles[row, at + np.uint64(16)], 0.0)
        v = max(
            rectangles[row, at + np.uint64(8)] - y, y - rectangles[row, at + np.uint64(24)], 0.0
        )
        squares[at] = u * u + v * v


@leaf_kernel
def _nearest_of_face(
    lightness: float,
    chroma: float,
    ca: float,
    cb: float,
    vertices: FloatArray,
    faces: IndexArray,
    face: int,
    limit: float,
    weights: FloatArray,
) -> tuple[float, float, float]:
    """Return squared distance, lightness and chroma of the nearest point of a face's section.

    The distance is infinite without a section. Weights are set only below the limit.
    """
    a, b, c = faces[face, 0], faces[face, 1], faces[face, 2]
    side_a = ca * vertices[a, 2] - cb * vertices[a, 1]
    side_b = ca * vertices[b, 2] - cb * vertices[b, 1]
    side_c = ca * vertices[c, 2] - cb * vertices[c, 1]
    left_a, left_b, left_c = side_a >= 0.0, side_b >= 0.0, side_c >= 0.0
    if left_a == left_b and left_b == left_c:
        return np.inf, np.nan, np.nan
    # the corner that is alone on its side comes first
    place = 0
    if left_a == left_c:
        a, b, c, side_a, side_b, side_c, place = b, c, a, side_b, side_c, side_a, 1
    elif left_a == left_b:
        a, b, c, side_a, side_b, side_c, place = c, a, b, side_c, side_a, side_b, 2
    s, t = side_a / (side_a - side_b), side_a / (side_a - side_c)
    chroma_a = ca * vertices[a, 1] + cb * vertices[a, 2]
    one = chroma_a + s * (ca * vertices[b, 1] + cb * vertices[b, 2] - chroma_a)
    two = chroma_a + t * (ca * vertices[c, 1] + cb * vertices[c, 2] - chroma_a)
    if one < 0.0 and two < 0.0:
        return np.inf, np.nan, np.nan
    low = vertices[a, 0] + s * (vertices[b, 0] - vertices[a, 0])
    high = vertices[a, 0] + t * (vertices[c, 0] - vertices[a, 0])
    rise, run = high - low, two - one
    length = rise * rise + run * run
    share = ((lightness - low) * rise + (chroma - one) * run) / length if length > 0.0 else 0.0
    share = min(max(share, 0.0), 1.0)
    if one < 0.0:  # not beyond the axis
        share = max(share, -one / run)
    elif two < 0.0:
        share = min(share, -one / run)
    near, near_chroma = low + share * rise, max(one + share * run, 0.0)
    square = (near - lightness) ** 2 + (near_chroma - chroma) ** 2
    if square < limit:
        weights[place] = (1.0 - share) * (1.0 - s) + share * (1.0 - t)
        weights[(place + 1) % 3] = (1.0 - share) * s
        weights[(place + 2) % 3] = share * t
    return square, near, near_chroma
