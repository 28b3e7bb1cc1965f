"""Kernels of device values: collapses can be undone, and what is written is read back."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from gamutcore.history.bit_codes import LENGTH_CLASSES, bit_reader, stream_bytes
from gamutcore.history.device import (
    SplitEdges,
    SplitValues,
    collapse_values,
    first_value_contexts,
    level_values,
    read_values,
    write_values,
)

LARGEST = 5100


def columns(edges, channels):
    moves = int(edges.shifted_end[edges.corrected - 1]) if edges.corrected else 0
    counts = (*(len(edges.parent),) * 3, moves, moves)
    return SplitValues(*(np.empty((count, channels), np.int16) for count in counts))


@st.composite
def forests(draw):
    """Return values of a full boundary, edges, and corrected values of any possible history."""
    vertices = draw(st.integers(4, 60))
    channels = draw(st.integers(1, 5))
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    splits = vertices - 4
    parent = np.array([random.integers(0, slot) for slot in range(4, vertices)], np.int32)
    moved = [
        np.sort(random.choice(np.delete(np.arange(slot), parent[slot - 4]), random.integers(0, 4)))
        if random.random() < 0.3
        else []
        for slot in range(4, vertices)
    ]
    moved = [np.unique(slots).astype(np.int32) for slots in moved]
    corrected = draw(st.integers(0, splits))
    stored = [len(slots) if split < corrected else 0 for split, slots in enumerate(moved)]
    edges = SplitEdges(
        parent,
        random.choice([0.0, 1.0, 0.5, *random.random(5)], splits),
        random.integers(0, LENGTH_CLASSES, splits).astype(np.uint8),
        np.cumsum(stored).astype(np.int32),
        np.concatenate([*moved, np.empty(0, np.int32)]),
        corrected,
    )
    some = [0, LARGEST, *random.integers(0, LARGEST + 1, 6)]
    values = random.choice(some, (vertices, channels)).astype(np.int16)
    empty = columns(edges, channels)
    nearest = random.choice(some, (edges.corrected, channels)).astype(np.int16)
    empty.shifted_coarse[:] = random.choice(some, empty.shifted_coarse.shape)
    return values, edges, (nearest, empty.shifted_coarse)


def collapsed(values, edges, nearest):
    """Return the values of all splits, and those of the coarsest level in the first four rows."""
    splits, coarsest = columns(edges, values.shape[1]), values.copy()
    splits.shifted_coarse[:] = nearest[1]
    middle = 4 + len(edges.parent) // 2
    collapse_values(coarsest, edges, nearest[0], splits, middle, len(values))
    collapse_values(coarsest, edges, nearest[0], splits, 4, middle)
    return splits, coarsest


def levels_of(values, edges, nearest):
    """Yield the values of every level from the finest on, by the definition."""
    level = values.astype(np.int64)
    yield level
    for slot in range(len(values) - 1, 3, -1):
        split = slot - 4
        level = level.copy()
        parent = edges.parent[split]
        change = level[slot] - level[parent]
        level[parent] += np.floor(edges.fraction[split] * change + 0.5).astype(int)
        if split < edges.corrected:
            level[parent] = nearest[0][split]
            begin = edges.shifted_end[split - 1] if split else 0
            for index in range(begin, edges.shifted_end[split]):
                level[edges.shifted[index]] = nearest[1][index]
        level = level[:slot]
        yield level


class TestLevels:
    @given(forests())
    def test_every_level_is_the_one_before_with_an_edge_collapsed(self, forest):
        values, edges, nearest = forest
        splits, coarsest = collapsed(values, edges, nearest)
        for level in levels_of(values, edges, nearest):
            found = level_values(len(level), values, edges, splits)
            np.testing.assert_array_equal(found, level)
        np.testing.assert_array_equal(coarsest[:4], level)


class TestCode:
    @given(forests(), st.data())
    def test_values_are_read_back(self, forest, data):
        values, edges, nearest = forest
        vertices, channels = values.shape
        splits, coarsest = collapsed(values, edges, nearest)
        cut = data.draw(st.integers(4, vertices))
        writing, reading = first_value_contexts(channels), first_value_contexts(channels)
        read, found = np.empty_like(values), columns(edges, channels)
        read[:4] = coarsest[:4]
        for start, end in ((4, cut), (cut, vertices)):
            writer = write_values(writing, edges, LARGEST, splits, start, end)
            reader = bit_reader(stream_bytes(writer))
            faulty = read_values(reader, reading, edges, LARGEST, read, found, start, end)
            assert faulty == 0
            assert reader.position[0] == writer.position[0]
        np.testing.assert_array_equal(read, values)
        for one, other in zip(found, splits, strict=True):
            np.testing.assert_array_equal(one, other)
