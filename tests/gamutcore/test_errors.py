"""Errors: one hierarchy, stable codes, remedies as sentences, and pickling without loss."""

import ast
import pickle
import re
from pathlib import Path

import pytest

import gamutcore
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
    assert str(copy) == str(error)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("message", ["The file is empty.", "the file is empty", "Is it empty?"])
def test_the_text_of_an_error_is_its_message_and_its_remedy(kind, message):
    """Once each, also if the message has no full stop of its own."""
    ended = message if message[-1] in ".?" else f"{message}."
    assert str(kind(message, remedy="Send another file.")) == f"{ended} Send another file."


@pytest.mark.parametrize("kind", KINDS)
def test_an_error_without_a_remedy_cannot_be_made(kind):
    with pytest.raises(TypeError, match="remedy"):
        kind("The file is empty.")


def _remedies(path):
    """Yield the line and the text of each remedy that a module writes down.

    What a text is composed of is shown as "{}".
    """
    text = path.read_text("utf-8")
    if "remedy" not in text.lower():
        return
    for node in ast.walk(ast.parse(text)):
        names = []
        if isinstance(node, ast.keyword):
            names = [node.arg]
        elif isinstance(node, ast.Assign) and isinstance(node.value, ast.Constant | ast.JoinedStr):
            names = [ast.unparse(target) for target in node.targets]
        if not any(name and "remedy" in name.lower() for name in names):
            continue
        value = node.value
        if isinstance(value, ast.Constant) and value.value:
            yield value.lineno, value.value
        elif isinstance(value, ast.JoinedStr):
            parts = value.values
            yield (
                value.lineno,
                "".join(part.value if isinstance(part, ast.Constant) else "{}" for part in parts),
            )


def test_every_remedy_is_a_sentence():
    """It follows the message in the text of an error, and stands alone in a problem document."""
    package = Path(gamutcore.__file__).parent
    found = [
        (path.relative_to(package), *remedy)
        for path in sorted(package.rglob("*.py"))
        for remedy in _remedies(path)
    ]
    assert len(found) > 100
    sentence = re.compile(r"(\{\}|[A-Z]).*[.?]( \{\})?", re.DOTALL)
    assert [each for each in found if not sentence.fullmatch(each[2])] == []


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
