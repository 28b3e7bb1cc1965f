"""The chosen level keeps its limits by other measures, and hardly a smaller one does."""

import itertools
from math import inf, isqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gamutcore.boundary import modified_convex_hull
from gamutcore.decimation import COSTS, decimate
from gamutcore.history import build_history
from gamutcore.metric import level_search, mismatch, radial_difference
from gamutcore.metric.error_curve import curve_counts, error_curve
from gamutcore.metric.level_search import NO_ERROR, BoundedLevel, Bounds, FullBoundary, LevelSearch

SLACK = 1.03
"""How much larger than an attained distance a bound of distance may be."""


def described(history):
    curve = error_curve(history, curve_counts(history.triangles))
    return [level.to_mapping() for level in curve]


@pytest.fixture(scope="module")
def small_choice(small_history):
    """Of all that is asked below: what is remembered must not change an answer."""
    return LevelSearch(small_history.triangles, described(small_history))


@pytest.fixture(scope="module")
def small_errors(small_history):
    """Of all levels: exact mismatch, and bound of the distance, by `radial_difference`."""
    full, errors = small_history.full(), {}
    for count in range(4, small_history.triangles, 2):
        level = small_history.level(count)
        found = radial_difference(full, level, small_history.centre)
        furthest = max(found.from_reference.maximum, found.to_reference.maximum)
        errors[count] = Bounds(furthest, found.mismatch)
    return errors


LIMITS = [*(Bounds(10.0**-power) for power in np.linspace(-1.5, 1.5, 19)), Bounds(1e-9)]
LIMITS += [Bounds(inf, 10.0**-power) for power in np.linspace(0.3, 3.5, 19)]
LIMITS += [Bounds(3.0, 0.05), Bounds(1.0, 0.05), Bounds(3.0, 0.01), Bounds(10.0, 0.002)]


class TestOfEachLevel:
    """Of some hundred triangles, of which all levels can be looked at."""

    @pytest.mark.parametrize("limits", LIMITS)
    @pytest.mark.slow
    def test_what_is_chosen_keeps_the_limits(
        self, small_history, small_choice, limits, distances_to, sampled
    ):
        chosen = small_choice.find(small_history, limits)
        assert chosen.bounds.within(limits)
        full, level = small_history.full(), small_history.level(chosen.triangles)
        assert mismatch(full, level) <= chosen.bounds.mismatch + 1e-9
        there = distances_to(np.vstack([full.vertices, sampled(full, 200)]), level).max()
        back = distances_to(np.vstack([level.vertices, sampled(level, 200)]), full).max()
        assert max(there, back) <= chosen.bounds.distance + 1e-9

    @pytest.mark.parametrize("limits", LIMITS)
    def test_one_vertex_less_does_not(self, small_history, small_choice, small_errors, limits):
        chosen = small_choice.find(small_history, limits).triangles
        if chosen > 4:
            less = small_errors[chosen - 2]
            assert less.distance * SLACK > limits.distance or less.mismatch > limits.mismatch * 0.99

    @pytest.mark.parametrize("limits", LIMITS)
    def test_it_is_the_smallest_where_finer_levels_are_closer(
        self, small_history, small_choice, small_errors, limits
    ):
        """Errors do not fall with every vertex: a smaller one may keep limits by chance."""
        kept = [count for count, bounds in small_errors.items() if bounds.within(limits)]
        loosely = Bounds(limits.distance * SLACK, limits.mismatch * 1.001)
        failed = [count for count, bounds in small_errors.items() if not bounds.within(loosely)]
        smallest = min(kept, default=small_history.triangles)
        chosen = small_choice.find(small_history, limits).triangles
        if max(failed, default=2) < smallest:
            assert max(failed, default=2) < chosen <= smallest
        else:
            assert chosen <= max(failed) + 2

    def test_most_limits_are_such(self, small_errors):
        """Else the test before this one would say little."""
        plain = 0
        for limits in LIMITS:
            kept = [bounds.within(limits) for bounds in small_errors.values()]
            plain += kept == sorted(kept)
        assert plain > len(LIMITS) / 2


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
    choice = LevelSearch(history.triangles, described(history))
    full = history.full()
    for one, other in powers:
        for limits in (Bounds(10**one), Bounds(inf, 10**other), Bounds(10**one, 10**other)):
            chosen = choice.find(history, limits)
            level = history.level(chosen.triangles)
            assert mismatch(full, level) <= limits.mismatch + 1e-9
            assert distances_to(full.vertices, level).max() <= limits.distance + 1e-9
            assert distances_to(level.vertices, full).max() <= limits.distance + 1e-9


