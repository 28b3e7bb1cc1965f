import asyncio
import contextlib
import itertools
import os
import signal
from types import SimpleNamespace

import pytest

from service.building import embedded
from service.building.builds import Builds
from service.building.embedded import EmbeddedEngine
from service.building.engine import queue_full
from service.problems.problem import ProblemError
from service.settings import Settings
from service.storage.blobs import StoreFullError, StoreUnavailableError
from service.storage.gamuts import GamutDamagedError

JOB = "a" * 64


OPTIONS = {"gamma": 1}


PATIENCE = 600.0


@pytest.fixture
def deployment(store, book, scripted_worker):
    """Processes of a service that share one store, as replicas share a bucket."""

    @contextlib.asynccontextmanager
    async def replica(*, sole_owner=False, **settings):
        values = Settings(**{"drain_seconds": 0, **settings})
        engine = EmbeddedEngine(values, store, book, sole_owner=sole_owner, command=scripted_worker)
        builds = Builds(values, store, book, engine)
        await builds.start()
        try:
            yield builds
        finally:
            await builds.stop()

    return SimpleNamespace(replica=replica, store=store, book=book, open=scripted_worker.open)


def run(scenario):
    asyncio.run(asyncio.wait_for(scenario, PATIENCE))


async def begun(builds, job_id=JOB):
    async def found():
        return (await builds.job(job_id)).stage

    async with asyncio.timeout(PATIENCE):
        while not await found():  # noqa: ASYNC110 - another process
            await asyncio.sleep(0.01)


@pytest.mark.slow
def test_a_job_is_durable_before_it_is_accepted_and_waited_for(deployment):
    async def scenario():
        async with deployment.replica() as builds:
            job = await builds.submit(JOB, OPTIONS, b"gate", {"traceparent": "00"})
            assert deployment.book.read(JOB).trace == {"traceparent": "00"}
            assert deployment.store.input_options(JOB) == OPTIONS
            assert not job.final
            assert not (await builds.wait(JOB, 0.0)).final
            deployment.open()
            assert (await builds.wait(JOB, PATIENCE)).state == "succeeded"
            assert (await builds.submit(JOB, OPTIONS, b"gate")).sha256
            assert builds.facts().completed == 1

    run(scenario())


@pytest.mark.parametrize("replicas", [1, 3])
def test_200_identical_requests_are_one_build(deployment, scripted_worker, replicas):
    async def scenario():
        async with contextlib.AsyncExitStack() as stack:
            each = [
                await stack.enter_async_context(deployment.replica(build_queue=1))
                for _ in range(replicas)
            ]
            requests = list(itertools.islice(itertools.cycle(each), 200))
            jobs = await asyncio.gather(*(one.submit(JOB, OPTIONS, b"gate") for one in requests))
            assert {job.id for job in jobs} == {JOB}
            deployment.open()
            ended = await asyncio.gather(*(one.wait(JOB, PATIENCE) for one in requests))
            assert {job.state for job in ended} == {"succeeded"}

    run(scenario())
    assert scripted_worker.begun() == 1


def test_who_submitted_may_leave(deployment):
    async def scenario():
        async with deployment.replica() as builds:
            first = asyncio.create_task(builds.submit(JOB, OPTIONS, b"gate"))
            await asyncio.sleep(0)
            first.cancel()
            assert (await builds.submit(JOB, OPTIONS, b"gate")).id == JOB
            waiting = asyncio.create_task(builds.wait(JOB, PATIENCE))
            await begun(builds)
            waiting.cancel()
            deployment.open()
            assert (await builds.wait(JOB, PATIENCE)).state == "succeeded"

    run(scenario())


