"""Pages: links, JSON of the same content, well-formed, closed to scripts, readable."""

import base64
import hashlib
import html
import json
import re
from html.parser import HTMLParser

import pytest

from gamutcore.version import __version__
from service.problems.kinds import KINDS
from service.routes.html_pages import definitions, link, page, table

HTML = {"accept": "text/html,application/xhtml+xml,application/xml;q=0.9,*/*;q=0.8"}
JSON = {"accept": "application/json"}
PAGES = ("/", "/problems", "/problems/not-found")


class TestLanding:
    def test_every_link_leads_somewhere(self, server):
        page = server.client.get("/", headers=HTML)
        assert page.headers["content-type"].startswith("text/html")
        links = set(re.findall(r'href="([^"]+)"', page.text))
        expected = {"/docs", "/openapi.json", "/v1/gamuts", "/problems", "/metrics", "/readyz"}
        assert expected <= links
        for address in links:
            assert server.client.get(address).status_code == 200

    def test_it_tells_the_state_of_the_moment(self, server):
        page = server.client.get("/", headers=HTML)
        assert page.headers["cache-control"] == "no-store"
        assert '<span class="ok">ready</span>' in page.text
        assert "1 of 1 warm" in page.text
        for probe in ("kernels", "workers", "queue", "store", "disk"):
            assert f'<th scope="row">{probe}</th><td><span class="ok">ok</span></td>' in page.text

    def test_it_is_json_for_who_asks_for_it(self, server):
        answer = server.client.get("/", headers=JSON)
        assert answer.headers["content-type"] == "application/json"
        assert answer.headers["vary"] == "Accept"
        document = answer.json()
        assert document["version"] == __version__
        assert document["state"]["ready"] is True
        assert set(document["state"]) == set(server.client.get("/readyz").json())
        for address in document["links"].values():
            assert server.client.get(address).status_code == 200

    def test_its_example_names_this_service(self, server):
        assert f"{server.url}/v1/gamuts" in server.client.get("/", headers=HTML).text


@pytest.mark.parametrize("path", PAGES)
def test_pages_can_neither_run_nor_load_anything(server, path):
    page = server.client.get(path, headers=HTML)
    (style,) = re.findall(r"<style>(.*?)</style>", page.text, re.DOTALL)
    digest = base64.b64encode(hashlib.sha256(style.encode()).digest()).decode()
    assert f"'sha256-{digest}'" in page.headers["content-security-policy"]
    assert "default-src 'none'" in page.headers["content-security-policy"]
    assert page.headers["vary"] == "Accept"
    assert re.findall(r'(?:src|href)="(?!/)[^"]*"', page.text) == []


@pytest.mark.parametrize("headers", [HTML, JSON])
@pytest.mark.parametrize("path", ["/problems", "/problems/not-found", "/docs", "/openapi.json"])
def test_what_stays_the_same_is_not_sent_again(server, path, headers):
    first = server.client.get(path, headers=headers)
    assert first.headers["cache-control"] == "no-cache"
    known = {**headers, "If-None-Match": first.headers["etag"]}
    same = server.client.get(path, headers=known)
    assert (same.status_code, same.content) == (304, b"")
    assert same.headers["etag"] == first.headers["etag"]
    other = server.client.get(path, headers={**headers, "If-None-Match": '"x"'})
    assert other.content == first.content


