"""The levels of queries: their choice, their error bounds, and how many are kept."""

import threading

import pytest

from gamutcore.gamut_levels import GamutLevels


@pytest.fixture
def levels(small_gamut):
    return GamutLevels(small_gamut.history, small_gamut.description)


def test_a_count_has_its_bound_where_it_is_known(levels, small_gamut):
    for row in small_gamut.description["levels"]:
        assert levels.indexed(triangles=row["triangles"]).max_error == row["distance_bound"]
    count = levels.indexed(max_error=1.0).triangles
    by_count = GamutLevels(small_gamut.history, small_gamut.description)
    by_count.indexed(triangles=count)
    assert by_count.indexed(max_error=1.0).max_error <= 1.0
    assert levels.indexed(triangles=small_gamut.history.triangles).max_error == 0.0


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
