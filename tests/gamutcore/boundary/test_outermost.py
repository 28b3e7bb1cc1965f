from __future__ import annotations

import numpy as np
import trimesh

from gamutcore.boundary.outermost import arrange, edge_crossings, is_hidden


def directions(count, seed=1):
    found = np.random.default_rng(seed).normal(size=(count, 3))
    return found / np.linalg.norm(found, axis=1)[:, np.newaxis]


def spheres(*radii):
    meshes = [trimesh.creation.icosphere(3, radius) for radius in radii]
    mesh = trimesh.util.concatenate(meshes)
    return np.ascontiguousarray(mesh.vertices), mesh.faces.astype(np.int32)


def test_a_larger_sphere_hides_a_smaller_one():
    position, faces = spheres(1.0, 2.0)
    sheets = arrange(position, faces, 1e-9)
    radii = np.linalg.norm(position, axis=1)
    np.testing.assert_array_equal(is_hidden(sheets, position), radii < 1.5)


def test_a_point_within_the_tolerance_is_not_hidden():
    position, faces = spheres(1.0)
    near = position * 0.99
    assert not is_hidden(arrange(position, faces, 0.02), near).any()
    assert is_hidden(arrange(position, faces, 0.001), near).all()


def test_the_centre_itself_is_hidden():
    position, faces = spheres(1.0)
    assert is_hidden(arrange(position, faces, 0.0), np.zeros((1, 3))).all()


def test_edges_cross_a_sphere_once():
    position, faces = spheres(1.0)
    ends = np.concatenate([position, 0.5 * directions(50), 1.5 * directions(50)])
    first = len(position)
    edges = np.column_stack([np.arange(50) + first, np.arange(50) + first + 50]).astype(np.int32)
    sheets = arrange(ends, faces, 0.0)
    count, crossings = edge_crossings(sheets, edges, 100)
    assert count == 50
    np.testing.assert_array_equal(np.sort(crossings.edge), np.arange(50))
    start, end = ends[edges[crossings.edge]].transpose(1, 0, 2)
    points = start + crossings.share[:, np.newaxis] * (end - start)
    corners = position[faces[crossings.triangle]]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    np.testing.assert_allclose(((points - corners[:, 0]) * normals).sum(axis=1), 0, atol=1e-9)
    few, kept = edge_crossings(sheets, edges, 10)
    assert few == 50
    assert len(kept.edge) == 10
