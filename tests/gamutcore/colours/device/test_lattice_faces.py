from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gamutcore.colours.device.lattice_faces import Layout, inside_count, lattice_faces

CELLS = 2
SIDES = [[0, 1, 2, 3], [4, 5, 3, 6]]
"""Edges below, above, before and after two unit squares side by side; they share edge 3."""

EDGES = [[0, 1], [2, 3], [0, 2], [3, 1], [1, 4], [3, 5], [4, 5]]
"""Edge 3 runs from the upper to the lower corner, against t of both squares."""

CORNERS = np.array([[0, 0], [1, 0], [0, 1], [1, 1], [2, 0], [2, 1]], float)

counts = st.integers(1, 4)


@st.composite
def layouts(draw):
    parts = np.array(draw(st.lists(counts, min_size=16, max_size=16))).reshape(2, CELLS, CELLS, 2)
    pieces = np.array(draw(st.lists(counts, min_size=14, max_size=14))).reshape(7, CELLS)
    reached = np.concatenate([np.zeros((7, 1), int), np.cumsum(pieces, axis=1)], axis=1)
    inner = reached[:, -1] - 1
    turned = np.array(draw(st.lists(st.booleans(), min_size=2, max_size=2)))
    return Layout(
        np.broadcast_to(np.array([0, 0.4, 1.0]), (2, 2, CELLS + 1)).copy(),
        parts,
        np.array(SIDES),
        np.array(SIDES) == 3,
        np.array(EDGES),
        reached,
        len(CORNERS) + np.cumsum(inner) - inner,
        turned,
    )


def triangulate(layout):
    """Return positions of all points, triangles and their squares."""
    outside = len(CORNERS) + int((layout.reached[:, -1] - 1).sum())
    inside = inside_count(layout.parts)
    owner, position, faces, labels = lattice_faces(layout, outside, inside, 2000, 16)
    along = [
        np.linspace(0, 1, int(parts[-1]) + 1)[1:-1, None] * (CORNERS[b] - CORNERS[a]) + CORNERS[a]
        for (a, b), parts in zip(layout.edges, layout.reached, strict=True)
    ]
    points = np.concatenate([CORNERS, *along, position + owner[:, None] * [1, 0]])
    return points, faces, labels


@given(layout=layouts())
@pytest.mark.slow
def test_each_patch_is_covered_once_without_t_junctions(layout):
    points, faces, labels = triangulate(layout)
    assert np.array_equal(np.unique(faces), np.arange(len(points)))  # every point is used
    a, b, c = points[faces].transpose(1, 0, 2)
    (x, y), (u, v) = (b - a).T, (c - a).T
    area = (x * v - y * u) / 2
    for patch in range(2):
        assert np.isclose(area[labels == patch].sum(), -1 if layout.turned[patch] else 1)
    sides = Counter(
        tuple(sorted(side))
        for face in faces.tolist()
        for side in zip(face, face[1:] + face[:1], strict=True)
    )
    rim = int(layout.reached[[0, 1, 2, 4, 5, 6], -1].sum())
    assert set(sides.values()) <= {1, 2}
    assert sum(n == 1 for n in sides.values()) == rim


@given(layout=layouts())
def test_turned_patches_run_the_other_way(layout):
    straight, turned = (
        triangulate(layout._replace(turned=np.full(2, way)))[1] for way in (False, True)
    )
    assert np.array_equal(straight[:, [0, 2, 1]], turned)


def test_points_inside_of_a_divided_cell():
    # one cell of 3 × 4 parts: 2 × 3 inner points
    assert inside_count(np.array([[[[3, 4]]]])) == 6
