import time

import pytest

from service.storage.record_cache import RecordCache
from service.storage.records import Record


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
