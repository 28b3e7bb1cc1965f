import asyncio
import contextlib
import os
import signal
import sys
import textwrap

import pytest

from service.builds import Builds
from service.problems import ProblemError
from service.settings import Settings
from service.storage.gamuts import GamutStore
from service.storage.local import LocalBlobs

WORKER = """
import hashlib, json, os, sys, time
def send(**event):
    print(json.dumps(event), flush=True)
send(event="ready")
for line in sys.stdin:
    request = json.loads(line)
    word = open(request["input"]).read()
    send(event="progress", stage=f"pid {os.getpid()}", fraction=0.5)
    if word == "hang":
        time.sleep(1000)
    elif word == "die":
        os._exit(3)
    elif word == "garble":
        print("no JSON", flush=True)
    elif word == "die once":
        open(request["input"], "w").write("build")
        os._exit(3)
    elif word == "refuse":
        send(event="refused", code="missing-column", message="m", where={"column": "L"}, remedy="r")
    elif word == "full":
        send(event="failed", errno=28)
    elif word == "defect":
        send(event="failed", errno=None)
    else:
        time.sleep(float(word) if word[0].isdigit() else 0)
        open(request["output"], "wb").write(b"history")
        digest = hashlib.sha256(b"history").hexdigest()
        send(event="built", sha256=digest, nbytes=7, description={"options": request["options"]})
"""
"""A worker that does what its input says, without a compiler to wait for."""


@pytest.fixture
def run_scenario(tmp_path):
    """Run a coroutine function with builds whose workers follow a script."""

    def run(scenario, script=WORKER, **settings):
        path = tmp_path / "worker.py"
        path.write_text(textwrap.dedent(script))

        async def main():
            store = GamutStore(LocalBlobs(tmp_path / "data"))
            store.open()
            values = {"build_timeout": 20, "drain_seconds": 0, **settings}
            builds = Builds(Settings(**values), store, (sys.executable, "-S", str(path)))
            builds.start()
            try:
                await asyncio.wait_for(scenario(builds, store), 60)
            finally:
                await builds.stop()
                store.close()
            assert list(scratch(store).glob("*.gamut")) == []

        asyncio.run(main())

    return run


def submit(builds, store, word, name="a"):
    return builds.submit(name * 64, {"gamma": 1}, written(store, word))


def written(store, word):
    path = store.scratch(".input")
    path.write_text(word)
    return path


def scratch(store):
    """The folder of work in progress."""
    return store.scratch("").parent


async def until(condition):
    while not condition():  # noqa: ASYNC110 - the condition is about another process
        await asyncio.sleep(0.01)


def test_a_build_is_published_and_its_input_removed(run_scenario):
    async def scenario(builds, store):
        job = submit(builds, store, "build")
        assert await job.wait(30)
        assert (job.state, job.attempts, job.problem) == ("succeeded", 1, None)
        assert store.content(job.id)[1] == b"history"
        assert list(scratch(store).iterdir()) == []
        assert builds.job(job.id) is job
        assert builds.active(job.id) is None
        assert builds.completed == 1

    run_scenario(scenario)


def test_identical_requests_share_one_job(run_scenario):
    async def scenario(builds, store):
        jobs = {submit(builds, store, "0.2") for _ in range(20)}
        (job,) = jobs
        assert await job.wait(30)
        assert builds.completed == 1
        assert list(scratch(store).iterdir()) == []

    run_scenario(scenario)


def test_what_is_stored_by_then_is_not_built_again(run_scenario):
    async def scenario(builds, store):
        assert await submit(builds, store, "build").wait(30)
        again = submit(builds, store, "die")
        assert await again.wait(30)
        assert (again.state, again.attempts) == ("succeeded", 0)
        assert builds.completed == 1

    run_scenario(scenario)


@pytest.mark.parametrize(
    ("word", "code"),
    [("refuse", "missing-column"), ("full", "storage-full"), ("defect", "build-failed")],
)
def test_a_worker_that_reports_an_error_goes_on(run_scenario, word, code):
    async def scenario(builds, store):
        failing = submit(builds, store, word)
        assert await failing.wait(30)
        assert (failing.state, failing.problem.code) == ("failed", code)
        following = submit(builds, store, "build", "b")
        assert await following.wait(30)
        assert following.stage == failing.stage

    run_scenario(scenario)


def test_the_place_and_the_remedy_of_a_refusal_are_kept(run_scenario):
    async def scenario(builds, store):
        job = submit(builds, store, "refuse")
        assert await job.wait(30)
        assert (job.problem.detail, job.problem.where, job.problem.remedy) == (
            "m",
            {"column": "L"},
            "r",
        )

    run_scenario(scenario)


def test_the_deadline_ends_a_build_and_the_next_one_works(run_scenario):
    async def scenario(builds, store):
        late = submit(builds, store, "hang")
        following = submit(builds, store, "build", "b")
        assert await late.wait(30)
        assert late.problem.code == "build-timeout"
        assert await following.wait(30)
        assert following.state == "succeeded"
        with pytest.raises(ProcessLookupError):
            os.kill(int(late.stage.split()[1]), 0)

    run_scenario(scenario, build_timeout=0.3)


def test_a_build_whose_worker_dies_is_tried_again(run_scenario):
    async def scenario(builds, store):
        job = submit(builds, store, "die once")
        assert await job.wait(30)
        assert (job.state, job.attempts) == ("succeeded", 2)

    run_scenario(scenario)


