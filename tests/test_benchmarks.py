"""The documents show what the committed results say, and their pictures are shown and light."""

import re

import pytest

from benchmarks import markdown
from benchmarks.common import ROOT
from benchmarks.documents import DOCUMENTS

PICTURES = ROOT / "docs" / "pictures"


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.stem)
def test_generated_blocks_are_those_of_the_results(document):
    text = document.read_text()
    current = markdown.replace_blocks(text, DOCUMENTS[document]()) == text
    assert current, f"{document.name} is out of date: run `make documents`"


def test_every_picture_is_shown_and_light():
    documents = [path.read_text() for path in (ROOT / "docs").rglob("*.md")]
    picture = re.compile(r"\]\((?:\.\./)*pictures/([^)]+\.(?:png|svg))\)")
    shown = {name for text in documents for name in picture.findall(text)}
    files = [path for path in PICTURES.rglob("*") if path.suffix in {".png", ".svg"}]
    assert shown == {str(file.relative_to(PICTURES)) for file in files}
    assert max(file.stat().st_size for file in files) < 300_000


def test_blocks_are_replaced_and_the_rest_is_kept():
    text = "before\n<!-- begin a -->\nold\n<!-- end a -->\nafter"
    replaced = markdown.replace_blocks(text, {"a": "new"})
    assert markdown.blocks(replaced) == {"a": "new"}
    assert replaced.startswith("before\n")
    assert replaced.endswith("\nafter")
    assert markdown.replace_blocks(text, {}) == text


@pytest.mark.parametrize("text", ["", "<!-- begin a -->", 2 * "<!-- begin a -->\n<!-- end a -->"])
def test_a_block_must_occur_once(text):
    with pytest.raises(ValueError, match="must contain the block 'a' once"):
        markdown.replace_blocks(text, {"a": "new"})
