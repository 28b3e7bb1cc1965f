"""Stages: compacted surfaces are the same surfaces, and joined records the same decimations."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gamutcore.corner_table import opposite_corners
from gamutcore.decimation import Decimation
from gamutcore.decimation.costs import quadric, volume
from gamutcore.decimation.plan import Plan
from gamutcore.decimation.record import empty_record
from gamutcore.decimation.stages import Stage, carried_out, compacted, copied, joined
from gamutcore.decimation.star import surface_of
from gamutcore.grid import grid_step, nearest_grid_points
from gamutcore.history import build_history

QUADRIC = Plan(state_on=lambda state, vertices, _: state._replace(quadric=state.quadric[vertices]))


@pytest.fixture(scope="session")
def first_stage(bumpy_mesh):
    """Return a function from a seed and a cost's module to the stage of a full boundary."""

    def make(seed, module, count=80):
        rough, faces = bumpy_mesh(seed, count)
        step = grid_step(rough)
        positions = nearest_grid_points(rough, step)
        faces = np.ascontiguousarray(faces, np.int32)
        return Stage(
            module.state(positions, faces),
            surface_of(positions, faces, opposite_corners(faces, len(positions))),
            positions.astype(np.float32),
            np.zeros(3),
            step,
            np.arange(len(positions), dtype=np.int32),
            np.arange(len(faces), dtype=np.int32),
        )

    return make


def in_stages(stage, plan, stops):
    """Decimate from stop to stop, and return the whole."""
    done, passages = np.zeros(1, np.int64), []
    record = empty_record(len(stage.delivered))
    size, step = len(stage.delivered), stage.step
    for until in (*(stop for stop in stops if stop < size), 4):
        if passages:
            stage = compacted(stage, plan)
        room = empty_record(len(stage.delivered)) if passages else record
        passages.append(carried_out(stage, until, room, done))
        assert passages[-1].left == until == size - done[0]
    record, vertex, delivered = joined(record, passages)
    return Decimation(record, vertex, delivered, np.zeros(3), step, None)


def rows(level):
    return sorted(map(tuple, level.vertices.tolist()))


@settings(max_examples=15)
@given(seed=st.integers(0, 10**6), stops=st.lists(st.integers(5, 60), max_size=4, unique=True))
def test_a_decimation_in_stages_is_the_one_in_one(first_stage, seed, stops):
    """`quadric` remembers everything in its vertices, so nothing is lost between two stages."""
    whole = build_history(in_stages(first_stage(seed, quadric), QUADRIC, []))
    stages = build_history(in_stages(first_stage(seed, quadric), QUADRIC, sorted(stops)[::-1]))
    for one, other in zip(whole.levels(), stages.levels(), strict=True):
        assert one.triangles == other.triangles
        assert rows(one) == rows(other)
        assert one.volume == pytest.approx(other.volume, rel=1e-12)


@pytest.mark.parametrize("seed", range(3))
def test_a_compacted_surface_is_what_was_left(first_stage, faces_left, seed):
    stage = first_stage(seed, volume)
    size = len(stage.delivered)
    carried_out(stage, size // 2, empty_record(size), np.zeros(1, np.int64))
    deficit, error = stage.surface.deficit.copy(), stage.state.deviation.error.sum()
    assert deficit[1] >= abs(deficit[0]) > 0
    numbers, faces = faces_left(stage.surface)
    small = compacted(stage, volume.PLAN)
    assert len(small.vertices) == size // 2 == len(small.surface.position)
    np.testing.assert_array_equal(small.faces, numbers)
    np.testing.assert_array_equal(small.vertices[small.surface.vertex.reshape(-1, 3)], faces)
    np.testing.assert_array_equal(small.surface.position, stage.surface.position[small.vertices])
    np.testing.assert_array_equal(small.delivered, stage.delivered[small.vertices])
    opposite = opposite_corners(small.surface.vertex.reshape(-1, 3), size // 2)
    np.testing.assert_array_equal(small.surface.opposite, opposite)
    np.testing.assert_array_equal(small.surface.deficit, deficit)
    assert small.state.deviation.error.sum() == pytest.approx(error, rel=1e-12)
    assert (small.centre == stage.centre).all()
    assert small.step == stage.step


def test_a_copy_leaves_the_stage_alone(first_stage):
    stage = first_stage(1, volume)
    size = len(stage.delivered)
    before = [array.copy() for array in (*stage.surface, stage.delivered)]
    other = copied(stage)
    passage = carried_out(other, size // 2, empty_record(size), np.zeros(1, np.int64))
    assert passage.left == size // 2
    for array, expected in zip((*stage.surface, stage.delivered), before, strict=True):
        np.testing.assert_array_equal(array, expected)
    # and can be decimated to the same
    again = carried_out(stage, size // 2, empty_record(size), np.zeros(1, np.int64))
    for one, two in zip(passage.record, again.record, strict=True):
        assert one.tobytes() == two.tobytes()


def test_ways_are_disturbed_differently_and_reproducibly(first_stage):
    stage, made = first_stage(4, volume), []
    for way in ((0, 0.0), (1, 0.3), (2, 0.3), (1, 0.3)):
        record = empty_record(len(stage.delivered))
        passage = carried_out(copied(stage), 20, record, np.zeros(1, np.int64), way=way)
        assert passage.left == 20
        made.append(passage.record.dead.tobytes())
    assert len(set(made)) == 3
    assert made[1] == made[3]
