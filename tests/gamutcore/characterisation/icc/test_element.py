from __future__ import annotations

import numpy as np
import pytest

from gamutcore.characterisation.icc.element import Element
from gamutcore.errors import MalformedProfileError

ELEMENT = Element("test", b"abcd" + bytes([0, 0, 0, 5, 255, 255, 0, 0, 0x80, 0]))


def test_numbers_are_big_endian():
    assert ELEMENT.kind == "abcd"
    assert ELEMENT.unsigned(4, 4) == 5
    assert ELEMENT.unsigned(12, 2) == 0x8000


def test_fixed_point_numbers():
    # ICC.1:2022, table 4: FFFF0000h is -1, 00018000h is 1.5.
    element = Element("test", bytes.fromhex("ffff000000018000"))
    np.testing.assert_array_equal(element.fixed(0, 2), [-1, 1.5])


def test_bytes_and_words_have_one_full_scale():
    element = Element("test", bytes([0, 255, 128]))
    np.testing.assert_array_equal(element.integers(0, 3, 1), [0, 65535, 32896])
    np.testing.assert_array_equal(element.integers(0, 1, 2), [255])


@pytest.mark.parametrize(
    "read",
    [
        lambda e: e.raw(10, 5),
        lambda e: e.raw(-1, 2),
        lambda e: e.raw(2**32, 2**32),
        lambda e: e.unsigned(12, 4),
        lambda e: e.integers(0, 2**31, 2),
        lambda e: e.fixed(4, 4),
    ],
)
def test_nothing_beyond_the_tag_is_read(read):
    with pytest.raises(MalformedProfileError) as caught:
        read(ELEMENT)
    assert caught.value.where == {"tag": "test"}
