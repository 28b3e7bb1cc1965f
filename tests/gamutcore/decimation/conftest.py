"""Fixtures of the tests of decimation."""

import numpy as np
import pytest

from gamutcore.boundary import modified_convex_hull
from gamutcore.decimation.surface_mesh import surface_of
from gamutcore.geometry import opposite_corners


@pytest.fixture(scope="session")
def surface_from():
    """Return a function from positions relative to the centre and faces to a `SurfaceMesh`."""

    def make(positions, faces):
        faces = np.ascontiguousarray(faces, np.int32)
        positions = np.ascontiguousarray(positions, np.float64)
        return surface_of(positions, faces, opposite_corners(faces, len(positions)))

    return make


@pytest.fixture(scope="session")
def bumpy_mesh(random_cloud):
    """Return a function from a seed to positions about a centre and faces of a boundary."""

    def make(seed, count=60):
        boundary = modified_convex_hull(random_cloud(seed, count))
        return boundary.mesh.vertices - boundary.centre, boundary.mesh.faces

    return make
