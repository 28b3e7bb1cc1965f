from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gamutcore.colours.declared_observer import declared_observer


@pytest.mark.parametrize(
    ("text", "observer"),
    [
        ("1931_2", "2"),  # Argyll, `spotread -Q`; DisplayCAL writes the same
        ("1964_10", "10"),
        ("2", "2"),
        ("10.0", "10"),
        ("2 degree", "2"),
        ("10deg", "10"),
        ("2°", "2"),
        ("2\ufffd", "2"),
        ("2_Degree", "2"),  # CxF3
        ("10º", "10"),
        ("CIE 1931", "2"),
        ("CIE 1964", "10"),
        ("CIE 15:2004, 2 degree", "2"),
        ("two", "2"),
        ("TEN", "10"),
        ("D50/2", "2"),
        ("D65/10", "10"),
        ("1955_2", None),
        ("1955_10", None),
        ("1978_2", None),
        ("2012_2", None),
        ("2012_10", None),
        ("shaw", None),
        ("Judd-Vos", None),
        ("CIE 170-2:2015 10 degree", None),
        ("CIE 1931 10 degree", None),
        ("2 10", None),
        ("0.2", None),
        ("4", None),
        ("", None),
        ("9" * 10_000, None),
    ],
)
def test_spellings(text, observer):
    assert declared_observer(text) == observer


@given(st.text())
def test_any_text_is_one_of_two_observers_or_none(text):
    assert declared_observer(text) in {"2", "10", None}
