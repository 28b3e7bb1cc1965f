"""Sweeps of fine levels: validity, and accuracy of the coarse levels."""

import numpy as np
import pytest

from gamutcore.decimation import decimate
from gamutcore.decimation.costs import cost_named
from gamutcore.decimation.costs.parameters import SWEPT_DOWN_TO
from gamutcore.decimation.record import empty_record, extend_record
from gamutcore.decimation.stage import Grid
from gamutcore.decimation.star import LARGEST_LINK
from gamutcore.decimation.sweeps import collapse_in_sweeps
from gamutcore.history import build_history
from gamutcore.metric import mismatch

VOLUME = cost_named("volume").parameters

CENTRE = (50.0, 0.0, 0.0)


@pytest.fixture(scope="module")
def large(icosphere):
    """Return a sphere of 40,962 vertices. Most of its collapses are made in sweeps."""
    mesh = icosphere(6, 40.0, CENTRE)
    assert len(mesh.vertices) == 40_962 > SWEPT_DOWN_TO + 20_000
    return mesh


@pytest.fixture(scope="module")
def run(large):
    """Return its decimation."""
    return decimate(large, CENTRE)


class TestLargeBoundary:
    @pytest.mark.slow
    def test_levels_are_gamuts_of_the_same_volume(self, large, run, assert_every_invariant):
        history = build_history(run)
        full = history.full()
        swept = [2 * SWEPT_DOWN_TO - 4 + more for more in (-2, 0, 2, 2000, 20_000, 38_000)]
        for triangles in [4, 100, 1000, 10_000, *swept, large.triangles]:
            level = history.level(triangles)
            assert_every_invariant(level, CENTRE, triangles)
            assert level.volume == pytest.approx(full.volume, rel=1e-5)

    def test_every_collapse_in_a_sweep_is_recorded(self, run):
        swept = len(run.positions) - SWEPT_DOWN_TO
        assert len(set(run.record.dead.tolist())) == len(run.record.dead)
        assert (run.record.shifted_end[:swept] == 0).all()
        assert (np.diff(run.record.moved_end[:swept]) > 0).all()

    @pytest.mark.parametrize("triangles", [500, 1000])
    @pytest.mark.slow
    def test_coarse_levels_are_as_good_as_of_smaller_spheres(self, large, run, triangles):
        """The bound for 10,000 vertices is 3.0 ÷ n. The limit for n → ∞ is 2.127 ÷ n."""
        assert triangles * mismatch(large, build_history(run).level(triangles)) <= 3.0

    def test_reruns_are_bit_identical(self, large, run):
        again = decimate(large, CENTRE)
        for one, other in zip(
            (*run.record, run.vertex, run.positions),
            (*again.record, again.vertex, again.positions),
            strict=True,
        ):
            assert one.tobytes() == other.tobytes()


@pytest.fixture(scope="module")
def swept(icosphere, stage_of, workspace_for):
    """Return a function that makes collapses in sweeps on a sphere of 2562 vertices."""

    def make(wanted, room=None):
        mesh = icosphere(4, 40.0, CENTRE)
        positions = mesh.vertices.astype(np.float64) - CENTRE
        grid = Grid(mesh.vertices.copy(), np.array(CENTRE), 2.0**-11)
        stage = stage_of(VOLUME, positions, mesh.faces, grid)
        record, work, calls = empty_record(len(positions)), workspace_for(stage.surface), 1
        work.queue.heap_index[:] = -1
        work.queue.size[0] = 0
        if room is not None:
            record = record._replace(moved=record.moved[:room])
        while not collapse_in_sweeps(stage, record, work, wanted):
            record, calls = extend_record(record, int(work.collapses[0]), LARGEST_LINK), calls + 1
        assert (work.queue.heap_index == -1).all()
        assert (calls > 1) == (room is not None)
        return int(work.collapses[0]), stage.surface, record

    return make


@pytest.mark.parametrize("wanted", [1, 10, 300])
def test_the_wanted_number_of_collapses_is_made(swept, faces_left, wanted):
    collapses, surface, record = swept(wanted)
    assert collapses == wanted
    _, faces = faces_left(surface)
    assert len(faces) == 2 * (2562 - wanted) - 4
    assert len(np.unique(faces)) == 2562 - wanted
    assert np.linalg.det(surface.position[faces]).min() > 0
    assert record.moved_end[wanted - 1] <= len(record.moved)


def test_sweeps_continue_after_the_record_was_full(swept):
    """No collapse is lost or recorded twice."""
    collapses, surface, record = swept(500, room=200)
    assert collapses == 500
    assert len(set(record.dead[:500].tolist())) == 500
    assert 200 < record.moved_end[499] <= len(record.moved)
    assert (surface.corner_facing >= 0).sum() == 3 * (2562 - 500 - 2)
