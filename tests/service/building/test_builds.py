"""Builds from their submission to their end, by one process or by replicas that share a store."""

import asyncio
import contextlib
import hashlib
import io
import itertools
import json
import os
import resource
import select
import signal
import struct
import sys
import time
import zlib
from functools import partial
from types import SimpleNamespace

import pytest
from PIL import Image

from gamutcore import Options
from gamutcore.building import gamut_id
from service.building import local_engine, process
from service.building.builds import JOB_SECONDS
from service.building.engine import queue_full
from service.building.job_runner import Interruption, JobRunner
from service.building.process import WORKER_COMMAND
from service.problems.problem import ProblemError
from service.routes.jobs import job_description
from service.settings import Settings
from service.storage.blobs import StoreFullError, StoreUnavailableError
from service.storage.gamut_store import GamutDamagedError

pytestmark = pytest.mark.anyio

JOB, SECOND, THIRD = (letter * 64 for letter in "abc")
OPTIONS = {"gamma": 1}
CONTENT = b'{"gamma": 1}'
PATIENCE = 600.0


async def until(condition):
    """Wait until a condition holds, as long as a replica lives at most."""
    while not condition():  # noqa: ASYNC110 - the condition is about another process
        await asyncio.sleep(0.01)


async def begun(builds, job_id=JOB):
    """Wait until a build is under way, and return the id of its process."""
    while not (stage := (await builds.job(job_id)).stage):  # noqa: ASYNC110 - another process
        await asyncio.sleep(0.01)
    return int(stage.split()[1])


def builders(tmp_path):
    """The processes of the builds that were begun, in their order."""
    return [int(line.split()[0]) for line in (tmp_path / "begun").read_text().splitlines()]


async def built(builds, text, job_id=JOB):
    """The end of a job whose input is a text."""
    await builds.submit(job_id, OPTIONS, text.encode())
    return await builds.wait(job_id, PATIENCE)


