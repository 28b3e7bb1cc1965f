"""Decimation to four triangles: every level keeps all invariants, for every cost."""

import re

import numpy as np
import pytest
import trimesh
from hypothesis import example, given, reject, settings
from hypothesis import strategies as st

from benchmarks.booleans import mismatch
from gamutcore.boundary import modified_convex_hull
from gamutcore.decimation import COSTS, decimate
from gamutcore.errors import FlatPointsError, GamutError, MeshError, OptionError
from gamutcore.geometry import TriangleMesh
from gamutcore.history import build_history


def directions(random, count):
    vectors = random.normal(size=(count, 3))
    return vectors / np.linalg.norm(vectors, axis=1)[:, np.newaxis]


def bumpy(random, count):
    return directions(random, count) * random.uniform(0.5, 1.0, (count, 1))


def sphere(random, count):
    return directions(random, count)


def spikes(random, count):
    far = random.random((count, 1)) < 0.1
    return directions(random, count) * np.where(far, random.uniform(5, 50, (count, 1)), 1.0)


def slivers(random, count):
    return bumpy(random, count) * (1.0, 1e-2, 1e-1)


def nearly_flat(random, count):
    return sphere(random, count) * (1.0, 1.0, 1e-4)


def needle(random, count):
    return sphere(random, count) * (1.0, 1e-2, 1e-2)


def lattice(_random, count):
    axis = np.linspace(-1.0, 1.0, 3 + count % 5)
    points = np.stack(np.meshgrid(axis, axis, axis), axis=-1).reshape(-1, 3)
    return points[(np.abs(points) == 1.0).any(axis=1)]


def six_decades_of_radii(random, count):
    return directions(random, count) * 10 ** random.uniform(-6, 0, (count, 1))


CLOUDS = (bumpy, sphere, spikes, slivers, nearly_flat, needle, lattice, six_decades_of_radii)


def cloud(kind, seed, count):
    return kind(np.random.default_rng(seed), count)


def rugged(random, count, radii):
    """A triangulation of the sphere whose vertices are pulled in and out along their rays."""
    hull = modified_convex_hull(directions(random, count), 1.0, (0.0, 0.0, 0.0)).mesh
    pulled = radii(random, (len(hull.vertices), 1))
    return TriangleMesh((hull.vertices * pulled).astype(np.float32), hull.faces)


def two_decades(random, shape):
    return 10 ** random.uniform(-1, 1, shape)


def four_decades(random, shape):
    return 10 ** random.uniform(-2, 2, shape)


def hundredfold(random, shape):
    return np.where(random.random(shape) < 0.2, 100.0, 1.0) * random.uniform(0.9, 1.1, shape)


def thousandfold(random, shape):
    return np.where(random.random(shape) < 0.1, 1000.0, 1.0) * random.uniform(0.9, 1.1, shape)


def dents(random, shape):
    return np.where(random.random(shape) < 0.1, 0.05, 1.0) * random.uniform(0.9, 1.1, shape)


