import contextlib
import hashlib
import io
import json
import mmap
import os
import resource
import signal
import struct
import sys
import zlib

import pytest
from PIL import Image

from gamutcore import Options
from gamutcore.building import gamut_id
from service.building.job_runner import Interrupted, Interruption, JobRunner, owner_name
from service.building.lease_renewer import LeaseRenewer
from service.building.process import (
    WORKER_COMMAND,
    BuildProcess,
    BuildTimeoutError,
    MemoryExceededError,
    ProcessDiedError,
    private_bytes,
)
from service.jobs.book import JobCancelledError, LeaseLostError
from service.settings import Settings
from service.storage.blobs import StoreUnavailableError

JOB = "a" * 64


@pytest.fixture
def reports():
    return []


@pytest.fixture
def runner(store, book, scripted_worker, reports):
    """Make a runner with settings, whose process follows a script."""
    made = []

    def make(command=scripted_worker, **settings):
        made.append(
            JobRunner(
                Settings(**settings),
                store,
                book,
                command=command,
                on_build=lambda outcome, seconds, _job: reports.append((outcome, seconds)),
            )
        )
        return made[-1]

    yield make
    for each in made:
        each.close()


@pytest.fixture(autouse=True)
def scratch_is_empty(store):
    """Check at the end that no work in progress was left."""
    yield
    assert list(store.scratch(".x").parent.iterdir()) == []


def test_a_job_is_built_published_and_finished(runner, accept, store, reports):
    accept("build")
    told = []
    outcome = runner().run(JOB, changed=told.append)
    assert (outcome.state, outcome.built) == ("succeeded", True)
    assert (outcome.document.state, outcome.document.attempts) == ("succeeded", 1)
    assert store.content(JOB)[1] == b'{"gamma": 1}'
    assert [document.state for document in told] == ["running", "running"]
    assert told[-1].fraction == 0.5
    ((word, seconds),) = reports
    assert (word, seconds["metric"]) == ("succeeded", 0.25)


def test_a_job_that_is_over_or_unknown_or_somebody_elses_is_left_alone(runner, accept, book):
    assert runner().run(JOB).document is None
    accept("build")
    claim = book.claim(JOB, "other", 60.0)
    outcome = runner().run(JOB)
    assert (outcome.state, outcome.document.owner) == ("elsewhere", "other")
    book.finish(claim, "failed", None)
    assert runner().run(JOB).state == "elsewhere"


def test_what_is_stored_by_then_is_not_built_again(runner, accept, scripted_worker, reports):
    one = runner()
    accept("build")
    one.run(JOB)
    accept("die")
    outcome = one.run(JOB)
    assert (outcome.state, outcome.built) == ("succeeded", False)
    assert scripted_worker.begun() == 1
    assert len(reports) == 1


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("refuse", "missing-column"),
        ("full", "storage-full"),
        ("defect", "build-failed"),
        ("exhaust", "build-out-of-memory"),
        ("outdate", "build-outdated"),
    ],
)
def test_what_the_process_reports_is_a_problem_and_the_process_goes_on(
    runner, accept, store, reports, text, code
):
    one = runner()
    process = one.warm()
    accept(text)
    outcome = one.run(JOB)
    assert (outcome.state, outcome.document.problem["code"]) == ("failed", code)
    assert store.input_kept(JOB) == (code == "storage-full")
    assert reports[0][0] == code
    assert one.process is process
    if code == "missing-column":
        problem = outcome.document.problem
        told = (problem["detail"], problem["where"], problem["remedy"])
        assert told == ("M.", {"column": "L"}, "R.")


@pytest.mark.parametrize(
    ("text", "code"), [("hang", "build-timeout"), ("swell", "build-out-of-memory")]
)
def test_what_exceeds_a_limit_is_ended_once_and_the_next_is_built(
    runner, accept, scripted_worker, clock, text, code
):
    one = runner(build_memory_bytes=256 << 20)

    def go_on(document):
        clock.seconds += 1000 if document.stage and text == "hang" else 0

    accept(text)
    outcome = one.run(JOB, changed=go_on)
    assert (outcome.state, outcome.document.problem["code"]) == ("failed", code)
    assert scripted_worker.begun(text) == 1
    accept("build", "b")
    assert one.run("b" * 64).state == "succeeded"


