"""What only a bucket has: lost answers, refused credentials, outages; the rest is `test_blobs`."""

import contextlib
import os
import socket
from pathlib import Path
from types import SimpleNamespace

import pytest
from obstore.exceptions import BaseError

from service.storage import cloud, gamut_store, published
from service.storage.blobs import StoreUnavailableError
from service.storage.cloud import CloudBlobs
from service.storage.gamut_store import GamutStore

KEY = "jobs/ab/abcd.job"


@pytest.fixture
def quick(address, monkeypatch):  # noqa: ARG001 - it sets longer ones
    """No long pauses between the repetitions."""
    monkeypatch.setattr(cloud, "_WRITE_PAUSES", (0.01, 0.02))
    monkeypatch.setattr(cloud, "_READ_RETRIES", 1)
    monkeypatch.setattr(cloud, "_RETRY_SECONDS", 2)


@pytest.fixture
def proxied(proxy):
    """A bucket behind a proxy, and the proxy's class."""
    where, handler = proxy
    blobs = CloudBlobs(where)
    blobs.open()
    yield blobs, handler
    blobs.close()


def spoiled(times, how, method):
    """Spoil the first requests with a method."""
    left = iter(range(times))
    return staticmethod(
        lambda command, _path: how if command == method and next(left, None) is not None else None
    )


@pytest.mark.parametrize("how", ["lose", "refuse"])
@pytest.mark.slow
def test_a_write_whose_answer_is_lost_has_succeeded_once(proxied, how):
    blobs, handler = proxied
    handler.spoil = spoiled(1, how, "PUT")
    version = blobs.create(KEY, b"first")
    assert version is not None
    handler.spoil = spoiled(1, how, "PUT")
    assert blobs.create(KEY, b"other") is None
    handler.spoil = spoiled(1, how, "PUT")
    newer = blobs.replace(KEY, b"second", version)
    assert blobs.read(KEY) == (b"second", newer)
    handler.spoil = spoiled(1, how, "PUT")
    assert blobs.replace(KEY, b"third", version) is None


@pytest.mark.slow
def test_repetitions_come_to_an_end(proxied):
    blobs, handler = proxied
    handler.spoil = spoiled(1000, "refuse", "PUT")
    handler.requests.clear()
    with pytest.raises(StoreUnavailableError, match="503"):
        blobs.create(KEY, b"first")
    assert handler.requests == ["PUT"] * 3
    handler.spoil = None
    assert blobs.create(KEY, b"first") is not None


@pytest.mark.slow
def test_a_gamut_damaged_on_its_way_is_read_again_and_not_set_aside(proxied, publish):
    blobs, handler = proxied
    store = GamutStore(blobs)
    record = publish(store)
    handler.spoil = spoiled(1, "flip", "GET")
    assert store.content(record.id)[0] == record
    store._cached.discard(record.id)
    handler.spoil = spoiled(1, "flip", "GET")
    assert store.record(record.id) == record
    assert store.corruptions == 0


@pytest.mark.slow
def test_a_record_is_read_once_in_a_while_and_those_read_last_are_remembered(
    proxied, publish, monkeypatch
):
    blobs, handler = proxied
    clock = SimpleNamespace(now=1000.0)
    monkeypatch.setattr(gamut_store, "_CACHED_RECORDS", 2)
    monkeypatch.setattr(published, "time", SimpleNamespace(monotonic=lambda: clock.now))
    ids = [publish(GamutStore(blobs), number).id for number in range(3)]
    store = GamutStore(blobs)
    handler.requests.clear()
    for seconds, number, requests in (
        (0, 0, 1),
        (59, 0, 1),
        (0, 1, 2),
        (2, 0, 3),  # not believed any longer
        (0, 2, 4),  # the second is forgotten
        (0, 0, 4),
        (0, 2, 4),
        (0, 1, 5),
    ):
        clock.now += seconds
        assert store.record(ids[number]).id == ids[number]
        assert handler.requests == ["GET"] * requests


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize("how", ["nobody listens", "nobody answers"])
@pytest.mark.slow
def test_a_bucket_that_does_not_answer_is_unavailable(address, monkeypatch, how):
    where = address("s3")
    monkeypatch.setattr(cloud, "_SILENT_SECONDS", 0.3)
    silent = socket.create_server(("127.0.0.1", 0))
    port = silent.getsockname()[1]
    monkeypatch.setenv("AWS_ENDPOINT", f"http://127.0.0.1:{port}")
    if how == "nobody listens":
        silent.close()
    else:
        monkeypatch.setattr(cloud, "_REQUEST_SECONDS", 1)  # a write may take all of it
    with silent:
        _all_is_unavailable(where)


def _all_is_unavailable(where):
    blobs = CloudBlobs(where)
    for attempt in (
        blobs.open,
        lambda: blobs.read(KEY),
        lambda: blobs.create(KEY, b""),
        lambda: blobs.delete(KEY),
        lambda: list(blobs.keys("")),
    ):
        with pytest.raises(StoreUnavailableError) as caught:
            attempt()
        assert "127.0.0.1" not in str(caught.value)
        assert caught.value.__cause__ is None


