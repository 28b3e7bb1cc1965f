"""Numbers of mesh files: blocks of text, and polygons."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gamutcore.characterisation.meshes.numbers as module
from gamutcore.characterisation.meshes.numbers import numbers_of, polygon_triangles
from gamutcore.errors import MalformedFileError


@given(st.lists(st.floats(allow_nan=False)), st.integers(1, 60))
def test_blocks_of_any_size_give_the_same_numbers(values, block):
    text = " \n".join(map(repr, values)).encode()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "_BLOCK", block)
        np.testing.assert_array_equal(numbers_of(text, 1, 10**6), np.array(values, float))


def test_no_more_are_read_than_are_wanted():
    assert numbers_of(b"1 2 3 4 5", 1, 3).tolist() == [1, 2, 3]


@pytest.mark.parametrize("block", [1 << 20, 4])
def test_a_fault_is_named_with_its_line(monkeypatch, block):
    monkeypatch.setattr(module, "_BLOCK", block)
    with pytest.raises(MalformedFileError, match="1_0") as caught:
        numbers_of(b"1 2\n3 4\n\n5 1_0\n7", 20, 100)
    assert caught.value.where == {"line": 23}


def test_a_word_without_an_end_is_refused(monkeypatch):
    monkeypatch.setattr(module, "_BLOCK", 100)
    with pytest.raises(MalformedFileError):
        numbers_of(b"1" * 10_000, 1, 100)


def test_polygons_are_split_from_their_first_corner():
    corners = np.array([7, 8, 9, 1, 2, 3, 4, 5, 6])
    triangles = polygon_triangles(np.array([3, 0, 4, 2]), corners)
    assert triangles.tolist() == [[7, 8, 9], [1, 2, 3], [1, 3, 4]]
