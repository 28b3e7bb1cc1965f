"""One collapse, compared with renaming a vertex in a list of faces; the workspace."""

import numpy as np
import pytest

from gamutcore.corner_table import opposite_corners, swing
from gamutcore.decimation.candidates import CANDIDATES
from gamutcore.decimation.costs import cost_named
from gamutcore.decimation.edge_collapse import (
    candidate_is_valid,
    collapse_edge,
    is_stale,
    mark_changed,
)
from gamutcore.decimation.edge_queue import dequeue
from gamutcore.decimation.record import empty_record
from gamutcore.decimation.stage import Grid
from gamutcore.decimation.star import keeps_star_shape, link_condition_holds, write_edge_link

QUADRIC = cost_named("quadric").parameters
VOLUME = cost_named("volume").parameters

STEP = 2.0**-11


def grid_of(positions, centre=(0.0, 0.0, 0.0)):
    return Grid(positions.astype(np.float32), np.array(centre), STEP)


def cycles(faces):
    """Faces from their smallest vertex on, sorted."""
    lists = np.asarray(faces).tolist()
    return sorted(tuple(np.roll(face, -face.index(min(face))).tolist()) for face in lists)


def neighbours(faces, vertex):
    return set(np.asarray(faces)[(np.asarray(faces) == vertex).any(axis=1)].ravel()) - {vertex}


def assert_consistent(surface, work, numbers, faces):
    """Compare all arrays of the surface with its faces."""
    compact = np.full(len(surface.vertex), -1)
    compact[(3 * numbers[:, np.newaxis] + np.arange(3)).ravel()] = np.arange(3 * len(numbers))
    kept, renamed = np.unique(faces, return_inverse=True)
    renamed = np.ascontiguousarray(renamed.reshape(-1, 3), np.int32)
    expected = opposite_corners(renamed, len(kept))
    corners = np.flatnonzero(compact >= 0)
    np.testing.assert_array_equal(compact[surface.opposite[corners]], expected)
    for vertex in kept.tolist():
        assert surface.vertex[surface.corner_at[vertex]] == vertex
        assert compact[surface.corner_at[vertex]] >= 0
        assert surface.degree[vertex] == len(neighbours(faces, vertex))
    left = np.flatnonzero(surface.corner_facing >= 0)
    assert len(left) == 3 * len(faces) // 2
    assert set(surface.edge_of[corners].tolist()) == set(left.tolist())
    np.testing.assert_array_equal(surface.edge_of[surface.corner_facing[left]], left)
    np.testing.assert_array_equal(
        surface.swung[corners], [swing(surface.opposite, corner) for corner in corners.tolist()]
    )
    twins = surface.opposite[surface.corner_facing[left]]
    np.testing.assert_array_equal(surface.edge_of[twins], left)
    # removed edges have left the queue
    gone = np.setdiff1d(np.arange(len(surface.corner_facing)), left)
    assert (work.queue.heap_index[gone] == -1).all()
    assert (work.queue.heap_index[left] >= 0).all()
    assert work.queue.size[0] == len(left)


class TestCollapse:
    @pytest.mark.parametrize("cost", [QUADRIC, VOLUME])
    @pytest.mark.parametrize("seed", range(3))
    def test_is_the_renaming_of_a_vertex(
        self, bumpy_mesh, workspace_for, faces_left, ends_of, cost, seed, stage_of
    ):
        positions, faces = bumpy_mesh(seed, 40)
        stage = stage_of(cost, positions, faces)
        surface = stage.surface
        grid, record = stage.grid, empty_record(len(positions))
        work, ring = workspace_for(surface), np.empty((100, 2), np.int32)
        expected, places, done = faces.copy(), positions.copy(), 0
        for edge in np.random.default_rng(seed).permutation(len(faces)).tolist():
            corner = int(surface.corner_facing[edge])
            if corner < 0:
                continue
            one, two = ends_of(surface, corner)
            count = write_edge_link(surface, one, two, ring)
            place = surface.position[[one, two]].mean(axis=0)
            if not link_condition_holds(surface, one, two) or not keeps_star_shape(
                surface.position, ring, count, *place
            ):
                continue
            degrees = [len(neighbours(expected, end)) for end in (one, two)]
            work.point[:], work.rounded[:] = place, place
            kept = collapse_edge(stage, record, work, edge)
            assert kept in {one, two}
            dead = one + two - kept
            assert degrees[(one, two).index(dead)] <= degrees[(one, two).index(kept)]
            assert (record.kept[done], record.dead[done]) == (kept, dead)
            expected = np.where(expected == dead, kept, expected)
            expected = expected[[len(set(face)) == 3 for face in expected.tolist()]]
            places[kept] = place
            numbers, left = faces_left(surface)
            assert cycles(left) == cycles(expected)
            np.testing.assert_array_equal(surface.position[left], places[left])
            np.testing.assert_array_equal(grid.position[kept], place.astype(np.float32))
            assert_consistent(surface, work, numbers, left)
            done += 1
        assert done > 10

    def test_counts_parked_edges_that_vanish(self, bumpy_mesh, workspace_for, stage_of):
        """Of the three edges that a collapse removes, those outside the queue were parked."""
        positions, faces = bumpy_mesh(1, 40)
        stage = stage_of(QUADRIC, positions, faces)
        surface, work = stage.surface, workspace_for(stage.surface)
        chosen = int(np.flatnonzero(surface.degree[surface.vertex] > 4)[0])
        for edge in range(len(surface.corner_facing)):
            dequeue(work.queue, edge)
        work.parked[0] = len(surface.corner_facing) - 1
        edge = int(surface.edge_of[chosen])
        place = surface.position[surface.vertex[chosen - chosen % 3]]
        work.point[:], work.rounded[:] = place, place
        record = empty_record(len(positions))
        collapse_edge(stage, record, work, edge)
        # the edge itself is neither queued nor parked, and the other two were parked
        assert work.parked[0] == (surface.corner_facing >= 0).sum()


