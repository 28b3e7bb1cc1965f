"""The viewer: its page, its files, and its features in a real browser."""

import hashlib
import json
import os
import re
import shutil
import subprocess
from pathlib import Path

import browser as chromium
import pytest

from service.access.api_keys import new_key
from service.http.conditional import IMMUTABLE
from service.routes.viewer import MEDIA_TYPES, version

ROOT = Path(__file__).parents[3]
WEB = ROOT / "web"
FOLDER = ROOT / "gamutcore" / "export" / "viewer"

BROWSER = {"accept": "text/html,application/xhtml+xml,application/xml;q=0.9,*/*;q=0.8"}
"""What Chromium and Firefox send for a page."""


class TestPage:
    def test_nothing_on_it_is_inline(self, server):
        page = server.client.get("/view")
        assert page.headers["content-type"].startswith("text/html")
        assert re.findall(r"<script(?![^>]*\bsrc=)|<style|\bstyle=|\bon\w+=", page.text) == []
        policy = page.headers["content-security-policy"]
        assert "unsafe" not in policy
        assert "sha256" not in policy

    def test_everything_that_it_loads_is_there(self, server):
        page = server.client.get("/view").text
        loaded = re.findall(r'(?:src|href)="(/view/[^"]+)"', page)
        assert len(loaded) == 2
        for address in loaded:
            assert server.client.get(address).status_code == 200

    def test_it_is_not_sent_twice(self, server):
        etag = server.client.get("/view").headers["etag"]
        assert server.client.get("/view", headers={"if-none-match": etag}).status_code == 304


class TestNegotiation:
    def test_a_browser_gets_the_page_at_a_gamut(self, server, gamut):
        page = server.client.get(f"/v1/gamuts/{gamut['id']}", headers=BROWSER)
        assert page.text == server.client.get("/view").text
        assert "Accept" in page.headers["vary"]

    @pytest.mark.parametrize("accept", [None, "*/*", "application/json", "text/html;q=0.5,*/*"])
    def test_others_get_json(self, server, gamut, accept):
        headers = {"accept": accept} if accept else {}
        answer = server.client.get(f"/v1/gamuts/{gamut['id']}", headers=headers)
        assert answer.json()["id"] == gamut["id"]
        assert {"Accept", "Accept-Encoding"} <= set(re.split(", *", answer.headers["vary"]))

    def test_an_unknown_gamut_is_a_problem(self, server, assert_problem):
        answer = server.client.get(f"/v1/gamuts/{'0' * 64}", headers=BROWSER)
        assert_problem(answer, 404, "gamut-not-found")


class TestFiles:
    @pytest.mark.parametrize("name", MEDIA_TYPES)
    def test_each_is_cached_for_ever_under_its_digest(self, server, name):
        content = (FOLDER / name).read_bytes()
        answer = server.client.get(f"/view/{version()}/{name}")
        assert answer.content == content
        assert answer.headers["content-type"] == MEDIA_TYPES[name]
        assert answer.headers["cache-control"] == IMMUTABLE
        assert answer.headers["etag"] == f'"{hashlib.sha256(content).hexdigest()}"'

    @pytest.mark.parametrize("name", ["index.html", "..%2f__init__.py", "nothing"])
    def test_nothing_else_is_served(self, server, assert_problem, name):
        assert_problem(server.client.get(f"/view/{version()}/{name}"), 404, "not-found")
        old = server.client.get("/view/0123456789abcdef/viewer.js")
        assert_problem(old, 404, "not-found")


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


@pytest.fixture
def guarded(start_server, sphere):
    """Environment of the test with API keys: a server, a key, and a gamut that needs the key."""
    key, known = new_key("viewer", frozenset({"read", "write"}))
    started = start_server(api_keys=known.entry)
    started.wait_for(lambda: started.client.get("/readyz").status_code == 200)
    started.client.headers["X-API-Key"] = key
    made = started.client.post("/v1/gamuts", json={"samples": sphere(seed=78, count=50)}).json()
    yield {"KEYS_URL": started.url, "KEY": key, "GUARDED": made["id"]}
    started.stop()


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
    pages = {}
    for name, gamut in (("PAGE", balls[0]), ("OTHER_PAGE", oklab)):
        path = tmp_path / f"{gamut['name']}.html"
        path.write_bytes(server.client.get(f"/v1/gamuts/{gamut['id']}/viewer.html").content)
        pages[name] = path.as_uri()
    bad = tmp_path / "bad.csv"
    bad.write_text("L,a,b\n1,2\n")
    rows = [",".join(f"{value:.6f}" for value in row) for row in sphere(seed=os.getpid())]
    tests = [f"viewer/tests/{name}.test.mjs" for name in ("view", "gamuts")]
    ended = subprocess.run(
        ["node", "--test", "--test-concurrency=2", *tests],
        cwd=WEB,
        env={
            **os.environ,
            **guarded,
            **pages,
            "VIEWER_URL": server.url,
            "CHROMIUM": chromium.program(),
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
