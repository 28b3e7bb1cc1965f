"""The results: they say how device values were found, and on which level."""

import numpy as np

from gamutcore import Gamut

CUBE = 20 * (2.0 * np.array(list(np.ndindex(2, 2, 2))) - 1) + (50, 0, 0)


def test_answers_state_their_level():
    answer = Gamut(CUBE, gamma=1).cusps(4, triangles=12)
    assert (answer.triangles, answer.max_error) == (12, 0.0)
    assert answer.device_values == "interpolated"
