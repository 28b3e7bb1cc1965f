from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gamutcore.characterisation.json_samples import MAX_JSON_SAMPLES, json_samples
from gamutcore.errors import (
    ConditionError,
    GamutError,
    MalformedFileError,
    MissingColumnError,
    SampleLimitError,
)

LAB = [[50, 0.5, 0], [60, -20, 30]]


@pytest.mark.parametrize(
    "document",
    [
        LAB,
        {"samples": LAB},
        {"columns": ["LAB_L", "LAB_A", "LAB_B"], "samples": LAB},
        {"columns": ["id", "L", "a", "b"], "samples": [[1, *LAB[0]], [2, *LAB[1]]]},
        {"samples": [dict(zip("Lab", row, strict=True)) for row in LAB]},
    ],
)
def test_every_shape_of_document(document):
    np.testing.assert_array_equal(json_samples(json.dumps(document)).lab, LAB)


def test_white_and_conditions():
    samples = json_samples(
        json.dumps(
            {
                "columns": ["RGB_R", "RGB_G", "RGB_B", "XYZ_X", "XYZ_Y", "XYZ_Z"],
                "samples": [[255, 0, 0, 41, 21, 2]],
                "white": [95, 100, 109],
                "illuminant": "D65",
                "conditions": {"observer": "2 degree", "instrument": 7},
            }
        )
    )
    np.testing.assert_array_equal(samples.white, [95, 100, 109])
    assert samples.conditions == {"ILLUMINANT": "D65", "OBSERVER": "2 degree", "INSTRUMENT": "7"}


@pytest.mark.parametrize(
    ("text", "where"),
    [
        ('{"samples": [[1, 2, 3],]}', {"line": 1}),
        ("[[1, 2, 3], [1, 2]]", {"row": 2, "field": "samples[1]"}),
        ("[[1, 2, 3], 7]", {"row": 2}),
        ('[[1, 2, 3], [1, "2", 3]]', {"row": 2, "column": 2, "field": "samples[1][1]"}),
        ("[[1, 2, true]]", {"row": 1, "column": 3}),
        ("[[1, 2, null]]", {"row": 1, "column": 3}),
        ("[[1, 2, NaN]]", {"field": "samples"}),
        ("[[1, 2, -Infinity]]", {"field": "samples"}),
        ("[[1, 2, 1" + "0" * 400 + "]]", {"row": 1, "column": 3}),
        ('{"samples": 3}', {"field": "samples"}),
        ('{"samples": [[1, 2, 3]], "columns": "Lab"}', {"field": "columns"}),
        ('{"samples": [[1, 2, 3]], "white": [1, 2]}', {"field": "white"}),
        ('{"samples": [[1, 2, 3]], "white": [0, 1, 1]}', {"field": "white"}),
        ('{"samples": [[1, 2, 3]], "conditions": 3}', {"field": "conditions"}),
        ('{"samples": [[1, 2, 3]], "smaples": [[1]]}', {"field": "smaples"}),
        ('{"samples": [[1, 2, 3]], "samples": [[4, 5, 6]]}', {"field": "samples"}),
        ('{"samples": [{"L": 1, "a": 2, "b": 3, "a": 4}]}', {"field": "a"}),
        ('{"samples": [{"L": 1, "a": 2, "b": 3}, {"L": 1, "a": 2}]}', {"row": 2, "column": 3}),
    ],
)
def test_errors_say_where(text, where):
    with pytest.raises(MalformedFileError) as caught:
        json_samples(text)
    assert {key: caught.value.where[key] for key in where} == where


def test_numbers_beyond_floats_are_refused():
    with pytest.raises(GamutError, match="finite"):
        json_samples("[[1, 2, 1e999]]")


def test_unknown_columns_are_refused():
    with pytest.raises(MissingColumnError):
        json_samples('{"columns": ["p", "q", "r"], "samples": [[1, 2, 3]]}')


@pytest.mark.parametrize(
    "text",
    [
        "[" * 200_000,
        '{"a":' * 200_000,
        "[[" + "9" * 10_000 + ", 1, 1]]",
    ],
)
def test_deep_and_long_documents_are_refused(text):
    with pytest.raises(MalformedFileError):
        json_samples(text)


@pytest.mark.parametrize("text", ["[" + "[]," * (MAX_JSON_SAMPLES + 101), "[" + "0," * 8_000_001])
def test_documents_that_would_take_much_memory_are_refused(text):
    with pytest.raises(SampleLimitError):
        json_samples(text)


leaves = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5)
names = st.sampled_from(["samples", "columns", "white", "conditions", "L", "a", "b", "x"])
trees = st.recursive(
    leaves,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(names, inner, max_size=4),
    max_leaves=30,
)


@given(trees)
@pytest.mark.slow
def test_any_document_gives_samples_or_a_named_error(tree):
    try:
        samples = json_samples(json.dumps(tree))
    except GamutError:
        return
    assert np.isfinite(samples.lab).all()


BANDS = [f"SPEC_{nm}" for nm in range(380, 740, 10)]


def test_spectra_names_and_conditions():
    columns = ["patch", "MEASUREMENT_CONDITION", "R", "G", "B", *BANDS]
    rows = [["white", "M0", 255, 255, 255, *[0.9] * 36], ["w", "M2", 255, 255, 255, *[0.8] * 36]]
    text = json.dumps({"columns": columns, "samples": rows})
    with pytest.raises(ConditionError, match="M0, M2"):
        json_samples(text)
    samples = json_samples(text, condition="M2")
    assert set(samples.spectra.values[0]) == {0.8}
    assert samples.condition == "M2"


def test_a_condition_of_the_document():
    text = json.dumps({"samples": LAB, "conditions": {"MEASUREMENT_CONDITION": "M1"}})
    assert json_samples(text).condition == "M1"
    with pytest.raises(ConditionError):
        json_samples(text, condition="M0")


@pytest.mark.parametrize("cell", [3, True, ["M0"]])
def test_a_condition_that_is_no_text_is_refused(cell):
    columns = ["CONDITION", "L", "a", "b"]
    with pytest.raises(MalformedFileError) as caught:
        json_samples(json.dumps({"columns": columns, "samples": [[cell, 1, 2, 3]]}))
    assert caught.value.where == {"row": 1, "field": "samples[0][0]"}
