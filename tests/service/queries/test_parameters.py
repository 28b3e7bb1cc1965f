import pytest

from gamutcore.option_types import Choice, Number, Vector, WholeNumber
from service.problems.problem import ProblemError
from service.queries.parameters import Boolean, Parameter, query_values, values_of

PARAMETERS = (
    Parameter("triangles", (WholeNumber(4, 100),), "A count.", example=10),
    Parameter("tolerance", (Number(0, 5),), "A distance.", 0.5),
    Parameter("distance", (Boolean(),), "Whether.", default=False),
    Parameter("metric", (Choice(("euclidean", "ciede2000")),), "Which.", "euclidean"),
    Parameter("focus", (Choice(("cusp",)), Vector()), "Where to.", "cusp", [50, 0, 0]),
)


def given(query):
    pairs = [tuple(part.split("=")) for part in query.split("&")] if query else []
    return query_values(PARAMETERS, pairs)


@pytest.mark.parametrize(
    ("query", "values"),
    [
        ("", {}),
        ("triangles=10&tolerance=1e-2", {"triangles": 10, "tolerance": 0.01}),
        ("distance=true&metric=CIEDE2000", {"distance": True, "metric": "ciede2000"}),
        ("focus=cusp", {"focus": "cusp"}),
        ("focus=50,-1.5,2e1", {"focus": (50.0, -1.5, 20.0)}),
    ],
)
def test_texts_of_a_query_become_values(query, values):
    assert given(query) == values


@pytest.mark.parametrize(
    ("query", "field"),
    [
        ("triangles=3", "triangles"),
        ("triangles=+10", "triangles"),
        ("triangles=10.0", "triangles"),
        ("triangles=\u0661\u0660", "triangles"),
        ("tolerance=nan", "tolerance"),
        ("tolerance=1_0", "tolerance"),
        ("tolerance=6", "tolerance"),
        ("distance=1", "distance"),
        ("metric=cie", "metric"),
        ("focus=1,2", "focus"),
        ("trianglez=10", "trianglez"),
        ("triangles=10&triangles=10", "triangles"),
    ],
)
def test_others_are_refused_by_name(query, field):
    with pytest.raises(ProblemError) as caught:
        given(query)
    problem = caught.value.problem
    assert problem.code == "invalid-parameter"
    assert problem.where == {"in": "query", "field": field}
    assert problem.remedy


def test_members_of_a_body_are_values_already():
    values = values_of(PARAMETERS, {"triangles": 10}, {"distance": True, "focus": [1, 2, 3]})
    assert values == {
        "triangles": 10,
        "tolerance": 0.5,
        "distance": True,
        "metric": "euclidean",
        "focus": (1.0, 2.0, 3.0),
    }


@pytest.mark.parametrize(
    ("query", "body", "place"),
    [
        ({"triangles": 10}, {"triangles": 10}, "query"),
        ({}, {"triangles": "10"}, "body"),
        ({}, {"triangles": True}, "body"),
        ({}, {"distance": 1}, "body"),
        ({}, {"tolerance": None}, "body"),
    ],
)
def test_a_value_of_another_type_or_in_two_places_is_refused(query, body, place):
    with pytest.raises(ProblemError) as caught:
        values_of(PARAMETERS, query, body)
    assert caught.value.problem.where["in"] == place


def test_misspelled_choices_get_a_near_match():
    with pytest.raises(ProblemError) as caught:
        given("metric=euclidian")
    assert "Did you mean 'euclidean'?" in caught.value.problem.remedy


def test_the_documentation_has_types_bounds_and_defaults():
    documented = {entry["name"]: entry for entry in (each.documentation() for each in PARAMETERS)}
    assert documented["triangles"]["schema"] == {"type": "integer", "minimum": 4, "maximum": 100}
    assert documented["tolerance"]["schema"]["default"] == 0.5
    assert documented["distance"]["schema"] == {"type": "boolean", "default": False}
    assert documented["focus"]["schema"]["anyOf"][1]["maxItems"] == 3
    assert documented["focus"]["explode"] is False
    assert PARAMETERS[3].member()["enum"] == ["euclidean", "ciede2000"]
