from __future__ import annotations

from itertools import combinations, product

import numpy as np
import pytest


@pytest.fixture
def uniform_surface():
    """Device values on all two-dimensional faces of the unit cube, `steps` along each edge."""

    def points(channels, steps):
        # by the number of a point in the lattice: rows are sorted ten times slower
        values, strides = np.arange(steps), steps ** np.arange(channels)[::-1]
        found = []
        for axes in combinations(range(channels), 2):
            face = np.add.outer(values * strides[axes[0]], values * strides[axes[1]]).ravel()
            others = np.delete(strides, axes)
            ends = product((0, steps - 1), repeat=channels - 2)
            found += [face + (others * end).sum() for end in ends]
        numbers = np.unique(np.concatenate(found))
        places = np.stack(np.unravel_index(numbers, (steps,) * channels), axis=1)
        return np.linspace(0.0, 1.0, steps)[places]

    return points
