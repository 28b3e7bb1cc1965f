"""USV: its segments, counts, published figures, and arbitrary input."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gamutcore.boundary import modified_convex_hull
from gamutcore.boundary.usv import BASES, sphere_triangles, triangles_towards, usv
from gamutcore.characterisation import characterisation
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
from gamutcore.mesh import TriangleMesh
from gamutcore.metric import radial_difference

FACES = {"tetrahedron": 4, "octahedron": 8, "icosahedron": 20}


class TestSegments:
    @pytest.mark.parametrize("basis", FACES)
    def test_of_the_regular_bodies(self, basis):
        corners, (faces,) = sphere_triangles(basis, 0)
        assert len(faces) == FACES[basis]
        np.testing.assert_allclose(np.linalg.norm(corners, axis=1), 1)
        sides = np.linalg.norm(corners[faces] - corners[np.roll(faces, 1, axis=1)], axis=2)
        np.testing.assert_allclose(sides, sides[0, 0])

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

    def test_even_directions_fall_evenly_into_even_segments(self):
        """The icosahedron's faces have equal areas: each gets a twentieth, up to chance."""
        directions = np.random.default_rng(1).normal(size=(40_000, 3))
        directions /= np.linalg.norm(directions, axis=1)[:, np.newaxis]
        counts = np.bincount(triangles_towards(directions, "icosahedron", 0), minlength=20)
        expected, deviation = 2000, math.sqrt(2000 * 0.95)
        assert np.abs(counts - expected).max() < 5 * deviation


class TestDefinition:
    @pytest.mark.parametrize(
        ("basis", "subdivisions", "triangles"),
        [("icosahedron", 1, 156), ("icosahedron", 2, 636), ("octahedron", 2, 252),
         ("tetrahedron", 3, 508)],
    )  # fmt: skip
    def test_every_segment_gives_a_vertex_of_a_sphere(
        self, icosphere, basis, subdivisions, triangles
    ):
        boundary = usv(icosphere(6, 40.0).vertices, basis, subdivisions, 0.05, (0, 0, 0))
        assert boundary.mesh.triangles == triangles
        radii = np.linalg.norm(boundary.mesh.vertices, axis=1)
        np.testing.assert_allclose(radii, 40, atol=1e-3)

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

    def test_vertices_are_the_colours_that_they_say(self, random_cloud):
        points = random_cloud(41, 3000)
        boundary = usv(points)
        np.testing.assert_allclose(boundary.mesh.vertices, points[boundary.sources], atol=1e-3)

    def test_it_is_the_modified_hull_of_the_farthest(self, random_cloud):
        points = random_cloud(42, 3000)
        for gamma in (0.05, 0.5, 1.0):
            boundary = usv(points, "octahedron", 3, gamma)
            assert boundary.gamma == gamma
            again = modified_convex_hull(points[boundary.sources], gamma, boundary.centre)
            assert again.mesh.volume == pytest.approx(boundary.mesh.volume, rel=1e-4)

    @pytest.mark.slow
    def test_with_a_segment_for_each_colour_it_is_the_modified_hull(self, random_cloud):
        points = random_cloud(43, 300)
        boundary = usv(points, "icosahedron", 7, 0.2)
        assert boundary.mesh == modified_convex_hull(points, 0.2).mesh

    @pytest.mark.slow
    def test_more_subdivisions_come_nearer(self, fogra39_points):
        whole = modified_convex_hull(fogra39_points)
        coarse = (usv(fogra39_points, "icosahedron", n, centre=whole.centre) for n in (1, 2, 3, 4))
        found = [
            radial_difference(whole.mesh, boundary.mesh, whole.centre).mismatch
            for boundary in coarse
        ]
        assert found == sorted(found, reverse=True)
        assert found[0] > 20 * found[-1]

    def test_reruns_are_bit_identical(self, random_cloud):
        points = random_cloud(44)
        one, other = usv(points), usv(points.copy())
        assert one.mesh == other.mesh
        np.testing.assert_array_equal(one.sources, other.sources)


