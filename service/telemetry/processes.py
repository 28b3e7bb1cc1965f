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

_OF_ITSELF, _OF_ENDED, _RESIDENT = slice(10, 12), slice(12, 14), 20
"""Places among the numbers of ``/proc/<pid>/stat`` (proc(5) has them as 14 to 17, and 24): CPU time
of the process, that of its children that have ended, and pages in memory."""


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


def descendants_usage(root: str = "self") -> Usage | None:
    """Return what the processes use that one has started, and those that they have started.

    Parameters
    ----------
    root : str
        Id of the process, by default the caller. It is not counted itself, nor is the caller.

    Returns
    -------
    Usage or None
        None if that cannot be known.
    """
    own, waiting = _fields(root), _children(root)
    if own is None or waiting is None:
        return None
    count, resident, ticks = 0, 0, sum(own[_OF_ENDED])
    while waiting:
        process = waiting.pop()
        fields = _fields(process)
        if fields is None or process == str(os.getpid()):
            continue  # ended since
        count += 1
        ticks += sum(fields[_OF_ITSELF]) + sum(fields[_OF_ENDED])
        resident += fields[_RESIDENT] * _PAGE
        waiting += _children(process) or []
    return Usage(count, resident, ticks / _TICKS)


def _fields(process: str) -> list[int] | None:
    """Return the numbers that the kernel tells of a process; None if it is gone."""
    try:
        stat = (Path("/proc") / process / "stat").read_text()
    except OSError:
        return None
    # The name, in parentheses, may hold anything; a letter follows, and then only numbers.
    return [int(field) for field in stat.rpartition(")")[2].split()[1:]]


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
