"""Mapping: properties of all methods, brute force over the segments of a section, and a sphere."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gamutcore.errors import InvalidPointsError, OptionError
from gamutcore.queries import build_index, contains, map_colours, nearest

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

    def test_of_a_sphere_is_monotone_along_lightness(self, rough, method):
        vertices, faces, centre = rough(9, 3000, 0.0)
        level = vertices - (0, *centre[1:]), faces, centre * (1, 0, 0)
        colours = np.zeros((300, 3))
        colours[:, 0] = np.linspace(-50, 150, 300)
        colours[:, 1] = 45.0
        lightness = map_colours(colours, level, method).points[:, 0]
        assert (np.diff(lightness) > -1e-9).all()

    def test_where_the_axis_is_far_away(self, level, colours, method):
        vertices, faces, centre = level
        shift = np.array([0.0, 150.0, 0.0])
        moved = vertices + shift, faces, centre + shift
        found = map_colours(colours, moved, method)
        assert contains(found.points, moved).all()
        assert found.moved.all()

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

    def test_nearest_is_the_nearest_point(self, level, colours):
        found = map_colours(colours, level, "clip-nearest")
        distance = np.linalg.norm(found.points - colours, axis=1)
        expected = np.where(found.moved, nearest(colours, level).distance, 0)
        np.testing.assert_allclose(distance, expected, atol=1e-8)

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

    def test_of_a_sphere_towards_its_middle_are_radial(self, rough, colours):
        vertices, faces, centre = rough(9, 3000, 0.0)
        level = vertices - (0, *centre[1:]), faces, centre * (1, 0, 0)
        radius = np.linalg.norm(colours - level[2], axis=1)
        outside = radius > 41
        for method, focus in (("clip-focal", level[2]), ("clip-hue", None), ("clip-nearest", None)):
            found = map_colours(colours[outside], level, method, focus=focus)
            distance = np.linalg.norm(found.points - colours[outside], axis=1)
            # the faces are up to 0.3 within the sphere
            np.testing.assert_allclose(distance, radius[outside] - 40, atol=0.3)


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
