import asyncio
import functools
import re
import threading
import time
from math import inf

import httpx
import pytest

from gamutcore.errors import HistoryFileError
from gamutcore.metric import level_search
from gamutcore.metric.level_search import NO_ERROR, BoundedLevel, Bounds
from service.meshes import requested_levels as module
from service.meshes.library import Library
from service.meshes.requested_levels import LevelRequest, RequestedLevels
from service.storage.gamuts import GamutDamagedError
from service.telemetry.server_timing import ServerTiming


class Levels(RequestedLevels):
    """Level searches, asked with limits only."""

    @staticmethod
    def request(limits):
        return LevelRequest(None, limits.distance, limits.mismatch)

    async def found(self, opened, limits):
        return BoundedLevel(*await self.find(opened, self.request(limits)))

    def known(self, name, limits):
        level = self.find_known(name, self.request(limits), None)
        return None if level is None else BoundedLevel(*level)

    def at_most(self, record, limits):
        return self.triangle_bound(record, self.request(limits))


LIMITS = Bounds(0.7, 0.02)


@pytest.fixture
def run(filled_store):
    """Run a coroutine function with the level searches of the filled store."""

    def run_scenario(scenario, capacity=10**9):
        library = Library(filled_store, capacity)
        try:
            return asyncio.run(scenario(library, Levels(library)))
        finally:
            library.close()

    return run_scenario


def test_one_search_runs_at_a_time(run, built, monkeypatch):
    find, inside, most = level_search.LevelSearch.find, [], []

    def recorded(self, history, limits):
        inside.append(threading.get_ident())
        most.append(len(inside))
        try:
            return find(self, history, limits)
        finally:
            inside.remove(threading.get_ident())

    monkeypatch.setattr(level_search.LevelSearch, "find", recorded)

    async def scenario(library, levels):
        opened = [await library.gamut(gamut.id) for gamut in built]
        limits = [Bounds(0.5 + 0.02 * place) for place in range(8)]
        asked = [(gamut, limit) for limit in [*limits, LIMITS, LIMITS] for gamut in opened]
        found = await asyncio.gather(*(levels.found(*each) for each in asked))
        for (_, limit), level in zip(asked, found, strict=True):
            assert level.bounds.within(limit)
        assert levels.known(built[0].id, LIMITS) is not None
        assert len(most) == 9 * len(built)

    run(scenario)
    assert set(most) == {1}


def test_others_are_served_while_a_level_is_searched(run, built, monkeypatch):
    """One of the library's threads is left, whatever is asked for."""
    hold = threading.Event()
    found = level_search.LevelSearch.find

    def held(self, history, limits):
        assert hold.wait(60)
        return found(self, history, limits)

    monkeypatch.setattr(level_search.LevelSearch, "find", held)

    async def scenario(library, levels):
        opened = await library.gamut(built[0].id)
        searches = [
            asyncio.create_task(levels.found(opened, Bounds(0.5 + 0.01 * place)))
            for place in range(20)
        ]
        await asyncio.sleep(0.05)
        try:
            other = await asyncio.wait_for(library.gamut(built[1].id), 30)
            await asyncio.wait_for(library.unpack(other, other.gamut.history.triangles), 30)
        finally:
            hold.set()
        await asyncio.gather(*searches)

    run(scenario)


def test_the_wait_for_other_searches_is_told_by_itself(run, built, monkeypatch):
    found = level_search.LevelSearch.find

    def slow(self, history, limits):
        time.sleep(0.05)
        return found(self, history, limits)

    monkeypatch.setattr(level_search.LevelSearch, "find", slow)

    async def scenario(library, levels):
        opened = [await library.gamut(gamut.id) for gamut in built]
        await asyncio.gather(*(library.unpack(one, one.gamut.history.triangles) for one in opened))

        async def app(scope, _receive, send):
            await levels.found(opened[int(scope["path"][1:])], LIMITS)
            await send({"type": "http.response.start", "status": 200, "headers": []})
            await send({"type": "http.response.body", "body": b""})

        transport = httpx.ASGITransport(ServerTiming(app))
        async with httpx.AsyncClient(transport=transport, base_url="http://test") as client:
            answers = await asyncio.gather(client.get("/0"), client.get("/1"))
        texts = [answer.headers["server-timing"] for answer in answers]
        return [dict(re.findall(r"([a-z]+);dur=([0-9.]+)", text)) for text in texts]

    first, second = run(scenario)
    assert list(first) == list(second) == ["total", "wait", "choose"]
    assert float(first["wait"]) < 40 <= float(second["wait"])
    assert float(second["choose"]) >= 40
    assert float(second["total"]) >= float(second["wait"]) + float(second["choose"]) - 0.1


