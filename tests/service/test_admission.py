"""Admission: never more than there is, everybody is answered, clients take turns."""

import asyncio
import contextlib
import gc
import itertools
import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from service.admission import FREE_BYTES, Admission, Work
from service.library import ByteBoundedCache
from service.problems.problem import ProblemError

UNIT = 10 * FREE_BYTES
BUDGET = 80 * UNIT
RESERVE = BUDGET // 8
HOUR = 36e9
"""Effort with a patience of an hour, so that no test is too slow for the order."""

MOST = 70
"""Units that views and heavy work have together."""

CLIENTS = st.sampled_from("abc")
WORKS = st.sampled_from(Work)
SIZES = st.integers(0, MOST)
STEPS = st.lists(
    st.one_of(
        st.tuples(st.just("ask"), CLIENTS, WORKS, SIZES),
        st.tuples(st.just("keep"), CLIENTS, WORKS, SIZES),
        st.tuples(
            st.sampled_from(["leave", "send", "read", "cancel", "exchange"]), CLIENTS, WORKS, SIZES
        ),
    ),
    max_size=40,
)


def run(scenario):
    asyncio.run(asyncio.wait_for(scenario(), 60))


async def settle():
    """Let the event loop run until nothing goes on."""
    for _ in range(8):
        await asyncio.sleep(0)


class Requests:
    """Requests of a schedule. The places are left by the test, in the order of the grants."""

    def __init__(self, admission):
        self.admission, self.order, self.places, self.tasks = admission, [], {}, {}

    def ask(self, name, client="a", work=Work.HEAVY, units=0, effort=0.0):
        async def wait():
            place = await self.admission.place(work, client, lambda: units * UNIT, HOUR * effort)
            self.order.append(name)
            self.places[name] = place

        self.tasks[name] = asyncio.create_task(wait())

    async def finish(self):
        """Leave all places, one after the other, until everybody has had one."""
        while not all(task.done() for task in self.tasks.values()) or self.places:
            await settle()
            for name in list(self.places)[:1]:
                self.places.pop(name).leave()
        await settle()


