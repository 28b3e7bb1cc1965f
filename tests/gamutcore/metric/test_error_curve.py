"""The error curve: against exact boolean volumes, and against what is known of spheres."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gamutcore.decimation import decimated
from gamutcore.errors import TriangleCountError
from gamutcore.history import history_of
from gamutcore.metric import mismatch
from gamutcore.metric.error_curve import error_curve, round_counts

COUNTS = [10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10_000]


@pytest.fixture(scope="module")
def curve(fogra39_gamut):
    return {level.triangles: level for level in error_curve(fogra39_gamut.history, COUNTS)}


class TestOfFogra39:
    @pytest.mark.parametrize("triangles", COUNTS)
    def test_mismatch_is_within_12_percent_of_the_exact_one(self, curve, fogra39_gamut, triangles):
        history = fogra39_gamut.history
        exact = mismatch(history.full(), history.level(triangles))
        assert curve[triangles].mismatch == pytest.approx(exact, rel=0.12)

    @pytest.mark.parametrize("triangles", COUNTS)
    def test_volume_is_exact(self, curve, fogra39_gamut, triangles):
        level = fogra39_gamut.history.level(triangles)
        assert curve[triangles].volume == pytest.approx(level.volume, rel=1e-9)

    @pytest.mark.parametrize("triangles", [10, 100, 1000])
    def test_distances_are_those_along_rays(self, curve, fogra39_gamut, triangles):
        """Every ray from the centre against every face, by solving for barycentric coordinates."""
        history = fogra39_gamut.history
        level = history.level(triangles)
        first, second, third = level.corners(history.centre)
        inverse = np.linalg.inv(np.stack([first, second, third], axis=2))
        points = history.full().vertices.astype(float) - history.centre
        points = points[:: max(1, len(points) // 3000)]
        shares = np.einsum("fij,pj->pfi", inverse, points)
        face = shares.min(axis=2).argmax(axis=1)
        # a point p = Σ shares · corners; on the face the shares sum to one
        ratio = 1 / shares[np.arange(len(points)), face].sum(axis=1)
        distance = np.abs(1 - ratio) * np.linalg.norm(points, axis=1)
        assert distance.max() <= curve[triangles].maximum_distance * (1 + 1e-9)
        assert curve[triangles].mean_distance == pytest.approx(distance.mean(), rel=0.25)
        assert curve[triangles].mean_distance < curve[triangles].maximum_distance

    def test_errors_fall_with_the_count(self, curve):
        mismatches = [curve[count].mismatch for count in COUNTS]
        assert mismatches == sorted(mismatches, reverse=True)


class TestOrder:
    def test_is_ascending_whatever_was_asked_for(self, small_history):
        counts = [50, 4, 20, 50, 4]
        assert [level.triangles for level in error_curve(small_history, counts)] == [4, 20, 50]

    def test_one_count_gives_what_many_do(self, small_history):
        together = error_curve(small_history, range(4, small_history.triangles, 10))
        for level in together:
            assert error_curve(small_history, [level.triangles]) == [level]

    def test_the_full_boundary_has_no_error(self, small_history):
        (level,) = error_curve(small_history, [small_history.triangles])
        assert level.mismatch == pytest.approx(0.0, abs=1e-12)
        assert level.maximum_distance == pytest.approx(0.0, abs=1e-10)
        assert level.volume == pytest.approx(small_history.full().volume, rel=1e-9)

    @pytest.mark.parametrize("count", [3, 10**7])
    def test_a_count_that_is_not_there_is_refused(self, small_history, count):
        with pytest.raises(TriangleCountError):
            error_curve(small_history, [10, count])


def test_of_a_sphere(icosphere):
    """The distance of a volume-preserving level from a sphere is of the order of its sagitta.

    A face with circumradius ρ of a unit sphere lies 1 − √(1 − ρ²) deep; with n equal faces of
    4π/n that is ρ²/2 = (4/√27)(4π/n)/… below 8/n. Preserving volume splits it between both sides.
    """
    history = history_of(decimated(icosphere(5), (0, 0, 0)))
    for level in error_curve(history, [100, 1000, 4000]):
        assert level.maximum_distance < 4 * 8 / level.triangles
        assert level.mean_distance < level.maximum_distance
        # volume differs by area times distance, on a unit sphere 3 × the mean distance
        assert level.mismatch == pytest.approx(3 * level.mean_distance, rel=0.1)


class TestRoundCounts:
    @given(st.integers(2, 10**7).map(lambda half: 2 * half))
    def test_ascend_from_four_to_the_maximum(self, maximum):
        counts = round_counts(maximum)
        assert counts == sorted(set(counts))
        assert counts[0] == 4
        assert counts[-1] == maximum
        assert all(count % 2 == 0 for count in counts)
        assert all(
            str(count).rstrip("0") in {"1", "2", "4", "5", "6", "8"} for count in counts[:-1]
        )

    def test_steps_are_one_two_five(self):
        assert round_counts(1234) == [4, 6, 8, 10, 20, 50, 100, 200, 500, 1000, 1234]
        assert round_counts(100) == [4, 6, 8, 10, 20, 50, 100]
        assert round_counts(4) == [4]
        assert round_counts(6) == [4, 6]
