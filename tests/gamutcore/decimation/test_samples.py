"""Samples in faces: no weight is lost, and each is in the list of the face whose cone it is in."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gamutcore.decimation.costs import finest
from gamutcore.decimation.samples import (
    LARGEST_RING,
    LARGEST_SHARE,
    hand_over_samples,
    no_deviation,
    redistribute_samples,
    room_for_samples,
    start_at_surface,
    thin_samples,
)
from gamutcore.mesh import TriangleMesh
from gamutcore.metric import mismatch


def start_at_centroids(deviation, surface):
    start_at_surface(deviation, surface, 1)


def start_at_parts(deviation, surface):
    start_at_surface(deviation, surface, PARTS * len(surface.vertex) // 3)


PARTS = 9
STARTS = (start_at_centroids, start_at_parts)


def six_volumes(positions, faces):
    return np.linalg.det(positions[faces])


def listed(deviation, numbers, samples_in):
    """Return all samples in the lists of faces, and the place of each one's face in `numbers`."""
    lists = [samples_in(deviation, int(number)) for number in numbers]
    samples = np.array([sample for face in lists for sample in face])
    owners = np.repeat(np.arange(len(lists)), [len(face) for face in lists])
    return samples, owners


def assert_in_their_faces(deviation, surface, faces_left, by_hand, samples_in):
    """Check that each sample in use is in exactly the list of its cone's face, and all errors."""
    numbers, faces = faces_left(surface)
    samples, owners = listed(deviation, numbers, samples_in)
    assert len(set(samples.tolist())) == len(samples)
    points, weights = deviation.point[samples], deviation.weight[samples]
    inside, shares = by_hand(surface.position, faces, points, weights)
    # a sample on an edge between two faces may be in the list of either
    cones = np.linalg.inv(np.swapaxes(surface.position[faces[owners]], 1, 2))
    parts = np.einsum("sij,sj->si", cones, points)
    assert parts.min() >= -1e-9
    clear = parts.min(axis=1) > 1e-9
    np.testing.assert_array_equal(inside[clear], owners[clear])
    expected = np.bincount(owners, np.minimum(shares, LARGEST_SHARE * weights), len(numbers))
    np.testing.assert_allclose(
        deviation.error[numbers], expected, rtol=1e-7, atol=1e-9 * weights.sum()
    )
    gone = np.setdiff1d(np.arange(len(deviation.first)), numbers)
    assert (deviation.first[gone] == -1).all()
    assert (deviation.error[gone] == 0.0).all()
    return samples


class Tracked:
    """A deviation beside a surface while random edges are collapsed."""

    def __init__(self, start, positions, faces, surface):
        self.surface = surface
        # the cost that does nothing about the samples but hand them over and redistribute them
        self.state = finest.state(positions, faces)
        room = no_deviation(room_for_samples(PARTS * len(faces), len(faces)), len(faces))
        self.state = self.state._replace(deviation=room)
        self.deviation = room
        start(room, surface)


@pytest.fixture(scope="session")
def tracked(bumpy_mesh, surface_from):
    """Return a function from a way to start, a seed and a number of points to a `Tracked`."""

    def make(start, seed, count=50):
        positions, faces = bumpy_mesh(seed, count)
        return Tracked(start, positions, faces, surface_from(positions, faces))

    return make


@pytest.mark.parametrize("start", STARTS)
@settings(max_examples=6)
@given(seed=st.integers(0, 10**6))
def test_samples_follow_random_collapses(
    tracked, random_collapses, faces_left, by_hand, samples_in, start, seed
):
    case = tracked(start, seed)
    deviation, surface = case.deviation, case.surface
    _numbers, faces = faces_left(surface)
    whole = six_volumes(surface.position, faces).sum()
    count = int(deviation.counts[2])
    assert count == len(faces) if start is start_at_centroids else count > 2 * len(faces)
    for _ in random_collapses(case.state, surface, seed, 25):
        samples = assert_in_their_faces(deviation, surface, faces_left, by_hand, samples_in)
        assert len(samples) == count
        # the share of the reference's volume, whatever the surface is now
        assert deviation.weight[samples].sum() == pytest.approx(whole, rel=1e-12)
    assert len(faces_left(surface)[1]) < len(faces)
    assert deviation.error.sum() > 0


