"""Samples of a reference and the deviation from it, by sums over all samples and exact volumes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.booleans import mismatch
from gamutcore.decimation.costs import cost_named
from gamutcore.decimation.deviation import (
    change_at,
    mismatch_error,
    query_edge,
    query_vertex,
    refine_point,
)
from gamutcore.decimation.deviation_samples import (
    LARGEST_SHARE,
    NO_FACE,
    SAMPLES,
    assign_samples,
    empty_deviation,
    reassign_samples,
    sample_capacity,
    take_samples,
    thin_samples,
)
from gamutcore.decimation.quadrics import constrained_optimum
from gamutcore.decimation.surface_mesh import (
    keeps_star_shape,
    link_condition_holds,
    star_volume,
    volume_gradient,
    write_edge_link,
    write_vertex_link,
)
from gamutcore.geometry import TriangleMesh

pytestmark = pytest.mark.slow  # it compiles kernels that only tests use

FINEST = cost_named("finest").parameters
SEEDS = st.integers(0, 10**6)
PARTS = (1, 9)
"""Samples of each face: the centroid alone, or several parts."""


def six_volumes(positions, faces):
    return np.linalg.det(positions[faces])


def sampled(surface, wanted, room=None):
    """Return a deviation with about so many samples, assigned to the faces of a surface."""
    faces = len(surface.vertex) // 3
    room = room or sample_capacity(max(wanted, 9 * faces), faces)
    deviation = empty_deviation(room, faces)
    take_samples(deviation, surface, wanted)
    assign_samples(deviation, surface)
    return deviation


def lantern(sides, rows):
    """Two poles with rings of vertices between them. With several rings the caps are small."""
    turn = np.linspace(0, 2 * np.pi, sides, endpoint=False)
    rings = [
        np.stack([np.sin(polar) * np.cos(turn), np.sin(polar) * np.sin(turn), height], axis=1)
        for polar in np.linspace(0, np.pi, rows + 2)[1:-1]
        for height in [np.full(sides, np.cos(polar))]
    ]
    here = np.arange(sides)
    after = (here + 1) % sides
    faces = [
        np.stack([here, after, np.full(sides, rows * sides)], axis=1),
        np.stack([after, here, np.full(sides, rows * sides + 1)], axis=1),
    ]
    faces[1][:, :2] += (rows - 1) * sides
    for row in range(rows - 1):
        one, two = row * sides + here, row * sides + after
        faces += [
            np.stack([one, one + sides, two + sides], axis=1),
            np.stack([one, two + sides, two], axis=1),
        ]
    return np.vstack([*rings, [[0, 0, 1], [0, 0, -1]]]), np.vstack(faces)


class TestTaking:
    @settings(max_examples=20)
    @given(seed=SEEDS, wanted=st.integers(1, 3000))
    def test_no_sample_has_much_more_than_the_wanted_share(
        self, bumpy_mesh, surface_from, samples_in, seed, wanted
    ):
        """Each face has a sample. Faces of several shares have about as many samples."""
        positions, faces = bumpy_mesh(seed)
        room = sample_capacity(wanted, len(faces))
        deviation = sampled(surface_from(positions, faces), wanted, room)
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
        assert deviation.counts[SAMPLES] <= room

    def test_sums_over_samples_integrate_linear_functions(
        self, bumpy_mesh, surface_from, points_of
    ):
        """Exactly, over the solid, for functions that are linear in the radius (Gauss' rule)."""
        positions, faces = bumpy_mesh(5)
        deviation = sampled(surface_from(positions, faces), 1)
        assert deviation.counts[SAMPLES] == len(faces)
        points = points_of(deviation, slice(len(faces)))
        volumes = six_volumes(positions, faces)
        for form in ([1, 0, 0], [0, 1, 1], [1, -2, 3]):
            exact = (volumes * (positions[faces] @ form).mean(axis=1)).sum()
            summed = deviation.weight[: len(faces)] @ (points @ form)
            assert summed == pytest.approx(exact, rel=1e-10, abs=1e-10 * volumes.sum())


@pytest.fixture(scope="module")
def tracked(bumpy_mesh, state_of):
    """Return a function from a number of parts and a seed to a state whose faces have samples."""

    def make(parts, seed, count=50):
        state = state_of(FINEST, *bumpy_mesh(seed, count))
        wanted = 1 if parts == 1 else parts * len(state.faces)
        return state._replace(deviation=sampled(state.surface, wanted))

    return make


class TestAssignment:
    @pytest.mark.parametrize("parts", PARTS)
    @settings(max_examples=6)
    @given(seed=SEEDS)
    @pytest.mark.slow
    def test_samples_follow_random_collapses_and_moves(
        self, tracked, random_collapses, faces_left, assert_in_their_faces, parts, seed
    ):
        state = tracked(parts, seed)
        deviation, surface = state.deviation, state.surface
        _, faces = faces_left(surface)
        whole = six_volumes(surface.position, faces).sum()
        count = int(deviation.counts[SAMPLES])
        assert count == len(faces) if parts == 1 else count > 2 * len(faces)
        assert_in_their_faces(deviation, surface)
        assert deviation.error.sum() <= 1e-12 * whole
        for kept in random_collapses(state, seed, 25):
            samples = assert_in_their_faces(deviation, surface)
            assert len(samples) == count
            # weights are shares of the volume of the reference
            assert deviation.weight[samples].sum() == pytest.approx(whole, rel=1e-12)
            before = surface.position[kept].copy()
            surface.position[kept] *= 0.98
            if six_volumes(surface.position, faces_left(surface)[1]).min() > 0:
                reassign_samples(deviation, surface, kept, NO_FACE, NO_FACE)
                assert_in_their_faces(deviation, surface)
            else:
                surface.position[kept] = before
        assert len(faces_left(surface)[1]) < len(faces)
        assert deviation.error.sum() > 0

    @pytest.mark.parametrize("parts", PARTS)
    @settings(max_examples=10)
    @given(seed=SEEDS, part=st.floats(0.02, 1))
    def test_thinned_samples_have_equal_shares(
        self, tracked, random_collapses, faces_left, samples_in, points_of, assert_in_their_faces,
        parts, seed, part,
    ):  # fmt: skip
        state = tracked(parts, seed, 100)
        deviation, surface = state.deviation, state.surface
        for _ in random_collapses(state, 1, 60):
            pass
        count = int(deviation.counts[SAMPLES])
        before = assert_in_their_faces(deviation, surface)
        # by their points, because samples change their indices
        points = map(tuple, points_of(deviation, before))
        weights = dict(zip(points, deviation.weight[before], strict=True))
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

    @pytest.mark.parametrize("sides", [5, 30, 400])
    @pytest.mark.slow
    def test_samples_are_assigned_where_walks_cycle(
        self, surface_from, faces_left, assert_in_their_faces, sides
    ):
        """A fan of slivers around an axis, where walks from some faces cycle."""
        random = np.random.default_rng(sides)
        positions, faces = lantern(sides, 1)
        positions[:sides, 2] = random.uniform(-3, 3, sides)
        positions[:sides] /= np.linalg.norm(positions[:sides], axis=1)[:, np.newaxis]
        positions[sides:] *= 9
        surface = surface_from(positions, faces)
        assert np.linalg.det(positions[faces_left(surface)[1]]).min() > 0
        deviation = empty_deviation(sample_capacity(3000, 2 * sides), 2 * sides)
        take_samples(deviation, surface, 3000)
        count = int(deviation.counts[SAMPLES])
        order = random.permutation(count)
        for array in (deviation.x, deviation.y, deviation.z, deviation.weight):
            array[:count] = array[order]
        assign_samples(deviation, surface)
        assert len(assert_in_their_faces(deviation, surface)) == count

    @pytest.mark.parametrize("parts", PARTS)
    def test_the_sum_of_the_errors_is_the_mismatch(
        self, parts, icosphere, random_collapses, faces_left, state_of
    ):
        """Compared with exact boolean operations, on a sphere of 2562 vertices decimated to 300."""
        mesh = icosphere(4)
        positions = mesh.vertices.astype(np.float64)
        state = state_of(FINEST, positions, mesh.faces)
        wanted = 1 if parts == 1 else parts * mesh.triangles
        state = state._replace(deviation=sampled(state.surface, wanted))
        left, rounds = len(positions) - 300, 0
        while left > 0 and rounds < 20:
            done = sum(1 for _ in random_collapses(state, rounds, left))
            left, rounds = left - done, rounds + 1
        _, faces = faces_left(state.surface)
        assert len(faces) <= 2 * 320
        kept, renamed = np.unique(faces, return_inverse=True)
        level = TriangleMesh(
            state.surface.position[kept].astype(np.float32), renamed.reshape(-1, 3).astype(np.int32)
        )
        exact = mismatch(mesh, level)
        assert exact > 0.02
        summed = state.deviation.error.sum() / 6 / mesh.volume
        assert summed == pytest.approx(exact, rel=0.05)


def change_by_collapse(deviation, surface, corner, place):
    """Infinite for long and dense links."""
    asked = query_edge(deviation, surface, corner)
    return change_at(deviation, surface, place) if asked else np.inf


def change_by_move(deviation, surface, vertex, place):
    asked = query_vertex(deviation, surface, vertex)
    return change_at(deviation, surface, place) if asked else np.inf


@pytest.fixture(scope="module")
def total(by_hand, all_samples, points_of):
    """Return a function that computes the deviation over all samples for positions and faces."""

    def summed(deviation, positions, faces):
        used = all_samples(deviation)
        weights = deviation.weight[used]
        _, shares = by_hand(positions, faces, points_of(deviation, used), weights)
        return np.minimum(shares, LARGEST_SHARE * weights).sum()

    return summed


class TestChanges:
    @settings(max_examples=10)
    @given(seed=SEEDS)
    @pytest.mark.slow
    def test_the_change_by_a_collapse_is_that_of_the_sum(
        self, tracked, random_collapses, total, faces_left, ends_of, seed
    ):
        state = tracked(1, seed)
        deviation, surface = state.deviation, state.surface
        for _ in random_collapses(state, seed, 15):
            pass
        _, faces = faces_left(surface)
        before = total(deviation, surface.position, faces)
        ring, random, compared = np.empty((200, 2), np.int32), np.random.default_rng(seed), 0
        for corner in surface.corner_facing[surface.corner_facing >= 0].tolist():
            one, two = ends_of(surface, corner)
            place = surface.position[[one, two]].mean(axis=0) * random.uniform(0.9, 1.1)
            count = write_edge_link(surface, one, two, ring)
            if not link_condition_holds(surface, one, two) or not keeps_star_shape(
                surface.position, ring, count, *place
            ):
                continue
            merged = np.where(faces == two, one, faces)
            merged = merged[[len(set(face)) == 3 for face in merged.tolist()]]
            positions = surface.position.copy()
            positions[one] = place
            expected = total(deviation, positions, merged) - before
            for at in (corner, int(surface.opposite[corner])):
                change = change_by_collapse(deviation, surface, at, place)
                assert change == pytest.approx(expected, rel=1e-7, abs=1e-9 * before)
            compared += 1
        assert compared > 10

    @settings(max_examples=10)
    @given(seed=SEEDS)
    @pytest.mark.slow
    def test_the_change_by_a_move_is_that_of_the_sum(
        self, tracked, random_collapses, total, faces_left, seed
    ):
        state = tracked(1, seed)
        deviation, surface = state.deviation, state.surface
        for _ in random_collapses(state, seed, 15):
            pass
        _, faces = faces_left(surface)
        before = total(deviation, surface.position, faces)
        ring, random, compared = np.empty((200, 2), np.int32), np.random.default_rng(seed), 0
        for vertex in np.unique(faces).tolist():
            place = surface.position[vertex] * random.uniform(0.9, 1.1, 3)
            count = write_vertex_link(surface, vertex, ring)
            if not keeps_star_shape(surface.position, ring, count, *place):
                continue
            positions = surface.position.copy()
            positions[vertex] = place
            change = change_by_move(deviation, surface, vertex, place)
            expected = total(deviation, positions, faces) - before
            assert change == pytest.approx(expected, rel=1e-7, abs=1e-9 * before)
            compared += 1
        assert compared > 5

    @pytest.mark.parametrize("keeps_volume", [False, True])
    def test_refined_positions_deviate_less_and_may_keep_the_volume(
        self, bumpy_mesh, state_of, ends_of, keeps_volume
    ):
        state = state_of(FINEST, *bumpy_mesh(3, 150))
        surface, deviation = state.surface, sampled(state.surface, 8000)
        least = 1e-6 * deviation.weight[: deviation.counts[SAMPLES]].sum()
        place, trial, ring = np.empty(3), np.empty(3), np.empty((200, 2), np.int32)
        moved = 0
        for corner in surface.corner_facing.tolist():
            constrained_optimum(state.quadrics, surface, corner, place)
            start = place.copy()
            before = mismatch_error(deviation, surface, corner, start)
            found = refine_point(
                deviation, state.quadrics, surface, corner, place, trial, keeps_volume
            )
            assert found <= before
            # the length penalty is negligible
            after = mismatch_error(deviation, surface, corner, place)
            assert found == pytest.approx(after, abs=least)
            if keeps_volume:
                one, two = ends_of(surface, corner)
                count = write_edge_link(surface, one, two, ring)
                slope = np.array(volume_gradient(surface.position, ring, count))
                assert slope @ place == pytest.approx(star_volume(surface, one, two), rel=1e-9)
            moved += bool((place != start).any())
        assert moved > len(surface.corner_facing) / 4
