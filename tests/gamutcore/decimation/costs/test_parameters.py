"""Costs by name, and parameters that depend on the size of the boundary."""

import pytest

from gamutcore.decimation.costs import COSTS, cost_named
from gamutcore.errors import OptionError


def test_there_are_three_costs():
    assert set(COSTS) == {"finest", "quadric", "volume"}
    assert [cost_named(name).name for name in COSTS] == list(COSTS)


@pytest.mark.parametrize("name", COSTS)
def test_stages_become_coarser(name):
    cost = cost_named(name)
    stops = list(cost.compacted)
    if cost.trials:
        assert cost.trials.number > 1
        stops += [cost.trials.vertices, cost.trials.until]
    assert stops == sorted(set(stops), reverse=True)
    assert not stops or stops[-1] > 4


def test_only_the_default_cost_preserves_the_volume():
    assert [name for name in COSTS if cost_named(name).parameters.preserves_volume] == ["volume"]


@pytest.mark.parametrize(
    ("vertices", "moved"), [(50, 100), (2000, 200), (35_000, 1500), (10**6, 1500)]
)
def test_vertices_move_in_a_tenth_of_the_levels(vertices, moved):
    parameters = cost_named("finest").parameters.for_boundary(vertices, 2 * vertices - 4)
    assert parameters.moved_vertices == moved


def test_small_references_have_fewer_samples():
    parameters = cost_named("finest").parameters
    assert parameters.for_boundary(102, 200).samples == 12 * 200
    assert parameters.for_boundary(50_002, 100_000).samples == parameters.samples


def test_unknown_costs_are_refused():
    with pytest.raises(OptionError, match="no cost 'area'"):
        cost_named("area")
