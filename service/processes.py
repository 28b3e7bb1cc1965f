"""What the processes use of the machine that this one started, as Linux tells it in ``/proc``.

Where there is no ``/proc``, nothing is known and nothing is said.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import NamedTuple

__all__ = ["Usage", "descendants_usage"]

_PAGE = os.sysconf("SC_PAGE_SIZE")
_TICKS = os.sysconf("SC_CLK_TCK")


class Usage(NamedTuple):
    """What processes use.

    Attributes
    ----------
    processes : int
        How many there are.
    resident_bytes : int
        Memory, pages that several share counted for each.
    cpu_seconds : float
        Of the processes that run now, and of those that ran before.
    """

    processes: int
    resident_bytes: int
    cpu_seconds: float


def descendants_usage() -> Usage | None:
    """Return what the processes use that this one has started, and those that they have started.

    Returns
    -------
    Usage or None
        None if that cannot be known.
    """
    waiting = _children("self")
    if waiting is None:
        return None
    times = os.times()
    count, resident, cpu = 0, 0, times.children_user + times.children_system
    while waiting:
        process = waiting.pop()
        try:
            stat = (Path("/proc") / process / "stat").read_text()
        except OSError:
            continue  # ended since
        # The name, in parentheses, may hold anything; proc(5) numbers the fields from 1.
        fields = stat.rpartition(")")[2].split()
        count += 1
        # its own, and that of its children that have ended
        cpu += sum(int(field) for field in fields[11:15]) / _TICKS
        resident += int(fields[21]) * _PAGE
        waiting += _children(process) or []
    return Usage(count, resident, cpu)


def _children(process: str) -> list[str] | None:
    """Return the ids of the processes that one has started; None if the kernel does not tell."""
    found: list[str] = []
    try:
        for task in (Path("/proc") / process / "task").iterdir():
            found += (task / "children").read_text().split()
    except OSError:
        # a thread that has ended meanwhile, or a kernel without this file
        return found or None
    return found
