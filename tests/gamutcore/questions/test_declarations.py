"""Declarations of questions agree with the functions that answer, and with the client."""

import inspect

import pytest
from gamutclient.gamuts import Level, RemoteGamut
from gamutclient.gamuts import Question as Asked

from gamutcore.questions import QUESTIONS

METHODS = {"comparisons": "compare"}
"""Methods of the client whose names are not those of the questions."""

RENAMED = {"lightness": "L"}
"""Parameters of `slice` that the methods name as colour scientists do."""


def defaults(function):
    return {
        name: None if each.default is inspect.Parameter.empty else each.default
        for name, each in inspect.signature(function).parameters.items()
    }


@pytest.mark.parametrize("question", QUESTIONS.values(), ids=QUESTIONS)
def test_functions_take_the_declared_parameters(question):
    taken = defaults(question.function)
    for each in question.all_parameters:
        assert taken[each.name] == each.default, each.name
    if question.picture is not None:
        drawn = defaults(question.picture)
        assert all(drawn[each.name] == each.default for each in question.all_parameters)


@pytest.mark.parametrize("question", QUESTIONS.values(), ids=QUESTIONS)
def test_the_client_has_the_declared_parameters(question):
    taken = defaults(getattr(RemoteGamut, METHODS.get(question.name, question.name)))
    assert {"triangles", "max_error"} <= set(Level.__annotations__)
    shared = {*Level.__annotations__, *Asked.__annotations__}
    for each in question.parameters:
        # of `contains`, the client has a method for each column
        if each.name in shared or (question.name == "contains" and each.name != "tolerance"):
            continue
        name = RENAMED.get(each.name, each.name) if question.name == "slice" else each.name
        assert taken[name] == each.default, name
