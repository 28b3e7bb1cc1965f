import asyncio
import contextlib
import itertools

import pytest

from service.building.builds import Builds
from service.building.embedded import EmbeddedEngine
from service.jobs.book import JobBook
from service.problems.problem import ProblemError
from service.settings import Settings
from service.storage.blobs import StoreFullError, StoreUnavailableError
from service.storage.gamuts import GamutDamagedError, GamutStore
from service.storage.local import LocalBlobs

JOB = "a" * 64
OPTIONS = {"gamma": 1}


class Deployment:
    """Processes of a service that share one store, as replicas share a bucket."""

    def __init__(self, folder, command):
        self.command = command
        self.store = GamutStore(LocalBlobs(folder))
        self.book = JobBook(
            self.store.blobs,
            lost_options=self.store.options_of_damaged_job,
            on_damaged=self.store.count_damaged_job,
        )

    @contextlib.asynccontextmanager
    async def replica(self, *, sole_owner=False, **settings):
        values = Settings(
            **{"build_timeout": 20, "drain_seconds": 0, "build_workers": 1, **settings}
        )
        engine = EmbeddedEngine(
            values, self.store, self.book, sole_owner=sole_owner, command=self.command
        )
        builds = Builds(values, self.store, self.book, engine)
        await builds.start()
        try:
            yield builds
        finally:
            await builds.stop()


@pytest.fixture
def deployment(tmp_path, scripted_worker):
    made = Deployment(tmp_path / "store", scripted_worker)
    made.store.open()
    yield made
    made.store.close()


def run(scenario):
    asyncio.run(asyncio.wait_for(scenario, 60))


async def begun(builds, job_id=JOB):
    async with asyncio.timeout(30):
        while (await builds.job(job_id)).stage == "":  # noqa: ASYNC110 - another process
            await asyncio.sleep(0.01)


@pytest.mark.slow
def test_a_job_is_durable_before_it_is_accepted_and_waited_for(deployment):
    async def scenario():
        async with deployment.replica() as builds:
            job = await builds.submit(JOB, OPTIONS, b"0.2", {"traceparent": "00"})
            assert deployment.book.read(JOB).trace == {"traceparent": "00"}
            assert deployment.store.input_options(JOB) == OPTIONS
            assert not job.final
            assert not (await builds.wait(JOB, 0.0)).final
            assert (await builds.wait(JOB, 30.0)).state == "succeeded"
            assert (await builds.submit(JOB, OPTIONS, b"0.2")).sha256
            assert builds.facts().completed == 1

    run(scenario())


@pytest.mark.slow
def test_200_identical_requests_are_one_build(deployment, scripted_worker):
    async def scenario():
        async with deployment.replica(build_queue=1) as builds:
            jobs = await asyncio.gather(*(builds.submit(JOB, OPTIONS, b"0.2") for _ in range(200)))
            assert {job.id for job in jobs} == {JOB}
            ended = await asyncio.gather(*(builds.wait(JOB, 30.0) for _ in range(200)))
            assert {job.state for job in ended} == {"succeeded"}

    run(scenario())
    assert scripted_worker.begun() == 1


@pytest.mark.slow
def test_200_identical_requests_to_three_replicas_are_one_build(deployment, scripted_worker):
    async def scenario():
        async with contextlib.AsyncExitStack() as stack:
            replicas = [await stack.enter_async_context(deployment.replica()) for _ in range(3)]
            requests = [replicas[number % 3] for number in range(200)]
            await asyncio.gather(*(each.submit(JOB, OPTIONS, b"0.5") for each in requests))
            ended = await asyncio.gather(*(each.wait(JOB, 30.0) for each in requests))
            assert {job.state for job in ended} == {"succeeded"}

    run(scenario())
    assert scripted_worker.begun() == 1


@pytest.mark.slow
def test_who_submitted_may_leave(deployment):
    async def scenario():
        async with deployment.replica() as builds:
            first = asyncio.create_task(builds.submit(JOB, OPTIONS, b"0.3"))
            await asyncio.sleep(0)
            first.cancel()
            assert (await builds.submit(JOB, OPTIONS, b"0.3")).id == JOB
            waiting = asyncio.create_task(builds.wait(JOB, 30.0))
            await asyncio.sleep(0.05)
            waiting.cancel()
            assert (await builds.wait(JOB, 30.0)).state == "succeeded"

    run(scenario())


