"""The page of the viewer: what its files are made of, and the options that it offers."""

import subprocess
from html.parser import HTMLParser
from pathlib import Path

import pytest

from gamutcore.arguments import marks
from gamutcore.export.viewer_page import VIEWER_FILES
from gamutcore.options import OPTIONS


def test_every_program_is_run():
    listed = "".join(path.read_text("utf-8") for path in Path(__file__).parent.glob("test_*.py"))
    programs = (Path(__file__).parents[3] / "web/viewer/tests").glob("*.test.mjs")
    names = [program.name.removesuffix(".test.mjs") for program in programs]
    assert names
    assert [name for name in names if f'"{name}"' not in listed] == []


@pytest.mark.slow
def test_the_files_are_built_from_the_sources(web):
    ended = subprocess.run(
        ["node", "build.mjs", "--check"], cwd=web, check=False, capture_output=True, text=True
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
