"""Stages: compaction keeps the surface, and joined records are the same decimation."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gamutcore.corner_table import opposite_corners
from gamutcore.decimation import Decimation
from gamutcore.decimation.costs import cost_named
from gamutcore.decimation.costs.dispatch import enter_level
from gamutcore.decimation.stage import Grid, compact_stage, copy_stage
from gamutcore.decimation.stages import join_records, run_stage
from gamutcore.decimation.star import DEFICIT_LARGEST, DEFICIT_NOW
from gamutcore.decimation.trials import perturbation
from gamutcore.grid import grid_step, nearest_grid_points
from gamutcore.history import build_history

QUADRIC, VOLUME = (cost_named(name).parameters for name in ("quadric", "volume"))


@pytest.fixture(scope="session")
def first_stage(bumpy_mesh, stage_of):
    """Return a function from a seed and a cost's parameters to the stage of a full boundary."""

    def make(seed, parameters, count=80):
        rough, faces = bumpy_mesh(seed, count)
        step = grid_step(rough)
        positions = nearest_grid_points(rough, step)
        grid = Grid(positions.astype(np.float32), np.zeros(3), step)
        return stage_of(parameters, positions, faces, grid)

    return make


def in_stages(stage, stops):
    """Decimate in stages and return the joined decimation."""
    counter, results = np.zeros(1, np.int64), []
    size, step = stage.size, stage.grid.step
    for until in (*(stop for stop in stops if stop < size), 4):
        if results:
            stage = compact_stage(stage)
        results.append(run_stage(stage, until, counter))
        assert results[-1].left == until == size - counter[0]
    record, vertex, positions = join_records(results)
    return Decimation(record, vertex, positions, np.zeros(3), step, None)


def rows(level):
    return sorted(map(tuple, level.vertices.tolist()))


@settings(max_examples=15)
@given(seed=st.integers(0, 10**6), stops=st.lists(st.integers(5, 60), max_size=4, unique=True))
def test_a_decimation_in_stages_is_the_same_as_in_one(first_stage, seed, stops):
    """`quadric` stores its state in vertices only, so nothing is lost between stages."""
    whole = build_history(in_stages(first_stage(seed, QUADRIC), []))
    stages = build_history(in_stages(first_stage(seed, QUADRIC), sorted(stops)[::-1]))
    for one, other in zip(whole.levels(), stages.levels(), strict=True):
        assert one.triangles == other.triangles
        assert rows(one) == rows(other)
        assert one.volume == pytest.approx(other.volume, rel=1e-12)


@pytest.mark.parametrize("seed", range(3))
def test_compaction_keeps_the_surface(first_stage, faces_left, seed):
    stage = first_stage(seed, VOLUME)
    size = len(stage.grid.position)
    run_stage(stage, size // 2, np.zeros(1, np.int64))
    deficit, error = stage.surface.deficit.copy(), stage.deviation.error.sum()
    assert deficit[DEFICIT_LARGEST] >= abs(deficit[DEFICIT_NOW]) > 0
    numbers, faces = faces_left(stage.surface)
    small = compact_stage(stage)
    assert len(small.vertices) == size // 2 == len(small.surface.position)
    np.testing.assert_array_equal(small.faces, numbers)
    np.testing.assert_array_equal(small.vertices[small.surface.vertex.reshape(-1, 3)], faces)
    np.testing.assert_array_equal(small.surface.position, stage.surface.position[small.vertices])
    np.testing.assert_array_equal(small.grid.position, stage.grid.position[small.vertices])
    opposite = opposite_corners(small.surface.vertex.reshape(-1, 3), size // 2)
    np.testing.assert_array_equal(small.surface.opposite, opposite)
    np.testing.assert_array_equal(small.surface.deficit, deficit)
    # samples are assigned again when the next stage begins
    enter_level(small, size // 2)
    assert small.deviation.error.sum() == pytest.approx(error, rel=1e-12)
    assert (small.grid.centre == stage.grid.centre).all()
    assert small.grid.step == stage.grid.step


def test_a_copy_does_not_change_the_stage(first_stage):
    stage = first_stage(1, VOLUME)
    size = len(stage.grid.position)
    before = [array.copy() for array in (*stage.surface, stage.grid.position)]
    other = copy_stage(stage)
    result = run_stage(other, size // 2, np.zeros(1, np.int64))
    assert result.left == size // 2
    for array, expected in zip((*stage.surface, stage.grid.position), before, strict=True):
        np.testing.assert_array_equal(array, expected)
    # the stage itself can be decimated to the same result
    again = run_stage(stage, size // 2, np.zeros(1, np.int64))
    for one, two in zip(result.record, again.record, strict=True):
        assert one.tobytes() == two.tobytes()


def test_perturbed_stages_differ_and_are_reproducible(first_stage):
    stage, made = first_stage(4, VOLUME), []
    for trial in (0, 1, 2, 1):
        perturbed = perturbation(stage.surface.corner_facing.size, trial)
        result = run_stage(copy_stage(stage), 20, np.zeros(1, np.int64), perturbation=perturbed)
        assert result.left == 20
        made.append(result.record.dead.tobytes())
    assert len(set(made)) == 3
    assert made[1] == made[3]
