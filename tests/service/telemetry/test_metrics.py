"""Counting: every value once, whatever it is, and no series that a client makes up."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.telemetry.metrics import BuildFigures, Distribution, RequestFigures


@given(values=st.lists(st.floats(0, 1e6)), bounds=st.sets(st.floats(0.001, 1e3), min_size=1))
def test_a_distribution_counts_up_to_each_bound(values, bounds):
    distribution = Distribution(sorted(bounds))
    for value in values:
        distribution.add(value)
    assert distribution.cumulative() == [
        (bound, sum(value <= bound for value in values)) for bound in [*sorted(bounds), math.inf]
    ]
    assert distribution.sum == pytest.approx(sum(values))


def test_requests_are_counted_by_method_route_and_status():
    figures = RequestFigures()
    for method, status in [("GET", 200), ("GET", 200), ("GET", 404), ("HEAD", 200)]:
        figures.count_answer(method, "/v1/gamuts", status, 0.002)
    assert figures.counts == {
        ("GET", "/v1/gamuts", 200): 2,
        ("GET", "/v1/gamuts", 404): 1,
        ("HEAD", "/v1/gamuts", 200): 1,
    }
    assert figures.seconds["/v1/gamuts"].cumulative()[-1] == (math.inf, 4)


def test_made_up_methods_are_one_series():
    figures = RequestFigures()
    for number in range(50):
        figures.count_answer(f"METHOD{number}", "unmatched", 405, 0.001)
    assert figures.counts == {("other", "unmatched", 405): 50}


def test_builds_are_counted_by_outcome_and_timed_by_stage():
    figures = BuildFigures()
    figures.count_build("succeeded", {"boundary": 1.0, "decimation": 0.5, "total": 1.75})
    figures.count_build("succeeded", {"boundary": 3.0, "decimation": 0.5, "total": 3.75})
    figures.count_build("build-crashed", {})
    assert figures.outcomes == {"succeeded": 2, "build-crashed": 1}
    assert figures.stages["boundary"].sum == 4.0
    assert set(figures.stages) == {"boundary", "decimation"}
    assert figures.seconds.sum == 5.5
    # a build that never told how long it took is no build of no time
    assert figures.seconds.cumulative()[-1] == (math.inf, 2)