class TestProblems:
    @pytest.mark.parametrize("code", KINDS)
    def test_each_has_its_page_with_what_to_do_and_an_example(self, server, code):
        kind = KINDS[code]
        page = server.client.get(f"/problems/{code}", headers=HTML)
        assert page.status_code == 200
        text = html.unescape(page.text)
        for part in (code, str(kind.status), kind.title, kind.remedy, kind.detail):
            assert part in text
        (example,) = re.findall(r"<pre[^>]*><code>(.*?)</code>", page.text, re.DOTALL)
        document = json.loads(html.unescape(example))
        assert document["type"] == f"/problems/{code}"
        # the same for programs
        answer = server.client.get(f"/problems/{code}", headers=JSON).json()
        assert answer["example"] == document
        assert (answer["status"], answer["remedy"]) == (kind.status, kind.remedy)

    def test_the_index_has_all(self, server):
        page = server.client.get("/problems", headers=HTML).text
        document = server.client.get("/problems", headers=JSON).json()
        assert {kind["code"] for kind in document["problems"]} == set(KINDS)
        for code, kind in KINDS.items():
            assert f'href="/problems/{code}"' in page
            assert html.escape(kind.title) in page

    def test_the_type_of_a_problem_is_the_address_of_its_page(self, server):
        problem = server.client.get("/v1/gamuts/nonsense").json()
        assert server.client.get(problem["type"], headers=JSON).json()["code"] == problem["code"]


def test_other_pages_are_not_found(server, assert_problem):
    for path in ("/problems/<script>", "/nowhere", "/v1", "/v1/gamuts/"):
        answer = server.client.get(path)
        assert_problem(answer, 404, "not-found")


@pytest.mark.parametrize("path", PAGES)
def test_a_browser_shows_every_page_and_complains_of_nothing(server, browser, path):
    page = browser(f"{server.url}{path}")
    assert page.complaints == []
    assert "<h1" in page.document


# --- the form of pages ----------------------------------------------------------------------------

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


@pytest.fixture
def response():
    content = definitions([("a", "b")]) + table("Caption", ("x", "y"), [("1", "2"), ("3", "4")])
    return page("Title", content)


def test_a_page_is_well_formed_and_says_its_language(response):
    tree = Tree(response.body.decode())
    assert ("html", {"lang": "en"}) in tree.tags
    names = [name for name, _ in tree.tags]
    for name in ("title", "main", "h1", "header", "footer", "nav"):
        assert names.count(name) == 1
    assert any(given.get("name") == "viewport" for name, given in tree.tags)


def test_the_policy_allows_the_style_that_is_there_and_nothing_else(response):
    text = response.body.decode()
    (style,) = re.findall(r"<style>(.*?)</style>", text, re.DOTALL)
    digest = base64.b64encode(hashlib.sha256(style.encode()).digest()).decode()
    policy = response.headers["content-security-policy"]
    assert "default-src 'none'" in policy
    assert f"style-src 'sha256-{digest}';" in policy
    assert "unsafe" not in policy
    assert "http" not in policy
    assert (
        re.findall(r"<script|<link|<img|<iframe|<object|style=|\bon\w+=|url\(|@import", text) == []
    )
    assert response.headers["x-content-type-options"] == "nosniff"
    assert response.headers["x-frame-options"] == "DENY"
    assert response.headers["referrer-policy"] == "no-referrer"


def test_whatever_text_is_shown_is_text():
    content = (
        link(HOSTILE, HOSTILE)
        + definitions([(HOSTILE, "")])
        + table(HOSTILE, (HOSTILE,), [("cell",)])
    )
    text = page(HOSTILE, content).body.decode()
    assert "<script" not in text
    Tree(text)


def test_tables_say_what_their_heads_are_heads_of(response):
    tags = Tree(response.body.decode()).tags
    heads = [given["scope"] for name, given in tags if name == "th"]
    assert heads == ["col", "col", "row", "row"]
    assert ("caption", {}) in tags
    (region,) = (given for name, given in tags if given.get("role") == "region")
    assert region["tabindex"] == "0"
    assert region["aria-label"] == "Caption"


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
@pytest.mark.parametrize("ground", ["back", "box"])
@pytest.mark.parametrize("name", ["text", "soft", "link", "good", "fair", "bad"])
def test_text_stands_out_from_its_ground(response, scheme, ground, name):
    """WCAG 2.2, success criterion 1.4.3: a contrast of 4.5 at least."""
    named = colours(response.body.decode(), scheme)
    low, high = sorted((luminance(named[ground]), luminance(named[name])))
    assert (high + 0.05) / (low + 0.05) >= 4.5
