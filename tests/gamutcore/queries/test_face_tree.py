"""The tree over faces: every cylinder holds what is below it."""

import numpy as np
import pytest

from gamutcore.queries import build_index
from gamutcore.queries.face_tree import WIDTH, set_lower_bounds


def faces_below(tree, node, at):
    """Return the faces below a child of a node; none if there is no child."""
    first = tree.first[node]
    if tree.cylinders[node].reshape(8, WIDTH)[6, at] < 0:
        return []
    if first < 0:
        return [int(tree.faces[~first + at])]
    return [face for each in range(WIDTH) for face in faces_below(tree, first + at, each)]


@pytest.fixture(params=[8, 24, 600])
def index(request, rough):
    return build_index(*rough(11, request.param))


class TestBuildFaceTree:
    def test_every_face_is_in_one_leaf(self, index):
        found = [face for at in range(WIDTH) for face in faces_below(index.tree, 0, at)]
        assert sorted(found) == list(range(len(index.faces)))

    def test_nodes_are_full_except_at_the_end(self, index):
        nodes, count = 0, len(index.faces)
        while count > 1:
            count = -(-count // WIDTH)
            nodes += count
        assert len(index.tree.first) == nodes

    def test_cylinders_are_not_wider_than_what_they_hold(self, index):
        tree = index.tree
        corners = (index.vertices[index.faces] - index.centre) * tree.scale
        for node in range(len(tree.first)):
            parts = tree.cylinders[node].reshape(8, WIDTH).astype(float)
            for at in range(WIDTH):
                below = corners[faces_below(tree, node, at)].reshape(-1, 3)
                if len(below):
                    away = np.linalg.norm(below - parts[:3, at], axis=1).max()
                    assert parts[6:, at].max() <= away * (1 + 1e-5) + 1e-7

    def test_memory_is_that_of_the_arrays(self, index):
        assert index.tree.nbytes == sum(array.nbytes for array in index.tree[:3])


class TestSetLowerBounds:
    def test_bounds_are_below_the_distance_of_every_corner_and_middle(self, index):
        corners = (index.vertices[index.faces] - index.centre) * index.tree.scale
        held = np.concatenate([corners, corners.mean(axis=1, keepdims=True)], axis=1)
        random = np.random.default_rng(2)
        points = np.concatenate([random.uniform(-2, 2, (20, 3)), corners[:5, 0], 1e9 * np.eye(3)])
        squares = np.empty(WIDTH)
        for node in range(len(index.tree.first)):
            for at in range(WIDTH):
                below = held[faces_below(index.tree, node, at)].reshape(-1, 3)
                for point in points:
                    set_lower_bounds(*point, index.tree.cylinders, node, squares)
                    if not len(below):
                        assert squares[at] == np.inf
                        continue
                    least = ((below - point) ** 2).sum(axis=1).min()
                    assert squares[at] <= least * (1 + 1e-12) + 1e-28

    def test_the_cylinder_of_a_face_is_tight(self, rough):
        """Above a face its bound is the distance, within the rounding of float32."""
        index = build_index(*rough(12, 300, 0.0))
        tree = index.tree
        squares = np.empty(WIDTH)
        for node in np.flatnonzero(tree.first < 0):
            for at in range(WIDTH):
                for face in faces_below(tree, node, at):
                    corners = (index.vertices[index.faces[face]] - index.centre) * tree.scale
                    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
                    normal /= np.linalg.norm(normal)
                    above = corners.mean(axis=0) + 0.5 * normal
                    set_lower_bounds(*above, tree.cylinders, node, squares)
                    assert abs(np.sqrt(squares[at]) - 0.5) < 1e-5
