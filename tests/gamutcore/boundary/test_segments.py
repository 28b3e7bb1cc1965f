"""USV and segment maxima: definitions, published figures, empty segments, arbitrary input."""

import itertools
import math

import numpy as np
import pytest
import scipy.spatial
from hypothesis import given, settings
from hypothesis import strategies as st

from gamutcore import Gamut
from gamutcore.boundary import compute_boundary, modified_convex_hull, segment_maxima, usv
from gamutcore.boundary.published.usv import BASES, sphere_triangles, triangles_towards
from gamutcore.characterisation import read_characterisation
from gamutcore.colours import surface_colours
from gamutcore.errors import (
    BoundaryError,
    CentreError,
    FlatPointsError,
    GamutError,
    InvalidPointsError,
    OptionError,
    TooFewPointsError,
)
from gamutcore.geometry import TriangleMesh, grid_step
from gamutcore.levels import radial_difference

FACES = {"tetrahedron": 4, "octahedron": 8, "icosahedron": 20}


class TestSegments:
    @pytest.mark.parametrize("basis", FACES)
    def test_each_level_splits_every_triangle_into_four(self, basis, times_around):
        corners, levels = sphere_triangles(basis, 4)
        assert [len(faces) for faces in levels] == [FACES[basis] * 4**n for n in range(5)]
        for coarse, fine in itertools.pairwise(levels):
            mesh = TriangleMesh(corners[: fine.max() + 1], fine)
            assert mesh.validity((0, 0, 0)).is_gamut
            assert times_around(mesh, np.zeros(3)) == pytest.approx(1)
            # a part's corners are its face's, or halfway along a side of it
            whole, parts = corners[coarse], corners[fine].reshape(-1, 4, 3, 3)
            for k in range(3):
                np.testing.assert_array_equal(parts[:, k, k], whole[:, k])
                halfway = whole[:, k] + whole[:, (k + 1) % 3]
                halfway /= np.linalg.norm(halfway, axis=1)[:, np.newaxis]
                np.testing.assert_allclose(parts[:, 3, k], halfway, atol=1e-15)

    @pytest.mark.parametrize("subdivisions", [0, 1, 3, 6])
    @pytest.mark.parametrize("basis", FACES)
    def test_the_walk_ends_in_the_triangle_that_holds_the_direction(self, basis, subdivisions):
        """The directions include axes, corners and midpoints, which lie on several borders."""
        random = np.random.default_rng(0).normal(size=(2000, 3))
        corners, levels = sphere_triangles(basis, subdivisions)
        directions = np.vstack([random, np.eye(3), -np.eye(3), corners[:500]])
        directions /= np.linalg.norm(directions, axis=1)[:, np.newaxis]
        found = triangles_towards(directions, basis, subdivisions)
        one, two, three = corners[levels[-1][found]].transpose(1, 0, 2)
        for start, end in ((one, two), (two, three), (three, one)):
            outside = np.linalg.det(np.stack([start, end, directions], axis=1))
            assert outside.min() > -1e-15


class TestUsv:
    @pytest.mark.parametrize("basis", FACES)
    def test_vertices_are_the_farthest_of_their_segments(self, random_cloud, basis):
        points, centre = random_cloud(40, 4000), np.array([50.0, 0.0, 0.0])
        boundary = usv(points, basis, 2, 0.05, centre)
        relative = points - centre
        radii = np.linalg.norm(relative, axis=1)
        segment = triangles_towards(relative / radii[:, np.newaxis], basis, 2)
        assert len(np.unique(segment[boundary.sources])) == len(boundary.sources)
        for source in boundary.sources:
            assert radii[source] == radii[segment == segment[source]].max()

    def test_it_is_the_modified_hull_of_the_farthest(self, random_cloud):
        points = random_cloud(42, 3000)
        for gamma in (0.05, 0.5, 1.0):
            boundary = usv(points, "octahedron", 3, gamma)
            assert boundary.gamma == gamma
            again = modified_convex_hull(points[boundary.sources], gamma, boundary.centre)
            assert again.mesh.volume == pytest.approx(boundary.mesh.volume, rel=1e-4)


