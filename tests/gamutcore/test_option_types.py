"""Types of option values: bounds, spellings, and what counts as a number."""

import math
from decimal import Decimal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gamutcore.errors import OptionError
from gamutcore.option_types import (
    Choice,
    Number,
    Text,
    Vector,
    WholeNumber,
    WholeNumbers,
    check_option,
    finite_number,
)


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


@given(st.floats(), st.floats(-10, 10), st.floats(0, 5), st.booleans(), st.booleans())
def test_a_number_is_within_its_bounds(value, least, extent, above, below):
    kind = Number(least, least + extent, above_least=above, below_most=below)
    accepted = kind.canonical(value) is not None
    low = value > least if above else value >= least
    high = value < least + extent if below else value <= least + extent
    assert accepted == (low and high)


@pytest.mark.parametrize("value", [0, 8, 2.0, "2", True, None])
def test_other_whole_numbers_are_refused(value):
    assert WholeNumber(1, 7).canonical(value) is None


def test_each_of_several_numbers_has_its_bounds():
    kind = WholeNumbers((WholeNumber(1, 2), WholeNumber(5, 9)), "rows and columns")
    assert kind.canonical([2, 9]) == (2, 9)
    assert kind.canonical([9, 2]) is None
    assert kind.canonical([1]) is None


@pytest.mark.parametrize("value", ["CAM16-UCS", "cam16 ucs", "Cam16UCS", "CAM16_UCS"])
def test_spellings_of_a_choice(value):
    assert Choice(("CIELAB", "CAM16-UCS")).canonical(value) == "CAM16-UCS"


def test_a_vector_is_normalised_or_refused():
    kind = Vector("a direction", lambda x, y, z: (x / y, 1.0, z / y) if y else None)
    assert kind.canonical([2, 2, 4]) == (1.0, 1.0, 2.0)
    assert kind.canonical([2, 0, 4]) is None


def test_a_text_has_a_length():
    kind = Text(3, "a code", str.upper)
    assert kind.canonical("m1") == "M1"
    assert kind.canonical("long") is None


def test_an_error_names_the_option_the_values_and_a_near_match():
    with pytest.raises(OptionError) as caught:
        check_option("basis", "octahedrn", Choice(("tetrahedron", "octahedron")))
    assert caught.value.where == {"field": "basis"}
    assert "'octahedron'" in caught.value.remedy
