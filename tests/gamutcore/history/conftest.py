"""Fixtures of the tests of histories."""

from __future__ import annotations

import numpy as np
import pytest

from gamutcore.history import History


@pytest.fixture(scope="session")
def shifting_history(small_history: History) -> History:
    """Return a history in which neighbours of a split move with it, by a few steps of the grid."""
    random = np.random.default_rng(5)
    splits, step = small_history.splits, small_history.step
    position = np.zeros((splits.vertices, 3), np.float32)
    position[:4] = splits.base_positions
    coarse = np.empty_like(splits.coarse)
    ends, shifted, before, after = [], [], [], []
    for split, parent in enumerate(splits.parent.tolist()):
        coarse[split] = position[parent]
        position[parent], position[split + 4] = splits.fine[split], splits.added[split]
        level = small_history.level(2 * split + 4).faces
        ring = np.unique(level[(level == parent).any(axis=1)])
        for neighbour in ring[ring != parent].tolist():
            if split % 3 and random.random() < 0.4:
                shifted.append(neighbour)
                before.append(position[neighbour].copy())
                position[neighbour] += np.float32(step) * random.integers(-9, 10, 3)
                after.append(position[neighbour].copy())
        ends.append(len(shifted))
    return History(
        splits._replace(
            coarse=coarse,
            shifted_end=np.array(ends, np.int32),
            shifted=np.array(shifted, np.int32),
            shifted_coarse=np.array(before, np.float32),
            shifted_fine=np.array(after, np.float32),
        ),
        small_history.centre,
        step,
    )
