"""The groups of splits in a history file."""

import numpy as np
import pytest

from gamutcore.errors import HistoryFileError
from gamutcore.history.bit_codes import read_bits, reader_of
from gamutcore.history.groups import (
    DEVICE,
    Unbroken,
    group_name,
    groups_leading_to,
    groups_of,
    lengthened,
    refuse_bits_left,
)


@pytest.mark.parametrize("vertices", [4, 5, 7, 8, 9, 16, 17, 1000, 2**25])
def test_groups_double_the_vertices_and_leave_none_out(vertices):
    groups = groups_of(vertices)
    assert [start for start, _ in groups] == [4 * 2**number for number in range(len(groups))]
    assert [end for _, end in groups[:-1]] == [start for start, _ in groups[1:]]
    assert (groups[-1][1] if groups else 4) == vertices


def test_the_groups_that_lead_to_a_level_are_the_fewest_that_reach_it():
    ends = [4, *(end for _, end in groups_of(2**25))]
    near = (end + step for end in ends for step in (-1, 0, 1))
    for vertices in (*range(4, 300), *(count for count in near if 4 <= count <= 2**25)):
        groups = groups_leading_to(vertices)
        assert ends[groups] >= vertices
        assert groups == 0 or ends[groups - 1] < vertices
        assert groups == len(groups_of(vertices))


def test_names_sort_as_the_groups_do():
    names = [group_name(number, DEVICE) for number in range(len(groups_of(2**25)))]
    assert names == sorted(names)
    assert names[0] == "device.00"


@pytest.mark.parametrize("shape", [(0, 3), (5, 3), (5,)])
def test_what_is_lengthened_keeps_its_rows_and_leaves_the_old_array_alone(shape):
    array = np.arange(np.prod(shape), dtype=np.int16).reshape(shape)
    longer = lengthened(array, 9)
    assert (longer.shape, longer.dtype) == ((9, *shape[1:]), array.dtype)
    np.testing.assert_array_equal(longer[: len(array)], array)
    longer[:] = -1
    assert (array >= 0).all()


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
    reader = reader_of(np.array(stream, np.uint8))
    for _ in range(read):
        read_bits(reader, 1)
    if right:
        refuse_bits_left(reader, "splits.03")
    else:
        with pytest.raises(HistoryFileError, match="bits over") as caught:
            refuse_bits_left(reader, "splits.03")
        assert caught.value.where == {"field": "splits.03"}


@pytest.mark.parametrize("kind", [HistoryFileError, MemoryError, KeyboardInterrupt])
def test_no_step_follows_one_that_failed(kind):
    unbroken, done, fault = Unbroken(), [], kind("at the second step")

    def step(number):
        with unbroken:
            if number == 2:
                raise fault
            done.append(number)

    step(0)
    step(1)
    for number in (2, 3, 4):
        with pytest.raises(kind) as caught:
            step(number)
        assert caught.value is fault
    assert done == [0, 1]
