"""The derivatives of ΔE00: compared with differences of the formula."""

import numpy as np
import pytest

from gamutcore.queries.ciede2000_slope import SLOPE, set_slope
from gamutcore.queries.colour_difference import delta_e_2000


def slopes(colours, others):
    """Return what `set_slope` sets for pairs of colours."""
    rows = np.empty((len(colours), SLOPE))
    for row, (colour, other) in enumerate(zip(colours, others, strict=True)):
        state = np.append(colour, np.hypot(*colour[1:]))
        assert set_slope(state, *other, rows[row]) == rows[row, -1]
    return rows


def half_square_gradient(colours, others, step=1e-5):
    """Return the gradient of half the square of ΔE00 by central differences."""
    sides = [
        delta_e_2000(colours, others + step * axis) ** 2
        - delta_e_2000(colours, others - step * axis) ** 2
        for axis in np.eye(3)
    ]
    return np.column_stack(sides) / (4 * step)


class TestSetSlope:
    @pytest.mark.parametrize("spread", [0.5, 10, 40])
    def test_gradient_is_that_of_the_formula(self, spread):
        random = np.random.default_rng(1)
        others = random.uniform((0, -100, -100), (100, 100, 100), (3000, 3))
        colours = others + spread * random.normal(size=others.shape)
        # away from the neutral axis and from opposite hues, where there is no derivative
        chroma = np.minimum(np.hypot(*colours[:, 1:].T), np.hypot(*others[:, 1:].T))
        kept = (chroma > 1) & ((colours[:, 1:] * others[:, 1:]).sum(axis=1) > 0)
        assert kept.sum() > 2000
        rows = slopes(colours[kept], others[kept])
        value = delta_e_2000(colours[kept], others[kept])
        np.testing.assert_allclose(rows[:, 9], value, atol=1e-9)
        expected = half_square_gradient(colours[kept], others[kept])
        scale = 1 + np.abs(expected).max(axis=1, keepdims=True)
        assert (np.abs(rows[:, :3] - expected) < 1e-5 * scale).all()

    def test_gradient_follows_from_the_derivatives_of_the_residuals(self):
        """Near a colour the square is the quadratic form of the derivatives."""
        random = np.random.default_rng(2)
        colours = random.uniform((0, -100, -100), (100, 100, 100), (500, 3))
        offset = 1e-3 * random.normal(size=colours.shape)
        rows = slopes(colours, colours + 1e-9)
        light = rows[:, 3] * offset[:, 0]
        u = rows[:, 4] * offset[:, 1] + rows[:, 5] * offset[:, 2]
        v = rows[:, 6] * offset[:, 1] + rows[:, 7] * offset[:, 2]
        form = np.sqrt(light**2 + u**2 + v**2 + rows[:, 8] * u * v)
        np.testing.assert_allclose(form, delta_e_2000(colours, colours + offset), rtol=2e-3)

    def test_neutral_and_opposite_colours_have_a_value(self):
        grey, red = np.array([50.0, 0, 0]), np.array([40.0, 30, 10])
        pairs = [(grey, grey + 1), (grey, grey), (red, grey), (red, -red), (grey, red)]
        colours, others = (np.array(side) for side in zip(*pairs, strict=True))
        rows = slopes(colours, others)
        assert np.isfinite(rows).all()
        np.testing.assert_allclose(rows[:, 9], delta_e_2000(colours, others), atol=1e-12)
        # of a neutral colour there is a gradient
        expected = half_square_gradient(colours[[0, 4]], others[[0, 4]])
        np.testing.assert_allclose(rows[[0, 4], :3], expected, atol=1e-6)
