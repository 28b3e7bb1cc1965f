from __future__ import annotations

import io
import pickle
import random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gamutcore.characterisation.npy_samples import NPY_MAGIC, npy_samples
from gamutcore.errors import ConditionError, GamutError, MalformedFileError, MissingColumnError

LAB = np.array([[50, 0.5, 0], [60, -20, 30]])


def saved(array, *, version=None):
    stream = io.BytesIO()
    np.lib.format.write_array(stream, np.asanyarray(array), version=version)
    return stream.getvalue()


def with_header(header, body=b"\0" * 48):
    text = header.encode()
    return NPY_MAGIC + b"\1\0" + len(text).to_bytes(2, "little") + text + body


@pytest.mark.parametrize("dtype", ["<f8", ">f8", "<f4", "<f2", ">i2", "i8"])
@pytest.mark.parametrize("order", ["C", "F"])
def test_plain_arrays_of_any_number(dtype, order):
    array = np.asarray(LAB, dtype=dtype, order=order)
    np.testing.assert_array_equal(npy_samples(saved(array)).lab, array.astype(float))


@pytest.mark.parametrize("version", [(1, 0), (2, 0), (3, 0)])
def test_every_version_of_the_format(version):
    np.testing.assert_array_equal(npy_samples(saved(LAB, version=version)).lab, LAB)


def test_named_fields():
    fields = [(name, "<f4") for name in ("id", "R", "G", "B", "LAB_L", "LAB_A", "LAB_B")]
    array = np.array([(1, 0, 0, 0, 5, 0, 1), (2, 255, 255, 255, 100, 0, 0)], dtype=fields)
    samples = npy_samples(saved(array))
    assert samples.channels == ("R", "G", "B")
    np.testing.assert_array_equal(samples.lab, [[5, 0, 1], [100, 0, 0]])


def test_a_large_array_is_read():
    lab = np.random.default_rng(1).uniform(0, 100, (200_000, 3)).astype(np.float32)
    assert len(npy_samples(saved(lab))) == 200_000


@pytest.mark.parametrize(
    "array", [np.zeros(3), np.zeros((2, 4)), np.zeros((1, 2, 3)), np.zeros(())]
)
def test_other_shapes_need_names(array):
    with pytest.raises(MissingColumnError):
        npy_samples(saved(array))


class Explosive:
    def __reduce__(self):
        return (pytest.fail, ("the file's code was run",))


@pytest.mark.parametrize(
    "data",
    [
        NPY_MAGIC,
        NPY_MAGIC + b"\x09\0" + bytes(20),
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
def test_broken_files_are_refused(data):
    with pytest.raises(MalformedFileError) as caught:
        npy_samples(data)
    assert caught.value.remedy


@settings(max_examples=100)
@given(seed=st.integers(0, 2**32))
def test_mutated_files_give_samples_or_a_named_error(seed):
    chance = random.Random(seed)  # noqa: S311
    data = bytearray(saved(LAB))
    for _ in range(chance.randint(1, 6)):
        data[chance.randrange(6, len(data))] = chance.randrange(256)
    try:
        samples = npy_samples(bytes(data))
    except GamutError:
        return
    assert np.isfinite(samples.lab).all()


def test_fields_of_all_kinds_and_conditions():
    fields = [("patch", "U8"), ("R", "u1"), ("G", "u1"), ("B", "u1"), ("CONDITION", "S2")]
    array = np.zeros(3, [*fields, *((f"SPEC_{nm}", "f4") for nm in range(380, 740, 10))])
    array["CONDITION"] = [b"M0", b"M1", b"m1"]
    array["SPEC_500"] = [0.25, 0.5, 0.75]
    with pytest.raises(ConditionError, match="M0, M1"):
        npy_samples(saved(array))
    samples = npy_samples(saved(array), condition="M1")
    assert samples.spectra.values[:, 12].tolist() == [0.5, 0.75]
    assert samples.device.shape == (2, 3)
    chromaticities = np.array([(0.25, 0.5, 10)], [("x", "f8"), ("y", "f8"), ("Y", "f8")])
    np.testing.assert_allclose(npy_samples(saved(chromaticities)).xyz, [[5, 10, 5]])


def test_texts_in_the_place_of_numbers_are_refused():
    array = np.array([("1", 2, 3)], [("L", "U4"), ("a", "f8"), ("b", "f8")])
    with pytest.raises(MalformedFileError) as caught:
        npy_samples(saved(array))
    assert caught.value.where["field"] == "L"
