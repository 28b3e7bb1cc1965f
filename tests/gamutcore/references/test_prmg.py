"""The perceptual reference medium gamut of ISO 12640-3."""

import numpy as np
import pytest

from gamutcore.colours import surface_colours
from gamutcore.geometry import TriangleMesh
from gamutcore.references import REFERENCES


def test_the_prmg_has_the_volume_that_the_reference_implementation_counts():
    """200,000 random colours below L* 95 by CIccPRMG::InGamut of iccdev 0.1.1: 1,277,811."""
    found = surface_colours(REFERENCES["prmg"])
    mesh = TriangleMesh(found.points, found.faces.corners)
    assert mesh.validity().closed
    assert mesh.volume == pytest.approx(1_277_811, rel=0.01)
    assert found.points[:, 0].min() == pytest.approx(3.5)
    assert found.points[:, 0].max() == pytest.approx(100)


def test_absolute_colours_have_the_white_of_the_medium():
    """A white that reflects 89 % has L* 95.6 (CIE 15:2018, 8.2.1)."""
    found = surface_colours(REFERENCES["prmg"], intent="absolute")
    expected = 116 * np.cbrt(0.89) - 16
    assert found.points[:, 0].max() == pytest.approx(expected, abs=1e-6)
