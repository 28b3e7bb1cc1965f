from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gamutcore.characterisation.delimited import delimited_samples
from gamutcore.errors import (
    ConditionError,
    GamutError,
    MalformedFileError,
    MissingColumnError,
    UnrecognisedFormatError,
)

ROWS = [["50", "0.5", "0"], ["60", "-20", "30"]]
LAB = np.array([[50, 0.5, 0], [60, -20, 30]])


@pytest.mark.parametrize("header", [["LAB_L", "LAB_A", "LAB_B"], ["L*", "a*", "b*"], None])
@pytest.mark.parametrize("mark", [",", ";", "\t", " ", ", "])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_every_delimiter_and_line_end(header, mark, end):
    lines = [mark.join(row) for row in [header, *ROWS] if row]
    samples = delimited_samples(end.join(["# a note", "", *lines]) + end)
    np.testing.assert_array_equal(samples.lab, LAB)
    assert bool(samples.warnings) == (header is None)


def test_decimal_commas_between_semicolons():
    samples = delimited_samples("L;a;b\n50,0;0,5;0\n60;-2,0e1;30\n")
    np.testing.assert_array_equal(samples.lab, LAB)


def test_quoted_cells_and_further_columns():
    text = '"name, of patch","L","a","b"\n"x, y",50,0.5,0\n"z",60,-20,30,\n'
    np.testing.assert_array_equal(delimited_samples(text).lab, LAB)


def test_device_values_beside_colours():
    samples = delimited_samples("R,G,B,X,Y,Z\n0,0,0,0,0,0\n255,255,255,95.04,100,108.9\n")
    assert samples.channels == ("R", "G", "B")
    np.testing.assert_array_equal(samples.device, [[0, 0, 0], [1, 1, 1]])
    assert samples.lab is None


@pytest.mark.parametrize(
    ("text", "where"),
    [
        ("L,a,b\n1,2,3\n1,2\n", {"line": 3, "column": 3}),
        ("L,a,b\n1,2,3\n\n1,2,3,4\n", {"line": 4, "column": 4}),
        ("L,a,b\n1,2,x\n", {"line": 2, "column": 3, "field": "b"}),
        ("L,a,b\n" + "1," * 2 + '"' + "3" * 200_000, {"line": 2}),
    ],
)
def test_errors_say_where(text, where):
    with pytest.raises(MalformedFileError) as caught:
        delimited_samples(text)
    assert {key: caught.value.where[key] for key in where} == where


def test_tables_without_colour_or_names():
    with pytest.raises(MissingColumnError, match="Lightness"):
        delimited_samples("Lightness,red,yellow\n1,2,3\n")
    with pytest.raises(MissingColumnError, match="no names"):
        delimited_samples("1,2,3,4\n1,2,3,4\n")


@pytest.mark.parametrize("text", ["", "# only a note\n", "This is prose, not data", "one\ntwo\n"])
def test_prose_is_no_table(text):
    with pytest.raises(UnrecognisedFormatError):
        delimited_samples(text)


@given(st.lists(st.sampled_from(['"', ",", ";", "\t", "\n", "1", "L", "a", "b", "#", " "])))
def test_any_text_gives_samples_or_a_named_error(pieces):
    try:
        samples = delimited_samples("".join(pieces))
    except GamutError:
        return
    assert np.isfinite(samples.lab).all()


def test_wavelengths_as_names():
    bands = range(380, 740, 10)
    text = ";".join(map(str, bands)) + "\n" + ";".join(["0,5"] * 36) + "\n"
    samples = delimited_samples(text)
    assert samples.spectra.wavelengths.tolist() == list(bands)
    assert set(samples.spectra.values[0]) == {0.5}


def test_named_columns_of_all_kinds():
    np.testing.assert_allclose(delimited_samples("x,y,Y\n0.25,0.5,10\n").xyz, [[5, 10, 5]])
    polar = delimited_samples("C\tM\tY\tK\tL*\tC*\th\n0\t0\t0\t100\t50\t20\t180\n")
    np.testing.assert_allclose(polar.lab, [[50, -20, 0]], atol=1e-12)
    assert polar.channels == ("C", "M", "Y", "K")


def test_rows_of_one_condition_are_chosen():
    text = "condition,L,a,b\nM0,50,1,2\nM1,60,1,2\n"
    with pytest.raises(ConditionError, match="M0, M1"):
        delimited_samples(text)
    assert delimited_samples(text, condition="M1").lab.tolist() == [[60, 1, 2]]
