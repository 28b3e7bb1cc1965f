from __future__ import annotations

from itertools import combinations, product

import numpy as np
import pytest


@pytest.fixture
def uniform_surface():
    """Device values on all two-dimensional faces of the unit cube, `steps` along each edge."""

    def points(channels, steps):
        values = np.linspace(0.0, 1.0, steps)
        face = np.stack(np.meshgrid(values, values), axis=-1).reshape(-1, 2)
        found = []
        for axes in combinations(range(channels), 2):
            for ends in product((0.0, 1.0), repeat=channels - 2):
                rows = np.empty((len(face), channels))
                rows[:, [axis for axis in range(channels) if axis not in axes]] = ends
                rows[:, list(axes)] = face
                found.append(rows)
        return np.unique(np.concatenate(found), axis=0)

    return points
