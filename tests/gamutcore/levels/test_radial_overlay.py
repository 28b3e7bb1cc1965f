"""The radial overlay, compared with booleans, similar bodies and densely sampled distances."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from benchmarks.booleans import intersection_volume, mismatch
from gamutcore.geometry import TriangleMesh
from gamutcore.levels import radial_difference
from gamutcore.levels.overlay import SLACK

CENTRE = (50.0, 0.0, 0.0)


def scaled(mesh, ratio, centre=CENTRE):
    vertices = (mesh.vertices.astype(float) - centre) * ratio + centre
    return TriangleMesh(vertices, mesh.faces)


def turned(mesh, seed, centre=CENTRE):
    turn = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    return TriangleMesh((mesh.vertices.astype(float) - centre) @ turn.T + centre, mesh.faces)


STEPS = np.array([(i, j) for i in range(100) for j in range(100 - i)])
UPPER = np.vstack([STEPS + 1 / 3, STEPS[STEPS.sum(axis=1) < 99] + 2 / 3]) / 100
MIDDLES = np.column_stack([1 - UPPER.sum(axis=1), UPPER])
"""Weights of the middles of 10,000 small triangles of equal area."""


class TestVolume:
    """Manifold rounds to about 1e-12 of the extent, far below the tolerance here."""

    @settings(max_examples=40, deadline=None)
    @given(
        st.integers(0, 10**6),
        st.integers(6, 120),
        st.integers(6, 120),
        st.sampled_from([1e-6, 1.0, 1e6]),
    )
    def test_is_that_of_boolean_operations(self, star_shaped, seed, count, other_count, scale):
        one, two = star_shaped(seed, count), star_shaped(seed + 1, other_count)
        expected, common = mismatch(one, two), intersection_volume(one, two)
        one, two = scaled(one, scale, (0, 0, 0)), scaled(two, scale, (0, 0, 0))
        found = radial_difference(one, two, np.multiply(CENTRE, scale))
        assert found.mismatch == pytest.approx(expected, rel=1e-6)
        assert found.volume == pytest.approx(one.volume, rel=1e-9)
        assert found.other_volume == pytest.approx(two.volume, rel=1e-9)
        twice = found.volume + found.other_volume - found.difference
        assert twice / 2 / scale**3 == pytest.approx(common, rel=1e-6)

    @pytest.mark.parametrize(
        ("cost", "triangles"),
        [("volume", 4), ("quadric", 30), ("volume", 300), ("quadric", 3000), ("volume", 20_000)],
    )
    @pytest.mark.slow
    def test_of_real_levels_is_that_of_boolean_operations(
        self, fogra39_gamut, fogra39_quadric, cost, triangles
    ):
        history = {"volume": fogra39_gamut.history, "quadric": fogra39_quadric}[cost]
        full, level = history.full(), history.level(triangles)
        found = radial_difference(full, level, history.centre)
        assert found.mismatch == pytest.approx(mismatch(full, level), rel=1e-6)

    @pytest.mark.parametrize("ratio", [0.5, 0.999, 1.001, 2.0])
    def test_of_similar_bodies(self, icosphere, ratio):
        """The mismatch is |1 − ratio³| for any body. Turning a sphere moves only its facets."""
        sphere = icosphere(3, 40.0, CENTRE)
        found = radial_difference(sphere, scaled(sphere, ratio), CENTRE)
        assert found.mismatch == pytest.approx(abs(1 - ratio**3), rel=1e-9)
        if abs(ratio - 1) > 0.1:
            other = turned(scaled(sphere, ratio), 1)
            found = radial_difference(sphere, other, CENTRE)
            assert found.mismatch == pytest.approx(abs(1 - ratio**3), rel=1e-9)

    def test_of_a_body_with_itself_is_nothing(self, star_shaped):
        mesh = star_shaped(9, 500)
        found = radial_difference(mesh, mesh, CENTRE)
        assert found.difference == pytest.approx(0, abs=1e-9 * found.volume)
        for distances in (found.from_reference, found.to_reference):
            assert distances.mean == pytest.approx(0, abs=1e-9)
            assert distances.maximum == pytest.approx(0, abs=1e-6)


class TestDistances:
    @pytest.mark.parametrize("seed", range(3))
    def test_means_are_those_of_many_small_triangles(self, seed):
        """Distances along rays, projected on the normal of the face that a ray meets."""
        random = np.random.default_rng(seed)
        corners = np.vstack([np.eye(3), -np.eye(3)])
        faces = ConvexHull(corners).simplices
        faces[np.linalg.det(corners[faces]) < 0] = faces[np.linalg.det(corners[faces]) < 0][:, ::-1]
        one, two = (TriangleMesh(corners * random.uniform(1, 1.5, (6, 1)), faces) for _ in "ab")
        two = turned(two, seed, np.zeros(3))
        found = radial_difference(one, two, np.zeros(3))
        for mesh, other, distances in (
            (one, two, found.from_reference),
            (two, one, found.to_reference),
        ):
            planes = np.linalg.solve(other.vertices[other.faces], np.ones((8, 3, 1)))[..., 0]
            inverse = np.linalg.inv(other.vertices[other.faces].transpose(0, 2, 1))
            total = area = 0.0
            for triangle in mesh.vertices[mesh.faces]:
                points = MIDDLES @ triangle
                cone = np.einsum("fij,nj->nfi", inverse, points).min(axis=2).argmax(axis=1)
                normal = planes[cone]
                away = abs((normal * points).sum(axis=1) - 1) / np.linalg.norm(normal, axis=1)
                size = np.linalg.norm(
                    np.cross(triangle[1] - triangle[0], triangle[2] - triangle[0])
                )
                total, area = total + size * away.mean(), area + size
            assert distances.mean == pytest.approx(total / area, rel=1e-3)

    @pytest.mark.parametrize("ratio", [0.7, 1.3])
    def test_of_similar_convex_bodies(self, icosphere, ratio):
        """Planes at distance m move by |ratio − 1| m; the area-weighted mean of m is 3 V ÷ A.

        The largest distance is between corresponding vertices: |ratio − 1| R.
        """
        sphere = icosphere(2, 40.0, CENTRE)
        found = radial_difference(sphere, scaled(sphere, ratio), CENTRE)
        mean = abs(ratio - 1) * 3 * sphere.volume / sphere.area
        for distances in (found.from_reference, found.to_reference):
            assert distances.mean == pytest.approx(mean, rel=1e-6)
        outer = found.to_reference if ratio > 1 else found.from_reference
        assert abs(ratio - 1) * 40 * (1 - 1e-6) <= outer.maximum
        assert outer.maximum <= SLACK * abs(ratio - 1) * 40 * (1 + 1e-6)

    @settings(max_examples=15, deadline=None)
    @given(st.integers(0, 10**6), st.integers(6, 80), st.integers(6, 300))
    @pytest.mark.slow
    def test_never_exceed_the_bound(
        self, star_shaped, distances_to, sampled, seed, count, other_count
    ):
        one, two = star_shaped(seed, count), star_shaped(seed + 1, other_count)
        found = radial_difference(one, two, CENTRE)
        for mesh, other, distances in (
            (one, two, found.from_reference),
            (two, one, found.to_reference),
        ):
            points = np.vstack([mesh.vertices, sampled(mesh, 300)])
            furthest = distances_to(points, other).max()
            assert furthest <= distances.maximum * (1 + 1e-9)
            # distant bumpy surfaces are the hard case: descent may end early
            assert distances.maximum <= 2 * furthest

    @pytest.mark.parametrize("triangles", [30, 100, 1000])
    @pytest.mark.slow
    def test_of_real_levels_are_those_of_samples(
        self, fogra39_gamut, fogra39_quadric, distances_to, sampled, triangles
    ):
        for history in (fogra39_gamut.history, fogra39_quadric):
            full, level = history.full(), history.level(triangles)
            found = radial_difference(full, level, history.centre)
            for mesh, other, distances in (
                (full, level, found.from_reference),
                (level, full, found.to_reference),
            ):
                points = sampled(mesh, 1000)
                measured = distances_to(points, other)
                error = measured.std() / np.sqrt(len(measured))
                assert distances.mean == pytest.approx(measured.mean(), rel=0.05, abs=4 * error)
                assert measured.max() <= distances.maximum * (1 + 1e-9)
