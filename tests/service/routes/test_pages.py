"""Pages: complete, closed to other origins and to scripts, readable, and JSON of the same."""

import asyncio
import base64
import gzip
import hashlib
import html
import json
import re
from html.parser import HTMLParser
from pathlib import Path

import httpx
import pytest

from gamutcore.building import gamut_id
from gamutcore.options import Options
from gamutcore.references import REFERENCES
from gamutcore.version import __version__
from service.application import create_app
from service.http.representations import IMMUTABLE
from service.problems.kinds import KINDS
from service.routes import viewer
from service.routes.pages import definitions, link, page, table
from service.settings import Settings

ROOT = Path(__file__).parents[3]
SWAGGER = ROOT / "service" / "static" / "swagger-ui"
VIEWER = ROOT / "gamutcore" / "export" / "viewer"
DOCS = f"/docs/{viewer.SWAGGER_VERSION}"
SWAGGER_TYPES = viewer.SWAGGER_MEDIA_TYPES
VIEW = f"/view/{viewer.version()}"

HTML = {"accept": "text/html,application/xhtml+xml,application/xml;q=0.9,*/*;q=0.8"}
"""What Chromium and Firefox send for a page."""
JSON = {"accept": "application/json"}

PLAIN = ("/status", "/problems", "/problems/not-found")
"""Pages without scripts."""
PAGES = (*PLAIN, "/docs", "/view")

FILES = [
    *(
        (f"{DOCS}/{name}", SWAGGER / name, kind)
        for name, kind in viewer.SWAGGER_MEDIA_TYPES.items()
    ),
    *((f"{VIEW}/{name}", VIEWER / name, kind) for name, kind in viewer.MEDIA_TYPES.items()),
]
"""Addresses of the files of pages, with the file and its media type."""

LOADING = re.compile(r"""(?:src|href|action|data|poster)=["']?([^"'>\s]+)""", re.IGNORECASE)
ADDRESS = re.compile(r"""(?:url\(\s*["']?|@import\s*["'])([^"')]+)""", re.IGNORECASE)
ELSEWHERE = re.compile(r"(?:[a-z][a-z0-9+.-]*:|//)", re.IGNORECASE)
INLINE = re.compile(r"<(script|style)\b(?![^>]*\bsrc=)[^>]*>(.*?)</\1>", re.DOTALL)
OWN = re.compile(r"'none'|'self'|'unsafe-inline'|'sha256-[A-Za-z0-9+/=]+'|data:|blob:")


@pytest.fixture
def get(server):
    return lambda path, headers=HTML: server.client.get(path, headers=headers)


# --- what pages may load and run ------------------------------------------------------------------


def from_elsewhere(text):
    """The addresses that a browser would load from another origin for a page or a style."""
    found = LOADING.findall(text) + ADDRESS.findall(text)
    return [each for each in found if ELSEWHERE.match(each) and not each.startswith("data:")]


def test_a_reference_to_another_origin_would_be_noticed():
    for text in (
        '<script src="https://cdn.example/a.js">',
        "<link href=//cdn.example/a.css>",
        "a{background:url(http://cdn.example/a.png)}",
        '@import "https://cdn.example/a.css";',
    ):
        assert from_elsewhere(text)


@pytest.mark.parametrize("path", PAGES)
def test_no_page_needs_or_admits_another_origin(get, path):
    shown = get(path)
    assert shown.headers["content-type"].startswith("text/html")
    assert LOADING.findall(shown.text)
    assert from_elsewhere(shown.text) == []
    policy = dict(
        each.split(maxsplit=1) for each in shown.headers["content-security-policy"].split("; ")
    )
    assert policy["default-src"] == "'none'"
    for name, sources in policy.items():
        for source in sources.split():
            assert OWN.fullmatch(source), (name, source)
    # nothing runs that is not named by its digest
    assert "'unsafe-inline'" not in policy.get("script-src", "")
    for kind, content in INLINE.findall(shown.text):
        digest = base64.b64encode(hashlib.sha256(content.encode()).digest()).decode()
        assert f"'sha256-{digest}'" in policy[f"{kind}-src"]
    if path != "/docs":  # Swagger UI sets styles
        assert "unsafe" not in shown.headers["content-security-policy"]
        assert re.findall(r"\bstyle=|\bon\w+=|url\(|@import", shown.text) == []
    if path in PLAIN:
        assert "script-src" not in policy
        assert re.findall(r"<script|<link|<img|<iframe|<object", shown.text) == []
        assert shown.headers["vary"] == "Accept"
    assert shown.headers["x-content-type-options"] == "nosniff"
    assert shown.headers["x-frame-options"] == "DENY"
    assert shown.headers["referrer-policy"] == "no-referrer"


