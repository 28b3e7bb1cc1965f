"""Memory of bounded size, and work that is done once for all who ask at the same time."""

import asyncio

import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.caching.byte_bounded_cache import ByteBoundedCache
from service.caching.single_flight import SingleFlight

CAPACITY = 50
KEYS = st.integers(0, 7)
SIZES = st.integers(0, 60)
STEPS = st.one_of(
    st.tuples(st.just("put"), KEYS, SIZES),
    st.tuples(st.just("get"), KEYS, SIZES),
    st.tuples(st.sampled_from(["resize", "discard_value"]), KEYS, SIZES),
    st.tuples(st.just("resize another"), KEYS, SIZES),
    st.tuples(st.sampled_from(["discard", "discard_where"]), KEYS, SIZES),
)


@given(st.lists(STEPS, max_size=60))
def test_a_cache_keeps_what_was_used_last_up_to_its_bytes(steps):
    """The expectation is a list of entries, the least recently used first."""
    cache, expected, hits, added = ByteBoundedCache(CAPACITY), [], 0, 0
    for name, key, size in steps:
        kept = next((entry for entry in expected if entry[0] == key), None)
        if name == "put":
            value = [key]
            cache.put(key, value, size)
            added += 1
            expected = [entry for entry in expected if entry[0] != key]
            if size <= CAPACITY:
                expected.append((key, value, size))
        elif name == "get":
            found = cache.get(key)
            assert found is (kept and kept[1])
            hits += kept is not None
            if kept:
                expected.remove(kept)
                expected.append(kept)
        elif name == "resize" and kept:
            cache.resize(key, kept[1], size)
            expected.remove(kept)
            if size <= CAPACITY:
                expected.append((key, kept[1], size))
        elif name == "resize another":
            cache.resize(key, [key], size)  # an equal value, but not the one that is kept
        elif name == "discard":
            cache.discard(key)
            expected = [entry for entry in expected if entry[0] != key]
        elif name == "discard_value":
            assert not cache.discard_value(key, [key])
            assert kept is None or cache.discard_value(key, kept[1])
            expected = [entry for entry in expected if entry[0] != key]
        elif name == "discard_where":
            cache.discard_where(lambda each, least=key: each >= least)
            expected = [entry for entry in expected if entry[0] < key]
        while sum(entry[2] for entry in expected) > CAPACITY:
            expected.pop(0)
        assert cache.nbytes == sum(entry[2] for entry in expected) <= CAPACITY
        assert (cache.hits, cache.misses, len(cache)) == (hits, added, len(expected))


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
