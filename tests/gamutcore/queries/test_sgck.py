"""SGCK, compared with an independent implementation from the equations of CIE 156:2004."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from gamutcore.queries import build_index, contains, cusp_points, map_colours

SOURCE_SCALE = 1.25


def sphere(rough, scale):
    vertices, faces, centre = rough(9, 30_000, 0.0)
    level = (vertices - centre) * scale + (50, 0, 0), faces, np.array([50.0, 0, 0])
    return level, 40 * scale


def sigmoid(lightness, chroma, low, high, darkest, lightest):
    """Return the lightness of CIE 156:2004, with a sum over 2,000 steps for the sigmoid."""
    table = {5: (53.7, 43.0), 10: (56.8, 40.0), 15: (58.2, 35.0), 20: (60.6, 34.5)}
    below = min(max(math.floor(darkest / 5) * 5, 5), 20)
    part = min(max((darkest - below) / 5, 0), 1)
    (x0, s0), (x1, s1) = table[below], table[min(below + 5, 20)]
    mean, deviation = x0 + part * (x1 - x0), s0 + part * (s1 - s0)
    steps = (np.arange(2000) + 0.5) / 20
    density = np.exp(-((steps - mean) ** 2) / (2 * deviation**2))
    total = np.concatenate([[0], np.cumsum(density)]) / density.sum()
    scaled = 100 * (lightness - low) / (high - low)
    sigmoidal = darkest + (lightest - darkest) * np.interp(scaled, np.arange(2001) / 20, total)
    weight = 1 - math.sqrt(chroma**3 / (chroma**3 + 5e5))
    return weight * sigmoidal + (1 - weight) * lightness


class TestSgck:
    @pytest.mark.parametrize("radius", [38, 30])
    @pytest.mark.slow
    def test_of_spheres_is_what_the_equations_say(self, rough, radius):
        """Facets of 30,000 points are within 0.03 of the spheres, and the poles of them."""
        level, _ = sphere(rough, radius / 40)
        source, wide = sphere(rough, SOURCE_SCALE)
        index = build_index(*level)
        limits = 50 - wide, 50 + wide, *index.box[:, 0]
        random = np.random.default_rng(1)
        colours = random.normal(size=(60, 3))
        colours *= (
            wide * random.uniform(0, 0.99, (60, 1)) / np.linalg.norm(colours, axis=1, keepdims=True)
        )
        colours += source[2]
        found = map_colours(colours, index, "sgck", source=source).points
        hues = np.degrees(np.arctan2(colours[:, 2], colours[:, 1]))
        focal = cusp_points(hues, index).points[:, 0]
        for colour, result, focus in zip(colours, found, focal, strict=True):
            chroma = math.hypot(*colour[1:])
            lightness = sigmoid(colour[0], chroma, *limits)
            rise, run = lightness - focus, chroma
            length = math.hypot(rise, run)
            u, v = rise / length, run / length
            b = (focus - 50) * u
            surface = -b + math.sqrt(b * b - (focus - 50) ** 2 + radius**2)

            def beyond(distance, u=u, v=v, focus=focus):
                """Negative if the source, after the mapping of lightness, has the point."""
                c = v * distance
                if c >= wide:
                    return 1.0 + c - wide  # not 0 at the equator, which is no root
                half = math.sqrt(wide**2 - c**2)
                low, high = (sigmoid(50 + sign * half, c, *limits) for sign in (-1, 1))
                return max(focus + u * distance - high, low - (focus + u * distance))

            limit = brentq(beyond, 0, 3 * wide)
            knee = 0.9 * surface
            distance = length
            if length > knee and limit > surface:
                distance = knee + (length - knee) * 0.1 * surface / (limit - knee)
            distance = min(distance, surface)
            expected = (focus + u * distance, v * distance)
            assert (result[0], math.hypot(*result[1:])) == pytest.approx(expected, abs=0.01)

    @pytest.mark.slow
    def test_keeps_hue_and_order_and_stays_in_gamut(self, rough):
        level, _ = sphere(rough, 0.8)
        source, _ = sphere(rough, SOURCE_SCALE)
        random = np.random.default_rng(2)
        colours = random.uniform((-10, -60, -60), (110, 60, 60), (2000, 3))
        found = map_colours(colours, level, "sgck", source=source)
        assert contains(found.points, level).all()
        across = colours[:, 1] * found.points[:, 2] - colours[:, 2] * found.points[:, 1]
        assert abs(across / np.hypot(colours[:, 1], colours[:, 2])).max() < 1e-9
        greys = np.zeros((200, 3))
        greys[:, 0] = np.linspace(1, 99, 200)
        lightness = map_colours(greys, level, "sgck", source=source).points[:, 0]
        assert (np.diff(lightness) > 0).all()

    @pytest.mark.slow
    def test_lightness_of_white_and_black_is_that_of_the_gamut(self, rough):
        level, radius = sphere(rough, 0.8)
        source, wide = sphere(rough, SOURCE_SCALE)
        index, wide_box = build_index(*level), build_index(*source).box[:, 0]
        ends = np.array([(wide_box[0], 0, 0), (wide_box[1], 0, 0)])
        found = map_colours(ends, index, "sgck", source=source).points
        np.testing.assert_allclose(found[:, 0], [50 - radius, 50 + radius], atol=0.2)
        assert wide > radius
