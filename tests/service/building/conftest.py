import pytest

from service.jobs.book import JobBook
from service.storage.gamuts import GamutStore
from service.storage.local import LocalBlobs

JOB = "a" * 64


@pytest.fixture
def store(tmp_path):
    opened = GamutStore(LocalBlobs(tmp_path / "store"))
    opened.open()
    yield opened
    opened.close()
    assert list((tmp_path / "store").rglob("*.gamut.tmp")) == []


@pytest.fixture
def book(store):
    return JobBook(store.blobs)


@pytest.fixture
def accept(store, book):
    """Accept a job whose input is a text, as `Builds.submit` does, and return it."""

    def accepted(text, name="a"):
        document, _ = book.accept(name * 64, {"gamma": 1})
        store.keep_input(document.id, text.encode(), document.options)
        return document

    return accepted