class Schedule:
    """Requests, places and values in any order; `check` has what always holds."""

    def __init__(self):
        self.admission = Admission(BUDGET, most_waiting=4)
        self.cache = ByteBoundedCache(BUDGET)
        self.admission.add(self.cache)
        self.tasks, self.places, self.answers = [], [], []

    def ask(self, client, work, units):
        need = self.admission.place(work, client, lambda: units * UNIT, units)
        self.tasks.append(asyncio.create_task(need))

    def keep(self, _client, _work, units):
        nbytes = min(units * UNIT, BUDGET - self.admission.total)
        kept = self.admission.hold("kept", nbytes)
        self.cache.put(object(), kept, nbytes)

    def cancel(self, _client, _work, units):
        if self.tasks:
            self.tasks[units % len(self.tasks)].cancel()

    def leave(self, _client, _work, units):
        if self.places:
            place = self.places.pop(units % len(self.places))
            place.leave()
            place.leave()

    def send(self, client, _work, units):
        """Leave a place, and hold a part of its bytes for an answer."""
        if self.places:
            place = self.places.pop(units % len(self.places))
            self.answers.append(self.admission.hold("answers", place.nbytes // 2, client))
            place.leave()

    def read(self, _client, _work, units):
        if self.answers:
            self.answers.pop(units % len(self.answers)).resize(0)

    def exchange(self, _client, _work, units):
        if self.places:
            place = self.places.pop(units % len(self.places))
            self.tasks.append(asyncio.create_task(exchanged(place, units * UNIT)))

    async def collect(self):
        """Take the places that were given."""
        await settle()
        for task in [task for task in self.tasks if task.done()]:
            self.tasks.remove(task)
            if not task.cancelled() and task.exception() is None:
                self.places.append(task.result())

    def check(self):
        admission = self.admission
        for work in Work:
            most = admission.places[work] + admission.first_places[work]
            assert 0 <= admission.running[work] <= most
        assert all(admission.granted[work] >= 0 for work in Work)
        assert admission.granted[Work.SMALL] <= admission.reserve == RESERVE
        others = admission.granted[Work.VIEW] + admission.granted[Work.HEAVY]
        assert others <= BUDGET - RESERVE
        assert admission.total <= BUDGET
        assert all(count >= 0 for count in admission.held.values())


async def exchanged(place, nbytes):
    await place.exchange(nbytes)
    return place


@settings(max_examples=100, deadline=None)
@given(STEPS)
def test_places_and_bytes_are_never_exceeded_and_everybody_is_answered(steps):
    async def scenario():
        schedule = Schedule()
        for name, *arguments in steps:
            getattr(schedule, name)(*arguments)
            await schedule.collect()
            schedule.check()
        schedule.cache.discard_where(lambda _: True)
        schedule.answers.clear()
        while schedule.tasks or schedule.places:
            while schedule.places:
                schedule.places.pop().leave()
            await schedule.collect()
            schedule.check()
        gc.collect(1)  # the whole heap of the test session takes long
        admission = schedule.admission
        assert not sum(admission.waiting.values())
        assert admission.total == 0
        assert not +admission.running
        assert not admission.sent
        for work in Work:  # everything is free again
            units = RESERVE if work is Work.SMALL else BUDGET - RESERVE
            with await admission.place(work, "a", lambda n=units: n):
                assert admission.total == units

    run(scenario)


@settings(max_examples=100, deadline=None)
@given(st.lists(st.tuples(CLIENTS, st.integers(0, 60), st.integers(0, 9)), max_size=12))
def test_clients_that_wait_take_turns_whatever_one_of_them_posts(others):
    """`mine` waits with five requests; between two of them, each other client has one grant."""

    async def scenario():
        requests = Requests(Admission(BUDGET, most_waiting=64))
        requests.ask(("first", 0))
        await settle()
        for number, (client, units, effort) in enumerate(others):
            requests.ask((client, number), client, units=units, effort=effort)
            if number == len(others) // 2:
                for own in range(5):
                    requests.ask(("mine", own), "mine", units=5 * own, effort=own)
        await requests.finish()
        order = [name for name, _ in requests.order[1:]]
        places = [place for place, name in enumerate(order) if name == "mine"]
        for before, after in itertools.pairwise(places):
            between = order[before + 1 : after]
            assert len(between) == len(set(between))
        # whoever has not had a turn yet precedes those that have
        if places:
            assert len(order[: places[0]]) == len(set(order[: places[0]]))

    run(scenario)


@settings(max_examples=50, deadline=None)
@given(st.lists(st.integers(0, 5), min_size=2, max_size=10))
def test_the_least_effort_of_a_client_goes_first(efforts):
    async def scenario():
        requests = Requests(Admission(BUDGET, most_waiting=64))
        requests.ask("first")
        await settle()
        for number, effort in enumerate(efforts):
            requests.ask((effort, number), effort=effort)
        await requests.finish()
        assert requests.order[1:] == sorted(requests.order[1:])

    run(scenario)


def test_a_stream_of_little_effort_does_not_delay_a_large_request_for_ever():
    async def scenario():
        loop = asyncio.get_running_loop()
        ahead, real = [0.0], loop.time
        loop.time = lambda: real() + ahead[0]
        requests = Requests(Admission(BUDGET, most_waiting=64))
        requests.ask("first")
        requests.ask("large", effort=0.05)
        await settle()
        for number in range(60):
            requests.ask(number)
            await settle()
            ahead[0] += 4.0  # seconds of each request; three minutes are the patience
            requests.places.pop(next(iter(requests.places))).leave()
            await settle()
        assert 30 < requests.order.index("large") < 50
        await requests.finish()

    asyncio.run(scenario())  # without a limit of time, because the clock is moved


def test_a_client_has_at_most_so_many_requests_waiting():
    async def scenario():
        admission = Admission(BUDGET, most_waiting=3)
        requests = Requests(admission)
        for number in range(5):
            requests.ask(number)
        await settle()
        with pytest.raises(ProblemError) as caught:
            await requests.tasks[4]
        assert caught.value.problem.code == "queries-busy"
        assert caught.value.problem.kind.status == 429
        assert int(caught.value.problem.headers["Retry-After"]) > 0
        assert (admission.waiting[Work.HEAVY], admission.refused) == (3, 1)
        requests.ask("other", "b")  # another client is not concerned
        await settle()
        assert admission.waiting[Work.HEAVY] == 4
        requests.tasks.pop(4)
        await requests.finish()

    run(scenario)


@pytest.mark.parametrize("pauses", range(6))
def test_a_cancelled_request_loses_nothing(pauses):
    """It waits, or has its place, or has it and does not know."""

    async def scenario():
        admission = Admission(BUDGET, most_waiting=9)
        requests = Requests(admission)
        requests.ask("first", units=MOST)
        await settle()
        requests.ask("cancelled", units=MOST)
        requests.ask("third", "b", units=MOST)
        await settle()
        requests.places.pop("first").leave()
        for _ in range(pauses):
            await asyncio.sleep(0)
        requests.tasks["cancelled"].cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await requests.tasks["cancelled"]
        await requests.finish()
        assert "third" in requests.order
        assert admission.total == 0

    run(scenario)


def test_caches_give_way_before_anyone_waits_the_least_recently_used_first():
    async def scenario():
        admission = Admission(BUDGET, most_waiting=9)
        caches = [ByteBoundedCache(BUDGET), ByteBoundedCache(BUDGET)]
        for number in range(7):
            kept = admission.hold("kept", 10 * UNIT)
            caches[number % 2].put(number, kept, kept.nbytes)
            del kept
        for cache in caches:
            admission.add(cache)
        caches[0].get(0)
        with await admission.place(Work.VIEW, "a", lambda: 40 * UNIT):
            assert [key for key in range(7) if caches[key % 2].get(key)] == [0, 5, 6]
        # what is used elsewhere cannot give way, so nothing is given up for it in vain
        in_use = admission.hold("used", 40 * UNIT)
        waiting = asyncio.create_task(admission.place(Work.VIEW, "a", lambda: 65 * UNIT))
        await settle()
        assert not waiting.done()
        assert [key for key in range(7) if caches[key % 2].get(key)] == [0, 5, 6]
        del in_use  # nobody refers to it any more
        await settle()
        waiting.result().leave()
        assert len(caches[0]) + len(caches[1]) == 0

    run(scenario)


def test_the_need_is_asked_for_again_at_the_end_of_the_wait():
    async def scenario():
        admission = Admission(BUDGET, most_waiting=9)
        needs = {"units": MOST}
        with await admission.place(Work.VIEW, "a", lambda: UNIT):
            task = asyncio.create_task(
                admission.place(Work.VIEW, "b", lambda: needs["units"] * UNIT)
            )
            await settle()
            assert not task.done()
            needs["units"] = 0  # the first has made what the second wants
        assert (await task).nbytes == 0
        task.result().leave()

    run(scenario)


def test_small_work_has_places_and_bytes_of_its_own():
    async def scenario():
        admission = Admission(BUDGET, most_waiting=99)
        requests = Requests(admission)
        for work in (Work.VIEW, Work.HEAVY):
            for number in range(20):
                requests.ask((work, number), work=work, units=MOST - 1)
        await settle()
        with await admission.place(Work.SMALL, "b", lambda: RESERVE):
            assert admission.granted[Work.SMALL] == RESERVE
            with await admission.place(Work.SMALL, "b", lambda: FREE_BYTES):
                pass  # no bytes are needed, so none are waited for
            # what needs more than the reserve is not small
            task = asyncio.create_task(admission.place(Work.SMALL, "b", lambda: RESERVE + 1))
            await settle()
            assert not task.done()
        requests.tasks["small"] = asyncio.create_task(leave(task))
        await requests.finish()

    async def leave(task):
        place = await task
        assert place.work is Work.VIEW
        place.leave()

    run(scenario)


def test_the_first_view_of_a_client_does_not_wait_for_the_views_of_others():
    async def scenario():
        admission = Admission(BUDGET, most_waiting=99)
        requests = Requests(admission)
        for number in range(20):
            requests.ask(number, "many", Work.VIEW)
        requests.ask("first", "other", Work.VIEW)
        requests.ask("second", "other", Work.VIEW)
        await settle()
        assert len(requests.order) == admission.places[Work.VIEW] + 1
        assert "first" in requests.places
        await requests.finish()

    run(scenario)


def test_heavy_work_gets_its_bytes_among_views_that_never_end():
    async def scenario():
        admission = Admission(BUDGET, most_waiting=99)
        requests, served = Requests(admission), 0
        for number in range(3):
            requests.ask(number, "views", Work.VIEW, 20)
        requests.ask("heavy", "heavy", Work.HEAVY, MOST)
        await settle()
        while "heavy" not in requests.order:
            requests.ask(f"view {served}", "views", Work.VIEW, 20)
            requests.places.pop(next(iter(requests.places))).leave()
            await settle()
            served += 1
            assert served < 10
        await requests.finish()

    run(scenario)


def test_an_answer_in_pieces_goes_on_before_requests_that_wait_for_its_bytes():
    async def scenario():
        admission = Admission(BUDGET, most_waiting=1)
        answer = admission.hold("answers", 10 * UNIT, "a")
        blocked = asyncio.create_task(admission.place(Work.VIEW, "a", lambda: MOST * UNIT))
        await settle()
        for _ in range(3):
            async with asyncio.timeout(10):
                with await admission.place(Work.VIEW, "a", int, goes_on=True):
                    assert admission.running[Work.VIEW] == 1
        assert not blocked.done()
        answer.resize(0)
        (await blocked).leave()

    run(scenario)


def test_answers_that_a_client_does_not_read_stop_its_own_work_alone():
    async def scenario():
        admission = Admission(BUDGET, most_waiting=99)
        answers = [admission.hold("answers", 10 * UNIT, "slow") for _ in range(2)]
        requests = Requests(admission)
        for number in range(3):
            requests.ask(number, "slow", Work.VIEW, 1)
        requests.ask("small", "slow", Work.SMALL, 1)
        requests.ask("view", "other", Work.VIEW, MOST - 20)
        await settle()
        assert set(requests.order) == {"small", "view"}
        requests.places.pop("view").leave()
        requests.ask("heavy", "other", Work.HEAVY, MOST - 20)  # nobody else has a claim
        await settle()
        assert "heavy" in requests.order
        answers.pop().resize(0)
        requests.places.pop("heavy").leave()
        await settle()
        assert 0 in requests.order
        await requests.finish()

    run(scenario)


def test_a_link_is_not_passed_for_ever_by_pictures_that_are_measured_first():
    """Pictures need no bytes before they are measured; views and pictures together fill memory."""

    async def scenario():
        admission = Admission(BUDGET, most_waiting=99)

        async def views():
            while True:
                with await admission.place(Work.VIEW, "v", lambda: 30 * UNIT):
                    await asyncio.sleep(0.001)

        async def pictures(client):
            while True:
                with await admission.place(Work.HEAVY, client, int) as place:
                    await asyncio.sleep(0)
                    await place.exchange(50 * UNIT)
                    await asyncio.sleep(0.005)

        others = [asyncio.create_task(each) for each in (views(), views(), pictures("p"))]
        others.append(asyncio.create_task(pictures("q")))
        await asyncio.sleep(0.02)
        async with asyncio.timeout(5):
            with await admission.place(Work.HEAVY, "l", lambda: 65 * UNIT):
                pass
        for each in others:
            each.cancel()
        await asyncio.gather(*others, return_exceptions=True)
        assert admission.total == 0

    run(scenario)


def test_a_client_that_asks_for_too_much_after_its_place_is_not_preferred():
    async def scenario():
        admission, order = Admission(BUDGET, most_waiting=99), []

        async def too_large(number):
            with await admission.place(Work.HEAVY, "a", int) as place:
                order.append(number)
                await place.exchange((MOST + 1) * UNIT)

        first = await admission.place(Work.HEAVY, "c", int)
        tasks = [asyncio.create_task(too_large(number)) for number in range(5)]
        await settle()
        requests = Requests(admission)
        requests.ask("other", "b")
        await settle()
        first.leave()
        await settle()
        assert len(order) == 1
        assert "other" in requests.order
        await requests.finish()
        outcomes = await asyncio.gather(*tasks, return_exceptions=True)
        assert {outcome.problem.code for outcome in outcomes} == {"memory-exceeded"}

    run(scenario)


def test_a_small_picture_waits_for_one_large_one():
    """Each is measured in its place before its bytes are known."""

    async def scenario():
        admission, order = Admission(BUDGET, most_waiting=99), []

        async def mapped(client, name, end):
            with await admission.place(Work.HEAVY, client, int, HOUR) as place:
                await asyncio.sleep(0)
                await place.exchange(40 * UNIT)
                order.append(name)
                await end

        end = asyncio.get_running_loop().create_future()
        large = [asyncio.create_task(mapped("a", number, end)) for number in range(6)]
        await settle()
        small = asyncio.create_task(mapped("b", "small", end))
        await settle()
        assert order == [0]
        end.set_result(None)
        await asyncio.gather(*large, small)
        assert order.index("small") == 1

    run(scenario)


def test_what_never_fits_is_refused_at_once():
    async def scenario():
        admission = Admission(BUDGET, most_waiting=9, process=10**6)
        with pytest.raises(ProblemError) as caught:
            await admission.place(Work.VIEW, "a", lambda: MOST * UNIT + 1)
        problem = caught.value.problem
        assert (problem.code, problem.kind.status) == ("memory-exceeded", 422)
        assert admission.refused == 1
        # with the setting that the remedy states, it fits
        (setting,) = re.findall(r"GAMUT_MEMORY_BYTES to (\d+) or more", problem.remedy)
        larger = Admission(int(setting) - 10**6, most_waiting=9)
        (await larger.place(Work.VIEW, "a", lambda: MOST * UNIT + 1)).leave()

    run(scenario)


def test_a_fault_of_one_request_that_waits_is_its_own():
    async def scenario():
        admission, broken = Admission(BUDGET, most_waiting=9), {"yes": False}

        def need():
            if broken["yes"]:
                raise OSError
            return UNIT

        requests = Requests(admission)
        requests.ask("first")
        await settle()
        task = asyncio.create_task(admission.place(Work.HEAVY, "b", need))
        requests.ask("third", "c")
        await settle()
        broken["yes"] = True
        await requests.finish()
        with pytest.raises(OSError):  # noqa: PT011 - it has no text
            await task
        assert requests.order == ["first", "third"]

    run(scenario)


def test_a_fault_at_the_end_of_the_wait_keeps_no_place():
    async def scenario():
        admission, needs = Admission(BUDGET, most_waiting=9), iter([UNIT, UNIT])
        requests = Requests(admission)
        requests.ask("first")
        await settle()
        task = asyncio.create_task(admission.place(Work.HEAVY, "b", lambda: next(needs)))
        requests.ask("third", "c", units=MOST)
        await requests.finish()
        with pytest.raises(RuntimeError):
            await task
        assert "third" in requests.order
        assert admission.total == 0

    run(scenario)
