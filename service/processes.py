"""What this process and those that it started use of the machine, as Linux tells it in ``/proc``.

Where there is no ``/proc``, nothing is known and nothing is said.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import NamedTuple

__all__ = ["Usage", "children_usage"]

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


def children_usage() -> Usage | None:
    """Return what the processes use that this one has started; None if that cannot be known."""
    children = _children()
    if children is None:
        return None
    times = os.times()
    count, resident, cpu = 0, 0, times.children_user + times.children_system
    for child in children:
        try:
            stat = (Path("/proc") / child / "stat").read_text()
        except (FileNotFoundError, ProcessLookupError):
            continue  # ended since
        # The name, in parentheses, may hold anything; proc(5) numbers the fields from 1.
        fields = stat.rpartition(")")[2].split()
        count += 1
        cpu += (int(fields[11]) + int(fields[12])) / _TICKS
        resident += int(fields[21]) * _PAGE
    return Usage(count, resident, cpu)


def _children() -> list[str] | None:
    found: list[str] = []
    try:
        for task in Path("/proc/self/task").iterdir():
            found += (task / "children").read_text().split()
    except FileNotFoundError:
        # a thread that has ended, or a kernel without this file
        return found or None
    except OSError:
        return None
    return found
