"""Replicas that share a store, with workers that follow a script and a clock that tests move."""

import asyncio
import contextlib
import time
from types import SimpleNamespace

import pytest

from service.building import process
from service.building.builds import Builds
from service.building.job_runner import JobRunner
from service.building.local_engine import LocalEngine
from service.jobs.book import JobBook
from service.settings import Settings
from service.storage.gamut_store import GamutStore
from service.storage.local import LocalBlobs

PATIENCE = 600.0
"""Seconds that end a test that hangs."""


class Clock:
    """The time of leases and of the deadlines of builds, which goes on when a test says so."""

    def __init__(self):
        self.seconds = time.time()

    def __call__(self):
        return self.seconds


@pytest.fixture(scope="session")
def anyio_backend():
    return "asyncio"


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
    assert list(opened.scratch(".x").parent.iterdir()) == []
    opened.close()


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
    """Accept a job whose input is a text, as a process that then died."""

    def accepted(text, name="a"):
        document, _ = book.accept(name * 64, {"gamma": 1})
        store.keep_input(document.id, text.encode(), document.options)
        return document

    return accepted


@pytest.fixture
def reports():
    """What is reported of builds: a word, and the seconds of stages."""
    return []


@pytest.fixture
def replica(store, book, scripted_worker, reports):
    """Start a process of a service. All share one store, as replicas share a bucket."""

    @contextlib.asynccontextmanager
    async def started(*, sole_owner=False, command=scripted_worker, **settings):
        values = Settings(**{"drain_seconds": 0, **settings})
        engine = LocalEngine(
            values,
            store,
            book,
            sole_owner=sole_owner,
            command=command,
            on_build=lambda word, seconds: reports.append((word, seconds)),
        )
        builds = Builds(store, book, engine)
        async with asyncio.timeout(PATIENCE):
            await builds.start()
            try:
                yield builds
            finally:
                await builds.stop()

    return started
