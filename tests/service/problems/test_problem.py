import json

import pytest

from gamutcore import errors
from service.problems.kinds import KINDS
from service.problems.problem import JsonResponse, Problem, problem_response, sentence

ERRORS = [getattr(errors, name) for name in errors.__all__]


@pytest.mark.parametrize("error", ERRORS)
def test_every_error_of_gamutcore_is_a_client_error_with_its_own_row(error):
    assert 400 <= KINDS[error.code].status < 500
    document = Problem.from_error(error("m", where={"line": 3}, remedy="r")).document()
    assert document["type"] == f"/problems/{error.code}"
    assert (document["detail"], document["where"], document["remedy"]) == ("M.", {"line": 3}, "R.")


@pytest.mark.parametrize(
    ("said", "told"),
    [
        ("the points are flat", "The points are flat."),
        ("surface_samples is 3", "surface_samples is 3."),
        ("'x' is no cost", "'x' is no cost."),
        ("Send the whole file.", "Send the whole file."),
        ("one of:", "One of:"),
        ("", ""),
    ],
)
def test_what_exceptions_say_is_told_in_sentences(said, told):
    assert sentence(said) == sentence(told) == told


def test_codes_are_distinct_names_for_addresses():
    assert all(code.replace("-", "").isalpha() and code.islower() for code in KINDS)
    assert all(kind.title and kind.remedy and kind.detail for kind in KINDS.values())


def test_a_remedy_is_never_empty():
    assert Problem("not-found", "d").document()["remedy"] == KINDS["not-found"].remedy


def test_an_unknown_code_is_still_a_problem():
    assert Problem("from-a-newer-worker", "d").document()["code"] == errors.GamutError.code


def test_no_cache_keeps_a_problem():
    response = problem_response(Problem("queue-full", "d", headers={"Retry-After": "5"}))
    assert response.status_code == 429
    assert response.media_type == "application/problem+json"
    assert response.headers["cache-control"] == "no-store"
    assert response.headers["retry-after"] == "5"


@pytest.mark.parametrize("code", ["missing-column", "overloaded"])
def test_what_is_particular_to_a_problem_can_be_kept(code):
    problem = Problem(code, "d", {"line": 3}, "r")
    again = Problem.from_mapping(json.loads(json.dumps(problem.to_mapping())))
    assert again.document() == problem.document()
    assert ("Retry-After" in again.headers) == (again.kind.status == 503)


@pytest.mark.parametrize("text", ["plain", "\ud800", "é\n\0", "\U0001f308"])
def test_any_text_comes_back_from_one_line_of_ascii(text):
    response = JsonResponse({text: [text]})
    body = bytes(response.body)
    assert body.isascii()
    assert body.endswith(b"\n")
    assert body.count(b"\n") == 1
    assert json.loads(body) == {text: [text]}
    assert response.headers["content-length"] == str(len(body))


def test_what_json_cannot_express_is_not_sent():
    with pytest.raises(ValueError, match="JSON"):
        JsonResponse({"volume": float("nan")})
