"""Progress of a running kernel, reported by a thread that reads the kernel's counter.

A kernel releases the interpreter lock and only counts its collapses. Collapses take more time in
some parts of the work than in others, so each part has a weight.
"""

from __future__ import annotations

import contextlib
import threading
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from gamutcore.arrays import LongArray

__all__ = ["Progress", "report_progress"]

_INTERVAL = 0.1
"""Seconds between two reports."""


class Progress:
    """Progress of work that consists of parts, each given as its final count and amount of work."""

    def __init__(self, parts: Sequence[tuple[int, float]]) -> None:
        self._parts = iter(parts)
        self._total = sum(work for _, work in parts)
        # replaced as a whole, because another thread reads it
        self._present = (0.0, 0, 0.0, np.zeros(1, np.int64))

    def begin_part(self) -> LongArray:
        """Begin the next part, and return the counter for it."""
        before, _, work, _ = self._present
        counter = np.zeros(1, np.int64)
        self._present = (before + work, *next(self._parts), counter)
        return counter

    def fraction(self) -> float:
        """Return the fraction of the work that is done."""
        before, count, work, counter = self._present
        here = min(int(counter[0]) / count, 1.0) * work if count > 0 else 0.0
        return min((before + here) / self._total, 1.0) if self._total > 0.0 else 1.0


@contextlib.contextmanager
def report_progress(
    fraction: Callable[[], float], progress: Callable[[float], None] | None
) -> Iterator[None]:
    """Report progress while the body of the context runs.

    `fraction` returns the fraction of the work that is done. `progress` is called with it in
    another thread. Leaving the context raises any exception of `progress`.
    """
    if progress is None:
        yield
        return
    ended = threading.Event()
    faults: list[BaseException] = []

    def report() -> None:
        try:
            while not ended.wait(_INTERVAL):
                progress(fraction())
        except BaseException as error:  # noqa: BLE001 - raised in the thread that it concerns
            faults.append(error)

    reporter = threading.Thread(target=report, name="progress", daemon=True)
    reporter.start()
    try:
        yield
    finally:
        ended.set()
        reporter.join()
    if faults:
        raise faults[0]