def test_changes_are_followed_to_the_end_here_and_elsewhere(deployment):
    async def scenario():
        async with deployment.replica() as one, deployment.replica() as other:
            await one.submit(JOB, OPTIONS, b"gate")

            async def followed(builds, found):
                async for job in builds.changes(JOB, PATIENCE):
                    if job is not None:
                        found.append(job)

            here, elsewhere = [], []
            following = asyncio.gather(followed(one, here), followed(other, elsewhere))
            await until(lambda: any(job.stage for job in here) and elsewhere)
            deployment.open()
            await following
            for jobs in (here, elsewhere):
                assert jobs[-1].state == "succeeded"
                assert all(not job.final for job in jobs[:-1])
                assert all(job != after for job, after in itertools.pairwise(jobs))

    run(scenario())


def test_silence_is_broken_by_signs_of_life(deployment):
    async def scenario():
        async with deployment.replica() as builds:
            await builds.submit(JOB, OPTIONS, b"hang")
            await begun(builds)
            changes = builds.changes(JOB, 0.05)
            assert await anext(changes) is not None
            silence = 0
            while silence < 2:
                silence += await anext(changes) is None
            await changes.aclose()
            assert builds._subscriptions == {}

    run(scenario())


@pytest.mark.parametrize("where", ["here", "elsewhere"])
@pytest.mark.slow
def test_a_cancelled_build_ends_for_all_who_wait(deployment, where):
    async def scenario():
        async with deployment.replica() as one, deployment.replica() as other:
            await one.submit(JOB, OPTIONS, b"hang")
            await begun(one)
            waiting = asyncio.create_task(one.wait(JOB, PATIENCE))
            job = await (one if where == "here" else other).cancel(JOB)
            assert job.state == "cancelled"
            assert (await waiting).problem["code"] == "build-cancelled"
            assert not deployment.store.input_kept(JOB)
            again = await other.submit(JOB, OPTIONS, b"build")
            assert (again.state, again.attempts) == ("queued", 0)
            assert (await other.wait(JOB, PATIENCE)).state == "succeeded"
            assert (await other.cancel(JOB)).state == "succeeded"
            assert await other.cancel("b" * 64) is None

    run(scenario())


def test_what_waits_here_and_is_cancelled_elsewhere_is_known_here(deployment):
    async def scenario():
        async with deployment.replica() as one, deployment.replica(build_workers=2) as other:
            await one.submit("b" * 64, OPTIONS, b"hang")
            await begun(one, "b" * 64)
            await one.submit(JOB, OPTIONS, b"build")
            waiting = asyncio.create_task(one.wait(JOB, PATIENCE))
            await other.cancel(JOB)
            assert (await waiting).state == (await one.job(JOB)).state == "cancelled"

    run(scenario())


def test_a_damaged_gamut_is_built_again_from_its_input(deployment, tmp_path, scripted_worker):
    async def scenario():
        async with deployment.replica() as builds:
            await builds.submit(JOB, OPTIONS, b"build")
            await builds.wait(JOB, PATIENCE)
            (history,) = (tmp_path / "store" / "published").rglob("*.gamut")
            good = history.read_bytes()
            history.write_bytes(good[::-1])
            with pytest.raises(GamutDamagedError) as caught:
                deployment.store.content(JOB)
            assert caught.value.input_kept
            jobs = await asyncio.gather(*(builds.rebuild(JOB) for _ in range(5)))
            assert {job.id for job in jobs} == {JOB}
            await builds.wait(JOB, PATIENCE)
            assert deployment.store.content(JOB)[1] == good
            assert await builds.rebuild(JOB) is None
            assert await builds.rebuild("b" * 64) is None

    run(scenario())
    assert scripted_worker.begun() == 2


