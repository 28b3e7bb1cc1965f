"""Errors: one hierarchy, stable codes, and pickling without loss."""

import json
import pickle
import re

import pytest

from gamutcore import errors
from gamutcore.errors import CharacterisationError, GamutError, InvalidPointsError, OptionError

KINDS = [getattr(errors, name) for name in errors.__all__]


def test_all_errors_of_the_module_are_public():
    defined = {
        name
        for name, value in vars(errors).items()
        if isinstance(value, type) and issubclass(value, Exception)
    }
    assert defined == set(errors.__all__)


def test_one_clause_catches_them_all():
    assert all(issubclass(kind, GamutError) for kind in KINDS)


def test_codes_are_words_and_each_names_one_error():
    codes = [kind.code for kind in KINDS]
    assert len(set(codes)) == len(codes)
    assert all(re.fullmatch(r"[a-z]+(-[a-z]+)*", code) for code in codes)
    assert all("code" in vars(kind) for kind in KINDS)


def test_released_codes_keep_their_meaning():
    """Clients and the service's problem documents refer to the codes."""
    assert {kind.__name__: kind.code for kind in KINDS} == {
        "GamutError": "gamut-error",
        "OptionError": "invalid-option",
        "CharacterisationError": "invalid-characterisation",
        "UnrecognisedFormatError": "unrecognised-format",
        "MalformedFileError": "malformed-file",
        "MissingColumnError": "missing-column",
        "ConditionError": "measurement-condition",
        "SampleLimitError": "too-many-samples",
        "MalformedProfileError": "malformed-profile",
        "UnsupportedProfileError": "unsupported-profile",
        "PictureSizeError": "picture-too-large",
        "ReferenceNameError": "unknown-reference",
        "UnsupportedPictureError": "unsupported-picture",
        "InvalidPointsError": "invalid-points",
        "TooFewPointsError": "too-few-points",
        "FlatPointsError": "flat-points",
        "CentreError": "centre-outside",
        "BoundaryError": "boundary-failed",
        "MeshError": "invalid-mesh",
        "DecimationError": "decimation-stalled",
        "NeighbourLimitError": "too-many-neighbours",
        "TriangleCountError": "triangle-count",
        "HistoryFileError": "malformed-history",
    }


def test_kinds_of_bad_input_share_a_base():
    for kind in (errors.TooFewPointsError, errors.FlatPointsError, errors.CentreError):
        assert issubclass(kind, InvalidPointsError)
    for kind in (errors.MalformedFileError, errors.MissingColumnError, errors.SampleLimitError):
        assert issubclass(kind, CharacterisationError)


@pytest.mark.parametrize("kind", KINDS)
def test_an_error_survives_pickling(kind):
    error = kind("wrong: ∆E", where={"line": 3, "columns": ["a", "b"]}, remedy="right")
    copy = pickle.loads(pickle.dumps(error))  # noqa: S301
    assert type(copy) is kind
    assert (copy.message, copy.where, copy.remedy) == (error.message, error.where, error.remedy)
    assert str(copy) == "wrong: ∆E"


def test_what_is_not_said_is_empty():
    error = GamutError("wrong")
    assert (error.message, error.where, error.remedy) == ("wrong", {}, "")


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


def test_where_is_the_errors_own():
    where = {"field": "gamma"}
    error = GamutError("wrong", where=where)
    where["field"] = "centre"
    assert error.where == {"field": "gamma"}
    assert json.dumps(error.where)
