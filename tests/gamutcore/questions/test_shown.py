"""Results in one line and as tables of notebooks, in the core and in the client."""

import dataclasses
import inspect
import re

import numpy as np
import pytest

import gamutcore.results
from gamutcore import Gamut

UNIT = 2.0 * np.array(list(np.ndindex(2, 2, 2))) - 1

ANSWERS = {
    "cusps": lambda one, _: one.cusps(),
    "nearest": lambda one, _: one.nearest([50, 90, 0]),
    "many nearest": lambda one, _: one.nearest([(50, 90, 0)] * 1000),
    "no colour": lambda one, _: one.nearest(np.zeros((0, 3))),
    "map": lambda one, _: one.map([(50, 90, 0)] * 10),
    "crossings": lambda one, _: one.crossings([50, 0, 0], [50, 90, 0]),
    "slice": lambda one, _: one.slice(50),
    "empty slice": lambda one, _: one.slice(5),
    "leaves": lambda one, _: one.leaves(),
    "rings": lambda one, other: one.rings(other),
    "compare": lambda one, other: one.compare(other),
    "sectors": lambda one, other: one.compare(other).sectors,
    "intersection": lambda one, other: one & other,
    "mesh": lambda one, _: one.mesh(8),
}


@pytest.fixture(scope="module")
def gamuts():
    return [Gamut(half * UNIT + (50, 0, 0), gamma=1) for half in (20, 10)]


@pytest.mark.parametrize("name", ANSWERS)
def test_every_answer_is_shown_in_one_line_and_as_a_table(gamuts, name):
    answer = ANSWERS[name](*gamuts)
    line, table = repr(answer), answer._repr_html_()
    assert line == str(answer)
    assert line.startswith(f"<{type(answer).__name__}: ")
    assert "\n" not in line
    assert "array" not in line
    assert len(line) < 400
    assert table.count("<tr>") >= 2
    assert max(part.count("<tr>") for part in table.split("<table>")) <= 13  # with a head
    assert not re.search("(?<!-)color *:|background *:(?!lab)", table)  # those of the notebook


def test_ranges_shapes_and_single_values_are_shown(gamuts):
    one, other = gamuts
    assert "hue 0 to 359 (360), lightness" in repr(one.cusps())
    assert "points 360 × 3, " in repr(one.cusps())
    assert "points 50 20 0, " in repr(one.nearest([50, 90, 0], metric="CIE 1976"))
    assert "moved 1 of 2" in repr(one.map([(50, 90, 0), (50, 0, 0)]))
    assert repr(one & other).startswith(
        "<Intersection: volume 8000, of_first 0.125, of_second 1, jaccard 0.125"
    )
    assert (
        "<th style='text-align:left'>volume</th><td style='text-align:left'>8000</td>"
        in (one & other)._repr_html_()
    )


def test_few_colours_are_a_table_with_swatches(gamuts):
    table = gamuts[0].map([(50, 90, 0), (50, 0, 0)])._repr_html_()
    assert table.count("background:lab(50% ") == 2
    assert "<td>50 0 0</td><td>no</td>" in table
    assert "background:color(srgb " in gamuts[0].nearest([(1, 0, 0)], space="sRGB")._repr_html_()
    assert "background" not in gamuts[0].nearest([(1, 0, 0)], space="CIEXYZ")._repr_html_()
    assert gamuts[0].nearest([50, 90, 0])._repr_html_().count("background:lab(") == 1


def test_colours_that_are_none_of_css_have_no_swatches():
    gamut = Gamut(20 * UNIT + (50, 0, 0), gamma=1, reference_white="D65")
    assert "background" not in gamut.nearest([50, 90, 0])._repr_html_()
    assert "background" not in gamut.nearest([50, 90, 0], space="LCHab")._repr_html_()
    assert "background" in gamut.nearest([1, 0, 0], space="sRGB")._repr_html_()
    stated = gamut.conditions
    for read in (stated.from_header(stated.header), stated.from_dict(stated.to_dict())):
        assert read.white == stated.white == "D65"


def test_texts_of_files_do_not_break_the_line_or_the_table(gamuts):
    answer = dataclasses.replace(gamuts[0].cusps(), channels=("a\nb", "<i>", "x" * 1000))
    assert "channels a b <i> xxx" in repr(answer)
    assert len(repr(answer)) < 400
    assert "&lt;i&gt;" in answer._repr_html_()


def test_every_kind_of_result_is_shown_so():
    """A data class has a line of its own unless it says repr=False."""
    kinds = [kind for kind in vars(gamutcore.results).values() if inspect.isclass(kind)]
    own = [kind for kind in kinds if dataclasses.is_dataclass(kind)]
    assert len(own) >= 8
    assert [
        kind for kind in own if kind.__repr__ is not gamutcore.results.TabularRepr.__repr__
    ] == []
