"""Segment maxima: the definition, empty segments, and arbitrary input."""

import math

import numpy as np
import pytest
import scipy.spatial
from hypothesis import given, settings
from hypothesis import strategies as st

from gamutcore.boundary.segment_maxima import segment_maxima
from gamutcore.errors import (
    BoundaryError,
    CentreError,
    FlatPointsError,
    GamutError,
    InvalidPointsError,
    OptionError,
    TooFewPointsError,
)
from gamutcore.grid import grid_step
from gamutcore.metric import mismatch

SEGMENTS = st.tuples(st.integers(2, 10), st.integers(3, 12))


def polar_and_azimuth(positions):
    """Return the angles of positions from and about the first axis, in degrees."""
    slope = [math.degrees(math.acos(x / math.hypot(x, y, z))) for x, y, z in positions]
    turn = [math.degrees(math.atan2(z, y)) % 360 for _, y, z in positions]
    return np.array(slope), np.array(turn)


class TestDefinition:
    @pytest.mark.parametrize("segments", [(6, 9), (16, 16), (40, 70)])
    def test_maxima_of_a_sphere_are_on_the_sphere(self, icosphere, segments):
        """Interpolation between equal radii gives that radius, also at poles and empty segments."""
        sphere = icosphere(6, 40.0, (50.0, 5.0, -5.0)).vertices
        boundary = segment_maxima(sphere, segments, (50.0, 5.0, -5.0))
        radii = np.linalg.norm(boundary.mesh.vertices - boundary.centre, axis=1)
        np.testing.assert_allclose(radii, 40.0, atol=2 * grid_step(sphere))

    @pytest.mark.parametrize("segments", [(2, 3), (5, 8), (16, 16)])
    def test_each_segment_has_its_farthest_colour(self, random_cloud, segments):
        points, centre = random_cloud(20, 5000), np.array([48.0, 2.0, -3.0])
        boundary = segment_maxima(points, segments, centre)
        polar, azimuth = segments
        relative = points - centre
        radii = np.linalg.norm(relative, axis=1)
        slope, turn = polar_and_azimuth(relative)
        for number, source in enumerate(boundary.sources[:-2]):
            row, column = divmod(number, azimuth)
            inside = (
                (slope // (180 / polar) == row) & (turn // (360 / azimuth) == column)
            )  # fmt: skip
            if source >= 0:
                assert inside[source]
                assert radii[source] == radii[inside].max()
        assert (boundary.sources >= 0).sum() > {6: 1, 40: 30, 256: 250}[polar * azimuth]
        np.testing.assert_array_equal(boundary.sources[-2:], -1)

    def test_vertices_are_the_colours_that_they_say(self, random_cloud):
        points = random_cloud(21, 3000)
        boundary = segment_maxima(points)
        kept = boundary.sources >= 0
        assert np.abs(
            boundary.mesh.vertices[kept] - points[boundary.sources[kept]]
        ).max() <= 0.5 * grid_step(points)  # fmt: skip
        assert len(np.unique(boundary.sources[kept])) == kept.sum()

    @pytest.mark.parametrize("segments", [(2, 3), (3, 5), (16, 16), (7, 40)])
    def test_there_are_two_triangles_for_every_segment(self, random_cloud, segments):
        boundary = segment_maxima(random_cloud(22, 2000), segments)
        assert len(boundary.mesh.vertices) == segments[0] * segments[1] + 2
        assert boundary.mesh.triangles == 2 * segments[0] * segments[1]

    @pytest.mark.slow
    def test_more_segments_come_nearer_to_a_smooth_body(self, icosphere):
        """On smooth surfaces, the mismatch is proportional to 1 ÷ number of triangles."""
        sphere = icosphere(6, 40.0)
        coarse, fine = (
            mismatch(sphere, segment_maxima(sphere.vertices, (n, n), (0, 0, 0)).mesh)
            for n in (16, 32)
        )
        assert fine == pytest.approx(coarse / 4, rel=0.1)

    @pytest.mark.parametrize("twist", [-20, 20])
    def test_of_two_diagonals_the_outer_one_is_taken(self, twist):
        """The sides of a square antiprism are convex along one of their two diagonals."""
        turn = np.radians(np.arange(45, 360, 90))
        rings = [
            [(x, 50 * math.cos(angle), 50 * math.sin(angle)) for angle in turn + shift]
            for x, shift in ((40.0, 0.0), (-40.0, math.radians(twist)))
        ]
        points = np.vstack([*rings, [(45.0, 0, 0), (-45.0, 0, 0)]])
        boundary = segment_maxima(points, (2, 4), (0, 0, 0))
        # convex: every edge between the rings is one of the hull's
        hull = scipy.spatial.ConvexHull(boundary.mesh.vertices.astype(float))
        assert boundary.mesh.volume == pytest.approx(hull.volume, rel=1e-6)

    def test_the_points_are_not_written_to(self, random_cloud):
        points = random_cloud(23)
        before = points.copy()
        segment_maxima(points)
        np.testing.assert_array_equal(points, before)

    def test_reruns_are_bit_identical(self, random_cloud):
        points = random_cloud(24)
        one, other = segment_maxima(points), segment_maxima(points.copy())
        assert one.mesh == other.mesh
        np.testing.assert_array_equal(one.sources, other.sources)


class TestEmptySegments:
    def test_between_two_radii_lie_those_of_the_membrane(self, icosphere):
        """Caps of 50 and 30 about the poles, and nothing between 70° and 110°.

        What is harmonic on the sphere between two circles of latitude is linear in the logarithm
        of tan(θ ÷ 2).
        """
        sphere = icosphere(5).vertices.astype(np.float64)
        limit = math.cos(math.radians(70))
        points = np.vstack([50 * sphere[sphere[:, 0] > limit], 30 * sphere[sphere[:, 0] < -limit]])
        boundary = segment_maxima(points, (18, 12), (0, 0, 0))
        radii = np.linalg.norm(boundary.mesh.vertices, axis=1)[:-2].reshape(18, 12)
        np.testing.assert_allclose(radii[:7], 50, atol=0.01)
        np.testing.assert_allclose(radii[11:], 30, atol=0.01)
        part = np.log(np.tan(np.radians(np.arange(18) * 10 + 5) / 2))
        expected = 50 - 20 * (part - part[6]) / (part[11] - part[6])
        np.testing.assert_allclose(radii[7:11], np.tile(expected[7:11, None], 12), atol=0.05)

    def test_their_vertices_are_at_the_middle_of_the_segment(self, random_cloud):
        points = random_cloud(25, 60)
        centre = np.array([50.0, 0.0, 0.0])
        boundary = segment_maxima(points, (12, 20), centre)
        slope, turn = polar_and_azimuth(points - centre)
        empty = np.ones((12, 20), bool)
        empty[(slope / 15).astype(int), (turn / 18).astype(int)] = False
        assert 150 < empty.sum() < 240
        found = polar_and_azimuth(boundary.mesh.vertices[:-2] - centre)
        row, column = np.nonzero(empty)
        number = row * 20 + column
        np.testing.assert_allclose(found[0][number], row * 15 + 7.5, atol=0.01)
        np.testing.assert_allclose(found[1][number], column * 18 + 9, atol=0.02)
        np.testing.assert_array_equal(boundary.sources[number], -1)

    def test_no_vertex_leaves_the_range_of_the_colours(self, hard_cloud):
        points = hard_cloud("nearly flat", 3) @ np.eye(3)[[2, 1, 0]]
        boundary = segment_maxima(points, (8, 12))
        step = grid_step(points)
        lowest, highest = boundary.mesh.bounds
        assert (lowest >= points.min(axis=0) - step).all()
        assert (highest <= points.max(axis=0) + step).all()


class TestAnything:
    @pytest.mark.parametrize(
        "kind", ["star", "spikes", "nearly flat", "sparse", "one side", "poles", "lattice"]
    )
    @settings(max_examples=12)
    @given(seed=st.integers(0, 10**6), segments=SEGMENTS)
    @pytest.mark.slow
    def test_is_a_gamut_at_every_level(self, hard_cloud, assert_decimates, kind, seed, segments):
        assert_decimates(segment_maxima(hard_cloud(kind, seed), segments))

    @settings(max_examples=40)
    @given(
        kind=st.sampled_from(["star", "spikes", "sparse", "one side", "poles", "lattice"]),
        seed=st.integers(0, 10**6),
        segments=SEGMENTS,
        scale=st.sampled_from([1e-30, 1e-9, 1e-3, 1e3, 1e8]),
        shift=st.sampled_from([0.0, 1.0, 30.0]),
        aside=st.floats(0, 0.99),
    )
    @pytest.mark.slow
    def test_at_any_scale_and_off_centre(
        self, hard_cloud, assert_decimates, kind, seed, segments, scale, shift, aside
    ):
        points = hard_cloud(kind, seed) * scale + shift * scale * 100
        middle = points.mean(axis=0)
        centre = middle + aside * (points[0] - middle)
        try:
            boundary = segment_maxima(points, segments, centre)
        except (CentreError, BoundaryError) as error:
            assert error.remedy  # noqa: PT017  # either outcome is right, if it is named
        else:
            assert_decimates(boundary)

    @settings(max_examples=100)
    @given(
        points=st.lists(
            st.tuples(*[st.sampled_from([0.0, -0.0, 1.0, -1.0, 0.5, 1e-7, 1e-30, 1e6, 1e11])] * 3),
            max_size=30,
        ),
        segments=SEGMENTS,
    )
    def test_of_awkward_numbers(self, assert_every_invariant, points, segments):
        try:
            boundary = segment_maxima(points, segments)
        except GamutError as error:
            assert error.remedy  # noqa: PT017
        else:
            assert_every_invariant(boundary.mesh, boundary.centre, boundary.mesh.triangles)

    @pytest.mark.slow
    def test_the_most_segments_of_a_press(self, fogra39_points, assert_every_invariant):
        boundary = segment_maxima(fogra39_points, (180, 360))
        assert_every_invariant(boundary.mesh, boundary.centre, 2 * 180 * 360)

    def test_maxima_in_bad_position_are_turned_and_say_so(self, times_around):
        """Three segments of 120° with maxima 220° apart: the fan at the pole would be inverted.

        The columns' maxima stand at 5°, 225° and 355°, a gap of 220° between the first two.
        """
        turn = np.radians([5, 225, 355] * 2)
        slope = np.radians([45] * 3 + [135] * 3)
        points = 50 * np.stack(
            [np.cos(slope), np.sin(slope) * np.cos(turn), np.sin(slope) * np.sin(turn)], axis=1
        )
        boundary = segment_maxima(np.vstack([points, [(0, -9, 9)]]), (2, 3), (0, 2, -2))
        assert boundary.mesh.validity(boundary.centre).is_gamut
        assert times_around(boundary.mesh, boundary.centre) == pytest.approx(1)
        moved = boundary.sources[:6] < 0
        assert moved.any()
        assert not moved.all()


class TestRefusals:
    @pytest.mark.parametrize(
        "segments",
        [(16,), (16, 16, 16), (1, 16), (16, 2), (181, 16), (16, 361), (16.0, 16), "16", 16, None,
         (True, 16), ("16", 16), {16: 16}, (10**400, 16), [[16, 16]]],
    )  # fmt: skip
    def test_of_segments(self, segments):
        with pytest.raises(OptionError) as caught:
            segment_maxima(np.eye(4, 3), segments)
        assert caught.value.where == {"field": "segments"}
        assert "[180, 360]" in caught.value.remedy
        assert len(caught.value.message) < 120

    @pytest.mark.parametrize(
        ("points", "kind"),
        [
            (np.eye(3), TooFewPointsError),
            (np.zeros((5, 2)), InvalidPointsError),
            (np.full((9, 3), np.nan), InvalidPointsError),
            (np.random.default_rng(0).random((50, 3)) * (1, 1, 0), FlatPointsError),
        ],
    )
    def test_of_points(self, points, kind):
        with pytest.raises(kind) as caught:
            segment_maxima(points)
        assert caught.value.remedy

    @pytest.mark.parametrize("centre", [(50, 90, 0), (15, 50, 0)])
    def test_of_a_centre_outside(self, random_cloud, centre):
        with pytest.raises(CentreError) as caught:
            segment_maxima(random_cloud(26), (16, 16), centre)
        assert caught.value.where == {"field": "centre"}

    @pytest.mark.parametrize("centre", ["middle", (1, 2), (np.nan, 0, 0), None])
    def test_of_a_centre_that_is_none(self, random_cloud, centre):
        with pytest.raises(OptionError) as caught:
            segment_maxima(random_cloud(26), (16, 16), centre)
        assert caught.value.where == {"field": "centre"}
