"""What all questions share: the default level, and device values in faces."""

import numpy as np
import pytest

from gamutcore import Gamut
from gamutcore.answers.base import Answering

CUBE = 20 * (2.0 * np.array(list(np.ndindex(2, 2, 2))) - 1) + (50, 0, 0)


@pytest.mark.slow
def test_device_values_are_linear_in_a_face(fogra39):
    level = Gamut(fogra39, surface_samples=500).levels.indexed(triangles=50)
    corners = level.device.values[level.index.faces[7]]
    weights = np.array([(1.0, 0, 0), (0.5, 0.5, 0), (0.2, 0.3, 0.5), (np.nan, np.nan, np.nan)])
    found, channels = Answering._device(level, np.array([7, 7, 7, -1]), weights)
    assert channels == ("C", "M", "Y", "K")
    np.testing.assert_allclose(found[:3], weights[:3] @ corners, atol=1e-6)
    assert np.isnan(found[3]).all()


def test_bare_colours_have_no_device_values():
    level = Gamut(CUBE).levels.indexed(triangles=12)
    assert Answering._device(level, np.zeros(1, int), np.ones((1, 3)) / 3) == (None, ())
