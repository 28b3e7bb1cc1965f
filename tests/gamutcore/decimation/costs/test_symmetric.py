"""The inverse of symmetric matrices, against NumPy's."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gamutcore.decimation.costs.symmetric import adjugate

NUMBERS = st.lists(st.floats(-100, 100), min_size=6, max_size=6)


@given(numbers=NUMBERS)
def test_the_cofactors_times_the_matrix_are_the_determinant(numbers):
    a, b, c, d, e, f = numbers
    matrix = np.array([[a, b, c], [b, d, e], [c, e, f]])
    i, j, k, m, n, o, determinant = adjugate(*numbers)
    cofactors = np.array([[i, j, k], [j, m, n], [k, n, o]])
    scale = max(1.0, np.abs(matrix).max()) ** 3
    np.testing.assert_allclose(
        matrix @ cofactors, determinant * np.eye(3), rtol=0, atol=1e-13 * scale
    )
    assert determinant == pytest.approx(np.linalg.det(matrix), abs=1e-12 * scale)