@pytest.mark.parametrize("start", STARTS)
def test_at_the_start_the_surface_deviates_from_itself_by_nothing(
    tracked, faces_left, by_hand, samples_in, start
):
    case = tracked(start, 3)
    samples = assert_in_their_faces(case.deviation, case.surface, faces_left, by_hand, samples_in)
    whole = six_volumes(case.surface.position, faces_left(case.surface)[1]).sum()
    assert case.deviation.weight[samples].sum() == pytest.approx(whole, rel=1e-12)
    assert case.deviation.error.sum() <= 1e-12 * whole


def test_samples_of_a_level_are_those_of_the_faces_that_are_left(
    tracked, random_collapses, faces_left, by_hand, samples_in
):
    """A reference may be taken at any level; its quadrature is exact for linear functions."""
    case = tracked(start_at_centroids, 5)
    for _ in random_collapses(case.state, case.surface, 0, 20):
        pass
    _numbers, faces = faces_left(case.surface)
    fresh = no_deviation(len(faces), len(case.deviation.first))
    start_at_surface(fresh, case.surface, 1)
    samples = assert_in_their_faces(fresh, case.surface, faces_left, by_hand, samples_in)
    assert len(samples) == len(faces)
    # integrals over the solid, of functions that grow with the radius: for each cone that over its
    # face, times a constant
    corners = case.surface.position[faces]
    volumes = six_volumes(case.surface.position, faces)
    for form in ([1, 0, 0], [0, 1, 1], [1, -2, 3]):
        exact = (volumes * (corners @ form).mean(axis=1)).sum()
        summed = fresh.weight[samples] @ (fresh.point[samples] @ form)
        assert summed == pytest.approx(exact, rel=1e-10, abs=1e-10 * volumes.sum())


@pytest.mark.parametrize("start", STARTS)
def test_samples_follow_moves(tracked, faces_left, by_hand, samples_in, start):
    case = tracked(start, 6)
    random = np.random.default_rng(0)
    for vertex in range(0, len(case.surface.position), 3):
        case.surface.position[vertex] *= random.uniform(0.9, 1.1)
        redistribute_samples(case.deviation, case.surface, vertex)
        assert_in_their_faces(case.deviation, case.surface, faces_left, by_hand, samples_in)
    assert case.deviation.error.sum() > 0


@settings(max_examples=20)
@given(seed=st.integers(0, 10**6), wanted=st.integers(1, 3000))
def test_no_sample_stands_for_much_more_than_the_share_that_is_wanted(
    bumpy_mesh, surface_from, samples_in, seed, wanted
):
    """Each face has at least one, those of more than a share so many as to be near it."""
    positions, faces = bumpy_mesh(seed)
    deviation = no_deviation(room_for_samples(wanted, len(faces)), len(faces))
    start_at_surface(deviation, surface_from(positions, faces), wanted)
    volumes = six_volumes(positions, faces)
    share = volumes.sum() / wanted
    for face, volume in enumerate(volumes):
        samples = samples_in(deviation, face)
        assert samples
        weights = deviation.weight[samples]
        assert weights.sum() == pytest.approx(volume, rel=1e-12)
        assert np.ptp(weights) == 0
        assert weights[0] <= 1.5**2 * share * (1 + 1e-12)
        if volume > 1.5**2 * share:
            assert weights[0] > share / 1.5**2
    used = int(deviation.counts[2])
    assert used <= len(deviation.point)


