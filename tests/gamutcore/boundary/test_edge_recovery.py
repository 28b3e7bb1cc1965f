from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from gamutcore.boundary.edge_recovery import recover_edges
from gamutcore.boundary.radial_hull import radial_hull
from gamutcore.mesh import TriangleMesh


def sphere(seed, count):
    points = np.random.default_rng(seed).normal(size=(count, 3))
    points /= np.linalg.norm(points, axis=1)[:, np.newaxis]
    return points, radial_hull(points)


def edges_of(faces):
    return {frozenset(pair) for a, b, c in faces.tolist() for pair in ((a, b), (b, c), (c, a))}


@settings(max_examples=30)
@given(st.integers(0, 10_000), st.integers(20, 300), st.integers(1, 100))
def test_the_mesh_stays_valid_and_pairs_become_edges(seed, count, wanted):
    points, faces = sphere(seed, count)
    pairs = np.random.default_rng(seed + 1).integers(count, size=(wanted, 2)).astype(np.int32)
    found, given_up = recover_edges(points, faces, pairs)
    assert TriangleMesh(points, found).validity(np.zeros(3)).is_gamut
    edges = edges_of(found)
    missing = sum(frozenset(pair) not in edges for pair in pairs.tolist())
    assert missing == given_up


@settings(max_examples=30)
@given(st.integers(0, 10_000), st.integers(30, 300))
def test_the_edges_of_another_triangulation_are_recovered(seed, count):
    points, faces = sphere(seed, count)
    # another star-shaped triangulation of the same points: their hull with other radii
    radii = np.random.default_rng(seed).uniform(1.0, 1.002, count)[:, np.newaxis]
    other = radial_hull(points * radii)
    pairs = np.array(sorted(tuple(sorted(edge)) for edge in edges_of(other)), np.int32)
    found, given_up = recover_edges(points, faces, pairs)
    assert TriangleMesh(points, found).validity(np.zeros(3)).is_gamut
    assert given_up <= 0.02 * len(pairs)


def test_the_first_of_two_crossing_pairs_wins():
    points = np.array([(1, 1, 1), (1, -1, 1), (-1, -1, 1), (-1, 1, 1), (0, 0, -1)], float)
    faces = radial_hull(points)
    for pairs in ([(0, 2), (1, 3)], [(1, 3), (0, 2)]):
        found, given_up = recover_edges(points, faces, np.array(pairs, np.int32))
        assert frozenset(pairs[0]) in edges_of(found)
        assert given_up == 1
