"""Properties of every cost's kernels."""

import numpy as np
import pytest

from gamutcore.decimation.costs import COSTS, cost_named
from gamutcore.decimation.costs.dispatch import (
    enter_level,
    error_at,
    find_improvement,
    find_optimum,
)
from gamutcore.decimation.star import keeps_star_shape, write_edge_link


@pytest.fixture(params=COSTS)
def cost(request, bumpy_mesh, random_collapses, stage_of):
    """Return the stage of a cost after a few collapses."""
    positions, faces = bumpy_mesh(30)
    stage = stage_of(cost_named(request.param).parameters, positions, faces)
    enter_level(stage, len(positions))
    for left, _ in enumerate(random_collapses(stage, 1, 10)):
        enter_level(stage, len(positions) - 1 - left)
    return stage


def edges(surface):
    """Return for each edge one of the corners that face it."""
    return surface.corner_facing[surface.corner_facing >= 0].tolist()


def test_the_optimum_returns_its_error(cost):
    stage = cost
    surface = stage.surface
    values = []
    for corner in edges(surface):
        place = np.empty(3)
        value = find_optimum(stage, corner, place)
        assert value == pytest.approx(error_at(stage, corner, place), rel=1e-6, abs=1e-9)
        values.append(value)
    assert len(set(values)) > len(values) // 2


def test_both_corners_of_an_edge_give_the_same_result(cost, ends_of):
    """At valid positions. Elsewhere a sample may lie in several cones, and the first counts."""
    stage = cost
    surface = stage.surface
    ring, compared = np.empty((200, 2), np.int32), 0
    for corner in edges(surface):
        twin = int(surface.opposite[corner])
        count = write_edge_link(surface, *ends_of(surface, corner), ring)
        middle = surface.position[list(ends_of(surface, corner))].mean(axis=0)
        if keeps_star_shape(surface.position, ring, count, *middle):
            assert error_at(stage, corner, middle) == pytest.approx(
                error_at(stage, twin, middle), rel=1e-9, abs=1e-9
            )
            compared += 1
    assert compared > 20


def test_evaluation_changes_no_position(cost):
    stage = cost
    surface = stage.surface
    before = [array.copy() for array in surface]
    error_at(stage, edges(surface)[0], np.ones(3))
    find_optimum(stage, edges(surface)[0], np.ones(3))
    find_improvement(stage, int(surface.vertex[edges(surface)[0]]), np.ones(3))
    for array, expected in zip(surface, before, strict=True):
        np.testing.assert_array_equal(array, expected)