@pytest.mark.parametrize("text", ["die", "garble"])
@pytest.mark.slow
def test_an_input_that_kills_every_process_is_given_up_after_three(
    runner, accept, scripted_worker, reports, text
):
    one = runner()
    accept(text)
    outcome = one.run(JOB)
    assert (outcome.state, outcome.document.attempts) == ("failed", 3)
    assert outcome.document.problem["code"] == "build-crashed"
    assert scripted_worker.begun(text) == 3
    assert [word for word, _ in reports] == ["crashed"] * 3 + ["build-crashed"]
    accept("build", "b")
    assert one.run("b" * 64).state == "succeeded"


@pytest.mark.slow
def test_a_build_is_repeated_until_its_process_is_left_alone(
    runner, accept, store, scripted_worker
):
    accept("gate")
    victims = []

    def kill(document):
        if document.stage and len(victims) < 2:
            victims.append(int(document.stage.split()[1]))
            os.kill(victims[-1], signal.SIGKILL)
        elif document.stage:
            scripted_worker.open()

    outcome = runner().run(JOB, changed=kill)
    assert (outcome.state, outcome.document.attempts, len(victims)) == ("succeeded", 3, 2)
    assert store.content(JOB)[1] == b'{"gamma": 1}'


def test_a_cancelled_build_is_ended_and_stays_cancelled(runner, accept, book, reports):
    accept("hang")
    interruption = Interruption()

    def cancel(document):
        if document.stage:
            book.request_cancel(JOB)
            interruption.cancel()

    one = runner()
    process = one.warm()
    outcome = one.run(JOB, interruption, cancel)
    assert (outcome.state, outcome.document.state) == ("cancelled", "cancelled")
    assert not process.alive
    assert [word for word, _ in reports] == ["cancelled"]


def test_a_build_that_fails_too_late_leaves_the_input_to_the_job_that_came_after_it(
    runner, accept, book, store
):
    document = accept("refuse")

    def cancel_and_ask_again(told):
        if told.stage:
            book.request_cancel(JOB)
            assert book.accept(JOB, document.options)[1]

    assert runner().run(JOB, changed=cancel_and_ask_again).state == "elsewhere"
    assert book.read(JOB).state == "queued"
    assert store.input_kept(JOB)


def test_a_build_that_is_given_back_waits_for_the_next_and_was_no_attempt(
    runner, accept, book, store
):
    accept("hang")
    interruption = Interruption()
    outcome = runner().run(
        JOB, interruption, lambda document: document.stage and interruption.release()
    )
    assert (outcome.state, outcome.document.state) == ("released", "queued")
    assert outcome.document.attempts == 0
    assert store.input_kept(JOB)
    assert book.claim(JOB, "next", 10.0) is not None


def test_a_job_whose_input_is_gone_fails(runner, accept, store):
    accept("build")
    store.drop_input(JOB)
    outcome = runner().run(JOB)
    assert outcome.document.problem["code"] == "build-input-lost"


@pytest.mark.parametrize(
    ("method", "error", "code"),
    [
        ("is_stored", OSError(5, "a bad disk"), "store-unavailable"),
        ("input_path", RuntimeError("a defect"), "build-failed"),
        ("publish", RuntimeError("a defect"), "build-failed"),
        ("publish", OSError(28, "No space left on device"), "storage-full"),
        ("input_path", OSError(24, "Too many open files"), "overloaded"),
    ],
)
def test_an_unexpected_error_costs_one_build(
    runner, accept, store, monkeypatch, caplog, method, error, code
):
    def fails(*_arguments):
        raise error

    accept("build")
    one = runner()
    with monkeypatch.context() as patch:
        patch.setattr(store, method, fails)
        outcome = one.run(JOB)
    assert (outcome.state, outcome.document.problem["code"]) == ("failed", code)
    # Only a defect needs a traceback; what an operator mends costs nobody the data.
    told = [record for record in caplog.records if record.levelname in {"WARNING", "ERROR"}]
    assert [bool(record.exc_info) for record in told] == [code == "build-failed"]
    assert store.input_kept(JOB) == (code != "build-failed")
    accept("build", "b")
    assert one.run("b" * 64).state == "succeeded"


def test_a_store_that_is_away_for_a_moment_costs_an_attempt(runner, accept, store, monkeypatch):
    publish, failures = store.publish, [StoreUnavailableError()]

    def fails_once(*arguments):
        if failures:
            raise failures.pop()
        return publish(*arguments)

    monkeypatch.setattr(store, "publish", fails_once)
    accept("build")
    outcome = runner().run(JOB)
    assert (outcome.state, outcome.document.attempts) == ("succeeded", 2)