def test_wrong_credentials_are_refused_without_telling_them(azure, monkeypatch, caplog):
    """By Azurite; moto's server accepts whatever it is given."""
    secret = "c2VjcmV0" * 8
    for name, value in {**azure, "AZURE_STORAGE_ACCOUNT_KEY": secret}.items():
        monkeypatch.setenv(name, value)
    blobs = CloudBlobs("az://bucket")
    with pytest.raises(StoreUnavailableError, match="403") as caught:
        blobs.open()
    with pytest.raises(StoreUnavailableError, match="PermissionDenied"):
        blobs.read(KEY)
    for text in (str(caught.value), caplog.text):
        assert secret not in text
        assert "http" not in text


@pytest.mark.slow
def test_scratch_files_go_with_their_process_however_it_ends(address, tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    where = address("s3")
    first, second = CloudBlobs(where), CloudBlobs(where)
    with pytest.raises(StoreUnavailableError):
        first.scratch(".x")
    first.open()
    kept = first.scratch(".x")
    kept.write_bytes(b"x")
    second.open()
    assert kept.exists()  # its process lives
    first._lock.close()  # as when it is killed
    third = CloudBlobs(where)
    third.open()
    assert not kept.exists()
    for blobs in (second, third):
        blobs.close()
    assert list(Path(tmp_path).iterdir()) == []
    with contextlib.suppress(StoreUnavailableError):
        first.close()


@pytest.mark.usefixtures("quick")
@pytest.mark.slow
def test_a_bucket_that_does_not_answer_is_tried_now_and_then_only(address, monkeypatch):
    where, clock, tries = address("s3"), SimpleNamespace(now=1000.0), []
    fake = SimpleNamespace(monotonic=lambda: clock.now, sleep=lambda _: None)
    monkeypatch.setattr(cloud, "time", fake)
    working = os.environ["AWS_ENDPOINT"]
    with socket.create_server(("127.0.0.1", 0)) as nobody:
        monkeypatch.setenv("AWS_ENDPOINT", f"http://127.0.0.1:{nobody.getsockname()[1]}")
    blobs = CloudBlobs(where)
    monkeypatch.setattr(cloud.obstore, "delete", lambda *_: tries.append(1) or _raise_timeout())
    for seconds, calls in ((0, 1), (0, 1), (4.9, 1), (0.2, 2), (0, 2), (5.1, 3)):
        clock.now += seconds
        with pytest.raises(StoreUnavailableError):
            blobs.delete(KEY)
        assert len(tries) == calls
    monkeypatch.undo()
    monkeypatch.setattr(cloud, "time", fake)
    monkeypatch.setenv("AWS_ENDPOINT", working)
    clock.now += 5.1
    monkeypatch.setattr(cloud.obstore, "delete", lambda *_: tries.append(1))
    for _ in range(3):
        blobs.delete(KEY)
    assert len(tries) == 6


def _raise_timeout():
    raise BaseError("Generic S3 error: HTTP error: request or response body error, kind: Timeout")


def test_a_service_shares_its_bucket_and_bears_its_outages(
    start_server, proxy, built, publish_built, assert_problem, sphere
):
    """What others have published it serves; while the bucket is away, what it has in memory."""
    where, bucket = proxy
    server = start_server(where)
    server.wait_ready()
    other = GamutStore(CloudBlobs(where))
    other.open()
    for gamut in built:
        publish_built(other, gamut)
    address, deleted = (f"/v1/gamuts/{gamut.id}" for gamut in built)
    for part in ("", "/levels", "/history", "/mesh", "/cusps"):
        assert server.client.get(f"{address}{part}").status_code == 200
    assert len(server.client.get("/v1/gamuts").json()["gamuts"]) == 2
    assert server.client.delete(deleted).status_code == 204
    assert server.client.get(deleted).status_code == 404
    assert [record.id for record in other.page("", 10)] == [built[0].id]
    other.close()
    mesh = server.client.get(f"{address}/mesh").content
    bucket.spoil = staticmethod(lambda *_: "lose")  # what is still connected
    bucket.close()
    answer = server.client.get(f"/v1/gamuts/{'0' * 64}")
    assert_problem(answer, 503, "store-unavailable")
    assert int(answer.headers["retry-after"]) > 0
    assert os.environ["AWS_ENDPOINT"] not in answer.text
    assert server.client.get(f"{address}/mesh").content == mesh
    for part in ("", "/levels", "/mesh?triangles=100", "/cusps"):
        assert server.client.get(f"{address}{part}").status_code == 200
    assert server.client.get("/livez").status_code == 200
    body = {"samples": sphere(seed=71)}
    assert_problem(server.client.post("/v1/gamuts", json=body), 503, "store-unavailable")
    ready = server.client.get("/readyz")
    assert ready.status_code == 200
    assert ready.json()["probes"]["store"]["status"] == "degraded"
    server.kill()
