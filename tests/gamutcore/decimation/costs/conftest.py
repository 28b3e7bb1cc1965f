"""Fixtures for the tests of costs: their compiled functions, called from Python."""

from types import SimpleNamespace

import numba
import pytest

from gamutcore.decimation.costs import interface


@pytest.fixture(scope="session")
def compiled():
    """Return the interface's functions as compiled code calls them."""
    optimum, error, merge = interface.optimum, interface.error, interface.merge
    depends_on_ring = interface.depends_on_ring

    @numba.njit
    def compiled_optimum(cost, surface, one, two, place):
        return optimum(cost, surface, one, two, place)

    @numba.njit
    def compiled_error(cost, surface, one, two, place):
        return error(cost, surface, one, two, place)

    @numba.njit
    def compiled_merge(cost, surface, one, two, place):
        merge(cost, surface, one, two, place)

    @numba.njit
    def compiled_depends_on_ring(cost):
        return depends_on_ring(cost)

    return SimpleNamespace(
        optimum=compiled_optimum,
        error=compiled_error,
        merge=compiled_merge,
        depends_on_ring=compiled_depends_on_ring,
    )
