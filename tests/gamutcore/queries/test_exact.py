"""Signs of determinants, compared with rational arithmetic."""

from fractions import Fraction

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from gamutcore.queries.exact import TERMS, add_product, orientation, sign_of


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
        found = orientation(*map(float, (*a, *b, *c, *p)), terms)
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
            assert orientation(*a, *b, *c, *point, terms) == 0

    def test_of_magnitudes_far_apart(self, orientation_of):
        corners = np.array([(1e20, 0, 1), (0, 1e-20, 1), (1, 1, 1e-30)])
        for point in ((0, 0, 0), (1e20, 1e-20, 1e-30), (1e60, 1.0, -1e60)):
            self.check(orientation_of, *corners, point)
