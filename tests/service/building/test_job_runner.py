import hashlib
import io
import json
import os
import signal
import struct
import sys
import threading
import time
import zlib
from pathlib import Path

import pytest
from PIL import Image

from gamutcore import Options
from gamutcore.building import gamut_id
from service.building.job_runner import Interrupted, Interruption, JobRunner, owner_name
from service.building.process import WORKER_COMMAND, ProcessDiedError
from service.settings import Settings
from service.storage.blobs import StoreUnavailableError

JOB = "a" * 64
EXAMPLE = Path(__file__).parents[3] / "examples" / "FOGRA39L.ti3"


@pytest.fixture
def reports():
    return []


@pytest.fixture
def runner(store, book, scripted_worker, reports):
    """Make a runner with settings, whose process follows a script."""
    made = []

    def make(command=scripted_worker, **settings):
        values = Settings(**{"build_timeout": 20, **settings})
        made.append(
            JobRunner(
                values,
                store,
                book,
                heartbeat=0.1,
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


def test_the_place_and_the_remedy_of_a_refusal_are_kept(runner, accept):
    accept("refuse")
    problem = runner().run(JOB).document.problem
    assert (problem["detail"], problem["where"], problem["remedy"]) == ("M.", {"column": "L"}, "R.")


@pytest.mark.parametrize(
    ("text", "settings", "code"),
    [
        ("hang", {"build_timeout": 0.3}, "build-timeout"),
        ("swell", {"build_memory_bytes": 256 << 20}, "build-out-of-memory"),
    ],
)
@pytest.mark.slow
def test_what_exceeds_a_limit_is_ended_once_and_the_next_is_built(
    runner, accept, scripted_worker, text, settings, code
):
    one = runner(**settings)
    accept(text)
    outcome = one.run(JOB)
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
def test_a_build_whose_process_died_is_begun_again(runner, accept):
    accept("die-until 3")
    outcome = runner().run(JOB)
    assert (outcome.state, outcome.document.attempts) == ("succeeded", 3)


@pytest.mark.slow
def test_a_build_is_repeated_until_its_process_is_left_alone(runner, accept, store):
    accept("0.3")
    victims = []

    def kill(document):
        if document.stage and len(victims) < 2:
            victims.append(int(document.stage.split()[1]))
            os.kill(victims[-1], signal.SIGKILL)

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


@pytest.mark.slow
def test_a_build_that_was_cancelled_elsewhere_is_ended_by_the_next_heartbeat(runner, accept, book):
    accept("hang")

    def cancel() -> None:
        while book.read(JOB).state != "running":
            time.sleep(0.01)
        book.request_cancel(JOB)

    cancelling = threading.Thread(target=cancel)
    cancelling.start()
    assert runner().run(JOB).state == "cancelled"
    cancelling.join()


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


def test_a_job_of_another_version_fails_and_its_data_goes(runner, accept, store):
    accept("outdate")
    outcome = runner().run(JOB)
    assert (outcome.state, outcome.document.problem["code"]) == ("failed", "build-outdated")
    assert not store.input_kept(JOB)
    assert not store.is_stored(JOB)


def test_a_job_whose_input_is_gone_fails(runner, accept, store):
    accept("build")
    store.drop_input(JOB)
    outcome = runner().run(JOB)
    assert outcome.document.problem["code"] == "build-input-lost"


@pytest.mark.parametrize("method", ["is_stored", "publish", "input_path"])
@pytest.mark.parametrize(
    ("error", "code"),
    [
        (OSError(5, "a bad disk"), "store-unavailable"),
        (RuntimeError("a defect"), "build-failed"),
        (OSError(28, "No space left on device"), "storage-full"),
        (OSError(24, "Too many open files"), "overloaded"),
    ],
)
@pytest.mark.slow
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


def test_an_end_that_cannot_be_written_down_is_told_all_the_same(runner, accept, book, monkeypatch):
    def fails(*_arguments):
        raise OSError(28, "No space left on device")

    accept("full")
    monkeypatch.setattr(book, "finish", fails)
    outcome = runner().run(JOB)
    assert outcome.state == "unwritten"
    assert outcome.document.problem["code"] == "storage-full"
    assert book.read(JOB).state == "running"


def test_a_process_that_does_not_start_costs_no_attempt(runner, accept, book):
    accept("build")
    one = runner(command=("/bin/false",))
    with pytest.raises(ProcessDiedError):
        one.run(JOB)
    assert book.read(JOB).attempts == 0


def test_starting_is_given_up_when_it_is_told_to(runner):
    interruption = Interruption()
    timer = threading.Timer(0.2, interruption.release)
    timer.start()
    clock = time.monotonic()
    outcome = runner(command=("/bin/sleep", "1000")).run(JOB, interruption)
    assert (outcome.state, time.monotonic() - clock < 60) == ("released", True)
    timer.join()


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


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells what is in use")
@pytest.mark.slow
def test_a_real_build_beyond_its_memory_fails_once_and_a_small_one_is_built(
    runner, book, store, sphere
):
    one = runner(command=WORKER_COMMAND, build_timeout=100)
    limit = max(one.warm().idle_bytes + (80 << 20), 256 << 20)
    one = runner(command=WORKER_COMMAND, build_timeout=100, build_memory_bytes=limit)
    inputs = [
        (EXAMPLE.read_bytes(), {"surface_samples": 1_000_000}),
        (json.dumps({"samples": sphere()}).encode(), {}),
    ]
    outcomes = []
    for data, mapping in inputs:
        options = Options.from_mapping(mapping)
        name = gamut_id(options, hashlib.sha256(data).hexdigest())
        book.accept(name, options.to_mapping())
        store.keep_input(name, data)
        outcomes.append(one.run(name))
    greedy, modest = (outcome.document for outcome in outcomes)
    assert (greedy.problem["code"], greedy.attempts) == ("build-out-of-memory", 1)
    assert modest.state == "succeeded"
    assert outcomes[1].seconds["metric"] > 0


def test_no_two_owners_have_one_name():
    assert owner_name() != owner_name()


def test_nothing_ends_until_it_is_told_to():
    interruption = Interruption()
    interruption.check()
    interruption.release()
    with pytest.raises(Interrupted) as caught:
        interruption.check()
    assert caught.value.reason == "release"


@pytest.mark.parametrize("order", [["cancel", "release"], ["release", "cancel"]])
def test_what_nobody_wants_is_not_given_to_another(order):
    interruption = Interruption()
    for word in order:
        getattr(interruption, word)()
    with pytest.raises(Interrupted) as caught:
        interruption.check()
    assert caught.value.reason == "cancel"


def blank_picture(file_format, **options):
    """Return 24 megapixels of one colour in a small file."""
    stream = io.BytesIO()
    Image.new("RGB", (6000, 4000), (120, 40, 200)).save(stream, file_format, **options)
    return stream.getvalue()


def with_png_size(data, size):
    """Return a PNG file whose header states another size."""
    header = data[12:16] + struct.pack(">II", *size) + data[24:29]
    return data[:12] + header + struct.pack(">I", zlib.crc32(header)) + data[33:]


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells what is in use")
@pytest.mark.slow
def test_small_files_of_large_pictures_are_bounded_by_their_header_and_by_the_memory_limit(
    runner, book, store, sphere
):
    one = runner(command=WORKER_COMMAND)
    limit = max(one.warm().idle_bytes + (200 << 20), 256 << 20)
    one = runner(command=WORKER_COMMAND, build_memory_bytes=limit)
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
        document = one.run(job).document
        assert document.attempts == 1
        assert (document.problem or {}).get("code") == code
