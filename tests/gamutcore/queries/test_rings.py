"""Gamut rings of cylinders, cones and spheres, and their sums."""

import numpy as np
import pytest

from gamutcore.errors import InvalidPointsError, OptionError
from gamutcore.queries import compare
from gamutcore.queries.rings import LIGHTNESSES, gamut_rings

SIDES = 720


@pytest.fixture(scope="module")
def cylinder():
    """Return a function that gives a cylinder of lightness 0 to 100 around the axis."""

    def make(radius):
        angle = np.arange(SIDES) * 2 * np.pi / SIDES
        circle = radius * np.column_stack([np.zeros(SIDES), np.cos(angle), np.sin(angle)])
        up = np.array([100.0, 0, 0])
        vertices = np.vstack([circle, circle + up, [np.zeros(3), up]])
        here, there = np.arange(SIDES), (np.arange(SIDES) + 1) % SIDES
        low, high = np.full(SIDES, 2 * SIDES), np.full(SIDES, 2 * SIDES + 1)
        faces = [
            (here, there, there + SIDES),
            (here, there + SIDES, here + SIDES),
            (there, here, low),
            (here + SIDES, there + SIDES, high),
        ]
        faces = np.concatenate([np.column_stack(each) for each in faces])
        return vertices, faces, np.array([50.0, 0, 0])

    return make


class TestGamutRings:
    def test_of_a_cylinder(self, cylinder):
        """Chroma C up to L: r² Δh / 2 = C² Δh / 2 · L."""
        found = gamut_rings(cylinder(40))
        np.testing.assert_array_equal(found.lightness, np.arange(10, 101, 10))
        np.testing.assert_array_equal(found.hues, np.arange(360) + 0.5)
        expected = 40 * np.sqrt(found.lightness)
        np.testing.assert_allclose(found.radius, np.tile(expected, (360, 1)).T, rtol=1e-5)

    @pytest.mark.slow
    def test_of_a_sphere(self, icosphere):
        """The cap of height H has the volume π H² (R − H / 3)."""
        mesh = icosphere(5, 40.0, (50.0, 0.0, 0.0))
        found = gamut_rings((mesh.vertices, mesh.faces, (50.0, 0.0, 0.0)), sectors=12)
        height = np.clip(found.lightness - 10, 0, 80)
        expected = np.sqrt(height**2 * (40 - height / 3))
        np.testing.assert_allclose(found.radius, np.tile(expected, (12, 1)).T, rtol=3e-3)

    def test_the_outer_ring_encloses_the_volume_and_rings_do_not_cross(self, rough):
        level = rough(2, 300)
        found = gamut_rings(level, lightness=[*LIGHTNESSES, 120])
        whole = compare(level, level, 360)
        assert found.volume == pytest.approx(whole.volume_a)
        areas = found.radius[-1] ** 2 * np.radians(1) / 2
        np.testing.assert_allclose(areas, whole.sectors.volume_a, rtol=1e-9)
        assert (np.diff(found.radius, axis=0) >= 0).all()
        assert found.reference_radius is None is found.intersection_radius

    def test_with_a_smaller_cylinder_as_reference(self, cylinder):
        found = gamut_rings(cylinder(40), cylinder(20), sectors=36)
        np.testing.assert_allclose(found.reference_radius[-1], 200, rtol=1e-5)
        # a band has the area 40² · 10 per Δh / 2, of which the intersection has a quarter
        inner = found.lightness - 10
        expected = np.sqrt(1600 * inner + 400 * 10)
        np.testing.assert_allclose(
            found.intersection_radius, np.tile(expected, (36, 1)).T, rtol=1e-5
        )

    def test_with_a_larger_reference_the_bands_are_full(self, cylinder):
        found = gamut_rings(cylinder(20), cylinder(40), sectors=36)
        np.testing.assert_allclose(found.intersection_radius, found.radius, rtol=1e-9)

    def test_the_intersection_is_that_of_the_comparison(self, rough):
        one, (vertices, faces, centre) = rough(3, 100), rough(4, 120)
        shift = np.array([2.0, 15, -8])
        other = vertices + shift, faces, centre + shift
        found = gamut_rings(one, other, sectors=24, lightness=[*LIGHTNESSES, 120])
        bands = found.intersection_radius**2 - np.vstack([np.zeros(24), found.radius[:-1] ** 2])
        by_hue = bands.sum(axis=0) * np.radians(15) / 2
        np.testing.assert_allclose(by_hue, compare(one, other, 24).sectors.intersection, rtol=1e-8)
        assert (found.intersection_radius <= found.radius + 1e-9).all()

    def test_colours_above_the_last_lightness_are_left_out(self, cylinder):
        found = gamut_rings(cylinder(40), lightness=[25], sectors=4)
        assert found.volume == pytest.approx(np.pi * 1600 * 25, rel=1e-4)

    @pytest.mark.parametrize("lightness", [[], [1, 1], [5, 4], [np.nan], [[1]]])
    def test_lightness_must_increase(self, cube, lightness):
        with pytest.raises(InvalidPointsError) as caught:
            gamut_rings(cube, lightness=lightness)
        assert caught.value.where["field"] == "lightness"

    def test_sectors_are_checked(self, cube):
        with pytest.raises(OptionError):
            gamut_rings(cube, sectors=0)
