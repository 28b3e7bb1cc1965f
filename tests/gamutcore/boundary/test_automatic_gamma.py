"""The values of γ that are tried, and the sign of a boundary that fell into inner points."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gamutcore.boundary.automatic_gamma import SCATTERED, has_fallen, surface_gammas


@given(points=st.integers(8, 5_000_000), closed=st.booleans())
def test_values_ascend_to_that_of_the_paper(points, closed):
    values = list(surface_gammas(points, closed=closed))
    assert values == sorted(set(values))
    assert values[-1] == SCATTERED == 0.2
    assert values[0] > 0


@given(points=st.integers(10_000, 1_000_000))
def test_four_times_as_many_points_have_half_the_angle(points):
    first, fourth = (next(surface_gammas(n, closed=False)) for n in (points, 4 * points))
    assert fourth == pytest.approx(first / 2, abs=1e-4)


@pytest.mark.parametrize(
    ("loss", "fallen"), [(-0.01, False), (0.0, False), (0.0002, False), (0.001, True)]
)
def test_a_boundary_that_lost_volume_has_fallen(loss, fallen):
    assert has_fallen(1.0 - loss, 1.0, 100_000) is fallen
