"""The engine of a replica that builds nothing, against a real Redis that comes and goes."""

import asyncio
from types import SimpleNamespace

import pytest

from service.broker import celery_engine
from service.broker.celery_app import Broker, celery_app
from service.broker.celery_engine import CeleryEngine
from service.broker.outbox import Outbox
from service.building.builds import Builds
from service.jobs.book import JobBook
from service.problems.problem import ProblemError
from service.settings import Settings
from service.storage.gamuts import GamutStore
from service.storage.local import LocalBlobs

JOBS = [letter * 64 for letter in "abc"]


@pytest.fixture
def run_scenario(tmp_path, cluster, patient):  # noqa: ARG001
    """Run a coroutine with an engine, its book, and a broker to look into; all are new."""

    def run(scenario, **values):
        chosen = Settings(
            store="s3://bucket/prefix", broker=cluster.environment["GAMUT_BROKER"], **values
        )
        store = GamutStore(LocalBlobs(tmp_path / "store"))
        store.open()
        book = JobBook(store.blobs)
        broker = Broker(celery_app(chosen))
        cluster.flush()

        async def main():
            engine = CeleryEngine(chosen, store, book)
            await engine.start()
            try:
                await asyncio.wait_for(scenario(engine, book, broker), 600)
            finally:
                await engine.stop()

        try:
            asyncio.run(main())
        finally:
            broker.close()
            store.close()

    return run


async def code_of(engine):
    with pytest.raises(ProblemError) as caught:
        await engine.check_admission()
    assert int(caught.value.problem.headers["Retry-After"]) > 0
    return caught.value.problem.code


def accepted(book, job_id):
    return book.accept(job_id, {})[0]


def test_a_job_is_marked_and_sent(run_scenario, tmp_path):
    async def scenario(engine, book, broker):
        await engine.enqueue(accepted(book, JOBS[0]))
        assert broker.waiting() == 1
        assert (tmp_path / "store" / "pending" / "aa" / JOBS[0]).exists()
        assert engine.document(JOBS[0]) is None

    run_scenario(scenario)


def test_a_job_of_another_replica_is_sent_if_that_has_died_before_it_could(run_scenario):
    async def scenario(engine, book, broker):
        document = accepted(book, JOBS[0])
        await engine.enqueue(document, joined=True)
        assert broker.waiting() == 1
        await engine.enqueue(document, joined=True)
        assert broker.waiting() == 1

    run_scenario(scenario)


def test_the_queue_is_bounded_whoever_filled_it(run_scenario):
    async def scenario(engine, book, broker):
        await engine.check_admission()
        broker.send(JOBS[0])
        await engine.enqueue(accepted(book, JOBS[1]))
        await engine.check_admission()
        await engine.check_admission(0)
        with pytest.raises(ProblemError, match="waiting"):
            await engine.check_admission(arriving=1)
        broker.send(JOBS[2])
        assert await code_of(engine) == "queue-full"

    run_scenario(scenario, build_queue=3)


def test_the_queue_is_bounded_however_many_come_to_a_replica_at_once(run_scenario):
    async def scenario(engine, book, broker):
        builds = Builds(Settings(), GamutStore(book._blobs), book, engine)
        names = [f"{number:064x}" for number in range(40)]
        answers = await asyncio.gather(
            *(builds.submit(name, {}, b"data") for name in names), return_exceptions=True
        )
        refused = [answer for answer in answers if isinstance(answer, ProblemError)]
        assert {answer.problem.code for answer in refused} == {"queue-full"}
        assert 1 <= broker.waiting() == len(names) - len(refused) <= 3

    run_scenario(scenario, build_queue=3)


def test_a_broker_that_is_lost_refuses_new_builds_and_keeps_those_let_in(
    run_scenario, cluster, monkeypatch
):
    async def scenario(engine, book, _broker):
        document = accepted(book, JOBS[0])
        await engine.check_admission()
        cluster.broker.kill()
        await engine.enqueue(document)  # durable and marked: the workers find it
        assert await code_of(engine) == "broker-unavailable"
        assert engine.facts().fault == "the broker does not answer"
        cluster.start_broker()
        clock.now += 100
        await engine.check_admission()
        assert engine.facts().fault is None

    clock = SimpleNamespace(now=1000.0)
    monkeypatch.setattr(celery_engine, "time", SimpleNamespace(monotonic=lambda: clock.now))
    run_scenario(scenario)


def test_a_replica_that_stops_takes_no_more(run_scenario):
    async def scenario(engine, _book, _broker):
        engine.drain()
        assert await code_of(engine) == "shutting-down"

    run_scenario(scenario)


def test_facts_are_those_of_the_deployment(run_scenario, monkeypatch):
    monkeypatch.setattr(celery_engine, "_OBSERVE_SECONDS", 0.05)

    async def scenario(engine, book, broker):
        for job_id in JOBS:
            Outbox(engine._outbox._blobs, book).mark(job_id)
        broker.send(JOBS[0])
        while (engine.facts().queued, engine.facts().running) != (1, 2):  # noqa: ASYNC110
            await asyncio.sleep(0.01)
        assert engine.facts().capacity == 16

    run_scenario(scenario)


def test_clients_are_told_to_come_back_later_the_more_wait(run_scenario):
    async def scenario(engine, _book, _broker):
        assert 0 < engine.retry_after() < engine.retry_after(10) <= engine.retry_after(10**6) <= 60

    run_scenario(scenario)