@pytest.mark.parametrize(("path", "folder"), [("/docs", DOCS), ("/view", VIEW)])
def test_everything_that_a_page_loads_is_there(get, path, folder):
    loaded = re.findall(rf'(?:src|href)="({folder}/[^"]+)"', get(path).text)
    assert {Path(address).suffix for address in loaded} >= {".css", ".js"}
    for address in loaded:
        answer = get(address)
        assert answer.status_code == 200
        if address.endswith(".css"):
            assert from_elsewhere(answer.text) == []


def test_nobody_is_asked_whether_the_document_is_valid(get):
    shown = get("/docs").text
    assert "'/openapi.json'" in shown
    assert '"validatorUrl": null' in shown


@pytest.mark.parametrize("path", ["/status", "/problems/not-found"])
def test_a_browser_shows_a_page_and_complains_of_nothing(server, browser, path):
    shown = browser(f"{server.url}{path}")
    assert shown.complaints == []
    assert "<h1" in shown.document


def test_a_browser_shows_every_operation_and_complains_of_nothing(server, browser):
    paths = server.client.get("/openapi.json").json()["paths"]
    shown = browser(f"{server.url}/docs")
    assert shown.complaints == []
    methods = {"get", "put", "post", "delete", "patch", "head", "options"}
    assert sorted(re.findall(r'class="opblock opblock-([a-z]+)', shown.document)) == sorted(
        method for operations in paths.values() for method in operations if method in methods
    )


# --- the pages and their files --------------------------------------------------------------------


@pytest.mark.parametrize("headers", [HTML, JSON])
@pytest.mark.parametrize(
    "path", ["/problems", "/problems/not-found", "/docs", "/view", "/openapi.json"]
)
def test_what_stays_the_same_is_not_sent_again(get, path, headers):
    first = get(path, headers)
    assert first.headers["cache-control"] == "no-cache"
    same = get(path, {**headers, "If-None-Match": first.headers["etag"]})
    assert (same.status_code, same.content) == (304, b"")
    assert same.headers["etag"] == first.headers["etag"]
    other = get(path, {**headers, "If-None-Match": '"x"'})
    assert other.content == first.content


@pytest.mark.parametrize(("address", "file", "media_type"), FILES)
def test_files_are_cached_for_ever_under_their_version(get, address, file, media_type):
    content = file.read_bytes()
    plain = {"accept-encoding": "identity"}
    answer = get(address, plain)
    assert answer.content == content
    assert answer.headers["content-type"] == media_type
    assert answer.headers["cache-control"] == IMMUTABLE
    assert answer.headers["etag"] == f'"{hashlib.sha256(content).hexdigest()}"'
    assert answer.headers["x-content-type-options"] == "nosniff"
    again = get(address, {**plain, "if-none-match": answer.headers["etag"]})
    assert (again.status_code, again.content) == (304, b"")
    for field in ("etag", "cache-control", "vary"):
        assert again.headers[field] == answer.headers[field]


def test_the_examples_are_gamuts_of_this_version_and_their_data_is_served(get):
    folder = f"{VIEW}/examples"
    for each in get(f"{folder}/index.json").json()["examples"]:
        described = get(f"{folder}/{each['key']}.json").json()
        source = get(f"{folder}/{each['file']}").content if each["file"] else None
        data = source or REFERENCES[each["key"]].data
        options = Options.from_mapping(described["options"])
        # run make examples after a change of the algorithm
        assert gamut_id(options, hashlib.sha256(data).hexdigest()) == described["id"]
        history = get(f"{folder}/{each['key']}.gamut")
        assert history.headers["cache-control"] == IMMUTABLE
        # a small gamut is whole in its beginning
        assert len(history.content) <= described["history_bytes"]
    assert f"{folder}/still.webp" in get("/view").text


