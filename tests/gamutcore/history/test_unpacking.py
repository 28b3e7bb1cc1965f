"""Histories from files unpack on request and return the same levels as complete histories."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gamutcore.errors import HistoryFileError
from gamutcore.history import history_bytes, history_from_bytes
from gamutcore.history.splits import group_ranges


def opened(data):
    history, _ = history_from_bytes(data)
    return history


def groups_unpacked(history):
    """Return the number of unpacked groups, according to `is_unpacked` of every group."""
    ends = [2 * end - 4 for _, end in group_ranges(history.vertices)]
    known = [history.is_unpacked(end) for end in ends]
    assert known == sorted(known, reverse=True)
    return sum(known)


@pytest.fixture(scope="module")
def large(fogra39_gamut):
    """Return a history with device values, and its file."""
    return fogra39_gamut.history, history_bytes(fogra39_gamut.history)


class TestUnpacking:
    def test_groups_are_unpacked_as_far_as_a_level_needs(self, large):
        built, data = large
        history = opened(data)
        sizes = [history.nbytes]
        for number, (start, end) in enumerate(group_ranges(built.vertices)):
            assert not history.is_unpacked(2 * start - 2)
            history.unpack(2 * start - 2)
            assert groups_unpacked(history) == number + 1
            assert history.is_unpacked(2 * end - 4)
            sizes.append(history.nbytes)
        assert sizes[:-1] == sorted(sizes[:-1])
        assert history.nbytes == opened_whole(data).nbytes
        # a level with a hundredth of the triangles needs a small part of the memory
        coarse = opened(data)
        coarse.unpack(built.triangles // 100)
        assert coarse.nbytes - len(data) < history.nbytes / 20

    @settings(max_examples=60, deadline=None)
    @given(st.data())
    @pytest.mark.slow
    def test_levels_are_the_same_in_any_order(self, file, shifting_history, data):
        for built in (opened(file), shifting_history):
            history = opened(history_bytes(built))
            counts = st.lists(st.integers(4, built.triangles), min_size=1, max_size=6)
            for count in data.draw(counts):
                assert history.level(count) == built.level(count)

    @pytest.mark.slow
    def test_several_threads_get_the_same(self, large):
        built, data = large
        counts = np.geomspace(4, built.triangles, 24).astype(int).tolist()
        expected = {count: (built.level(count), built.device_values(count)) for count in counts}
        for seed in range(3):
            history = opened(data)
            order = np.random.default_rng(seed).permutation(counts * 4).tolist()
            with ThreadPoolExecutor(8) as threads:
                found = threads.map(lambda n, h=history: (h.level(n), h.device_values(n)), order)
                for count, (level, values) in zip(order, found, strict=True):
                    assert level == expected[count][0]
                    assert values == expected[count][1]
            for array, built_array in zip(history.splits, built.splits, strict=True):
                np.testing.assert_array_equal(array, built_array)


class TestDamage:
    def test_damage_leaves_coarser_levels(self, small_history, damaged):
        data, group = damaged
        history = opened(data)
        good = 2 * group_ranges(history.vertices)[group][0] - 4
        for _ in range(2):
            with pytest.raises(HistoryFileError) as caught:
                history.full()
            assert caught.value.where["field"] == f"groups.{group:02d}"
            assert history.level(good) == small_history.level(good)
            with pytest.raises(HistoryFileError):
                _ = history.splits
            with pytest.raises(HistoryFileError):
                history.level(good + 2)
            assert groups_unpacked(history) == group


@pytest.fixture
def damaged(file, layout):
    """Return a file with wrong last bytes in one group, and the number of that group."""
    group = 3
    data = bytearray(file)
    end = layout.group_end(file, group)
    for place in range(end - 8, end):
        data[place] ^= 255
    return bytes(data), group


def opened_whole(data):
    history = opened(data)
    history.unpack()
    return history
