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
from service.storage.eviction import remove_uncommitted
from service.storage.gamut_store import GamutDamagedError, GamutNotStoredError, GamutStore
from service.storage.local import LocalBlobs
from service.storage.published import (
    PublishedGamut,
    blob_key,
    seal,
)

CONTENT = bytes(range(256)) * 40


def stored_keys(store):
    """The keys of all blobs."""
    return list(store.blobs.keys(""))


def files(store, gamut_id):
    """The files of a gamut: history, then record."""
    return sorted((store.blobs.directory / "published").rglob(f"{gamut_id}*"))


def quarantined(store):
    return list(store.blobs.keys("quarantine/"))


def test_what_one_publishes_the_other_serves_until_it_is_deleted(replicas, publish, unfinished):
    here, there = replicas
    record = publish(here)
    here.keep_input(record.id, b"data", {"gamma": 1})
    assert there.record(record.id) == record
    assert there.content(record.id) == (record, CONTENT)
    assert (there.hits, there.misses, there.corruptions) == (2, 0, 0)
    assert there.page("", 10) == [record]
    path = there.input_path(record.id)
    assert (path.read_bytes(), there.input_options(record.id)) == (b"data", {"gamma": 1})
    path.unlink()
    assert publish(there, content=b"other") == record
    assert len(list(here.blobs.keys("published/"))) == 2
    assert there.delete(record.id)
    assert not there.delete(record.id)
    assert stored_keys(here) == []
    with pytest.raises(GamutNotStoredError):
        here.content(record.id)
    assert unfinished(here) == unfinished(there) == []


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


DAMAGES = {
    "flip": lambda data: data[:9] + bytes([data[9] ^ 1]) + data[10:],
    "truncate": lambda data: data[:-1],
    "extend": lambda data: data + b" ",
    "empty": lambda _: b"",
    "remove": None,
}


@pytest.mark.parametrize("which", ["history", "record", "input"])
def test_damage_is_noticed_set_aside_and_mended(replicas, publish, which):
    """By another than the one who published it, if there is another."""
    here, there = replicas
    for turn, (damage, damaged) in enumerate(DAMAGES.items()):
        record = publish(here, turn)
        here.keep_input(record.id, b"input")
        keys = {
            "history": record.key,
            "record": blob_key(record.id, "record"),
            "input": blob_key(record.id, "input"),
        }
        data, _ = here.blobs.read(keys[which])
        here.blobs.delete(keys[which])
        if damaged is not None:
            here.blobs.create(keys[which], damaged(data))
        deleted = which == "record" and damage == "remove"
        before = there.corruptions
        if which == "input":
            with pytest.raises(BlobNotFoundError):
                there.input_path(record.id)
            assert not there.input_kept(record.id)
        else:
            with pytest.raises(GamutNotStoredError if deleted else GamutDamagedError) as caught:
                there.content(record.id)
            assert deleted or caught.value.input_kept
        noticed = not deleted and (which, damage) != ("input", "remove")
        assert there.corruptions == before + noticed
        if noticed:
            added = [key for key in quarantined(there) if record.id in key]
            (reason,) = [key for key in added if key.endswith(".reason")]
            moved = there.blobs.read(reason).data.decode().splitlines()[1:]
            assert {key.rpartition("/")[2] for key in moved} >= {
                key.removeprefix("quarantine/").rpartition(".")[0] for key in added if key != reason
            }
        here.keep_input(record.id, b"input")
        assert there.input_path(record.id).read_bytes() == b"input"
        assert there.to_be_rebuilt(record.id) == (noticed and which != "input")
        mended = publish(there, turn)
        there._cached.discard(record.id)
        assert there.content(record.id) == (mended, CONTENT)


@settings(max_examples=100, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data())
@pytest.mark.slow
def test_no_damage_of_any_file_is_served(store, publish, unfinished, data):
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
        if data.draw(st.booleans()):  # else it is noticed by the one who keeps it again
            with pytest.raises(BlobNotFoundError):
                store.input_path(record.id)
            assert not store.input_kept(record.id)
        store.keep_input(record.id, b"input" * 30, {"gamma": 0.2})
    else:
        with pytest.raises(GamutDamagedError) as caught:
            store.content(record.id)
        assert caught.value.input_kept
    assert store.corruptions == before + 1
    assert path.suffix == ".input" or not path.exists()
    store.keep_input(record.id, b"input" * 30)
    copy = store.input_path(record.id)
    assert copy.read_bytes() == b"input" * 30
    copy.unlink()
    mended = publish(store, content=b"history" * 30)
    assert store.content(record.id) == (mended, b"history" * 30)
    store.delete(record.id)
    assert unfinished(store) == []