class TestEveryLevel:
    @pytest.mark.parametrize("cost", COSTS)
    @pytest.mark.parametrize("kind", CLOUDS)
    @settings(max_examples=6)
    @given(
        seed=st.integers(0, 2**32),
        count=st.integers(8, 120),
        scale=st.sampled_from([1e-20, 1e-10, 1e-3, 1.0, 50.0, 1e5]),
        shift=st.sampled_from([0.0, 0.0, 1.0, 10.0, 30.0, 1000.0]),
        gamma=st.sampled_from([0.05, 0.2, 1.0]),
    )
    @pytest.mark.slow
    def test_is_a_gamut_down_to_four_triangles_without_a_gap(
        self, assert_every_level, cost, kind, seed, count, scale, shift, gamma
    ):
        """Of any shape, of which float32 keeps few digits far from the origin.

        The volume cannot be kept better there than the grid allows. Each place is chosen so that
        the volume is exact, what the collapses before it lost included; rounding then moves it by
        half a step along each axis at most, √3 ÷ 2 steps in all, and a vertex that moves by δ
        changes the volume by δ times a third of the area around it, which is less than the whole.
        """
        points = (cloud(kind, seed, count) + shift) * scale
        try:
            boundary = modified_convex_hull(points, gamma)
        except FlatPointsError:
            reject()  # the grid is too coarse for the flat body
        decimation = decimate(boundary.mesh, boundary.centre, cost)
        history = build_history(decimation)
        levels = list(history.levels())
        counts = assert_every_level(levels, boundary.centre)
        assert counts == list(range(4, boundary.mesh.triangles + 1, 2))
        if cost == "volume":
            volume, rounding = boundary.mesh.volume, np.sqrt(3) / 2 * history.step
            changes = [abs(level.volume - volume) for level in levels]
            for level, change in zip(levels, changes, strict=True):
                assert change <= max(1e-5 * volume, level.area * rounding)
            worst = pytest.approx(max(changes), rel=1e-6, abs=1e-11 * volume)
            assert decimation.volume_error == worst
        else:
            assert decimation.volume_error is None

    @pytest.mark.parametrize("cost", COSTS)
    @pytest.mark.parametrize("kind", [bumpy, sphere, slivers])
    @settings(max_examples=4)
    @given(
        seed=st.integers(0, 2**32),
        count=st.integers(30, 150),
        part=st.sampled_from([0.5, 0.9, 0.97]),
    )
    @pytest.mark.slow
    def test_of_bodies_whose_centre_is_near_their_surface(
        self, assert_every_level, cost, kind, seed, count, part
    ):
        """The centre lies near a vertex, so half of all directions end near the centre."""
        points = 50.0 * cloud(kind, seed, count)
        middle = modified_convex_hull(points, 0.2).centre
        try:
            boundary = modified_convex_hull(points, 0.2, middle + part * (points[0] - middle))
        except GamutError:
            reject()  # the centre is outside
        history = build_history(decimate(boundary.mesh, boundary.centre, cost))
        counts = assert_every_level(history.levels(), boundary.centre)
        assert counts == list(range(4, boundary.mesh.triangles + 1, 2))

    @pytest.mark.parametrize("cost", COSTS)
    @pytest.mark.parametrize("radii", [two_decades, four_decades, hundredfold, thousandfold, dents])
    @settings(max_examples=3)
    @given(seed=st.integers(0, 2**32), count=st.integers(30, 150))
    # on each of these `finest` once stopped at 6 to 12 triangles, with some of the radii
    @example(seed=15, count=150)
    @example(seed=46, count=150)
    @example(seed=66, count=150)
    @example(seed=110, count=150)
    @pytest.mark.slow
    def test_of_rugged_bodies_as_well(self, assert_every_level, cost, radii, seed, count):
        """Boundaries posted as meshes, which no hull has smoothed."""
        mesh = rugged(np.random.default_rng(seed), count, radii)
        centre = np.zeros(3)
        try:
            history = build_history(decimate(mesh, centre, cost))
        except MeshError:
            reject()  # not star-shaped after rounding
        counts = assert_every_level(history.levels(), centre)
        assert counts == list(range(4, mesh.triangles + 1, 2))

    @pytest.mark.parametrize("cost", COSTS)
    def test_a_tetrahedron_has_nothing_to_collapse(self, cost):
        boundary = modified_convex_hull(np.vstack([np.zeros(3), np.eye(3)]))
        decimation = decimate(boundary.mesh, boundary.centre, cost)
        assert len(decimation.record.kept) == 0
        assert build_history(decimation).triangles == 4


def highest_degree(mesh):
    return np.bincount(mesh.faces.ravel()).max()


class TestStructure:
    """Shapes on which a greedy decimation creates vertices whose faces span a whole side."""

    @pytest.mark.parametrize("cost", COSTS)
    @pytest.mark.slow
    def test_of_a_box_with_flat_faces(self, assert_every_invariant, cost):
        axis = np.linspace(-1.0, 1.0, 16)
        points = np.stack(np.meshgrid(axis, axis, axis), axis=-1).reshape(-1, 3)
        points = points[(np.abs(points) == 1.0).any(axis=1)]
        boundary = modified_convex_hull(points * (40.0, 60.0, 50.0))
        history = build_history(decimate(boundary.mesh, boundary.centre, cost))
        triangles = history.triangles
        while triangles >= 12:
            level = history.level(triangles)
            assert_every_invariant(level, boundary.centre, level.triangles)
            # on a flat side every collapse is free; the vertices must not merge into a few hubs
            assert highest_degree(level) <= 40
            triangles = triangles * 9 // 10
        # a box needs 12 triangles; corners are exact but for the solve's small pull to the midpoint
        assert mismatch(boundary.mesh, history.level(12)) < 1e-3

    @pytest.mark.parametrize("cost", COSTS)
    @pytest.mark.slow
    def test_of_a_double_pyramid_over_many_sides(self, assert_every_level, cost):
        angle = np.linspace(0, 2 * np.pi, 1000, endpoint=False)
        rim = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=1)
        boundary = modified_convex_hull(np.vstack([rim, [[0, 0, 1], [0, 0, -1]]]), 1.0)
        assert highest_degree(boundary.mesh) == 1000
        history = build_history(decimate(boundary.mesh, boundary.centre, cost))
        asked = range(4, history.triangles + 1, 26)
        levels = (history.level(triangles) for triangles in asked)
        assert assert_every_level(levels, boundary.centre) == list(asked)
        # the end of lower degree is removed, so about three corners move in a collapse
        assert len(history.splits.moved) <= 6 * history.vertices