class TestAnything:
    @pytest.mark.parametrize(
        "kind", ["star", "spikes", "nearly flat", "sparse", "one side", "poles", "lattice"]
    )
    @settings(max_examples=8)
    @given(seed=st.integers(0, 10**6), basis=st.sampled_from(list(BASES)), level=st.integers(2, 3))
    @pytest.mark.slow
    def test_is_a_gamut_at_every_level(
        self, hard_cloud, assert_decimates, kind, seed, basis, level
    ):
        """With 64 segments or more, their farthest colours surround the centre."""
        assert_decimates(usv(hard_cloud(kind, seed), basis, level))

    @settings(max_examples=40)
    @given(
        kind=st.sampled_from(["star", "spikes", "sparse", "one side", "poles", "lattice"]),
        seed=st.integers(0, 10**6),
        basis=st.sampled_from(list(BASES)),
        level=st.integers(0, 3),
        scale=st.sampled_from([1e-30, 1e-9, 1e-3, 1e3, 1e8]),
        shift=st.sampled_from([0.0, 1.0, 30.0]),
        aside=st.floats(0, 0.99),
    )
    @pytest.mark.slow
    def test_at_any_scale_and_off_centre(
        self, hard_cloud, assert_decimates, kind, seed, basis, level, scale, shift, aside
    ):
        points = hard_cloud(kind, seed) * scale + shift * scale * 100
        middle = points.mean(axis=0)
        centre = middle + aside * (points[0] - middle)
        try:
            boundary = usv(points, basis, level, 0.05, centre)
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
        level=st.integers(0, 4),
    )
    def test_of_awkward_numbers(self, assert_every_invariant, points, level):
        try:
            boundary = usv(points, "icosahedron", level)
        except GamutError as error:
            assert error.remedy  # noqa: PT017
        else:
            assert_every_invariant(boundary.mesh, boundary.centre, boundary.mesh.triangles)


class TestRefusals:
    def test_of_too_few_segments_to_surround_the_centre(self):
        """A cube's eight corners lie on the borders of at most four segments of a tetrahedron."""
        corners = np.array([(x, y, z) for x in (-1.0, 1) for y in (-1.0, 1) for z in (-1.0, 1)])
        with pytest.raises(BoundaryError) as caught:
            usv(corners * (1, 1, 1.5) + (0, 0, 0.2), "tetrahedron", 0, 0.05, (0.5, 0.5, 0.5))
        assert caught.value.where == {"field": "subdivisions"}
        assert "4 segments" in caught.value.message
        assert "more subdivisions" in caught.value.remedy

    @pytest.mark.parametrize("basis", ["cube", "", None, 20, ["icosahedron"], "x" * 1000])
    def test_of_a_basis(self, basis):
        with pytest.raises(OptionError) as caught:
            usv(np.eye(4, 3), basis)
        assert caught.value.where == {"field": "basis"}
        assert "octahedron" in caught.value.remedy

    @pytest.mark.parametrize("subdivisions", [-1, 8, 2.0, "2", None, True, 10**400])
    def test_of_subdivisions(self, subdivisions):
        with pytest.raises(OptionError) as caught:
            usv(np.eye(4, 3), "icosahedron", subdivisions)
        assert caught.value.where == {"field": "subdivisions"}
        assert "0 to 7" in caught.value.remedy

    @pytest.mark.parametrize("gamma", [0, 1.5, "0.2", None])
    def test_of_gamma(self, random_cloud, gamma):
        with pytest.raises(OptionError) as caught:
            usv(random_cloud(45), "icosahedron", 2, gamma)
        assert caught.value.where == {"field": "gamma"}

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
            usv(points)
        assert caught.value.remedy

    def test_of_a_centre_outside(self, random_cloud):
        with pytest.raises(CentreError) as caught:
            usv(random_cloud(46), centre=(15, 50, 0))
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
            else surface_colours(characterisation(small_profile("sRGB-v4.icc"))).points
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
