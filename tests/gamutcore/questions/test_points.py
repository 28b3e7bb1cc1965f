"""Questions about single colours, mapping among them, on bodies whose answers are known."""

import numpy as np
import pytest

from gamutcore import Gamut
from gamutcore.errors import InvalidPointsError, OptionError

CUBE = 20 * (2.0 * np.array(list(np.ndindex(2, 2, 2))) - 1) + (50, 0, 0)


@pytest.fixture(scope="module")
def cube():
    return Gamut(CUBE, gamma=1)


@pytest.fixture
def colours():
    return np.random.default_rng(3).uniform(-45, 45, (300, 3)) + np.array([50, 0, 0])


def box_distance(colours):
    """Signed distance from a cube (Quilez, Distance functions)."""
    beyond = np.abs(colours - (50, 0, 0)) - 20
    outside = np.linalg.norm(np.maximum(beyond, 0), axis=1)
    return outside + np.minimum(beyond.max(axis=1), 0)


class TestDistance:
    def test_is_that_of_the_body(self, cube, colours):
        np.testing.assert_allclose(cube.distance(colours), box_distance(colours), atol=1e-3)
        assert cube.distance(colours.reshape(3, 100, 3)).shape == (3, 100)

    def test_classes_have_a_tolerance(self, cube, colours):
        distance = box_distance(colours)
        expected = np.select([np.abs(distance) <= 3, distance < 0], ["edge", "inside"], "outside")
        clear = np.abs(np.abs(distance) - 3) > 0.01
        found = cube.classify(colours, tolerance=3)
        assert (found[clear] == expected[clear]).all()
        with pytest.raises(OptionError, match="tolerance"):
            cube.classify(colours, tolerance=-1)


def test_convert(cube):
    assert cube.convert([(50, 20, 90)], "LCHab").round(9).tolist() == [[50, 0, 20]]
    with pytest.raises(InvalidPointsError):
        cube.convert([(50, np.nan, 90)], "LCHab")


class TestNearest:
    def test_is_that_of_the_body(self, cube, colours):
        found = cube.nearest(colours)
        np.testing.assert_allclose(found.distance, np.abs(box_distance(colours)), atol=1e-3)
        np.testing.assert_allclose(np.abs(found.points - (50, 0, 0)).max(axis=1), 20, atol=1e-3)
        outside = box_distance(colours) > 0
        beyond = np.clip(colours, (30, -20, -20), (70, 20, 20))
        np.testing.assert_allclose(found.points[outside], beyond[outside], atol=1e-3)
        assert found.device is None

    def test_metric_is_named_as_in_colour_science(self, cube):
        near = cube.nearest((50, 30, 0), metric="cie 1976")
        np.testing.assert_allclose(
            near.points, cube.nearest((50, 30, 0), metric="Euclidean").points
        )
        with pytest.raises(OptionError) as caught:
            cube.nearest((50, 30, 0), metric="CIE 1967")
        assert "CIE 1976" in caught.value.remedy


@pytest.mark.slow
class TestNearestByCiede2000:
    def test_is_better_than_the_euclidean_nearest(self, cube, colours):
        outside = colours[~cube.contains(colours)]
        best, euclidean = (cube.nearest(outside, metric=m) for m in ("CIE 2000", "CIE 1976"))
        assert (best.delta_e <= euclidean.delta_e + 1e-6).all()
        away = np.linalg.norm(best.points - outside, axis=1)
        assert (away >= euclidean.distance - 1e-6).all()
        assert best.delta_e.mean() < 0.99 * euclidean.delta_e.mean()
        assert np.abs(cube.distance(best.points)).max() < 1e-3

    def test_distance_is_that_of_the_metric_everywhere(self, cube, colours):
        """CIEDE2000 by colour-science, with the sign of the body."""
        colour = pytest.importorskip("colour")
        near = cube.nearest(colours, metric="CIE 2000")
        expected = colour.delta_E(colours, near.points, method="CIE 2000")
        np.testing.assert_allclose(near.distance, expected, atol=1e-9)
        np.testing.assert_array_equal(near.distance, near.delta_e)
        sign = np.where(box_distance(colours) > 0, 1, -1)
        found = cube.distance(colours, metric="CIE 2000")
        np.testing.assert_allclose(found, sign * expected, atol=1e-3)

    def test_is_defined_in_cielab(self):
        other = Gamut(CUBE, gamma=1, space="Oklab")
        with pytest.raises(OptionError, match="Oklab"):
            other.nearest((0.5, 0, 0), metric="CIE 2000")
        with pytest.raises(OptionError, match="Oklab"):
            other.distance((0.5, 0, 0), metric="CIE 2000")
        assert other.nearest((0.5, 0.3, 0)).delta_e > 0


class TestCrossings:
    def test_of_a_cube(self, cube):
        found = cube.crossings([(50, 0, -50), (50, 0, 0)], [(50, 0, 50), (50, 40, 0)])
        assert found.offsets.tolist() == [0, 2, 3]
        np.testing.assert_allclose(found.t, [0.3, 0.7, 0.5], atol=1e-4)
        assert found.entering.tolist() == [True, False, False]
        np.testing.assert_allclose(found.points[2], (50, 20, 0), atol=1e-3)

    def test_starts_and_ends_are_broadcast_and_in_a_space(self, cube):
        found = cube.crossings((50, 0, 0), [(50, 60, 0), (50, 60, 90)], space="LCHab")
        assert found.offsets.tolist() == [0, 1, 2]
        np.testing.assert_allclose(found.points[1], (50, 20, 90), atol=1e-3)


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


@pytest.mark.slow
def test_device_values_exist_on_the_surface_and_are_linear_in_a_face(fogra39):
    press = Gamut(fogra39, surface_samples=2000)
    found = press.map([(50, 0, 0), (50, 110, 0)])
    assert np.isnan(found.device[0]).all()
    assert found.device[1, 1] > 0.9  # magenta
    level = press.level(50)
    middles = level.vertices.astype(np.float64)[level.faces].mean(axis=1)
    found = press.nearest(middles, triangles=50)
    assert (found.triangles, found.device_values) == (50, "interpolated")
    assert found.channels == ("C", "M", "Y", "K")
    np.testing.assert_allclose(
        found.device, level.device.values[level.faces].mean(axis=1), atol=1e-6
    )