def polar_and_azimuth(positions):
    """Return the angles of positions from and about the first axis, in degrees."""
    slope = [math.degrees(math.acos(x / math.hypot(x, y, z))) for x, y, z in positions]
    turn = [math.degrees(math.atan2(z, y)) % 360 for _, y, z in positions]
    return np.array(slope), np.array(turn)


class TestSegmentMaxima:
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


KINDS = ("star", "spikes", "nearly flat", "sparse", "one side", "poles", "lattice")
SEGMENTS = st.tuples(st.integers(2, 10), st.integers(3, 12))
# with 64 segments or more, their farthest colours surround the centre
FINE = {
    "usv": st.fixed_dictionaries(
        {"basis": st.sampled_from(list(BASES)), "subdivisions": st.integers(2, 3)}
    ),
    "segment-maxima": st.fixed_dictionaries({"segments": SEGMENTS}),
}
ANY = FINE | {
    "usv": st.fixed_dictionaries(
        {"basis": st.sampled_from(list(BASES)), "subdivisions": st.integers(0, 3)}
    )
}


@pytest.mark.parametrize("method", FINE)
class TestAnything:
    @pytest.mark.parametrize("kind", KINDS)
    @settings(max_examples=6)
    @given(seed=st.integers(0, 10**6), data=st.data())
    @pytest.mark.slow
    def test_is_a_gamut_at_every_level(
        self, hard_cloud, assert_decimates, method, kind, seed, data
    ):
        parameters = data.draw(FINE[method])
        assert_decimates(compute_boundary(hard_cloud(kind, seed), method, **parameters))

    @settings(max_examples=30)
    @given(
        kind=st.sampled_from([kind for kind in KINDS if kind != "nearly flat"]),
        seed=st.integers(0, 10**6),
        data=st.data(),
        scale=st.sampled_from([1e-30, 1e-9, 1e-3, 1e3, 1e8]),
        shift=st.sampled_from([0.0, 1.0, 30.0]),
        aside=st.floats(0, 0.99),
    )
    @pytest.mark.slow
    def test_at_any_scale_and_off_centre(
        self, hard_cloud, assert_decimates, method, kind, seed, data, scale, shift, aside
    ):
        points = hard_cloud(kind, seed) * scale + shift * scale * 100
        middle = points.mean(axis=0)
        centre = middle + aside * (points[0] - middle)
        try:
            boundary = compute_boundary(points, method, centre, **data.draw(ANY[method]))
        except (CentreError, BoundaryError) as error:
            assert error.remedy  # noqa: PT017  # either outcome is right, if it is named
        else:
            assert_decimates(boundary)

    @settings(max_examples=80)
    @given(
        points=st.lists(
            st.tuples(*[st.sampled_from([0.0, -0.0, 1.0, -1.0, 0.5, 1e-7, 1e-30, 1e6, 1e11])] * 3),
            max_size=30,
        ),
        data=st.data(),
    )
    def test_of_awkward_numbers(self, assert_every_invariant, method, points, data):
        try:
            boundary = compute_boundary(points, method, **data.draw(ANY[method]))
        except GamutError as error:
            assert error.remedy  # noqa: PT017
        else:
            assert_every_invariant(boundary.mesh, boundary.centre, boundary.mesh.triangles)

    def test_reruns_are_bit_identical_and_points_are_not_written_to(self, random_cloud, method):
        points = random_cloud(44)
        before = points.copy()
        one, other = compute_boundary(points, method), compute_boundary(points.copy(), method)
        assert one.mesh == other.mesh
        np.testing.assert_array_equal(one.sources, other.sources)
        np.testing.assert_array_equal(points, before)


