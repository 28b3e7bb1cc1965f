"""Accuracy of levels: a sphere against theory, kept volumes, and costs against each other."""

import functools

import numpy as np
import pytest

from benchmarks.booleans import mismatch
from gamutcore.boundary import modified_convex_hull
from gamutcore.characterisation import read_characterisation
from gamutcore.colours import surface_colours
from gamutcore.decimation import COSTS, decimate
from gamutcore.decimation.costs import SWEPT_DOWN_TO
from gamutcore.history import build_history

CENTRE = (50.0, 0.0, 0.0)


@pytest.fixture(scope="module")
def history_of(icosphere):
    """Return a function from a cost to the history of a sphere of 20,480 triangles."""
    mesh = icosphere(5, 40.0, CENTRE)
    return functools.cache(lambda cost: build_history(decimate(mesh, CENTRE, cost)))


@pytest.fixture(scope="module")
def constant(icosphere, history_of):
    """Return a function from a cost to its mismatch × triangles at 1000 triangles."""
    mesh = icosphere(5, 40.0, CENTRE)
    return lambda cost: 1000 * mismatch(mesh, history_of(cost).level(1000))


class TestSphereAgainstTheory:
    """Mismatch × triangles of a sphere: 5.13 for accumulated plane quadrics, 2.127 at best.

    The first constant was measured for the published method. The second is the limit of Böröczky
    and Ludwig.
    """

    # the best possible with n triangles: 12 π (1 ÷ (6 √3) − 1 ÷ (8 π))
    OPTIMUM = 12 * np.pi * (1 / (6 * np.sqrt(3)) - 1 / (8 * np.pi))

    def test_the_published_cost_reaches_its_constant(self, constant):
        assert constant("quadric") <= 5.13 * 1.1

    @pytest.mark.slow
    def test_volume_preservation_stays_well_below_it_and_above_the_optimum(self, constant):
        assert self.OPTIMUM * 0.97 < constant("volume") <= 3.0

    @pytest.mark.slow
    def test_the_most_accurate_cost_comes_near_the_optimum(self, constant):
        assert self.OPTIMUM * 0.97 < constant("finest") < constant("volume")
        assert constant("finest") <= 2.4

    @pytest.mark.parametrize("cost", COSTS)
    @pytest.mark.slow
    def test_its_levels_are_gamuts(self, assert_every_level, icosphere, history_of, cost):
        history = history_of(cost)
        asked = [*range(4, 400, 2), 1000, 5000, 10_000, history.triangles]
        levels = [history.level(triangles) for triangles in asked]
        assert assert_every_level(levels, CENTRE) == asked
        if cost == "volume":
            volume = icosphere(5, 40.0, CENTRE).volume
            assert [level.volume for level in levels] == pytest.approx(
                [volume] * len(asked), rel=1e-5
            )

    @pytest.mark.parametrize("subdivisions", [2, 3, 4])
    @pytest.mark.long
    def test_small_spheres_are_as_close_as_large_ones(self, icosphere, subdivisions):
        """Samples are taken however small the boundary is: 162, 642 and 2562 vertices.

        The prototype of this cost reached 3.07 ÷ n on a sphere of 20,000 faces. Accumulated
        quadrics reach 5.13 ÷ n.
        """
        mesh = icosphere(subdivisions)
        history = build_history(decimate(mesh, (0, 0, 0)))
        triangles = mesh.triangles // 6 * 2
        assert triangles * mismatch(mesh, history.level(triangles)) <= 5.13
        assert 40 * mismatch(mesh, history.level(40)) <= 3.07


@pytest.fixture(scope="module")
def large(icosphere):
    """Return the sphere, its decimation and its history."""
    mesh = icosphere(6, 40.0, CENTRE)
    assert len(mesh.vertices) == 40_962 > SWEPT_DOWN_TO + 20_000
    run = decimate(mesh, CENTRE)
    return mesh, run, build_history(run)


