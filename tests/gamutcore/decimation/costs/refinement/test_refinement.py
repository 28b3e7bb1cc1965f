"""Refined positions: their error, and preservation of the volume."""

import numpy as np
import pytest

from gamutcore.decimation.costs import cost_named
from gamutcore.decimation.costs.memoryless_quadrics import constrained_optimum
from gamutcore.decimation.costs.refinement import mismatch_error, refine_point
from gamutcore.decimation.costs.sample_assignment import assign_samples
from gamutcore.decimation.costs.samples import SAMPLES, take_samples
from gamutcore.decimation.star import star_volume, volume_gradient, write_edge_link

FINEST = cost_named("finest").parameters


@pytest.fixture(scope="module")
def case(bumpy_mesh, stage_of):
    """Return the planes, the deviation and the surface of a small boundary, and its edges."""
    positions, faces = bumpy_mesh(3, 150)
    stage = stage_of(FINEST, positions, faces)
    surface = stage.surface
    take_samples(stage.deviation, surface, 8000)
    assign_samples(stage.deviation, surface)
    return stage, surface.corner_facing[surface.corner_facing >= 0].tolist()


@pytest.mark.parametrize("keeps_volume", [False, True])
def test_refined_positions_are_better_and_their_errors_are_correct(case, keeps_volume):
    stage, corners = case
    surface = stage.surface
    place, trial, moved = np.empty(3), np.empty(3), 0
    least = 1e-6 * stage.deviation.weight[: stage.deviation.counts[SAMPLES]].sum()
    for corner in corners:
        constrained_optimum(stage.quadrics, surface, corner, place)
        start = place.copy()
        before = mismatch_error(stage.deviation, surface, corner, start)
        found = refine_point(
            stage.deviation, stage.quadrics, surface, corner, place, trial, keeps_volume
        )
        assert found <= before
        # the length penalty is negligible
        assert found == pytest.approx(
            mismatch_error(stage.deviation, surface, corner, place), abs=least
        )
        moved += bool((place != start).any())
    assert moved > len(corners) / 4


def test_refinement_preserves_the_volume(case):
    stage, corners = case
    surface = stage.surface
    place, trial, ring = np.empty(3), np.empty(3), np.empty((200, 2), np.int32)
    for corner in corners:
        constrained_optimum(stage.quadrics, surface, corner, place)
        refine_point(stage.deviation, stage.quadrics, surface, corner, place, trial, True)
        one, two = (int(surface.vertex[3 * (corner // 3) + (corner + k) % 3]) for k in (1, 2))
        count = write_edge_link(surface, one, two, ring)
        slope = np.array(volume_gradient(surface.position, ring, count))
        assert slope @ place == pytest.approx(star_volume(surface, one, two), rel=1e-9)
