"""The expansion of ΔE00: compared with differences of the formula."""

import numpy as np
import pytest

from gamutcore.kernels import kernel
from gamutcore.queries.ciede2000_expansion import (
    chroma_expansion,
    lightness_expansion,
    steepest_rotation,
)
from gamutcore.queries.colour_difference import delta_e_2000, hue_rotation


@kernel
def expansions(colours, others, found):
    """Set the value, and the derivatives by x, y, z, xx, yy, yz, zz, of half squares of ΔE00."""
    for row in range(len(colours)):
        l, a, b = colours[row, 0], colours[row, 1], colours[row, 2]  # noqa: E741
        x, y, z = others[row, 0], others[row, 1], others[row, 2]
        light, gx, hxx = lightness_expansion(l, x)
        f, gy, gz, hyy, hyz, hzz, _, _ = chroma_expansion(a, b, np.sqrt(a * a + b * b), y, z)
        found[row, 0], found[row, 1], found[row, 2], found[row, 3] = light + f, gx, gy, gz
        found[row, 4], found[row, 5], found[row, 6], found[row, 7] = hxx, hyy, hyz, hzz


def half_square(colours, others):
    return 0.5 * delta_e_2000(colours, others) ** 2


class TestExpansion:
    @pytest.mark.parametrize("spread", [0.5, 10, 60])
    def test_derivatives_are_those_of_the_formula(self, spread):
        random = np.random.default_rng(1)
        others = random.uniform((0, -100, -100), (100, 100, 100), (4000, 3))
        colours = others + spread * random.normal(size=others.shape)
        # away from the neutral axis, opposite hues, and hue 0, where equation 16 jumps by 1e-5
        chroma = np.minimum(np.hypot(*colours[:, 1:].T), np.hypot(*others[:, 1:].T))
        kept = (chroma > 3) & ((colours[:, 1:] * others[:, 1:]).sum(axis=1) > 0)
        kept &= (colours[:, 1] + others[:, 1] < 0) | (np.abs(colours + others)[:, 2] > 5)
        kept &= np.abs((colours + others)[:, 2]) > 0.2 * spread
        colours, others = colours[kept], others[kept]
        assert len(colours) > 1500
        found = np.empty((len(colours), 8))
        expansions(colours, others, found)
        value = half_square(colours, others)
        assert (np.abs(found[:, 0] - value) <= 3e-5 * value + 1e-12).all()
        size = 1e-3
        steps = size * np.eye(3)
        for axis in range(3):
            sides = [half_square(colours, others + sign * steps[axis]) for sign in (1, -1)]
            expected = (sides[0] - sides[1]) / (2 * size)
            assert (np.abs(found[:, 1 + axis] - expected) <= 1e-3 * (1 + np.abs(expected))).all()
        for place, one, two in ((4, 0, 0), (5, 1, 1), (6, 1, 2), (7, 2, 2)):
            corners = [
                half_square(colours, others + p * steps[one] + q * steps[two])
                for p, q in ((1, 1), (1, -1), (-1, 1), (-1, -1))
            ]
            expected = (corners[0] - corners[1] - corners[2] + corners[3]) / (4 * size**2)
            assert (np.abs(found[:, place] - expected) <= 1e-3 * (1 + np.abs(expected))).all()

    def test_neutral_colours_give_numbers(self):
        grey = np.array([50.0, 0.0, 0.0])
        colours = np.array([grey, grey, (40, 30, 10)])
        others = np.array([grey, (60, 20, -5), grey])
        found = np.empty((3, 8))
        expansions(colours, others, found)
        assert np.isfinite(found[1]).all()
        np.testing.assert_allclose(found[1, 0], half_square(colours, others)[1], rtol=1e-4)


def test_steepest_rotation_is_an_upper_limit():
    random = np.random.default_rng(2)
    for hue in np.radians(random.uniform(0, 360, 300)):
        for slack in (0.0, 0.1, 1.0):
            limit = steepest_rotation(np.cos(hue), np.sin(hue), slack)
            for turn in np.linspace(-slack, slack, 9):
                assert hue_rotation(np.cos(hue + turn), np.sin(hue + turn), 0.0) <= limit + 3e-6