class TestRefusals:
    def test_of_too_few_segments_to_surround_the_centre(self):
        """A cube's eight corners lie on the borders of at most four segments of a tetrahedron."""
        corners = np.array([(x, y, z) for x in (-1.0, 1) for y in (-1.0, 1) for z in (-1.0, 1)])
        with pytest.raises(BoundaryError) as caught:
            usv(corners * (1, 1, 1.5) + (0, 0, 0.2), "tetrahedron", 0, 0.05, (0.5, 0.5, 0.5))
        assert caught.value.where == {"field": "subdivisions"}
        assert "4 segments" in caught.value.message
        assert "more subdivisions" in caught.value.remedy

    @pytest.mark.parametrize(
        ("field", "value"),
        [
            *[("basis", value) for value in ("cube", "", 20, ["icosahedron"], "x" * 1000)],
            *[("subdivisions", value) for value in (-1, 8, 2.0, "2", True, 10**400)],
            *[("gamma", value) for value in (0, 1.5, "0.2")],
        ],
    )
    def test_of_a_parameter_of_usv(self, random_cloud, field, value):
        with pytest.raises(OptionError) as caught:
            Gamut(random_cloud(45), boundary="usv", **{field: value})
        assert caught.value.where == {"field": field}
        expected = {"basis": "octahedron", "subdivisions": "0 to 7", "gamma": "1"}
        assert expected[field] in caught.value.remedy

    @pytest.mark.parametrize(
        "segments",
        [(16,), (16, 16, 16), (1, 16), (16, 2), (181, 16), (16, 361), (16.0, 16), "16", 16,
         (True, 16), ("16", 16), {16: 16}, (10**400, 16), [[16, 16]]],
    )  # fmt: skip
    def test_of_segments(self, segments):
        with pytest.raises(OptionError) as caught:
            Gamut(np.eye(4, 3), boundary="segment-maxima", segments=segments)
        assert caught.value.where == {"field": "segments"}
        assert "[180, 360]" in caught.value.remedy
        assert len(caught.value.message) < 120

    @pytest.mark.parametrize("method", FINE)
    @pytest.mark.parametrize(
        ("points", "kind"),
        [
            (np.eye(3), TooFewPointsError),
            (np.zeros((5, 2)), InvalidPointsError),
            (np.full((9, 3), np.nan), InvalidPointsError),
            (np.random.default_rng(0).random((50, 3)) * (1, 1, 0), FlatPointsError),
        ],
    )
    def test_of_points(self, method, points, kind):
        for centre in ("auto", (0.5, 0.5, 0)):
            with pytest.raises(kind) as caught:
                compute_boundary(points, method, centre)
            assert caught.value.remedy

    @pytest.mark.parametrize("method", FINE)
    @pytest.mark.parametrize(
        ("centre", "kind"),
        [((50, 90, 0), CentreError), ((15, 50, 0), CentreError), ("middle", OptionError),
         ((1, 2), OptionError), ((np.nan, 0, 0), OptionError), (None, OptionError)],
    )  # fmt: skip
    def test_of_a_centre(self, random_cloud, method, centre, kind):
        with pytest.raises(kind) as caught:
            compute_boundary(random_cloud(26), method, centre)
        assert caught.value.where == {"field": "centre"}


class TestPublishedFigures:
    """Mismatch in % with the full boundary: `decimation.md`, whose conditions are not stated.

    How the icosahedron stands against the gamut changes the figures by a factor of two. What can
    be said is that each published one is a draw out of them, about the centre (50, 0, 0).
    """

    CENTRE = np.array([50.0, 0.0, 0.0])

    @pytest.mark.parametrize(
        ("device", "level", "triangles", "published"),
        [("sRGB", 1, 156, 3.08), ("sRGB", 2, 636, 0.785), ("FOGRA39L", 2, 636, 0.758)],
    )
    @pytest.mark.slow
    def test_is_one_of_the_figures_of_turned_segments(
        self, small_profile, fogra39_points, device, level, triangles, published
    ):
        points = (
            fogra39_points
            if device == "FOGRA39L"
            else surface_colours(read_characterisation(small_profile("sRGB-v4.icc"))).points
        )
        random = np.random.default_rng(1)
        found = []
        while len(found) < 8 and not (found and min(found) < published < max(found)):
            turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
            turned = (points - self.CENTRE) @ turn + self.CENTRE
            boundary = usv(turned, "icosahedron", level, 0.05, self.CENTRE)
            # one or two of the farthest colours may lie below the hull of the others
            assert triangles - 4 <= boundary.mesh.triangles <= triangles
            full = modified_convex_hull(turned, 0.2, self.CENTRE).mesh
            found.append(100 * radial_difference(full, boundary.mesh, self.CENTRE).mismatch)
        assert min(found) < published < max(found)
