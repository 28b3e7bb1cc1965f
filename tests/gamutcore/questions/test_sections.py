"""Questions about the shape of a gamut, on a cube."""

import numpy as np
import pytest

from gamutcore import Gamut
from gamutcore.errors import InvalidPointsError, OptionError

CUBE = 20 * (2.0 * np.array(list(np.ndindex(2, 2, 2))) - 1) + (50, 0, 0)


def test_cusps_of_a_square_section():
    hues = np.arange(0, 360, 5.0)
    found = Gamut(CUBE, gamma=1).cusps(hues)
    angle = np.radians((hues + 45) % 90 - 45)
    np.testing.assert_allclose(found.chroma, 20 / np.cos(angle), atol=1e-3)
    np.testing.assert_allclose(np.hypot(*found.points[:, 1:].T), found.chroma)
    assert found.device is None
    assert found.channels == ()
    with pytest.raises(OptionError, match="hue"):
        Gamut(CUBE, gamma=1, space="CIEXYZ").cusps()


def test_hues_are_a_number_or_angles(small_gamut):
    assert small_gamut.cusps(8).hue.tolist() == list(range(0, 360, 45))
    assert small_gamut.cusps(40.5).hue.tolist() == [40.5]
    for hues in (0, 10**6):
        with pytest.raises(OptionError, match="hues"):
            small_gamut.cusps(hues)


@pytest.mark.slow
def test_cusps_have_device_values(fogra39):
    """The most chromatic yellow is solid yellow (ISO 12647-2:2004: 100 % Y at L* 89, b* 93)."""
    found = Gamut(fogra39, surface_samples=3000).cusps([92])
    assert found.channels == ("C", "M", "Y", "K")
    assert found.device[0, 2] > 0.95
    assert found.device[0, 3] < 0.05


def area(polygon):
    x, y = polygon.T
    return (x * np.roll(y, -1) - y * np.roll(x, -1)).sum() / 2


@pytest.fixture(scope="module")
def cube():
    return Gamut(CUBE, gamma=1)


class TestSlice:
    def test_of_a_cube_is_a_square(self, cube):
        for lightness in (35, 50, 65.5):
            (polygon,) = cube.slice(L=lightness).polygons
            np.testing.assert_allclose(polygon[:, 0], lightness)
            assert area(polygon[:, 1:]) == pytest.approx(40**2, rel=1e-5)
        assert cube.slice(L=90).polygons == []

    def test_lightness_is_the_second_axis_of_xyz(self):
        gamut = Gamut(CUBE, gamma=1, space="CIEXYZ")
        (polygon,) = gamut.slice(L=0.2).polygons
        np.testing.assert_allclose(polygon[:, 1], 0.2)

    @pytest.mark.parametrize(
        "choice",
        [{"L": np.nan}, {"hue": np.inf}, {"plane": (0, 0, 0, 1)}],
    )
    def test_numbers_are_finite(self, cube, choice):
        with pytest.raises(InvalidPointsError):
            cube.slice(**choice)

    @pytest.mark.parametrize(
        "choice",
        [{}, {"L": 50, "hue": 0}, {"plane": (1, 0, 0)}, {"plane": (1, 0, 0, 5), "L": 5}],
    )
    def test_needs_one_plane(self, cube, choice):
        with pytest.raises(OptionError):
            cube.slice(**choice)


class TestLeaves:
    def test_of_a_cube(self, cube):
        table = cube.leaves([0, 30, 45], [20, 40, 60])
        expected = 20 / np.cos(np.radians([0, 30, 45]))
        np.testing.assert_allclose(table.largest[:, 1:].T, [expected, expected], atol=1e-3)
        assert np.isnan(table.largest[:, 0]).all()
        assert table.device is None

    def test_lightnesses_are_those_of_the_space(self, cube):
        assert cube.leaves(4, 11).lightness.tolist() == list(range(0, 101, 10))
        oklab = Gamut(CUBE, gamma=1, space="Oklab")
        assert oklab.leaves(4, 11).lightness[-1] == pytest.approx(1, rel=1e-3)

    def test_max_chroma_agrees(self, cube):
        table = cube.leaves(12, [35, 50])
        found = cube.max_chroma([[35, 50]], table.hue[:, np.newaxis])
        np.testing.assert_allclose(found, table.largest, atol=1e-6)
        assert np.isnan(cube.max_chroma(95, 40))


class TestRings:
    @pytest.mark.parametrize(
        ("space", "white"), [("CIELAB", 100), ("Oklab", 1), ("DIN99o", 100), ("CIELUV", 100)]
    )
    def test_go_up_to_the_white_of_the_space(self, space, white):
        gamut = Gamut(CUBE, gamma=1, space=space)
        found = gamut.rings(sectors=12)
        assert found.lightness == pytest.approx(np.arange(1, 11) / 10 * white, rel=2e-3)
        # the darkest and the lightest colour of the cube are L* 30 and 70
        assert found.volume == pytest.approx(gamut.volume, rel=1e-5)
        assert found.radius[0].max() == 0
        assert found.radius[4].mean() < 0.9 * found.radius[-1].mean()

    def test_with_a_reference(self, cube):
        small = Gamut(CUBE / 2 + np.array([25, 0, 0]), gamma=1)
        found = cube.rings(small)
        assert (found.reference_radius <= found.radius + 1e-9).all()
        with pytest.raises(OptionError, match="CIELAB and Oklab"):
            cube.rings(Gamut(CUBE, gamma=1, space="Oklab"))


@pytest.mark.slow
def test_sections_have_device_values(fogra39):
    """A slice at L* 50 needs ink everywhere; white and black are at the ends of a leaf."""
    gamut = Gamut(fogra39, surface_samples=3000)
    device = gamut.slice(L=50).device
    assert device.shape[1] == 4
    assert (device.sum(axis=1) > 0.3).all()
    assert gamut.leaves(8, [-5, 120]).device.shape == (0, 2, 4)
    table = gamut.leaves(8, [50])
    assert np.isnan(table.device[:, 0]).all()  # the intervals begin on the neutral axis
    assert not np.isnan(table.device[:, 1]).any()
