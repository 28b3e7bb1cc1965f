"""Mapping by the class: spaces, shapes and device values; the methods have tests of their own."""

import numpy as np
import pytest

from gamutcore import Gamut
from gamutcore.errors import InvalidPointsError, OptionError

CUBE = 20 * (2.0 * np.array(list(np.ndindex(2, 2, 2))) - 1) + (50, 0, 0)


@pytest.fixture(scope="module")
def cube():
    return Gamut(CUBE, gamma=1)


@pytest.mark.parametrize("method", ["clip-nearest", "clip-hue", "clip-chroma", "clip-focal"])
def test_colours_arrive_inside_and_those_inside_stay(cube, method):
    colours = np.random.default_rng(1).uniform(-40, 40, (50, 2, 3)) + np.array([50, 0, 0])
    found = cube.map(colours, method)
    inside = cube.contains(colours)
    assert cube.contains(found.points).all()
    np.testing.assert_array_equal(found.moved, ~inside)
    np.testing.assert_array_equal(found.points[inside], colours[inside])
    assert (found.delta_e[inside] == 0).all()
    assert (found.delta_e[~inside] > 0).all()


def test_colours_come_back_in_their_space(cube):
    found = cube.map([(50, 35, 90)], "Clip Chroma", space="LCHab")
    np.testing.assert_allclose(found.points, [(50, 20, 90)], atol=1e-3)
    focal = cube.map([(50, 40, 0)], "clip-focal", focus=(50, 20, 180), space="LCHab")
    np.testing.assert_allclose(focal.points, [(50, 20, 0)], atol=1e-3)


def test_compression_needs_a_source(cube):
    with pytest.raises(OptionError, match="source"):
        cube.map([(50, 0, 0)], "sgck")
    source = Gamut(1.5 * (CUBE - np.array([50, 0, 0])) + np.array([50, 0, 0]), gamma=1)
    mapped = cube.map([(50, 28, 0), (50, 0, 0)], "sgck", source=source)
    assert mapped.points[0, 1] < 28
    assert cube.contains(mapped.points).all()
    with pytest.raises(OptionError, match="CIELAB and Oklab"):
        cube.map([(50, 0, 0)], "sgck", source=Gamut(CUBE, gamma=1, space="Oklab"))


def test_what_is_refused(cube):
    with pytest.raises(OptionError) as caught:
        cube.map([(50, 0, 0)], "clip-hues")
    assert "clip-hue" in caught.value.remedy
    with pytest.raises(InvalidPointsError):
        cube.map([(50, 0, np.nan)])
    with pytest.raises(OptionError, match="hue"):
        Gamut(CUBE, gamma=1, space="CIEXYZ").map([(0.5, 0.5, 0.5)], "clip-hue")


@pytest.mark.slow
def test_device_values_exist_on_the_surface(fogra39):
    press = Gamut(fogra39, surface_samples=2000)
    found = press.map([(50, 0, 0), (50, 110, 0)])
    assert np.isnan(found.device[0]).all()
    assert found.device[1, 1] > 0.9  # magenta
