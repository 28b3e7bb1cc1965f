"""Stages: copies share no memory, and compaction keeps the surface."""

import numpy as np
import pytest

from gamutcore.decimation.costs import COSTS, cost_named
from gamutcore.decimation.stage import compact_stage, copy_stage


@pytest.mark.parametrize("cost", COSTS)
def test_a_copy_shares_no_memory(stage_of, icosphere, cost):
    mesh = icosphere(1)
    stage = stage_of(cost_named(cost).parameters, mesh.vertices, mesh.faces)
    copy = copy_stage(stage)
    copy.surface.position[:] = 0.0
    copy.level[:] = 4
    np.testing.assert_array_equal(stage.surface.position, mesh.vertices)
    assert stage.level[0] == len(mesh.vertices)


@pytest.mark.parametrize("cost", COSTS)
def test_a_stage_without_collapses_is_compact(stage_of, icosphere, cost):
    mesh = icosphere(1)
    small = compact_stage(stage_of(cost_named(cost).parameters, mesh.vertices, mesh.faces))
    np.testing.assert_array_equal(small.surface.vertex.reshape(-1, 3), mesh.faces)
    np.testing.assert_array_equal(small.grid.position, mesh.vertices)
    assert small.size == len(mesh.vertices)
