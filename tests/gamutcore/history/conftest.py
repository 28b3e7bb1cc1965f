"""Fixtures of the tests of histories."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from gamutcore.geometry import TriangleMesh
from gamutcore.history import History, history_bytes

if TYPE_CHECKING:
    from collections.abc import Callable


@pytest.fixture(scope="session")
def note() -> dict[str, str]:
    """Return metadata of the caller with characters beyond ASCII."""
    return {"note": "größer\nals 🎨"}


@pytest.fixture(scope="session")
def file(small_history: History, note: dict[str, str]) -> bytes:
    """Return the bytes of a small history."""
    return history_bytes(small_history, note)


@pytest.fixture(scope="session")
def shifting_history(small_history: History) -> History:
    """Return a history whose splits also move neighbours, by a few steps of the grid."""
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


@pytest.fixture(scope="session")
def first_levels() -> Callable[[History, int], History]:
    """Return a function that cuts a history off after a number of vertices."""

    def beginning(history: History, vertices: int) -> History:
        splits, steps = history.splits, vertices - 4
        columns = {
            name: array[:steps]
            for name, array in splits._asdict().items()
            if not name.startswith(("base", "moved", "shifted"))
        }
        for end, names in (
            ("moved_end", ["moved"]),
            ("shifted_end", ["shifted", "shifted_coarse", "shifted_fine"]),
        ):
            columns[end] = getattr(splits, end)[:steps]
            length = int(columns[end][-1]) if steps else 0
            columns |= {name: getattr(splits, name)[:length] for name in names}
        return History(splits._replace(**columns), history.centre, history.step)

    return beginning


@pytest.fixture(scope="session")
def double_pyramid() -> Callable[[int], TriangleMesh]:
    """Return a function that makes a double pyramid with a given number of vertices on its rim."""

    def body(rim: int) -> TriangleMesh:
        turn = 2 * np.pi * np.arange(rim) / rim
        around = np.stack([50 * np.cos(turn), 50 * np.sin(turn), np.zeros(rim)], axis=1)
        one, other = np.arange(rim), (np.arange(rim) + 1) % rim
        above = np.stack([one, other, np.full(rim, rim)], axis=1)
        below = np.stack([other, one, np.full(rim, rim + 1)], axis=1)
        return TriangleMesh(
            np.vstack([around, (0, 0, 50), (0, 0, -50)]),
            np.vstack([above, below]).astype(np.int32),
        )

    return body
