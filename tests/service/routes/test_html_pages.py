"""Pages: well-formed, closed to scripts, and readable in light and in dark."""

import base64
import hashlib
import re
from html.parser import HTMLParser

import pytest

from service.routes.html_pages import definitions, link, page, table

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
