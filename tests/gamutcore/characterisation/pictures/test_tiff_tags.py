import struct

import pytest

from gamutcore.characterisation.pictures.tiff_tags import tiff_directory
from gamutcore.errors import MalformedFileError


@pytest.mark.parametrize("big", [False, True])
@pytest.mark.parametrize("order", ["<", ">"])
def test_values_within_and_behind_the_directory(tiff, order, big):
    stated = {256: (4, [70_000]), 258: (3, [8, 16, 8]), 34675: (7, b"a profile")}
    tags, following = tiff_directory(tiff([b"12"], stated, order=order, big=big), 0)
    assert tags.whole(256, 0) == 70_000
    assert tags.numbers(258) == (8, 16, 8)
    assert tags.content(34675) == b"a profile"
    assert (tags.whole(999, 5), tags.numbers(999), tags.content(999)) == (5, (), b"")
    assert following == 0


def directory(*entries):
    table = b"".join(struct.pack("<HHII", *entry) for entry in entries)
    return b"II*\0\x08\0\0\0" + struct.pack("<H", len(entries)) + table + bytes(4)


def test_values_beyond_the_file():
    with pytest.raises(MalformedFileError, match="not within the file") as caught:
        tiff_directory(directory((273, 4, 100, 26)), 0)
    assert caught.value.where == {"tag": "273"}


def test_types_that_nobody_knows_are_passed_over():
    tags, _ = tiff_directory(directory((700, 99, 1, 0), (256, 3, 1, 9)), 0)
    assert tags.whole(256, 0) == 9
    assert tags.numbers(700) == ()


def test_rationals_without_a_denominator_are_nothing():
    data = directory((282, 5, 1, 26)) + struct.pack("<II", 3, 0)
    tags, _ = tiff_directory(data, 0)
    assert tags.numbers(282) == (0.0,)
    with pytest.raises(MalformedFileError, match="whole number"):
        tags.whole(282, 1)


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"II*\0",
        b"II*\0\xff\xff\xff\xff",
        b"II*\0\x08\0\0\0\0\0" + bytes(4),
        b"II*\0\x08\0\0\0\xff\xff" + bytes(40),
        b"II+\0\x08\0\0\0" + b"\xff" * 8,
        directory((256, 3, 1, 9))[:-5],
    ],
)
def test_broken_directories(data):
    with pytest.raises(MalformedFileError):
        tiff_directory(data, 0)
