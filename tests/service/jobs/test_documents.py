import pytest

from service.jobs.documents import JobDocument, now, rfc3339
from service.storage.blobs import BlobDamagedError

JOB = "a" * 64


def test_a_document_is_read_back_whole_and_what_a_later_version_adds_is_let_go():
    document = JobDocument(JOB, {"gamma": 1}, "running", "metric", 0.5, 2, trace={"a": "b"})
    data = document.to_bytes()
    assert JobDocument.from_bytes(data) == document
    with pytest.raises(BlobDamagedError):
        JobDocument.from_bytes(data.replace(b"metric", b"maetric"))


def test_times_are_utc():
    assert now().endswith("Z")
    assert rfc3339(0.25) == "1970-01-01T00:00:00.250Z"
