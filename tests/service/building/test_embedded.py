import asyncio
import os
import signal

import pytest

from service.building import embedded
from service.building.embedded import EmbeddedEngine
from service.problems.problem import ProblemError
from service.settings import Settings
from service.storage.blobs import StoreUnavailableError


@pytest.fixture
def run_scenario(store, book, scripted_worker):
    """Run a coroutine function with an engine whose workers follow a script."""

    def run(scenario, *, command=scripted_worker, sole_owner=True, **settings):
        values = Settings(**{"build_timeout": 20, "drain_seconds": 0, **settings})

        async def main():
            engine = EmbeddedEngine(values, store, book, sole_owner=sole_owner, command=command)
            told = []
            engine.listen(told.append)
            await engine.start()
            try:
                return await asyncio.wait_for(scenario(engine, told), 60)
            finally:
                await asyncio.wait_for(engine.stop(), 30)

        return asyncio.run(main())

    return run


async def until(condition):
    async with asyncio.timeout(30):
        while not condition():  # noqa: ASYNC110 - the condition is about another process
            await asyncio.sleep(0.01)


def states(told, name="a"):
    found = []
    for document in told:
        if document.id == name * 64 and document.state not in found[-1:]:
            found.append(document.state)
    return found


def test_what_is_queued_is_done_and_every_change_told(run_scenario, accept, store):
    async def scenario(engine, told):
        await engine.enqueue(accept("build"))
        assert engine.document("a" * 64).state == "queued"
        await until(lambda: "succeeded" in states(told))
        assert states(told) == ["running", "succeeded"]
        assert engine.document("a" * 64) is None
        assert engine.facts().completed == 1

    run_scenario(scenario)
    assert store.content("a" * 64)[1] == b'{"gamma": 1}'


@pytest.mark.slow
def test_what_is_queued_twice_is_done_once(run_scenario, accept, scripted_worker):
    async def scenario(engine, told):
        document = accept("0.2")
        for _ in range(3):
            await engine.enqueue(document)
        assert engine.facts().queued == 1
        await until(lambda: "succeeded" in states(told))
        assert scripted_worker.begun() == 1

    run_scenario(scenario)


@pytest.mark.slow
def test_an_idle_worker_that_dies_is_replaced_at_once(run_scenario, accept):
    async def scenario(engine, told):
        await engine.enqueue(accept("build"))
        await until(lambda: "succeeded" in states(told))
        pid = next(int(document.stage.split()[1]) for document in told if document.stage)
        os.kill(pid, signal.SIGKILL)
        await until(lambda: engine.facts().warm_workers == 0)
        await until(lambda: engine.facts().warm_workers == 1)
        await engine.enqueue(accept("build", "b"))
        await until(lambda: "succeeded" in states(told, "b"))

    run_scenario(scenario)


def test_a_full_queue_refuses_at_once_for_as_long_as_a_build_takes(run_scenario, accept):
    async def scenario(engine, _told):
        for name in "abc":
            await engine.check_admission()
            await engine.enqueue(accept("hang", name))
            await until(lambda: engine.facts().running)
        with pytest.raises(ProblemError) as caught:
            await engine.check_admission()
        assert caught.value.problem.code == "queue-full"
        assert int(caught.value.problem.headers["Retry-After"]) >= 1
        facts = engine.facts()
        assert (facts.running, facts.queued, facts.capacity) == (1, 2, 2)
        await engine.cancel("c" * 64)
        await engine.check_admission()
        with pytest.raises(ProblemError):
            await engine.check_admission(arriving=1)

    run_scenario(scenario, build_queue=2)


def test_the_time_to_come_back_is_learnt_from_builds(run_scenario, accept):
    async def scenario(engine, _told):
        before = engine.retry_after()
        for name in "abcdefgh":
            await engine.enqueue(accept("build", name))
        await until(lambda: engine.facts().completed == 8)
        assert engine.retry_after() < before
        assert engine.retry_after(1000) > 100 * engine.retry_after()

    run_scenario(scenario)


def test_several_workers_build_at_the_same_time(run_scenario, accept):
    async def scenario(engine, told):
        for name in "abc":
            await engine.enqueue(accept("hang", name))
        await until(lambda: len({document.stage for document in told if document.stage}) == 3)
        assert engine.facts().running == 3

    run_scenario(scenario, build_workers=3)


@pytest.mark.slow
def test_a_poisonous_input_leaves_the_others_alone(run_scenario, accept, scripted_worker):
    async def scenario(engine, told):
        for name, text in zip("abcd", ["die", "build", "hang", "build"], strict=True):
            await engine.enqueue(accept(text, name))
        await until(lambda: "succeeded" in states(told, "d"))
        assert [states(told, name)[-1] for name in "abcd"] == [
            "failed",
            "succeeded",
            "failed",
            "succeeded",
        ]
        assert scripted_worker.begun("die") == 3

    run_scenario(scenario, build_timeout=0.5)


