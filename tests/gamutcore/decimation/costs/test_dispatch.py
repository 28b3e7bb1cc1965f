"""What every cost has to do, and how a further one is added."""

from typing import NamedTuple

import numpy as np
import pytest

from gamutcore.decimation import COSTS
from gamutcore.decimation.costs import cost_module, interface
from gamutcore.decimation.star import keeps_star_shape, write_edge_link
from gamutcore.kernels import leaf_kernel


@pytest.fixture(params=COSTS)
def cost(request, bumpy_mesh, surface_from, compiled, random_collapses):
    """Return a cost's state for a surface after a few collapses, and the surface."""
    positions, faces = bumpy_mesh(30)
    state, surface = (
        cost_module(request.param).state(positions, faces),
        surface_from(positions, faces),
    )
    compiled.reach(state, surface, len(positions))
    for left, _ in enumerate(random_collapses(state, surface, 1, 10)):
        compiled.reach(state, surface, len(positions) - 1 - left)
    return state, surface


def edges(surface):
    """Return for each edge one of the corners that face it."""
    return surface.corner_facing[surface.corner_facing >= 0].tolist()


def test_the_costs_are_the_modules_of_the_folder():
    assert set(COSTS) == {"finest", "quadric", "volume"}


def test_the_optimum_says_its_own_error(cost, compiled):
    state, surface = cost
    values = []
    for corner in edges(surface):
        place = np.empty(3)
        value = compiled.optimum(state, surface, corner, place)
        assert value == pytest.approx(
            compiled.error(state, surface, corner, place), rel=1e-6, abs=1e-9
        )
        values.append(value)
    assert len(set(values)) > len(values) // 2


def test_either_corner_that_faces_an_edge_will_do(cost, compiled, ends_of):
    """Where a place is valid; elsewhere a sample may be in several cones, and the first counts."""
    state, surface = cost
    ring, compared = np.empty((200, 2), np.int32), 0
    for corner in edges(surface):
        twin = int(surface.opposite[corner])
        count = write_edge_link(surface, *ends_of(surface, corner), ring)
        middle = surface.position[list(ends_of(surface, corner))].mean(axis=0)
        if keeps_star_shape(surface.position, ring, count, *middle):
            assert compiled.error(state, surface, corner, middle) == pytest.approx(
                compiled.error(state, surface, twin, middle), rel=1e-9, abs=1e-9
            )
            compared += 1
    assert compared > 20


def test_what_is_only_asked_changes_no_position(cost, compiled):
    state, surface = cost
    before = [array.copy() for array in surface]
    compiled.error(state, surface, edges(surface)[0], np.ones(3))
    compiled.optimum(state, surface, edges(surface)[0], np.ones(3))
    compiled.improve(state, surface, int(surface.vertex[edges(surface)[0]]), np.ones(3))
    for array, expected in zip(surface, before, strict=True):
        np.testing.assert_array_equal(array, expected)


def test_the_constants_of_each_cost(compiled, bumpy_mesh):
    """Depends on the ring, preserves the volume, moves vertices; and evaluates how many at once."""
    for name, expected in (
        ("quadric", (False, False, False)),
        ("volume", (True, True, False)),
        ("finest", (True, False, True)),
    ):
        *flags, eager = compiled.constants(cost_module(name).state(*bumpy_mesh(30)))
        assert tuple(flags) == expected
        assert (eager > 0) == expected[0]
        assert cost_module(name).PRESERVES_VOLUME is expected[1]


@pytest.mark.parametrize(
    "function",
    [
        interface.optimum,
        interface.error,
        interface.merge,
        interface.settle,
        interface.reach,
        interface.improve,
        interface.depends_on_ring,
        interface.preserves_volume,
        interface.moves_vertices,
        interface.eager_collapses,
    ],
)
def test_the_names_themselves_are_not_for_calling(function):
    parameters = function.__code__.co_argcount
    with pytest.raises(TypeError, match="no implementation"):
        function(*[None] * parameters)


class Sameness(NamedTuple):
    """State of a cost to which all collapses are equal."""

    nothing: np.ndarray


@leaf_kernel
def _same_optimum(cost, surface, at, place):  # noqa: ARG001
    for axis in range(3):
        place[axis] = surface.position[surface.vertex[at], axis]
    return 1.0


@leaf_kernel
def _same_error(cost, surface, at, place):  # noqa: ARG001
    return 1.0


@leaf_kernel
def _nothing(cost, surface, at, kept, dead, place):
    pass


def test_a_further_cost_is_its_functions_and_nothing_else(surface_from, bumpy_mesh, compiled):
    interface.implement(Sameness, optimum=_same_optimum, error=_same_error, merge=_nothing)
    positions, faces = bumpy_mesh(30)
    place, state, surface = np.empty(3), Sameness(np.zeros(1)), surface_from(positions, faces)
    assert compiled.optimum(state, surface, 5, place) == 1.0
    np.testing.assert_array_equal(place, positions[faces[1, 2]])
    # what is left out does nothing
    before = place.copy()
    assert compiled.reach(state, surface, 20) is False
    assert compiled.improve(state, surface, 5, place) is False
    compiled.settle(state, surface, 5)
    np.testing.assert_array_equal(place, before)
    assert compiled.constants(state) == (False, False, False, 0)
