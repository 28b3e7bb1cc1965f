import time

import pytest

from service.building.lease_renewer import LeaseRenewer
from service.jobs.book import JobCancelledError, LeaseLostError
from service.storage.blobs import StoreUnavailableError

JOB = "a" * 64


LEASE = 1.0
"""Seconds. Busy machines keep threads waiting for tenths of a second."""


@pytest.fixture
def claim(book):
    book.accept(JOB, {})
    return book.claim(JOB, "me", LEASE)


def until(condition):
    deadline = time.monotonic() + 20
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.01)


@pytest.mark.slow
def test_a_claim_holds_as_long_as_it_is_kept_and_its_progress_is_written_down(book, claim):
    with LeaseRenewer(book, claim, 0.05) as renewer:
        renewer.note("metric", 0.5)
        until(lambda: book.read(JOB).stage == "metric")
        time.sleep(1.2 * LEASE)
        assert book.claim(JOB, "other", 1.0) is None
        renewer.check()
    assert book.finish(renewer.claim, "succeeded").state == "succeeded"


@pytest.mark.slow
def test_a_claim_that_is_not_kept_any_more_ends(book, claim):
    with LeaseRenewer(book, claim, 0.05):
        pass
    time.sleep(1.2 * LEASE)
    assert book.claim(JOB, "other", 1.0) is not None


def test_who_was_cancelled_is_told(book, claim):
    with LeaseRenewer(book, claim, 0.05) as renewer:
        book.request_cancel(JOB)
        with pytest.raises(JobCancelledError):
            until(renewer.check)


@pytest.mark.slow
def test_who_was_too_late_is_told(book, claim):
    time.sleep(1.2 * LEASE)
    book.claim(JOB, "other", 10.0)
    with LeaseRenewer(book, claim, 0.05) as renewer, pytest.raises(LeaseLostError):
        until(renewer.check)


def test_a_store_that_fails_for_a_while_costs_nothing(book, claim, monkeypatch):
    heartbeat, failures = book.heartbeat, [StoreUnavailableError(), OSError(28, "full")]

    def fails_twice(*arguments):
        if failures:
            raise failures.pop()
        return heartbeat(*arguments)

    monkeypatch.setattr(book, "heartbeat", fails_twice)
    with LeaseRenewer(book, claim, 0.05) as renewer:
        renewer.note("metric", 0.5)
        until(lambda: book.read(JOB).stage == "metric")
        renewer.check()
