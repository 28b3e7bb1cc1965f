"""Tasks of queries: small ones first, large ones never starved, and no thread is lost."""

import asyncio
import threading
from types import SimpleNamespace

from hypothesis import given
from hypothesis import strategies as st

from service.queries.scheduling import DeadlineThreads


def run(scenario):
    """Run a scenario with one thread, whose clock it moves; return the order of the tasks."""

    async def main():
        loop = asyncio.get_running_loop()
        clock, real = SimpleNamespace(ahead=0.0), loop.time
        loop.time = lambda: real() + clock.ahead
        order, gate = [], threading.Event()
        threads = DeadlineThreads(1)
        first = asyncio.ensure_future(threads.run(1, gate.wait, 600))
        await asyncio.sleep(0)

        async def add(name, rows):
            task = asyncio.ensure_future(threads.run(rows, order.append, name))
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
        return [await add(rows, rows) for rows in (1_000_000, 10, 100_000, 200)]

    assert run(scenario) == [10, 200, 100_000, 1_000_000]


def test_no_stream_of_small_tasks_delays_a_large_one_for_ever():
    async def scenario(add, clock):
        tasks = [await add("large", 1_000_000), await add("small", 10)]
        clock.ahead += 1000
        return [*tasks, await add("late", 10)]

    assert run(scenario) == ["small", "large", "late"]


@given(st.lists(st.tuples(st.integers(1, 10**6), st.booleans()), max_size=20))
def test_every_task_that_is_not_cancelled_is_done(tasks):
    async def scenario(add, _clock):
        made = [await add(number, rows) for number, (rows, _) in enumerate(tasks)]
        for task, (_, cancelled) in zip(made, tasks, strict=True):
            if cancelled:
                task.cancel()
        return made

    assert sorted(run(scenario)) == [
        number for number, (_, cancelled) in enumerate(tasks) if not cancelled
    ]


def test_no_thread_is_lost_whenever_a_waiting_task_is_cancelled():
    async def main():
        threads = DeadlineThreads(1)
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
