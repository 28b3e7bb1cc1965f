"""Declarations of questions agree with the functions that answer."""

import inspect

import pytest

from gamutcore.questions import QUESTIONS


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
