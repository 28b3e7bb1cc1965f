"""Lookup tables over the unit cube."""

import numpy as np
import pytest

from gamutcore.colours import LookupTable, cube_nodes


def test_a_linear_function_is_exact_and_nodes_are_kept() -> None:
    matrix = np.random.default_rng(1).normal(size=(3, 4))
    table = LookupTable.sample(lambda points: points @ matrix + 1.0, 7)
    points = np.random.default_rng(2).random((500, 3))
    np.testing.assert_allclose(table.values(points), points @ matrix + 1.0, atol=1e-13)
    nodes = np.random.default_rng(3).random((5, 5, 5, 3))
    assert np.array_equal(LookupTable(nodes).values(cube_nodes(5)), nodes.reshape(-1, 3))


def test_each_tetrahedron_has_the_barycentric_mean_of_its_corners() -> None:
    corners = np.random.default_rng(4).random((2, 2, 2, 2))
    table = LookupTable(corners)
    for point in np.random.default_rng(5).random((50, 3)):
        order = np.argsort(-point)
        path = np.concatenate([np.zeros((1, 3), int), np.cumsum(np.eye(3, dtype=int)[order], 0)])
        # barycentric coordinates of the point in the tetrahedron of the path
        system = np.vstack([path.T, np.ones(4)])
        weights = np.linalg.solve(system, [*point, 1.0])
        assert weights.min() >= 0.0
        np.testing.assert_allclose(
            table.values(point[np.newaxis])[0], weights @ corners[tuple(path.T)], atol=1e-14
        )


def test_points_outside_are_clipped() -> None:
    table = LookupTable.sample(np.asarray, 3)
    given = np.array([(-1.0, 2.0, np.inf), (np.nan, 0.3, -np.inf)])
    np.testing.assert_allclose(table.values(given), [(0.0, 1.0, 1.0), (0.0, 0.3, 0.0)], atol=1e-15)


def test_other_shapes_are_refused() -> None:
    with pytest.raises(ValueError, match=r"Give \(n, n, n, k\)"):
        LookupTable(np.zeros((2, 3, 2, 3)))
