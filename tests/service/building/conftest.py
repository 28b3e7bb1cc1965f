"""A store, its jobs, and a clock that the tests move."""

import time
from types import SimpleNamespace

import pytest

from service.building import process
from service.building.job_runner import JobRunner
from service.jobs.book import JobBook
from service.storage.gamuts import GamutStore
from service.storage.local import LocalBlobs

PATIENCE = 600.0
"""Seconds that end a test that hangs."""


class Clock:
    """The time of leases and of the deadlines of builds, which goes on when a test says so."""

    def __init__(self):
        self.seconds = time.time()

    def __call__(self):
        return self.seconds


@pytest.fixture(autouse=True)
def clock(monkeypatch):
    made = Clock()
    monkeypatch.setattr(process, "time", SimpleNamespace(monotonic=made))
    # The progress of a build is stored, and a cancellation noticed, at the next heartbeat.
    monkeypatch.setitem(JobRunner.__init__.__kwdefaults__, "heartbeat", 0.05)
    return made


@pytest.fixture
def store(tmp_path):
    opened = GamutStore(LocalBlobs(tmp_path / "store"))
    opened.open()
    yield opened
    opened.close()
    assert list((tmp_path / "store").rglob("*.gamut.tmp")) == []


@pytest.fixture
def book(store, clock):
    return JobBook(
        store.blobs,
        clock=clock,
        lost_options=store.options_of_damaged_job,
        on_damaged=store.count_damaged_job,
    )


@pytest.fixture
def accept(store, book):
    """Accept a job whose input is a text, as `Builds.submit` does, and return it."""

    def accepted(text, name="a"):
        document, _ = book.accept(name * 64, {"gamma": 1})
        store.keep_input(document.id, text.encode(), document.options)
        return document

    return accepted


@pytest.fixture(scope="session")
def until():
    """Wait until a condition holds."""

    def wait(condition):
        deadline = time.monotonic() + PATIENCE
        while not condition():
            assert time.monotonic() < deadline
            time.sleep(0.01)

    return wait