def test_a_compressed_file_is_another_representation(server):
    address, coded = f"{DOCS}/swagger-ui.css", {"accept-encoding": "gzip"}
    with server.client.stream("GET", address, headers=coded) as answer:
        sent = b"".join(answer.iter_raw())
    assert answer.headers["content-encoding"] == "gzip"
    assert answer.headers["vary"] == "Accept-Encoding"
    assert answer.headers["etag"] == f'"{hashlib.sha256(sent).hexdigest()}"'
    assert gzip.decompress(sent) == (SWAGGER / "swagger-ui.css").read_bytes()


@pytest.mark.parametrize(
    "address",
    [
        *("/problems/<script>", "/nowhere", "/v1", "/v1/gamuts/", "/docs/"),
        *(f"{DOCS}/{name}" for name in ("README.md", "..%2f..%2f__init__.py", "%2e%2e/LICENSE")),
        *(f"{VIEW}/{name}" for name in ("index.html", "..%2f__init__.py", "nothing")),
        *("/docs/0.0.0/swagger-ui.css", "/view/0123456789abcdef/viewer.js"),
    ],
)
def test_nothing_else_is_served(get, assert_problem, address):
    assert_problem(get(address), 404, "not-found")


def test_the_files_of_swagger_ui_are_those_of_the_package():
    """The digests were taken of the package's content when it was put here."""
    notice = (SWAGGER / "README.md").read_text()
    stated = dict(re.findall(r"\| `(\S+)` \| `([0-9a-f]{64})` \|", notice))
    ours = {"README.md", "contrast.css"}
    there = {path.name for path in SWAGGER.iterdir()} - ours
    assert set(stated) == there > set(SWAGGER_TYPES) - ours
    for name, digest in stated.items():
        assert hashlib.sha256((SWAGGER / name).read_bytes()).hexdigest() == digest
    assert f"`swagger-ui-dist` {viewer.SWAGGER_VERSION}" in notice


def test_the_document_of_the_api_is_what_the_app_generates(get):
    plain = get("/openapi.json", {"accept-encoding": "identity"})
    assert plain.json() == create_app(Settings()).openapi()
    small = get("/openapi.json", {"accept-encoding": "gzip"})
    assert small.headers["content-encoding"] == "gzip"
    assert small.headers["etag"] != plain.headers["etag"]
    assert small.content == plain.content


@pytest.mark.slow
def test_behind_a_prefix_the_document_says_so():
    async def document():
        transport = httpx.ASGITransport(create_app(Settings()), root_path="/gamut")
        async with httpx.AsyncClient(transport=transport, base_url="http://localhost") as client:
            return (await client.get("/gamut/openapi.json")).json()

    assert asyncio.run(document())["servers"] == [{"url": "/gamut"}]


# --- state, problems, gamuts ---------------------------------------------------------------


def test_the_page_of_the_state_has_links_that_lead_somewhere(server, get):
    shown = get("/status")
    assert shown.headers["cache-control"] == "no-store"
    assert '<span class="ok">ready</span>' in shown.text
    assert "1 of 1 warm" in shown.text
    for probe in ("kernels", "workers", "queue", "store", "disk"):
        row = f'<th scope="row">{probe}</th><td><span class="ok">ok</span></td>'
        assert row in shown.text
    # its example names this service
    assert f"{server.url}/v1/gamuts" in shown.text
    links = set(re.findall(r'href="([^"]+)"', shown.text))
    assert {"/docs", "/openapi.json", "/v1/gamuts", "/problems", "/metrics", "/readyz"} <= links

    answer = get("/status", JSON)
    assert answer.headers["content-type"] == "application/json"
    assert answer.headers["vary"] == "Accept"
    document = answer.json()
    assert document["version"] == __version__
    assert document["state"]["ready"] is True
    assert set(document["state"]) == set(get("/readyz").json())
    assert document["links"]["view"] == "/view"
    for address in links | set(document["links"].values()):
        assert get(address).status_code == 200


