"""Moves after a collapse: which vertices move, validity, and the record."""

import numpy as np
import pytest

from gamutcore.decimation.costs import cost_named
from gamutcore.decimation.costs.parameters import SAMPLES_OF_REFERENCE_FACE
from gamutcore.decimation.costs.sample_assignment import assign_samples
from gamutcore.decimation.costs.samples import take_samples
from gamutcore.decimation.record import empty_record, extend_record
from gamutcore.decimation.relaxation import relax
from gamutcore.decimation.stage import Grid

FINEST = cost_named("finest").parameters
VOLUME = cost_named("volume").parameters

CENTRE = np.array([50.0, 0.0, 0.0])
STEP = 2.0**-11


@pytest.fixture(scope="module")
def after_collapses(bumpy_mesh, random_collapses, workspace_for, faces_left, stage_of):
    """Return a function that relaxes around vertices after collapses, and calls a check each time.

    Positions are on the grid at first. The collapses of the tests leave it.
    """

    def run(parameters, seed, check):
        positions, faces = bumpy_mesh(seed, 120)
        stage = stage_of(parameters, positions, faces)
        surface = stage.surface
        if parameters is FINEST:
            take_samples(stage.deviation, surface, SAMPLES_OF_REFERENCE_FACE * len(faces))
            assign_samples(stage.deviation, surface)
        work = workspace_for(surface)
        record, start = extend_record(empty_record(len(positions)), 0, 5000), 0
        for done, kept in enumerate(random_collapses(stage, seed, 60)):
            delivered = (surface.position + CENTRE).astype(np.float32)
            before = delivered.copy()
            record.position[done, 2] = delivered[kept]
            errors = stage.deviation.error.sum()
            record.shifted_end[done] = start
            work.collapses[0] = done + 1
            relax(stage._replace(grid=Grid(delivered, CENTRE, STEP)), record, work, kept)
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
                stage.deviation.error.sum() - errors,
                work,
                done + 1,
            )
            start = end
        return start

    return run


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.slow
def test_the_new_vertex_and_its_neighbours_move_to_less_deviation(after_collapses, seed):
    gained = []

    def check(
        surface, kept, faces, before, delivered, place, shifted, shift, change, work, collapses
    ):
        ring = set(faces[(faces == kept).any(axis=1)].ravel().tolist()) - {kept}
        moved = set(np.flatnonzero((before != delivered).any(axis=1)).tolist())
        assert moved <= ring | {kept}
        # each neighbour that moved is recorded once, with both positions
        assert sorted(shifted.tolist()) == sorted(moved - {kept})
        np.testing.assert_array_equal(shift[:, 0], before[shifted])
        np.testing.assert_array_equal(shift[:, 1], delivered[shifted])
        np.testing.assert_array_equal(place, delivered[kept])
        # positions lie on the grid, and both copies agree
        vertices = sorted(moved)
        np.testing.assert_array_equal(delivered[vertices] % STEP, 0.0)
        np.testing.assert_array_equal(surface.position[vertices] + CENTRE, delivered[vertices])
        assert np.linalg.det(surface.position[faces]).min() > 0
        gained.append(change)
        for vertex in moved - {kept}:
            assert work.changed[vertex] == collapses

    assert after_collapses(FINEST, seed, check) > 60
    # a move saves deviation before rounding, and the grid is fine
    assert max(gained) <= 0.0
    assert np.count_nonzero(gained) > 30


def test_without_improvements_nothing_moves(after_collapses):
    def check(surface, kept, faces, before, delivered, place, *_):
        np.testing.assert_array_equal(delivered, before)
        np.testing.assert_array_equal(place, before[kept])
        assert (faces >= 0).all()
        assert len(surface.position) == len(before)

    assert after_collapses(VOLUME, 1, check) == 0
