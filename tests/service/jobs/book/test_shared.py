"""The job book in storage that several processes share."""

import concurrent.futures

import pytest

from service.jobs.book import JobBook
from service.problems.problem import Problem
from service.storage.local import LocalBlobs
from service.storage.location import blobs_at

JOB = "a" * 64
LEASE = 10.0
PROBLEM = Problem("build-crashed", "It died.", {"signal": 9}, "r")


@pytest.fixture(params=["a directory", "a bucket"])
def shared_blobs(request, tmp_path, monkeypatch):
    """Storage in which several processes compare and swap."""
    if request.param == "a directory":
        opened = LocalBlobs(tmp_path / "store")
    else:
        pytest.importorskip("obstore")
        for name, value in request.getfixturevalue("s3").items():
            monkeypatch.setenv(name, value)
        opened = blobs_at(f"s3://bucket/{tmp_path.name}")
    opened.open()
    yield opened
    opened.close()


@pytest.mark.slow
def test_of_many_who_ask_at_the_same_time_one_wins(shared_blobs):
    books = [JobBook(shared_blobs) for _ in range(8)]

    with concurrent.futures.ThreadPoolExecutor(len(books)) as threads:
        accepted = list(threads.map(lambda book: book.accept(JOB, {}), books))
        assert sum(new for _, new in accepted) == 1
        for attempt in (1, 2):
            claims = list(threads.map(lambda book: book.claim(JOB, "x", LEASE), books))
            (claim,) = [claim for claim in claims if claim is not None]
            assert claim.document.token == claim.document.attempts == attempt
            claim = books[0].heartbeat(claim, "metric", 0.5)
            books[1].record_crash(claim, PROBLEM)
        claim = books[0].claim(JOB, "x", LEASE)
        ends = [
            lambda: books[0].finish(claim, "succeeded"),
            lambda: books[1].request_cancel(JOB),
            lambda: books[2].finish(claim, "failed", PROBLEM),
        ]
        outcomes = [threads.submit(end) for end in ends]
        won = [outcome.result() for outcome in outcomes if outcome.exception() is None]
        assert {document.state for document in won} == {books[3].read(JOB).state}
        assert [document.id for document in books[0].page("", 9)] == [JOB]
