"""How far a running kernel is, told by a thread that looks at its counter.

The kernel holds no lock of the interpreter and knows nothing of whoever watches it: it only counts.
What it counts is worth more in some parts of its work than in others.
"""

from __future__ import annotations

import contextlib
import threading
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from gamutcore.arrays import LongArray

__all__ = ["Course", "watched"]

_INTERVAL = 0.1
"""Seconds between two looks: what a person can tell apart."""


class Course:
    """How far something is that is done in parts.

    Parameters
    ----------
    parts : sequence of (int, float)
        How far each of them is counted, and how much work it is.
    """

    def __init__(self, parts: Sequence[tuple[int, float]]) -> None:
        self._parts = iter(parts)
        self._total = sum(work for _, work in parts)
        # replaced as a whole, for another thread looks at it
        self._present = (0.0, 0, 0.0, np.zeros(1, np.int64))

    def next_part(self) -> LongArray:
        """Begin the next part, and return what is to be counted in there."""
        before, _, work, _ = self._present
        done = np.zeros(1, np.int64)
        self._present = (before + work, *next(self._parts), done)
        return done

    def done(self) -> float:
        """Return the part of all work that has been done."""
        before, count, work, done = self._present
        here = min(int(done[0]) / count, 1.0) * work if count > 0 else 0.0
        return min((before + here) / self._total, 1.0) if self._total > 0.0 else 1.0


@contextlib.contextmanager
def watched(done: Callable[[], float], progress: Callable[[float], None] | None) -> Iterator[None]:
    """Tell how far a kernel is while it runs.

    Parameters
    ----------
    done : callable
        Returns what part is done; called in another thread.
    progress : callable or None
        Called with the part that is done, in a thread of its own, never before the context is
        entered nor after it is left. What it raises is raised on leaving.
    """
    if progress is None:
        yield
        return
    over = threading.Event()
    faults: list[BaseException] = []

    def look() -> None:
        try:
            while not over.wait(_INTERVAL):
                progress(done())
        except BaseException as error:  # noqa: BLE001 - raised in the thread that it concerns
            faults.append(error)

    looking = threading.Thread(target=look, name="progress", daemon=True)
    looking.start()
    try:
        yield
    finally:
        over.set()
        looking.join()
    if faults:
        raise faults[0]
