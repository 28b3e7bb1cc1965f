"""Sections and rings, with areas and volumes that are known otherwise."""

import manifold3d
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gamutcore.errors import InvalidPointsError, OptionError
from gamutcore.search import compare, gamut_rings, hue_leaf, slice_polygons


def area(x, y):
    """Return the signed area of a polygon, positive if counter-clockwise."""
    return float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum() / 2)


def assert_on_surface(level, section):
    vertices, faces, _ = level
    corners = vertices.astype(np.float64)[faces[section.faces]]
    found = np.einsum("mc,mcx->mx", section.weights, corners)
    np.testing.assert_allclose(found, section.points, atol=1e-11)
    assert section.weights.min(initial=0) >= -1e-12
    np.testing.assert_allclose(section.weights.sum(axis=1), 1)


def ring_with_a_dent():
    """A low cylinder with a deep dent in its top: star-shaped about a point near the bottom."""
    angle = np.arange(16) * np.pi / 8
    circle = np.column_stack([np.zeros(16), np.cos(angle), np.sin(angle)])
    rim, foot = 2 * circle + (4, 0, 0), 2 * circle
    vertices = np.vstack([foot, rim, [(0, 0, 0), (1, 0, 0)]])
    here, there = np.arange(16), (np.arange(16) + 1) % 16
    faces = [
        (here, there, there + 16),
        (here, there + 16, here + 16),
        (there, here, np.full(16, 32)),
        (here + 16, there + 16, np.full(16, 33)),
    ]
    return (
        vertices,
        np.concatenate([np.column_stack(each) for each in faces]),
        np.array([0.5, 0.0, 0.0]),
    )


class TestSlicePolygons:
    @pytest.mark.parametrize("lightness", [-1 + 1e-9, -0.5, 0.0, 0.3, 1.0])
    def test_of_a_cube_through_faces_edges_and_corners(self, cube, lightness):
        found = slice_polygons(cube, (3, 0, 0), 3 * lightness)
        (polygon,) = found.polygons
        assert area(polygon[:, 1], polygon[:, 2]) == pytest.approx(4)
        np.testing.assert_allclose(polygon[:, 0], lightness)
        assert_on_surface(cube, found)

    def test_the_hexagon_of_a_cube_and_its_corner(self, cube):
        found = slice_polygons(cube, (1, 1, 1), 0)
        turned = np.linalg.svd(np.ones((1, 3)))[2]
        turned *= np.sign(np.linalg.det(turned)) * np.sign(turned[0].sum())
        (polygon,) = found.polygons
        across = polygon @ turned[1:].T
        assert abs(area(*across.T)) == pytest.approx(6 * np.sqrt(3) / 4 * 2)
        assert slice_polygons(cube, (1, 1, 1), 3).polygons == []

    @settings(max_examples=40)
    @given(
        seed=st.integers(0, 50),
        lightness=st.floats(10, 90),
        tilt=st.tuples(*[st.floats(-1, 1)] * 2),
    )
    def test_areas_are_those_of_manifold(self, rough, seed, lightness, tilt):
        """The polygons, holes included, have the area that booleans find."""
        level = vertices, faces, _ = rough(seed, 60)
        normal = np.array([1.0, *tilt])
        normal /= np.linalg.norm(normal)
        across = np.linalg.svd(normal[np.newaxis])[2][1:]
        if np.dot(np.cross(*across), normal) < 0:
            across = across[::-1]
        turned = vertices.astype(np.float64) @ np.vstack([across, normal]).T
        solid = manifold3d.Manifold(manifold3d.Mesh64(turned, faces.astype(np.uint64)))
        found = slice_polygons(level, normal, lightness)
        total = sum(area(*(polygon @ across.T).T) for polygon in found.polygons)
        assert total == pytest.approx(solid.slice(lightness).area(), abs=1e-4)
        assert_on_surface(level, found)

    @settings(max_examples=60)
    @given(seed=st.integers(0, 50), corner=st.integers(0, 39))
    def test_through_a_corner_is_the_limit_from_above(self, rough, seed, corner):
        level = vertices, _, _ = rough(seed, 40)
        lightness = float(vertices[corner, 0])
        near = [slice_polygons(level, (1, 0, 0), lightness - below) for below in (0, 1e-9)]
        areas = [sum(area(p[:, 1], p[:, 2]) for p in found.polygons) for found in near]
        assert areas[0] == pytest.approx(areas[1], abs=1e-5)

    def test_holes_are_clockwise(self):
        found = slice_polygons(ring_with_a_dent(), (1, 0, 0), 2.5)
        signed = sorted(area(polygon[:, 1], polygon[:, 2]) for polygon in found.polygons)
        disc = 8 * np.sin(np.pi / 8)
        np.testing.assert_allclose(signed, [-disc, 4 * disc])

    def test_what_is_refused(self, cube):
        for normal, offset in (
            ((0, 0, 0), 0),
            ((1, np.nan, 0), 0),
            ((1, 0), 0),
            ((1, 0, 0), np.inf),
        ):
            with pytest.raises(InvalidPointsError) as caught:
                slice_polygons(cube, normal, offset)
            assert caught.value.where["field"] in {"normal", "offset"}


