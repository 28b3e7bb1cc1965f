"""The chosen level keeps its limits by other measures, and no smaller level promises them."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.booleans import mismatch
from gamutcore.boundary import modified_convex_hull
from gamutcore.decimation import COSTS, decimate
from gamutcore.history import build_history
from gamutcore.levels import (
    NO_ERROR,
    BoundedLevel,
    LevelRequest,
    LevelSearch,
    curve_counts,
    error_bounds,
    error_curve,
)
from gamutcore.levels.level_search import search_counts


def within(max_error=None, max_mismatch=None):
    return LevelRequest(None, max_error, max_mismatch)


LIMITS = [within(10.0**-power) for power in np.linspace(-1.5, 1.5, 19)] + [within(1e-9)]
LIMITS += [within(None, 10.0**-power) for power in np.linspace(0.3, 3.5, 19)]
LIMITS += [within(3.0, 0.05), within(1.0, 0.05), within(3.0, 0.01), within(10.0, 0.002)]


def search_of(history):
    counts = curve_counts(history.triangles)
    return LevelSearch([level.to_mapping() for level in error_curve(history, counts)])


@pytest.fixture(scope="module")
def small_search(small_history):
    return search_of(small_history)


@pytest.mark.parametrize("full", [4, 6, 34, 500, 9000, 133_174, 2_572_362])
def test_counts_are_close_together(full):
    counts = search_counts(full)
    assert counts == sorted(set(counts))
    assert all(count % 2 == 0 and 4 <= count < full for count in counts)
    for count, finer in pairwise([*counts, full]):
        if finer <= 2048:
            assert finer == count + 2
        elif finer <= 65_536:
            assert finer <= 1.1 * count + 2
        assert finer <= 2.1 * count


@pytest.mark.parametrize("limits", LIMITS)
@pytest.mark.slow
def test_the_chosen_level_keeps_the_limits(
    small_history, small_search, limits, distances_to, sampled
):
    chosen = small_search.find(small_history, limits)
    assert chosen.bounds.within(limits.limits)
    full, level = small_history.full(), small_history.level(chosen.triangles)
    assert mismatch(full, level) <= chosen.bounds.mismatch + 1e-9
    there = distances_to(np.vstack([full.vertices, sampled(full, 200)]), level).max()
    back = distances_to(np.vstack([level.vertices, sampled(level, 200)]), full).max()
    assert max(there, back) <= chosen.bounds.distance + 1e-9


@settings(max_examples=12)
@given(
    st.integers(0, 10**6),
    st.integers(8, 150),
    st.sampled_from(sorted(COSTS)),
    st.sampled_from([0.1, 0.5, 1.0]),
    st.lists(st.tuples(st.floats(-2, 1.5), st.floats(-4, 0)), min_size=5, max_size=5),
)
@pytest.mark.slow
def test_limits_are_kept_by_anything(random_cloud, distances_to, seed, count, cost, gamma, powers):
    boundary = modified_convex_hull(random_cloud(seed, count), gamma)
    history = build_history(decimate(boundary.mesh, boundary.centre, cost))
    search = search_of(history)
    full = history.full()
    for one, other in powers:
        for limits in (within(10**one), within(None, 10**other), within(10**one, 10**other)):
            level = history.level(search.find(history, limits).triangles)
            distance, part = limits.limits
            assert mismatch(full, level) <= part + 1e-9
            assert distances_to(full.vertices, level).max() <= distance + 1e-9
            assert distances_to(level.vertices, full).max() <= distance + 1e-9


class TestOfTheEnds:
    def test_only_the_full_boundary_has_no_error(self, small_history, small_search):
        full = BoundedLevel(small_history.triangles, NO_ERROR)
        for limits in (within(0.0), within(None, 0.0), within(1.0, 0.0), within(0.0, 0.0)):
            assert small_search.find_known(limits) == full
        for limits in (within(1e-300), within(None, 1e-300)):
            assert small_search.find(small_history, limits) == full

    def test_four_triangles_keep_large_limits(self, small_search):
        for limits in (within(1e6), within(None, 10.0), within(1e6, 10.0)):
            chosen = small_search.find_known(limits)
            assert chosen.triangles == 4
            assert chosen.bounds.within(limits.limits)

    def test_a_tetrahedron_has_no_other_level(self):
        rows = [{"triangles": 4, "distance_bound": 0.0, "mismatch_bound": 0.0}]
        for limits in (LevelRequest(4), within(0.0), within(1e-9)):
            assert LevelSearch(rows).find_known(limits) == BoundedLevel(4, NO_ERROR)


def largest_distance(mesh, other, distances_to):
    """Largest distance of a point of `mesh` from `other`, found to 0.5 % by branch and bound.

    The distance changes by no more than the point moves. So the distance of a triangle's centroid
    plus its circumscribed radius is an upper bound for the triangle.
    """
    triangles, largest = mesh.vertices.astype(np.float64)[mesh.faces], 0.0
    while len(triangles):
        centroids = triangles.mean(axis=1)
        distances = distances_to(centroids, other)
        largest = max(largest, distances.max())
        reach = np.linalg.norm(triangles - centroids[:, np.newaxis], axis=2).max(axis=1)
        a, b, c = triangles[distances + reach > 1.005 * largest].transpose(1, 0, 2)
        ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
        parts = ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))
        triangles = np.concatenate([np.stack(corners, axis=1) for corners in parts])
    return largest


@pytest.mark.slow
def test_bounds_are_tight(small_history, small_search, distances_to):
    full, answers = small_history.full(), {}
    for limits in LIMITS:
        triangles, bounds = small_search.find(small_history, limits)
        answers[triangles] = bounds
    # bounds of the curve are less tight
    for triangles in sorted(answers.keys() - set(curve_counts(full.triangles)))[:4]:
        bounds = answers[triangles]
        level = small_history.level(triangles)
        assert mismatch(full, level) <= bounds.mismatch * (1 + 2e-5)
        # 1.005 times the largest distance that was found is a bound, so 1.03 leaves little slack.
        furthest = max(
            largest_distance(full, level, distances_to), largest_distance(level, full, distances_to)
        )
        assert furthest <= bounds.distance <= 1.03 * furthest


@pytest.mark.parametrize("cost", sorted(COSTS))
def test_no_smaller_level_keeps_the_limit(random_cloud, cost):
    """Evidence rejects what a comparison of every level rejects."""
    boundary = modified_convex_hull(random_cloud(11, 150), 0.3)
    history = build_history(decimate(boundary.mesh, boundary.centre, cost))
    search = search_of(history)
    every = error_bounds(history, range(4, history.triangles, 2))
    full = BoundedLevel(history.triangles, NO_ERROR)
    # also limits that a level only just keeps, or only just does not
    attained = [level.bounds.distance for level in every[:: len(every) // 10]]
    for limit in [*np.geomspace(0.5, 40.0, 30).tolist(), *attained, *(0.9999 * np.array(attained))]:
        keeping = (level for level in every if level.bounds.distance <= limit)
        first, found = next(keeping, full), search.find(history, within(float(limit)))
        assert found.triangles <= first.triangles
        if found.triangles < first.triangles:  # its bound in the error curve is smaller
            assert found.triangles in curve_counts(history.triangles)


@settings(max_examples=5)
@given(
    st.integers(0, 10**6),
    st.integers(20, 80),
    st.sampled_from(sorted(COSTS)),
    st.lists(st.tuples(st.floats(-1.5, 1.5), st.floats(-3.5, 0)), min_size=6, max_size=6),
)
@pytest.mark.slow
def test_no_answer_promises_what_a_smaller_answer_promises(random_cloud, seed, count, cost, powers):
    boundary = modified_convex_hull(random_cloud(seed, count), 0.3)
    history = build_history(decimate(boundary.mesh, boundary.centre, cost))
    search = search_of(history)
    limits = [within(10**one, 10**other) for one, other in powers]
    limits += [within(10**one) for one, _ in powers]
    limits += [within(None, 10**other) for _, other in powers]
    answers = [(each.limits, search.find(history, each)) for each in limits]
    for limit, answer in answers:
        assert answer.bounds.within(limit)
        for other_limit, other in answers:
            if limit.within(other_limit):
                assert answer.triangles >= other.triangles
            if other.bounds.within(limit):
                assert answer.triangles <= other.triangles


@pytest.mark.slow
def test_smallest_levels_of_fogra39(fogra39_gamut):
    history = fogra39_gamut.history
    search = LevelSearch(fogra39_gamut.description["levels"])
    before = 0
    for limit in np.geomspace(3.0, 0.15, 12):
        triangles, bounds = search.find(history, within(float(limit)))
        assert bounds.distance <= limit
        assert triangles >= before
        before = triangles
