"""The levels of queries: their choice, their error bounds, and how many are kept."""

import threading

import pytest

from gamutcore import Gamut
from gamutcore.errors import OptionError, TriangleCountError
from gamutcore.levels import LevelRequest


@pytest.fixture
def gamut(small_gamut):
    return Gamut.from_bytes(small_gamut.to_bytes())


def bound_of(gamut, **level):
    return gamut.nearest([(50, 0, 0)], **level).max_error


def test_a_count_has_its_bound_where_it_is_known(gamut):
    for row in gamut.description["levels"]:
        assert bound_of(gamut, triangles=row["triangles"]) == row["distance_bound"]
    count = gamut.mesh(max_error=1.0).triangles
    bound_of(gamut, triangles=count)
    assert bound_of(gamut, max_error=1.0) <= 1.0
    assert bound_of(gamut, triangles=gamut.history.triangles) == 0.0


def test_a_bound_that_needs_a_comparison_is_kept(gamut):
    search, history = gamut.search, gamut.history
    between = next(n for n in range(4, 400, 2) if search.find_error_bound(n) is None)
    before = search.nbytes
    bound = search.error_bound(history, between)
    assert search.find_error_bound(between) == bound > 0.0
    assert search.nbytes > before
    # it is no bound of finer levels, so a mesh does not state it
    assert gamut.mesh(between).max_error is None


def test_another_object_of_the_gamut_uses_what_a_search_has_found(gamut):
    found = gamut.search.find(gamut.history, LevelRequest(max_error=0.8))
    again = Gamut.from_bytes(gamut.to_bytes(), search=gamut.search, index_bytes=0)
    assert again.search.find_known(LevelRequest(max_error=0.8)) == found
    again.contains((50, 0, 0))
    assert again.levels.nbytes == 0


@pytest.mark.parametrize(
    ("request_", "field"),
    [
        ({"triangles": 100, "max_error": 0.0}, "triangles"),
        ({"triangles": 100, "max_mismatch": 0.5}, "triangles"),
        ({"max_error": -1.0}, "max_error"),
        ({"max_error": float("nan")}, "max_error"),
        ({"max_mismatch": True}, "max_mismatch"),
        ({"max_mismatch": "1"}, "max_mismatch"),
        ({"side": "above"}, "side"),
    ],
)
def test_requests_that_are_none(gamut, request_, field):
    for ask in (LevelRequest, gamut.mesh):
        with pytest.raises(OptionError) as caught:
            ask(**request_)
        assert caught.value.where["field"] == field
        assert caught.value.remedy


def test_a_count_without_a_level(gamut):
    for count in (3, gamut.history.triangles + 1):
        assert gamut.search.find_known(LevelRequest(count)) is None
        with pytest.raises(TriangleCountError):
            gamut.search.find(gamut.history, LevelRequest(count))


def test_a_kept_level_is_indexed_once(gamut):
    first = gamut.levels.level(20)
    assert gamut.levels.level(20) is first
    gamut.levels.capacity = 0
    gamut.levels.level(30)
    assert gamut.levels.nbytes == first.nbytes


def test_threads_share_the_cache(gamut):
    found = []
    threads = [
        threading.Thread(target=lambda n=n: found.append(gamut.levels.level(10 + n % 10 * 2)))
        for n in range(40)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    kept = {level.triangles: level.nbytes for level in found}
    assert gamut.levels.nbytes == sum(kept.values())