class TestHueLeaf:
    @pytest.mark.parametrize("hue", [0, 45, 90, 100, 359.5, -30, 765])
    def test_of_a_cube_on_the_axis(self, cube, hue):
        found = hue_leaf(cube, hue)
        (polygon,) = found.polygons
        width = 1 / max(abs(np.cos(np.radians(hue))), abs(np.sin(np.radians(hue))))
        chroma = np.hypot(polygon[:, 1], polygon[:, 2])
        assert area(chroma, polygon[:, 0]) == pytest.approx(2 * width)
        assert_on_surface(cube, found)

    @settings(max_examples=40)
    @given(
        seed=st.integers(0, 50), hue=st.floats(0, 360), shift=st.tuples(*[st.floats(-30, 30)] * 2)
    )
    def test_areas_are_those_of_manifold(self, rough, seed, hue, shift):
        vertices, faces, centre = rough(seed, 60)
        vertices, centre = vertices + np.array([0.0, *shift]), centre + np.array([0.0, *shift])
        radians = np.radians(hue)
        axes = np.array(
            [
                [0, np.cos(radians), np.sin(radians)],
                [1, 0, 0],
                [0, np.sin(radians), -np.cos(radians)],
            ]
        )
        solid = manifold3d.Manifold(manifold3d.Mesh64(vertices @ axes.T, faces.astype(np.uint64)))
        square = manifold3d.CrossSection.square((1e3, 2e3)).translate((0, -1e3))
        expected = (solid.slice(0) ^ square).area()
        found = hue_leaf((vertices, faces, centre), hue)
        leaf = [polygon @ axes[:2].T for polygon in found.polygons]
        assert sum(area(*each.T) for each in leaf) == pytest.approx(expected, abs=1e-4)
        assert all(each[:, 0].min() >= -1e-9 for each in leaf)
        assert abs(found.points @ axes[2]).max(initial=0) < 1e-9
        assert_on_surface((vertices, faces, centre), found)

    def test_need_not_contain_the_axis(self, cube):
        vertices, faces, centre = cube
        shift = np.array([50, 0, 9])
        level = vertices + shift, faces, centre + shift
        assert hue_leaf(level, 270).polygons == []
        (polygon,) = hue_leaf(level, 90).polygons
        assert polygon[:, 2].min() == pytest.approx(8)
        assert area(np.hypot(*polygon.T[1:]), polygon[:, 0]) == pytest.approx(4)

    def test_a_dent_gives_one_polygon_along_two_parts_of_the_axis(self):
        vertices, faces, centre = ring_with_a_dent()
        # beside the axis, the dent splits the leaf; its ends lie on the axis
        shift = np.array([0, 0.5, 0])
        level = vertices - shift, faces, centre - shift
        found = hue_leaf(level, 0)
        on_axis = [polygon[np.hypot(*polygon.T[1:]) < 1e-12, 0] for polygon in found.polygons]
        assert [len(each) for each in on_axis] == [2]


SIDES = 720
LIGHTNESSES = np.arange(10, 101, 10)


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

    def test_the_intersection_is_that_of_the_comparison(self, rough):
        one, (vertices, faces, centre) = rough(3, 100), rough(4, 120)
        shift = np.array([2.0, 15, -8])
        other = vertices + shift, faces, centre + shift
        found = gamut_rings(one, other, sectors=24, lightness=[*LIGHTNESSES, 120])
        bands = found.intersection_radius**2 - np.vstack([np.zeros(24), found.radius[:-1] ** 2])
        by_hue = bands.sum(axis=0) * np.radians(15) / 2
        np.testing.assert_allclose(by_hue, compare(one, other, 24).sectors.intersection, rtol=1e-8)
        assert (found.intersection_radius <= found.radius + 1e-9).all()

    @pytest.mark.parametrize("lightness", [[], [1, 1], [5, 4], [np.nan], [[1]]])
    def test_lightness_must_increase(self, cube, lightness):
        with pytest.raises(InvalidPointsError) as caught:
            gamut_rings(cube, lightness=lightness)
        assert caught.value.where["field"] == "lightness"

    def test_sectors_are_checked(self, cube):
        with pytest.raises(OptionError):
            gamut_rings(cube, sectors=0)
