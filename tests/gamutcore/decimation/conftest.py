"""Fixtures for the tests of decimation's parts."""

import numpy as np
import pytest

from gamutcore.boundary import modified_convex_hull
from gamutcore.corner_table import opposite_corners
from gamutcore.decimation.star import surface_of


@pytest.fixture(scope="session")
def surface_from():
    """Return a function from positions relative to the centre and faces to a `Surface`."""

    def make(positions, faces):
        faces = np.ascontiguousarray(faces, np.int32)
        positions = np.ascontiguousarray(positions, np.float64)
        return surface_of(positions, faces, opposite_corners(faces, len(positions)))

    return make


@pytest.fixture(scope="session")
def bumpy_mesh(random_cloud):
    """Return a function from a seed to positions relative to a centre, and faces, of a boundary."""

    def make(seed, count=60):
        boundary = modified_convex_hull(random_cloud(seed, count))
        return boundary.mesh.vertices - boundary.centre, boundary.mesh.faces

    return make


@pytest.fixture(scope="session")
def edges_of():
    """Return a function from faces to their edges as sorted pairs."""
    return lambda faces: sorted(
        {tuple(sorted((int(f[i]), int(f[(i + 1) % 3])))) for f in faces for i in range(3)}
    )
