"""Work that is done once for all who ask at the same time, and threads.

In threads, small tasks come first, large ones are never starved, and no thread is lost.
"""

import asyncio
import threading
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.concurrency import SingleFlight, Threads


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


def run(scenario):
    """Run a scenario with one thread, whose clock it moves; return the order of the tasks."""

    async def main():
        loop = asyncio.get_running_loop()
        clock, real = SimpleNamespace(ahead=0.0), loop.time
        loop.time = lambda: real() + clock.ahead
        order, gate = [], threading.Event()
        threads = Threads(1, "tests")
        first = asyncio.ensure_future(threads.run(1, gate.wait, 600))
        await asyncio.sleep(0)

        async def add(name, patience):
            task = asyncio.ensure_future(threads.run(patience, order.append, name))
            await asyncio.sleep(0)  # it waits from now on
            return task

        tasks = await scenario(add, clock)
        gate.set()
        await asyncio.gather(first, *tasks, return_exceptions=True)
        threads.close()
        return order

    return asyncio.run(main())


def test_small_tasks_pass_large_ones():
    async def scenario(add, _clock):
        return [await add(each, each) for each in (1_000_000, 10, 100_000, 200)]

    assert run(scenario) == [10, 200, 100_000, 1_000_000]


def test_no_stream_of_small_tasks_delays_a_large_one_for_ever():
    async def scenario(add, clock):
        tasks = [await add("large", 500), await add("small", 10)]
        clock.ahead += 1000
        return [*tasks, await add("late", 10)]

    assert run(scenario) == ["small", "large", "late"]


@given(st.lists(st.tuples(st.integers(1, 10**6), st.booleans()), max_size=20))
def test_every_task_that_is_not_cancelled_is_done(tasks):
    async def scenario(add, _clock):
        made = [await add(number, patience) for number, (patience, _) in enumerate(tasks)]
        for task, (_, cancelled) in zip(made, tasks, strict=True):
            if cancelled:
                task.cancel()
        return made

    assert sorted(run(scenario)) == [
        number for number, (_, cancelled) in enumerate(tasks) if not cancelled
    ]


def test_no_thread_is_lost_whenever_a_waiting_task_is_cancelled():
    async def main():
        threads = Threads(1, "tests")
        for pauses in range(30):
            gate = threading.Event()
            first = asyncio.ensure_future(threads.run(1, gate.wait, 600))
            second = asyncio.ensure_future(threads.run(1, int))
            await asyncio.sleep(0)
            gate.set()
            for _ in range(pauses):
                await asyncio.sleep(0)
            second.cancel()  # it waits, or has its turn, or runs, or has ended
            await asyncio.gather(first, second, return_exceptions=True)
            assert await asyncio.wait_for(threads.run(1, int, "7"), 600) == 7
        threads.close()

    asyncio.run(main())