def test_a_browser_gets_the_viewer_at_the_root_and_others_the_state(get):
    assert get("/").text == get("/view").text
    answer = get("/", JSON)
    assert answer.json().keys() == get("/status", JSON).json().keys()
    assert answer.headers["vary"] == "Accept"
    assert "Probes" in get("/", {"accept": "*/*"}).text


@pytest.mark.parametrize("code", KINDS)
def test_each_problem_has_its_page_with_what_to_do_and_an_example(get, code):
    kind = KINDS[code]
    shown = get(f"/problems/{code}")
    assert shown.status_code == 200
    text = html.unescape(shown.text)
    for part in (code, str(kind.status), kind.title, kind.remedy, kind.detail):
        assert part in text
    (example,) = re.findall(r"<pre[^>]*><code>(.*?)</code>", shown.text, re.DOTALL)
    document = json.loads(html.unescape(example))
    assert document["type"] == f"/problems/{code}"
    # the same for programs
    answer = get(f"/problems/{code}", JSON).json()
    assert (answer["code"], answer["example"]) == (code, document)
    assert (answer["status"], answer["remedy"]) == (kind.status, kind.remedy)


def test_the_index_of_problems_has_all(get):
    shown = get("/problems").text
    document = get("/problems", JSON).json()
    assert {kind["code"] for kind in document["problems"]} == set(KINDS)
    for code, kind in KINDS.items():
        assert f'href="/problems/{code}"' in shown
        assert html.escape(kind.title) in shown


def test_a_browser_gets_the_viewer_with_a_picture_and_facts_at_a_gamut(server, get, sphere):
    made = server.client.post("/v1/gamuts", json={"samples": sphere(seed=792, count=40)}).json()
    address = f"/v1/gamuts/{made['id']}"
    server.client.put(f"{address}/name", json={"name": HOSTILE})
    shown = get(address)
    assert "Accept" in shown.headers["vary"]
    assert f"{VIEW}/viewer.js" in shown.text
    assert HOSTILE not in shown.text
    assert f"<title>{html.escape(HOSTILE)} – gamut</title>" in shown.text
    named = dict(re.findall(r'<meta property="og:(\w+)" content="([^"]*)">', shown.text))
    assert named["image"] == f"{server.url}{address}/picture.png"
    assert f"{made['counts']['triangles']} triangles" in named["description"]
    [figure] = re.findall(r"<figure id=\"static\".*?</figure>", shown.text, re.DOTALL)
    assert f"<h2>{html.escape(HOSTILE)}</h2>" in figure
    assert "cubic ΔE*ab" in figure
    [picture] = re.findall(r'<img src="([^"]+)"', figure)
    assert get(html.unescape(picture)).headers["content-type"] == "image/png"


def test_there_is_no_page_for_a_gamut_that_does_not_exist(get, assert_problem):
    assert_problem(get(f"/v1/gamuts/{'0' * 64}"), 404, "gamut-not-found")


@pytest.mark.parametrize("accept", [None, "*/*", "application/json", "text/html;q=0.5,*/*"])
def test_others_get_json(get, gamut, accept):
    answer = get(f"/v1/gamuts/{gamut['id']}", {"accept": accept} if accept else {})
    assert answer.json()["id"] == gamut["id"]
    assert {"Accept", "Accept-Encoding"} <= set(re.split(", *", answer.headers["vary"]))


def test_the_page_of_a_gamut_is_downloaded_under_its_name(server, sphere):
    made = server.client.post("/v1/gamuts", json={"samples": sphere(seed=791, count=40)}).json()
    address = f"/v1/gamuts/{made['id']}"
    before = server.client.get(f"{address}/viewer.html")
    assert before.status_code == 200
    name = f'attachment; filename="{made["name"]}.html"'
    assert before.headers["content-disposition"] == name
    assert before.headers["content-type"] == "text/html; charset=utf-8"
    assert before.headers["x-content-type-options"] == "nosniff"

    name = {"name": 'Größe "M" 50/50 <b>'}
    assert server.client.put(f"{address}/name", json=name).status_code < 300
    after = server.client.get(f"{address}/viewer.html")
    assert after.headers["etag"] != before.headers["etag"]
    encoded = "filename*=UTF-8''Gr%C3%B6%C3%9Fe%20_M_%2050_50%20_b_.html"
    assert encoded in after.headers["content-disposition"]
    assert b"<b>" not in after.content.split(b"<script type", 1)[0]


