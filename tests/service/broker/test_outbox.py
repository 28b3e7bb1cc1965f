"""Marks of jobs that were sent: found again when their messages are lost, and by one only."""

from concurrent.futures import ThreadPoolExecutor

import pytest

from service.broker.celery_app import Outbox
from service.jobs.book import JobBook
from service.storage.local import LocalBlobs

JOB, OTHER = "a" * 64, "b" * 64


class Clock:
    def __init__(self):
        self.seconds = 1_000_000.0

    def __call__(self):
        return self.seconds


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def blobs(tmp_path):
    opened = LocalBlobs(tmp_path / "store")
    opened.open()
    yield opened
    opened.close()


@pytest.fixture
def book(blobs, clock):
    return JobBook(blobs, clock=clock)


@pytest.fixture
def outbox(blobs, book, clock):
    return Outbox(blobs, book, clock)


def test_what_nobody_has_begun_is_sent_again_once_in_a_while(outbox, book, clock):
    book.accept(JOB, {})
    assert outbox.mark(JOB)
    assert not outbox.mark(JOB)
    assert outbox.count() == 1
    for _ in range(2):
        clock.seconds += 9
        assert list(outbox.overdue(10)) == []
        clock.seconds += 2
        assert list(outbox.overdue(10)) == [JOB]
        assert list(outbox.overdue(10)) == []


def test_of_all_who_look_one_sends(blobs, book, clock):
    for name in (JOB, OTHER):
        book.accept(name, {})
        Outbox(blobs, book, clock).mark(name)
    clock.seconds += 11
    with ThreadPoolExecutor(8) as pool:
        found = pool.map(lambda _: list(Outbox(blobs, book, clock).overdue(10)), range(8))
    assert sorted(name for names in found for name in names) == [JOB, OTHER]


def test_a_build_that_goes_on_is_left_alone_and_one_that_is_not_heard_of_sent_again(
    outbox, book, clock
):
    book.accept(JOB, {})
    outbox.mark(JOB)
    claim = book.claim(JOB, "worker", 5)
    for _ in range(10):
        clock.seconds += 4
        claim = book.heartbeat(claim, "decimation", 0.5)
        assert list(outbox.overdue(1)) == []
    clock.seconds += 6
    assert list(outbox.overdue(1)) == [JOB]
    document = book.read(JOB)
    assert (document.state, document.attempts) == ("queued", 1)


def test_what_has_killed_its_workers_too_often_fails_and_is_forgotten(outbox, book, clock):
    book.accept(JOB, {})
    outbox.mark(JOB)
    for attempt in (1, 2, 3):
        assert book.claim(JOB, "worker", 5)
        clock.seconds += 6
        assert list(outbox.overdue(1)) == ([JOB] if attempt < 3 else [])
    assert book.read(JOB).problem["code"] == "build-crashed"
    clock.seconds += 6
    assert list(outbox.overdue(1)) == []
    assert outbox.count() == 0


def test_marks_of_jobs_that_are_over_or_unknown_are_removed_and_others_stay(outbox, book):
    book.accept(JOB, {})
    for name in (JOB, OTHER):
        outbox.mark(name)
    outbox.remove(JOB)  # of an old job: the new one keeps its own
    assert list(outbox.ids()) == [JOB, OTHER]
    book.request_cancel(JOB)
    assert list(outbox.overdue(10)) == []
    assert outbox.count() == 0
