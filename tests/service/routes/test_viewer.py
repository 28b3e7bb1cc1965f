"""The viewer: what its files are made of, and its features in a real browser."""

import json
import os
import shutil
import socket
import subprocess
import threading
from html.parser import HTMLParser
from pathlib import Path

import browser as chromium
import pytest
import uvicorn

from gamutcore.arguments import marks
from gamutcore.export.viewer_page import VIEWER_FILES
from gamutcore.options import OPTIONS
from service.access.api_keys import new_key
from service.application import create_app
from service.settings import Settings

ROOT = Path(__file__).parents[3]
WEB = ROOT / "web"


def need(found, what):
    if not found:
        if os.environ.get("CI") == "true":
            pytest.fail(what)
        pytest.skip(what)


@pytest.mark.slow
def test_the_files_are_built_from_the_sources():
    need(shutil.which("node"), "there is no Node.js")
    need((WEB / "node_modules").is_dir(), "the packages of web/ are not installed: npm ci in web")
    ended = subprocess.run(
        ["node", "build.mjs", "--check"], cwd=WEB, check=False, capture_output=True, text=True
    )
    assert ended.returncode == 0, ended.stderr


class _Controls(HTMLParser):
    """Attributes of the form controls of a page by id, and the options of each select."""

    def __init__(self, page):
        super().__init__()
        self.controls, self.options, self.selected, self._select = {}, {}, {}, ""
        self.feed(page)

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        if tag in {"input", "select"} and "id" in given:
            self.controls[given["id"]] = given
            self._select = given["id"]
        if tag == "option":
            self._given = given

    def handle_data(self, data):
        if self.lasttag == "option" and data.strip():
            value = self._given.get("value", data)
            self.options.setdefault(self._select, []).append(value)
            if "selected" in self._given:
                self.selected[self._select] = value


def test_the_page_offers_the_options_of_the_service_and_their_defaults():
    page = _Controls((VIEWER_FILES / "index.html").read_text("utf-8"))
    for name in ("intent", "space"):
        (choice,) = marks(OPTIONS[name].kind)
        assert page.options[name] == list(choice.values), name
        assert page.selected[name] == OPTIONS[name].default
    limit = next(each for each in marks(OPTIONS["ink_limit"].kind) if hasattr(each, "least"))
    field = page.controls["ink-limit"]
    assert float(field["min"]) > limit.least
    assert float(field["max"]) == limit.most
    assert "value" not in field


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


def test_the_features_in_a_browser(server, sphere, guarded, tmp_path):
    need(shutil.which("node"), "there is no Node.js")
    need((WEB / "node_modules").is_dir(), "the packages of web/ are not installed: npm ci in web")
    reason = chromium.missing()
    need(reason is None, reason)
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
        path = tmp_path / f"{gamut['name']}.html"
        path.write_bytes(server.client.get(f"/v1/gamuts/{gamut['id']}/viewer.html").content)
        pages[name] = path.as_uri()
    bad = tmp_path / "bad.csv"
    bad.write_text("L,a,b\n1,2\n")
    rows = [",".join(f"{value:.6f}" for value in row) for row in sphere(seed=os.getpid())]
    names = (
        *("static", "view", "scene", "gamuts", "layers", "flow", "slices"),
        *("colours", "answers", "recipes", "late", "drops", "tasks"),
    )
    tests = [f"viewer/tests/{name}.test.mjs" for name in names]
    ended = subprocess.run(
        ["node", "--test", "--test-concurrency=2", *tests],
        cwd=WEB,
        env={
            **os.environ,
            **guarded,
            **pages,
            "VIEWER_URL": server.url,
            "CHROMIUM": chromium.program(),
            "PRESS": press["id"],
            "FIRST": balls[0]["id"],
            "SECOND": balls[1]["id"],
            "FINEST": str(balls[0]["counts"]["triangles"]),
            "SAMPLES": "\n".join(["L,a,b", *rows]),
            "BAD": str(bad),
        },
        check=False,
        capture_output=True,
        text=True,
    )
    assert ended.returncode == 0, ended.stdout + ended.stderr + json.dumps(balls[0]["counts"])
    assert "# fail 0" in ended.stdout
