"""Volumes by rays, against bodies of known volume."""

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from gamutcore.boundary.radial_volume import COARSE, FINE, radial_volume


def measured(points, faces, centre, pixels=FINE):
    return radial_volume(
        np.array(points, float), np.array(faces, np.int32), np.array(centre, float), pixels
    )


def volume(points, faces, centre):
    return measured(points, faces, centre).volume


@pytest.mark.parametrize("centre", [(0, 0, 0), (0.3, -0.2, 0.1)])
@pytest.mark.parametrize("turned", [1, -1])
def test_of_a_sphere_it_is_the_mesh_s_volume(centre, turned):
    ball = trimesh.creation.icosphere(5, 1.0)
    assert volume(ball.vertices, ball.faces[:, ::turned], centre) == pytest.approx(
        ball.volume, rel=2e-5
    )


def test_inner_faces_do_not_count():
    ball = trimesh.creation.icosphere(4, 1.0)
    rng = np.random.default_rng(3)
    inner = rng.uniform(-0.3, 0.3, (60, 3))
    points = np.vstack([ball.vertices, inner])
    faces = np.vstack([ball.faces, np.arange(60).reshape(-1, 3) + len(ball.vertices)])
    assert volume(points, faces, (0, 0, 0)) == pytest.approx(ball.volume, rel=2e-5)


def test_of_two_boxes_that_cross_it_is_that_of_their_union():
    one, two = trimesh.creation.box((4, 1, 1)), trimesh.creation.box((1, 4, 1))
    parts = [body.subdivide().subdivide().subdivide() for body in (one, two)]
    points = np.vstack([part.vertices for part in parts])
    faces = np.vstack([parts[0].faces, parts[1].faces + len(parts[0].vertices)])
    # all of a cross of bars is seen from its middle
    assert volume(points, faces, (0, 0, 0)) == pytest.approx(4 + 4 - 1, rel=1e-3)


@pytest.mark.parametrize("centre", [(0, 0, 0), (0.9, -0.9, 0.99)])
def test_large_triangles_surround_what_is_inside_of_them(centre):
    """Seen under wide angles, from a corner of the box too."""
    box = trimesh.creation.box((2, 2, 2))
    found = measured(box.vertices, box.faces, centre)
    assert found.uncovered == 0
    assert found.volume == pytest.approx(8, rel=2e-3)
    assert found.depth == pytest.approx(1 - np.abs(centre).max(), rel=1e-4)


def test_from_outside_some_rays_meet_nothing():
    box = trimesh.creation.box((2, 2, 2))
    found = measured(box.vertices, box.faces, (3, 0, 0), COARSE)
    # half of the directions and more point away from the box
    assert 0.5 < found.uncovered < 1
    assert found.depth == 0


@given(st.integers(0, 1000), st.integers(1, 200), st.floats(0.01, 3))
@settings(max_examples=20)
def test_rays_meet_what_a_test_of_all_pairs_finds(seed, count, size):
    rng = np.random.default_rng(seed)
    corners = rng.normal(size=(count, 1, 3)) * 3 + rng.normal(size=(count, 3, 3)) * size
    pixels = 8
    middles = (np.arange(pixels) + 0.5) * 2 / pixels - 1
    u, v = (grid.ravel() for grid in np.meshgrid(middles, middles, indexing="ij"))
    ahead = np.stack([np.ones_like(u), u, v], axis=1)
    rays = np.concatenate(
        [np.roll(ahead * (sign, 1, 1), axis, axis=1) for axis in range(3) for sign in (-1, 1)]
    )
    # p = weights · corners with weights of one sign, by the inverse of each triangle
    weights = np.linalg.solve(corners.transpose(0, 2, 1)[:, np.newaxis], rays[..., np.newaxis])
    weights = weights[..., 0]
    hit = (weights >= 0).all(axis=2)
    along = np.where(hit, 1 / np.where(hit, weights.sum(axis=2), 1.0), 0.0).max(axis=0)
    found = measured(corners.reshape(-1, 3), np.arange(3 * count).reshape(-1, 3), (0, 0, 0), pixels)
    assert found.uncovered == pytest.approx((along == 0).mean())
    assert found.volume == pytest.approx((along**3).sum() / 3 * (2 / pixels) ** 2, rel=1e-6)
    assert found.depth == pytest.approx((along * np.linalg.norm(rays, axis=1)).min(), rel=1e-6)