@pytest.mark.parametrize("start", STARTS)
@settings(max_examples=10)
@given(seed=st.integers(0, 10**6), part=st.floats(0.02, 1))
def test_thinning_leaves_samples_that_stand_for_equal_shares(
    tracked, random_collapses, faces_left, by_hand, samples_in, start, seed, part
):
    case = tracked(start, seed, 100)
    deviation, surface = case.deviation, case.surface
    for _ in random_collapses(case.state, surface, 1, 60):
        pass
    count = int(deviation.counts[2])
    before = assert_in_their_faces(deviation, surface, faces_left, by_hand, samples_in)
    weights = deviation.weight.copy()
    numbers, _ = faces_left(surface)
    in_faces = [weights[samples_in(deviation, int(face))].sum() for face in numbers]
    assert thin_samples(deviation, surface, count) is False
    np.testing.assert_array_equal(deviation.weight, weights)
    most = max(2, int(part * (count - 1)))
    assert thin_samples(deviation, surface, most) is True
    after = assert_in_their_faces(deviation, surface, faces_left, by_hand, samples_in)
    assert set(after) < set(before)
    assert 0 < len(after) == int(deviation.counts[2]) <= most // 2
    share = weights[before].sum() / (most // 2)
    marks = deviation.weight[after] / share
    np.testing.assert_allclose(marks, np.rint(marks), rtol=1e-9)
    # one mark, or as many as its share was worth before
    assert (np.abs(marks - weights[after] / share) < 1 + 1e-9).all()
    # no weight is lost, and no face has a share more or less than it had
    assert deviation.weight[after].sum() == pytest.approx(weights[before].sum(), rel=1e-9)
    now = [deviation.weight[samples_in(deviation, int(face))].sum() for face in numbers]
    assert np.abs(np.subtract(now, in_faces)).max() <= share * (1 + 1e-9)


def test_handed_over_samples_are_beside_where_they_were(tracked, samples_in):
    case = tracked(start_at_centroids, 9)
    corner = int(case.surface.corner_facing[17])
    twin = int(case.surface.opposite[corner])
    gone = [corner // 3, twin // 3]
    before = [set(samples_in(case.deviation, face)) for face in gone]
    faces = case.surface.vertex.reshape(-1, 3)
    lists = {face: set(samples_in(case.deviation, face)) for face in range(len(faces))}
    hand_over_samples(case.deviation, case.surface, corner)
    for face, samples in zip(gone, before, strict=True):
        assert samples
        assert samples_in(case.deviation, face) == []
        taker = next(
            other
            for other in range(len(faces))
            if other not in gone and samples <= set(samples_in(case.deviation, other))
        )
        # a face that shares a side with it and stays
        assert len(set(faces[taker]) & set(faces[face])) == 2
        assert lists[taker] <= set(samples_in(case.deviation, taker))


def test_the_ring_may_be_larger_than_the_scratch(surface_from, faces_left, by_hand, samples_in):
    """Redistribution goes around a vertex with any number of faces."""
    sides = LARGEST_RING + 50
    turn = np.linspace(0, 2 * np.pi, sides, endpoint=False)
    rim = np.stack([np.cos(turn), np.sin(turn), np.zeros(sides)], axis=1)
    positions = np.vstack([rim, [[0, 0, 1], [0, 0, -1]]])
    after = (np.arange(sides) + 1) % sides
    above = np.stack([np.arange(sides), after, np.full(sides, sides)], axis=1)
    below = np.stack([after, np.arange(sides), np.full(sides, sides + 1)], axis=1)
    surface = surface_from(positions, np.vstack([above, below]))
    deviation = no_deviation(3 * len(positions), 2 * sides)
    start_at_surface(deviation, surface, 1)
    surface.position[sides] = (0.2, 0.1, 0.8)
    redistribute_samples(deviation, surface, sides)
    assert_in_their_faces(deviation, surface, faces_left, by_hand, samples_in)
    assert deviation.error.sum() > 0


@pytest.mark.parametrize("start", STARTS)
def test_the_sum_of_the_errors_is_the_mismatch(
    start, icosphere, surface_from, random_collapses, faces_left
):
    """Against exact boolean operations, on a sphere of 2562 vertices with 300 of them left."""
    mesh = icosphere(4)
    positions = mesh.vertices.astype(np.float64)
    case = Tracked(start, positions, mesh.faces, surface_from(positions, mesh.faces))
    wanted = len(positions) - 300
    rounds = 0
    while wanted > 0 and rounds < 20:
        done = sum(1 for _ in random_collapses(case.state, case.surface, rounds, wanted))
        wanted, rounds = wanted - done, rounds + 1
    _, faces = faces_left(case.surface)
    assert len(faces) <= 2 * 320
    kept, renamed = np.unique(faces, return_inverse=True)
    level = TriangleMesh(
        case.surface.position[kept].astype(np.float32), renamed.reshape(-1, 3).astype(np.int32)
    )
    exact = mismatch(mesh, level)
    assert exact > 0.02
    summed = case.deviation.error.sum() / 6 / mesh.volume
    assert summed == pytest.approx(exact, rel=0.05)
