"""Mapping: properties of all methods, brute force, a sphere, and the equations of CIE 156:2004."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from gamutcore.errors import InvalidPointsError, OptionError
from gamutcore.search import build_index, contains, cusp_points, map_colours

CLIPS = ("clip-nearest", "clip-hue", "clip-lightness", "clip-chroma", "clip-focal")
OF_HUE = CLIPS[1:]


def around_axis(level):
    """Move a level so that the axis goes through its middle."""
    vertices, faces, centre = level
    shift = np.array([0.0, centre[1] + 3, centre[2] - 2])
    return vertices - shift, faces, centre - shift


def section(level, hue):
    """Return the segments of a section in lightness and chroma, (n, 2, 2), from all faces."""
    vertices, faces, _ = level
    along, across = np.array([np.cos(hue), np.sin(hue)]), np.array([-np.sin(hue), np.cos(hue)])
    found = []
    for face in faces:
        corners = vertices[face].astype(np.float64)
        side, chroma = corners[:, 1:] @ across, corners[:, 1:] @ along
        ends = []
        for one, two in ((0, 1), (1, 2), (2, 0)):
            if (side[one] >= 0) != (side[two] >= 0):
                share = side[one] / (side[one] - side[two])
                ends.append(
                    (
                        corners[one, 0] + share * (corners[two, 0] - corners[one, 0]),
                        chroma[one] + share * (chroma[two] - chroma[one]),
                    )
                )
        if ends and max(ends[0][1], ends[1][1]) >= 0:
            (l1, c1), (l2, c2) = ends
            if c1 < 0:
                l1, c1 = l2 + (l1 - l2) * c2 / (c2 - c1), 0.0
            elif c2 < 0:
                l2, c2 = l1 + (l2 - l1) * c1 / (c1 - c2), 0.0
            found.append([(l1, c1), (l2, c2)])
    return np.array(found).reshape(-1, 2, 2)


def distances(segments, point):
    """Return the distances of a point to segments of a plane."""
    start, way = segments[:, 0], segments[:, 1] - segments[:, 0]
    share = np.einsum("ni,ni->n", point - start, way) / np.maximum((way**2).sum(axis=1), 1e-300)
    near = start + np.clip(share, 0, 1)[:, None] * way
    return np.linalg.norm(near - point, axis=1)


def hue_errors(points, mapped):
    """Return how far mapped colours are from the half-planes of their hues."""
    chroma = np.hypot(points[:, 1], points[:, 2])
    across = (points[:, 1] * mapped[:, 2] - points[:, 2] * mapped[:, 1]) / chroma
    behind = -np.minimum((points[:, 1:] * mapped[:, 1:]).sum(axis=1) / chroma, 0)
    return np.hypot(across, behind)


@pytest.fixture(scope="module")
def level(rough):
    return around_axis(rough(21, 400, 0.35))


@pytest.fixture(scope="module")
def colours():
    return np.random.default_rng(0).uniform((-30, -90, -90), (130, 90, 90), (3000, 3))


@pytest.mark.parametrize("method", CLIPS)
class TestAllClips:
    def test_results_are_in_gamut_and_colours_in_gamut_are_not_changed(
        self, level, colours, method
    ):
        index = build_index(*level)
        found = map_colours(colours, index, method)
        inside = contains(colours, index)
        assert 100 < inside.sum() < 2000
        assert contains(found.points, index).all()
        np.testing.assert_array_equal(found.points[inside], colours[inside])
        np.testing.assert_array_equal(found.moved, ~inside)
        np.testing.assert_array_equal(found.faces < 0, inside)
        outside = ~inside
        on_face = np.einsum(
            "nc,ncx->nx", found.weights[outside], index.vertices[index.faces[found.faces[outside]]]
        )
        np.testing.assert_allclose(on_face, found.points[outside], atol=1e-8)
        assert found.weights[outside].min() >= -1e-15
        again = map_colours(found.points, index, method)
        np.testing.assert_array_equal(again.points, found.points)

    def test_hue_is_kept(self, level, colours, method):
        if method == "clip-nearest":
            return
        found = map_colours(colours, level, method)
        assert hue_errors(colours, found.points).max() < 1e-9

    @settings(max_examples=50, deadline=None)
    @given(st.tuples(*[st.sampled_from([-2.0, -1.0, 0.0, 0.5, 1.0, 1e6])] * 3))
    def test_of_a_cube_along_its_sides_edges_and_axis(self, cube, method, colour):
        found = map_colours([colour], cube, method)
        assert contains(found.points, cube).all()
        assert found.moved[0] == (max(map(abs, colour)) > 1)


class TestClips:
    @pytest.mark.slow
    def test_hue_is_the_nearest_point_of_the_section(self, level, colours):
        found = map_colours(colours[:150], level, "clip-hue")
        rows = np.flatnonzero(found.moved)
        assert len(rows) > 50
        for row in rows:
            lightness, a, b = colours[row]
            here = np.array([lightness, np.hypot(a, b)])
            expected = distances(section(level, np.arctan2(b, a)), here).min()
            distance = np.linalg.norm(found.points[row] - colours[row])
            assert distance == pytest.approx(expected, abs=1e-9)

    def test_lightness_keeps_chroma_and_chroma_keeps_lightness(self, cube):
        colours = [(3, 0.5, 0.25), (-2, 0, 0), (0.5, 2, 1), (2, 0.25, 0), (0.25, 3, 0), (0, 4, 4)]
        found = map_colours(colours, cube, "clip-lightness").points
        expected = [(1, 0.5, 0.25), (-1, 0, 0), (np.nan, 1, 0.5), (1, 0.25, 0), (np.nan, 1, 0)]
        for point, wanted in zip(found, [*expected, (np.nan, 1, 1)], strict=True):
            for value, right in zip(point, wanted, strict=True):
                assert np.isnan(right) or value == pytest.approx(right, abs=1e-9)
        found = map_colours(colours, cube, "clip-chroma").points
        expected = [(1, 0, 0), (-1, 0, 0), (0.5, 1, 0.5), (1, 0, 0), (0.25, 1, 0), (0, 1, 1)]
        np.testing.assert_allclose(found, expected, atol=1e-9)

    def test_focal_is_on_the_line_to_the_focus(self, level, colours):
        focus = np.array([55.0, 2.0, -4.0])
        assert contains([focus], level).all()
        found = map_colours(colours, level, "clip-focal", focus=focus)
        way, whole = found.points - colours, focus - colours
        share = (way * whole).sum(axis=1) / (whole**2).sum(axis=1)
        assert share.min() >= 0
        assert share.max() < 1
        np.testing.assert_allclose(way, share[:, None] * whole, atol=1e-8)
        same = map_colours(colours, level, "clip-focal", focus="cusp")
        np.testing.assert_array_equal(same.points, map_colours(colours, level, "clip-focal").points)


def test_what_does_not_apply_is_refused(cube):
    points = np.zeros((2, 3))
    with pytest.raises(OptionError, match="method"):
        map_colours(points, cube, "clip")
    with pytest.raises(OptionError, match="focus"):
        map_colours(points, cube, "clip-hue", focus="cusp")
    with pytest.raises(OptionError, match="focus"):
        map_colours(points, cube, "clip-focal", focus="centre")
    with pytest.raises(InvalidPointsError, match="focus"):
        map_colours(points, cube, "clip-focal", focus=(1, 2))
    with pytest.raises(OptionError, match="source"):
        map_colours(points, cube, "sgck")
    with pytest.raises(OptionError, match="source"):
        map_colours(points, cube, "clip-hue", source=cube)
    with pytest.raises(InvalidPointsError, match="Row 1"):
        map_colours([(0, 0, 0), (np.nan, 0, 0)], cube, "clip-hue")
    assert map_colours(np.zeros((0, 3)), cube, "clip-hue").points.shape == (0, 3)


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
