import contextlib
import hashlib
import json
import os
import threading
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, replace

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from service.storage.blobs import BlobNotFoundError, StoreUnavailableError
from service.storage.gamuts import GamutDamagedError, GamutNotStoredError, GamutStore
from service.storage.local import LocalBlobs
from service.storage.records import (
    Record,
    RecordCache,
    history_key,
    id_of,
    input_key,
    record_key,
    seal,
)
from service.storage.sweep import remove_uncommitted

CONTENT = bytes(range(256)) * 40


def files(store, gamut_id):
    """The files of a gamut: history, then record."""
    return sorted((store.blobs.directory / "published").rglob(f"{gamut_id}*"))


def quarantined(store):
    return list(store.blobs.keys("quarantine/"))


def reopened(store):
    """The same directory as another process would find it; the caller closes it."""
    other = GamutStore(LocalBlobs(store.blobs.directory))
    other.open()
    other._sweeping.join()
    return other


def test_what_is_published_is_read_back(store, publish, unfinished):
    record = publish(store)
    assert store.record(record.id) == record
    assert store.content(record.id) == (record, CONTENT)
    assert unfinished(store) == []
    assert (store.hits, store.misses, store.corruptions) == (2, 0, 0)


def test_what_was_never_published_is_not_there(store, identity):
    for read in (store.record, store.content, store.verified_file):
        with pytest.raises(GamutNotStoredError):
            read(identity(1))
    assert (store.hits, store.misses) == (0, 3)


def test_looking_whether_a_gamut_is_stored_is_no_use_of_it(store, publish, identity):
    record = publish(store)
    assert store.is_stored(record.id)
    assert not store.is_stored(identity(1))
    (folder,) = {path.parent for path in files(store, record.id)}
    (folder / f"{record.id}.record").write_bytes(b"damaged")
    assert not store.is_stored(record.id)
    assert (store.hits, store.misses, store.corruptions) == (0, 0, 1)


def test_publishing_again_changes_nothing(store, publish, unfinished):
    first = publish(store)
    assert publish(store, content=b"other") == first
    assert store.content(first.id) == (first, CONTENT)
    assert unfinished(store) == []
    assert len(files(store, first.id)) == 2


def test_of_concurrent_publishers_one_wins_and_all_are_told_which(store, publish):
    barrier = threading.Barrier(8)

    def attempt(number):
        barrier.wait()
        return publish(store, content=b"%d" % number * 1000)

    with ThreadPoolExecutor(8) as threads:
        (winner,) = {record.sha256: record for record in threads.map(attempt, range(8))}.values()
    assert store.content(winner.id)[0] == winner
    assert len(files(store, winner.id)) == 2


@pytest.mark.slow
def test_publishers_deleters_and_readers_never_meet_half_a_gamut(store, publish, identity):
    gamut_id, seen, deleted = identity(0), Counter(), []
    deadline = time.monotonic() + 600

    def go_on():
        enough = min(seen[b"1"], seen[b"2"]) >= 20 and len(deleted) >= 100
        return not enough and time.monotonic() < deadline

    def publishing(number):
        while go_on():
            # Whoever is told that it is published can read it, unless it is deleted since.
            with contextlib.suppress(GamutNotStoredError, StoreUnavailableError):
                publish(store, content=b"%d" % number * 5000)

    def deleting():
        while go_on():
            deleted.extend([1] * store.delete(gamut_id))

    def reading():
        while go_on():
            with contextlib.suppress(GamutNotStoredError):
                content = store.content(gamut_id)[1]
                assert content == content[:1] * 5000
                seen[content[:1]] += 1

    with ThreadPoolExecutor(6) as threads:
        work = [threads.submit(publishing, number) for number in (1, 2)]
        work += [threads.submit(deleting), *(threads.submit(reading) for _ in range(3))]
        for done in work:
            done.result()
    assert set(seen) == {b"1", b"2"}
    publish(store, content=b"last")
    assert len(store.content(gamut_id)[1]) in {4, 5000}


def test_a_history_without_a_record_is_no_gamut_and_is_swept(store, publish):
    record = publish(store)
    files(store, record.id)[1].unlink()
    with pytest.raises(GamutNotStoredError):
        store.content(record.id)
    store.close()
    other = reopened(store)
    assert files(other, record.id) == []
    again = publish(other, content=b"rebuilt")
    assert other.content(record.id) == (again, b"rebuilt")
    other.close()


