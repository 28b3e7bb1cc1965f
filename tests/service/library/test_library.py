import asyncio
import hashlib
import threading
from collections import Counter

import pytest

from gamutcore.history import columns
from service.admission import Admission
from service.library import Library
from service.storage.gamut_store import GamutDamagedError, GamutNotStoredError
from service.storage.published import PublishedGamut

NAME = "a" * 64


def run(library, scenario):
    try:
        asyncio.run(scenario)
    finally:
        library.close()


def published(store, content, description=None):
    """The record of some bytes, which are in the store from now on."""
    digest = hashlib.sha256(content).hexdigest()
    path = store.scratch(".gamut")
    path.write_bytes(content)
    return store.publish(PublishedGamut(NAME, digest, len(content), "", description or {}), path)


def of_a_damaged_stream(gamut):
    """The bytes of a gamut, except for the last of its finest levels."""
    content = bytearray(gamut.to_bytes())
    content[-1] ^= 255
    return bytes(content)


def test_a_file_that_is_no_history_is_set_aside(filled_store):
    record = published(filled_store, b"intact, but of another kind")
    library = Library(filled_store, Admission(10**9, most_waiting=9), 10**9, 10**9)

    async def scenario():
        with pytest.raises(GamutNotStoredError):
            await library.open(record.id)
        assert list(filled_store.blobs.keys("quarantine/"))

    run(library, scenario())


def test_a_file_with_a_damaged_stream_is_set_aside_when_that_is_asked_for(filled_store, built):
    """Its digest is right: it was written like that."""
    record = published(filled_store, of_a_damaged_stream(built[0]), built[0].description)
    library = Library(filled_store, Admission(10**9, most_waiting=9), 10**9, 10**9)
    triangles = built[0].history.triangles

    async def scenario():
        opened = await library.open(record.id)
        await library.unpack(opened, 10)
        assert opened.gamut.level(10) == built[0].level(10)
        wanted = (library.unpack(opened, triangles) for _ in range(3))
        errors = await asyncio.gather(*wanted, return_exceptions=True)
        assert all(isinstance(error, GamutDamagedError) for error in errors)
        assert library.find_open(record.id) is None
        assert list(filled_store.blobs.keys("quarantine/"))
        with pytest.raises(GamutNotStoredError):
            await library.open(record.id)

    run(library, scenario())


def test_a_reader_of_a_damaged_gamut_leaves_the_one_that_replaced_it(filled_store, built):
    """Two requests hold it; by the time of the second it has been set aside, mended and opened."""
    published(filled_store, of_a_damaged_stream(built[0]))
    library = Library(filled_store, Admission(10**9, most_waiting=9), 10**9, 10**9)
    triangles = built[0].history.triangles

    async def scenario():
        damaged = await library.open(NAME)
        with pytest.raises(GamutDamagedError):
            await library.unpack(damaged, triangles)
        record = published(filled_store, built[0].to_bytes())
        mended = await library.open(NAME)
        with pytest.raises(GamutDamagedError):
            await library.unpack(damaged, triangles)
        assert library.find_open(NAME) is mended
        assert filled_store.record(NAME) == record
        assert filled_store.corruptions == 1
        await library.unpack(mended, triangles)
        assert mended.gamut.history.full() == built[0].history.full()

    run(library, scenario())


def test_what_replaced_a_file_that_is_no_history_while_it_was_read_stays(
    filled_store, built, monkeypatch
):
    published(filled_store, b"intact, but of another kind")
    library, content, mended = (
        Library(filled_store, Admission(10**9, most_waiting=9), 10**9, 10**9),
        filled_store.content,
        [],
    )

    def replaced_when_read(gamut_id):
        found = content(gamut_id)
        filled_store.delete(gamut_id)
        mended.append(published(filled_store, built[0].to_bytes()))
        return found

    async def scenario():
        with monkeypatch.context() as patch:
            patch.setattr(filled_store, "content", replaced_when_read)
            with pytest.raises(GamutDamagedError):
                await library.open(NAME)
        assert [filled_store.record(NAME)] == mended
        assert filled_store.corruptions == 0
        assert (await library.open(NAME)).record == mended[0]

    run(library, scenario())


def test_a_gamut_that_could_not_be_unpacked_is_opened_anew(filled_store, built, monkeypatch):
    library = Library(filled_store, Admission(10**9, most_waiting=9), 10**9, 10**9)
    triangles = built[0].history.triangles

    def no_memory(*_):
        raise MemoryError

    async def scenario():
        opened = await library.open(built[0].id)
        monkeypatch.setattr(columns, "_inflate_columns", no_memory)
        with pytest.raises(MemoryError):
            await library.unpack(opened, triangles)
        monkeypatch.undo()
        again = await library.open(built[0].id)
        await library.unpack(again, triangles)
        assert again.gamut.history.full() == built[0].history.full()
        assert not list(filled_store.blobs.keys("quarantine/"))

    run(library, scenario())


class CounterOfOneThread(Counter):
    """A count that is changed in the main thread alone, because adding is not atomic."""

    def __setitem__(self, key, value):
        assert threading.current_thread() is threading.main_thread()
        super().__setitem__(key, value)


def test_memory_is_counted_in_the_thread_of_the_loop(filled_store, built):
    admission = Admission(10**9, most_waiting=9)
    admission.held = CounterOfOneThread()
    library = Library(filled_store, admission, 10**9, 10**9)

    async def scenario():
        opened = await library.open(built[0].id)
        assert admission.held["gamuts"] == opened.gamut.nbytes > 0

    run(library, scenario())
