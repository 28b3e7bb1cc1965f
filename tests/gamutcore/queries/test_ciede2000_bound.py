"""The lower bound of ΔE00 in a ball: never above a colour of the ball, and near the smallest."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gamutcore.queries.ciede2000_bound import LARGEST_T, STEEPNESS, interval_bound
from gamutcore.queries.colour_difference import delta_e_2000, hue_factor


def balls(seed, count):
    """Return colours and middles: everywhere, near neutral, opposite, and near each other."""
    random = np.random.default_rng(seed)
    middles = random.uniform((0, -110, -110), (100, 110, 110), (count, 3))
    middles[::3, 1:] *= 0.1
    colours = random.uniform((-50, -200, -200), (150, 200, 200), (count, 3))
    near = random.random(count) < 0.4
    colours[near] = middles[near] + random.normal(0, 20, (near.sum(), 3))
    opposite = random.random(count) < 0.2
    colours[opposite, 1:] = -middles[opposite, 1:] * random.uniform(0.1, 2, (opposite.sum(), 1))
    return random, colours, middles


def bound(colour, middle, radius):
    """Return the bound of ΔE00 to the colours of a ball."""
    chroma = np.hypot(*middle[1:])
    turn = np.arcsin(radius / chroma) if radius < chroma else np.pi
    lightness, chromas = middle[0] - radius, (max(chroma - radius, 0.0), chroma + radius)
    found = interval_bound(
        *colour,
        np.hypot(*colour[1:]),
        lightness,
        lightness + 2 * radius,
        *middle[1:],
        *chromas,
        turn,
    )
    return np.sqrt(2 * found)


class TestIntervalBound:
    @pytest.mark.parametrize("radius", [0.1, 2.0, 10.0, 60.0])
    def test_is_below_the_difference_to_every_colour_of_the_ball(self, radius):
        random, colours, middles = balls(1, 3000)
        bounds = np.array(
            [bound(one, two, radius) for one, two in zip(colours, middles, strict=True)]
        )
        for _ in range(40):
            offset = random.normal(size=middles.shape)
            offset *= radius * random.random((len(middles), 1)) ** 0.2
            offset /= (
                np.linalg.norm(offset, axis=1, keepdims=True) / radius
                if radius == 0.1
                else (np.maximum(np.linalg.norm(offset, axis=1, keepdims=True) / radius, 1.0))
            )
            assert (bounds <= delta_e_2000(colours, middles + offset) + 1e-9).all()

    def test_of_a_point_is_nearly_the_difference(self):
        _, colours, middles = balls(2, 3000)
        along = (colours[:, 1:] * middles[:, 1:]).sum(axis=1)
        same_side = along > 0
        expected = delta_e_2000(colours, middles)[same_side]
        found = [
            bound(one, two, 0.0)
            for one, two in zip(colours[same_side], middles[same_side], strict=True)
        ]
        assert (found <= expected * (1 + 1e-9) + 1e-9).all()
        assert np.median(found / expected) > 0.98

    @settings(max_examples=100, deadline=None)
    @given(degrees=st.floats(0, 360), step=st.floats(0, 60))
    def test_limits_of_t_hold(self, degrees, step):
        here, there = (
            hue_factor(np.cos(np.radians(hue)), np.sin(np.radians(hue)))
            for hue in (degrees, degrees + step)
        )
        assert here <= LARGEST_T
        assert abs(there - here) <= STEEPNESS * np.radians(step) + 1e-12
