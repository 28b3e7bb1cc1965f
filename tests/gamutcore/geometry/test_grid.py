"""The grid: fine enough, exact in float32, and a power of two at any scale."""

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from gamutcore.geometry import grid_step, mesh_grid_step, nearest_grid_points


@given(
    st.lists(st.tuples(*[st.floats(-1.0, 1.0)] * 3), min_size=2, max_size=20),
    st.sampled_from([1e-30, 1e-10, 1.0, 300.0, 1e9]),
    st.sampled_from([0.0, 1.0, 5000.0]),
)
def test_rounded_points_are_exact_in_float32_and_near(points, scale, shift):
    points = (np.array(points) + shift) * scale
    if not np.abs(points).max() > 0:
        return
    step = grid_step(points)
    rounded = nearest_grid_points(points, step)
    assert math.frexp(step)[0] == 0.5
    assert np.array_equal(rounded.astype(np.float32).astype(np.float64), rounded)
    assert np.abs(rounded - points).max() <= step / 2
    assert np.array_equal(np.rint(rounded / step), rounded / step)
    assert np.array_equal(nearest_grid_points(rounded, step), rounded)
    assert not np.signbit(rounded[rounded == 0]).any()


def box(extents):
    corners = np.stack(np.meshgrid(*[(-1.0, 1.0)] * 3), axis=-1).reshape(-1, 3)
    return corners * np.asarray(extents) / 2


@given(st.floats(1e-3, 1e3), st.integers(-10, 10))
def test_the_step_scales_with_the_points(extent, power):
    points = box((extent, extent, extent))
    assert grid_step(points * 2.0**power) == grid_step(points) * 2.0**power
    assert extent * 2.0**-18 <= grid_step(points) < extent * 2.0**-17 * (1 + 1e-15)


def test_a_few_spikes_do_not_coarsen_it():
    points = np.vstack([np.tile(box((1.0, 1.0, 1.0)), (10, 1)), 9 * np.eye(3)])
    assert grid_step(points) == grid_step(box((1.0, 1.0, 1.0)))


def test_far_from_the_origin_float32_sets_the_step():
    points = np.array([[1e6, 1e6, 1e6], [1e6 + 1, 1e6, 1e6]])
    assert grid_step(points) == 2.0**20 * 2.0**-22


def test_a_single_point_has_a_step_too():
    assert grid_step([[3.0, 0.0, 0.0]]) == 4.0 * 2.0**-22
    assert grid_step([[0.0, 0.0, 0.0]]) > 0


@given(st.lists(st.tuples(*[st.integers(-(2**20), 2**20)] * 3), min_size=4, max_size=20))
def test_the_grid_of_a_mesh_is_never_coarser_than_the_one_it_is_on(whole):
    points = np.array(whole) * 2.0**-12
    step = mesh_grid_step(points)
    assert step <= grid_step(points)
    assert np.array_equal(nearest_grid_points(points, step), points)


def test_a_mesh_of_whole_numbers_has_a_grid_fine_enough_for_what_comes_between():
    assert mesh_grid_step(box((64.0, 64.0, 64.0))) == 2.0**-12


def test_a_mesh_of_any_float32_numbers_is_kept_as_far_as_its_largest_is_resolved():
    points = np.random.default_rng(1).uniform(-100, 100, (50, 3)).astype(np.float32)
    step = mesh_grid_step(points)
    assert step == 128 * 2.0**-22
    assert np.abs(nearest_grid_points(points, step) - points).max() <= step / 2
