import asyncio
import contextlib
import hashlib
import http.server
import itertools
import json
import logging
import os
import sys
import threading
from pathlib import Path

import httpx
import pytest

from gamutcore import Gamut, Options
from service.openapi.documentation import EXAMPLE_GAMUT
from service.storage.gamut_store import GamutStore
from service.storage.local import LocalBlobs
from service.storage.published import PublishedGamut

# The tests' folders are no packages.
sys.path.insert(0, str(Path(__file__).parent))
import browser as chromium
import emulators
import google_storage
from servers import Server, guarded_app, serve_app, server, shared_server, sphere, start_server

__all__ = ["Server", "guarded_app", "serve_app", "server", "sphere", "start_server"]


@pytest.fixture(autouse=True)
def _log_of_its_own():
    """End with the test what a command that it ran in this process set for all of the process."""
    root = logging.getLogger()
    level, handlers = root.level, root.handlers[:]
    yield
    root.setLevel(level)
    for handler in root.handlers[:]:
        if type(handler) is logging.StreamHandler and handler not in handlers:
            root.removeHandler(handler)
    logging.captureWarnings(capture=False)
    sys.excepthook, threading.excepthook = sys.__excepthook__, threading.__excepthook__


@pytest.fixture
def browser(tmp_path):
    """Open an address in a real browser, and return the page."""
    if reason := chromium.missing():
        if os.environ.get("CI") == "true":
            pytest.fail(reason)
        pytest.skip(reason)
    profiles = (tmp_path / f"profile{number}" for number in itertools.count())
    return lambda address: chromium.open_page(address, next(profiles))


@pytest.fixture(scope="session")
def s3(tmp_path_factory):
    """The environment of an S3 emulator with the bucket ``bucket``."""
    with emulators.s3_server(tmp_path_factory.mktemp("s3")) as environment:
        yield environment


@pytest.fixture(scope="session")
def azure(tmp_path_factory):
    """The environment of an Azure emulator with the container ``bucket``."""
    if reason := emulators.azurite_missing():
        if os.environ.get("CI") == "true":
            pytest.fail(reason)
        pytest.skip(reason)
    with emulators.azure_server(tmp_path_factory.mktemp("azure")) as environment:
        yield environment


@pytest.fixture(scope="session")
def gcs():
    """The environment of a server that behaves as Google's documentation says."""
    with google_storage.server() as environment:
        yield environment


@pytest.fixture(scope="session")
def gamut(server, sphere):
    """The description of a gamut that the shared server has built, and nobody deletes."""
    response = server.client.post("/v1/gamuts", json={"samples": sphere(seed=1)})
    assert response.status_code == 201, response.text
    return response.json()


@pytest.fixture(scope="session")
def slow_build():
    """What to post for a build that takes some seconds: a real press, sampled densely, `finest`."""
    path = Path(__file__).parents[2] / "examples" / "FOGRA39L.ti3"

    def arguments(surface_samples=60_000):
        options = {"surface_samples": surface_samples, "cost": "finest"}
        return {
            "files": {"file": ("FOGRA39L.ti3", path.read_bytes())},
            "data": {"options": json.dumps(options)},
        }

    return arguments


@pytest.fixture(scope="session")
def assert_problem():
    """Check that a response is a problem document with this code, and return it."""

    def check(response, status, code):
        assert response.status_code == status, response.text
        assert response.headers["content-type"] == "application/problem+json"
        assert response.headers["cache-control"] == "no-store"
        document = response.json()
        assert document["code"] == code, document
        assert document["status"] == status
        assert document["type"] == f"/problems/{code}"
        assert set(document) == {"type", "title", "status", "detail", "code", "where", "remedy"}
        assert all(document[name] for name in ("title", "detail", "remedy"))
        return document

    return check


@pytest.fixture(scope="session")
def request_app():
    """Send a request to an app in this process. Its lifespan does not run: it builds nothing."""

    def request(app, method, path, **arguments):
        async def send():
            transport = httpx.ASGITransport(app, raise_app_exceptions=False)
            fields = {"Accept-Encoding": "identity"}
            async with httpx.AsyncClient(
                transport=transport, base_url="http://localhost", headers=fields
            ) as client:
                return await client.request(method, path, **arguments)

        return asyncio.run(send())

    return request


class _Pages(http.server.BaseHTTPRequestHandler):
    """Serves web pages."""

    def do_GET(self):
        text = self.server.pages.get(self.path)
        self.send_response(404 if text is None else 200)
        self.send_header("Content-Type", "text/html; charset=utf-8")
        self.end_headers()
        self.wfile.write((text or "").encode())

    def log_message(self, *_):
        pass


