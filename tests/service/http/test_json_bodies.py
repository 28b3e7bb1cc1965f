import pytest

from service.http.json_bodies import parse_json
from service.problems.problem import ProblemError


def test_values_are_those_of_the_text():
    assert parse_json(b'{"a": [1, 2.5, "\\u00e9"], "b": null}') == {"a": [1, 2.5, "é"], "b": None}
    assert parse_json(bytearray(b"[]")) == []


@pytest.mark.parametrize(
    ("text", "code", "place"),
    [
        (b'{"a": 1,\n "b"}', "malformed-body", {"field": "options", "line": 2, "column": 5}),
        (b'{"a": NaN}', "malformed-body", {}),
        (b"[-Infinity]", "malformed-body", {}),
        (b'"\xff"', "malformed-body", {"field": "options", "byte": 1}),
        (b"[" * 10**6, "malformed-body", {"field": "options"}),
        (b"[" + b"1" * 5000 + b"]", "malformed-body", {"field": "options"}),
        (b'{"a": {"b": 1, "b": 2}}', "invalid-body", {"field": "b"}),
    ],
)
def test_faults_have_their_place(text, code, place):
    with pytest.raises(ProblemError) as caught:
        parse_json(text, {"field": "options"})
    problem = caught.value.problem
    assert problem.code == code
    assert dict(problem.where) == place
