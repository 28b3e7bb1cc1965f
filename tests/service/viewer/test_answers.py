"""Features of the viewer in a real browser: colours, recipes, and what is dropped."""

import pytest

PROGRAMS = ("tasks", "colours", "answers", "recipes", "late", "drops")


@pytest.mark.slow
@pytest.mark.parametrize("name", PROGRAMS)
def test_answers_in_a_browser(run_in_browser, name):
    run_in_browser(name)