@pytest.fixture(scope="session")
def page_origins():
    """Two origins of web pages; `pages` are those of both."""
    with contextlib.ExitStack() as stack:
        origins, pages = [], {}
        for _ in range(2):
            opened = stack.enter_context(http.server.ThreadingHTTPServer(("127.0.0.1", 0), _Pages))
            opened.pages = pages
            opened.url = f"http://127.0.0.1:{opened.server_port}"
            thread = threading.Thread(target=opened.serve_forever)
            thread.start()
            stack.callback(thread.join)
            stack.callback(opened.shutdown)
            origins.append(opened)
        yield origins


@pytest.fixture(scope="session")
def small_server(start_server, page_origins):
    """A server with small limits, which the first of two origins may use. Nothing is left running.

    One build may wait.
    """
    started = start_server(
        build_queue=1,
        client_requests=1,
        cors_origins=page_origins[0].url,
    )
    started.wait_ready()
    return started


@pytest.fixture(scope="session")
def built(sphere):
    """Two small gamuts, built here."""
    return [Gamut(json.dumps({"samples": sphere(seed)}).encode(), Options()) for seed in (10, 11)]


@pytest.fixture(scope="session")
def publish_built():
    """Publish a gamut that was built here, and return its record."""

    def published(store, gamut):
        content = gamut.to_bytes()
        path = store.scratch(".gamut")
        path.write_bytes(content)
        digest = hashlib.sha256(content).hexdigest()
        record = PublishedGamut(
            gamut.id, digest, len(content), "2026-01-01T00:00:00Z", gamut.description
        )
        return store.publish(record, path)

    return published


@pytest.fixture
def filled_store(tmp_path, built, publish_built):
    """A store with the gamuts of `built`."""
    opened = GamutStore(LocalBlobs(tmp_path / "data"))
    opened.open()
    for gamut in built:
        publish_built(opened, gamut)
    yield opened
    opened.close()


@pytest.fixture(scope="session")
def observed_server():
    """A server that logs every request as JSON."""
    return shared_server(log_format="json", access_log="true")


SCRIPTED_WORKER = """
import hashlib, json, os, sys, time
from pathlib import Path
def send(**event):
    print(json.dumps(event), flush=True)
send(event="ready")
for line in sys.stdin:
    request = json.loads(line)
    word = Path(request["input"]).read_text()
    begun = Path(sys.argv[1]) / "begun"
    with begun.open("a") as log:
        log.write(f"{os.getpid()} {word}\\n")
    send(event="progress", stage=f"pid {os.getpid()}", fraction=0.5)
    if word == "hang":
        time.sleep(1000)
    elif word == "die":
        os._exit(3)
    elif word == "garble":
        print("no JSON", flush=True)
    elif word == "swell":
        kept = [bytearray(os.urandom(1 << 20) * 8)]
        while True:
            kept.append(bytearray(kept[0]))
            time.sleep(0.005)
    elif word == "refuse":
        send(event="refused", code="missing-column", message="m", where={"column": "L"}, remedy=".")
    elif word == "exhaust":
        send(event="exhausted")
    elif word == "full":
        send(event="failed", errno=28)
    elif word == "defect":
        send(event="failed", errno=None)
    else:
        while word == "gate" and not (Path(sys.argv[1]) / "open").exists():
            time.sleep(0.01)
        content = json.dumps(request["options"]).encode()
        Path(request["output"]).write_bytes(content)
        digest = hashlib.sha256(content).hexdigest()
        description = DESCRIPTION | {"options": request["options"]}
        send(event="built", sha256=digest, nbytes=len(content), seconds={"metric": 0.25},
             description={} if word == "misdescribe" else description)
"""
"""A worker that does what the first word of its input says, without a compiler to wait for."""


@pytest.fixture
def scripted_worker(tmp_path):
    """The command line of a worker that follows a script, and the builds that it has begun."""
    path = tmp_path / "worker.py"
    path.write_text(f"DESCRIPTION = {EXAMPLE_GAMUT!r}\n{SCRIPTED_WORKER}")

    class Command(tuple):
        __slots__ = ()

        def begun(self, word=""):
            log = tmp_path / "begun"
            return log.read_text().count(f" {word}") if log.exists() else 0

        @staticmethod
        def open():
            """Let the builds of ``gate`` end."""
            (tmp_path / "open").touch()

    return Command((sys.executable, "-S", str(path), str(tmp_path)))