def test_a_loser_s_history_is_swept_and_the_winner_s_stays(store, publish):
    record = publish(store)
    loser = store.blobs.path(replace(record, copy="0" * 16).key)
    loser.write_bytes(b"not committed")
    store.close()
    other = reopened(store)
    assert not loser.exists()
    assert other.content(record.id) == (record, CONTENT)
    other.close()


def test_a_gamut_of_before_there_were_copies_is_served_and_deleted(store, publish):
    record = publish(store)
    fields = asdict(record)
    del fields["copy"]
    history, record_file = files(store, record.id)
    history.rename(history.with_name(f"{record.id}.gamut"))
    record_file.write_bytes(seal(json.dumps(fields, separators=(",", ":")).encode()))
    assert store.content(record.id)[1] == CONTENT
    assert store.delete(record.id)
    assert files(store, record.id) == []


@pytest.mark.parametrize("which", [0, 1], ids=["history", "record"])
@pytest.mark.parametrize("damage", ["flip", "truncate", "extend", "empty", "remove"])
def test_damage_is_noticed_set_aside_and_mended_by_publishing(
    store, publish, caplog, which, damage
):
    record = publish(store)
    store.keep_input(record.id, b"input")
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
    deleted = which == 1 and damage == "remove"
    with pytest.raises(GamutNotStoredError if deleted else GamutDamagedError) as caught:
        store.content(record.id)
    if not deleted:
        assert caught.value.input_kept
        assert store.corruptions == 1
        assert files(store, record.id) == []
        (reason,) = [key for key in quarantined(store) if key.endswith(".reason")]
        assert record.id in store.blobs.read(reason).data.decode()
        assert "quarantine" in caplog.text
    assert not store.delete(record.id)
    again = publish(store)
    assert store.content(record.id) == (again, CONTENT)


@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data())
@pytest.mark.slow
def test_no_damage_of_any_file_is_served(store, publish, data):
    """Any bit of any file flipped, or any part of its end lost: noticed, counted, and mended."""
    record = publish(store, content=b"history" * 30)
    store.keep_input(record.id, b"input" * 30, {"gamma": 0.2})
    paths = sorted(store.blobs.path(key) for key in store.blobs.keys("") if "quarantine" not in key)
    assert len(paths) == 3
    path = data.draw(st.sampled_from(paths))
    content = bytearray(path.read_bytes())
    position = data.draw(st.integers(0, len(content) - 1))
    if data.draw(st.booleans()):
        content[position] ^= 1 << data.draw(st.integers(0, 7))
    else:
        del content[position:]
    path.write_bytes(content)
    before = store.corruptions
    if path.suffix == ".input":
        with pytest.raises(BlobNotFoundError):
            store.input_path(record.id)
    else:
        with pytest.raises(GamutDamagedError) as caught:
            store.content(record.id)
        assert caught.value.input_kept
    assert store.corruptions == before + 1
    assert not path.exists()
    store.keep_input(record.id, b"input" * 30)
    assert store.input_path(record.id).read_bytes() == b"input" * 30
    mended = publish(store, content=b"history" * 30)
    assert store.content(record.id) == (mended, b"history" * 30)
    store.delete(record.id)


def test_a_sound_gamut_is_not_set_aside_for_what_its_predecessor_was(store, publish):
    """Two readers find the same damage; by the time of the second it has been mended."""
    record = publish(store)
    record_file = files(store, record.id)[1]
    damaged = record_file.read_bytes()[:-2]
    record_file.write_bytes(damaged)
    with pytest.raises(GamutDamagedError):
        store.record(record.id)
    mended = publish(store)
    store._quarantine_gamut(record.id, "found by the second reader", None, damaged)
    assert isinstance(store.set_aside(record, "found by the second reader"), GamutDamagedError)
    assert store.content(record.id) == (mended, CONTENT)
    assert store.corruptions == 1


def test_nothing_is_set_aside_for_a_gamut_that_was_deleted(store, publish):
    record = publish(store)
    store.delete(record.id)
    store.set_aside(record, "no history")
    assert store.corruptions == 0
    assert list(store.blobs.keys("")) == []


