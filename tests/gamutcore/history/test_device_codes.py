"""The kernels of device values: collapses that can be taken back, and a code that is."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gamutcore.history.bit_codes import reader_of, written
from gamutcore.history.device_codes import (
    LENGTHS,
    SplitValues,
    collapse_values,
    first_value_contexts,
    level_values,
    read_values,
    split_values,
    write_values,
)

LARGEST = 5100


def columns(vertices, channels):
    return SplitValues(*(np.empty((vertices - 4, channels), np.int16) for _ in range(3)))


@st.composite
def forests(draw):
    """Return values of a full boundary, parents, places and lengths as any history may have."""
    vertices = draw(st.integers(4, 60))
    channels = draw(st.integers(1, 5))
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    parent = np.array([random.integers(0, slot) for slot in range(4, vertices)], np.int32)
    place = random.choice([0.0, 1.0, 0.5, *random.random(5)], vertices - 4)
    length = random.integers(0, LENGTHS, vertices - 4).astype(np.uint8)
    values = random.choice([0, LARGEST, *random.integers(0, LARGEST + 1, 6)], (vertices, channels))
    return values.astype(np.int16), parent, place, length


def levels_of(values, parent, place):
    """Return the values of every level from the finest on, as the definition has it."""
    level = values.astype(np.int64)
    yield level
    for slot in range(len(values) - 1, 3, -1):
        level = level.copy()
        one, other = level[parent[slot - 4]], level[slot]
        level[parent[slot - 4]] = one + np.floor(place[slot - 4] * (other - one) + 0.5).astype(int)
        level = level[:slot]
        yield level


class TestLevels:
    @given(forests())
    def test_every_level_is_the_one_before_with_an_edge_collapsed(self, forest):
        values, parent, place, _ = forest
        splits, coarsest = columns(*values.shape), values.copy()
        collapse_values(coarsest, parent, place, splits)
        refined = np.empty_like(values)
        refined[:4] = coarsest[:4]
        for level in reversed(list(levels_of(values, parent, place))):
            count = len(level)
            if count > 4:
                split_values(refined, parent, splits, count - 1, count)
            np.testing.assert_array_equal(refined[:count], level)
            np.testing.assert_array_equal(level_values(count, values, parent, splits), level)

    @given(forests())
    def test_no_level_leaves_the_range_of_the_full_boundary(self, forest):
        values, parent, place, _ = forest
        for level in levels_of(values, parent, place):
            assert (level >= values.min(axis=0)).all()
            assert (level <= values.max(axis=0)).all()


class TestCode:
    @given(forests(), st.data())
    def test_is_read_back(self, forest, data):
        values, parent, place, length = forest
        vertices, channels = values.shape
        splits, coarsest = columns(*values.shape), values.copy()
        collapse_values(coarsest, parent, place, splits)
        cut = data.draw(st.integers(4, vertices))
        writing, reading = first_value_contexts(channels), first_value_contexts(channels)
        read, found = np.empty_like(values), columns(*values.shape)
        read[:4] = coarsest[:4]
        for start, end in ((4, cut), (cut, vertices)):
            writer = write_values(writing, length, LARGEST, splits, start, end)
            reader = reader_of(written(writer))
            faulty = read_values(
                reader, reading, parent, place, length, LARGEST, read, found, start, end
            )
            assert faulty == 0
            assert reader.place[0] == writer.place[0]
        np.testing.assert_array_equal(read, values)
        for one, other in zip(found, splits, strict=True):
            np.testing.assert_array_equal(one, other)

    @pytest.mark.parametrize("data", [b"", b"\0\0\0\0\0\0\0\0", b"\0\0\0\xff\xff\xff\xff\xff"])
    def test_what_is_no_value_is_told(self, data):
        """A stream that ends early, and one whose differences lead beyond full scale."""
        values = np.full((5, 2), 7, np.int16)
        faulty = read_values(
            reader_of(np.frombuffer(data, np.uint8)),
            first_value_contexts(2),
            np.zeros(1, np.int32),
            np.full(1, 0.5),
            np.zeros(1, np.uint8),
            LARGEST,
            values,
            columns(5, 2),
            4,
            5,
        )
        assert faulty == 4
