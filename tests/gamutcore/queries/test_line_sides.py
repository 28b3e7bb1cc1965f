"""Signs of lines and points against faces, compared with rational arithmetic."""

from fractions import Fraction

import numpy as np
import pytest

from gamutcore.queries import build_index
from gamutcore.queries.exact import TERMS
from gamutcore.queries.line_sides import exact_sides, is_below


@pytest.fixture
def index(rough):
    return build_index(*rough(21, 40))


def plain(values):
    return tuple(float(value) for value in values)


class TestExactSides:
    @pytest.mark.slow
    def test_determinants_and_directions_are_those_of_rational_numbers(self, index, orientation_of):
        """det(end − start, p − start, q − start) is the orientation of end, p, q from start."""
        random, terms = np.random.default_rng(5), np.empty(TERMS)
        for _ in range(20):
            start, end = plain(random.uniform(-60, 120, 3)), plain(random.uniform(-60, 120, 3))
            for face in range(len(index.faces)):
                corners = index.vertices[index.faces[face]]
                exact = [
                    orientation_of(end, corners[(at + 1) % 3], corners[(at + 2) % 3], start)
                    for at in range(3)
                ]
                direction, *sides = exact_sides(start, end, index, face, terms)
                signs = {1 if each > 0 else -1 for each in exact}
                if len(signs) == 2:
                    assert direction == 0
                else:
                    assert direction == signs.pop()
                    np.testing.assert_allclose(sides, [float(each) for each in exact], rtol=1e-9)

    def test_a_line_from_the_centre_through_a_vertex_leaves_by_one_face(self, index):
        """Two determinants are 0. One face gets the line, by the infinitely small change."""
        terms = np.empty(TERMS)
        centre = plain(index.centre)
        for vertex in index.vertices:
            found = [
                exact_sides(centre, plain(vertex), index, face, terms)[0]
                for face in range(len(index.faces))
            ]
            assert min(found) == -1  # behind the centre
            assert (found.count(-1), found.count(1)) == (1, 1)

    def test_the_reverse_line_has_the_opposite_direction(self, index):
        random, terms = np.random.default_rng(6), np.empty(TERMS)
        for _ in range(50):
            start, end = plain(random.uniform(0, 90, 3)), plain(random.uniform(0, 90, 3))
            for face in range(len(index.faces)):
                there = exact_sides(start, end, index, face, terms)[0]
                assert exact_sides(end, start, index, face, terms)[0] == -there


class TestIsBelow:
    @pytest.mark.slow
    def test_agrees_with_rational_numbers_next_to_the_plane(self, index, orientation_of):
        random, terms = np.random.default_rng(7), np.empty(TERMS)
        for face in range(len(index.faces)):
            corners = index.vertices[index.faces[face]]
            for _ in range(10):
                near = random.dirichlet((1, 1, 1)) @ corners
                for point in (near, np.nextafter(near, 1e3), np.nextafter(near, -1e3)):
                    exact: Fraction = orientation_of(*corners, point)
                    assert is_below(plain(point), index, face, terms) == (exact >= 0)

    def test_corners_are_below_their_face(self, index):
        terms = np.empty(TERMS)
        for face, corners in enumerate(index.faces):
            for corner in corners:
                assert is_below(plain(index.vertices[corner]), index, face, terms)
