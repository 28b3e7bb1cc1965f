import hashlib
from itertools import count

import pytest

from service.storage import cloud
from service.storage.cloud import CloudBlobs
from service.storage.gamuts import GamutStore
from service.storage.local import LocalBlobs
from service.storage.records import Record

PREFIXES = count()


@pytest.fixture
def address(request, monkeypatch):
    """Return an unused address in the bucket of an emulator: ``s3``, ``gcs`` or ``azure``.

    It is waited for, however slow the machine is.
    """
    for name in ("_CONNECT_SECONDS", "_SILENT_SECONDS", "_REQUEST_SECONDS", "_RETRY_SECONDS"):
        monkeypatch.setattr(cloud, name, 600)

    def unused(kind):
        for name, value in request.getfixturevalue(kind).items():
            monkeypatch.setenv(name, value)
        return f"{ {'s3': 's3', 'gcs': 'gs', 'azure': 'az'}[kind] }://bucket/test/{next(PREFIXES)}"

    return unused


@pytest.fixture(params=["local", "s3", "gcs", "azure"])
def blobs(request, tmp_path, address):
    """An open storage of every kind in turn."""
    if request.param == "local":
        opened = LocalBlobs(tmp_path / "store")
    else:
        opened = CloudBlobs(address(request.param))
    opened.open()
    yield opened
    opened.close()


@pytest.fixture
def local(tmp_path):
    """An open local storage."""
    opened = LocalBlobs(tmp_path / "store")
    opened.open()
    yield opened
    opened.close()


@pytest.fixture
def store(tmp_path):
    """An open local store."""
    opened = GamutStore(LocalBlobs(tmp_path / "store"))
    opened.open()
    yield opened
    opened.close()


@pytest.fixture(scope="session")
def identity():
    """The id of the gamut of some number."""
    return lambda number: hashlib.sha256(str(number).encode()).hexdigest()


@pytest.fixture(scope="session")
def publish(identity):
    """Publish some content as the gamut of some number."""

    def published(store, number=0, content=bytes(range(256)) * 40):
        digest = hashlib.sha256(content).hexdigest()
        path = store.scratch(".gamut")
        path.write_bytes(content)
        record = Record(
            identity(number), digest, len(content), "2026-01-01T00:00:00Z", {"volume": 0.1}
        )
        return store.publish(record, path)

    return published


@pytest.fixture(scope="session")
def unfinished():
    """What is left in a local store's folder of work in progress."""
    return lambda store: list(store.scratch("").parent.iterdir())