def test_starting_is_given_up_when_it_is_told_to(runner):
    interruption = Interruption()
    interruption.release()
    outcome = runner(command=("/bin/sleep", "1000")).run(JOB, interruption)
    assert outcome.state == "released"


def test_a_process_that_stays_large_is_replaced(runner, accept):
    one = runner()
    process = one.warm()
    accept("build")
    assert one.run(JOB).state == "succeeded"
    assert one.process is process
    process.idle_bytes = -one._settings.build_memory_bytes  # as if it had begun far below
    accept("build", "b")
    assert one.run("b" * 64).state == "succeeded"
    assert one.process is None
    assert not process.alive


def test_no_two_owners_have_one_name():
    assert owner_name() != owner_name()


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (["release"], "release"),
        (["cancel", "release"], "cancel"),
        (["release", "cancel"], "cancel"),
    ],
)
def test_a_build_ends_when_it_is_told_to_and_what_nobody_wants_goes_to_nobody(words, reason):
    interruption = Interruption()
    interruption.check()
    for word in words:
        getattr(interruption, word)()
    with pytest.raises(Interrupted) as caught:
        interruption.check()
    assert caught.value.reason == reason


def blank_picture(file_format, **options):
    """Return 16 megapixels of one colour in a small file."""
    stream = io.BytesIO()
    Image.new("RGB", (4000, 4000), (120, 40, 200)).save(stream, file_format, **options)
    return stream.getvalue()


def with_png_size(data, size):
    """Return a PNG file whose header states another size."""
    header = data[12:16] + struct.pack(">II", *size) + data[24:29]
    return data[:12] + header + struct.pack(">I", zlib.crc32(header)) + data[33:]


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells what is in use")
@pytest.mark.slow
def test_real_builds_are_bounded_by_the_header_of_a_picture_and_by_the_memory_limit(
    runner, book, store, sphere
):
    one = runner(command=WORKER_COMMAND)
    limit = max(one.warm().idle_bytes + (80 << 20), 256 << 20)
    one._settings = Settings(build_memory_bytes=limit)
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
    for data, code in cases:
        assert len(data) < 300_000
        job = gamut_id(Options(), hashlib.sha256(data).hexdigest())
        book.accept(job, Options().to_mapping())
        store.keep_input(job, data)
        outcome = one.run(job)
        assert outcome.document.attempts == 1
        assert (outcome.document.problem or {}).get("code") == code
        assert code is not None or outcome.seconds["metric"] > 0


MEBIBYTE = 1 << 20


def nothing(*_arguments):
    pass


@pytest.fixture
def process(scripted_worker):
    started = BuildProcess(scripted_worker)
    started.wait_until_ready(nothing)
    yield started
    started.kill()


@pytest.fixture
def result(process, tmp_path):
    """Have the process do what a text says, and return its final event."""

    def run(text, timeout=60.0, memory=0, progress=nothing, check=nothing):
        (tmp_path / "input").write_text(text)
        request = {
            "input": str(tmp_path / "input"),
            "output": str(tmp_path / "output"),
            "options": {"gamma": 1},
            "memory": memory,
        }
        return process.result(request, timeout=timeout, progress=progress, check=check)

    return run


