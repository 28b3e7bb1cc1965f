"""The corner table against adjacency by brute force."""

import itertools

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from gamutcore.boundary import modified_convex_hull
from gamutcore.geometry import next_corner, opposite_corners, previous_corner, swing, vertex_fans


def brute_force(faces):
    """Opposite corner of every corner, by comparing all edges with each other; −1 if not unique."""
    edges = {
        3 * face + place: (corners[(place + 1) % 3], corners[(place + 2) % 3])
        for face, corners in enumerate(faces)
        for place in range(3)
    }
    result = []
    for edge in edges.values():
        across = [other for other, turned in edges.items() if turned == edge[::-1]]
        same = [other for other, turned in edges.items() if turned == edge]
        result.append(across[0] if len(across) == len(same) == 1 else -1)
    return result


@given(
    st.lists(st.permutations(range(5)).map(lambda order: tuple(order[:3])), min_size=1, max_size=8)
)
def test_opposite_corners_of_anything(faces):
    """An edge without a counterpart, or with several, has no opposite corner."""
    opposite = opposite_corners(np.array(faces, np.int32), 5)
    assert opposite.tolist() == brute_force(faces)


def test_swinging_goes_once_round_a_vertex(random_cloud):
    faces = modified_convex_hull(random_cloud(1, 40)).mesh.faces
    vertex, opposite = faces.ravel(), opposite_corners(faces, 40)
    for start in range(len(vertex)):
        round_trip, corner = [start], swing(opposite, start)
        while corner != start:
            round_trip.append(corner)
            assert len(round_trip) <= len(vertex)
            corner = swing(opposite, corner)
        assert sorted(round_trip) == np.flatnonzero(vertex == vertex[start]).tolist()
        for one, other in itertools.pairwise(round_trip):
            # across the edge to the preceding corner
            assert vertex[previous_corner(one)] == vertex[next_corner(other)]


@given(seed=st.integers(0, 10**6))
def test_faces_around_each_vertex(seed):
    faces = np.random.default_rng(seed).integers(0, 9, (12, 3)).astype(np.int32)
    start, fan = vertex_fans(faces.reshape(-1), 10)
    for vertex, part in enumerate(np.split(fan, start[1:-1])):
        assert part.tolist() == sorted(np.nonzero(faces == vertex)[0])