def test_a_page_has_other_gamuts_beside_the_first(get, gamut, assert_problem):
    address = f"/v1/gamuts/{gamut['id']}/viewer.html"
    shown = get(f"{address}?with={gamut['id']},srgb")
    text = re.findall(r'id="gamut-file">(.*?)</script>', shown.text)[0]
    first, second = (each["gamut"] for each in json.loads(text)["gamuts"])
    assert (first["id"], second["name"]) == (gamut["id"], "sRGB")
    assert shown.headers["content-location"].endswith(f"?with={gamut['id']},{second['id']}")
    assert_problem(get(f"{address}?with={','.join(['srgb'] * 6)}"), 422, "invalid-parameter")
    assert_problem(get(f"{address}?with=srbg"), 422, "invalid-parameter")
    small = "space=Oklab&surface-samples=1000"
    refused = assert_problem(get(f"{address}?with=srgb&{small}"), 422, "invalid-option")
    assert refused["detail"] == "The gamuts are in CIELAB and Oklab."


# --- the form of pages without scripts ------------------------------------------------------------

HOSTILE = "<script>alert(1)</script>\"'&"


class Tree(HTMLParser):
    """Notes what is opened and not closed, and each tag."""

    EMPTY = ("meta", "br")

    def __init__(self, text):
        super().__init__()
        self.tags, self.open = [], []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attributes):
        self.tags.append((tag, dict(attributes)))
        if tag not in self.EMPTY:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


@pytest.mark.parametrize("path", PLAIN)
def test_a_page_is_well_formed_and_says_its_language(get, path):
    tree = Tree(get(path).text)
    assert ("html", {"lang": "en"}) in tree.tags
    names = [name for name, _ in tree.tags]
    for name in ("title", "main", "h1", "header", "footer"):
        assert names.count(name) == 1
    assert any(given.get("name") == "viewport" for name, given in tree.tags)


def test_whatever_text_is_shown_is_text():
    heads = (HOSTILE, "x")
    content = (
        link(HOSTILE, HOSTILE)
        + definitions([(HOSTILE, "")])
        + table(HOSTILE, heads, [("1", "2"), ("3", "4")])
    )
    text = page(HOSTILE, content).body.decode()
    assert "<script" not in text
    tags = Tree(text).tags
    # tables say what their heads are heads of
    assert [given["scope"] for name, given in tags if name == "th"] == ["col", "col", "row", "row"]
    assert ("caption", {}) in tags
    (region,) = (given for name, given in tags if given.get("role") == "region")
    assert (region["tabindex"], region["aria-label"]) == ("0", HOSTILE)


def colours(text, after):
    """The colours that are named from a place in the style on, as numbers of linear light."""
    named = {}
    for name, value in re.findall(r"--(\w+):#([0-9a-f]+)", text[text.index(after) :]):
        digits = value if len(value) == 6 else "".join(2 * digit for digit in value)
        parts = [int(digits[place : place + 2], 16) / 255 for place in (0, 2, 4)]
        named.setdefault(
            name, [p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts]
        )
    return named


def luminance(colour):
    return sum(part * weight for part, weight in zip(colour, (0.2126, 0.7152, 0.0722), strict=True))


@pytest.mark.parametrize("scheme", [":root", "prefers-color-scheme:dark"])
def test_text_stands_out_from_its_ground(get, scheme):
    """WCAG 2.2, success criterion 1.4.3: a contrast of 4.5 at least."""
    named = colours(get("/status").text, scheme)
    for ground in ("back", "box"):
        for name in ("text", "soft", "link", "good", "fair", "bad"):
            low, high = sorted((luminance(named[ground]), luminance(named[name])))
            assert (high + 0.05) / (low + 0.05) >= 4.5, (ground, name)
