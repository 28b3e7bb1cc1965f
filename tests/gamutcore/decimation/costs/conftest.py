"""Fixtures for the tests of costs: their compiled functions, called from Python."""

from types import SimpleNamespace

import numba
import pytest

from gamutcore.decimation.costs import interface


@pytest.fixture(scope="session")
def compiled():
    """Return the interface's functions as compiled code calls them."""
    optimum, error, improve = interface.optimum, interface.error, interface.improve
    merge, settle, reach = interface.merge, interface.settle, interface.reach
    depends_on_ring, preserves_volume = interface.depends_on_ring, interface.preserves_volume
    moves_vertices, eager_collapses = interface.moves_vertices, interface.eager_collapses

    @numba.njit
    def compiled_optimum(cost, surface, at, place):
        return optimum(cost, surface, at, place)

    @numba.njit
    def compiled_error(cost, surface, at, place):
        return error(cost, surface, at, place)

    @numba.njit
    def compiled_merge(cost, surface, at, kept, dead, place):
        merge(cost, surface, at, kept, dead, place)

    @numba.njit
    def compiled_settle(cost, surface, at):
        settle(cost, surface, at)

    @numba.njit
    def compiled_reach(cost, surface, at):
        return reach(cost, surface, at)

    @numba.njit
    def compiled_improve(cost, surface, at, place):
        return improve(cost, surface, at, place)

    @numba.njit
    def compiled_constants(cost):
        return (
            depends_on_ring(cost),
            preserves_volume(cost),
            moves_vertices(cost),
            eager_collapses(cost),
        )

    return SimpleNamespace(
        optimum=compiled_optimum,
        error=compiled_error,
        merge=compiled_merge,
        settle=compiled_settle,
        reach=compiled_reach,
        improve=compiled_improve,
        constants=compiled_constants,
    )