def test_what_is_cancelled_is_ended_and_may_come_again(run_scenario, accept, book, store):
    async def scenario(engine, told):
        await engine.enqueue(accept("hang"))
        await until(lambda: any(document.stage for document in told))
        await engine.enqueue(accept("hang", "b"))
        for name in "ab":
            book.request_cancel(name * 64)
            await engine.cancel(name * 64)
            assert engine.document(name * 64) is None
            store.drop_input(name * 64)
            await engine.enqueue(accept("build", name))
        await until(lambda: "succeeded" in states(told, "a") and "succeeded" in states(told, "b"))
        assert states(told, "b") == ["running", "succeeded"]

    run_scenario(scenario)


@pytest.mark.slow
def test_stopping_lets_what_runs_finish_and_leaves_the_rest_to_the_next(run_scenario, accept, book):
    async def scenario(engine, _told):
        await engine.enqueue(accept("0.5"))
        await engine.enqueue(accept("build", "b"))
        await until(lambda: engine.facts().running == 1)
        engine.drain()
        with pytest.raises(ProblemError) as caught:
            await engine.check_admission()
        assert caught.value.problem.code == "shutting-down"
        assert int(caught.value.problem.headers["Retry-After"]) >= 1

    run_scenario(scenario, drain_seconds=20)
    assert [book.read(name * 64).state for name in "ab"] == ["succeeded", "queued"]

    async def next_scenario(_engine, told):
        await until(lambda: "succeeded" in states(told, "b"))

    run_scenario(next_scenario)


@pytest.mark.slow
def test_what_does_not_finish_in_time_is_given_back(run_scenario, accept, book):
    pids = []

    async def scenario(engine, told):
        await engine.enqueue(accept("hang"))
        await until(lambda: any(document.stage for document in told))
        pids.append(int(told[-1].stage.split()[1]))

    run_scenario(scenario, drain_seconds=0.2)
    document = book.read("a" * 64)
    assert (document.state, document.attempts) == ("queued", 0)
    with pytest.raises(ProcessLookupError):
        os.kill(pids[0], 0)


def test_the_next_owner_of_a_store_takes_up_what_the_last_one_left(run_scenario, accept, book):
    for name in "ab":
        accept("build", name)
    book.claim("a" * 64, "killed", 1000.0)

    async def scenario(_engine, told):
        await until(lambda: "succeeded" in states(told, "a") and "succeeded" in states(told, "b"))

    run_scenario(scenario)
    assert book.read("a" * 64).attempts == 2


@pytest.mark.parametrize("error", [OSError(5, "no disk"), StoreUnavailableError("no bucket")])
def test_what_was_left_is_taken_up_when_the_store_can_be_used_again(
    run_scenario, accept, book, monkeypatch, error
):
    look, looks = book.unfinished, []

    def unfinished():
        looks.append(1)
        if len(looks) < 4:
            raise error
        return look()

    async def scenario(engine, told):
        await until(lambda: "succeeded" in states(told))
        assert engine.document("a" * 64) is None

    monkeypatch.setattr(embedded, "_RECOVERY_DELAYS", (0.0, 0.01))
    monkeypatch.setattr(book, "unfinished", unfinished)
    accept("build")
    run_scenario(scenario)
    assert len(looks) == 4


@pytest.mark.slow
def test_elsewhere_a_lease_is_waited_for(run_scenario, accept, book):
    accept("build")
    book.claim("a" * 64, "other host", 1.0)

    async def scenario(_engine, told):
        await until(lambda: "succeeded" in states(told))

    run_scenario(scenario, sole_owner=False)
    assert book.read("a" * 64).attempts == 2


def test_a_job_that_took_the_service_down_too_often_is_not_tried_again(
    run_scenario, accept, book, scripted_worker
):
    accept("build")
    for _ in range(3):
        claim = book.claim("a" * 64, "killed", 1000.0)
        document = book.requeue("a" * 64, claim.document.token)

    async def scenario(engine, told):
        await engine.enqueue(accept("build", "b"))
        await until(lambda: "succeeded" in states(told, "b"))

    run_scenario(scenario)
    assert (document.state, scripted_worker.begun()) == ("failed", 1)


@pytest.mark.slow
def test_a_worker_that_cannot_start_is_not_warm_and_costs_no_attempt(run_scenario, accept, book):
    async def scenario(engine, _told):
        await engine.enqueue(accept("build"))
        await asyncio.sleep(0.3)
        assert engine.facts().warm_workers == 0
        assert engine.document("a" * 64).state == "queued"

    run_scenario(scenario, command=("/bin/false",))
    assert book.read("a" * 64).attempts == 0