class TestOfTheEnds:
    def test_of_zero_only_the_full_boundary_is_left(self, small_history):
        choice = LevelSearch(small_history.triangles, described(small_history))
        full = BoundedLevel(small_history.triangles, NO_ERROR)
        for limits in (Bounds(0.0), Bounds(inf, 0.0), Bounds(1.0, 0.0), Bounds(0.0, 0.0)):
            assert choice.find_known(limits) == full
        for limits in (Bounds(1e-300), Bounds(inf, 1e-300)):
            assert choice.find(small_history, limits) == full

    def test_of_large_ones_four_triangles_are_enough(self, small_history):
        choice = LevelSearch(small_history.triangles, described(small_history))
        for limits in (Bounds(), Bounds(1e6), Bounds(1e6, 10.0)):
            chosen = choice.find_known(limits)
            assert chosen.triangles == 4
            assert chosen.bounds.within(limits)

    @pytest.mark.parametrize("strange", [[], [{"triangles": 50, "volume": 1.0}]])
    def test_without_a_curve_every_level_is_compared(self, small_history, small_errors, strange):
        choice = LevelSearch(small_history.triangles, strange)
        for limits in LIMITS[::3]:
            chosen = choice.find(small_history, limits)
            assert chosen.bounds.within(limits)
            if chosen.triangles < small_history.triangles:
                assert small_errors[chosen.triangles].mismatch <= limits.mismatch * (1 + 1e-9)

    @pytest.mark.parametrize("count", [-2, 0, 2, 5, 10**9])
    def test_levels_that_are_not_there_are_never_chosen(self, small_history, count):
        strange = {"triangles": count, "distance_bound": 0.0, "mismatch_bound": 0.0}
        choice = LevelSearch(small_history.triangles, [strange, *described(small_history)])
        sound = LevelSearch(small_history.triangles, described(small_history))
        for limits in LIMITS[::5]:
            chosen = choice.find(small_history, limits)
            assert chosen == sound.find(small_history, limits)

    def test_four_triangles_are_all_that_there_are(self):
        choice = LevelSearch(4, [{"triangles": 4, "distance_bound": 0.0, "mismatch_bound": 0.0}])
        for limits in (Bounds(), Bounds(0.0), Bounds(1e-9)):
            assert choice.find_known(limits) == BoundedLevel(4, NO_ERROR)


def test_what_is_known_is_what_was_found(small_history):
    choice = LevelSearch(small_history.triangles, described(small_history))
    for limits in LIMITS:
        known = choice.find_known(limits)
        found = choice.find(small_history, limits)
        assert known in {None, found}
        assert choice.find_known(limits) == found
    assert choice.nbytes < 300 * small_history.triangles


def test_answers_do_not_depend_on_what_was_asked_before(small_history, small_choice):
    levels = described(small_history)
    for limits in LIMITS[::-2]:
        alone = LevelSearch(small_history.triangles, levels).find(small_history, limits)
        assert alone == small_choice.find(small_history, limits)


@given(
    st.lists(st.tuples(st.floats(-3, 3), st.floats(-6, 1)), min_size=2, max_size=2).map(sorted),
    st.sampled_from(["distance", "mismatch", "both"]),
)
def test_less_error_never_has_fewer_triangles(small_history, small_choice, powers, kind):
    (low, one), (high, other) = powers
    tight = Bounds(10**low, 10 ** min(one, other))
    loose = Bounds(10**high, 10 ** max(one, other))
    if kind == "distance":
        tight, loose = tight._replace(mismatch=inf), loose._replace(mismatch=inf)
    elif kind == "mismatch":
        tight, loose = tight._replace(distance=inf), loose._replace(distance=inf)
    chosen = [small_choice.find(small_history, limits).triangles for limits in (tight, loose)]
    assert chosen[0] >= chosen[1]


@pytest.fixture
def made_up(monkeypatch):
    """Errors that go up and down with the count, and what was compared; no history is needed."""

    def make(seed, wildness):
        compared = []

        def error(count):
            random = np.random.default_rng([seed, count]).normal(size=2)
            return Bounds(*(np.exp(wildness * random) * (1e3 / count, 1e2 / count**2)).tolist())

        class MadeUp:
            def __init__(self, _history):
                pass

            def bounds(self, count):
                compared.append(count)
                return error(count)

        monkeypatch.setattr(level_search, "FullBoundary", MadeUp)
        return error, compared

    return make


def described_of(error, full, excess):
    """A curve of these errors: bounds that hold for finer counts too, and are too large by some."""
    levels, so_far = [], Bounds(0.0, 0.0)
    for count in reversed(curve_counts(full)[:-1]):
        found = error(count)
        so_far = Bounds(
            max(so_far.distance, excess * found.distance),
            max(so_far.mismatch, excess * found.mismatch),
        )
        levels.append(
            {"triangles": count, "distance_bound": so_far[0], "mismatch_bound": so_far[1]}
        )
    return levels[::-1]