def is_gone(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return True
    return False


def failing(error, times=1000, *, function=None):
    """A function that fails some times."""
    left = iter(range(times))

    def fails(*arguments):
        if next(left, None) is not None:
            raise error
        return function(*arguments)

    return fails


async def test_a_job_is_durable_before_it_is_accepted_and_waited_for(
    replica, book, store, scripted_worker, reports
):
    async with replica() as builds:
        job = await builds.submit(JOB, OPTIONS, b"gate")
        assert book.read(JOB).options == OPTIONS
        assert store.input_options(JOB) == OPTIONS
        assert not job.final
        assert not (await builds.wait(JOB, 0.0)).final
        await begun(builds)
        assert (await builds.job(JOB)).fraction == 0.5
        scripted_worker.open()
        ended = await builds.wait(JOB, PATIENCE)
        assert (ended.state, ended.attempts) == ("succeeded", 1)
        assert (await builds.submit(JOB, OPTIONS, b"gate")).sha256
        assert builds.facts().completed == 1
    assert store.content(JOB)[1] == CONTENT
    ((word, seconds),) = reports
    assert (word, seconds["metric"]) == ("succeeded", 0.25)


@pytest.mark.parametrize("replicas", [1, 3])
async def test_200_identical_requests_are_one_build(replica, scripted_worker, replicas):
    async with contextlib.AsyncExitStack() as stack:
        each = [await stack.enter_async_context(replica(build_queue=1)) for _ in range(replicas)]
        requests = list(itertools.islice(itertools.cycle(each), 200))
        jobs = await asyncio.gather(*(one.submit(JOB, OPTIONS, b"gate") for one in requests))
        assert {job.id for job in jobs} == {JOB}
        scripted_worker.open()
        ended = await asyncio.gather(*(one.wait(JOB, PATIENCE) for one in requests))
        assert {job.state for job in ended} == {"succeeded"}
    assert scripted_worker.begun() == 1


async def test_who_submitted_may_leave(replica, scripted_worker):
    async with replica() as builds:
        first = asyncio.create_task(builds.submit(JOB, OPTIONS, b"gate"))
        await asyncio.sleep(0)
        first.cancel()
        assert (await builds.submit(JOB, OPTIONS, b"gate")).id == JOB
        waiting = asyncio.create_task(builds.wait(JOB, PATIENCE))
        await begun(builds)
        waiting.cancel()
        scripted_worker.open()
        assert (await builds.wait(JOB, PATIENCE)).state == "succeeded"


async def test_changes_are_followed_to_the_end_here_and_elsewhere(replica, scripted_worker):
    async with replica() as one, replica() as other:
        await one.submit(JOB, OPTIONS, b"gate")

        async def followed(builds, found):
            async for job in builds.changes(JOB, PATIENCE):
                if job is not None:
                    found.append(job)

        here, elsewhere = [], []
        following = asyncio.gather(followed(one, here), followed(other, elsewhere))
        await until(lambda: any(job.stage for job in here) and elsewhere)
        scripted_worker.open()
        await following
        for jobs in (here, elsewhere):
            assert jobs[-1].state == "succeeded"
            assert all(not job.final for job in jobs[:-1])
            assert all(job != after for job, after in itertools.pairwise(jobs))


async def test_silence_is_broken_by_signs_of_life(replica):
    async with replica() as builds:
        await builds.submit(JOB, OPTIONS, b"hang")
        await begun(builds)
        changes = builds.changes(JOB, 0.05)
        assert await anext(changes) is not None
        silence = 0
        while silence < 2:
            silence += await anext(changes) is None
        await changes.aclose()


@pytest.mark.parametrize("where", ["here", "elsewhere"])
async def test_a_cancelled_build_ends_for_all_who_wait(replica, store, reports, where):
    async with replica() as one, replica() as other:
        await one.submit(JOB, OPTIONS, b"hang")
        pid = await begun(one)
        waiting = asyncio.create_task(one.wait(JOB, PATIENCE))
        job = await (one if where == "here" else other).cancel(JOB)
        assert job.state == "cancelled"
        assert (await waiting).problem["code"] == "build-cancelled"
        assert not store.input_kept(JOB)
        await until(lambda: reports)
        assert reports[0][0] == "cancelled"
        assert is_gone(pid)
        again = await other.submit(JOB, OPTIONS, b"build")
        assert (again.state, again.attempts) == ("queued", 0)
        assert (await other.wait(JOB, PATIENCE)).state == "succeeded"
        assert (await other.cancel(JOB)).state == "succeeded"
        assert await other.cancel(THIRD) is None


async def test_what_waits_here_and_is_cancelled_elsewhere_is_known_here(replica, book):
    async with replica() as one, replica(build_workers=2) as other:
        await one.submit(SECOND, OPTIONS, b"hang")
        await begun(one, SECOND)
        await one.submit(JOB, OPTIONS, b"build")
        waiting = asyncio.create_task(one.wait(JOB, PATIENCE))
        await other.cancel(JOB)
        assert (await waiting).state == (await one.job(JOB)).state == "cancelled"
        await other.submit(THIRD, OPTIONS, b"hang")
        await begun(other, THIRD)
        assert book.read(SECOND).owner != book.read(THIRD).owner


async def test_what_is_cancelled_may_come_again_whether_it_ran_or_waited(replica, scripted_worker):
    async with replica(sole_owner=True) as builds:
        for name in (JOB, SECOND):
            await builds.submit(name, OPTIONS, b"hang")
            await begun(builds, JOB)
        for name in (JOB, SECOND):
            await builds.cancel(name)
            await builds.submit(name, OPTIONS, b"build")
        for name in (JOB, SECOND):
            assert (await builds.wait(name, PATIENCE)).state == "succeeded"
    assert (scripted_worker.begun("hang"), scripted_worker.begun("build")) == (1, 2)


async def test_a_damaged_gamut_is_built_again_from_its_input(
    replica, store, tmp_path, scripted_worker
):
    async with replica() as builds:
        await built(builds, "build")
        (history,) = (tmp_path / "store" / "published").rglob("*.gamut")
        good = history.read_bytes()
        history.write_bytes(good[::-1])
        with pytest.raises(GamutDamagedError) as caught:
            store.content(JOB)
        assert caught.value.input_kept
        jobs = await asyncio.gather(*(builds.rebuild(JOB) for _ in range(5)))
        assert {job.id for job in jobs} == {JOB}
        await builds.wait(JOB, PATIENCE)
        assert store.content(JOB)[1] == good
        assert await builds.rebuild(JOB) is None
        assert await builds.rebuild(SECOND) is None
    assert scripted_worker.begun() == 2


@pytest.mark.parametrize(
    ("options", "option", "remedy"),
    [
        ({"space": "Oklab", "scale": 100.0}, "scale", "Post the data again without scale"),
        ({"space": "Oklab", "gamma": 7}, "gamma", "Post the data again with options"),
        ({"left_out": 1}, "left_out", "Post the data again with options"),
    ],
)
async def test_a_damaged_gamut_whose_options_are_refused_is_not_built_in_vain(
    replica, store, options, option, remedy
):
    store.keep_input(JOB, CONTENT, options)
    async with replica() as builds:
        for _ in range(2):
            with pytest.raises(ProblemError) as caught:
                await builds.rebuild(JOB)
            problem = caught.value.problem
            assert problem.document()["status"] == 404
            assert (problem.code, problem.where["option"]) == ("gamut-not-found", option)
            assert problem.remedy.startswith(remedy)
        assert await builds.job(JOB) is None


@pytest.mark.parametrize("when", ["before the start", "after it"])
async def test_a_job_whose_document_is_damaged_is_built_from_its_input(
    replica, store, book, accept, tmp_path, when
):
    def damage():
        (path,) = (tmp_path / "store" / "jobs").rglob("*.job")
        path.write_bytes(path.read_bytes()[:-3])

    accept("build")
    if when == "before the start":
        damage()
    else:
        book.request_cancel(JOB)  # so that the start finds nothing to do
    async with replica() as builds:
        if when == "after it":
            await builds._engine._recovery
            damage()
            assert (await builds.job(JOB)).state == "queued"
        assert (await builds.wait(JOB, PATIENCE)).state == "succeeded"
    assert store.corruptions == 1
    assert store.is_stored(JOB)
    damage()
    async with replica() as builds:
        assert await builds.job(JOB) is None


async def test_the_queue_is_bounded_however_many_come_at_once_and_only_for_what_is_new(
    replica, book
):
    async with replica(build_queue=4) as builds:
        await builds.submit(JOB, OPTIONS, b"hang")
        await begun(builds)
        names = [f"{number:064x}" for number in range(40)]
        answers = await asyncio.gather(
            *(builds.submit(name, OPTIONS, b"hang") for name in names), return_exceptions=True
        )
        refused = [
            name
            for name, answer in zip(names, answers, strict=True)
            if isinstance(answer, ProblemError) and answer.problem.code == "queue-full"
        ]
        assert len(refused) == 36
        assert builds.facts().queued == 4
        for name in names:
            if name in refused:
                assert book.read(name) is None
            else:
                assert (await builds.submit(name, OPTIONS, b"hang")).state == "queued"


@pytest.mark.parametrize(("estimate", "told"), [(0, "1"), (7, "7"), (10**6, "600")])
def test_a_full_queue_says_when_to_come_back_within_reason(estimate, told):
    problem = queue_full(16, estimate).problem
    assert (problem.code, problem.headers) == ("queue-full", {"Retry-After": told})
    assert "16" in problem.detail


async def test_the_time_to_come_back_is_learnt_from_builds(replica, clock, monkeypatch):
    # builds that take no time
    monkeypatch.setattr(local_engine, "time", SimpleNamespace(monotonic=clock, time=clock))
    async with replica() as builds:
        before = builds.facts().retry_after
        for name in "abcdefgh":
            await builds.submit(name * 64, OPTIONS, b"build")
        await until(lambda: builds.facts().completed == 8)
        assert builds.facts().retry_after < before


async def test_the_queue_of_one_client_delays_others_by_one_build(
    replica, book, scripted_worker, clock, monkeypatch
):
    """Also after a restart; clients come and go, and none is left behind."""

    def job_id(client, number):
        return hashlib.sha256(f"{client} {number}".encode()).hexdigest()

    async def post(builds, client, count):
        for number in range(count):
            name = job_id(client, number)
            await builds.submit(name, OPTIONS, b"gate", client=f"address {client}")
            names[name] = client

    names = {}
    monkeypatch.setattr(book, "_clock", partial(next, itertools.count(clock.seconds, 0.002)))
    async with replica(sole_owner=True) as builds:
        await post(builds, "busy", 4)
        await begun(builds, job_id("busy", 0))
        await post(builds, "late", 2)
        assert "late" not in job_description(book.read(job_id("late", 0))).model_dump_json()
    async with replica(sole_owner=True) as builds:
        await until(lambda: builds.facts().running)
        await post(builds, "later", 1)
        scripted_worker.open()
        ended = [await builds.wait(name, PATIENCE) for name in names]
    turns = [names[job.id] for job in sorted(ended, key=lambda job: job.finished)]
    assert turns.count("busy") == 4
    assert turns[:5].count("busy") == 2
    assert set(turns[:3]) == {"busy", "late", "later"}


async def test_the_age_of_the_oldest_waiting_build_is_known(
    replica, scripted_worker, clock, monkeypatch
):
    later = SimpleNamespace(time=lambda: clock.seconds + 100, monotonic=time.monotonic)
    monkeypatch.setattr(local_engine, "time", later)
    async with replica() as builds:
        await builds.submit(JOB, OPTIONS, b"gate")
        await begun(builds, JOB)
        assert builds.facts().oldest == 0
        for name in (SECOND, THIRD):
            await builds.submit(name, OPTIONS, b"build")
            clock.seconds += 10
        assert builds.facts().oldest == pytest.approx(120, abs=0.01)
        scripted_worker.open()
        await until(lambda: builds.facts().completed == 3)
        assert builds.facts().oldest == 0


async def test_several_workers_build_at_the_same_time(replica):
    async with replica(build_workers=3) as builds:
        for name in (JOB, SECOND, THIRD):
            await builds.submit(name, OPTIONS, b"hang")
        assert len({await begun(builds, name) for name in (JOB, SECOND, THIRD)}) == 3
        assert builds.facts().running == 3


@pytest.mark.parametrize(
    ("error", "code"),
    [(StoreFullError(), "storage-full"), (StoreUnavailableError(), "build-input-lost")],
)
async def test_an_input_that_cannot_be_stored_is_no_job(
    replica, store, book, monkeypatch, error, code
):
    async with replica() as builds:
        with monkeypatch.context() as patch:
            patch.setattr(store, "keep_input", failing(error))
            with pytest.raises(type(error)):
                await builds.submit(JOB, OPTIONS, b"build")
        assert book.read(JOB).problem["code"] == code
        assert (await built(builds, "build")).state == "succeeded"


@pytest.mark.parametrize(
    ("text", "code", "attempts", "processes", "detail"),
    [
        ("refuse", "missing-column", 1, 1, "M."),
        ("full", "storage-full", 1, 1, ""),
        ("defect", "build-failed", 1, 1, ""),
        ("misdescribe", "build-failed", 1, 1, ""),
        ("exhaust", "build-out-of-memory", 1, 1, "268435456 bytes"),
        ("hang", "build-timeout", 1, 2, "120 s"),
        ("hang, stopped", "build-timeout", 1, 2, "120 s"),
        ("die", "build-crashed", 3, 4, "exit status 3"),
        ("garble", "build-crashed", 3, 4, "unreadable"),
    ],
)
async def test_what_happens_to_a_build_is_a_problem_and_the_next_is_built(
    replica, store, book, scripted_worker, reports, clock, text, code, attempts, processes, detail
):
    """A process ends only if it must, and an input that kills it is given up after three."""
    word, _, stopped = text.partition(", ")
    async with replica(build_memory_bytes=256 << 20) as builds:
        await builds.submit(JOB, OPTIONS, word.encode())
        if word == "hang":
            pid = await begun(builds)
            if stopped:
                os.kill(pid, signal.SIGSTOP)
            clock.seconds += 119
            await until(lambda: book.read(JOB).lease_until > clock.seconds)
            assert not is_gone(pid)
            clock.seconds += 2
        job = await builds.wait(JOB, PATIENCE)
        assert (job.state, job.problem["code"], job.attempts) == ("failed", code, attempts)
        assert detail in job.problem["detail"]
        if word == "refuse":
            assert (job.problem["where"], job.problem["remedy"]) == ({"column": "L"}, ".")
        assert store.input_kept(JOB) == (code in {"storage-full", "build-crashed"})
        assert scripted_worker.begun(word) == attempts
        assert (await built(builds, "build", SECOND)).state == "succeeded"
        assert builds.facts().worker_starts == processes
        if word == "hang":
            assert is_gone(pid)
    crashes = ["crashed"] * attempts if attempts > 1 else []
    assert [word for word, _ in reports] == [*crashes, code, "succeeded"]


@pytest.mark.slow
async def test_a_build_that_fills_the_memory_is_ended_at_the_first_look_that_finds_it(
    replica, monkeypatch
):
    """Between two looks, one wait of at most 50 ms: the growth in it is all that is exceeded."""
    usual, events = process.private_bytes, []

    def look(pid):
        events.append((pid, usual(pid)))
        return events[-1][1]

    def poll():
        made = select.poll()

        def wait(milliseconds):
            assert 0 < milliseconds <= 50
            events.append(("wait", milliseconds))
            return made.poll(milliseconds)

        return SimpleNamespace(register=made.register, poll=wait)

    monkeypatch.setattr(process, "private_bytes", look)
    names = {"POLLIN": select.POLLIN, "POLLOUT": select.POLLOUT}
    monkeypatch.setattr(process, "select", SimpleNamespace(poll=poll, **names))
    limit = 256 << 20
    async with replica(build_memory_bytes=limit) as builds:
        await builds.submit(SECOND, OPTIONS, b"build")
        await builds.wait(SECOND, PATIENCE)
        events.clear()
        job = await built(builds, "swell")
        assert job.problem["code"] == "build-out-of-memory"
    worker = events[0][0]
    ended = max(place for place, event in enumerate(events) if event[0] == worker)
    *earlier, last = [nbytes for pid, nbytes in events[: ended + 1] if pid == worker]
    assert max(earlier) <= limit < last
    assert all(
        worker in {one[0], other[0]} for one, other in itertools.pairwise(events[: ended + 1])
    )


@pytest.mark.parametrize("kills", [2, 3])
@pytest.mark.slow
async def test_a_build_is_repeated_until_its_process_is_left_alone(
    replica, store, scripted_worker, kills
):
    victims = set()
    async with replica() as builds:
        await builds.submit(JOB, OPTIONS, b"gate")
        while len(victims) < kills:
            pid = await begun(builds)
            if pid not in victims:
                os.kill(pid, signal.SIGKILL)
                victims.add(pid)
            await asyncio.sleep(0.01)
        scripted_worker.open()
        job = await builds.wait(JOB, PATIENCE)
    assert job.attempts == 3
    if kills == 2:
        assert (job.state, store.content(JOB)[1]) == ("succeeded", CONTENT)
    else:
        assert "signal 9" in job.problem["detail"]


async def test_an_idle_worker_that_dies_is_replaced_at_once(replica, tmp_path):
    async with replica() as builds:
        await built(builds, "build")
        (worker,) = builders(tmp_path)
        os.kill(worker, signal.SIGKILL)
        await until(lambda: builds.facts().warm_workers == 0)
        await until(lambda: builds.facts().warm_workers == 1)
        assert (await built(builds, "build", SECOND)).state == "succeeded"


async def test_a_process_that_stays_large_is_replaced(replica, tmp_path, monkeypatch):
    """Large is more than half of the limit above what it had when it was idle."""
    limit, idle = 256 << 20, set()
    grown = limit // 2

    def in_use(pid):
        if pid in idle:
            return grown
        idle.add(pid)
        return 0

    monkeypatch.setattr(process, "private_bytes", in_use)
    async with replica(build_memory_bytes=limit) as builds:
        await built(builds, "build")
        grown += 1
        await built(builds, "build", SECOND)
        await built(builds, "build", THIRD)
    first, second, third = builders(tmp_path)
    assert first == second != third
    assert is_gone(first)


async def test_a_build_that_ends_too_late_leaves_the_input_to_the_job_that_came_after_it(
    replica, book, monkeypatch, scripted_worker
):
    heartbeat, late = book.heartbeat, []

    def too_late(claim, *progress):
        if not late:
            late.append(claim)
            book.request_cancel(JOB)
            assert book.accept(JOB, OPTIONS)[1]
        return heartbeat(claim, *progress)

    monkeypatch.setattr(book, "heartbeat", too_late)
    async with replica() as builds:
        await builds.submit(JOB, OPTIONS, b"refuse")
        await until(lambda: (job := book.read(JOB)).final and job.token > late[0].document.token)
    assert book.read(JOB).problem["code"] == "missing-column"
    assert scripted_worker.begun() == 2


@pytest.mark.slow
async def test_a_claim_is_renewed_and_progress_stored_although_the_store_fails_for_a_while(
    replica, book, clock, monkeypatch, scripted_worker
):
    renew = failing(
        StoreUnavailableError(),
        1,
        function=failing(OSError(28, "full"), 1, function=book.heartbeat),
    )
    monkeypatch.setattr(book, "heartbeat", renew)
    async with replica(build_timeout=10_000) as builds:
        await builds.submit(JOB, OPTIONS, b"gate")
        await begun(builds)
        await until(lambda: book.read(JOB).fraction == 0.5)
        for _ in range(5):
            clock.seconds = book.read(JOB).lease_until - 1
            await until(lambda: book.read(JOB).lease_until > clock.seconds + 10)
            assert book.claim(JOB, "other", 10.0) is None
        scripted_worker.open()
        job = await builds.wait(JOB, PATIENCE)
        assert (job.state, job.attempts) == ("succeeded", 1)


async def test_who_lost_a_lease_changes_nothing(
    replica, book, clock, monkeypatch, scripted_worker, reports
):
    heartbeat, late = book.heartbeat, []

    def refuses_the_first(claim, *progress):
        if claim.document.attempts == 1:
            raise StoreUnavailableError
        return heartbeat(claim, *progress)

    async with replica(build_timeout=10_000) as one, replica(build_timeout=10_000) as other:
        with monkeypatch.context() as patch:
            patch.setattr(book, "heartbeat", refuses_the_first)
            await one.submit(JOB, OPTIONS, b"gate")
            late.append(await begun(one))
            clock.seconds += 1000
            await other.submit(JOB, OPTIONS, b"gate")
            await until(lambda: book.read(JOB).attempts == 2)
            owner = book.read(JOB).owner
        await until(lambda: is_gone(late[0]))
        assert book.read(JOB).owner == owner
        scripted_worker.open()
        job = await other.wait(JOB, PATIENCE)
        assert (job.state, job.attempts) == ("succeeded", 2)
    assert [word for word, _ in reports] == ["succeeded"]


@pytest.mark.parametrize(
    ("method", "times", "error", "code"),
    [
        ("is_stored", 1000, OSError(5, "a bad disk"), "store-unavailable"),
        ("input_path", 1000, RuntimeError("a defect"), "build-failed"),
        ("publish", 1000, RuntimeError("a defect"), "build-failed"),
        ("publish", 1000, OSError(28, "No space left on device"), "storage-full"),
        ("publish", 1000, StoreFullError(), "storage-full"),
        ("input_path", 1000, OSError(24, "Too many open files"), "overloaded"),
        ("publish", 1000, StoreUnavailableError(), "store-unavailable"),
        ("publish", 1, StoreUnavailableError(), None),
    ],
)
async def test_a_fault_costs_one_build_which_can_be_asked_for_again(
    replica, store, monkeypatch, caplog, method, times, error, code
):
    async with replica() as builds:
        with monkeypatch.context() as patch:
            patch.setattr(store, method, failing(error, times, function=getattr(store, method)))
            job = await built(builds, "build")
        assert (job.problem or {}).get("code") == code
        unavailable = isinstance(error, StoreUnavailableError)
        assert job.attempts == (min(times + 1, 3) if unavailable else 1)
        # Only a defect needs a traceback; what an operator mends costs nobody the data.
        told = [record for record in caplog.records if record.levelname in {"WARNING", "ERROR"}]
        assert any(record.exc_info for record in told) == (code == "build-failed")
        assert store.input_kept(JOB) == (code != "build-failed")
        if code is not None:
            assert (await built(builds, "build")).state == "succeeded"


async def test_an_end_that_cannot_be_written_down_is_told_to_those_who_wait(
    replica, store, book, monkeypatch, scripted_worker
):
    async with replica() as builds:
        await builds.submit(JOB, OPTIONS, b"gate")
        waiting = asyncio.create_task(builds.wait(JOB, PATIENCE))
        await begun(builds)
        full = failing(OSError(28, "No space left on device"))
        monkeypatch.setattr(store, "publish", full)
        monkeypatch.setattr(book, "finish", full)
        scripted_worker.open()
        assert (await waiting).problem["code"] == "storage-full"


@pytest.mark.slow
async def test_what_was_accepted_survives_the_process(replica, scripted_worker):
    async with replica() as builds:
        for name in (JOB, SECOND, THIRD):
            await builds.submit(name, OPTIONS, b"gate")
        await begun(builds)
        waiting = asyncio.create_task(builds.wait(THIRD, PATIENCE))
        followed = asyncio.create_task(anext(builds.changes(THIRD, PATIENCE)))
        await until(lambda: len(builds._subscriptions.get(THIRD, ())) == 2)
        builds.drain()
        assert (await waiting).state == (await followed).state == "queued"
        with pytest.raises(ProblemError) as caught:
            await builds.submit("d" * 64, OPTIONS, b"build")
        assert caught.value.problem.code == "shutting-down"
        assert int(caught.value.problem.headers["Retry-After"]) >= 1
        with pytest.raises(ProblemError, match=caught.value.problem.detail):
            await builds.check_admission()
    scripted_worker.open()
    async with replica(sole_owner=True) as builds:
        for name in (JOB, SECOND, THIRD):
            assert (await builds.wait(name, PATIENCE)).state == "succeeded"


@pytest.mark.parametrize("patient", [True, False])
async def test_stopping_lets_what_runs_finish_in_time_and_gives_the_rest_back(
    replica, book, scripted_worker, patient
):
    async with replica(drain_seconds=PATIENCE if patient else 0) as builds:
        await builds.submit(JOB, OPTIONS, b"gate")
        await builds.submit(SECOND, OPTIONS, b"build")
        pid = await begun(builds)
        builds.drain()
        if patient:
            scripted_worker.open()
    assert is_gone(pid)
    # What is given back was no attempt.
    ended = ("succeeded", 1) if patient else ("queued", 0)
    assert (book.read(JOB).state, book.read(JOB).attempts) == ended
    assert (book.read(SECOND).state, book.read(SECOND).attempts) == ("queued", 0)


async def test_the_next_owner_of_a_store_takes_up_what_the_last_one_left(
    replica, accept, book, store, scripted_worker
):
    """What killed its owner too often is not tried again, nor what has lost its input."""
    poison, lost = "d" * 64, "e" * 64
    for name in "abcde":
        accept("build", name)
    for _ in range(3):
        book.requeue(poison, book.claim(poison, "killed", 1000.0).document.token)
    book.claim(JOB, "killed", 1000.0)
    store.drop_input(lost)
    async with replica(sole_owner=True) as builds:
        ended = [await builds.wait(name * 64, PATIENCE) for name in "abcde"]
    assert [job.state for job in ended] == ["succeeded"] * 3 + ["failed"] * 2
    assert [job.attempts for job in ended] == [2, 1, 1, 3, 1]
    assert ended[4].problem["code"] == "build-input-lost"
    assert scripted_worker.begun() == 3


async def test_what_is_stored_by_then_is_not_built_again(replica, accept, scripted_worker, reports):
    async with replica() as builds:
        await built(builds, "build")
    accept("die")
    async with replica() as builds:
        assert (await builds.wait(JOB, PATIENCE)).state == "succeeded"
        assert builds.facts().completed == 0
    assert scripted_worker.begun() == len(reports) == 1


@pytest.mark.parametrize("error", [OSError(5, "no disk"), StoreUnavailableError("no bucket")])
async def test_what_was_left_is_taken_up_when_the_store_can_be_used_again(
    replica, accept, book, monkeypatch, error
):
    monkeypatch.setattr(local_engine, "_RECOVERY_DELAYS", (0.0, 0.01))
    monkeypatch.setattr(book, "unfinished", failing(error, 3, function=book.unfinished))
    accept("build")
    async with replica(sole_owner=True) as builds:
        assert (await builds.wait(JOB, PATIENCE)).state == "succeeded"


@pytest.mark.slow
async def test_elsewhere_a_lease_is_waited_for(replica, accept, book, clock, monkeypatch):
    accept("build")
    book.claim(JOB, "other host", 1.0)
    claim, refused = book.claim, []

    def claim_and_note(*arguments):
        claimed = claim(*arguments)
        refused.append(claimed is None)
        return claimed

    async with replica() as builds:
        await builds._engine._recovery  # it ends while it waits
    monkeypatch.setattr(book, "claim", claim_and_note)
    async with replica() as builds:
        await until(lambda: refused)
        clock.seconds += 2
        job = await builds.wait(JOB, PATIENCE)
    assert refused[0]
    assert (job.state, job.attempts) == ("succeeded", 2)


@pytest.mark.parametrize(
    "command",
    [
        ("/bin/false",),
        ("/no/such/program",),
        (sys.executable, "-S", "-c", "print('hello', flush=True)"),
        (sys.executable, "-S", "-c", "print(1)"),
        ("/bin/sleep", "1000"),
    ],
)
async def test_a_worker_that_cannot_start_is_not_warm_and_costs_no_attempt(
    replica, book, caplog, command
):
    async with replica(command=command) as builds:
        await builds.submit(JOB, OPTIONS, b"build")
        if command[0] != "/bin/sleep":
            await until(lambda: "build worker did not start" in caplog.text)
        assert builds.facts().warm_workers == 0
        assert (await builds.job(JOB)).state == "queued"
    assert book.read(JOB).attempts == 0


async def test_finished_jobs_are_paged_and_forgotten_with_inputs_nobody_needs(
    replica, accept, store, book, clock
):
    for name in "abc":
        accept("build", name)
    book.request_cancel(SECOND)
    async with replica(sole_owner=True) as builds:
        for name in (JOB, THIRD):
            await builds.wait(name, PATIENCE)
        assert [job.id for job in await builds.page("", 9)] == [JOB, SECOND, THIRD]
        assert [job.id for job in await builds.page(JOB, 1)] == [SECOND]
        assert builds.retry_after(book.read(SECOND)) >= 1
    # It is to be built again, by whoever asks for it next.
    store.set_aside(store.record(JOB), "a test")
    clock.seconds += JOB_SECONDS + 10
    async with replica() as builds:
        await until(lambda: not book.page("", 9))
        await until(lambda: not store.input_kept(SECOND))
        assert await builds.job(JOB) is None
        assert await builds.wait(JOB, 1.0) is None
    assert [store.input_kept(name) for name in (JOB, SECOND, THIRD)] == [True, False, True]


async def test_the_input_of_a_forgotten_job_stays_for_one_that_came_after_it(
    replica, accept, store, book, monkeypatch, clock
):
    for name in "bc":
        accept("hang", name)
        book.request_cancel(name * 64)
    clock.seconds += JOB_SECONDS + 10
    forget = book.forget_finished

    def forget_and_ask_again(older_than):
        forgotten = forget(older_than)
        if forgotten:
            book.accept(SECOND, OPTIONS)
        return forgotten

    monkeypatch.setattr(book, "forget_finished", forget_and_ask_again)
    async with replica():
        # the inputs are looked at in this order
        await until(lambda: not store.input_kept(THIRD))
    assert store.input_kept(SECOND)


@pytest.fixture
def many_open_files():
    """Have descriptors of up to three digits, and some more, in use, as by as many connections."""
    limits = resource.getrlimit(resource.RLIMIT_NOFILE)
    if 0 <= limits[1] < 1200:
        pytest.skip("the system does not let as many files be open")
    resource.setrlimit(resource.RLIMIT_NOFILE, (limits[1], limits[1]))
    with contextlib.ExitStack() as stack:
        while (descriptor := os.open(os.devnull, os.O_RDONLY)) < 1100:
            stack.callback(os.close, descriptor)
        stack.callback(os.close, descriptor)
        yield
    resource.setrlimit(resource.RLIMIT_NOFILE, limits)


@pytest.mark.usefixtures("many_open_files")
async def test_a_process_is_spoken_to_however_many_files_are_open(replica):
    async with replica() as builds:
        assert (await built(builds, "build")).state == "succeeded"


def blank_picture(file_format, **options):
    """Return 16 megapixels of one colour in a small file."""
    stream = io.BytesIO()
    Image.new("RGB", (4000, 4000), (120, 40, 200)).save(stream, file_format, **options)
    return stream.getvalue()


def with_png_size(data, size):
    """Return a PNG file whose header states another size."""
    header = data[12:16] + struct.pack(">II", *size) + data[24:29]
    return data[:12] + header + struct.pack(">I", zlib.crc32(header)) + data[33:]


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells what is in use")
async def test_real_builds_are_bounded_by_the_header_of_a_picture_and_by_the_memory_limit(
    replica, sphere, reports
):
    png = blank_picture("PNG")
    cases = [
        # The header states 10.8 GB, which are refused before anything is decoded.
        (with_png_size(png, (60_000, 60_000)), "picture-too-large"),
        # Decoded some rows at a time.
        (png, "too-few-points"),
        # OpenJPEG decodes the whole picture, with 32 bits per sample.
        (blank_picture("JPEG2000"), "build-out-of-memory"),
        # The coefficients of all scans are in memory.
        (blank_picture("JPEG", progressive=True, subsampling=0), "build-out-of-memory"),
        (json.dumps({"samples": sphere()}).encode(), None),
    ]
    limit = 256 << 20
    async with replica(command=WORKER_COMMAND, build_memory_bytes=limit) as builds:
        for data, code in cases:
            assert len(data) < 300_000
            job_id = gamut_id(Options(), hashlib.sha256(data).hexdigest())
            await builds.submit(job_id, Options().to_mapping(), data)
            job = await builds.wait(job_id, PATIENCE)
            assert job.attempts == 1
            assert (job.problem or {}).get("code") == code
    assert reports[-1][1]["metric"] > 0


@pytest.mark.slow
async def test_a_decoder_that_takes_too_long_costs_one_build_and_one_process(replica, sphere):
    """A PNG of 0.4 MB with 400 MB of texts, where no time is allowed."""

    def chunk(name, content):
        size, check = struct.pack(">I", len(content)), zlib.crc32(name + content)
        return size + name + content + struct.pack(">I", check)

    small = blank_picture("PNG")
    text = chunk(b"zTXt", b"a\0\0" + zlib.compress(bytes(4_000_000), 9))
    hostile = small[:33] + 100 * text + small[33:]
    hurried = (
        "from gamutcore.characterisation.pictures import raster\n"
        "raster.OPENING_SECONDS = raster.DECODING_SECONDS = raster.SECONDS_PER_MEGAPIXEL = 0\n"
        "raster._TICK = 0.001\n"
        "from service.building.worker import main; main()"
    )
    async with replica(command=(sys.executable, "-c", hurried)) as builds:
        codes = []
        for data in (hostile, json.dumps({"samples": sphere()}).encode()):
            job_id = gamut_id(Options(), hashlib.sha256(data).hexdigest())
            await builds.submit(job_id, Options().to_mapping(), data)
            job = await builds.wait(job_id, PATIENCE)
            codes.append((job.state, (job.problem or {}).get("code"), job.attempts))
        assert codes == [("failed", "picture-too-complex", 1), ("succeeded", None, 1)]
        assert builds.facts().worker_starts == 2


def test_a_runner_takes_what_it_can_claim_and_may_be_stopped_while_it_starts(
    store, book, accept, scripted_worker
):
    """As `gamut worker` uses it, in a thread for each build."""
    runner = JobRunner(Settings(), store, book, command=scripted_worker)
    assert runner.run(JOB).document is None
    accept("build")
    assert runner.run(JOB).state == "succeeded"
    runner.close()
    interruption = Interruption()
    interruption.release()
    sleeping = JobRunner(Settings(), store, book, command=("/bin/sleep", "1000"))
    assert sleeping.run(SECOND, interruption).state == "released"