@pytest.mark.slow
def test_changes_are_followed_to_the_end_here_and_elsewhere(deployment):
    async def scenario():
        async with deployment.replica() as one, deployment.replica() as other:
            await one.submit(JOB, OPTIONS, b"0.5")

            async def followed(builds):
                return [job async for job in builds.changes(JOB, 30.0) if job is not None]

            here, elsewhere = await asyncio.gather(followed(one), followed(other))
            assert [job.state for job in here][-1] == "succeeded"
            assert any(job.stage for job in here)
            assert [job.state for job in elsewhere][-1] == "succeeded"
            for jobs in (here, elsewhere):
                assert all(not job.final for job in jobs[:-1])
                assert all(job != after for job, after in itertools.pairwise(jobs))

    run(scenario())


def test_silence_is_broken_by_signs_of_life(deployment):
    async def scenario():
        async with deployment.replica() as builds:
            await builds.submit(JOB, OPTIONS, b"hang")
            await begun(builds)
            changes = builds.changes(JOB, 0.05)
            found = [await anext(changes) for _ in range(3)]
            assert found[1:] == [None, None]
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
            waiting = asyncio.create_task(one.wait(JOB, 30.0))
            job = await (one if where == "here" else other).cancel(JOB)
            assert job.state == "cancelled"
            assert (await waiting).problem["code"] == "build-cancelled"
            assert not deployment.store.input_kept(JOB)
            again = await other.submit(JOB, OPTIONS, b"build")
            assert (again.state, again.attempts) == ("queued", 0)
            assert (await other.wait(JOB, 30.0)).state == "succeeded"
            assert (await other.cancel(JOB)).state == "succeeded"
            assert await other.cancel("b" * 64) is None

    run(scenario())


def test_what_waits_here_and_is_cancelled_elsewhere_is_known_here(deployment):
    async def scenario():
        async with deployment.replica() as one, deployment.replica(build_workers=2) as other:
            await one.submit("b" * 64, OPTIONS, b"hang")
            await begun(one, "b" * 64)
            await one.submit(JOB, OPTIONS, b"build")
            waiting = asyncio.create_task(one.wait(JOB, 30.0))
            await other.cancel(JOB)
            assert (await waiting).state == (await one.job(JOB)).state == "cancelled"

    run(scenario())


def test_what_failed_is_begun_anew(deployment):
    async def scenario():
        async with deployment.replica() as builds:
            for text, state in ((b"refuse", "failed"), (b"build", "succeeded")):
                await builds.submit(JOB, OPTIONS, text)
                assert (await builds.wait(JOB, 30.0)).state == state

    run(scenario())


def test_what_was_evicted_is_built_anew(deployment, scripted_worker):
    async def scenario():
        async with deployment.replica() as builds:
            for _ in range(2):
                await builds.submit(JOB, OPTIONS, b"build")
                assert (await builds.wait(JOB, 30.0)).state == "succeeded"
                deployment.store.evict(JOB)

    run(scenario())
    assert scripted_worker.begun() == 2


def test_a_damaged_gamut_is_built_again_from_its_input(deployment, tmp_path, scripted_worker):
    async def scenario():
        async with deployment.replica() as builds:
            await builds.submit(JOB, OPTIONS, b"build")
            await builds.wait(JOB, 30.0)
            (history,) = (tmp_path / "store" / "published").rglob("*.gamut")
            good = history.read_bytes()
            history.write_bytes(good[::-1])
            with pytest.raises(GamutDamagedError) as caught:
                deployment.store.content(JOB)
            assert caught.value.input_kept
            jobs = await asyncio.gather(*(builds.rebuild(JOB) for _ in range(5)))
            assert {job.id for job in jobs} == {JOB}
            await builds.wait(JOB, 30.0)
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
                assert (await builds.wait(JOB, 30.0)).state == "succeeded"
        else:
            deployment.book.request_cancel(JOB)  # so that the start finds nothing to do
            async with deployment.replica() as builds:
                await asyncio.sleep(0.2)
                damage()
                assert (await builds.job(JOB)).state == "queued"
                assert (await builds.wait(JOB, 30.0)).state == "succeeded"
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
            assert (await builds.wait(JOB, 30.0)).state == "succeeded"

    run(scenario())


