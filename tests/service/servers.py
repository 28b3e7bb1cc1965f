"""Services in processes of their own, and the fixtures that share them among folders of tests."""

import atexit
import contextlib
import os
import re
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import httpx
import numpy as np
import pytest
import uvicorn

from service.access.api_keys import new_key
from service.application import create_app
from service.server import server_config
from service.settings import Settings
from service.storage.gamut_store import GamutStore
from service.storage.local import LocalBlobs

PATIENCE = 600
"""Seconds that end a test that hangs. No test of a sound service comes near."""

READY = re.compile(r"Uvicorn running on http://(?:127\.0\.0\.1|0\.0\.0\.0):(\d+)")
WARM = re.compile(r"build worker (\d+) is warm")

UNHURRIED = {
    "build_timeout": 3600,
    "client_wait": 300,
    "body_timeout": PATIENCE,
}
"""Settings of servers whose test is not about time: a slow machine cannot reach them."""


PATIENT_WITH_BUCKETS = (
    "from service.storage import cloud;"
    f"cloud._CONNECT_SECONDS = cloud._SILENT_SECONDS = cloud._REQUEST_SECONDS = {PATIENCE}"
)


class Server:
    """A service in a process of its own, as `gamut serve` starts it."""

    def __init__(self, data: Path, log: Path, **settings) -> None:
        self.data = data
        self.log_path = log
        environment = {
            **{name: value for name, value in os.environ.items() if not name.startswith("GAMUT_")},
            **{
                f"GAMUT_{name.upper()}": str(value)
                for name, value in {**UNHURRIED, **settings}.items()
            },
        }
        command = "import sys; from service.__main__ import main; sys.exit(main())"
        if "://" in str(data):
            command = f"{PATIENT_WITH_BUCKETS}; {command}"
        with log.open("wb") as output:
            self.process = subprocess.Popen(
                [sys.executable, "-c", command, "serve", "--port", "0", "--store", str(data)],
                env=environment,
                stdout=output,
                stderr=subprocess.STDOUT,
            )
        self.url = f"http://127.0.0.1:{self.logged(READY)}"
        # Without a content coding, so that digests are those of what a test sees.
        fields = {"Accept-Encoding": "identity"}
        self.client = httpx.Client(base_url=self.url, timeout=PATIENCE, headers=fields)

    def log(self):
        return self.log_path.read_text()

    def logged(self, pattern, count=1):
        """The first group of the count-th match of a pattern in the log, waited for."""
        deadline = time.monotonic() + PATIENCE
        while time.monotonic() < deadline:
            found = pattern.findall(self.log())
            if len(found) >= count:
                return found[count - 1]
            if self.process.poll() is not None:
                break
            time.sleep(0.02)
        pytest.fail(f"no {pattern.pattern!r} in the log:\n{self.log()}")

    def wait_ready(self):
        return self.wait_for(lambda: self.client.get("/readyz").status_code == 200)

    def wait_for(self, condition):
        deadline = time.monotonic() + PATIENCE
        while not (value := condition()):
            assert time.monotonic() < deadline, self.log()
            time.sleep(0.02)
        return value

    def finished_job(self, address):
        """The document of a job, when it is done."""
        return self.wait_for(lambda: (job := self.client.get(address).json())["finished"] and job)

    def worker(self, count=1):
        """The process id of the count-th worker that became warm."""
        return int(self.logged(WARM, count))

    def builds_started(self, gamut_id):
        return self.log().count(f"build of {gamut_id} started")

    def stop(self):
        """End it as an operator does; it has to go in good order."""
        self.client.close()
        self.process.send_signal(signal.SIGTERM)
        # uvicorn shuts everything down and then lets the signal have its usual effect.
        assert self.process.wait(PATIENCE) == -signal.SIGTERM
        assert "Application shutdown complete" in self.log()
        assert "Traceback" not in self.log()

    def kill(self):
        """End it as a power cut does."""
        self.client.close()
        self.process.kill()
        self.process.wait(PATIENCE)

    def end(self):
        """End it if it still runs."""
        if self.process.poll() is None:
            self.client.close()
            self.process.terminate()
            self.process.wait(PATIENCE)


READER = new_key("reader", frozenset({"read"}))
WRITER = new_key("writer", frozenset({"write"}))
"""Keys, each with what the service knows of it."""

_SHARED = {}


def shared_server(**settings):
    """Return the server of this process of the test run that has these settings, started once."""
    key = tuple(sorted(settings.items()))
    if key not in _SHARED:
        folder = tempfile.TemporaryDirectory()
        atexit.register(folder.cleanup)
        _SHARED[key] = Server(Path(folder.name) / "data", Path(folder.name) / "log", **settings)
        atexit.register(_SHARED[key].end)
        _SHARED[key].wait_ready()
    return _SHARED[key]


@pytest.fixture(scope="session")
def start_server(tmp_path_factory):
    """Start a server with settings; it is stopped at the end of the session if it still runs."""
    with contextlib.ExitStack() as stack:

        def start(data=None, **settings):
            folder = tmp_path_factory.mktemp("server")
            server = Server(data or folder / "data", folder / "log", **settings)
            stack.callback(lambda: server.process.poll() is None and server.kill())
            return server

        yield start


@pytest.fixture(scope="session")
def server():
    """The server that most tests share; every test brings gamuts of its own."""
    return shared_server(max_body_bytes=2_000_000)


@pytest.fixture(scope="session")
def serve_app(tmp_path_factory):
    """Serve an app with settings in a thread, and return its address.

    It takes 0.1 s where a `Server` takes 9 s, and cannot build.
    """
    with contextlib.ExitStack() as stack:

        def serve(host="127.0.0.1", **settings):
            data = tmp_path_factory.mktemp("app") / "data"
            store = GamutStore(LocalBlobs(data))
            store.open()
            store.close()
            known = Settings(store=str(data), host=host, **settings)
            config = server_config(create_app(known), known)
            config.lifespan = "off"
            server = uvicorn.Server(config)
            listening = stack.enter_context(socket.create_server((host, 0)))
            thread = threading.Thread(target=server.run, args=([listening],))
            thread.start()
            stack.callback(thread.join)
            stack.callback(setattr, server, "should_exit", True)
            return f"http://127.0.0.1:{listening.getsockname()[1]}"

        yield serve


@pytest.fixture(scope="session")
def guarded_app(serve_app):
    """The address of an app with the keys of `READER` and `WRITER`."""
    entries = (known.entry for _, known in (READER, WRITER))
    return serve_app(api_keys=",".join(entries), cors_origins="https://example.org")


@pytest.fixture(scope="session")
def sphere():
    """Points on a sphere in CIELAB; another seed gives other colours, and so another gamut."""

    def points(seed=0, count=300, radius=40.0):
        directions = np.random.default_rng(seed).normal(size=(count, 3))
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        return [[50 + row[0], row[1], row[2]] for row in (radius * directions).tolist()]

    return points