@pytest.mark.parametrize("when", ["before the start", "after it"])
@pytest.mark.slow
def test_a_job_whose_document_is_damaged_is_built_from_its_input(deployment, tmp_path, when):
    def damage():
        (path,) = (tmp_path / "store" / "jobs").rglob("*.job")
        path.write_bytes(path.read_bytes()[:-3])

    async def scenario():
        deployment.book.accept(JOB, OPTIONS)
        deployment.store.keep_input(JOB, b"build", OPTIONS)
        if when == "before the start":
            damage()
            async with deployment.replica() as builds:
                assert (await builds.wait(JOB, PATIENCE)).state == "succeeded"
        else:
            deployment.book.request_cancel(JOB)  # so that the start finds nothing to do
            async with deployment.replica() as builds:
                await builds._engine._recovery
                damage()
                assert (await builds.job(JOB)).state == "queued"
                assert (await builds.wait(JOB, PATIENCE)).state == "succeeded"
        assert deployment.store.corruptions == 1
        assert deployment.store.is_stored(JOB)
        damage()
        async with deployment.replica() as builds:
            assert await builds.job(JOB) is None

    run(scenario())


def test_a_full_queue_refuses_what_is_new_and_only_that(deployment):
    async def scenario():
        async with deployment.replica(build_queue=1) as builds:
            await builds.submit(JOB, OPTIONS, b"hang")
            await begun(builds)
            await builds.submit("b" * 64, OPTIONS, b"build")
            with pytest.raises(ProblemError) as caught:
                await builds.submit("c" * 64, OPTIONS, b"build")
            assert caught.value.problem.code == "queue-full"
            assert deployment.book.read("c" * 64) is None
            assert (await builds.submit("b" * 64, OPTIONS, b"build")).state == "queued"

    run(scenario())


def test_the_queue_is_bounded_however_many_come_at_once(deployment):
    async def scenario():
        async with deployment.replica(build_queue=4) as builds:
            await builds.submit(JOB, OPTIONS, b"hang")
            await begun(builds)
            names = [f"{number:064x}" for number in range(40)]
            answers = await asyncio.gather(
                *(builds.submit(name, OPTIONS, b"hang") for name in names), return_exceptions=True
            )
            refused = [answer for answer in answers if isinstance(answer, ProblemError)]
            assert {answer.problem.code for answer in refused} == {"queue-full"}
            assert len(refused) == 36
            assert builds.facts().queued == 4

    run(scenario())


@pytest.mark.parametrize(
    ("error", "code"),
    [(StoreFullError(), "storage-full"), (StoreUnavailableError(), "build-input-lost")],
)
def test_an_input_that_cannot_be_stored_is_no_job(deployment, monkeypatch, error, code):
    def fails(*_arguments):
        raise error

    async def scenario():
        async with deployment.replica() as builds:
            with monkeypatch.context() as patch:
                patch.setattr(deployment.store, "keep_input", fails)
                with pytest.raises(type(error)):
                    await builds.submit(JOB, OPTIONS, b"build")
            assert deployment.book.read(JOB).problem["code"] == code
            await builds.submit(JOB, OPTIONS, b"build")
            assert (await builds.wait(JOB, PATIENCE)).state == "succeeded"

    run(scenario())


@pytest.mark.slow
def test_what_was_accepted_survives_the_process(deployment):
    async def scenario():
        async with deployment.replica() as builds:
            for name in "abc":
                await builds.submit(name * 64, OPTIONS, b"gate")
            await begun(builds)
            waiting = asyncio.create_task(builds.wait("c" * 64, PATIENCE))
            followed = asyncio.create_task(anext(builds.changes("c" * 64, PATIENCE)))
            await until(lambda: len(builds._subscriptions.get("c" * 64, ())) == 2)
            builds.drain()
            assert (await waiting).state == (await followed).state == "queued"
            with pytest.raises(ProblemError) as caught:
                await builds.submit("d" * 64, OPTIONS, b"build")
            assert caught.value.problem.code == "shutting-down"
        deployment.open()
        async with deployment.replica(sole_owner=True) as builds:
            for name in "abc":
                assert (await builds.wait(name * 64, PATIENCE)).state == "succeeded"

    run(scenario())


