"""Products and inverses of vectors and symmetric matrices, against NumPy's."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gamutcore.decimation.vectors import adjugate, cross, dot, product, quadratic_form, triple

NUMBERS = st.lists(st.floats(-100, 100), min_size=6, max_size=6)


@given(numbers=NUMBERS)
def test_the_cofactors_times_the_matrix_are_the_determinant(numbers):
    a, b, c, d, e, f = numbers
    matrix = np.array([[a, b, c], [b, d, e], [c, e, f]])
    (i, j, k, m, n, o), determinant = adjugate(tuple(numbers), 0.0)
    cofactors = np.array([[i, j, k], [j, m, n], [k, n, o]])
    scale = max(1.0, np.abs(matrix).max()) ** 3
    np.testing.assert_allclose(
        matrix @ cofactors, determinant * np.eye(3), rtol=0, atol=1e-13 * scale
    )
    assert determinant == pytest.approx(np.linalg.det(matrix), abs=1e-12 * scale)


def test_products_are_those_of_numpy():
    random = np.random.default_rng(0)
    for _ in range(20):
        a, b, c = random.normal(size=(3, 3))
        half = random.normal(size=(3, 3))
        matrix = half + half.T
        m = tuple(matrix[np.triu_indices(3)].tolist())
        one, two, three = tuple(a.tolist()), tuple(b.tolist()), tuple(c.tolist())
        assert dot(one, two) == pytest.approx(a @ b)
        np.testing.assert_allclose(cross(one, two), np.cross(a, b))
        assert triple(one, two, three) == pytest.approx(np.linalg.det([a, b, c]))
        np.testing.assert_allclose(product(m, one), matrix @ a)
        assert quadratic_form(m, one) == pytest.approx(a @ matrix @ a)
