"""Errors: one hierarchy, stable codes, and pickling without loss."""

import pickle
import re

import pytest

from gamutcore import errors
from gamutcore.errors import OptionError

KINDS = [getattr(errors, name) for name in errors.__all__]


def test_each_error_has_a_code_of_its_own():
    """Clients and the service's problem documents refer to the codes."""
    codes = [vars(kind)["code"] for kind in KINDS]
    assert len(set(codes)) == len(codes)
    assert all(re.fullmatch(r"[a-z]+(-[a-z]+)*", code) for code in codes)


@pytest.mark.parametrize("kind", KINDS)
def test_an_error_survives_pickling(kind):
    error = kind("wrong: ∆E", where={"line": 3, "columns": ["a", "b"]}, remedy="right")
    copy = pickle.loads(pickle.dumps(error))  # noqa: S301
    assert type(copy) is kind
    assert (copy.message, copy.where, copy.remedy) == (error.message, error.where, error.remedy)
    assert str(copy) == "wrong: ∆E"


def test_a_refused_option_says_its_value_and_what_is_accepted():
    error = OptionError.refusal("gamma", 2, "a number above 0, at most 1")
    assert error.message == "gamma is 2, which is not accepted."
    assert error.where == {"field": "gamma"}
    assert error.remedy == "Give a number above 0, at most 1."


def test_an_option_without_a_place_says_why():
    error = OptionError.not_applicable("popularity", 0.1, "the data is no picture")
    assert error.message == "popularity 0.1 does not apply: the data is no picture."
    assert error.where == {"field": "popularity"}
    assert error.remedy == "Leave it out."


def test_a_long_value_is_shown_in_part():
    value = "x" * 1000
    for error in (
        OptionError.refusal("space", value, "one of CIELAB, CIEXYZ"),
        OptionError.not_applicable("condition", value, "a mesh has none"),
    ):
        assert "xxx…" in error.message
        assert len(error.message) < 120
