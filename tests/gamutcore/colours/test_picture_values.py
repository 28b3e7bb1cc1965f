"""Values for colours, against the values that the colours are from and a search over a grid."""

import numpy as np
import pytest

from gamutcore.characterisation.pictures.encoding import SRGB, code_point_encoding
from gamutcore.characterisation.pictures.picture import Picture
from gamutcore.colours.picture_colours import picture_colours
from gamutcore.colours.picture_values import ACCURACY, find_values


def forward(encoding):
    def colours(values):
        once = np.ones(len(values), np.int64)
        return picture_colours(Picture("png", "RGB", values, once, encoding), "relative").points

    return colours


@pytest.mark.parametrize("codes", [(1, 13), (12, 13), (9, 16), (9, 18), (1, 4), (1, 8)])
def test_the_values_of_colours_are_found_from_other_values(codes):
    """sRGB, Display P3, PQ, HLG, a power and linear light."""
    colours = forward(code_point_encoding(*codes))
    random = np.random.default_rng(1)
    values = random.uniform(0.02, 1, (500, 3))
    start = np.clip(values + random.uniform(-0.2, 0.2, values.shape), 0, 1)
    found, distance = find_values(colours(values), start, colours)
    assert distance.max() <= ACCURACY
    # dark values of one channel hardly matter beside bright ones of the others
    np.testing.assert_allclose(found, values, atol=5e-4)


def test_black_white_and_primaries_are_found():
    colours = forward(SRGB)
    corners = np.array(list(np.ndindex(2, 2, 2)), np.float64)
    found, distance = find_values(colours(corners), np.full((8, 3), 0.5), colours)
    np.testing.assert_allclose(found, corners, atol=1e-4)
    assert distance.max() <= ACCURACY


def test_colours_outside_get_the_nearest_of_the_range():
    colours = forward(SRGB)
    wanted = np.array([[60.0, 110, 0], [90, -120, 40], [40, 40, -130], [105, 0, 0]])
    found, distance = find_values(wanted, np.full((4, 3), 0.5), colours)
    assert found.min() >= 0
    assert found.max() <= 1
    grid = colours(np.array(list(np.ndindex(41, 41, 41))) / 40)
    nearest = np.linalg.norm(grid[:, np.newaxis] - wanted, axis=2).min(axis=0)
    assert (distance <= nearest + 1e-6).all()


def test_no_colours():
    found, distance = find_values(np.empty((0, 3)), np.empty((0, 3)), forward(SRGB))
    assert len(found) == len(distance) == 0
