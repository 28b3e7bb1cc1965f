"""Work that is done once for all who ask at the same time."""

import asyncio

import pytest

from service.concurrency import SingleFlight


@pytest.fixture
def flights():
    return SingleFlight()


def test_all_who_ask_at_the_same_time_share_one_run(flights):
    async def scenario():
        runs, go = [], asyncio.Event()

        async def work():
            runs.append(1)
            await go.wait()
            return len(runs)

        asked = [asyncio.create_task(flights.value("a", work)) for _ in range(50)]
        await asyncio.sleep(0)
        go.set()
        assert await asyncio.gather(*asked) == [1] * 50
        assert await flights.value("a", work) == 2

    asyncio.run(scenario())


def test_the_work_goes_on_when_the_first_to_ask_leaves(flights):
    async def scenario():
        go = asyncio.Event()

        async def work():
            await go.wait()
            return "result"

        first, second = (asyncio.create_task(flights.value("a", work)) for _ in range(2))
        await asyncio.sleep(0)
        first.cancel()
        await asyncio.sleep(0)
        go.set()
        assert await second == "result"
        assert first.cancelled()

    asyncio.run(scenario())


def test_an_error_reaches_all_and_is_not_kept(flights):
    async def scenario():
        async def fail():
            await asyncio.sleep(0)
            raise LookupError("gone")

        asked = (flights.value("a", fail) for _ in range(3))
        outcomes = await asyncio.gather(*asked, return_exceptions=True)
        assert [type(outcome) for outcome in outcomes] == [LookupError] * 3
        assert await flights.value("a", lambda: asyncio.sleep(0, 1)) == 1

    asyncio.run(scenario())


def test_a_forgotten_key_begins_anew(flights):
    async def scenario():
        current, go = {}, asyncio.Event()

        async def work(name):
            await go.wait()
            current[name] = flights.is_current("a")
            return name

        before = asyncio.create_task(flights.value("a", lambda: work("before")))
        await asyncio.sleep(0)
        flights.forget("a")
        after = asyncio.create_task(flights.value("a", lambda: work("after")))
        await asyncio.sleep(0)
        go.set()
        assert await before == "before"
        assert await after == "after"
        assert current == {"before": False, "after": True}

    asyncio.run(scenario())
