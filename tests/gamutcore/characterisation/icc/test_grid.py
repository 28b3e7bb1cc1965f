from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import RegularGridInterpolator

from gamutcore.characterisation.icc.grid import Grid
from gamutcore.errors import UnsupportedProfileError


def random_grid(nodes, seed=0):
    table = np.random.default_rng(seed).integers(0, 65536, (*nodes, 3), dtype=np.uint16)
    return Grid(nodes, table.reshape(-1, 3)), table


@pytest.mark.parametrize("nodes", [(5,), (2, 3), (4, 3, 2), (3, 3, 3, 3), (2, 2, 3, 2, 2, 2, 3)])
def test_it_is_scipys_multilinear_interpolation(nodes):
    grid, table = random_grid(nodes)
    points = np.random.default_rng(1).random((200, len(nodes)))
    points[:50] = points[:50].round()
    axes = [np.linspace(0, 1, n) for n in nodes]
    expected = RegularGridInterpolator(axes, table / 65535.0)(points)
    np.testing.assert_allclose(grid.values(points), expected, atol=1e-12)


def test_nodes_are_returned_exactly():
    grid, table = random_grid((3, 4))
    points = np.array([[0, 0], [0.5, 1 / 3], [1, 1], [0, 1]])
    np.testing.assert_allclose(
        grid.values(points) * 65535, table[[0, 1, 2, 0], [0, 1, 3, 3]], atol=1e-9
    )


def test_positions_beyond_the_grid_are_cut_off():
    grid, table = random_grid((3, 3))
    hostile = np.array([[-1, 5], [np.inf, -np.inf], [np.nan, np.nan], [1e300, -1e300]])
    np.testing.assert_allclose(
        grid.values(hostile) * 65535, table[[0, 2, 0, 2], [2, 0, 0, 0]], atol=1e-9
    )


def test_a_grid_of_many_dimensions_is_refused_only_between_its_nodes():
    grid, _ = random_grid((2,) * 15)
    corners = np.random.default_rng(2).integers(0, 2, (50_000, 15)).astype(float)
    assert grid.values(corners).shape == (50_000, 3)
    with pytest.raises(UnsupportedProfileError):
        grid.values(np.full((50_000, 15), 0.5))
