"""Fixtures of the tests of decimation."""

import numpy as np
import pytest

from gamutcore.boundary import modified_convex_hull
from gamutcore.decimation.collapse import collapse_edge, empty_workspace
from gamutcore.decimation.costs import GridPositions, cost_named, initial_state
from gamutcore.decimation.deviation_samples import LARGEST_SHARE, SAMPLES
from gamutcore.decimation.edge_queue import fill_queue
from gamutcore.decimation.record import empty_record
from gamutcore.decimation.surface_mesh import (
    keeps_star_shape,
    link_condition_holds,
    surface_of,
    write_edge_link,
)
from gamutcore.geometry import opposite_corners

FINEST = cost_named("finest").parameters


@pytest.fixture(scope="session")
def surface_from():
    """Return a function from positions relative to the centre and faces to a `SurfaceMesh`."""

    def make(positions, faces):
        faces = np.ascontiguousarray(faces, np.int32)
        positions = np.ascontiguousarray(positions, np.float64)
        return surface_of(positions, faces, opposite_corners(faces, len(positions)))

    return make


@pytest.fixture(scope="session")
def state_of():
    """Return a function from parameters, positions and faces to the state of a full boundary."""

    def make(parameters, positions, faces, grid=None):
        faces = np.ascontiguousarray(faces, np.int32)
        positions = np.ascontiguousarray(positions, np.float64)
        opposite = opposite_corners(faces, len(positions))
        grid = grid or GridPositions(positions.astype(np.float32), np.zeros(3), 1.0)
        return initial_state(parameters, positions, faces, opposite, grid)

    return make


@pytest.fixture(scope="session")
def bumpy_mesh(random_cloud):
    """Return a function from a seed to positions about a centre and faces of a boundary."""

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


def _ends(surface, corner):
    """Return the two vertices of the edge that a corner faces, in the kernels' order."""
    place = 3 * (corner // 3)
    return (
        int(surface.vertex[place + (corner + 1) % 3]),
        int(surface.vertex[place + (corner + 2) % 3]),
    )


@pytest.fixture(scope="session")
def ends_of():
    """Return a function from a surface and a corner to the ends of the edge that it faces."""
    return _ends


@pytest.fixture(scope="session")
def corner_of():
    """Return a function from a surface and an edge's ends to a corner that faces the edge."""

    def find(surface, one, two):
        for edge in np.flatnonzero(surface.corner_facing >= 0):
            corner = int(surface.corner_facing[edge])
            if set(_ends(surface, corner)) == {one, two}:
                return corner
        message = f"{one} and {two} are not the ends of an edge"
        raise LookupError(message)

    return find


@pytest.fixture(scope="session")
def faces_left():
    """Return a function from a surface to the numbers and vertices of its remaining faces."""

    def left(surface):
        corners = surface.corner_facing[surface.corner_facing >= 0]
        numbers = np.unique(np.concatenate([corners, surface.opposite[corners]]) // 3)
        return numbers, surface.vertex.reshape(-1, 3)[numbers]

    return left


def _workspace(surface):
    edges = len(surface.corner_facing)
    work = empty_workspace(edges, len(surface.position), np.zeros(1, np.int64), np.empty(0))
    work.queue.heap[:] = np.arange(edges)
    work.queue.priority[:] = np.arange(edges)
    fill_queue(work.queue, edges)
    return work


@pytest.fixture(scope="session")
def random_collapses():
    """Return a generator that collapses random edges to positions near their midpoints.

    Its arguments are a state, a seed and the number of collapses. It yields the kept
    vertex after each collapse.
    """

    def collapses(state, seed, wanted):
        random, surface = np.random.default_rng(seed), state.surface
        record, work = empty_record(len(surface.position)), _workspace(surface)
        ring, done = np.empty((200, 2), np.int32), 0
        for edge in random.permutation(len(surface.corner_facing)).tolist():
            if done == wanted:
                return
            corner = int(surface.corner_facing[edge])
            if corner < 0:
                continue
            one, two = _ends(surface, corner)
            middle = (surface.position[one] + surface.position[two]) / 2
            work.point[:] = middle * random.uniform(0.95, 1.05)
            count = write_edge_link(surface, one, two, ring)
            if not link_condition_holds(surface, one, two) or not keeps_star_shape(
                surface.position, ring, count, *work.point
            ):
                continue
            work.rounded[:] = work.point
            kept = collapse_edge(state, record, work, edge)
            done += 1
            yield int(kept)

    return collapses


@pytest.fixture(scope="session")
def by_hand():
    """Return a function that finds the face whose cone contains each point, and w |1 − t³|.

    It solves p = α a + β b + γ c for every point p and every face (a, b, c). All three coefficients
    are positive in the cone of the face, and 1 ÷ t is their sum.
    """

    def compute(positions, faces, points, weights):
        cones = np.linalg.inv(np.swapaxes(positions[faces], 1, 2))
        parts = np.einsum("fij,sj->fsi", cones, points)
        inside = parts.min(axis=2).argmax(axis=0)
        inverse = parts[inside, np.arange(len(points))].sum(axis=1)
        return inside, weights * np.abs(1 - 1 / inverse**3)

    return compute


@pytest.fixture(scope="session")
def samples_in():
    """Return a function from a deviation and a face to the indices of the face's samples."""
    return lambda deviation, face: list(range(deviation.begin[face], deviation.end[face]))


@pytest.fixture(scope="session")
def points_of():
    """Return a function from a deviation and indices of samples to their points."""

    def points(deviation, samples):
        return np.stack([deviation.x[samples], deviation.y[samples], deviation.z[samples]], axis=1)

    return points


@pytest.fixture(scope="session")
def all_samples(samples_in):
    """Return a function from a deviation to the indices of all assigned samples."""

    def listed(deviation):
        faces = range(len(deviation.begin))
        return np.array([sample for face in faces for sample in samples_in(deviation, face)], int)

    return listed


@pytest.fixture(scope="session")
def assert_in_their_faces(faces_left, by_hand, samples_in, points_of):
    """Return a check of the assignment of all samples and of the errors of all faces.

    Its arguments are a deviation and its surface. It returns the indices of the samples.
    """

    def check(deviation, surface):
        numbers, faces = faces_left(surface)
        lists = [samples_in(deviation, int(number)) for number in numbers]
        samples = np.array([sample for face in lists for sample in face])
        owners = np.repeat(np.arange(len(lists)), [len(face) for face in lists])
        assert len(set(samples.tolist())) == len(samples) == deviation.counts[SAMPLES]
        points, weights = points_of(deviation, samples), deviation.weight[samples]
        inside, shares = by_hand(surface.position, faces, points, weights)
        # a sample on an edge between two faces may be in either
        cones = np.linalg.inv(np.swapaxes(surface.position[faces[owners]], 1, 2))
        parts = np.einsum("sij,sj->si", cones, points)
        assert parts.min() >= -1e-9
        clear = parts.min(axis=1) > 1e-9
        np.testing.assert_array_equal(inside[clear], owners[clear])
        expected = np.bincount(owners, np.minimum(shares, LARGEST_SHARE * weights), len(numbers))
        np.testing.assert_allclose(
            deviation.error[numbers], expected, rtol=1e-7, atol=1e-9 * weights.sum()
        )
        gone = np.setdiff1d(np.arange(len(deviation.begin)), numbers)
        assert (deviation.begin[gone] == deviation.end[gone]).all()
        assert (deviation.error[gone] == 0.0).all()
        return samples

    return check
