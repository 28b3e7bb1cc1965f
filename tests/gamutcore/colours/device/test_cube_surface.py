from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gamutcore.colours.device.cube_surface import (
    SURFACE_SAMPLES,
    cube_surface,
    cube_surface_count,
    surface_steps,
)
from gamutcore.errors import OptionError, SampleLimitError


@pytest.mark.parametrize("steps", [2, 3, 10, 129])
def test_the_count_of_rgb(steps):
    assert cube_surface_count(3, steps) == 6 * steps**2 - 12 * steps + 8


def test_the_602_points_of_the_idms_measurement():
    # IDMS v1.1: 11 by 11 points on each face of the RGB cube are 602.
    assert len(cube_surface(3, 11)) == 602


@pytest.mark.parametrize(("channels", "faces"), [(2, 1), (3, 6), (4, 24), (7, 672)])
def test_every_two_dimensional_face_is_sampled(channels, faces):
    inner = cube_surface_count(channels, 3) - cube_surface_count(channels, 2)
    edges = channels * 2 ** (channels - 1)
    assert inner == edges + faces


@pytest.mark.parametrize(("channels", "steps"), [(1, 5), (2, 4), (3, 5), (4, 4), (6, 3), (15, 2)])
def test_points_are_distinct_and_on_faces(channels, steps):
    points = cube_surface(channels, steps)
    assert len(points) == cube_surface_count(channels, steps)
    assert len(np.unique(points, axis=0)) == len(points)
    assert np.count_nonzero((points > 0) & (points < 1), axis=1).max(initial=0) <= 2
    np.testing.assert_allclose(points * (steps - 1) % 1, 0, atol=1e-9)


def test_a_face_of_cmyk_is_a_full_grid():
    points = cube_surface(4, 5)
    face = points[(points[:, 1] == 1) & (points[:, 3] == 0)]
    assert len(face) == 25
    assert {tuple(p) for p in face[:, [0, 2]]} == {
        (i / 4, j / 4) for i in range(5) for j in range(5)
    }


@given(st.integers(1, 15), st.integers(8, SURFACE_SAMPLES.most))
def test_as_many_steps_as_fit(channels, wanted):
    steps = surface_steps(channels, wanted)
    assert steps >= 2
    assert steps == 2 or cube_surface_count(channels, steps) <= wanted
    assert cube_surface_count(channels, steps + 1) > wanted


def test_the_default_of_100000_points():
    assert cube_surface_count(3, surface_steps(3, 100_000)) == 99_848
    assert cube_surface_count(4, surface_steps(4, 100_000)) == 97_288


@pytest.mark.parametrize("wanted", [-1, 0, 7, SURFACE_SAMPLES.most + 1])
def test_a_number_out_of_range_is_refused(wanted):
    with pytest.raises(OptionError) as caught:
        surface_steps(3, wanted)
    assert caught.value.where == {"field": "surface_samples"}


@pytest.mark.parametrize("channels", [0, 16])
def test_other_numbers_of_channels_are_refused(channels):
    with pytest.raises(SampleLimitError):
        surface_steps(channels, 1000)
