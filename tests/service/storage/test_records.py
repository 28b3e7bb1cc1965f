import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.storage.records import Record, RecordCache, history_key, id_of, input_key, record_key

RECORD = Record("a" * 64, "b" * 64, 7, "now", {"volume": 1.5}, "c" * 16)


def test_a_record_is_read_back():
    assert Record.from_bytes(RECORD.to_bytes()) == RECORD


@given(st.integers(0, 10**6), st.integers(0, 7))
def test_no_flipped_bit_in_a_record_goes_unnoticed(position, bit):
    data = RECORD.to_bytes()
    position %= len(data)
    flipped = data[:position] + bytes([data[position] ^ 1 << bit]) + data[position + 1 :]
    with pytest.raises((ValueError, TypeError)):
        Record.from_bytes(flipped)


def test_every_key_tells_its_gamut_and_no_two_are_the_same():
    keys = [record_key("a" * 64), input_key("a" * 64), history_key("a" * 64, ""), RECORD.key]
    assert {id_of(key) for key in keys} == {"a" * 64}
    assert len(set(keys)) == 4


@pytest.fixture(scope="module")
def records():
    return [Record(letter * 64, "", 1, "", {}) for letter in "abc"]


def test_the_records_read_last_are_kept(records):
    cache = RecordCache(2, 100.0)
    for record in (records[0], records[1], records[0], records[2]):
        cache.put(record)
    assert [cache.get(record.id) for record in records] == [records[0], None, records[2]]


def test_a_record_in_doubt_is_forgotten(records):
    cache = RecordCache(2, 100.0)
    cache.put(records[0])
    cache.discard(records[0].id)
    cache.discard(records[1].id)
    assert cache.get(records[0].id) is None


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
