"""Moves after a collapse: who moves, that levels stay valid, and that it is written down."""

import numpy as np
import pytest

from gamutcore.decimation.costs import finest, volume
from gamutcore.decimation.record import empty_record, with_room
from gamutcore.decimation.relaxation import relax
from gamutcore.decimation.costs.samples import take_samples

CENTRE = np.array([50.0, 0.0, 0.0])
STEP = 2.0**-11


@pytest.fixture(scope="module")
def after_collapses(bumpy_mesh, surface_from, random_collapses, workspace_for, faces_left):
    """Return a function that relaxes around vertices after collapses, and calls a check each time.

    Positions are on the grid from the start; the collapses of the tests leave it.
    """

    def run(module, seed, check):
        positions, faces = bumpy_mesh(seed, 120)
        surface = surface_from(positions, faces)
        state = module.state(positions, faces)
        if module is finest:
            take_samples(state.deviation, surface, finest.SAMPLES_OF_FACE * len(faces), True)
        work, ring = workspace_for(surface), np.empty((200, 2), np.int32)
        record, start = with_room(empty_record(len(positions)), 0, 5000), 0
        for done, kept in enumerate(random_collapses(state, surface, seed, 60)):
            delivered = (surface.position + CENTRE).astype(np.float32)
            before = delivered.copy()
            record.position[done, 2] = delivered[kept]
            errors = state.deviation.error.sum()
            record.shifted_end[done] = start
            relax(state, surface, delivered, CENTRE, STEP, record, work, kept, done + 1, ring)
            end = int(record.shifted_end[done])
            faces_now = faces_left(surface)[1]
            check(
                surface,
                kept,
                faces_now,
                before,
                delivered,
                record.position[done, 2],
                record.shifted[start:end],
                record.shift[start:end],
                state.deviation.error.sum() - errors,
                work,
                done + 1,
            )
            start = end
        return start

    return run


@pytest.mark.parametrize("seed", range(3))
def test_the_new_vertex_and_its_neighbours_move_to_less_deviation(after_collapses, seed):
    gained = []

    def check(
        surface, kept, faces, before, delivered, place, shifted, shift, change, work, collapses
    ):
        ring = set(faces[(faces == kept).any(axis=1)].ravel().tolist()) - {kept}
        moved = set(np.flatnonzero((before != delivered).any(axis=1)).tolist())
        assert moved <= ring | {kept}
        # neighbours that are elsewhere now are written down, each once, from where to where
        assert sorted(shifted.tolist()) == sorted(moved - {kept})
        np.testing.assert_array_equal(shift[:, 0], before[shifted])
        np.testing.assert_array_equal(shift[:, 1], delivered[shifted])
        np.testing.assert_array_equal(place, delivered[kept])
        # on the grid, and the surface is where it says that it is
        vertices = sorted(moved)
        np.testing.assert_array_equal(delivered[vertices] % STEP, 0.0)
        np.testing.assert_array_equal(surface.position[vertices] + CENTRE, delivered[vertices])
        assert np.linalg.det(surface.position[faces]).min() > 0
        gained.append(change)
        for vertex in moved - {kept}:
            assert work.changed[vertex] == collapses

    assert after_collapses(finest, seed, check) > 60
    # each move has to save a part of the deviation before it is rounded to the grid, which is fine
    assert max(gained) <= 0.0
    assert np.count_nonzero(gained) > 30


def test_a_cost_that_proposes_nothing_moves_nothing(after_collapses):
    def check(surface, kept, faces, before, delivered, place, *_):
        np.testing.assert_array_equal(delivered, before)
        np.testing.assert_array_equal(place, before[kept])
        assert (faces >= 0).all()
        assert len(surface.position) == len(before)

    assert after_collapses(volume, 1, check) == 0


def test_a_ring_that_is_too_large_for_the_scratch_is_left_alone(
    bumpy_mesh, surface_from, workspace_for
):
    positions, faces = bumpy_mesh(4, 60)
    surface, state = surface_from(positions * 1.1, faces), finest.state(positions, faces)
    take_samples(
        state.deviation, surface_from(positions, faces), finest.SAMPLES_OF_FACE * len(faces), True
    )
    delivered = (surface.position + CENTRE).astype(np.float32)
    before = delivered.copy()
    kept, record = int(surface.degree.argmax()), empty_record(len(positions))
    record.shifted_end[0] = 0
    record.position[0, 2] = delivered[kept]
    ring = np.empty((int(surface.degree[kept]) - 1, 2), np.int32)
    work = workspace_for(surface)
    relax(state, surface, delivered, CENTRE, STEP, record, work, kept, 1, ring)
    assert record.shifted_end[0] == 0
    np.testing.assert_array_equal(delivered, before)
    np.testing.assert_array_equal(record.position[0, 2], before[kept])