@pytest.mark.slow
def test_what_was_accepted_survives_the_process(deployment):
    async def scenario():
        async with deployment.replica() as builds:
            for name in "abc":
                await builds.submit(name * 64, OPTIONS, b"0.2")
            await begun(builds)
            waiting = asyncio.create_task(builds.wait("c" * 64, 30.0))
            followed = asyncio.create_task(anext(builds.changes("c" * 64, 30.0)))
            await asyncio.sleep(0.05)
            builds.drain()
            assert (await waiting).state == (await followed).state == "queued"
            with pytest.raises(ProblemError) as caught:
                await builds.submit("d" * 64, OPTIONS, b"build")
            assert caught.value.problem.code == "shutting-down"
        async with deployment.replica(sole_owner=True) as builds:
            for name in "abc":
                assert (await builds.wait(name * 64, 30.0)).state == "succeeded"

    run(scenario())


@pytest.mark.slow
def test_an_end_that_cannot_be_written_down_is_told_to_those_who_wait(deployment, monkeypatch):
    def fails(*_arguments):
        raise OSError(28, "No space left on device")

    async def scenario():
        async with deployment.replica() as builds:
            await builds.submit(JOB, OPTIONS, b"0.3")
            waiting = asyncio.create_task(builds.wait(JOB, 30.0))
            await begun(builds)
            monkeypatch.setattr(deployment.store, "publish", fails)
            monkeypatch.setattr(deployment.book, "finish", fails)
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
                ended = await builds.wait(JOB, 30.0)
            assert (ended.state, ended.problem["code"]) == ("failed", "storage-full")
            assert deployment.store.input_kept(JOB)
            await builds.submit(JOB, OPTIONS, b"build")
            assert (await builds.wait(JOB, 30.0)).state == "succeeded"

    run(scenario())


def test_finished_jobs_are_paged_and_forgotten_with_inputs_nobody_needs(deployment):
    async def scenario():
        for name, text in zip("abc", ("build", "cancelled", "build"), strict=True):
            deployment.book.accept(name * 64, OPTIONS)
            deployment.store.keep_input(name * 64, text.encode(), OPTIONS)
        deployment.book.request_cancel("b" * 64)
        async with deployment.replica(sole_owner=True) as builds:
            for name in "ac":
                await builds.wait(name * 64, 30.0)
            assert [job.id[0] for job in await builds.page("", 9)] == ["a", "b", "c"]
            assert [job.id[0] for job in await builds.page("a" * 64, 1)] == ["b"]
            assert builds.retry_after(deployment.book.read("b" * 64)) >= 1
        # It is to be built again, by whoever asks for it next.
        deployment.store.set_aside(deployment.store.record("a" * 64), "a test")
        async with deployment.replica(job_retention_seconds=0) as builds:
            async with asyncio.timeout(30):
                while await builds.page("", 9):  # noqa: ASYNC110 - a task of its own
                    await asyncio.sleep(0.01)
                while deployment.store.input_kept("b" * 64):  # noqa: ASYNC110 - the same one
                    await asyncio.sleep(0.01)
            assert await builds.job(JOB) is None
            assert await builds.wait(JOB, 1.0) is None
        kept = [deployment.store.input_kept(name * 64) for name in "abc"]
        assert kept == [True, False, True]

    run(scenario())


@pytest.mark.slow
def test_the_input_of_a_forgotten_job_stays_for_one_that_came_after_it(deployment, monkeypatch):
    job = "b" * 64
    deployment.book.accept(job, OPTIONS)
    deployment.store.keep_input(job, b"hang", OPTIONS)
    deployment.book.request_cancel(job)
    forget = JobBook.forget_finished

    def forget_and_ask_again(book, older_than):
        forgotten = forget(book, older_than)
        if forgotten:
            book.accept(job, OPTIONS)
        return forgotten

    monkeypatch.setattr(JobBook, "forget_finished", forget_and_ask_again)

    async def scenario():
        async with deployment.replica(job_retention_seconds=0) as builds:
            async with asyncio.timeout(30):
                while (found := await builds.job(job)) is None or found.final:  # noqa: ASYNC110
                    await asyncio.sleep(0.01)
            await asyncio.sleep(0.2)
        assert deployment.store.input_kept(job)

    run(scenario())
