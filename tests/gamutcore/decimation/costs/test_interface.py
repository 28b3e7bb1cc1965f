"""What every cost has to do, and how a further one is added."""

from typing import NamedTuple

import numpy as np
import pytest

from gamutcore.decimation import COSTS
from gamutcore.decimation.costs import cost_module, interface
from gamutcore.kernels import leaf_kernel


@pytest.fixture(params=COSTS)
def cost(request, bumpy_mesh, surface_from):
    """Return a cost's state for a surface, and the surface."""
    positions, faces = bumpy_mesh(30)
    return cost_module(request.param).state(positions, faces), surface_from(positions, faces)


def test_the_costs_are_the_modules_of_the_folder():
    assert set(COSTS) == {"quadric", "volume"}


def test_the_optimum_says_its_own_error(cost, compiled, bumpy_mesh, edges_of):
    state, surface = cost
    for one, two in edges_of(bumpy_mesh(30)[1]):
        place = np.empty(3)
        value = compiled.optimum(state, surface, one, two, place)
        assert value == pytest.approx(
            compiled.error(state, surface, one, two, place), rel=1e-6, abs=1e-12
        )
        assert value >= 0


def test_the_order_of_the_ends_makes_no_difference(cost, compiled, bumpy_mesh, edges_of):
    state, surface = cost
    for one, two in edges_of(bumpy_mesh(30)[1]):
        here, there = np.empty(3), np.empty(3)
        value = compiled.optimum(state, surface, one, two, here)
        assert compiled.optimum(state, surface, two, one, there) == pytest.approx(value, rel=1e-9)
        np.testing.assert_allclose(there, here, rtol=1e-7, atol=1e-7)


def test_an_error_changes_no_position(cost, compiled):
    state, surface = cost
    before = surface.position.copy()
    compiled.error(state, surface, 0, int(surface.vertex[1]), np.ones(3))
    np.testing.assert_array_equal(surface.position, before)


def test_only_the_memoryless_cost_depends_on_the_ring(compiled, bumpy_mesh):
    for name, depends in (("quadric", False), ("volume", True)):
        assert compiled.depends_on_ring(cost_module(name).state(*bumpy_mesh(30))) is depends


@pytest.mark.parametrize(
    "function", [interface.optimum, interface.error, interface.merge, interface.depends_on_ring]
)
def test_the_names_themselves_are_not_for_calling(function):
    parameters = function.__code__.co_argcount
    with pytest.raises(TypeError, match="no implementation"):
        function(*[None] * parameters)


class Sameness(NamedTuple):
    """State of a cost to which all collapses are equal."""

    nothing: np.ndarray


@leaf_kernel
def _same_optimum(cost, surface, kept, dead, place):  # noqa: ARG001
    for axis in range(3):
        place[axis] = surface.position[kept, axis]
    return 1.0


@leaf_kernel
def _same_error(cost, surface, kept, dead, place):  # noqa: ARG001
    return 1.0


@leaf_kernel
def _nothing(cost, surface, kept, dead, place):
    pass


def test_a_further_cost_is_its_functions_and_nothing_else(surface_from, bumpy_mesh, compiled):
    interface.implement(
        Sameness,
        optimum=_same_optimum,
        error=_same_error,
        merge=_nothing,
        depends_on_ring=False,
    )
    positions, faces = bumpy_mesh(30)
    place = np.empty(3)
    state = Sameness(np.zeros(1))
    assert compiled.optimum(state, surface_from(positions, faces), 5, 7, place) == 1.0
    np.testing.assert_array_equal(place, positions[5])
    assert compiled.depends_on_ring(state) is False