def test_nothing_is_unpacked_for_the_coarsest_and_the_full_level(run, built):
    async def scenario(library, levels):
        opened = await library.gamut(built[0].id)
        assert (await levels.found(opened, Bounds(1e6))).triangles == 4
        largest = opened.gamut.history.triangles
        assert await levels.found(opened, Bounds(inf, 0.0)) == BoundedLevel(largest, NO_ERROR)
        assert not opened.gamut.history.is_unpacked(largest)

    run(scenario)


@pytest.mark.parametrize("name", ["distance", "mismatch"])
def test_at_most_so_many_triangles_are_told_without_a_search(run, built, name):
    async def scenario(library, levels):
        opened = await library.gamut(built[0].id)
        largest = opened.record.description["counts"]["triangles"]
        limits = [Bounds()._replace(**{name: limit}) for limit in (1e-9, 0.003, 0.03, 0.3, 3, 300)]
        told = [levels.at_most(opened.record, limit) for limit in limits]
        assert told == sorted(told, reverse=True)
        assert (told[0], told[-1]) == (largest, 4)
        assert levels.at_most(opened.record, Bounds(inf, 0.0)) == largest
        for limit, most in zip(limits, told, strict=True):
            assert (await levels.found(opened, limit)).triangles <= most

    run(scenario)


def test_what_is_known_outlives_the_open_gamut_but_not_the_deleted_one(run, built):
    async def scenario(library, levels):
        name = built[0].id
        assert levels.known(name, LIMITS) is None
        level = await levels.found(await library.gamut(name), LIMITS)
        library.discard(name)
        assert levels.known(name, LIMITS) == level
        levels.discard(name)
        assert levels.known(name, LIMITS) is None

    run(scenario)


def test_what_is_deleted_meanwhile_leaves_nothing_behind(run, built):
    async def scenario(library, levels):
        name = built[0].id
        opened = await library.gamut(name)
        search = asyncio.create_task(levels.found(opened, LIMITS))
        await asyncio.sleep(0)
        library.discard(name)
        levels.discard(name)
        assert (await search).bounds.within(LIMITS)
        assert (await levels.found(opened, Bounds(0.6))).bounds.within(Bounds(0.6))
        for limits in (LIMITS, Bounds(0.6), Bounds(1e6)):
            assert levels.known(name, limits) is None

    run(scenario)


def test_without_room_everything_is_answered_and_nothing_kept(run, built, monkeypatch):
    monkeypatch.setattr(module, "_CAPACITY", 0)
    monkeypatch.setattr(module, "_LEVELS_CAPACITY", 0)

    async def scenario(library, levels):
        opened = await library.gamut(built[0].id)
        first, second = [await levels.found(opened, LIMITS) for _ in range(2)]
        assert first == second
        assert levels.known(built[0].id, LIMITS) is None

    run(scenario)


def test_processes_agree(run, built):
    """Each finds for itself, after other questions."""

    async def scenario(library, levels, others):
        opened = await library.gamut(built[0].id)
        for other in others:
            await levels.found(opened, other)
        return await levels.found(opened, LIMITS)

    others = ([], [Bounds(0.4), Bounds(2.0)], [Bounds(inf, 1e-3), Bounds(1.0, 0.1)])
    answers = {run(functools.partial(scenario, others=asked)) for asked in others}
    assert len(answers) == 1


def test_of_a_damaged_gamut_nothing_is_found_and_the_next_one_is_searched_anew(
    run, built, filled_store, publish_built, monkeypatch
):
    async def scenario(library, levels):
        opened = await library.gamut(built[0].id)

        def broken(_triangles):
            raise HistoryFileError("a stream ends too early")

        monkeypatch.setattr(opened.gamut.history, "unpack", broken)
        with pytest.raises(GamutDamagedError):
            await levels.found(opened, LIMITS)
        assert levels.known(built[0].id, LIMITS) is None
        publish_built(filled_store, built[0])
        again = await library.gamut(built[0].id)
        assert again is not opened
        assert (await levels.found(again, LIMITS)).bounds.within(LIMITS)

    run(scenario)