class TestLargeSphere:
    """A sphere of 40,962 vertices. Most of its collapses are made in sweeps."""

    @pytest.mark.slow
    def test_levels_are_gamuts_of_the_same_volume(self, large, assert_every_invariant):
        mesh, _, history = large
        swept = [2 * SWEPT_DOWN_TO - 4 + more for more in (-2, 0, 2, 2000, 20_000, 38_000)]
        for triangles in [4, 100, 1000, 10_000, *swept, mesh.triangles]:
            level = history.level(triangles)
            assert_every_invariant(level, CENTRE, triangles)
            assert level.volume == pytest.approx(mesh.volume, rel=1e-5)

    @pytest.mark.slow
    def test_every_collapse_is_recorded_once(self, large):
        mesh, run, _ = large
        assert len(set(run.record.dead.tolist())) == len(run.record.dead) == len(mesh.vertices) - 4
        assert (np.diff(run.record.moved_end) > 0).all()
        assert len(run.record.moved) == run.record.moved_end[-1]

    @pytest.mark.long
    def test_coarse_levels_are_as_good_as_of_smaller_spheres(self, large):
        """The bound for 10,000 vertices is 3.0 ÷ n. The limit for n → ∞ is 2.127 ÷ n."""
        mesh, _, history = large
        for triangles in (500, 1000):
            assert triangles * mismatch(mesh, history.level(triangles)) <= 3.0


def waves(seed, count, amplitude, stretch):
    """Return a boundary with waves and folds."""
    random = np.random.default_rng(seed)
    directions = random.normal(size=(count, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, np.newaxis]
    ways = random.normal(size=(4, 3))
    radii = 40.0 + amplitude * np.abs(np.sin(directions @ ways.T * 1.5)).sum(axis=1)
    return modified_convex_hull(directions * radii[:, np.newaxis] * stretch + CENTRE, 0.05)


@pytest.mark.long
def test_levels_of_a_larger_boundary_have_its_volume():
    """More vertices than the levels that are compared with samples, of which there are 2000."""
    boundary = waves(0, 3300, 2.0, (1.0, 1.0, 1.0))
    assert len(boundary.mesh.vertices) > 2400
    history = build_history(decimate(boundary.mesh, boundary.centre, "volume"))
    for triangles in range(4, history.triangles + 1, 12):
        level = history.level(triangles)
        assert level.volume == pytest.approx(boundary.mesh.volume, rel=1e-5)


COMPARED = (200, 100, 50)


@pytest.mark.long
def test_levels_of_finest_are_closer_than_those_of_the_default_cost():
    found = []
    for seed in range(3):
        boundary = waves(seed, 600, 4.0, (1.2, 1.0, 0.8))
        for cost in ("finest", "volume"):
            history = build_history(decimate(boundary.mesh, boundary.centre, cost))
            found.append([mismatch(boundary.mesh, history.level(n)) for n in COMPARED])
    finest, volume = np.mean(found[::2], axis=0), np.mean(found[1::2], axis=0)
    assert (finest <= volume).all()


@pytest.mark.parametrize("centre", [(12.0, 0.0, 0.0), (93.0, -1.0, -1.0)])
@pytest.mark.long
def test_levels_do_not_grow_about_a_centre_near_the_surface(fogra39, centre):
    """Half of all directions end near the centre, where hardly any volume is sampled.

    An earlier version had five times the volume of the press about the first centre, and twice the
    mismatch of `volume` about the second.
    """
    points = surface_colours(read_characterisation(fogra39), surface_samples=3000).points
    boundary = modified_convex_hull(points, 0.2, centre)
    closer, default = (
        build_history(decimate(boundary.mesh, boundary.centre, cost))
        for cost in ("finest", "volume")
    )
    ratios = []
    for triangles in (4, 6, 10, 20, *COMPARED):
        level = closer.level(triangles)
        assert level.volume < 1.5 * boundary.mesh.volume
        other = mismatch(boundary.mesh, default.level(triangles))
        ratios.append(mismatch(boundary.mesh, level) / other)
    # single levels of so few triangles are chaotic
    assert np.mean(ratios) < 1


@pytest.mark.parametrize(("divisions", "first"), [(2, 100), (4, 256)])
@pytest.mark.slow
def test_vertices_move_in_a_tenth_of_all_levels(icosphere, divisions, first):
    """Number of vertices left at the first move, for spheres of 162 and 2562 vertices."""
    mesh = icosphere(divisions)
    record = decimate(mesh, (0, 0, 0), "finest").record
    shifts = np.diff(record.shifted_end, prepend=0)
    left = len(mesh.vertices) - 1 - np.arange(len(shifts))
    assert (shifts[left > first] == 0).all()
    assert (shifts[left < first] > 0).mean() > 0.5
