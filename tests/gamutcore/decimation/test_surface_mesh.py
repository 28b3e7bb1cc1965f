"""The geometry of one collapse, compared with sets, determinants, volumes and linear programmes."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from gamutcore.decimation.surface_mesh import (
    DEFICIT_NOW,
    find_inner_direction,
    keeps_star_shape,
    link_condition_holds,
    scale_to_preserve_volume,
    star_volume,
    volume_gradient,
    write_edge_link,
    write_vertex_link,
)

TETRAHEDRON = (
    np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)], float),
    [(0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)],
)
OCTAHEDRON = (
    np.vstack([np.eye(3), -np.eye(3)]),
    [(x, y, z) if (x < 3) ^ (y < 3) ^ (z < 3) else (x, z, y)
     for x, y, z in itertools.product((0, 3), (1, 4), (2, 5))],
)  # fmt: skip
# two tetrahedra on one base: vertices 0, 1, 2 around, 3 above, 4 below
BIPYRAMID = (
    np.array([(1, 0, 0), (-0.5, 0.9, 0), (-0.5, -0.9, 0), (0, 0, 1), (0, 0, -1)]),
    [(0, 1, 3), (1, 2, 3), (2, 0, 3), (1, 0, 4), (2, 1, 4), (0, 2, 4)],
)


def neighbours(faces, vertex):
    return {int(v) for face in faces for v in face if vertex in face} - {vertex}


def link(faces, kept, dead):
    """For each face that contains one end of an edge, its other two vertices."""
    turned = [tuple(np.roll(face, shift).tolist()) for face in faces for shift in range(3)]
    return sorted(
        (one, two)
        for end, one, two in turned
        if end in {kept, dead} and not {one, two} & {kept, dead}
    )


def volume(positions, faces):
    return np.linalg.det(positions[np.asarray(faces)]).sum() / 6


def collapsed(positions, faces, kept, dead, place):
    """Positions and faces after a collapse, by renaming."""
    renamed = [[kept if v == dead else int(v) for v in face] for face in faces]
    moved = positions.copy()
    moved[kept] = place
    return moved, [face for face in renamed if len(set(face)) == 3]


def ring_of(surface, kept, dead):
    ring = np.empty((100, 2), np.int32)
    count = write_edge_link(surface, kept, dead, ring)
    return ring, count


def slope_of(surface, ring, count):
    return np.array(volume_gradient(surface.position, ring, count))


class TestLinkCondition:
    @pytest.mark.parametrize("body", [TETRAHEDRON, OCTAHEDRON])
    def test_holds_for_every_edge_of_the_regular_bodies(self, surface_from, edges_of, body):
        surface = surface_from(*body)
        for one, two in edges_of(body[1]):
            assert link_condition_holds(surface, one, two)

    def test_fails_around_the_waist_of_a_bipyramid(self, surface_from, edges_of):
        surface = surface_from(*BIPYRAMID)
        holds = {edge: link_condition_holds(surface, *edge) for edge in edges_of(BIPYRAMID[1])}
        # the waist is a triangle that is not a face: collapsing its edges would pinch the surface
        assert {edge for edge, it_does in holds.items() if not it_does} == {(0, 1), (0, 2), (1, 2)}

    @settings(max_examples=20)
    @given(seed=st.integers(0, 10**6))
    @pytest.mark.slow
    def test_is_two_common_neighbours(self, surface_from, bumpy_mesh, edges_of, seed):
        positions, faces = bumpy_mesh(seed, 30)
        surface = surface_from(positions, faces)
        for one, two in edges_of(faces):
            common = neighbours(faces, one) & neighbours(faces, two)
            assert link_condition_holds(surface, one, two) == (len(common) == 2)
            assert link_condition_holds(surface, two, one) == (len(common) == 2)


class TestLink:
    @settings(max_examples=10)
    @given(seed=st.integers(0, 10**6))
    @pytest.mark.slow
    def test_is_the_boundary_of_the_faces_around_an_edge(
        self, surface_from, bumpy_mesh, edges_of, seed
    ):
        positions, faces = bumpy_mesh(seed, 40)
        surface = surface_from(positions, faces)
        for kept, dead in edges_of(faces):
            ring, count = ring_of(surface, kept, dead)
            assert sorted(map(tuple, ring[:count].tolist())) == link(faces, kept, dead)

    def test_of_a_vertex_is_the_boundary_of_its_faces(self, surface_from, bumpy_mesh):
        positions, faces = bumpy_mesh(4, 40)
        surface = surface_from(positions, faces)
        for vertex in range(len(positions)):
            ring = np.empty((100, 2), np.int32)
            count = write_vertex_link(surface, vertex, ring)
            # a vertex instead of an edge: its number twice
            pairs = ring[:count].tolist()
            assert sorted(map(tuple, pairs)) == link(faces, vertex, vertex)
            # in order around the vertex
            for one, other in zip(pairs, pairs[1:] + pairs[:1], strict=True):
                assert set(one) & set(other)


class TestStarShape:
    @settings(max_examples=20)
    @given(seed=st.integers(0, 10**6))
    @pytest.mark.slow
    def test_is_kept_where_all_new_determinants_are_positive(self, surface_from, bumpy_mesh, seed):
        positions, faces = bumpy_mesh(seed, 30)
        surface = surface_from(positions, faces)
        random = np.random.default_rng(seed)
        seen = set()
        for face in faces[:20]:
            kept, dead = int(face[0]), int(face[1])
            ring, count = ring_of(surface, kept, dead)
            place = positions[kept] + random.normal(size=3) * 15
            new = [(positions[a], positions[b], place) for a, b in link(faces, kept, dead)]
            expected = bool(np.linalg.det(new).min() > 0)
            assert keeps_star_shape(surface.position, ring, count, *place) == expected
            # only the direction matters
            for factor in (1e-6, 1e6):
                assert (
                    keeps_star_shape(surface.position, ring, count, *(factor * place)) == expected
                )
            seen.add(expected)
        assert seen == {True, False}

    def test_nan_does_not_keep_it(self, surface_from):
        surface = surface_from(*OCTAHEDRON)
        ring, count = ring_of(surface, 0, 1)
        assert keeps_star_shape(surface.position, ring, count, 0.7, 0.7, 0.0)
        assert not keeps_star_shape(surface.position, ring, count, np.nan, 0.7, 0.0)


class TestVolume:
    @settings(max_examples=20)
    @given(seed=st.integers(0, 10**6))
    def test_is_preserved_by_scaling(self, surface_from, bumpy_mesh, edges_of, seed):
        positions, faces = bumpy_mesh(seed, 30)
        surface = surface_from(positions, faces)
        before = volume(positions, faces)
        for kept, dead in edges_of(faces)[::5]:
            ring, count = ring_of(surface, kept, dead)
            place = (positions[kept] + positions[dead]) / 2
            direction = place / np.linalg.norm(place)
            if not link_condition_holds(surface, kept, dead) or not keeps_star_shape(
                surface.position, ring, count, *place
            ):
                continue
            assert scale_to_preserve_volume(surface, kept, dead, ring, count, place)
            np.testing.assert_allclose(place / np.linalg.norm(place), direction, rtol=1e-12)
            after = volume(*collapsed(positions, faces, kept, dead, place))
            assert after == pytest.approx(before, rel=1e-12)

    @settings(max_examples=10)
    @given(seed=st.integers(0, 10**6))
    def test_is_linear_in_the_position(self, surface_from, bumpy_mesh, edges_of, seed):
        positions, faces = bumpy_mesh(seed, 30)
        surface = surface_from(positions, faces)
        whole = volume(positions, faces)
        for kept, dead in edges_of(faces)[::5]:
            if len(neighbours(faces, kept) & neighbours(faces, dead)) != 2:
                continue
            place = positions[kept] * 1.1
            slope = slope_of(surface, *ring_of(surface, kept, dead))
            change = (slope @ place - star_volume(surface, kept, dead)) / 6
            after = volume(*collapsed(positions, faces, kept, dead, place))
            assert whole + change == pytest.approx(after, rel=1e-12)

    @pytest.mark.parametrize(("missing", "made_up"), [(0.01, 0.01), (-1.0, 0.0)])
    def test_deficit_is_made_up_unless_it_is_large(
        self, surface_from, bumpy_mesh, missing, made_up
    ):
        positions, faces = bumpy_mesh(2, 30)
        surface = surface_from(positions, faces)
        kept, dead = next(
            (int(face[0]), int(face[1]))
            for face in faces
            if len(neighbours(faces, int(face[0])) & neighbours(faces, int(face[1]))) == 2
        )
        before = volume(positions, faces)
        surface.deficit[DEFICIT_NOW] = 6 * missing * before
        place = (positions[kept] + positions[dead]) / 2
        ring, count = ring_of(surface, kept, dead)
        assert scale_to_preserve_volume(surface, kept, dead, ring, count, place)
        after = volume(*collapsed(positions, faces, kept, dead, place))
        assert after == pytest.approx((1 + made_up) * before, rel=1e-12)

    @pytest.mark.parametrize("place", [(-1.0, -1.0, 0.0), (0.0, 0.0, 0.0), (np.nan, 1.0, 0.0)])
    def test_cannot_be_kept_behind_the_centre(self, surface_from, place):
        surface = surface_from(*OCTAHEDRON)
        ring, count = ring_of(surface, 0, 1)
        moved = np.array(place)
        assert not scale_to_preserve_volume(surface, 0, 1, ring, count, moved)
        np.testing.assert_array_equal(moved, place)


def deepest(normals):
    """Largest t with n·x ≥ t for unit normals n and some x in the cube, by linear programming."""
    bounds = [(-1, 1)] * 3 + [(None, None)]
    rows = np.hstack([-normals, np.ones((len(normals), 1))])
    return -linprog([0, 0, 0, -1], rows, np.zeros(len(normals)), bounds=bounds).fun


class TestInnerDirection:
    @settings(max_examples=150)
    @given(seed=st.integers(0, 10**6), sides=st.integers(3, 12), spread=st.floats(0.05, 3.0))
    @pytest.mark.slow
    def test_agrees_with_linear_programming(self, seed, sides, spread):
        """A perturbed ring around the z axis, seen from the centre."""
        random = np.random.default_rng(seed)
        turn = np.sort(random.uniform(0, 2 * np.pi, sides))
        position = np.stack([np.cos(turn), np.sin(turn), np.ones(sides)], axis=1)
        position += random.normal(size=(sides, 3)) * spread * 0.3
        ring = np.stack([np.arange(sides), (np.arange(sides) + 1) % sides], axis=1).astype(np.int32)
        normals = np.cross(position[ring[:, 0]], position[ring[:, 1]])
        normals /= np.linalg.norm(normals, axis=1)[:, np.newaxis]
        depth = deepest(normals)
        direction = random.normal(size=3)
        found = find_inner_direction(position, ring, sides, direction)
        if found:
            assert np.linalg.norm(direction) == pytest.approx(1.0)
            assert (normals @ direction).min() > 0
            # the cube's corners are at √3: an x of the linear programme may be that much longer
            assert (normals @ direction).min() <= depth * (1 + 1e-9)
        if depth <= 0:
            assert not found
        if depth > 0.1:
            assert found
            # well inside: at least a third of the largest depth
            assert (normals @ direction).min() > depth / 3 / np.sqrt(3)

    def test_finds_the_axis_of_a_regular_ring_from_anywhere(self):
        turn = np.arange(6) * np.pi / 3
        position = np.stack([np.cos(turn), np.sin(turn), np.ones(6)], axis=1)
        ring = np.stack([np.arange(6), (np.arange(6) + 1) % 6], axis=1).astype(np.int32)
        for start in [(0, 0, 1), (0, 0, -1), (1, 0, 0), (-3, 2, -5)]:
            direction = np.array(start, float)
            assert find_inner_direction(position, ring, 6, direction)
            np.testing.assert_allclose(direction, (0, 0, 1), atol=0.05)

    def test_there_is_none_for_opposite_pairs(self):
        position = np.array([(1, 0, 1), (0, 1, 1), (-1, 0, 1)], float)
        ring = np.array([(0, 1), (1, 0), (1, 2)], np.int32)
        assert not find_inner_direction(position, ring, 3, np.array([0.0, 0.0, 1.0]))

    def test_there_is_none_where_a_side_of_the_ring_points_at_the_centre(self):
        position = np.array([(1, 0, 1), (2, 0, 2), (-1, 0, 1)], float)
        ring = np.array([(0, 1), (1, 2), (2, 0)], np.int32)
        assert not find_inner_direction(position, ring, 3, np.array([0.0, 0.0, 1.0]))

    def test_there_is_none_from_no_direction(self):
        turn = np.arange(6) * np.pi / 3
        position = np.stack([np.cos(turn), np.sin(turn), np.ones(6)], axis=1)
        ring = np.stack([np.arange(6), (np.arange(6) + 1) % 6], axis=1).astype(np.int32)
        assert not find_inner_direction(position, ring, 6, np.zeros(3))


class TestSurface:
    def test_every_corner_faces_the_edge_of_the_other_two(self, surface_from, bumpy_mesh, edges_of):
        positions, faces = bumpy_mesh(3)
        surface = surface_from(positions, faces)
        edges = edges_of(faces)
        assert len(surface.corner_facing) == len(edges) == 3 * len(faces) // 2
        named = {}
        for corner, edge in enumerate(surface.edge_of.tolist()):
            face = faces[corner // 3].tolist()
            del face[corner % 3]
            assert named.setdefault(edge, tuple(sorted(face))) == tuple(sorted(face))
        assert sorted(named.values()) == edges
        for edge, corner in enumerate(surface.corner_facing.tolist()):
            assert surface.edge_of[corner] == edge
        for vertex, corner in enumerate(surface.corner_at.tolist()):
            assert surface.vertex[corner] == vertex

    def test_its_arrays_are_its_own(self, surface_from, bumpy_mesh):
        positions, faces = bumpy_mesh(3)
        surface = surface_from(positions, faces)
        assert not np.shares_memory(surface.position, positions)
        assert not np.shares_memory(surface.vertex, faces)

    def test_knows_the_number_of_edges_at_each_vertex(self, surface_from, bumpy_mesh):
        positions, faces = bumpy_mesh(3)
        surface = surface_from(positions, faces)
        counted = [len(neighbours(faces, vertex)) for vertex in range(len(positions))]
        assert surface.degree.tolist() == counted
        assert surface.deficit.tolist() == [0.0, 0.0]
