"""Errors: one hierarchy, stable codes, and all they say survives a process border."""

import json
import pickle
import re

import pytest

from gamutcore import errors
from gamutcore.errors import CharacterisationError, GamutError, InvalidPointsError

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
    """What clients and the service's problem documents refer to."""
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
        "UnsupportedPictureError": "unsupported-picture",
        "InvalidPointsError": "invalid-points",
        "TooFewPointsError": "too-few-points",
        "FlatPointsError": "flat-points",
        "CentreError": "centre-outside",
        "BoundaryError": "boundary-failed",
        "MeshError": "invalid-mesh",
        "DecimationError": "decimation-stalled",
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


def test_where_is_the_errors_own():
    where = {"field": "gamma"}
    error = GamutError("wrong", where=where)
    where["field"] = "centre"
    assert error.where == {"field": "gamma"}
    assert json.dumps(error.where)
