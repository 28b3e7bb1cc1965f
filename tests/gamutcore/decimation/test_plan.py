"""Plans: each cost has one that its levels can follow, and one without stages asks for nothing."""

import numpy as np
import pytest

from gamutcore.decimation.costs import COSTS, cost_module
from gamutcore.decimation.plan import Plan


@pytest.mark.parametrize("cost", COSTS)
def test_the_levels_of_a_plan_become_coarser(cost):
    plan = cost_module(cost).PLAN
    stops = list(plan.compacted)
    for fork in plan.forks:
        assert fork.ways > 1
        stops += [fork.vertices] if fork.vertices != stops[-1] else []
        stops += fork.compared
    assert stops == sorted(set(stops), reverse=True)
    assert not stops or stops[-1] > 4


@pytest.mark.parametrize("cost", ["finest", "volume"])
def test_a_state_goes_along_to_all_of_its_faces_as_it_is(cost, bumpy_mesh):
    positions, faces = bumpy_mesh(3)
    state = cost_module(cost).state(positions, faces)
    plan = cost_module(cost).PLAN
    assert plan.deviation(state) == 0.0
    state.deviation.error[:] = 1.0
    assert plan.deviation(state) == len(faces)
    other = plan.state_on(state, np.arange(len(positions)), np.arange(len(faces)))
    np.testing.assert_array_equal(other.quadrics.area_vector, state.quadrics.area_vector)
    assert other.quadrics.sums.shape == state.quadrics.sums.shape
    np.testing.assert_array_equal(other.vertices, state.vertices)
    assert other.vertices is not state.vertices


def test_a_plan_without_stages_has_no_use_for_their_functions():
    plan = Plan()
    assert plan.compacted == plan.forks == ()
    with pytest.raises(TypeError, match="no stages"):
        plan.deviation(None)
