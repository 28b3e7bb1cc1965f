import asyncio

import pytest

from service.caching.single_flight import SingleFlight


def test_all_who_ask_at_the_same_time_share_one_run():
    async def scenario():
        flights, runs = SingleFlight(), []

        async def work():
            runs.append(1)
            await asyncio.sleep(0.01)
            return len(runs)

        assert await asyncio.gather(*(flights.value("a", work) for _ in range(50))) == [1] * 50
        assert await flights.value("a", work) == 2

    asyncio.run(scenario())


def test_the_work_goes_on_when_the_first_to_ask_leaves():
    async def scenario():
        flights, go = SingleFlight(), asyncio.Event()

        async def work():
            await go.wait()
            return "result"

        first = asyncio.create_task(flights.value("a", work))
        await asyncio.sleep(0)
        second = asyncio.create_task(flights.value("a", work))
        await asyncio.sleep(0)
        first.cancel()
        await asyncio.sleep(0)
        go.set()
        assert await second == "result"
        assert first.cancelled()

    asyncio.run(scenario())


def test_an_error_reaches_all_and_is_not_kept():
    async def scenario():
        flights = SingleFlight()

        async def fail():
            await asyncio.sleep(0)
            raise LookupError("gone")

        async def succeed():
            return 1

        outcomes = await asyncio.gather(
            *(flights.value("a", fail) for _ in range(3)), return_exceptions=True
        )
        assert [type(outcome) for outcome in outcomes] == [LookupError] * 3
        assert await flights.value("a", succeed) == 1

    asyncio.run(scenario())


def test_a_forgotten_key_begins_anew():
    async def scenario():
        flights, current = SingleFlight(), []

        async def work():
            await asyncio.sleep(0.01)
            current.append(flights.is_current("a"))
            return object()

        before = asyncio.create_task(flights.value("a", work))
        await asyncio.sleep(0)
        flights.forget("a")
        after = await flights.value("a", work)
        assert await before is not after
        assert current == [False, True]

    asyncio.run(scenario())


def test_what_the_work_raises_comes_out():
    async def fail():
        raise ValueError("no")

    with pytest.raises(ValueError, match="no"):
        asyncio.run(SingleFlight().value("a", fail))
