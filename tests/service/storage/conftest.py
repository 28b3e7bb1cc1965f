import contextlib
import hashlib
import http.client
import http.server
import os
import threading
from itertools import count

import pytest

from service.storage import cloud
from service.storage.cloud import CloudBlobs
from service.storage.gamut_store import GamutStore
from service.storage.local import LocalBlobs
from service.storage.published import PublishedGamut

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


@pytest.fixture(params=["local", "s3", "gcs", "azure"])
def replicas(request, tmp_path, address):
    """Two who use the same storage, of every kind in turn; a directory has one process only."""
    if request.param == "local":
        opened = [GamutStore(LocalBlobs(tmp_path / "store"))]
    else:
        where = address(request.param)
        opened = [GamutStore(CloudBlobs(where)) for _ in range(2)]
    for store in opened:
        store.open()
    yield opened[0], opened[-1]
    for store in opened:
        store.close()


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
        record = PublishedGamut(
            identity(number), digest, len(content), "2026-01-01T00:00:00Z", {"volume": 0.1}
        )
        return store.publish(record, path)

    return published


@pytest.fixture(scope="session")
def unfinished():
    """What is left in a local store's folder of work in progress."""
    return lambda store: [
        path for path in store.scratch("").parent.iterdir() if path.name != "lock"
    ]


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
def proxy(address, monkeypatch):
    """An address behind a proxy, and the proxy's class: ``spoil`` says what happens to a request.

    The proxy itself is there until it is closed.
    """
    where = address("s3")
    handler = type("Spoiling", (Proxy,), {"target": os.environ["AWS_ENDPOINT"], "requests": []})
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
    server.daemon_threads = True
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    monkeypatch.setenv("AWS_ENDPOINT", f"http://127.0.0.1:{server.server_port}")
    monkeypatch.setattr(cloud, "_WRITE_PAUSES", (0.01, 0.02))

    def close():
        server.shutdown()
        server.server_close()
        thread.join()

    handler.close = close
    yield where, handler
    close()