class TestStaleness:
    def test_edges_are_stale_around_what_changed(
        self, bumpy_mesh, surface_from, workspace_for, ends_of
    ):
        positions, faces = bumpy_mesh(2, 40)
        surface = surface_from(positions, faces)
        work = workspace_for(surface)
        edges = range(len(surface.corner_facing))
        assert not any(is_stale(surface, work, edge) for edge in edges)
        work.evaluated[:] = 6
        work.collapses[0] = 7
        mark_changed(surface, work, 11)
        around = neighbours(faces, 11) | {11}
        for edge in edges:
            ends = set(ends_of(surface, int(surface.corner_facing[edge])))
            assert is_stale(surface, work, edge) == bool(ends & around)
        work.evaluated[:] = 7
        assert not any(is_stale(surface, work, edge) for edge in edges)


class TestCandidatePositions:
    @pytest.mark.parametrize("cost", [QUADRIC, VOLUME])
    def test_are_valid_where_the_collapsed_mesh_is(
        self, bumpy_mesh, workspace_for, ends_of, cost, stage_of
    ):
        """They lie on the grid, and all faces around them see the centre, by determinants."""
        positions, faces = bumpy_mesh(5, 40)
        centre = np.array([50.25, 1.5, -3.0])
        stage = stage_of(cost, positions, faces, grid_of(positions, centre))
        surface = stage.surface
        work, valid = workspace_for(surface), 0
        for edge, corner in enumerate(surface.corner_facing.tolist()):
            one, two = ends_of(surface, corner)
            if not link_condition_holds(surface, one, two):
                continue
            count = write_edge_link(surface, one, two, work.link)
            if not candidate_is_valid(stage, work, edge, count):
                continue
            np.testing.assert_array_equal(work.rounded.astype(np.float64) % STEP, 0.0)
            np.testing.assert_array_equal(work.point, work.rounded.astype(np.float64) - centre)
            moved = positions.copy()
            moved[one] = moved[two] = work.point
            merged = np.where(faces == two, one, faces)
            merged = merged[[len(set(face)) == 3 for face in merged.tolist()]]
            assert np.linalg.det(moved[merged]).min() > 0
            valid += 1
        assert valid > 20

    def test_other_candidates_are_tried_as_chosen(
        self, bumpy_mesh, workspace_for, ends_of, stage_of
    ):
        positions, faces = bumpy_mesh(6, 40)
        stage = stage_of(QUADRIC, positions, faces, grid_of(positions))
        surface = stage.surface
        work, _ring = workspace_for(surface), np.empty((100, 2), np.int32)
        seen = set()
        for edge, corner in enumerate(surface.corner_facing.tolist()):
            one, two = ends_of(surface, corner)
            if not link_condition_holds(surface, one, two):
                continue
            count = write_edge_link(surface, one, two, work.link)
            places = set()
            for choice in range(CANDIDATES):
                work.choice[edge] = choice
                if candidate_is_valid(stage, work, edge, count):
                    places.add(tuple(work.rounded.tolist()))
            seen.add(len(places))
        assert max(seen) == CANDIDATES
