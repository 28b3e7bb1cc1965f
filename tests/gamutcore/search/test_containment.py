"""In gamut and its exact predicates: rational arithmetic, a cube, a sphere and winding numbers."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gamutcore.geometry import TERMS, add_product, orientation, sign_of
from gamutcore.search import build_index, contains

COORDINATE = st.one_of(
    st.sampled_from([-1.0, 1.0, 0.0, np.nextafter(1.0, 2.0), -np.nextafter(1.0, 2.0)]),
    st.floats(-2, 2).map(lambda value: 0.0 if abs(value) < 1e-80 else value),
)


class TestContains:
    @given(point=st.tuples(COORDINATE, COORDINATE, COORDINATE))
    def test_of_a_cube_is_a_comparison_of_coordinates(self, cube, point):
        (found,) = contains([point], cube)
        assert found == (max(map(abs, point)) <= 1)

    @pytest.mark.parametrize("count", [4, pytest.param(20, marks=pytest.mark.slow)])
    def test_near_edges_vertices_and_faces_is_what_rational_arithmetic_says(
        self, rough, exact_inside, count
    ):
        level = vertices, faces, centre = rough(7, 24)
        index = build_index(*level)
        random = np.random.default_rng(5)
        corners = vertices.astype(np.float64)[faces]
        shares = np.concatenate(
            [random.dirichlet(np.ones(3), count), [(1, 0, 0), (0.5, 0.5, 0), (0.25, 0, 0.75)]]
        )
        points = np.einsum("sc,fcx->fsx", shares, corners[:12]).reshape(-1, 3)
        radial = centre + (points - centre) * (
            1 + 2.0**-52 * random.integers(-4, 5, (len(points), 1))
        )
        for near in (points, np.nextafter(points, centre), radial):
            expected = [exact_inside(point, level) for point in near]
            assert contains(near, index).tolist() == expected
            assert 0 < sum(expected) < len(expected)

    def test_vertices_are_inside_and_so_is_the_centre(self, rough):
        vertices, faces, centre = rough(8, 300)
        assert contains(vertices, (vertices, faces, centre)).all()
        near = centre + np.vstack([np.zeros(3), 1e-13 * np.eye(3), -1e-300 * np.eye(3)])
        assert contains(near, (vertices, faces, centre)).all()

    def test_near_a_centre_that_a_face_nearly_touches(self, cube, exact_inside):
        """The direction of a point so near is rounded by degrees."""
        vertices, faces, _ = cube
        level = vertices, faces, np.array([1 - 1e-9, 0.3, 0.3])
        random = np.random.default_rng(0)
        points = level[2] + random.normal(0, 1e-9, (40, 3))
        expected = [exact_inside(point, level) for point in points]
        assert contains(points, level).tolist() == expected
        assert 0 < sum(expected) < 40

    def test_near_such_a_centre_on_the_planes_between_cones(self, cube, exact_inside):
        """The points are exact: 2⁻¹² of the way to the vertices and to middles of edges."""
        vertices, faces, _ = cube
        centre = np.array([1 - 2.0**-20, 0.25, 0.25])
        ends = np.vstack([vertices, (vertices[faces] + vertices[np.roll(faces, 1, 1)])[:, 0] / 2])
        points = centre + 2.0**-12 * (ends - centre)
        level = vertices, faces, centre
        assert all(exact_inside(point, level) for point in points)
        assert contains(points, level).all()

    def test_of_a_fine_sphere_is_a_comparison_of_radii(self, rough):
        vertices, faces, centre = rough(9, 3000, 0.0)
        random = np.random.default_rng(1)
        points = centre + random.uniform(-80, 80, (20_000, 3))
        radius = np.linalg.norm(points - centre, axis=1)
        # the farthest that a face of the inscribed polyhedron is from the sphere
        corners = vertices[faces] - centre
        depth = 40 - np.linalg.norm(corners.mean(axis=1), axis=1).min() + 0.1
        clear = (radius < 40 - depth) | (radius > 40 + 1e-5)
        np.testing.assert_array_equal(
            contains(points[clear], (vertices, faces, centre)), radius[clear] < 40
        )

    @pytest.mark.slow
    def test_of_a_press_is_what_winding_numbers_say(self, fogra39_gamut):
        """A closed surface winds once around a point inside, and not around others."""
        level = fogra39_gamut.level(2000)
        points = np.random.default_rng(4).uniform(*level.bounds, (1000, 3))
        angle = np.zeros(len(points))
        for row, point in enumerate(points):
            a, b, c = level.corners(point)
            u, v, w = (np.linalg.norm(each, axis=1) for each in (a, b, c))
            cosines = u * v * w + (a * b).sum(1) * w + (b * c).sum(1) * u + (c * a).sum(1) * v
            angle[row] = 2 * np.arctan2(level.determinants(point), cosines).sum()
        found = contains(points, (level.vertices, level.faces, fogra39_gamut.history.centre))
        np.testing.assert_allclose(found, angle / (4 * np.pi), atol=1e-6)
        assert 100 < found.sum() < 900

    def test_far_points_are_outside(self, cube):
        assert not contains(np.diag([1e60, -1e60, 1e30]), cube).any()


def sign(value):
    return int(value > 0) - int(value < 0)


class TestAddProduct:
    @settings(max_examples=50, deadline=None)
    @given(st.lists(st.tuples(*[st.floats(-1e6, 1e6, width=32)] * 3), min_size=1, max_size=12))
    def test_sums_of_products_have_no_error(self, products):
        terms, count, expected = np.empty(TERMS), 0, Fraction(0)
        for product in products:
            if all(abs(value) > 1e-30 for value in product):
                count = add_product(terms, count, *product)
                expected += Fraction(product[0]) * Fraction(product[1]) * Fraction(product[2])
        assert sum(map(Fraction, terms[:count].tolist()), Fraction(0)) == expected
        assert sign(sign_of(terms, count)) == sign(expected)


class TestOrientation:
    def check(self, orientation_of, a, b, c, p):
        terms = np.empty(TERMS)
        found = orientation(*(tuple(map(float, each)) for each in (a, b, c, p)), terms)
        assert sign(found) == sign(orientation_of(a, b, c, p))

    def test_of_points_in_a_plane_and_beside_it(self, orientation_of):
        random = np.random.default_rng(1)
        for _ in range(100):
            a, b, c = random.normal(50, 20, (3, 3)).astype(np.float32)
            shares = random.dirichlet(np.ones(3))
            point = shares @ np.array([a, b, c], np.float64)
            for beside in (point, np.nextafter(point, np.inf), np.nextafter(point, -np.inf)):
                self.check(orientation_of, a, b, c, beside)

    def test_is_zero_in_a_common_plane(self, orientation_of):
        a, b, c = np.array([(0, 0, 0), (3, 0, 3), (0, 7, 7)], np.float64)
        terms = np.empty(TERMS)
        for point in (a, b, (a + b) / 2, a + b + c, 2**20 * b + c):
            assert orientation_of(a, b, c, point) == 0
            assert orientation(tuple(a), tuple(b), tuple(c), tuple(point), terms) == 0

    def test_of_magnitudes_far_apart(self, orientation_of):
        corners = np.array([(1e20, 0, 1), (0, 1e-20, 1), (1, 1, 1e-30)])
        for point in ((0, 0, 0), (1e20, 1e-20, 1e-30), (1e60, 1.0, -1e60)):
            self.check(orientation_of, *corners, point)
