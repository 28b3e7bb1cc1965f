"""Methods of the client agree with the declarations of the questions."""

import inspect

import gamutclient
import pytest
from gamutclient.gamuts import Level, Space
from gamutclient.gamuts import Question as Asked

from gamutcore.questions import QUESTIONS, SPACE
from gamutcore.questions.declarations import LEVEL_PARAMETERS

METHODS = {"colours": "to_colour", "comparisons": "compare", "recipes": "to_device"}
"""Methods of the client whose names are not those of the questions."""

CLASSIFYING = {"contains": "classify"}
"""Of `contains`, the client has a method for each column; this one has all other parameters."""

RENAMED = {
    ("slice", "lightness"): "L",
    ("crossings", "from"): "starts",
    ("crossings", "to"): "ends",
}
"""Parameters that the methods name as colour scientists do, or as Python can."""

OF_DISTANCE = {("contains", "metric")}
"""Parameters of the method `distance`, which asks another question."""


@pytest.mark.parametrize("question", QUESTIONS.values(), ids=QUESTIONS)
def test_methods_of_the_client_have_the_declared_parameters_and_summaries(question):
    """The level, and the space of the colours, are the arguments of all methods."""
    name = METHODS.get(question.name, question.name)
    asked = Asked if question.inputs else Level
    asked = Space if question.of_device else asked
    columns = {each.name for each in question.columns}  # `distance` is a method, and no parameter
    others = {other: None for other in (*question.inputs, question.other) if other}
    declared = others | {each.name: each.default for each in question.parameters}
    expected = {
        RENAMED.get((question.name, parameter), parameter): default
        for parameter, default in declared.items()
        if parameter not in {*asked.__annotations__, *columns}
        and (question.name, parameter) not in OF_DISTANCE
    }
    for method in {name, CLASSIFYING.get(name, name)}:
        _, *taken = inspect.signature(getattr(gamutclient.Gamut, method)).parameters.values()
        if question.name != "uncertainty":  # of the data, so there is no level
            *taken, rest = taken
            assert rest.annotation == f"Unpack[{asked.__name__}]"
        given = {each.name: None if each.default is each.empty else each.default for each in taken}
        assert given.items() <= expected.items()
        assert len(given) == len(expected) or method in CLASSIFYING
    assert inspect.getdoc(getattr(gamutclient.Gamut, name)).startswith(question.summary)


@pytest.mark.parametrize(("question", "parameter"), OF_DISTANCE)
def test_parameters_of_distance(question, parameter):
    assert parameter in {each.name for each in QUESTIONS[question].parameters}
    assert parameter in inspect.signature(gamutclient.Gamut.distance).parameters


def test_arguments_of_all_methods_of_the_client_are_declared():
    assert set(Level.__annotations__) == {each.name for each in LEVEL_PARAMETERS}
    assert set(Asked.__annotations__) == {*Level.__annotations__, SPACE.name}
    assert set(Space.__annotations__) == {SPACE.name}