def is_gone(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return True
    return False


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
def test_a_process_is_spoken_to_however_many_files_are_open(process, result):
    assert process.fileno() > 1024
    assert result("build")["event"] == "built"


def test_builds_follow_one_another_in_one_process(process, result):
    stages = []
    for _ in range(3):
        event = result("build", progress=lambda stage, fraction: stages.append((stage, fraction)))
        assert event["event"] == "built"
    assert stages == [(f"pid {process.pid}", 0.5)] * 3
    assert process.alive


@pytest.mark.parametrize("stopped", [False, True])
def test_the_deadline_ends_the_process_even_if_it_is_stopped(process, result, clock, stopped):
    looks = []

    def check():
        looks.append(1)
        clock.seconds += 20

    if stopped:
        os.kill(process.pid, signal.SIGSTOP)
    with pytest.raises(BuildTimeoutError):
        result("hang", timeout=60, check=check)
    assert len(looks) == 4
    assert not process.alive
    assert is_gone(process.pid)


@pytest.mark.slow
def test_a_build_that_fills_the_memory_is_ended_in_time(process, result):
    limit = process.private_bytes() + 100 * MEBIBYTE
    seen = []
    with pytest.raises(MemoryExceededError):
        result("swell", memory=limit, check=lambda: seen.append(process.private_bytes()))
    assert max(seen) > 50 * MEBIBYTE
    assert is_gone(process.pid)


def test_what_the_caller_finds_ends_the_process(process, result):
    class FoundError(Exception):
        pass

    looks = []

    def check():
        looks.append(1)
        if len(looks) > 3:
            raise FoundError

    with pytest.raises(FoundError):
        result("hang", check=check)
    assert is_gone(process.pid)


@pytest.mark.parametrize(("text", "reason"), [("die", "exit status 3"), ("garble", "unreadable")])
def test_a_process_that_dies_or_babbles_is_dead(process, result, text, reason):
    with pytest.raises(ProcessDiedError, match=reason):
        result(text)
    assert is_gone(process.pid)


def test_a_process_that_is_killed_is_told_by_its_signal(process, result):
    def kill(*_arguments):
        os.kill(process.pid, signal.SIGKILL)

    with pytest.raises(ProcessDiedError, match="signal 9"):
        result("hang", progress=kill)


def test_a_process_that_died_while_idle_is_noticed(process, result):
    os.kill(process.pid, signal.SIGKILL)
    with pytest.raises(ProcessDiedError):
        result("build")


@pytest.mark.parametrize(
    "script", ["raise SystemExit(1)", "print('hello', flush=True)", "print(1)"]
)
def test_what_is_no_worker_does_not_start(script):
    process = BuildProcess((sys.executable, "-S", "-c", script))
    with pytest.raises(ProcessDiedError):
        process.wait_until_ready(nothing)
    assert is_gone(process.pid)


@pytest.mark.slow
def test_only_what_was_touched_and_belongs_to_the_process_counts(tmp_path):
    size = 64 << 20
    (tmp_path / "file").write_bytes(bytes(size))
    before = private_bytes("self")
    with (tmp_path / "file").open("rb") as file:
        mapped = mmap.mmap(file.fileno(), size, access=mmap.ACCESS_READ)
        assert sum(mapped[::4096]) == 0
        assert private_bytes(os.getpid()) - before < size / 2
        mapped.close()
    reserved = mmap.mmap(-1, size, mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
    assert private_bytes("self") - before < size / 2
    for place in range(0, size, 4096):
        reserved[place] = 1
    assert private_bytes("self") - before > size * 0.9
    reserved.close()


@pytest.mark.parametrize("process", [0, "none"])
def test_of_no_process_nothing_is_known(process):
    assert private_bytes(process) is None


LEASE = 10.0


@pytest.fixture
def claim(book):
    book.accept(JOB, {})
    return book.claim(JOB, "me", LEASE)


def test_a_claim_holds_as_long_as_it_is_kept_and_its_progress_is_written_down(
    book, claim, clock, until
):
    with LeaseRenewer(book, claim, 0.01) as renewer:
        renewer.note("metric", 0.5)
        for _ in range(5):
            clock.seconds += 0.9 * LEASE
            until(lambda: book.read(JOB).lease_until > clock.seconds + 0.5 * LEASE)
            assert book.claim(JOB, "other", LEASE) is None
        until(lambda: book.read(JOB).stage == "metric")
        renewer.check()
    assert book.finish(renewer.claim, "succeeded").state == "succeeded"


def test_a_claim_that_is_not_kept_any_more_ends(book, claim, clock):
    with LeaseRenewer(book, claim, 0.01):
        pass
    clock.seconds += LEASE + 1
    assert book.claim(JOB, "other", LEASE) is not None


def test_who_was_cancelled_is_told(book, claim, until):
    with LeaseRenewer(book, claim, 0.01) as renewer:
        book.request_cancel(JOB)
        with pytest.raises(JobCancelledError):
            until(renewer.check)


def test_who_was_too_late_is_told(book, claim, clock, until):
    clock.seconds += LEASE + 1
    book.claim(JOB, "other", LEASE)
    with LeaseRenewer(book, claim, 0.01) as renewer, pytest.raises(LeaseLostError):
        until(renewer.check)


def test_a_store_that_fails_for_a_while_costs_nothing(book, claim, monkeypatch, until):
    heartbeat, failures = book.heartbeat, [StoreUnavailableError(), OSError(28, "full")]

    def fails_twice(*arguments):
        if failures:
            raise failures.pop()
        return heartbeat(*arguments)

    monkeypatch.setattr(book, "heartbeat", fails_twice)
    with LeaseRenewer(book, claim, 0.01) as renewer:
        renewer.note("metric", 0.5)
        until(lambda: book.read(JOB).stage == "metric")
        renewer.check()