def test_a_damaged_gamut_without_its_input_says_so(store, publish):
    record = publish(store)
    files(store, record.id)[0].write_bytes(b"")
    with pytest.raises(GamutDamagedError) as caught:
        store.record(record.id)
    assert not caught.value.input_kept
    assert caught.value.args == (record.id,)


def test_a_record_under_another_name_is_not_believed(store, publish):
    record = publish(store)
    other = "0" * 64
    store.blobs.create(record_key(other), store.blobs.read(record_key(record.id)).data)
    with pytest.raises(GamutDamagedError):
        store.record(other)
    assert store.content(record.id) == (record, CONTENT)


def test_a_gamut_can_be_set_aside_for_what_is_in_it(store, publish):
    record = publish(store)
    error = store.set_aside(record, "no history")
    assert isinstance(error, GamutDamagedError)
    assert files(store, record.id) == []
    with pytest.raises(GamutNotStoredError):
        store.record(record.id)
    assert not store.to_be_rebuilt(record.id)
    store.keep_input(record.id, b"data")
    assert store.to_be_rebuilt(record.id)
    assert not store.to_be_rebuilt("0" * 64)


def test_deleting_removes_everything(store, publish):
    record = publish(store)
    store.keep_input(record.id, b"input")
    assert store.delete(record.id)
    assert not store.delete(record.id)
    assert list(store.blobs.keys("")) == []


def test_an_open_history_survives_its_deletion(store, publish):
    record = publish(store)
    _, file = store.verified_file(record.id)
    store.delete(record.id)
    with file:
        assert file.read() == CONTENT


def test_inputs_go_with_publication_if_they_are_not_to_be_kept(tmp_path, publish, identity):
    store = GamutStore(LocalBlobs(tmp_path / "store"), keep_inputs=False)
    store.open()
    store.keep_input(identity(0), b"input")
    assert store.input_kept(identity(0))
    publish(store)
    assert not store.input_kept(identity(0))
    store.close()


def test_pages_follow_each_other_in_the_order_of_ids(store, publish):
    ids = sorted(publish(store, number).id for number in range(12))
    assert [record.id for record in store.page("", 100)] == ids
    assert [record.id for record in store.page("", 5)] == ids[:5]
    assert [record.id for record in store.page(ids[4], 5)] == ids[5:10]
    assert store.page(ids[-1], 5) == []


def test_a_damaged_record_is_left_out_of_the_pages(store, publish):
    ids = sorted(publish(store, number).id for number in range(3))
    files(store, ids[1])[1].write_bytes(b"")
    assert [record.id for record in store.page("", 5)] == [ids[0], ids[2]]


def test_a_failed_publication_leaves_nothing(store, publish, identity, unfinished, monkeypatch):
    create, failing = store.blobs.create, [OSError(5, "a bad disk")]

    def fails_once(key, content):
        if key.endswith(".record") and failing:
            raise failing.pop()
        return create(key, content)

    monkeypatch.setattr(store.blobs, "create", fails_once)
    with pytest.raises(OSError, match="a bad disk"):
        publish(store)
    assert files(store, identity(0)) == []
    assert unfinished(store) == []
    assert store.content(publish(store).id)[1] == CONTENT


def test_last_uses_are_written_down(store, publish):
    record = publish(store)
    path = files(store, record.id)[1]
    os.utime(path, (1, 1))
    began = time.time()
    store.mark_used(record.id)
    store.flush_uses()
    assert path.stat().st_mtime >= began - 0.01


def test_every_key_tells_its_gamut_and_no_two_are_the_same():
    keys = [record_key("a" * 64), input_key("a" * 64), history_key("a" * 64, "")]
    assert {id_of(key) for key in keys} == {"a" * 64}
    assert len(set(keys)) == 3


@pytest.fixture(scope="module")
def records():
    return [Record(letter * 64, "", 1, "", {}) for letter in "abc"]


def test_the_records_read_last_are_kept(records):
    cache = RecordCache(2, 100.0)
    for record in (records[0], records[1], records[0], records[2]):
        cache.put(record)
    assert [cache.get(record.id) for record in records] == [records[0], None, records[2]]


def test_none_is_believed_for_longer_than_its_time(records, monkeypatch):
    cache, now = RecordCache(2, 100.0), time.monotonic()
    monkeypatch.setattr(time, "monotonic", lambda: now)
    cache.put(records[0])
    now += 99
    assert cache.get(records[0].id) == records[0]
    now += 2
    assert cache.get(records[0].id) is None


