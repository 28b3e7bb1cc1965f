"""Meshes that the export tests write."""

import pytest

PROVENANCE = {
    "title": "Fotopapier „glänzend“ — 印刷",
    "conditions": "D50,\r\n2°\tM1",
    "comment end_header": "end_header\nelement vertex 0",
}


@pytest.fixture(scope="session")
def provenance():
    """Return entries with difficult text: line breaks, other scripts, keywords of formats."""
    return dict(PROVENANCE)


@pytest.fixture(scope="session", params=[4, 10, 1000])
def level(request, press_gamut):
    """Return a level of a real press."""
    return press_gamut.history.level(request.param)
