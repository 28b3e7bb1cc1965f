"""Memory and CPU time of the descendants of a process, from Linux's ``/proc``.

Without ``/proc`` nothing is reported.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import NamedTuple

__all__ = ["Usage", "descendants_usage"]

_PAGE = os.sysconf("SC_PAGE_SIZE")
_TICKS = os.sysconf("SC_CLK_TCK")

_OF_ITSELF, _OF_ENDED, _RESIDENT = slice(10, 12), slice(12, 14), 20
"""Indices into the numbers of ``/proc/<pid>/stat`` (fields 14 to 17 and 24 in proc(5)): CPU time of
the process, CPU time of its ended children, and resident pages."""


class Usage(NamedTuple):
    """Resource use of processes.

    Shared pages count once per process in `resident_bytes`. `cpu_seconds` includes ended processes.
    """

    processes: int
    resident_bytes: int
    cpu_seconds: float


def descendants_usage(root: str = "self") -> Usage | None:
    """Return memory and CPU time of all descendants of a process, without the process itself.

    The result is None if the system does not report them.
    """
    own, waiting = _fields(root), _children(root)
    if own is None or waiting is None:
        return None
    count, resident, ticks = 0, 0, sum(own[_OF_ENDED])
    while waiting:
        process = waiting.pop()
        fields = _fields(process)
        if fields is None or process == str(os.getpid()):
            continue  # it has ended
        count += 1
        ticks += sum(fields[_OF_ITSELF]) + sum(fields[_OF_ENDED])
        resident += fields[_RESIDENT] * _PAGE
        waiting += _children(process) or []
    return Usage(count, resident, ticks / _TICKS)


def _fields(process: str) -> list[int] | None:
    """Return the numbers in ``/proc/<pid>/stat``; None if the process has ended."""
    try:
        stat = (Path("/proc") / process / "stat").read_text()
    except OSError:
        return None
    # The name in parentheses may contain anything. One letter and numbers follow.
    return [int(field) for field in stat.rpartition(")")[2].split()[1:]]


def _children(process: str) -> list[str] | None:
    """Return the ids of the children of a process; None if the kernel does not report them."""
    children: list[str] = []
    try:
        for task in (Path("/proc") / process / "task").iterdir():
            children += (task / "children").read_text().split()
    except OSError:
        # A thread ended meanwhile, or the kernel lacks this file.
        return children or None
    return children