def test_a_gamut_is_set_aside_for_what_is_in_it_but_not_one_that_replaced_it(replicas, publish):
    """Also by the one who remembers its record, while another has built it again."""
    here, there = replicas
    record = publish(here)
    there.delete(record.id)
    here.set_aside(record, "no history")
    assert stored_keys(here) == []
    mended = publish(there)
    assert here.content(record.id)[0] == mended
    assert isinstance(here.set_aside(record, "no history"), GamutDamagedError)
    assert here.content(record.id)[0] == mended
    assert here.corruptions == 0
    error = there.set_aside(mended, "no history")
    assert (error.args, error.input_kept) == ((record.id,), False)
    assert there.corruptions == 1
    with pytest.raises(GamutNotStoredError):
        here.content(record.id)


def test_of_two_who_find_a_damaged_record_the_second_leaves_what_has_mended_it(
    store, publish, monkeypatch
):
    record = publish(store)
    files(store, record.id)[1].write_bytes(b"damaged")
    read, second = store.blobs.read, []

    def read_and_let_others_in(key):
        found = read(key)
        if found.data == b"damaged":
            second.append(key)
        if len(second) == 3:  # it has been read for the last time
            second.append(key)
            with pytest.raises(GamutDamagedError):
                store.record(record.id)
            publish(store)
        return found

    monkeypatch.setattr(store.blobs, "read", read_and_let_others_in)
    with pytest.raises(GamutDamagedError):
        store.record(record.id)
    assert store.content(record.id)[1] == CONTENT
    assert store.corruptions == 1


def test_a_damaged_input_that_another_has_set_aside_counts_for_that_one(
    store, identity, monkeypatch
):
    store.keep_input(identity(0), b"data")
    store.blobs.path(blob_key(identity(0), "input")).write_bytes(b"damaged")
    move = store.blobs.move
    monkeypatch.setattr(
        store.blobs, "move", lambda key, to: move(key, f"{to}.other") and move(key, to)
    )
    with pytest.raises(BlobNotFoundError):
        store.input_options(identity(0))
    assert store.corruptions == 0


def test_a_record_under_another_name_is_not_believed(store, publish):
    record = publish(store)
    other = "0" * 64
    store.blobs.create(
        blob_key(other, "record"), store.blobs.read(blob_key(record.id, "record")).data
    )
    with pytest.raises(GamutDamagedError):
        store.record(other)
    assert store.content(record.id) == (record, CONTENT)


def test_inputs_go_with_publication_if_they_are_not_to_be_kept(tmp_path, publish, identity):
    store = GamutStore(LocalBlobs(tmp_path / "store"), keep_inputs=False)
    store.open()
    store.keep_input(identity(0), b"input")
    assert store.input_kept(identity(0))
    publish(store)
    assert not store.input_kept(identity(0))
    store.close()


def test_pages_follow_each_other_in_the_order_of_ids_without_what_is_damaged(store, publish):
    ids = sorted(publish(store, number).id for number in range(12))
    assert [record.id for record in store.page("", 100)] == ids
    assert [record.id for record in store.page("", 5)] == ids[:5]
    assert [record.id for record in store.page(ids[4], 5)] == ids[5:10]
    assert store.page(ids[-1], 5) == []
    files(store, ids[1])[1].write_bytes(b"")
    assert [record.id for record in store.page("", 5)] == [ids[0], *ids[2:6]]


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
    store.uses.mark(record.id)
    store.uses.flush()
    assert path.stat().st_mtime >= began - 0.01


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
    store.blobs.create(blob_key(identity("early"), "input"), content)
    path = store.input_path(identity("early"))
    assert path.read_bytes() == data
    assert store.input_options(identity("early")) == {"gamma": 0.2}
    path.unlink()


def test_histories_that_no_record_names_are_swept_and_all_else_stays(tmp_path):
    blobs = LocalBlobs(tmp_path / "store")
    blobs.open()
    for name, copies, record in (
        ("a", "0", b""),
        ("b", "012", None),
        ("c", "01", None),
        ("d", "01", b"damaged"),
        ("e", "0", None),
        ("f", "0", None),
    ):
        whole = PublishedGamut(name * 64, "", 1, "", {}, copy="0" * 16)
        for copy in copies:
            blobs.create(replace(whole, copy=copy * 16).key, b"x")
        if name in "abd":
            blobs.create(
                blob_key(whole.id, "record"), whole.to_bytes() if record is None else record
            )
    store = GamutStore(blobs)
    assert remove_uncommitted(store.blobs, store.uses, lambda: False) == 0  # told to end
    blobs.close()
    with store.uses.publishing("e" * 64):
        store.open()
        store._sweeping.join()
    left = [key.rpartition("/")[2].split(".") for key in blobs.keys("published/")]
    assert [(name[0], rest[0][0]) for name, *rest in left] == [
        *[("a", "0"), ("a", "r")],
        *[("b", "0"), ("b", "r")],
        *[("d", "0"), ("d", "1"), ("d", "r")],
        ("e", "0"),
    ]
    with pytest.raises(GamutNotStoredError):
        store.content("c" * 64)
    store.close()
