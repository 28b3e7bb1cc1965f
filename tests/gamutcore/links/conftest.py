"""Fixtures of the tests of links and profiles."""

import pytest

from gamutcore.links import table


@pytest.fixture(autouse=True)
def few_inputs(request, monkeypatch):
    """Measure the errors of tables at fewer device values, but for the slow tests."""
    if request.node.get_closest_marker("slow") is None:
        monkeypatch.setattr(table, "INPUTS", 1000)
        monkeypatch.setattr(table, "EDGE_INPUTS", 300)
