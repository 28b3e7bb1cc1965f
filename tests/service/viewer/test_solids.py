"""Features of the viewer in a real browser: the view, its gamuts, and cuts."""

import pytest

PROGRAMS = ("static", "view", "scene", "gamuts", "layers", "flow", "slices")


@pytest.mark.slow
@pytest.mark.parametrize("name", PROGRAMS)
def test_the_view_in_a_browser(run_in_browser, name):
    run_in_browser(name)
