"""Samples of a reference, and the deviation of levels from it, by sums over all samples.

The samples are those of real decimations, which stop after a number of collapses. Each check
computes the faces that they lie in, and the deviation, from all samples and all faces.
"""

from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.booleans import mismatch
from gamutcore.decimation.collapse import LoopWorkspace, collapse_edges, empty_workspace
from gamutcore.decimation.costs import (
    MEMORYLESS,
    GridPositions,
    Parameters,
    State,
    copy_state,
    initial_state,
)
from gamutcore.decimation.deviation import LARGEST_SHARE, SAMPLES
from gamutcore.decimation.quadrics import constrained_optimum
from gamutcore.decimation.record import Record, empty_record, extend_record
from gamutcore.geometry import TriangleMesh, opposite_corners

SEEDS = st.integers(0, 10**6)
ALWAYS = Parameters(
    MEMORYLESS,
    compares_with_full=True,
    compared_vertices=1 << 30,
    samples=1,
    largest_samples=1 << 30,
    samples_per_face=1 << 20,
)
"""All levels are compared with the full boundary, by one sample of each face."""

REFINED = 12
"""Samples of each face, from which on the positions of new vertices are refined."""


class Decimation(NamedTuple):
    """A decimation that goes on from where it stopped."""

    state: State
    record: Record
    work: LoopWorkspace

    def collapse(self, wanted):
        """Collapse edges until there have been so many, and return the decimation."""
        record = self.record
        while missing := collapse_edges(self.state, record, self.work, 0, wanted):
            record = extend_record(record, int(self.work.collapses[0]), int(missing))
        assert self.work.collapses[0] == wanted
        return self._replace(record=record)

    def faces(self):
        """Return the numbers and the vertices of the remaining faces."""
        surface = self.state.surface
        corners = surface.corner_facing[surface.corner_facing >= 0]
        numbers = np.unique(np.concatenate([corners, surface.opposite[corners]]) // 3)
        return numbers, surface.vertex.reshape(-1, 3)[numbers]

    def edges(self):
        """Return the ends of the edges by their numbers; -1 where an edge is removed."""
        surface = self.state.surface
        corners = surface.corner_facing.astype(np.int64)
        places = 3 * (corners // 3) + (corners[:, np.newaxis] + [1, 2]).T % 3
        return np.where(corners >= 0, surface.vertex[places], -1).T

    def samples(self):
        """Return points, weights and the faces that the samples are assigned to."""
        deviation = self.state.deviation
        sizes = deviation.end - deviation.begin
        chosen = np.concatenate(
            [np.arange(*ends) for ends in zip(deviation.begin, deviation.end, strict=True)]
        )
        points = np.stack([deviation.x[chosen], deviation.y[chosen], deviation.z[chosen]], axis=1)
        return points, deviation.weight[chosen], np.repeat(np.arange(len(sizes)), sizes)

    def shares(self, positions=None):
        """Return the numbers of the faces, depths in their cones, and w |1 - t³| of all samples.

        It solves p = α a + β b + γ c for every point p and every face (a, b, c). All three
        coefficients are positive in the cone of the face, and 1 ÷ t is their sum.
        """
        points, weights, _ = self.samples()
        numbers, faces = self.faces()
        if positions is None:
            positions = self.state.surface.position
        cones = np.linalg.inv(np.swapaxes(positions[faces], 1, 2))
        parts = np.einsum("fij,sj->fsi", cones, points)
        depths = parts.min(axis=2)
        inside = depths.argmax(axis=0)
        inverse = parts[inside, np.arange(len(points))].sum(axis=1)
        return numbers, depths, weights * np.minimum(np.abs(1 - 1 / inverse**3), LARGEST_SHARE)

    def check(self):
        """Check the assignment of all samples and the errors of all faces."""
        deviation, (_, weights, owners) = self.state.deviation, self.samples()
        numbers, depths, shares = self.shares()
        assert len(weights) == deviation.counts[SAMPLES]
        # a sample on an edge between two faces may be in either
        assert depths[np.searchsorted(numbers, owners), np.arange(len(owners))].min() >= -1e-9
        assert np.isin(owners, numbers).all()
        errors = np.bincount(owners, shares, len(deviation.error))
        np.testing.assert_allclose(deviation.error, errors, rtol=1e-7, atol=1e-9 * weights.sum())


@pytest.fixture(scope="module")
def begin():
    """Return a function from parameters and a mesh to a decimation that compares all levels."""

    def make(mesh, samples=1, wanted=None, **options):
        positions, faces = np.asarray(mesh[0], np.float64), np.ascontiguousarray(mesh[1], np.int32)
        grid = GridPositions(positions.astype(np.float32), np.zeros(3), 2.0**-12)
        wanted = wanted or (1 if samples == 1 else samples * len(faces))
        parameters = ALWAYS._replace(samples=wanted, **options)
        opposite = opposite_corners(faces, len(positions))
        state = initial_state(parameters, positions, faces, opposite, grid)
        record = empty_record(len(positions), state.parameters.moved_vertices)
        work = empty_workspace(
            3 * len(faces) // 2, len(positions), np.zeros(1, np.int64), np.empty(0)
        )
        return Decimation(state, record, work).collapse(0)

    return make


def six_volumes(mesh):
    return np.linalg.det(np.asarray(mesh[0], np.float64)[mesh[1]])


class TestTaking:
    @settings(max_examples=8)
    @given(seed=SEEDS, wanted=st.integers(1, 3000))
    def test_no_sample_has_much_more_than_the_wanted_share(self, bumpy_mesh, begin, seed, wanted):
        """Each face has a sample. Faces of several shares have about as many samples."""
        mesh = bumpy_mesh(seed)
        wanted = min(wanted, 12 * len(mesh[1]))
        decimation = begin(mesh, wanted=wanted)
        decimation.check()
        _, weights, owners = decimation.samples()
        volumes = six_volumes(mesh)
        share = volumes.sum() / wanted
        np.testing.assert_allclose(np.bincount(owners, weights), volumes, rtol=1e-12)
        assert np.ptp(weights / (volumes / np.bincount(owners))[owners]) < 1e-12
        assert (weights <= 1.5**2 * share * (1 + 1e-12)).all()
        assert (weights[volumes[owners] > 1.5**2 * share] > share / 1.5**2).all()

    def test_sums_over_samples_integrate_linear_functions(self, bumpy_mesh, begin):
        """Exactly, over the solid, for functions that are linear in the radius (Gauss' rule)."""
        mesh = bumpy_mesh(5)
        points, weights, _ = begin(mesh).samples()
        volumes = six_volumes(mesh)
        assert len(points) == len(volumes)
        for form in ([1, 0, 0], [0, 1, 1], [1, -2, 3]):
            exact = (volumes * (mesh[0][mesh[1]] @ form).mean(axis=1)).sum()
            assert weights @ (points @ form) == pytest.approx(exact, abs=1e-10 * volumes.sum())

    @pytest.mark.parametrize("sides", [5, 30, 200])
    def test_walks_that_cycle_find_the_faces(self, begin, sides):
        """A fan of slivers around an axis, where walks from some faces cycle."""
        turn, here = np.linspace(0, 2 * np.pi, sides, endpoint=False), np.arange(sides)
        height = np.random.default_rng(sides).uniform(-3, 3, sides)
        rim = np.stack([np.cos(turn), np.sin(turn), height], axis=1)
        rim /= np.linalg.norm(rim, axis=1)[:, np.newaxis]
        after, top = np.roll(here, -1), np.full(sides, sides)
        faces = [np.stack([here, after, top], 1), np.stack([after, here, top + 1], 1)]
        mesh = np.vstack([rim, [[0, 0, 9], [0, 0, -9]]]), np.vstack(faces)
        assert six_volumes(mesh).min() > 0
        begin(mesh, REFINED).check()


class TestCollapses:
    @pytest.mark.parametrize("samples", [1, REFINED])
    @pytest.mark.parametrize("keeps_volume", [False, True])
    def test_the_cheapest_edge_changes_the_deviation_by_its_error(
        self, bumpy_mesh, begin, samples, keeps_volume
    ):
        """Each call queues all edges anew, so the error of an edge is that of the present level.

        The error has a small penalty for the length of the edge, and the position is rounded. With
        many samples the position is refined: the deviation is less than at the quadric's optimum.
        """
        mesh = bumpy_mesh(0, 60)
        decimation = begin(mesh, samples, preserves_volume=keeps_volume)
        whole = six_volumes(mesh).sum()
        _, weights, _ = decimation.samples()
        before, compared, refined = 0.0, 0, 0
        for number in range(24):
            old, place = copy_state(decimation.state), np.empty(3)
            edges = decimation.edges()
            decimation = decimation.collapse(number + 1)
            decimation.check()
            # a weight is a share of the volume of the reference, whatever face it is in
            assert decimation.samples()[1].sum() == pytest.approx(whole, rel=1e-12)
            assert len(decimation.samples()[1]) == len(weights)
            after = decimation.shares()[2].sum()
            record, priority = decimation.record, decimation.work.queue.priority
            ends = {int(record.kept[number]), int(record.dead[number])}
            (edge,) = (e for e, pair in enumerate(edges.tolist()) if set(pair) == ends)
            # the first candidate of an edge: another one has at least the error of the first
            if decimation.work.choice[edge] == 0:
                assert priority[edge] == pytest.approx(after - before, abs=1e-6 * whole)
                compared += 1
                corner = old.surface.corner_facing[edge]
                constrained_optimum(old.quadrics, old.surface, corner, place)
                moved = decimation.state.surface.position.copy()
                moved[record.kept[number]] = place
                if np.linalg.det(moved[decimation.faces()[1]]).min() > 0:
                    gain = decimation.shares(moved)[2].sum() - after
                    assert gain >= -1e-6 * whole
                    refined += gain > 1e-6 * whole
            before = after
        assert compared > 15
        assert (refined > 10) == (samples == REFINED)
        assert before > 1e-3 * whole

    @pytest.mark.parametrize("samples", [1, REFINED])
    def test_moves_lower_the_deviation(self, bumpy_mesh, begin, samples):
        mesh, deviations = bumpy_mesh(3, 150), []
        for moved in (0, 1 << 20):
            decimation = begin(mesh, samples, moved_vertices=moved).collapse(60)
            decimation.check()
            deviations.append(decimation.shares()[2].sum())
            shifts = decimation.record.shifted_end[59]
            assert (shifts > 0) == (moved > 0)
        assert deviations[1] < deviations[0]

    @settings(max_examples=5)
    @given(seed=SEEDS, samples=st.sampled_from([1, REFINED]), most=st.integers(1, 8))
    def test_thinned_samples_have_equal_shares(self, bumpy_mesh, begin, seed, samples, most):
        """No weight is lost, and no face gains or loses more than a share."""
        mesh = bumpy_mesh(seed, 60)
        decimation = begin(mesh, samples).collapse(25)
        points, weights, owners = decimation.samples()
        size = len(decimation.state.deviation.begin)
        parameters = decimation.state.parameters._replace(samples_per_face=most)
        decimation = decimation._replace(state=decimation.state._replace(parameters=parameters))
        decimation = decimation.collapse(25)
        decimation.check()
        thinned, marked, kept = decimation.samples()
        limit = 4 * most * (len(mesh[0]) - 25)
        if len(points) <= limit:
            np.testing.assert_array_equal(thinned, points)
            return
        assert 0 < len(thinned) <= limit // 2
        share = weights.sum() / (limit // 2)
        marks = marked / share
        np.testing.assert_allclose(marks, np.rint(marks), rtol=1e-9)
        worth = dict(zip(map(tuple, points), weights / share, strict=True))
        assert (np.abs(marks - [worth[tuple(point)] for point in thinned]) < 1 + 1e-9).all()
        assert marked.sum() == pytest.approx(weights.sum(), rel=1e-9)
        changes = np.bincount(kept, marked, size) - np.bincount(owners, weights, size)
        assert np.abs(changes).max() <= share * (1 + 1e-9)

    @pytest.mark.parametrize("samples", [1, 9])
    def test_the_sum_of_the_errors_is_the_mismatch(self, icosphere, begin, samples):
        """Compared with exact boolean operations, on a sphere of 2562 vertices."""
        mesh = icosphere(4)
        decimation = begin((mesh.vertices, mesh.faces), samples, preserves_volume=True)
        decimation = decimation.collapse(2562 - 100)
        _, faces = decimation.faces()
        kept, renamed = np.unique(faces, return_inverse=True)
        positions = decimation.state.surface.position[kept].astype(np.float32)
        level = TriangleMesh(positions, renamed.reshape(-1, 3).astype(np.int32))
        exact = mismatch(mesh, level)
        assert exact > 0.005
        summed = decimation.state.deviation.error.sum() / 6 / mesh.volume
        assert summed == pytest.approx(exact, rel=0.05)