@pytest.mark.parametrize("word", ["die", "garble"])
def test_an_input_that_kills_every_worker_fails_and_others_are_built(run_scenario, word):
    async def scenario(builds, store):
        poison = submit(builds, store, word)
        other = submit(builds, store, "build", "b")
        assert await poison.wait(30)
        assert (poison.state, poison.attempts) == ("failed", 3)
        assert poison.problem.code == "build-crashed"
        assert await other.wait(30)
        assert other.state == "succeeded"

    run_scenario(scenario)


def test_an_idle_worker_that_dies_is_replaced_at_once(run_scenario):
    async def scenario(builds, store):
        job = submit(builds, store, "build")
        assert await job.wait(30)
        os.kill(int(job.stage.split()[1]), signal.SIGKILL)
        await until(lambda: not builds.warm)
        await until(lambda: builds.warm)
        other = submit(builds, store, "build", "b")
        assert await other.wait(30)
        assert (other.state, other.attempts) == ("succeeded", 1)

    run_scenario(scenario)


def test_a_full_queue_refuses_at_once(run_scenario):
    async def scenario(builds, store):
        running = submit(builds, store, "hang")
        await until(lambda: running.state == "running")
        for name in "bc":
            submit(builds, store, "build", name)
        with pytest.raises(ProblemError) as caught:
            submit(builds, store, "build", "d")
        assert caught.value.problem.code == "queue-full"
        assert int(caught.value.problem.headers["Retry-After"]) > 0
        assert submit(builds, store, "build", "b").id == "b" * 64
        assert (builds.running, builds.queued) == (1, 2)

    run_scenario(scenario, build_queue=2)


def test_several_workers_build_at_the_same_time(run_scenario):
    async def scenario(builds, store):
        jobs = [submit(builds, store, "1", name) for name in "abc"]
        await until(lambda: all(job.state == "running" for job in jobs))
        assert len({job.stage for job in jobs if job.stage}) == len(
            [job for job in jobs if job.stage]
        )
        for job in jobs:
            assert await job.wait(30)

    run_scenario(scenario, build_workers=3)


def test_stopping_lets_accepted_builds_finish_and_takes_no_more(run_scenario):
    async def scenario(builds, store):
        jobs = [submit(builds, store, "0.3", name) for name in "ab"]
        stopping = asyncio.create_task(builds.stop())
        await asyncio.sleep(0)
        with pytest.raises(ProblemError) as caught:
            submit(builds, store, "build", "c")
        assert caught.value.problem.code == "shutting-down"
        assert int(caught.value.problem.headers["Retry-After"]) > 0
        await stopping
        assert [job.state for job in jobs] == ["succeeded", "succeeded"]

    run_scenario(scenario, drain_seconds=30)


def test_finished_jobs_are_forgotten_in_order(run_scenario):
    async def scenario(builds, store):
        jobs = [submit(builds, store, "refuse", name) for name in "abc"]
        for job in jobs:
            assert await job.wait(30)
        assert [builds.job(job.id) for job in jobs] == [None, *jobs[1:]]

    run_scenario(scenario, finished_jobs=2)


def test_a_worker_that_cannot_start_is_not_warm(run_scenario):
    async def scenario(builds, store):
        job = submit(builds, store, "build")
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(builds.first_warm.wait(), 0.5)
        assert not builds.warm
        assert job.state == "queued"

    run_scenario(scenario, script="raise SystemExit(1)")


def test_a_worker_ends_with_the_service(run_scenario):
    pids = []

    async def scenario(builds, store):
        job = submit(builds, store, "hang")
        await until(lambda: job.stage)
        pids.append(int(job.stage.split()[1]))

    run_scenario(scenario)
    with pytest.raises(ProcessLookupError):
        os.kill(pids[0], 0)


@pytest.mark.parametrize("method", ["record", "publish"])
@pytest.mark.parametrize(
    ("error", "code"),
    [
        (OSError(5, "a bad disk"), "store-unavailable"),
        (RuntimeError("a defect"), "build-failed"),
        (OSError(24, "Too many open files"), "overloaded"),
    ],
)
def test_an_unexpected_error_costs_one_build_and_not_the_slot(
    run_scenario, monkeypatch, method, error, code
):
    async def scenario(builds, store):
        usual = getattr(store, method)
        errors = [error]

        def fails_once(*arguments):
            if errors:
                raise errors.pop()
            return usual(*arguments)

        source = written(store, "build")
        monkeypatch.setattr(store, method, fails_once)
        job = builds.submit("a" * 64, {}, source)
        assert await job.wait(30)
        assert (job.state, job.problem.code) == ("failed", code)
        assert builds.active(job.id) is None
        following = submit(builds, store, "build", "b")
        assert await following.wait(30)
        assert following.state == "succeeded"

    run_scenario(scenario)


def test_an_input_that_cannot_be_removed_does_not_hold_up_the_job(run_scenario):
    async def scenario(builds, store):
        folder = store.scratch(".input")
        folder.mkdir()
        job = builds.submit("a" * 64, {}, folder / ".." / folder.name)
        assert await job.wait(30)
        assert (job.state, job.problem.code) == ("failed", "build-crashed")
        following = submit(builds, store, "build", "b")
        assert await following.wait(30)
        assert following.state == "succeeded"

    run_scenario(scenario)
