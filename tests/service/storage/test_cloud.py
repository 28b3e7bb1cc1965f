"""What only a bucket has: lost answers, refused credentials, outages; the rest is `test_blobs`."""

import contextlib
import http.client
import http.server
import os
import socket
import threading
from pathlib import Path

import pytest

from service.storage import cloud
from service.storage.blobs import BlobNotFoundError, StoreUnavailableError
from service.storage.cloud import CloudBlobs
from service.storage.gamuts import GamutDamagedError, GamutNotStoredError, GamutStore
from service.storage.records import input_key, record_key

KEY = "jobs/ab/abcd.job"


@pytest.fixture
def quick(address, monkeypatch):  # noqa: ARG001 - it sets longer ones
    """No long pauses between the repetitions."""
    monkeypatch.setattr(cloud, "_WRITE_PAUSES", (0.01, 0.02))
    monkeypatch.setattr(cloud, "_READ_RETRIES", 1)
    monkeypatch.setattr(cloud, "_RETRY_SECONDS", 2)


class Proxy(http.server.BaseHTTPRequestHandler):
    """Passes requests on to the emulator, except for what a test has it spoil."""

    protocol_version = "HTTP/1.1"
    target = ""
    spoil = None
    requests: list[str]

    def do(self):
        body = self.rfile.read(int(self.headers.get("Content-Length") or 0))
        self.requests.append(self.command)
        how = self.spoil(self.command, self.path) if self.spoil else None
        status, headers, answer = 503, {}, b""
        if how != "refuse":
            connection = http.client.HTTPConnection(self.target.removeprefix("http://"))
            with contextlib.closing(connection):
                connection.request(self.command, self.path, body, dict(self.headers))
                response = connection.getresponse()
                status, headers, answer = response.status, response.headers, response.read()
        if how == "lose":
            self.close_connection = True
            return
        if how == "flip" and answer:
            answer = answer[:-1] + bytes([answer[-1] ^ 1])
        self.send_response(status)
        for name, value in dict(headers).items():
            if name.lower() not in {"content-length", "connection", "transfer-encoding", "date"}:
                self.send_header(name, value)
        length = dict(headers).get("Content-Length", len(answer))
        self.send_header("Content-Length", str(length))
        self.end_headers()
        self.wfile.write(answer)

    do_GET = do_PUT = do_POST = do_DELETE = do_HEAD = do  # noqa: N815 - the names it calls

    def log_message(self, *_):
        """Say nothing."""


@pytest.fixture
def proxied(address, monkeypatch):
    """A bucket behind a proxy, and the proxy's class: ``spoil`` says what happens to a request."""
    where = address("s3")
    handler = type("Spoiling", (Proxy,), {"target": os.environ["AWS_ENDPOINT"], "requests": []})
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
    server.daemon_threads = True
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    monkeypatch.setenv("AWS_ENDPOINT", f"http://127.0.0.1:{server.server_port}")
    monkeypatch.setattr(cloud, "_WRITE_PAUSES", (0.01, 0.02))
    blobs = CloudBlobs(where)
    blobs.open()
    yield blobs, handler
    blobs.close()
    server.shutdown()
    server.server_close()
    thread.join()


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
def test_describing_a_gamut_again_asks_nobody(proxied, publish):
    blobs, handler = proxied
    store = GamutStore(blobs)
    record = publish(store)
    other = GamutStore(blobs)
    handler.requests.clear()
    assert [other.record(record.id) for _ in range(100)] == [record] * 100
    assert handler.requests == ["GET"]


@pytest.mark.parametrize("kind", ["s3", "gcs", "azure"])
class TestGamuts:
    """Gamuts in a bucket; everything else about them is in `test_gamuts`."""

    @pytest.fixture
    def stores(self, kind, address):
        """Two replicas."""
        where = address(kind)
        stores = [GamutStore(CloudBlobs(where)) for _ in range(2)]
        for store in stores:
            store.open()
        yield stores
        for store in stores:
            store.close()

    def test_what_one_publishes_the_other_serves_until_it_is_deleted(
        self, stores, publish, unfinished
    ):
        here, there = stores
        record = publish(here)
        here.keep_input(record.id, b"data", {"gamma": 1})
        assert there.content(record.id)[0] == record
        assert there.page("", 10) == [record]
        path = there.input_path(record.id)
        assert (path.read_bytes(), there.input_options(record.id)) == (b"data", {"gamma": 1})
        path.unlink()
        assert publish(there, content=b"other") == record
        assert there.delete(record.id)
        assert not there.delete(record.id)
        assert list(here.blobs.keys("")) == []
        with pytest.raises(GamutNotStoredError):
            here.content(record.id)
        assert [path for path in unfinished(here) if path.name != "lock"] == []

    @pytest.mark.parametrize("which", ["record", "history"])
    @pytest.mark.parametrize("damage", ["flip", "truncate", "remove"])
    def test_damage_is_noticed_set_aside_and_mended(self, stores, publish, which, damage):
        here, there = stores
        record = publish(here)
        here.keep_input(record.id, b"data")
        key = record.key if which == "history" else record_key(record.id)
        data, _ = here.blobs.read(key)
        here.blobs.delete(key)
        if damage != "remove":
            flipped = data[:9] + bytes([data[9] ^ 1]) + data[10:]
            here.blobs.create(key, flipped if damage == "flip" else data[:-1])
        gone = (which, damage) == ("record", "remove")
        with pytest.raises(GamutNotStoredError if gone else GamutDamagedError) as caught:
            there.content(record.id)
        assert gone or caught.value.input_kept
        assert there.corruptions == (0 if gone else 1)
        mended = publish(there)
        there._cached.discard(record.id)
        assert there.content(record.id)[0] == mended

    def test_only_the_gamut_that_was_read_is_set_aside(self, stores, publish):
        """Also by the one who remembers its record, while another replica has built it again."""
        here, there = stores
        record = publish(here)
        there.delete(record.id)
        mended = publish(there)
        assert here.content(record.id)[0] == mended
        here.set_aside(record, "no history")
        assert here.content(record.id)[0] == mended
        assert here.corruptions == 0
        there.set_aside(mended, "no history")
        assert there.corruptions == 1
        with pytest.raises(GamutNotStoredError):
            here.content(record.id)

    def test_a_damaged_input_is_none(self, stores, identity):
        here, there = stores
        here.keep_input(identity(1), b"data")
        data, version = here.blobs.read(input_key(identity(1)))
        here.blobs.replace(input_key(identity(1)), data[:-1], version)
        with pytest.raises(BlobNotFoundError):
            there.input_path(identity(1))
        there.keep_input(identity(1), b"data")
        assert here.input_path(identity(1)).read_bytes() == b"data"


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
