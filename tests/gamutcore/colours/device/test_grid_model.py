from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import RegularGridInterpolator

from gamutcore.colours.device.grid_model import grid_model
from gamutcore.errors import OptionError


def nodes_of(levels):
    return np.stack(np.meshgrid(*levels, indexing="ij"), axis=-1).reshape(-1, len(levels))


def uneven(counts, seed=0):
    chance = np.random.default_rng(seed)
    return [np.concatenate([[0.0], np.sort(chance.random(n - 2)), [1.0]]) for n in counts]


@pytest.mark.parametrize("counts", [(9,), (4, 3), (5, 4, 6), (3, 5, 2, 4), (3, 2, 3, 2, 3, 2, 3)])
def test_it_is_scipys_interpolation_whatever_the_order_and_spacing(counts):
    chance = np.random.default_rng(1)
    levels = uneven(counts)
    device = nodes_of(levels)
    colours = 100 * chance.random((len(device), 3))
    reference = RegularGridInterpolator(levels, colours.reshape(*counts, 3))
    order = chance.permutation(len(device))
    model = grid_model(device[order], colours[order])
    assert model.shape == counts
    points = chance.random((500, len(counts)))
    np.testing.assert_allclose(model.colours(points), reference(points), atol=3e-5)
    np.testing.assert_allclose(model.colours(device), colours, atol=3e-5)


def test_what_is_missing_or_beside_makes_no_grid():
    device = nodes_of(uneven((4, 4, 4)))
    colours = np.zeros((64, 3))
    assert grid_model(device, colours) is not None
    assert grid_model(device[1:], colours[1:]) is None
    beside = np.concatenate([device, [[0.5, 0.5, 0.123]]])
    assert grid_model(beside, np.zeros((65, 3))) is None
    # As many as a grid of the same levels has, one of them twice within rounding.
    moved = device.copy()
    moved[20] = device[21] + 1e-9
    assert grid_model(moved, colours) is None


def test_values_that_differ_by_rounding_are_one_level():
    device = nodes_of([np.linspace(0, 1, 4)] * 3)
    model = grid_model(device + 1e-8 * np.random.default_rng(0).random(device.shape), device)
    assert model.shape == (4, 4, 4)


def test_a_channel_that_never_varies_has_one_level():
    device = np.insert(nodes_of(uneven((5, 4))), 1, 0.25, axis=1)
    colours = device @ np.diag([100.0, 10.0, 50.0])
    model = grid_model(device, colours)
    assert model.shape == (5, 1, 4)
    points = np.array([[0.3, 0.25, 0.7]])
    np.testing.assert_allclose(model.colours(points), [[30, 2.5, 35]], atol=1e-5)


def test_beyond_the_outermost_levels_values_are_cut_off():
    device = nodes_of([[0.1, 0.4, 0.8]] * 2)
    model = grid_model(device, np.column_stack([device, device[:, 0]]) * 100)
    np.testing.assert_allclose(model.colours(np.array([[0.0, 1.0]])), [[10, 80, 10]], atol=1e-5)


@pytest.mark.parametrize("counts", [(9, 9), (4, 7, 6), (3, 3, 3, 3)])
def test_a_linear_device_leaves_no_error(counts):
    device = nodes_of(uneven(counts))
    colours = 100 * np.column_stack([device.mean(axis=1), device[:, 0], device[:, -1]])
    assert grid_model(device, colours).leave_out_errors().max() < 1e-4


def test_the_errors_are_those_at_the_nodes_left_out():
    """The error of linear interpolation of x² over steps of 2h is h² in the middle."""
    device = np.linspace(0, 1, 9)[:, np.newaxis]
    colours = np.column_stack([64 * device**2, 0 * device, 0 * device])
    model = grid_model(device, colours)
    np.testing.assert_allclose(model.leave_out_errors(), np.ones(4), atol=1e-5)
    # And a quarter of it between the nodes of the whole grid.
    middle = (device[1:] + device[:-1]) / 2
    errors = model.colours(middle)[:, 0] - 64 * middle[:, 0] ** 2
    np.testing.assert_allclose(errors, 0.25, atol=1e-5)


def test_two_levels_leave_nothing_out():
    assert len(grid_model(nodes_of([[0.0, 1.0]] * 3), np.zeros((8, 3))).leave_out_errors()) == 0


def test_what_would_take_too_long_is_refused():
    model = grid_model(nodes_of([[0.0, 1.0]] * 13), np.zeros((8192, 3)))
    with pytest.raises(OptionError) as caught:
        model.colours(np.full((100_000, 13), 0.5))
    assert caught.value.where == {"field": "surface_samples"}
