"""The levels of queries: their choice, their error bounds, and how many are kept."""

import threading

import pytest

from gamutcore.errors import OptionError, TriangleCountError
from gamutcore.levels import GamutLevels


@pytest.fixture
def levels(small_gamut):
    return GamutLevels(small_gamut.history, small_gamut.description)


def test_a_level_of_a_limit_keeps_it_and_says_so(levels):
    for limit in (0.5, 1.0, 3.0):
        level = levels.indexed(max_error=limit)
        assert level.max_error <= limit
    assert levels.indexed(max_error=0.0).triangles == levels.indexed(max_error=0).triangles


def test_a_count_has_its_bound_where_it_is_known(levels, small_gamut):
    for row in small_gamut.description["levels"]:
        assert levels.indexed(triangles=row["triangles"]).max_error == row["distance_bound"]
    count = levels.indexed(max_error=1.0).triangles
    by_count = GamutLevels(small_gamut.history, small_gamut.description)
    by_count.indexed(triangles=count)
    assert by_count.indexed(max_error=1.0).max_error <= 1.0
    assert levels.indexed(triangles=small_gamut.history.triangles).max_error == 0.0


def test_limits_and_counts_that_are_none(levels):
    for limit in (-1.0, float("nan"), "0.5", True):
        with pytest.raises(OptionError):
            levels.indexed(max_error=limit)
    with pytest.raises(TriangleCountError):
        levels.indexed(triangles=2)


def test_a_kept_level_is_the_same_object(levels):
    first = levels.indexed(triangles=20)
    assert levels.indexed(triangles=21) is first
    levels.capacity = 0
    levels.indexed(triangles=30)
    assert levels.nbytes == first.nbytes


def test_threads_share_the_cache(levels):
    found = []
    threads = [
        threading.Thread(target=lambda n=n: found.append(levels.indexed(triangles=10 + n % 20)))
        for n in range(40)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    kept = {level.triangles: level.nbytes for level in found}
    assert levels.nbytes == sum(kept.values())