@pytest.mark.parametrize("full", [400, 20_000, 175_312, 2_500_000])
@pytest.mark.parametrize("wildness", [0.0, 0.3, 1.5])
class TestOfMadeUpErrors:
    """Errors that fall with the count, nearly so, and hardly."""

    def limits(self, full):
        distances = [1e3 / full * 10**power for power in np.linspace(-0.5, 6, 40)]
        mismatches = [1e2 / full**2 * 10**power for power in np.linspace(-0.5, 11, 40)]
        alone = [*map(Bounds, distances), *(Bounds(inf, value) for value in mismatches)]
        pairs = itertools.product(distances[::6], mismatches[::6])
        return [*alone, *(Bounds(*pair) for pair in pairs)]

    def test_limits_are_kept_and_less_error_never_has_fewer_triangles(
        self, made_up, full, wildness
    ):
        error, _ = made_up(1, wildness)
        choice = LevelSearch(full, described_of(error, full, 1.3))
        chosen = {limits: choice.find(None, limits) for limits in self.limits(full)}
        for limits, level in chosen.items():
            assert level.bounds.within(limits)
            assert level.triangles == full or error(level.triangles).within(limits)
        for (tight, one), (loose, other) in itertools.permutations(chosen.items(), 2):
            if tight.within(loose):
                assert one.triangles >= other.triangles

    def test_hardly_fewer_triangles_would_do(self, made_up, full, wildness):
        """A level within 1 % fails, but for the finest ones of so many that work is limited."""
        error, _ = made_up(2, wildness)
        choice = LevelSearch(full, described_of(error, full, 1.3))
        for limits in self.limits(full):
            chosen = choice.find(None, limits).triangles
            fewest = min(0.99 * chosen, chosen - 2)
            if chosen > 32 and chosen < full / 16:
                least = int(fewest) // 2 * 2
                tried = [
                    count for count in range(least, chosen, 2) if not error(count).within(limits)
                ]
                assert tried

    def test_work_is_limited(self, made_up, full, wildness):
        """By the model 57 ns for each triangle: 0.8 s of 175,312 triangles, 4 of 2.5 million."""
        error, compared = made_up(3, wildness)
        levels = described_of(error, full, 1.3)
        for limits in self.limits(full):
            compared.clear()
            LevelSearch(full, levels).find(None, limits)
            work = sum(full + 10 * isqrt(full * count) for count in compared)
            assert 57e-9 * work < 0.8 + 1.3e-6 * full
            assert len(compared) == len(set(compared)) < 20


@pytest.mark.parametrize("full", [300, 2500, 40_000])
def test_levels_finer_than_all_of_the_curve_are_tried_too(monkeypatch, full):
    """Those of some counts beyond it keep a limit, of which bisection could pass over all."""
    finest = max(curve_counts(full)[:-1])
    start = finest + (min(full, 4000) - finest) // 3
    good = range(start, int(1.25 * start))

    class MadeUp:
        def __init__(self, _history):
            pass

        def bounds(self, count):
            return Bounds(1.0, 1.0) if count in good else Bounds(9.0, 9.0)

    monkeypatch.setattr(level_search, "FullBoundary", MadeUp)
    levels = described_of(lambda _: Bounds(9.0, 9.0), full, 1.0)
    assert LevelSearch(full, levels).find(None, Bounds(2.0)).triangles in good


@pytest.mark.parametrize("limits", [Bounds(inf, 1e-8), Bounds(inf, 1e-11), Bounds(1e-6)])
def test_a_finer_level_with_some_error_does_not_hide_a_coarser_one(monkeypatch, limits):
    """Levels from 12 triangles on are exact, as of a cube, but a few between those of the curve."""
    full, coarsest, rounded = 300, 12, range(152, 180)
    assert not set(rounded) & set(curve_counts(full))

    def error(count):
        if count < coarsest:
            return Bounds(10.0, 1.0)
        return Bounds(1e-5, 1e-7) if count in rounded else Bounds(0.0, 0.0)

    class MadeUp:
        def __init__(self, _history):
            pass

        def bounds(self, count):
            return error(count)

    monkeypatch.setattr(level_search, "FullBoundary", MadeUp)
    levels = described_of(error, full, 1.0)
    assert LevelSearch(full, levels).find(None, limits).triangles == coarsest


@pytest.mark.parametrize("cost", sorted(COSTS))
@pytest.mark.parametrize("thickness", [0.3, 3.0])
@pytest.mark.slow
def test_of_flat_bodies_bounds_are_tight_too(cost, thickness, distances_to, sampled):
    """20 and 200 times as wide as high: with few halvings bounds were ten times too large.

    Where descent to the nearest face ends on the rim, they are still half as much again.
    """
    points = np.random.default_rng(3).normal(size=(400, 3))
    points *= (thickness, 60, 60) / np.linalg.norm(points, axis=1)[:, None]
    boundary = modified_convex_hull(points + np.array([50.0, 0.0, 0.0]))
    history = build_history(decimate(boundary.mesh, boundary.centre, cost))
    full, whole = history.full(), FullBoundary(history)
    for count in (40, 100, 160):
        level = history.level(count)
        there = distances_to(np.vstack([full.vertices, sampled(full, 1500)]), level).max()
        back = distances_to(np.vstack([level.vertices, sampled(level, 1500)]), full).max()
        assert whole.bounds(count).distance <= 1.6 * max(there, back)


