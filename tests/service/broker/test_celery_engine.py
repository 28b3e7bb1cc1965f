"""The engine of a replica that builds nothing, against a real Redis that comes and goes."""

import asyncio
from types import SimpleNamespace

import pytest

from service.broker import celery_engine
from service.broker.celery_app import Outbox
from service.broker.celery_engine import CeleryEngine
from service.building.builds import Builds
from service.jobs.book import JobBook
from service.problems.problem import ProblemError
from service.storage.gamut_store import GamutStore
from service.storage.local import LocalBlobs

pytestmark = pytest.mark.anyio

JOBS = [letter * 64 for letter in "abc"]


@pytest.fixture
def store(tmp_path):
    opened = GamutStore(LocalBlobs(tmp_path / "store"))
    opened.open()
    yield opened
    opened.close()


@pytest.fixture
def book(store):
    return JobBook(store.blobs)


@pytest.fixture
async def engine(store, book, settings, cluster, broker):  # noqa: ARG001 - the broker is empty
    made = CeleryEngine(settings(cluster.environment["GAMUT_BROKER"], build_queue=3), store, book)
    await made.start(lambda _: None)
    yield made
    await made.stop()


async def code_of(engine):
    with pytest.raises(ProblemError) as caught:
        await engine.check_admission(0)
    assert int(caught.value.problem.headers["Retry-After"]) > 0
    return caught.value.problem.code


async def test_a_job_is_marked_and_sent_once_also_if_who_accepted_it_died(
    engine, book, broker, tmp_path
):
    document, _ = book.accept(JOBS[0], {})
    for _ in range(2):
        await engine.enqueue(document, joined=True)
        assert broker.waiting() == 1
    assert (tmp_path / "store" / "pending" / "aa" / JOBS[0]).exists()
    assert engine.document(JOBS[0]) is None
    await engine.enqueue(document)
    assert broker.waiting() == 2


async def test_the_queue_is_bounded_whoever_filled_it(engine, store, book, broker):
    marks = Outbox(store.blobs, book)
    await engine.check_admission(0)
    marks.mark(JOBS[0])
    broker.send(JOBS[0])
    await engine.enqueue(book.accept(JOBS[1], {})[0])
    await engine.check_admission(0)
    with pytest.raises(ProblemError, match="waiting"):
        await engine.check_admission(arriving=1)
    marks.mark(JOBS[2])
    broker.send(JOBS[2])
    assert await code_of(engine) == "queue-full"
    assert engine.facts().queued == 3


async def test_messages_of_jobs_that_were_run_before_their_turn_do_not_fill_the_queue(
    engine, book, broker
):
    for number in range(5):
        broker.send(f"{number:064x}")
    await engine.check_admission(0)
    await engine.enqueue(book.accept(JOBS[0], {})[0])
    await engine.check_admission(0)
    assert (engine.facts().queued, engine.facts().running) == (1, 0)


async def test_the_queue_is_bounded_however_many_come_to_a_replica_at_once(
    engine, store, book, broker
):
    builds = Builds(store, book, engine)
    names = [f"{number:064x}" for number in range(40)]
    answers = await asyncio.gather(
        *(builds.submit(name, {}, b"data") for name in names), return_exceptions=True
    )
    refused = [answer for answer in answers if isinstance(answer, ProblemError)]
    assert {answer.problem.code for answer in refused} == {"queue-full"}
    assert 1 <= broker.waiting() == len(names) - len(refused) <= 3


async def test_a_broker_that_is_lost_refuses_new_builds_and_keeps_those_let_in(
    engine, book, cluster, monkeypatch
):
    clock = SimpleNamespace(now=1000.0)
    monkeypatch.setattr(celery_engine, "time", SimpleNamespace(monotonic=lambda: clock.now))
    document, _ = book.accept(JOBS[0], {})
    await engine.check_admission(0)
    cluster.broker.kill()
    await engine.enqueue(document)  # durable and marked: the workers find it
    assert await code_of(engine) == "broker-unavailable"
    assert engine.facts().fault == "the broker does not answer"
    cluster.start_broker()
    clock.now += 100
    await engine.check_admission(0)
    assert engine.facts().fault is None


@pytest.fixture
def observed_often(monkeypatch):
    monkeypatch.setattr(celery_engine, "_OBSERVE_SECONDS", 0.05)


@pytest.mark.usefixtures("observed_often")
async def test_facts_are_those_of_the_deployment(store, book, broker, engine):
    for job_id in JOBS:
        Outbox(store.blobs, book).mark(job_id)
    broker.send(JOBS[0])
    async with asyncio.timeout(600):
        while (engine.facts().queued, engine.facts().running) != (1, 2):  # noqa: ASYNC110
            await asyncio.sleep(0.01)
    assert engine.facts().capacity == 3
