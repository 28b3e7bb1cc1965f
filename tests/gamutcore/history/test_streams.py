"""Streams of a history file: their names, their ends, and errors that persist."""

import numpy as np
import pytest

from gamutcore.errors import HistoryFileError
from gamutcore.history.bit_codes import read_bits
from gamutcore.history.prefix_order import group_ranges
from gamutcore.history.streams import DEVICE, SPLITS, Streams, stream_name


def test_names_sort_as_the_groups_do():
    names = [stream_name(number, DEVICE) for number in range(len(group_ranges(2**25)))]
    assert names == sorted(names)
    assert names[0] == "device.00"


@pytest.mark.parametrize(
    ("read", "stream", "right"),
    [
        (16, [255, 255], True),
        (9, [255, 128], True),
        (9, [255, 129], False),
        (8, [255, 0], False),
        (0, [0], False),
        (0, [], True),
    ],
)
def test_a_stream_ends_with_less_than_a_byte_of_zeros(read, stream, right):
    def unpack():
        with streams.next_group() as (_, _, _, reader):
            for _ in range(read):
                read_bits(reader, 1)

    streams = Streams(SPLITS, [np.array(stream, np.uint8)], 8)
    if right:
        unpack()
        assert streams.is_complete
    else:
        with pytest.raises(HistoryFileError) as caught:
            unpack()
        assert caught.value.where == {"field": "splits.00"}
        assert streams.unpacked == 0


@pytest.mark.parametrize("kind", [HistoryFileError, MemoryError, KeyboardInterrupt])
def test_no_group_is_read_after_one_that_failed(kind):
    empty = np.empty(0, np.uint8)
    streams, done, fault = Streams(SPLITS, [empty] * 4, 64), [], kind("in the third group")

    def unpack():
        with streams.next_group() as (_, start, end, _):
            if start == 16:
                raise fault
            done.append((start, end))

    unpack()
    unpack()
    for _ in range(3):
        with pytest.raises(kind) as caught:
            unpack()
        assert caught.value is fault
    assert done == [(4, 8), (8, 16)]
    assert streams.unpacked == 2
