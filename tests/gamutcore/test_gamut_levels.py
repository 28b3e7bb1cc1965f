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
