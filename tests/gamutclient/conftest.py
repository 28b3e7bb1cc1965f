"""Gamuts here and on the service, and servers that answer as a busy service does."""

import http.server
import sys
import threading
from pathlib import Path

import gamutclient
import httpx
import pytest
from gamutclient import clients

import gamutcore

# The tests' folders are no packages.
sys.path.insert(0, str(Path(__file__).parents[1] / "service"))
from servers import guarded_app, serve_app, server, sphere, start_server

__all__ = ["guarded_app", "serve_app", "server", "sphere", "start_server"]

EXAMPLE = Path(__file__).parents[2] / "examples" / "FOGRA39L.ti3"
SAMPLES = 1000


@pytest.fixture(autouse=True)
def _unhurried(monkeypatch):
    """A slow machine reaches no time limit of a client."""
    monkeypatch.setattr(clients, "TIMEOUT", httpx.Timeout(600.0))


@pytest.fixture(scope="session")
def client(server):
    with gamutclient.Client(server.url, timeout=600) as opened:
        yield opened


@pytest.fixture(scope="session")
def local():
    """A press and sRGB, built in this process."""
    return (
        gamutcore.Gamut(EXAMPLE, surface_samples=SAMPLES, ink_limit=300),
        gamutcore.reference("sRGB", surface_samples=SAMPLES),
    )


@pytest.fixture(scope="session")
def remote(client):
    """The same, built by the service. Only the first word of each line differs."""
    return (
        client.build(EXAMPLE, surface_samples=SAMPLES, ink_limit=300),
        client.reference("sRGB", surface_samples=SAMPLES),
    )


@pytest.fixture(params=["local", "remote"])
def gamuts(request):
    """The press and sRGB, here and on the service."""
    return request.getfixturevalue(request.param)


@pytest.fixture
def press(gamuts):
    return gamuts[0]


@pytest.fixture
def srgb(gamuts):
    return gamuts[1]


class _Script(http.server.BaseHTTPRequestHandler):
    """Answers with what the test put into `server.answers`; the last answer stays."""

    protocol_version = "HTTP/1.1"

    def _answer(self):
        self.rfile.read(int(self.headers.get("content-length", 0)))
        self.server.requests.append((self.command, self.path, dict(self.headers)))
        answers = self.server.answers
        status, headers, body = answers.pop(0) if len(answers) > 1 else answers[0]
        if status is None:
            self.connection.close()
            self.close_connection = True
            return
        self.send_response(status)
        for name, value in {"Content-Length": str(len(body)), **headers}.items():
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(body)

    do_GET = _answer  # noqa: N815  # the name that the base class calls

    def log_message(self, *_):
        pass


@pytest.fixture
def scripted():
    """A server whose answers a test writes: (status, headers, body), or None for no answer."""
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), _Script) as opened:
        opened.requests, opened.answers = [], []
        opened.url = f"http://127.0.0.1:{opened.server_port}"
        thread = threading.Thread(target=opened.serve_forever)
        thread.start()
        yield opened
        opened.shutdown()
        thread.join()
