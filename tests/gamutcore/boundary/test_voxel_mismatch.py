"""Mismatch in voxels, compared with voxels counted one by one and with exact figures."""

import itertools
import math

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.booleans import mismatch
from gamutcore.boundary import modified_convex_hull, voxel_mismatch
from gamutcore.errors import MeshError
from gamutcore.geometry import TriangleMesh


def box(lowest, highest):
    solid = trimesh.creation.box(bounds=[lowest, highest])
    return TriangleMesh(np.asarray(solid.vertices), np.asarray(solid.faces))


def voxels_inside(mesh, edge):
    """Return the voxels with centres inside a mesh, by its solid angle at each centre."""
    lowest, highest = np.floor(mesh.bounds / edge).astype(int)
    found = set()
    for place in itertools.product(*map(range, lowest, highest + 1)):
        corners = mesh.vertices[mesh.faces] - (np.array(place) + 0.5) * edge
        lengths = np.linalg.norm(corners, axis=2)
        a, b, c = corners.transpose(1, 0, 2)
        la, lb, lc = lengths.T
        cosines = (
            la * lb * lc + (a * b).sum(1) * lc + (b * c).sum(1) * la + (c * a).sum(1) * lb
        )  # fmt: skip
        if np.arctan2(np.linalg.det(corners), cosines).sum() > np.pi:
            found.add(place)
    return found


class TestCounting:
    @settings(max_examples=8)
    @given(seed=st.integers(0, 10**6))
    @pytest.mark.slow
    def test_is_that_of_voxels_one_by_one(self, random_cloud, seed):
        """The bodies are bumpy and concave; the second one is shifted."""
        one = modified_convex_hull(random_cloud(seed, 60)).mesh
        other = modified_convex_hull(random_cloud(seed + 1, 60) + np.array([3, -5, 7])).mesh
        found = voxel_mismatch(one, other, 9.7)
        inside = [voxels_inside(mesh, 9.7) for mesh in (one, other)]
        assert found.reference_voxels == len(inside[0])
        assert found.differing_voxels == len(inside[0] ^ inside[1])
        assert found.mismatch == found.differing_voxels / found.reference_voxels
        assert found.edge == 9.7

    @pytest.mark.parametrize("shift", [0.0, 0.25, 0.5, 0.75])
    def test_of_a_box_whose_sides_go_through_centres(self, shift):
        """Centres on lower sides are inside and those on upper sides outside: always 4 · 5 · 6."""
        solid = box(np.full(3, shift), np.array([4, 5, 6]) + shift)
        assert voxel_mismatch(solid, solid, 1.0).reference_voxels == 120

    def test_by_default_the_longest_axis_has_256_voxels(self):
        reference, other = box((0, 0, 0), (10, 64, 20)), box((-30, 0, 0), (10, 90, 20))
        assert voxel_mismatch(reference, other).edge == 0.25

    def test_what_a_line_enters_twice_is_outside(self):
        """A box with a cavity: two closed surfaces in one mesh."""
        outer, inner = box((0, 0, 0), (4, 4, 4)), box((1, 1, 1), (3, 3, 3))
        hollow = TriangleMesh(
            np.vstack([outer.vertices, inner.vertices]),
            np.vstack([outer.faces, inner.faces[:, ::-1] + len(outer.vertices)]),
        )
        assert voxel_mismatch(hollow, outer, 0.5).reference_voxels == 8**3 - 4**3


class TestAgainstAnalysis:
    @pytest.mark.parametrize("ratio", [0.5, 0.9, 0.99])
    @pytest.mark.parametrize("edge", [None, 0.5, 3.0])
    def test_concentric_spheres(self, icosphere, ratio, edge):
        """The mismatch is 1 − (r/R)³ within the bound, and within a thousandth with 256 voxels."""
        outer, inner = (icosphere(5, r, (50.0, 0.0, 0.0)) for r in (50.0, 50.0 * ratio))
        found = voxel_mismatch(outer, inner, edge)
        assert abs(found.mismatch - (1 - ratio**3)) <= found.bound
        if edge is None:
            assert found.mismatch == pytest.approx(1 - ratio**3, abs=1e-3)

    @settings(max_examples=100)
    @given(
        corner=st.tuples(*[st.floats(-3, 3)] * 3),
        sides=st.tuples(*[st.floats(0.5, 4)] * 3),
        shift=st.tuples(*[st.floats(-1, 1)] * 3),
        edge=st.floats(0.2, 0.5),
    )
    def test_boxes_are_within_the_bound(self, corner, sides, shift, edge):
        low, high = np.array(corner), np.array(corner) + sides
        moved = low + shift, high + shift
        common = np.maximum(np.minimum(high, moved[1]) - np.maximum(low, moved[0]), 0).prod()
        exact = 2 * (np.prod(sides) - common) / np.prod(sides)
        try:
            found = voxel_mismatch(box(low, high), box(*moved), edge)
        except MeshError:
            assert min(sides) < edge  # no centre is inside
        else:
            assert abs(found.mismatch - exact) <= found.bound

    def test_the_bound_counts_the_voxels_that_the_surface_meets(self):
        """Sides lie in the middle of voxels: 12³ voxels are touched, 10³ of them wholly inside."""
        solid = box((0.3, 0.3, 0.3), (11.7, 11.7, 11.7))
        found = voxel_mismatch(solid, solid, 1.0)
        surface, volume = 12**3 - 10**3, 11.4**3
        expected = (surface + surface / volume * surface) / 12**3
        assert found.bound == pytest.approx(expected, rel=1e-12)


def agree(reference, other):
    """Check that the figure in voxels is within its bound of the exact one, and closer.

    Centres are spread more evenly than random points, whose n hits have a standard deviation of
    √n.
    """
    found, exact = voxel_mismatch(reference, other), mismatch(reference, other)
    assert abs(found.mismatch - exact) <= found.bound
    deviation = math.sqrt(found.differing_voxels) / found.reference_voxels
    assert abs(found.mismatch - exact) <= 5 * deviation


class TestDevices:
    @pytest.mark.parametrize("triangles", [10_000, 1000, 100, 20, 4])
    @pytest.mark.slow
    def test_levels_of_fogra39(self, fogra39_gamut, triangles):
        agree(fogra39_gamut.history.full(), fogra39_gamut.history.level(triangles))
