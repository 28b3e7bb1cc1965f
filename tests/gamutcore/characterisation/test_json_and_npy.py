"""Samples in JSON documents and in NumPy arrays."""

import io
import json
import pickle
import random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gamutcore.characterisation import read_characterisation
from gamutcore.characterisation.samples import MAX_JSON_SAMPLES
from gamutcore.errors import (
    ConditionError,
    GamutError,
    MalformedFileError,
    MissingColumnError,
    SampleLimitError,
)

ROWS = [[50, 0.5, 0], [60, -20, 30]]


def read(text, **options):
    return read_characterisation(text.encode(), **options)


@pytest.mark.parametrize(
    "document",
    [
        ROWS,
        {"samples": ROWS},
        {"columns": ["LAB_L", "LAB_A", "LAB_B"], "samples": ROWS},
        {"columns": ["id", "L", "a", "b"], "samples": [[1, *ROWS[0]], [2, *ROWS[1]]]},
        {"samples": [dict(zip("Lab", row, strict=True)) for row in ROWS]},
    ],
)
def test_every_shape_of_document(document):
    np.testing.assert_array_equal(read(json.dumps(document)).lab, ROWS)


def test_white_and_conditions():
    samples = read(
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
        read(text)
    assert {key: caught.value.where[key] for key in where} == where


def test_unknown_columns_are_refused():
    with pytest.raises(MissingColumnError):
        read('{"columns": ["p", "q", "r"], "samples": [[1, 2, 3]]}')


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
        read(text)


@pytest.mark.parametrize("text", ["[" + "[]," * (MAX_JSON_SAMPLES + 101), "[" + "0," * 8_000_001])
def test_documents_that_would_take_much_memory_are_refused(text):
    with pytest.raises(SampleLimitError):
        read(text)


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
        samples = read(json.dumps(tree))
    except GamutError:
        return
    assert np.isfinite(samples.lab).all()


BANDS = [f"SPEC_{nm}" for nm in range(380, 740, 10)]


def test_spectra_names_and_conditions():
    columns = ["patch", "MEASUREMENT_CONDITION", "R", "G", "B", *BANDS]
    rows = [["white", "M0", 255, 255, 255, *[0.9] * 36], ["w", "M2", 255, 255, 255, *[0.8] * 36]]
    text = json.dumps({"columns": columns, "samples": rows})
    with pytest.raises(ConditionError, match="M0, M2"):
        read(text)
    samples = read(text, condition="M2")
    assert set(samples.spectra.values[0]) == {0.8}
    assert samples.condition == "M2"


def test_a_condition_of_the_document():
    text = json.dumps({"samples": ROWS, "conditions": {"MEASUREMENT_CONDITION": "M1"}})
    assert read(text).condition == "M1"
    with pytest.raises(ConditionError):
        read(text, condition="M0")


@pytest.mark.parametrize("cell", [3, True, ["M0"]])
def test_a_condition_that_is_no_text_is_refused(cell):
    columns = ["CONDITION", "L", "a", "b"]
    with pytest.raises(MalformedFileError) as caught:
        read(json.dumps({"columns": columns, "samples": [[cell, 1, 2, 3]]}))
    assert caught.value.where == {"row": 1, "field": "samples[0][0]"}


LAB = np.array([[50, 0.5, 0], [60, -20, 30]])


def saved(array, *, version=None):
    stream = io.BytesIO()
    np.lib.format.write_array(stream, np.asanyarray(array), version=version)
    return stream.getvalue()


def with_header(header, body=b"\0" * 48):
    text = header.encode()
    return np.lib.format.MAGIC_PREFIX + b"\1\0" + len(text).to_bytes(2, "little") + text + body


@pytest.mark.parametrize("dtype", ["<f8", ">f8", "<f4", "<f2", ">i2", "i8"])
@pytest.mark.parametrize("order", ["C", "F"])
def test_plain_arrays_of_any_number(dtype, order):
    array = np.asarray(LAB, dtype=dtype, order=order)
    np.testing.assert_array_equal(read_characterisation(saved(array)).lab, array.astype(float))


@pytest.mark.parametrize("version", [(1, 0), (2, 0), (3, 0)])
def test_every_version_of_the_format(version):
    np.testing.assert_array_equal(read_characterisation(saved(LAB, version=version)).lab, LAB)


def test_named_fields():
    fields = [(name, "<f4") for name in ("id", "R", "G", "B", "LAB_L", "LAB_A", "LAB_B")]
    array = np.array([(1, 0, 0, 0, 5, 0, 1), (2, 255, 255, 255, 100, 0, 0)], dtype=fields)
    samples = read_characterisation(saved(array))
    assert samples.channels == ("R", "G", "B")
    np.testing.assert_array_equal(samples.lab, [[5, 0, 1], [100, 0, 0]])


class Explosive:
    def __reduce__(self):
        return (pytest.fail, ("the file's code was run",))


@pytest.mark.parametrize(
    "data",
    [
        np.lib.format.MAGIC_PREFIX,
        np.lib.format.MAGIC_PREFIX + b"\x09\0" + bytes(20),
        saved(LAB)[:-1],
        saved(LAB) + b"\0",
        saved(LAB)[:20],
        saved(np.array(["a", "b"])),
        saved(LAB.astype(complex)),
        saved(np.zeros((2, 3), "M8[s]")),
        with_header("{'descr': '|O', 'fortran_order': False, 'shape': (2, 3)}", pickle.dumps(0)),
        with_header(
            "{'descr': '|O', 'fortran_order': False, 'shape': (2, 3)}", pickle.dumps(Explosive())
        ),
        with_header("{'descr': '<f8', 'fortran_order': False, 'shape': (10000000000, 3)}"),
        with_header("{'descr': '<f8', 'fortran_order': False, 'shape': (-2, 3)}"),
        with_header("{'descr': '<f8', 'fortran_order': False, 'shape': (2, 3), 'x': 1}"),
        with_header("{'descr': '<f8', 'fortran_order': False, 'shape': 6}"),
        with_header("{'descr': ('<f8', (99999999,)), 'fortran_order': False, 'shape': (2,)}"),
        with_header("{'descr': [('L', '<f8', (2,))], 'fortran_order': False, 'shape': (3,)}"),
        with_header("__import__('os').abort()"),
        with_header("(" * 9000),
        with_header("-" * 9000 + "1"),
        with_header("'\0'"),
    ],
)
def test_broken_arrays_are_refused(data):
    with pytest.raises(MalformedFileError) as caught:
        read_characterisation(data)
    assert caught.value.remedy


@settings(max_examples=100)
@given(seed=st.integers(0, 2**32))
def test_mutated_arrays_give_samples_or_a_named_error(seed):
    chance = random.Random(seed)  # noqa: S311
    data = bytearray(saved(LAB))
    for _ in range(chance.randint(1, 6)):
        data[chance.randrange(6, len(data))] = chance.randrange(256)
    try:
        samples = read_characterisation(bytes(data))
    except GamutError:
        return
    assert np.isfinite(samples.lab).all()


def test_fields_of_all_kinds_and_conditions():
    fields = [("patch", "U8"), ("R", "u1"), ("G", "u1"), ("B", "u1"), ("CONDITION", "S2")]
    array = np.zeros(3, [*fields, *((f"SPEC_{nm}", "f4") for nm in range(380, 740, 10))])
    array["CONDITION"] = [b"M0", b"M1", b"m1"]
    array["SPEC_500"] = [0.25, 0.5, 0.75]
    with pytest.raises(ConditionError, match="M0, M1"):
        read_characterisation(saved(array))
    samples = read_characterisation(saved(array), condition="M1")
    assert samples.spectra.values[:, 12].tolist() == [0.5, 0.75]
    assert samples.device.shape == (2, 3)
    chromaticities = np.array([(0.25, 0.5, 10)], [("x", "f8"), ("y", "f8"), ("Y", "f8")])
    np.testing.assert_allclose(read_characterisation(saved(chromaticities)).xyz, [[5, 10, 5]])


def test_texts_in_the_place_of_numbers_are_refused():
    array = np.array([("1", 2, 3)], [("L", "U4"), ("a", "f8"), ("b", "f8")])
    with pytest.raises(MalformedFileError) as caught:
        read_characterisation(saved(array))
    assert caught.value.where["field"] == "L"


@pytest.mark.parametrize(
    "array", [np.zeros(3), np.zeros((2, 4)), np.zeros((1, 2, 3)), np.zeros(())]
)
def test_other_shapes_need_names(array):
    with pytest.raises(MissingColumnError):
        read_characterisation(saved(array))
