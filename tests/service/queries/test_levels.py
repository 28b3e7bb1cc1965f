import asyncio

import pytest

from gamutcore.errors import TriangleCountError
from service.meshes.library import Library
from service.meshes.requested_levels import LevelRequest, RequestedLevels
from service.queries.levels import QueryLevels


@pytest.fixture
def run(filled_store, built):
    """Run a coroutine function with the levels of the filled store and its first gamut, open."""

    def run_scenario(scenario, capacity=10**8):
        library = Library(filled_store, 10**9)

        async def opened_first():
            levels = QueryLevels(library, RequestedLevels(library), capacity)
            await scenario(library, levels, await library.gamut(built[0].id))

        try:
            asyncio.run(opened_first())
        finally:
            library.close()

    return run_scenario


@pytest.mark.slow
def test_a_level_is_indexed_once_and_then_at_hand(run):
    async def scenario(library, levels, opened):
        request = LevelRequest(100)
        assert levels.find_ready(opened, request) is None
        before = library.cache.nbytes
        level, same = await asyncio.gather(
            levels.level(opened, request), levels.level(opened, request)
        )
        assert level == same == levels.find_ready(opened, request)
        assert levels.find_ready(opened, LevelRequest(101)) == level
        assert level.triangles == 100
        assert level.axes == ("L*", "a*", "b*")
        assert opened.gamut.levels.nbytes > 0
        # indexes are memory of open gamuts
        assert library.cache.nbytes == opened.gamut.nbytes > before

    run(scenario)


def test_the_error_is_bounded_for_counts_and_limits(run):
    async def scenario(_library, levels, opened):
        errors = {}
        for request in (LevelRequest(4), LevelRequest(20), LevelRequest(302)):
            level = await levels.level(opened, request)
            errors[level.triangles] = level.max_error
        assert errors[4] > errors[20] > errors[302] > 0
        assert (await levels.level(opened, LevelRequest(max_error=1.0))).max_error <= 1
        full = await levels.level(opened, LevelRequest(max_error=0.0))
        assert full.triangles == opened.gamut.history.triangles
        assert full.max_error == 0

    run(scenario)


def test_what_does_not_fit_is_not_kept(run):
    async def scenario(_library, levels, opened):
        level = await levels.level(opened, LevelRequest(100))
        assert level.triangles == 100
        assert opened.gamut.levels.nbytes == 0
        assert levels.find_ready(opened, LevelRequest(100)) is None

    run(scenario, capacity=1000)


def test_missing_levels_are_errors(run):
    async def scenario(_library, levels, opened):
        with pytest.raises(TriangleCountError):
            await levels.level(opened, LevelRequest(10**6))

    run(scenario)
