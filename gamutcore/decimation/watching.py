"""How far a running kernel is, told by a thread that looks at its counter.

The kernel holds no lock of the interpreter and knows nothing of whoever watches it: it only counts.
"""

from __future__ import annotations

import contextlib
import threading
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from gamutcore.arrays import LongArray

__all__ = ["watched"]

_INTERVAL = 0.1
"""Seconds between two looks: what a person can tell apart."""


@contextlib.contextmanager
def watched(
    done: LongArray, total: int, progress: Callable[[float], None] | None
) -> Iterator[None]:
    """Tell how far a kernel is while it runs.

    Parameters
    ----------
    done : (1,) int64
        What the kernel counts in.
    total : int
        What it counts to.
    progress : callable or None
        Called with the part that is done, in a thread of its own, never before the context is
        entered nor after it is left. What it raises is raised on leaving.
    """
    if progress is None or total <= 0:
        yield
        return
    over = threading.Event()
    faults: list[BaseException] = []

    def look() -> None:
        try:
            while not over.wait(_INTERVAL):
                progress(min(int(done[0]) / total, 1.0))
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
