"""Refined positions: their error, and preservation of the volume."""

import numpy as np
import pytest

from gamutcore.decimation.costs import cost_named
from gamutcore.decimation.costs.deviation import change_at, query_edge
from gamutcore.decimation.costs.dispatch import cost_state
from gamutcore.decimation.costs.memoryless_quadrics import constrained_optimum
from gamutcore.decimation.costs.refinement import mismatch_error, refine_point
from gamutcore.decimation.costs.samples import SAMPLES, take_samples
from gamutcore.decimation.star import star_volume, write_edge_link, write_volume_gradient

FINEST = cost_named("finest").parameters


@pytest.fixture(scope="module")
def case(bumpy_mesh, surface_from):
    """Return the planes, the deviation and the surface of a small boundary, and its edges."""
    positions, faces = bumpy_mesh(3, 150)
    surface, state = surface_from(positions, faces), cost_state(FINEST, positions, faces)
    take_samples(state.deviation, surface, 8000, True)
    return state, surface, surface.corner_facing[surface.corner_facing >= 0].tolist()


@pytest.mark.parametrize("keeps_volume", [False, True])
def test_refined_positions_are_better_and_their_errors_are_correct(case, keeps_volume):
    state, surface, corners = case
    place, trial, moved = np.empty(3), np.empty(3), 0
    least = 1e-6 * state.deviation.weight[: state.deviation.counts[SAMPLES]].sum()
    for corner in corners:
        constrained_optimum(state.quadrics, surface, corner, place)
        start = place.copy()
        before = mismatch_error(state.deviation, surface, corner, start)
        found = refine_point(
            state.deviation, state.quadrics, surface, corner, place, trial, 3, keeps_volume
        )
        assert found <= before
        # the length penalty is negligible
        assert found == pytest.approx(
            mismatch_error(state.deviation, surface, corner, place), abs=least
        )
        moved += bool((place != start).any())
    assert moved > len(corners) / 4


def test_without_steps_the_position_stays(case):
    state, surface, corners = case
    place, trial = np.empty(3), np.empty(3)
    for corner in corners[:20]:
        constrained_optimum(state.quadrics, surface, corner, place)
        start = place.copy()
        found = refine_point(
            state.deviation, state.quadrics, surface, corner, place, trial, 0, False
        )
        np.testing.assert_array_equal(place, start)
        assert found == mismatch_error(state.deviation, surface, corner, start)
        assert query_edge(state.deviation, surface, corner)
        change = change_at(state.deviation, surface, start)
        assert found == pytest.approx(
            change, abs=1e-6 * state.deviation.weight[: state.deviation.counts[SAMPLES]].sum()
        )


def test_refinement_preserves_the_volume(case):
    state, surface, corners = case
    place, trial, ring, slope = np.empty(3), np.empty(3), np.empty((200, 2), np.int32), np.empty(3)
    for corner in corners:
        constrained_optimum(state.quadrics, surface, corner, place)
        refine_point(state.deviation, state.quadrics, surface, corner, place, trial, 3, True)
        one, two = (int(surface.vertex[3 * (corner // 3) + (corner + k) % 3]) for k in (1, 2))
        write_volume_gradient(
            surface.position, ring, write_edge_link(surface, one, two, ring), slope
        )
        assert slope @ place == pytest.approx(star_volume(surface, one, two), rel=1e-9)
