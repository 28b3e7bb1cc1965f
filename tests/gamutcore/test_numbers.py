"""Numbers from outside: what counts as one."""

import math
from decimal import Decimal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gamutcore.numbers import finite_number


@given(value=st.floats(allow_nan=False, allow_infinity=False))
def test_finite_floats_are_what_they_were(value):
    assert finite_number(value) == value
    assert math.copysign(1, finite_number(value)) == (-1 if value < 0 else 1)


@pytest.mark.parametrize(
    "value",
    [None, "1", True, False, math.nan, math.inf, -math.inf, 10**400, [1.0], Decimal(1), 1j],
)
def test_nothing_else_is_a_number(value):
    assert finite_number(value) is None


def test_numbers_of_numpy_are_floats_if_python_says_so():
    assert finite_number(np.float64(0.5)) == 0.5
    assert finite_number(7) == 7.0
    assert isinstance(finite_number(7), float)
