"""Assignment of samples: no weight is lost, and each sample lies in the cone of its face."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gamutcore.decimation.costs import cost_named
from gamutcore.decimation.costs.sample_assignment import (
    NO_FACE,
    assign_samples,
    reassign_samples,
    thin_samples,
)
from gamutcore.decimation.costs.samples import (
    SAMPLES,
    empty_deviation,
    sample_capacity,
    take_samples,
)
from gamutcore.decimation.star import LARGEST_LINK
from gamutcore.mesh import TriangleMesh
from gamutcore.metric import mismatch

FINEST = cost_named("finest").parameters


def start_at_centroids(deviation, surface):
    take_samples(deviation, surface, 1)
    assign_samples(deviation, surface)


def start_at_parts(deviation, surface):
    take_samples(deviation, surface, PARTS * len(surface.vertex) // 3)
    assign_samples(deviation, surface)


PARTS = 9
STARTS = (start_at_centroids, start_at_parts)


def six_volumes(positions, faces):
    return np.linalg.det(positions[faces])


class Tracked:
    """A deviation and a surface whose random edges are collapsed."""

    def __init__(self, start, stage):
        # samples are reassigned but not thinned
        faces = len(stage.faces)
        room = empty_deviation(sample_capacity(PARTS * faces, faces), faces)
        self.stage = stage._replace(deviation=room)
        self.deviation, self.surface = room, stage.surface
        start(room, stage.surface)


@pytest.fixture(scope="session")
def tracked(bumpy_mesh, stage_of):
    """Return a function from a sampling method, a seed and a number of points to a `Tracked`."""

    def make(start, seed, count=50):
        positions, faces = bumpy_mesh(seed, count)
        return Tracked(start, stage_of(FINEST, positions, faces))

    return make


@pytest.mark.parametrize("start", STARTS)
@settings(max_examples=6)
@given(seed=st.integers(0, 10**6))
@pytest.mark.slow
def test_samples_follow_random_collapses(
    tracked, random_collapses, faces_left, assert_in_their_faces, start, seed
):
    case = tracked(start, seed)
    deviation, surface = case.deviation, case.surface
    _numbers, faces = faces_left(surface)
    whole = six_volumes(surface.position, faces).sum()
    count = int(deviation.counts[SAMPLES])
    assert count == len(faces) if start is start_at_centroids else count > 2 * len(faces)
    for _ in random_collapses(case.stage, seed, 25):
        samples = assert_in_their_faces(deviation, surface)
        assert len(samples) == count
        # weights are shares of the volume of the reference
        assert deviation.weight[samples].sum() == pytest.approx(whole, rel=1e-12)
    assert len(faces_left(surface)[1]) < len(faces)
    assert deviation.error.sum() > 0


@pytest.mark.parametrize("start", STARTS)
def test_a_surface_does_not_deviate_from_itself(tracked, faces_left, assert_in_their_faces, start):
    case = tracked(start, 3)
    samples = assert_in_their_faces(case.deviation, case.surface)
    whole = six_volumes(case.surface.position, faces_left(case.surface)[1]).sum()
    assert case.deviation.weight[samples].sum() == pytest.approx(whole, rel=1e-12)
    assert case.deviation.error.sum() <= 1e-12 * whole


@pytest.mark.parametrize("start", STARTS)
def test_samples_follow_moves(tracked, assert_in_their_faces, start):
    case = tracked(start, 6)
    random = np.random.default_rng(0)
    for vertex in range(0, len(case.surface.position), 3):
        case.surface.position[vertex] *= random.uniform(0.9, 1.1)
        reassign_samples(case.deviation, case.surface, vertex, NO_FACE, NO_FACE)
        assert_in_their_faces(case.deviation, case.surface)
    assert case.deviation.error.sum() > 0


@pytest.mark.parametrize("start", STARTS)
@settings(max_examples=10)
@given(seed=st.integers(0, 10**6), part=st.floats(0.02, 1))
def test_thinned_samples_have_equal_shares(
    tracked,
    random_collapses,
    faces_left,
    samples_in,
    points_of,
    assert_in_their_faces,
    start,
    seed,
    part,
):
    case = tracked(start, seed, 100)
    deviation, surface = case.deviation, case.surface
    for _ in random_collapses(case.stage, 1, 60):
        pass
    count = int(deviation.counts[SAMPLES])
    before = assert_in_their_faces(deviation, surface)
    # by their points, because samples change their indices
    weights = dict(
        zip(map(tuple, points_of(deviation, before)), deviation.weight[before], strict=True)
    )
    whole = deviation.weight[before].sum()
    numbers, _ = faces_left(surface)
    in_faces = [deviation.weight[samples_in(deviation, int(face))].sum() for face in numbers]
    assert thin_samples(deviation, surface, count) is False
    np.testing.assert_array_equal(assert_in_their_faces(deviation, surface), before)
    most = max(2, int(part * (count - 1)))
    assert thin_samples(deviation, surface, most) is True
    after = assert_in_their_faces(deviation, surface)
    assert 0 < len(after) == int(deviation.counts[SAMPLES]) <= most // 2
    share = whole / (most // 2)
    marks = deviation.weight[after] / share
    np.testing.assert_allclose(marks, np.rint(marks), rtol=1e-9)
    # one mark, or as many as its weight contains
    worth = np.array([weights[tuple(point)] for point in points_of(deviation, after)]) / share
    assert (np.abs(marks - worth) < 1 + 1e-9).all()
    # no weight is lost, and no face gains or loses more than a share
    assert deviation.weight[after].sum() == pytest.approx(whole, rel=1e-9)
    now = [deviation.weight[samples_in(deviation, int(face))].sum() for face in numbers]
    assert np.abs(np.subtract(now, in_faces)).max() <= share * (1 + 1e-9)


@settings(max_examples=10)
@given(seed=st.integers(0, 10**6))
def test_samples_taken_earlier_are_found_at_any_level(
    tracked, random_collapses, assert_in_their_faces, seed
):
    case = tracked(start_at_centroids, seed, 100)
    loose = empty_deviation(len(case.deviation.pair), len(case.deviation.begin))
    take_samples(loose, case.surface, 500)
    whole = loose.weight[: loose.counts[SAMPLES]].sum()
    for _ in random_collapses(case.stage, seed, 60):
        pass
    assign_samples(loose, case.surface)
    samples = assert_in_their_faces(loose, case.surface)
    assert loose.weight[samples].sum() == pytest.approx(whole, rel=1e-12)


@pytest.mark.slow
def test_samples_are_assigned_where_walks_cycle(surface_from, faces_left, assert_in_their_faces):
    """A fan of slivers around an axis, where walks from some faces cycle."""
    random = np.random.default_rng(5)
    for sides in (5, 30, 400):
        turn = np.linspace(0, 2 * np.pi, sides, endpoint=False)
        rim = np.stack([np.cos(turn), np.sin(turn), random.uniform(-3, 3, sides)], axis=1)
        rim /= np.linalg.norm(rim, axis=1)[:, np.newaxis]
        positions = np.vstack([rim, [[0, 0, 9], [0, 0, -9]]])
        after = (np.arange(sides) + 1) % sides
        above = np.stack([np.arange(sides), after, np.full(sides, sides)], axis=1)
        below = np.stack([after, np.arange(sides), np.full(sides, sides + 1)], axis=1)
        surface = surface_from(positions, np.vstack([above, below]))
        assert np.linalg.det(positions[faces_left(surface)[1]]).min() > 0
        deviation = empty_deviation(sample_capacity(3000, 2 * sides), 2 * sides)
        take_samples(deviation, surface, 3000)
        count = int(deviation.counts[SAMPLES])
        order = random.permutation(count)
        for array in (deviation.x, deviation.y, deviation.z, deviation.weight):
            array[:count] = array[order]
        assign_samples(deviation, surface)
        assert len(assert_in_their_faces(deviation, surface)) == count


def test_reassignment_has_no_limit_of_degree(surface_from, assert_in_their_faces):
    """A vertex may have more faces than the longest link that is evaluated."""
    sides = LARGEST_LINK + 50
    turn = np.linspace(0, 2 * np.pi, sides, endpoint=False)
    rim = np.stack([np.cos(turn), np.sin(turn), np.zeros(sides)], axis=1)
    positions = np.vstack([rim, [[0, 0, 1], [0, 0, -1]]])
    after = (np.arange(sides) + 1) % sides
    above = np.stack([np.arange(sides), after, np.full(sides, sides)], axis=1)
    below = np.stack([after, np.arange(sides), np.full(sides, sides + 1)], axis=1)
    surface = surface_from(positions, np.vstack([above, below]))
    deviation = empty_deviation(3 * len(positions), 2 * sides)
    take_samples(deviation, surface, 1)
    assign_samples(deviation, surface)
    surface.position[sides] = (0.2, 0.1, 0.8)
    reassign_samples(deviation, surface, sides, NO_FACE, NO_FACE)
    assert_in_their_faces(deviation, surface)
    assert deviation.error.sum() > 0


@pytest.mark.parametrize("start", STARTS)
def test_the_sum_of_the_errors_is_the_mismatch(
    start, icosphere, random_collapses, faces_left, stage_of
):
    """Compared with exact boolean operations, on a sphere of 2562 vertices decimated to 300."""
    mesh = icosphere(4)
    positions = mesh.vertices.astype(np.float64)
    case = Tracked(start, stage_of(FINEST, positions, mesh.faces))
    wanted = len(positions) - 300
    rounds = 0
    while wanted > 0 and rounds < 20:
        done = sum(1 for _ in random_collapses(case.stage, rounds, wanted))
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
