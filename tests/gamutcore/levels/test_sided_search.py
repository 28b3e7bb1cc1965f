"""Answers are on their side, keep their limits, and do not contradict each other."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gamutcore import Gamut
from gamutcore.boundary import modified_convex_hull
from gamutcore.decimation import decimate
from gamutcore.history import build_history
from gamutcore.levels import (
    NO_ERROR,
    BoundedLevel,
    LevelRequest,
    LevelSearch,
    radial_difference,
    sided_level,
)
from gamutcore.levels.sides import DENSE_UP_TO, sided_counts

SIDES = ("inside", "outside")
LIMITS = [(distance, None) for distance in np.geomspace(100.0, 0.05, 12)]
LIMITS += [(None, mismatch) for mismatch in np.geomspace(1.0, 0.001, 8)]
LIMITS += [(5.0, 0.02), (0.0, None), (None, 0.0)]


def search_of(history):
    return LevelSearch([{"triangles": history.triangles}])


@pytest.fixture(scope="module")
def history(fogra39):
    """Return the history of a press with fewer samples: levels of all sizes are searched often."""
    history = Gamut(fogra39, surface_samples=20_000).history
    assert history.triangles > 10 * DENSE_UP_TO
    return history


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.slow
def test_levels_keep_their_limits_and_looser_limits_have_no_more_triangles(history, side):
    search, full = search_of(history), history.full()
    requests = [LevelRequest(None, *limits, side) for limits in LIMITS]
    found = {request: search.find(history, request) for request in requests}
    for request, level in found.items():
        limits = request.limits
        assert level.bounds.within(limits)
        assert search.find_known(request) == level
        for other in found.values():
            # no smaller answer promises the same
            assert not (other.bounds.within(limits) and other.triangles < level.triangles)
    for triangles, bounds in set(found.values()) - {BoundedLevel(full.triangles, NO_ERROR)}:
        mesh = sided_level(history, triangles, side)
        error = radial_difference(full, mesh, history.centre)
        assert error.mismatch <= bounds.mismatch
        # both bounds of the distance are within 3 % of the largest distance
        distance = max(error.from_reference.maximum, error.to_reference.maximum)
        assert distance <= 1.03 * bounds.distance


@pytest.mark.parametrize("side", SIDES)
def test_the_curve_bounds_all_finer_levels(small_history, side):
    search = search_of(small_history)
    assert search.known_curve(side) is None
    curve = search.curve(small_history, side)
    assert search.known_curve(side) is curve
    assert [level.triangles for level in curve[:-1]] == sided_counts(small_history.triangles)
    assert curve[-1].triangles == small_history.triangles
    assert curve[-1].volume == pytest.approx(small_history.full().volume, rel=1e-12)
    for coarse, fine in itertools.pairwise(curve):
        assert coarse.mismatch_bound >= max(coarse.mismatch, fine.mismatch_bound)
        assert coarse.distance_bound >= max(coarse.to_full.maximum, fine.distance_bound)
        assert coarse.distance_bound >= coarse.from_full.maximum


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 10**6), st.integers(8, 60), st.floats(1e-3, 1.0), st.sampled_from(SIDES))
def test_limits_of_random_bodies_are_kept(random_cloud, seed, count, part, side):
    boundary = modified_convex_hull(random_cloud(seed, count), 0.5)
    history = build_history(decimate(boundary.mesh, boundary.centre, "volume"))
    request = LevelRequest(max_mismatch=part, side=side)
    level = search_of(history).find(history, request)
    assert level.bounds.within(request.limits)
    mesh = sided_level(history, level.triangles, side)
    lost = abs(mesh.volume - history.full().volume) / history.full().volume
    assert lost <= level.bounds.mismatch
