"""The documentation over a real connection, and that no page needs anything from elsewhere."""

import asyncio
import base64
import gzip
import hashlib
import re
from pathlib import Path

import httpx
import pytest

from service.application import create_app
from service.http.conditional import IMMUTABLE
from service.routes.swagger_ui import MEDIA_TYPES, VERSION
from service.settings import Settings

ROOT = Path(__file__).parents[3]
FOLDER = ROOT / "service" / "static" / "swagger-ui"

HTML = {"accept": "text/html"}
PAGES = ("/", "/docs", "/view", "/problems", "/problems/not-found")
LOADING = re.compile(r"""(?:src|href|action|data|poster)=["']?([^"'>\s]+)""", re.IGNORECASE)
ADDRESS = re.compile(r"""(?:url\(\s*["']?|@import\s*["'])([^"')]+)""", re.IGNORECASE)
ELSEWHERE = re.compile(r"(?:[a-z][a-z0-9+.-]*:|//)", re.IGNORECASE)


def address_of(name):
    return f"/docs/{VERSION}/{name}"


def from_elsewhere(text):
    """The addresses that a browser would load from another origin for a page or a style."""
    found = LOADING.findall(text) + ADDRESS.findall(text)
    return [each for each in found if ELSEWHERE.match(each) and not each.startswith("data:")]


class TestOrigins:
    @pytest.mark.parametrize("path", PAGES)
    def test_no_page_refers_to_another(self, server, path):
        page = server.client.get(path, headers=HTML)
        assert page.headers["content-type"].startswith("text/html")
        assert LOADING.findall(page.text)
        assert from_elsewhere(page.text) == []

    @pytest.mark.parametrize("path", PAGES)
    def test_no_policy_lets_one_in(self, server, path):
        policy = server.client.get(path, headers=HTML).headers["content-security-policy"]
        own = r"'none'|'self'|'unsafe-inline'|'sha256-[A-Za-z0-9+/=]+'|data:|blob:"
        directives = dict(each.split(maxsplit=1) for each in policy.split("; "))
        assert directives["default-src"] == "'none'"
        for name, sources in directives.items():
            for source in sources.split():
                assert re.fullmatch(own, source), (name, source)

    def test_neither_does_the_style(self, server):
        style = server.client.get(address_of("swagger-ui.css")).text
        assert ADDRESS.findall(style)
        assert from_elsewhere(style) == []

    def test_a_reference_to_another_would_be_noticed(self):
        for text in (
            '<script src="https://cdn.example/a.js">',
            "<link href=//cdn.example/a.css>",
            "a{background:url(http://cdn.example/a.png)}",
            '@import "https://cdn.example/a.css";',
        ):
            assert from_elsewhere(text)


class TestPage:
    def test_it_runs_only_what_it_is_made_of(self, server):
        page = server.client.get("/docs")
        policy = page.headers["content-security-policy"]
        (script,) = re.findall(r"<script>(.*?)</script>", page.text, re.DOTALL)
        digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
        assert f"script-src 'self' 'sha256-{digest}';" in policy

    def test_everything_that_it_loads_is_there(self, server):
        page = server.client.get("/docs").text
        loaded = {each for each in LOADING.findall(page) if not each.startswith("data:")}
        assert loaded == {address_of("swagger-ui.css"), address_of("swagger-ui-bundle.js")}
        for address in (*loaded, "/openapi.json"):
            assert server.client.get(address).status_code == 200
        assert "'/openapi.json'" in page

    def test_nobody_is_asked_whether_the_document_is_valid(self, server):
        assert '"validatorUrl": null' in server.client.get("/docs").text


def test_the_document_of_the_api_is_what_the_app_generates(server):
    plain = server.client.get("/openapi.json", headers={"accept-encoding": "identity"})
    assert plain.json() == create_app(Settings()).openapi()
    small = server.client.get("/openapi.json", headers={"accept-encoding": "gzip"})
    assert small.headers["content-encoding"] == "gzip"
    assert small.headers["etag"] != plain.headers["etag"]
    assert small.content == plain.content


@pytest.mark.slow
def test_behind_a_prefix_the_document_says_so():
    app = create_app(Settings())

    async def document():
        transport = httpx.ASGITransport(app, root_path="/gamut")
        async with httpx.AsyncClient(transport=transport, base_url="http://test") as client:
            return (await client.get("/gamut/openapi.json")).json()

    assert asyncio.run(document())["servers"] == [{"url": "/gamut"}]


class TestFiles:
    @pytest.mark.parametrize("name", MEDIA_TYPES)
    def test_each_is_cached_for_ever_under_its_version(self, server, name):
        content = (FOLDER / name).read_bytes()
        answer = server.client.get(address_of(name), headers={"accept-encoding": "identity"})
        assert answer.content == content
        assert answer.headers["content-type"] == MEDIA_TYPES[name]
        assert answer.headers["cache-control"] == IMMUTABLE
        assert answer.headers["etag"] == f'"{hashlib.sha256(content).hexdigest()}"'
        assert answer.headers["x-content-type-options"] == "nosniff"
        known = {"if-none-match": answer.headers["etag"], "accept-encoding": "identity"}
        again = server.client.get(address_of(name), headers=known)
        assert (again.status_code, again.content) == (304, b"")
        for field in ("etag", "cache-control", "vary"):
            assert again.headers[field] == answer.headers[field]

    def test_compressed_it_is_another_representation(self, server):
        address = address_of("swagger-ui.css")
        with server.client.stream("GET", address, headers={"accept-encoding": "gzip"}) as answer:
            sent = b"".join(answer.iter_raw())
        assert answer.headers["content-encoding"] == "gzip"
        assert answer.headers["vary"] == "Accept-Encoding"
        assert answer.headers["etag"] == f'"{hashlib.sha256(sent).hexdigest()}"'
        assert gzip.decompress(sent) == (FOLDER / "swagger-ui.css").read_bytes()

    @pytest.mark.parametrize(
        "address",
        [
            address_of("README.md"),
            address_of("..%2f..%2f__init__.py"),
            address_of("%2e%2e/LICENSE"),
            "/docs/0.0.0/swagger-ui.css",
            "/docs/",
        ],
    )
    def test_nothing_else_is_served(self, server, assert_problem, address):
        assert_problem(server.client.get(address), 404, "not-found")


def test_the_files_are_those_of_the_package():
    """The digests were taken of the package's content when it was put here."""
    notice = (FOLDER / "README.md").read_text()
    stated = dict(re.findall(r"\| `(\S+)` \| `([0-9a-f]{64})` \|", notice))
    there = {path.name for path in FOLDER.iterdir()} - {"README.md"}
    assert set(stated) == there > set(MEDIA_TYPES)
    for name, digest in stated.items():
        assert hashlib.sha256((FOLDER / name).read_bytes()).hexdigest() == digest
    assert f"`swagger-ui-dist` {VERSION}" in notice


def test_a_browser_shows_every_operation_and_complains_of_nothing(server, browser):
    paths = server.client.get("/openapi.json").json()["paths"]
    page = browser(f"{server.url}/docs")
    assert page.complaints == []
    shown = re.findall(r'class="opblock opblock-([a-z]+)', page.document)
    methods = {"get", "put", "post", "delete", "patch", "head", "options"}
    assert sorted(shown) == sorted(
        method for operations in paths.values() for method in operations if method in methods
    )
