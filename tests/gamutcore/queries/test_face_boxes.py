"""Boxes of the tree over faces: each holds what is below it, and lines through it are found."""

import numpy as np
import pytest

from gamutcore.queries import build_index
from gamutcore.queries.face_boxes import set_box_gaps
from gamutcore.queries.face_tree import WIDTH


@pytest.fixture(params=[8, 24, 600])
def index(request, rough):
    return build_index(*rough(13, request.param))


def boxes_of_faces(index):
    """Return for each face the smallest and the largest coordinates of its leaf's box."""
    tree, found = index.tree, {}
    for node in np.flatnonzero(tree.first < 0):
        sides = index.boxes[node].reshape(2, 3, WIDTH)
        for at in range(WIDTH):
            if np.isfinite(sides[0, 0, at]):
                found[int(tree.faces[~tree.first[node] + at])] = sides[:, :, at]
    return found


class TestFaceBoxes:
    def test_leaves_hold_their_faces_tightly(self, index):
        corners = (index.vertices[index.faces] - index.centre) * index.tree.scale
        found = boxes_of_faces(index)
        assert sorted(found) == list(range(len(index.faces)))
        for face, (low, high) in found.items():
            assert (low <= corners[face].min(axis=0)).all()
            assert (high >= corners[face].max(axis=0)).all()
            np.testing.assert_allclose(low, corners[face].min(axis=0), atol=1e-6)
            np.testing.assert_allclose(high, corners[face].max(axis=0), atol=1e-6)

    def test_nodes_hold_the_boxes_below(self, index):
        sides = index.boxes.reshape(-1, 2, 3, WIDTH)
        for node in np.flatnonzero(index.tree.first >= 0):
            for at in range(WIDTH):
                if np.isfinite(sides[node, 0, 0, at]):
                    below = sides[index.tree.first[node] + at]
                    np.testing.assert_array_equal(sides[node, 0, :, at], below[0].min(axis=1))
                    np.testing.assert_array_equal(sides[node, 1, :, at], below[1].max(axis=1))


class TestSetBoxGaps:
    def test_a_line_through_a_point_of_a_box_has_a_length_in_it(self, index):
        random = np.random.default_rng(4)
        gaps = np.empty(WIDTH)
        for node, flat in enumerate(index.boxes):
            low, high = flat.reshape(2, 3, WIDTH).astype(float)
            for at in np.flatnonzero(np.isfinite(low[0])):
                middle = (low[:, at] + high[:, at]) / 2
                direction = random.normal(size=3)
                origin, slope = middle - direction, 1 / direction
                set_box_gaps(
                    tuple(origin), tuple(slope), -np.inf, np.inf, 1e-12, index.boxes, node, gaps
                )
                assert gaps[at] >= 0
                beyond = tuple(origin), tuple(slope), -np.inf, -1e6, 1e-12
                set_box_gaps(*beyond, index.boxes, node, gaps)
                assert gaps[at] < 0

    def test_a_line_beside_all_boxes_and_a_missing_child_have_none(self, index):
        gaps = np.empty(WIDTH)
        line = (5.0, 5.0, 5.0), (1.0, 1e300, 1e300)
        for node, flat in enumerate(index.boxes):
            set_box_gaps(*line, -1e9, 1e9, 1e-12, index.boxes, node, gaps)
            assert (gaps < 0).all()
            missing = np.isinf(flat[:WIDTH])
            set_box_gaps(
                (0.0, 0.0, 0.0), (1.0, 2.0, 3.0), -1e9, 1e9, 1e-12, index.boxes, node, gaps
            )
            assert (gaps[missing] < 0).all()
