"""Values at the nearest points of a surface, compared with trimesh's nearest points."""

import numpy as np
import pytest
import trimesh

from gamutcore.history.nearest_values import nearest_values

SCALE = 5000


def values_of(positions):
    """Return values that are an affine function of the position, so that they identify it."""
    return np.rint((np.asarray(positions) + 2.0) * SCALE)


@pytest.mark.parametrize("distance", [0.0, 0.01, 0.2])
def test_are_interpolated_where_the_surface_is_nearest(icosphere, distance):
    mesh = icosphere(3)
    random = np.random.default_rng(1)
    places = random.normal(size=(500, 3))
    places /= np.linalg.norm(places, axis=1)[:, np.newaxis]
    places *= 1 + distance * random.uniform(-1, 1, (500, 1))
    found = nearest_values(
        places.astype(np.float32), mesh.vertices, mesh.faces, values_of(mesh.vertices).astype("i2")
    )
    nearest, _, _ = trimesh.proximity.closest_point_naive(mesh.to_trimesh(), places)
    # values and result are both rounded, by at most half a step
    np.testing.assert_allclose(found, (nearest + 2.0) * SCALE, rtol=0, atol=1.05)


def test_at_vertices_are_theirs(icosphere):
    mesh = icosphere(2)
    values = np.random.default_rng(2).integers(0, 5100, (len(mesh.vertices), 2)).astype(np.int16)
    found = nearest_values(mesh.vertices, mesh.vertices, mesh.faces, values)
    np.testing.assert_array_equal(found, values)


def test_stay_within_the_range_of_the_surface(icosphere):
    mesh = icosphere(1)
    places = np.random.default_rng(3).normal(size=(1000, 3)).astype(np.float32)
    for level in (0, 5100):
        values = np.full((len(mesh.vertices), 1), level, np.int16)
        assert (nearest_values(places, mesh.vertices, mesh.faces, values) == level).all()


def test_no_points_have_no_values(icosphere):
    mesh = icosphere(0)
    values = np.zeros((12, 3), np.int16)
    none = np.empty((0, 3), np.float32)
    assert nearest_values(none, mesh.vertices, mesh.faces, values).shape == (0, 3)


def test_values_on_a_tetrahedron():
    corners = np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)], np.float32)
    faces = np.array([(0, 1, 2), (0, 2, 3), (0, 3, 1), (1, 3, 2)], np.int32)
    values = np.array([[0], [30], [60], [90]], np.int16)
    middle = corners[[1, 3, 2]].mean(axis=0, keepdims=True)
    assert nearest_values(2 * middle, corners, faces, values).tolist() == [[60]]
