"""The programs of web/viewer/tests, each driven in Chromium over a real server."""

import json
import os
import shutil
import socket
import subprocess
import threading
from pathlib import Path

import browser as chromium
import pytest
import uvicorn

from service.access.api_keys import new_key
from service.application import create_app
from service.settings import Settings

ROOT = Path(__file__).parents[3]
WEB = ROOT / "web"


def _need(found, what):
    if not found:
        if os.environ.get("CI") == "true":
            pytest.fail(what)
        pytest.skip(what)


@pytest.fixture(scope="session")
def web():
    """The folder ``web``, with Node.js and its packages."""
    _need(shutil.which("node"), "there is no Node.js")
    _need((WEB / "node_modules").is_dir(), "the packages of web/ are not installed: npm ci in web")
    return WEB


@pytest.fixture(scope="module")
def gamuts(server, sphere, tmp_path_factory):
    """Environment of the programs: gamuts of the server, pages from disk, a faulty file."""
    folder = tmp_path_factory.mktemp("viewer")
    balls = []
    for name, radius in (("Ball A", 40.0), ("Ball B", 30.0)):
        body = {"samples": sphere(seed=77, count=700, radius=radius), "name": name}
        balls.append(server.client.post("/v1/gamuts", json=body).json())
    other = {"samples": sphere(seed=77), "name": "Oklab sphere", "options": {"space": "Oklab"}}
    oklab = server.client.post("/v1/gamuts", json=other).json()
    press = server.client.post(
        "/v1/gamuts",
        files={"file": (ROOT / "examples" / "FOGRA39L.ti3").read_bytes()},
        data={"options": json.dumps({"surface_samples": 4000, "ink_limit": 300})},
    ).json()
    pages = {}
    for name, gamut in (("PAGE", balls[0]), ("OTHER_PAGE", oklab)):
        path = folder / f"{gamut['name']}.html"
        path.write_bytes(server.client.get(f"/v1/gamuts/{gamut['id']}/viewer.html").content)
        pages[name] = path.as_uri()
    bad = folder / "bad.csv"
    bad.write_text("L,a,b\n1,2\n")
    rows = [",".join(f"{value:.6f}" for value in row) for row in sphere(seed=os.getpid())]
    return {
        **pages,
        "VIEWER_URL": server.url,
        "PRESS": press["id"],
        "FIRST": balls[0]["id"],
        "SECOND": balls[1]["id"],
        "FINEST": str(balls[0]["counts"]["triangles"]),
        "SAMPLES": "\n".join(["L,a,b", *rows]),
        "BAD": str(bad),
    }


@pytest.fixture
def guarded(filled_store, built):
    """Environment of the test with API keys: a server in this process, a key, and a gamut."""
    key, known = new_key("viewer", frozenset({"read"}))
    app = create_app(Settings(store=str(filled_store.blobs.directory), api_keys=known.entry))
    server = uvicorn.Server(uvicorn.Config(app, lifespan="off", log_config=None))
    with socket.create_server(("127.0.0.1", 0)) as listening:
        thread = threading.Thread(target=server.run, args=([listening],))
        thread.start()
        url = f"http://127.0.0.1:{listening.getsockname()[1]}"
        yield {"KEYS_URL": url, "KEY": key, "GUARDED": built[0].id}
        server.should_exit = True
        thread.join()


@pytest.fixture
def run_in_browser(web, gamuts, guarded):
    """Run one program of web/viewer/tests; what it printed is the message of a failure."""
    reason = chromium.missing()
    _need(reason is None, reason)

    def run(name):
        ended = subprocess.run(
            ["node", "--test", f"viewer/tests/{name}.test.mjs"],
            cwd=web,
            env={**os.environ, **guarded, **gamuts, "CHROMIUM": chromium.program()},
            check=False,
            capture_output=True,
            text=True,
        )
        assert ended.returncode == 0, ended.stdout + ended.stderr
        assert "# fail 0" in ended.stdout

    return run
