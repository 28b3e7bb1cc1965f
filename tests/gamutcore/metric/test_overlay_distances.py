"""Lower bounds of overlaid surfaces are attained, and upper bounds hold."""

import numpy as np
import trimesh

from gamutcore.mesh import TriangleMesh
from gamutcore.metric.cones import compute_cones, locate
from gamutcore.metric.distance_bound import breadth_first, make_surface
from gamutcore.metric.overlay_distances import (
    FROM_LOWER,
    FROM_UPPER,
    TO_LOWER,
    TO_UPPER,
    new_bounds,
    raise_lower_bounds,
)


def surface_of(mesh):
    return make_surface(mesh.vertices.astype(np.float64), mesh.faces.astype(np.int32).ravel())


def test_lower_bounds_are_attained_at_the_given_points(distances_to):
    fine, coarse = trimesh.creation.icosphere(3, 1.0), trimesh.creation.icosphere(1, 1.0)
    reference, other = surface_of(fine), surface_of(coarse)
    locations = locate(reference.position, *breadth_first(reference), compute_cones(other))
    away = distances_to(
        fine.vertices, TriangleMesh(coarse.vertices.astype(np.float32), coarse.faces)
    )
    for points in (np.arange(len(away), dtype=np.int32), np.arange(7, 200, 5, dtype=np.int32)):
        bounds = new_bounds(1e4, 1.5)
        raise_lower_bounds(reference, other, locations, points, bounds)
        np.testing.assert_allclose(bounds[FROM_LOWER], away[points].max(), rtol=1e-6)
        # points of the other surface on the same rays are not nearer than the surface
        assert 0.0 < bounds[TO_LOWER] <= locations.along[points].max()
        assert bounds[FROM_UPPER] == 1.5 * bounds[FROM_LOWER]
        assert bounds[TO_UPPER] == 1.5 * bounds[TO_LOWER]


def test_no_points_leave_the_bounds_alone():
    surface = surface_of(trimesh.creation.icosphere(1, 1.0))
    locations = locate(surface.position, *breadth_first(surface), compute_cones(surface))
    bounds = new_bounds(1e4, 1.5)
    raise_lower_bounds(surface, surface, locations, np.empty(0, np.int32), bounds)
    np.testing.assert_array_equal(bounds, new_bounds(1e4, 1.5))
