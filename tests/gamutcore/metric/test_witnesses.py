"""Evidence rejects levels that brute force finds too far away, and no others."""

import numpy as np
import pytest

from gamutcore.metric.cones import compute_cones, locate
from gamutcore.metric.distance_bound import make_surface
from gamutcore.metric.error_curve import surface_in_preorder
from gamutcore.metric.witnesses import Evidence, LevelWalk, find_evidence

NO_POINTS, NO_FACES = np.empty((0, 3)), np.empty(0, np.int32)


@pytest.fixture(scope="module")
def counts(small_history):
    return np.arange(4, min(small_history.triangles, 160), 2, dtype=np.int32)


def evidence_of(history, triangles, limit):
    full, near = surface_in_preorder(history.full(), history)
    level = history.level(triangles)
    position = np.ascontiguousarray(level.vertices - np.asarray(history.centre))
    surface = make_surface(position, level.faces.astype(np.int32).ravel())
    order = np.arange(len(near), dtype=np.int32)
    locations = locate(full.position, order, near, compute_cones(surface))
    return find_evidence(full, surface, locations, limit)


@pytest.mark.parametrize("limit", [0.5, 2.0, 8.0])
@pytest.mark.slow
def test_points_reject_the_levels_that_they_are_far_from(
    small_history, counts, distances_to, limit
):
    found = evidence_of(small_history, 20, limit)
    points = found.points + np.asarray(small_history.centre)
    assert (distances_to(points, small_history.level(20)) > limit - 1e-9).all()
    walk = LevelWalk(small_history, counts)
    for index, point in enumerate(points):
        walk = LevelWalk(small_history, counts)
        walk.skip(Evidence(found.points[index : index + 1], NO_FACES), limit)
        skipped = counts[: walk.index].tolist()
        far = [distances_to(point[np.newaxis], small_history.level(n))[0] for n in skipped]
        assert all(distance > limit - 1e-9 for distance in far)
        if walk.index < len(counts):
            level = small_history.level(int(counts[walk.index]))
            assert distances_to(point[np.newaxis], level)[0] <= limit + 1e-9


def test_a_face_rejects_the_levels_that_have_it(small_history, counts):
    level = small_history.level(4)
    for face in range(4):
        walk = LevelWalk(small_history, counts)
        walk.skip(Evidence(NO_POINTS, np.array([face], np.int32)), 1.0)
        for count in counts[: walk.index]:
            same = small_history.level(int(count))
            np.testing.assert_array_equal(same.faces[face], level.faces[face])
            corners = level.faces[face]
            np.testing.assert_array_equal(same.vertices[corners], level.vertices[corners])
        after = small_history.level(int(counts[walk.index]))
        one = after.vertices[after.faces[face]]
        assert not np.array_equal(one, level.vertices[level.faces[face]])


def test_no_evidence_within_a_large_limit(small_history, counts):
    assert evidence_of(small_history, 20, 1e3) is None
    walk = LevelWalk(small_history, counts)
    walk.skip(Evidence(NO_POINTS, NO_FACES), 1.0)
    assert walk.index == 0


def test_a_walk_advances_level_by_level(small_history, counts):
    walk = LevelWalk(small_history, counts)
    for index in range(1, len(counts) + 1):
        walk.advance()
        assert walk.index == index


def test_evidence_of_all_levels_skips_to_the_end(small_history, counts):
    walk = LevelWalk(small_history, counts)
    walk.skip(Evidence(np.full((1, 3), 1e4), NO_FACES), 1.0)
    assert walk.index == len(counts)