@pytest.fixture(scope="module")
def fogra39_choice(fogra39_gamut):
    levels = fogra39_gamut.description["levels"]
    return LevelSearch(fogra39_gamut.history.triangles, levels)


class TestOfFogra39:
    @pytest.mark.parametrize(
        "limits",
        [Bounds(0.5), Bounds(0.03), Bounds(inf, 1e-3), Bounds(inf, 3e-5), Bounds(0.5, 1e-3)],
    )
    @pytest.mark.slow
    def test_the_level_keeps_its_limits_and_one_a_little_coarser_does_not(
        self, fogra39_gamut, fogra39_choice, limits, distances_to, sampled
    ):
        history = fogra39_gamut.history
        chosen = fogra39_choice.find(history, limits)
        full = history.full()
        level = history.level(chosen.triangles)
        direct = radial_difference(full, level, history.centre)
        assert (
            direct.mismatch <= chosen.bounds.mismatch * (1 + 1e-9) <= limits.mismatch * (1 + 1e-9)
        )
        points = sampled(full, 150)
        assert distances_to(points, level).max() <= chosen.bounds.distance <= limits.distance
        coarser = [
            count
            for count, bounds in fogra39_choice._compared.items()
            if count < chosen.triangles and not bounds.within(limits)
        ]
        assert max(coarser) >= min(0.99 * chosen.triangles, chosen.triangles - 2)
        direct = radial_difference(full, history.level(max(coarser)), history.centre)
        furthest = max(direct.from_reference.maximum, direct.to_reference.maximum)
        assert furthest * SLACK > limits.distance or direct.mismatch > limits.mismatch * 0.99999

    def test_far_fewer_triangles_come_than_by_the_curve_alone(self, fogra39_gamut, fogra39_choice):
        """Where its counts are four to sixteen times one another."""
        levels = fogra39_gamut.description["levels"]
        for bound, kind in (("distance_bound", "distance"), ("mismatch_bound", "mismatch")):
            limit = levels[-2][bound] * 0.9
            limits = Bounds()._replace(**{kind: limit})
            assert min(each["triangles"] for each in levels if each[bound] <= limit) == (
                fogra39_gamut.history.triangles
            )
            assert fogra39_choice.find(fogra39_gamut.history, limits).triangles < (
                fogra39_gamut.history.triangles / 4
            )

    @pytest.mark.slow
    def test_hardly_any_limit_is_kept_by_a_much_smaller_level(self, fogra39_gamut, fogra39_choice):
        """Of all levels with few triangles, each compared by itself."""
        history, full = fogra39_gamut.history, FullBoundary(fogra39_gamut.history)
        errors = {count: full.bounds(count) for count in range(4, 501, 2)}
        excess = []
        for limits in (
            *map(Bounds, np.geomspace(0.4, 20.0, 60).tolist()),
            *(Bounds(inf, mismatched) for mismatched in np.geomspace(2e-3, 0.5, 60).tolist()),
        ):
            smallest = min(count for count, bounds in errors.items() if bounds.within(limits))
            excess.append(fogra39_choice.find(history, limits).triangles / smallest)
        assert np.mean(excess) < 1.01
        assert max(excess) < 2.0
        assert sum(one > 1.01 for one in excess) <= 6


class TestFullBoundary:
    def test_mismatch_is_that_of_boolean_operations(self, small_history):
        full = FullBoundary(small_history)
        for count in (4, 20, 100, small_history.triangles):
            exact = mismatch(small_history.full(), small_history.level(count))
            assert full.bounds(count).mismatch == pytest.approx(exact, rel=1e-5, abs=1e-12)

    def test_distance_is_one_that_holds_and_is_tight(
        self, small_history, small_errors, distances_to
    ):
        full, whole = FullBoundary(small_history), small_history.full()
        for count in (4, 20, 100, 150):
            bound = full.bounds(count).distance
            level = small_history.level(count)
            there = distances_to(whole.vertices, level).max()
            back = distances_to(level.vertices, whole).max()
            assert max(there, back) <= bound + 1e-9
            assert bound == pytest.approx(small_errors[count].distance, rel=SLACK - 1)

    def test_bounds_have_as_many_digits_as_a_description(self, small_history):
        for value in FullBoundary(small_history).bounds(100):
            assert value == float(f"{value:.6g}")
