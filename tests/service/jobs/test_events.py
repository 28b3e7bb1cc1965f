import asyncio
import dataclasses
import json

import pytest

from service.jobs.book import JobDocument, now, rfc3339
from service.jobs.events import EventStreams, event_id, stream_of_events
from service.storage.blobs import BlobDamagedError

RUNNING = JobDocument("a" * 64, {}, "running", "metric", 0.5, 1, token=3)
DONE = JobDocument("a" * 64, {}, "succeeded", "", 1.0, 1, token=3)


def stream(changes, known=None):
    async def all_changes():
        for change in changes:
            yield None if change is None else (change, {"state": change.state})

    async def collected():
        return [block async for block in stream_of_events(all_changes(), known)]

    return b"".join(asyncio.run(collected())).decode()


def events(text):
    """The events of a stream as a client reads them (WHATWG HTML, 9.2.6)."""
    found = []
    for block in text.split("\n\n"):
        fields = [line.split(": ", 1) for line in block.splitlines() if not line.startswith(":")]
        if any(name == "data" for name, _ in fields):
            found.append(dict(fields))
    return found


def test_the_job_is_told_as_it_changes_and_the_end_by_another_name():
    first, last = events(stream([RUNNING, None, DONE]))
    assert (first["event"], last["event"]) == ("progress", "finished")
    assert json.loads(first["data"]) == {"state": "running"}
    assert first["id"] == event_id(RUNNING) != event_id(DONE) == last["id"]


def test_no_two_events_of_a_stream_have_one_id():
    further = dataclasses.replace(RUNNING, fraction=0.5002)
    told = events(stream([RUNNING, RUNNING, further, None, further, DONE]))
    assert [event["id"] for event in told] == [event_id(RUNNING), event_id(DONE)]


def test_a_sign_of_life_is_no_event():
    text = stream([None])
    assert events(text) == []
    assert "\n:" in text


def test_who_comes_back_is_told_only_what_is_new():
    assert [event["event"] for event in events(stream([RUNNING, DONE], event_id(RUNNING)))] == [
        "finished"
    ]
    # the end is told to whoever asks, since a stream that tells nothing would be opened again
    assert len(events(stream([DONE], event_id(DONE)))) == 1


def test_the_number_of_streams_is_bounded_and_goes_down_again():
    streams = EventStreams(2)
    with streams.one():
        assert not streams.full
        with streams.one():
            assert streams.full
    assert streams.count == 0


JOB = "a" * 64


def test_a_document_is_read_back_whole_and_what_a_later_version_adds_is_let_go():
    document = JobDocument(JOB, {"gamma": 1}, "running", "metric", 0.5, 2)
    data = document.to_bytes()
    assert JobDocument.from_bytes(data) == document
    with pytest.raises(BlobDamagedError):
        JobDocument.from_bytes(data.replace(b"metric", b"maetric"))


def test_times_are_utc():
    assert now().endswith("Z")
    assert rfc3339(0.25) == "1970-01-01T00:00:00.250Z"
