"""The page of a gamut: complete, inert towards what it contains, and without a way out."""

import base64
import hashlib
import json
from html.parser import HTMLParser

import numpy as np
import pytest

from gamutcore import Gamut
from gamutcore.errors import OptionError

COLOURS = [(20, 0, 0), (90, 0, 0), (50, 60, 0), (50, -40, 50), (50, -40, -50)]


class Page(HTMLParser):
    """Elements of a page, and the text of its scripts and styles, as a browser parses them."""

    def __init__(self, content):
        super().__init__()
        self.tags, self.texts = [], []
        self.feed(content.decode())

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        self.tags.append((f"/{tag}", {}))

    def handle_data(self, data):
        if self.tags and self.tags[-1][0] in ("script", "style"):
            self.texts.append((self.tags[-1], data))

    def text(self, tag, **attributes):
        [found] = [
            text
            for (name, given), text in self.texts
            if name == tag and attributes.items() <= given.items()
        ]
        return found


@pytest.fixture(scope="module")
def gamut():
    return Gamut(COLOURS)


@pytest.fixture(scope="module")
def page(gamut):
    return Page(gamut.to_html("A press"))


def test_it_has_the_history_and_the_description(page, gamut):
    [content] = json.loads(page.text("script", id="gamut-file"))["gamuts"]
    assert base64.b64decode(content["history"]) == gamut.to_bytes()
    assert content["gamut"] == {**gamut.description, "name": "A press", "channels": []}
    assert json.loads(page.text("script", id="page-state")) is None


def test_several_gamuts_have_given_names_or_those_of_their_data(gamut):
    others = [Gamut(np.array(COLOURS) * scale) for scale in (0.9, 0.8)]
    page = Page(gamut.to_html(["A press", "Smaller"], *others))
    found = json.loads(page.text("script", id="gamut-file"))["gamuts"]
    assert [each["gamut"]["id"] for each in found] == [each.id for each in (gamut, *others)]
    names = [each["gamut"]["name"] for each in found]
    assert names == ["A press", "Smaller", f"Gamut {others[1].id[:12]}"]
    with pytest.raises(OptionError):
        gamut.to_html("Too many", *[gamut] * 6)


def test_two_gamuts_bring_their_coverage(page, gamut):
    assert json.loads(page.text("script", id="gamut-file"))["coverage"] is None
    smaller = Gamut(np.array(COLOURS) * 0.9)
    text = Page(gamut.to_html((), smaller)).text("script", id="gamut-file")
    coverage = json.loads(text)["coverage"]
    common = coverage["b_covers_a"] * gamut.description["volume"]
    assert 0 < coverage["b_covers_a"] < 1
    assert coverage["a_covers_b"] * smaller.description["volume"] == pytest.approx(common, rel=1e-3)
    assert coverage["summary"]


def test_a_notebook_shows_the_page_in_a_frame_with_a_state(gamut, tmp_path):
    state = "colours=</script>&theme=dark"
    shown = gamut.show(gamut, state=f"#{state}", height=300)
    shown.save(tmp_path / "shown.html")
    assert (tmp_path / "shown.html").read_bytes() == shown.html
    found = Page(shown.html)
    assert json.loads(found.text("script", id="page-state")) == {"address": state}
    assert len(json.loads(found.text("script", id="gamut-file"))["gamuts"]) == 2
    [(tag, frame), _] = Page(shown._repr_html_().encode()).tags
    assert (tag, frame["height"]) == ("iframe", "300")
    assert frame["srcdoc"].encode() == shown.html
    assert gamut.show().html == gamut.to_html()
    assert len(repr(shown)) < 100  # notebooks keep it beside the frame
    other = Gamut(COLOURS, space="CIELUV")
    for refused in (gamut.show, lambda other: gamut.to_html((), other)):
        with pytest.raises(OptionError):
            refused(other)


def test_nothing_is_loaded(page):
    addresses = [
        value
        for tag, given in page.tags
        for name, value in given.items()
        if name in ("src", "href") and tag != "a"
    ]
    assert addresses == ["data:,"]


def test_its_policy_allows_its_own_script_and_style_and_no_connection(page):
    [policy] = [given["content"] for tag, given in page.tags if "http-equiv" in given]
    rules = dict(rule.strip().split(" ", 1) for rule in policy.split(";"))
    assert rules["default-src"] == "'none'"
    assert "connect-src" not in rules
    for rule, text in (
        ("script-src", page.text("script", type="module")),
        ("style-src", page.text("style")),
    ):
        assert "unsafe" not in rules[rule]
        digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
        assert f"'sha256-{digest}'" in rules[rule]


@pytest.mark.parametrize(
    "name", ["</script><script>alert(1)</script>", "<!--<script>", "</title>&amp;", "\u2028'\"\\"]
)
def test_a_name_is_only_a_name(gamut, page, name):
    content = gamut.to_html(name)
    found = Page(content)
    assert [tag for tag, _ in found.tags] == [tag for tag, _ in page.tags]
    [read] = json.loads(found.text("script", id="gamut-file"))["gamuts"]
    assert read["gamut"]["name"] == name


def test_a_suffix_chooses_the_page(gamut, tmp_path):
    gamut.save(tmp_path / "My press.HTML")
    assert (tmp_path / "My press.HTML").read_bytes() == gamut.to_html("My press")
    gamut.save(tmp_path / "html")
    assert Gamut.load(tmp_path / "html").id == gamut.id