@pytest.mark.slow
def test_an_end_that_cannot_be_written_down_is_told_to_those_who_wait(deployment, monkeypatch):
    def fails(*_arguments):
        raise OSError(28, "No space left on device")

    async def scenario():
        async with deployment.replica() as builds:
            await builds.submit(JOB, OPTIONS, b"gate")
            waiting = asyncio.create_task(builds.wait(JOB, PATIENCE))
            await begun(builds)
            monkeypatch.setattr(deployment.store, "publish", fails)
            monkeypatch.setattr(deployment.book, "finish", fails)
            deployment.open()
            assert (await waiting).problem["code"] == "storage-full"

    run(scenario())


def test_what_failed_for_want_of_room_is_built_when_it_is_asked_for_again(deployment, monkeypatch):
    def fails(*_arguments):
        raise StoreFullError

    async def scenario():
        async with deployment.replica() as builds:
            with monkeypatch.context() as patch:
                patch.setattr(deployment.store, "publish", fails)
                await builds.submit(JOB, OPTIONS, b"build")
                ended = await builds.wait(JOB, PATIENCE)
            assert (ended.state, ended.problem["code"]) == ("failed", "storage-full")
            assert deployment.store.input_kept(JOB)
            await builds.submit(JOB, OPTIONS, b"build")
            assert (await builds.wait(JOB, PATIENCE)).state == "succeeded"

    run(scenario())


def test_finished_jobs_are_paged_and_forgotten_with_inputs_nobody_needs(deployment, clock):
    async def scenario():
        for name, text in zip("abc", ("build", "cancelled", "build"), strict=True):
            deployment.book.accept(name * 64, OPTIONS)
            deployment.store.keep_input(name * 64, text.encode(), OPTIONS)
        deployment.book.request_cancel("b" * 64)
        async with deployment.replica(sole_owner=True) as builds:
            for name in "ac":
                await builds.wait(name * 64, PATIENCE)
            assert [job.id[0] for job in await builds.page("", 9)] == ["a", "b", "c"]
            assert [job.id[0] for job in await builds.page("a" * 64, 1)] == ["b"]
            assert builds.retry_after(deployment.book.read("b" * 64)) >= 1
        # It is to be built again, by whoever asks for it next.
        deployment.store.set_aside(deployment.store.record("a" * 64), "a test")
        clock.seconds += 10
        async with deployment.replica(job_retention_seconds=5) as builds:
            async with asyncio.timeout(PATIENCE):
                while await builds.page("", 9):  # noqa: ASYNC110 - a task of its own
                    await asyncio.sleep(0.01)
                while deployment.store.input_kept("b" * 64):  # noqa: ASYNC110 - the same one
                    await asyncio.sleep(0.01)
            assert await builds.job(JOB) is None
            assert await builds.wait(JOB, 1.0) is None
        kept = [deployment.store.input_kept(name * 64) for name in "abc"]
        assert kept == [True, False, True]

    run(scenario())


def test_the_input_of_a_forgotten_job_stays_for_one_that_came_after_it(
    deployment, monkeypatch, clock
):
    again, over = "b" * 64, "c" * 64
    for job in (again, over):
        deployment.book.accept(job, OPTIONS)
        deployment.store.keep_input(job, b"hang", OPTIONS)
        deployment.book.request_cancel(job)
    clock.seconds += 10
    forget = deployment.book.forget_finished

    def forget_and_ask_again(older_than):
        forgotten = forget(older_than)
        if forgotten:
            deployment.book.accept(again, OPTIONS)
        return forgotten

    monkeypatch.setattr(deployment.book, "forget_finished", forget_and_ask_again)

    async def scenario():
        async with deployment.replica(job_retention_seconds=5):
            # the inputs are looked at in this order
            await until(lambda: not deployment.store.input_kept(over))
        assert deployment.store.input_kept(again)

    run(scenario())


@pytest.fixture
def run_scenario(store, book, scripted_worker):
    """Run a coroutine function with an engine whose workers follow a script."""

    def run(scenario, *, command=scripted_worker, sole_owner=True, **settings):
        values = Settings(**{"drain_seconds": 0, **settings})

        async def main():
            engine = EmbeddedEngine(values, store, book, sole_owner=sole_owner, command=command)
            told = []
            engine.listen(told.append)
            await engine.start()
            try:
                return await asyncio.wait_for(scenario(engine, told), PATIENCE)
            finally:
                await asyncio.wait_for(engine.stop(), PATIENCE)

        return asyncio.run(main())

    return run


