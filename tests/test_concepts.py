"""The pictures of docs/concepts.md are those that the program draws."""

import re
import runpy
from pathlib import Path

import pytest

DOCUMENTS = Path(__file__).parents[1] / "docs"
PROGRAM = DOCUMENTS / "pictures" / "concepts.py"


@pytest.fixture(scope="module")
def program():
    return runpy.run_path(str(PROGRAM))


def test_the_page_shows_every_picture_in_the_order_of_the_program(program):
    shown = re.findall(r"\(pictures/concepts/(\w+)\.svg\)", (DOCUMENTS / "concepts.md").read_text())
    assert shown == list(program["CONCEPTS"])
    assert sorted(path.stem for path in program["FOLDER"].iterdir()) == sorted(shown)


def test_text_and_lines_are_visible_on_light_and_dark_pages(program):
    """WCAG 2.2, relative luminance and contrast; 3 is the minimum for graphics."""

    def luminance(colour):
        shares = [int(colour[place : place + 2], 16) / 255 for place in (1, 3, 5)]
        linear = [v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4 for v in shares]
        return sum(
            part * weight for part, weight in zip(linear, (0.2126, 0.7152, 0.0722), strict=True)
        )

    white, dark = luminance("#ffffff"), luminance("#14181e")  # the pages of the theme
    for name in ("INK", "BLUE", "ORANGE", "GREEN", "VIOLET"):
        own = luminance(program[name])
        assert (white + 0.05) / (own + 0.05) >= 3, name
        assert (own + 0.05) / (dark + 0.05) >= 3, name


NUMBER = re.compile(r"-?\d+\.\d+")


@pytest.mark.slow
def test_the_pictures_are_up_to_date(program, tmp_path):
    """Lines and areas have the same places. Colours of pixels are left to the eye."""
    program["draw_concepts"](tmp_path)
    for drawn in sorted(tmp_path.iterdir()):
        kept = (program["FOLDER"] / drawn.name).read_text()
        paths = [re.findall(r' d="([^"]*)"', text) for text in (drawn.read_text(), kept)]
        assert [len(NUMBER.findall(path)) for path in paths[0]] == [
            len(NUMBER.findall(path)) for path in paths[1]
        ], drawn.name
        for new, old in zip(*paths, strict=True):
            places = [list(map(float, NUMBER.findall(path))) for path in (new, old)]
            assert places[0] == pytest.approx(places[1], abs=0.5), drawn.name