def test_without_a_time_nothing_is_kept(records):
    cache = RecordCache(2, 0)
    cache.put(records[0])
    assert cache.get(records[0].id) is None


ANY = settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])


@ANY
@given(st.binary(max_size=3000), st.dictionaries(st.text(), st.integers() | st.text()))
def test_data_and_options_are_read_back(store, identity, data, options):
    gamut_id = identity("any")
    store.drop_input(gamut_id)
    store.keep_input(gamut_id, data, options)
    path = store.input_path(gamut_id)
    assert path.read_bytes() == data
    assert store.input_options(gamut_id) == options
    path.unlink()


def test_an_input_stays_until_it_is_dropped(store, identity, unfinished):
    assert not store.input_kept(identity(1))
    store.keep_input(identity(1), b"data")
    store.keep_input(identity(1), b"data")
    assert store.input_kept(identity(1))
    assert unfinished(store) == []
    assert store.drop_input(identity(1))
    assert not store.drop_input(identity(1))
    for read in (store.input_path, store.input_options):
        with pytest.raises(BlobNotFoundError):
            read(identity(1))
    assert unfinished(store) == []


@pytest.mark.parametrize("data", [b"the data of an input", b""])
def test_inputs_of_earlier_versions_are_read(store, identity, data):
    # SHA-256 of everything after the first line, a line with the options, the data
    rest = b'{"gamma":0.2}\n' + data
    content = hashlib.sha256(rest).hexdigest().encode() + b"\n" + rest
    store.blobs.create(input_key(identity("early")), content)
    path = store.input_path(identity("early"))
    assert path.read_bytes() == data
    assert store.input_options(identity("early")) == {"gamma": 0.2}
    path.unlink()


def put(blobs, name, copies, record=None):
    """Histories of a gamut, and perhaps the record that names one of them."""
    whole = Record(name * 64, "", 1, "", {})
    for copy in copies:
        blobs.create(replace(whole, copy=copy * 16).key, b"x")
    if record is not None:
        blobs.create(record_key(whole.id), record or replace(whole, copy=copies[0] * 16).to_bytes())
    return whole.id


def test_what_no_record_names_goes_and_all_else_stays(local):
    sound = put(local, "a", "0", b"")
    winner = put(local, "b", "012", b"")
    put(local, "c", "01")
    damaged = put(local, "d", "01", b"damaged")
    making = put(local, "e", "0")
    assert remove_uncommitted(local, making.__eq__, lambda: True) == 4
    left = [key.partition("/")[2].partition("/")[2] for key in local.keys("published/")]
    assert left == [
        f"{sound}.{'0' * 16}.gamut",
        f"{sound}.record",
        f"{winner}.{'0' * 16}.gamut",
        f"{winner}.record",
        f"{damaged}.{'0' * 16}.gamut",
        f"{damaged}.{'1' * 16}.gamut",
        f"{damaged}.record",
        f"{making}.{'0' * 16}.gamut",
    ]


def test_it_ends_when_it_is_told_to(local):
    put(local, "c", "01")
    assert remove_uncommitted(local, lambda _: False, lambda: False) == 0


@ANY
@given(st.data())
@pytest.mark.slow
def test_no_damage_goes_unnoticed_and_keeping_mends_it(store, identity, unfinished, data):
    gamut_id = identity("damaged")
    store.drop_input(gamut_id)
    store.keep_input(gamut_id, b"the data of an input", {"gamma": 0.2})
    path = store.blobs.path(input_key(gamut_id))
    content = bytearray(path.read_bytes())
    position = data.draw(st.integers(0, len(content) - 1))
    if data.draw(st.booleans()):
        content[position] ^= 1 << data.draw(st.integers(0, 7))
    else:
        del content[position:]
    path.write_bytes(content)
    before = store.corruptions
    if data.draw(st.booleans()):
        with pytest.raises(BlobNotFoundError):
            store.input_path(gamut_id)
        assert not store.input_kept(gamut_id)
    store.keep_input(gamut_id, b"the data of an input", {"gamma": 0.2})
    assert store.corruptions == before + 1
    path = store.input_path(gamut_id)
    assert path.read_bytes() == b"the data of an input"
    path.unlink()
    assert unfinished(store) == []