async def until(condition):
    async with asyncio.timeout(PATIENCE):
        while not condition():  # noqa: ASYNC110 - the condition is about another process
            await asyncio.sleep(0.01)


def states(told, name="a"):
    found = []
    for document in told:
        if document.id == name * 64 and document.state not in found[-1:]:
            found.append(document.state)
    return found


def test_what_is_queued_twice_is_done_once(run_scenario, accept, scripted_worker):
    async def scenario(engine, told):
        document = accept("gate")
        for _ in range(3):
            await engine.enqueue(document)
        assert engine.facts().queued == 1
        scripted_worker.open()
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


def test_the_time_to_come_back_is_learnt_from_builds(run_scenario, accept, clock, monkeypatch):
    # builds that take no time
    monkeypatch.setattr(embedded, "time", SimpleNamespace(monotonic=clock, time=clock))

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
def test_a_poisonous_input_leaves_the_others_alone(run_scenario, accept, scripted_worker, clock):
    async def scenario(engine, told):
        for name, text in zip("abcd", ["die", "build", "hang", "build"], strict=True):
            await engine.enqueue(accept(text, name))
        await until(lambda: any(job.id == "c" * 64 and job.stage for job in told))
        clock.seconds += 1000
        await until(lambda: "succeeded" in states(told, "d"))
        assert [states(told, name)[-1] for name in "abcd"] == [
            "failed",
            "succeeded",
            "failed",
            "succeeded",
        ]
        assert scripted_worker.begun("die") == 3

    run_scenario(scenario)


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
def test_stopping_lets_what_runs_finish_and_leaves_the_rest_to_the_next(
    run_scenario, accept, book, scripted_worker
):
    async def scenario(engine, _told):
        await engine.enqueue(accept("gate"))
        await engine.enqueue(accept("build", "b"))
        await until(scripted_worker.begun)
        engine.drain()
        scripted_worker.open()
        with pytest.raises(ProblemError) as caught:
            await engine.check_admission()
        assert caught.value.problem.code == "shutting-down"
        assert int(caught.value.problem.headers["Retry-After"]) >= 1

    run_scenario(scenario, drain_seconds=600)
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

    run_scenario(scenario)
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


def test_elsewhere_a_lease_is_waited_for(run_scenario, accept, book, clock, monkeypatch):
    accept("build")
    book.claim("a" * 64, "other host", 1.0)
    claim, refused = book.claim, []

    def claim_and_note(*arguments):
        claimed = claim(*arguments)
        refused.append(claimed is None)
        return claimed

    monkeypatch.setattr(book, "claim", claim_and_note)

    async def scenario(_engine, told):
        await until(lambda: refused)
        clock.seconds += 2
        await until(lambda: "succeeded" in states(told))

    run_scenario(scenario, sole_owner=False)
    assert refused[0]
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


def test_a_worker_that_cannot_start_is_not_warm_and_costs_no_attempt(
    run_scenario, accept, book, caplog
):
    async def scenario(engine, _told):
        await engine.enqueue(accept("build"))
        await until(lambda: "build worker did not start" in caplog.text)
        assert engine.facts().warm_workers == 0
        assert engine.document("a" * 64).state == "queued"

    run_scenario(scenario, command=("/bin/false",))
    assert book.read("a" * 64).attempts == 0


@pytest.mark.parametrize(("estimate", "told"), [(0, "1"), (7, "7"), (10**6, "600")])
def test_a_full_queue_says_when_to_come_back_within_reason(estimate, told):
    problem = queue_full(16, estimate).problem
    assert (problem.code, problem.headers) == ("queue-full", {"Retry-After": told})
    assert "16" in problem.detail
