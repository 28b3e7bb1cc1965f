import hashlib
import os

import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.store import GamutNotStoredError, GamutStore, Record, StoreInUseError

CONTENT = bytes(range(256)) * 40


def identity(number):
    return hashlib.sha256(str(number).encode()).hexdigest()


@pytest.fixture
def store(tmp_path):
    opened = GamutStore(tmp_path / "data")
    opened.open()
    yield opened
    opened.close()


def publish(store, number=0, content=CONTENT):
    gamut_id = identity(number)
    digest = hashlib.sha256(content).hexdigest()
    record = Record(gamut_id, digest, len(content), "2026-01-01T00:00:00Z", {"volume": 0.1})
    store.publish(record, store.write_temporary(".gamut", content))
    return record


def files(store, gamut_id):
    return sorted(store.published.rglob(f"{gamut_id}*"))


def test_what_is_published_is_read_back(store):
    record = publish(store)
    assert store.record(record.id) == record
    assert store.content(record.id) == (record, CONTENT)
    assert list(store.temporary.iterdir()) == []


def test_what_was_never_published_is_not_there(store):
    for read in (store.record, store.content, store.verified_file):
        with pytest.raises(GamutNotStoredError):
            read(identity(1))


def test_publishing_again_changes_nothing(store):
    first = publish(store)
    publish(store, content=b"other")
    assert store.content(first.id) == (first, CONTENT)
    assert list(store.temporary.iterdir()) == []


def test_a_content_without_a_record_is_no_gamut_and_is_no_obstacle(store):
    record = publish(store)
    files(store, record.id)[1].unlink()
    with pytest.raises(GamutNotStoredError):
        store.content(record.id)
    again = publish(store, content=b"rebuilt")
    assert store.content(record.id) == (again, b"rebuilt")


def test_another_process_gets_what_is_there_and_nothing_unfinished(store):
    record = publish(store)
    store.write_temporary(".input", b"left behind")
    store.close()
    other = GamutStore(store.directory)
    other.open()
    assert other.content(record.id) == (record, CONTENT)
    assert list(other.temporary.iterdir()) == []
    other.close()


def test_a_directory_belongs_to_one_process(store):
    with pytest.raises(StoreInUseError, match="GAMUT_DATA"):
        GamutStore(store.directory).open()


@pytest.mark.parametrize("which", [0, 1], ids=["history", "record"])
@pytest.mark.parametrize("damage", ["flip", "truncate", "extend", "empty", "remove"])
def test_damage_is_noticed_set_aside_and_mended_by_publishing(store, which, damage):
    record = publish(store)
    path = files(store, record.id)[which]
    data = path.read_bytes()
    middle = len(data) // 2
    if damage == "remove":
        path.unlink()
    else:
        path.write_bytes(
            {
                "flip": data[:middle] + bytes([data[middle] ^ 1]) + data[middle + 1 :],
                "truncate": data[:-1],
                "extend": data + b" ",
                "empty": b"",
            }[damage]
        )
    with pytest.raises(GamutNotStoredError):
        store.content(record.id)
    if not (which == 1 and damage == "remove"):
        assert files(store, record.id) == []
        assert list(store.quarantine.iterdir())
    publish(store)
    assert store.content(record.id) == (record, CONTENT)


@given(st.integers(0, 10**6), st.integers(0, 7))
def test_no_flipped_bit_in_a_record_goes_unnoticed(position, bit):
    data = Record("a" * 64, "b" * 64, 7, "now", {"volume": 1.5}).to_bytes()
    position %= len(data)
    flipped = data[:position] + bytes([data[position] ^ 1 << bit]) + data[position + 1 :]
    with pytest.raises((ValueError, TypeError)):
        Record.from_bytes(flipped)


def test_a_record_under_another_name_is_not_believed(store):
    record = publish(store)
    path = files(store, record.id)[1]
    other = "0" * 64
    (store.published / "00").mkdir()
    (store.published / "00" / f"{other}.record").write_bytes(path.read_bytes())
    with pytest.raises(GamutNotStoredError):
        store.record(other)


def test_deleting_removes_everything(store):
    record = publish(store)
    assert store.delete(record.id)
    assert files(store, record.id) == []
    assert not store.delete(record.id)


def test_an_open_history_outlives_its_deletion(store):
    record = publish(store)
    _, file = store.verified_file(record.id)
    with file:
        store.delete(record.id)
        assert file.read() == CONTENT


def test_pages_cover_all_gamuts_in_order_and_leave_damaged_ones_out(store):
    ids = sorted(publish(store, number).id for number in range(20))
    files(store, ids[4])[1].write_bytes(b"damaged")
    found, after = [], ""
    while page := store.page(after, 3):
        assert len(page) <= 3
        found += [record.id for record in page]
        after = found[-1]
    assert found == ids[:4] + ids[5:]


def test_a_full_disk_leaves_nothing_behind(store, monkeypatch):
    def no_space(_descriptor):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", no_space)
    with pytest.raises(OSError, match="No space"):
        publish(store)
    assert list(store.temporary.iterdir()) == []
    monkeypatch.undo()
    with pytest.raises(GamutNotStoredError):
        store.record(identity(0))
    assert store.content(publish(store).id)[1] == CONTENT


@pytest.mark.parametrize("content", [None, b"", CONTENT[:-1]])
def test_a_record_does_not_stand_for_a_history_file_that_is_gone(store, content):
    record = publish(store)
    path = files(store, record.id)[0]
    path.unlink()
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(GamutNotStoredError):
        store.record(record.id)
    assert files(store, record.id) == []
    assert store.page("", 10) == []
    publish(store)
    assert store.record(record.id) == record


def test_a_folder_of_somebody_else_does_not_stop_the_start(store):
    folder = store.temporary / "folder"
    folder.mkdir()
    store.write_temporary(".input", b"left behind")
    store.close()
    store.open()
    assert list(store.temporary.iterdir()) == [folder]