def faces_of(mesh, *, without=(), flipped=()):
    faces = mesh.faces.copy()
    faces[list(flipped)] = faces[list(flipped), ::-1]
    return np.delete(faces, list(without), axis=0)


class TestRefusals:
    @pytest.mark.parametrize("cost", COSTS)
    def test_of_an_open_mesh(self, icosphere, cost):
        mesh = icosphere(1)
        with pytest.raises(MeshError, match="not closed") as caught:
            decimate(TriangleMesh(mesh.vertices, faces_of(mesh, without=[7])), (0, 0, 0), cost)
        assert "face" in caught.value.where

    def test_of_a_flipped_face(self, icosphere):
        mesh = icosphere(1)
        with pytest.raises(MeshError, match="consistently oriented"):
            decimate(TriangleMesh(mesh.vertices, faces_of(mesh, flipped=[3])), (0, 0, 0))

    def test_of_a_mesh_turned_inside_out(self, icosphere):
        mesh = icosphere(1)
        with pytest.raises(MeshError, match="star-shaped"):
            decimate(TriangleMesh(mesh.vertices, mesh.faces[:, ::-1]), (0, 0, 0))

    def test_of_a_torus(self):
        torus = trimesh.creation.torus(2.0, 0.5, major_sections=12, minor_sections=8)
        mesh = TriangleMesh(np.asarray(torus.vertices, np.float32), np.asarray(torus.faces))
        assert mesh.validity().closed
        with pytest.raises(MeshError, match="genus 0"):
            decimate(mesh, (0, 0, 0))

    def test_of_two_pieces(self, icosphere):
        one = icosphere(1)
        both = TriangleMesh(
            np.vstack([one.vertices, 2 * one.vertices]),
            np.vstack([one.faces, one.faces + len(one.vertices)]),
        )
        with pytest.raises(MeshError, match="genus 0") as caught:
            decimate(both, (0, 0, 0))
        assert "one closed piece" in caught.value.remedy

    def test_of_two_pieces_whose_face_count_a_handle_makes_right(self, icosphere):
        """A sphere (V − E + F = 2) and a torus (0) have as many faces together as one sphere."""
        torus = trimesh.creation.torus(2.0, 0.5, major_sections=12, minor_sections=8)
        one = icosphere(1)
        mesh = TriangleMesh(
            np.vstack([one.vertices, torus.vertices]).astype(np.float32),
            np.vstack([one.faces, torus.faces + len(one.vertices)]),
        )
        assert mesh.triangles == 2 * len(mesh.vertices) - 4
        with pytest.raises(MeshError):
            decimate(mesh, (0, 0, 0))

    def test_of_unused_vertices(self, icosphere):
        mesh = icosphere(1)
        with pytest.raises(MeshError, match="genus 0") as caught:
            decimate(TriangleMesh(np.vstack([mesh.vertices, [[0, 0, 9]]]), mesh.faces), (0, 0, 0))
        assert "unused vertices" in caught.value.remedy

    @pytest.mark.parametrize("centre", [(2.0, 0.0, 0.0), (0.0, 0.0, 1.0)])
    def test_of_a_centre_that_a_face_does_not_see(self, icosphere, centre):
        with pytest.raises(MeshError, match="star-shaped") as caught:
            decimate(icosphere(1), centre)
        face = caught.value.where["face"]
        assert icosphere(1).determinants(centre)[face] <= 1e-6

    @pytest.mark.parametrize("value", [np.nan, np.inf])
    def test_of_numbers_that_are_not_finite(self, icosphere, value):
        mesh = icosphere(1)
        mesh.vertices[5, 1] = value
        with pytest.raises(MeshError, match="finite"):
            decimate(mesh, (0, 0, 0))
        with pytest.raises(MeshError, match="finite"):
            decimate(icosphere(1), (0, value, 0))

    def test_of_nothing(self):
        with pytest.raises(MeshError):
            decimate(TriangleMesh(np.empty((0, 3)), np.empty((0, 3), int)), (0, 0, 0))

    @pytest.mark.parametrize("cost", ["area", "", "Volume", "../quadric"])
    def test_of_a_cost_that_is_not_there(self, icosphere, cost):
        with pytest.raises(OptionError, match=re.escape(repr(cost))) as caught:
            decimate(icosphere(1), (0, 0, 0), cost)
        assert caught.value.where == {"field": "cost"}
        assert "volume" in caught.value.remedy
