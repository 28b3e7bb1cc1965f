"""Parts of device surfaces: exact unions of solids, recovered edges, volumes by rays."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from gamutcore.boundary.radial_envelope import radial_envelope, radial_volume, recover_edges
from gamutcore.boundary.radial_hull import radial_hull
from gamutcore.geometry import TriangleMesh, grid_step, nearest_grid_points


def divided_box(size, times, angles=(0.0, 0.0, 0.0)):
    mesh = trimesh.creation.box(size)
    for _ in range(times):
        mesh = mesh.subdivide()
    mesh.apply_transform(trimesh.transformations.euler_matrix(*angles))
    return mesh


def envelope_of(*meshes):
    """The envelope around the origin, and its step."""
    points = np.vstack([mesh.vertices for mesh in meshes])
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes[:-1])])
    corners = np.vstack([mesh.faces + start for mesh, start in zip(meshes, starts, strict=True)])
    step = grid_step(points)
    position = nearest_grid_points(points, step)
    envelope = radial_envelope(position, corners.astype(np.int32), step)
    return envelope, position, step


def used(envelope):
    """The envelope as a mesh of its vertices only."""
    rows, faces = np.unique(envelope.faces, return_inverse=True)
    return TriangleMesh(envelope.position[rows], faces.reshape(-1, 3).astype(np.int32))


@given(st.tuples(*[st.floats(-3, 3)] * 3), st.tuples(*[st.floats(0.6, 1.6)] * 3), st.integers(2, 4))
@pytest.mark.slow
def test_two_boxes_that_cross_make_their_union(angles, size, times):
    one, two = divided_box((2, 2, 2), times), divided_box(2 * np.array(size), times, angles)
    envelope, _, _ = envelope_of(one, two)
    mesh = used(envelope)
    assert mesh.validity(np.zeros(3)).is_gamut
    union = trimesh.boolean.union([one, two], engine="manifold")
    # edges shorter than the cells of the boxes are not followed: their volume falls with the cell
    assert mesh.volume == pytest.approx(union.volume, rel=0.03 / 4 ** (times - 2))


def test_crossing_vertices_are_on_the_lines_between_points():
    envelope, position, step = envelope_of(
        divided_box((2, 2, 2), 3), divided_box((3, 1.5, 1.6), 3, (0.3, 0.5, 0.7))
    )
    assert (envelope.share > 0).any()
    start, end = position[envelope.ends[:, 0]], position[envelope.ends[:, 1]]
    between = start + envelope.share[:, np.newaxis] * (end - start)
    assert np.abs(between - envelope.position).max() <= step / 2


def sphere(seed, count):
    points = np.random.default_rng(seed).normal(size=(count, 3))
    points /= np.linalg.norm(points, axis=1)[:, np.newaxis]
    return points, radial_hull(points)


def edges_of(faces):
    return {frozenset(pair) for a, b, c in faces.tolist() for pair in ((a, b), (b, c), (c, a))}


@settings(max_examples=30)
@given(st.integers(0, 10_000), st.integers(20, 300), st.integers(1, 100))
def test_the_mesh_stays_valid_and_pairs_become_edges(seed, count, wanted):
    points, faces = sphere(seed, count)
    pairs = np.random.default_rng(seed + 1).integers(count, size=(wanted, 2)).astype(np.int32)
    found, given_up = recover_edges(points, faces, pairs)
    assert TriangleMesh(points, found).validity(np.zeros(3)).is_gamut
    edges = edges_of(found)
    missing = sum(frozenset(pair) not in edges for pair in pairs.tolist())
    assert missing == given_up


def test_the_first_of_two_crossing_pairs_wins():
    points = np.array([(1, 1, 1), (1, -1, 1), (-1, -1, 1), (-1, 1, 1), (0, 0, -1)], float)
    faces = radial_hull(points)
    for pairs in ([(0, 2), (1, 3)], [(1, 3), (0, 2)]):
        found, given_up = recover_edges(points, faces, np.array(pairs, np.int32))
        assert frozenset(pairs[0]) in edges_of(found)
        assert given_up == 1


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
    faces = np.arange(3 * count, dtype=np.int32).reshape(-1, 3)
    found = radial_volume(corners.reshape(-1, 3), faces, np.zeros(3), pixels)
    assert found.uncovered == pytest.approx((along == 0).mean())
    assert found.volume == pytest.approx((along**3).sum() / 3 * (2 / pixels) ** 2, rel=1e-6)
    assert found.depth == pytest.approx((along * np.linalg.norm(rays, axis=1)).min(), rel=1e-6)
