"""The memory of the API process: its budget, and the heap of the C library."""

from __future__ import annotations

import ctypes
import os
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from service.settings import Settings

__all__ = ["PROCESS_BYTES", "keep_heap_small", "memory_budget", "return_free_pages"]

_MEBIBYTE = 1024 * 1024

PROCESS_BYTES = 224 * _MEBIBYTE
"""Memory of a process without gamuts: interpreter, libraries and kernels. Resident after start and
80 builds: 220 MB."""

LEAST_BUDGET = 448 * _MEBIBYTE
"""Smallest default of the budget: the process, and two full boundaries of a press in comparison."""

SHARE = 0.6
"""Default share of the memory of the container or computer. The rest is for other processes, bodies
and the page cache."""


def memory_budget(settings: Settings, root: Path = Path("/")) -> int:
    """Return the largest memory of the API process in bytes: the setting, or a default.

    The default is 60 % of the smallest cgroup limit (v2 and v1) or of the computer's memory, less
    the build workers' limits, at least `LEAST_BUDGET`. `root` has ``proc`` and ``sys``.
    """
    if settings.memory_bytes:
        return settings.memory_bytes
    workers = 0 if settings.broker else settings.build_workers * settings.build_memory_bytes
    return max(LEAST_BUDGET, int(SHARE * _available_memory(root)) - workers)


def _available_memory(root: Path) -> int:
    """Return the smallest limit of this process's cgroups, or the memory of the computer."""
    limits = [
        int(line.split()[1]) * 1024
        for line in _lines(root / "proc/meminfo")
        if line.startswith("MemTotal:")
    ]
    for line in _lines(root / "proc/self/cgroup"):
        _, controllers, path = line.split(":", 2)
        if controllers and "memory" not in controllers.split(","):
            continue
        mount = "sys/fs/cgroup/memory" if controllers else "sys/fs/cgroup"
        name = "memory.limit_in_bytes" if controllers else "memory.max"
        # A parent may have the limit. Inside a container, the path may not exist below the mount.
        folder = root / mount / path.lstrip("/")
        for each in (folder, *folder.parents[: len(Path(path).parts)]):
            limits += [int(text) for text in _lines(each / name) if text.isdigit()]
    return min(limits, default=0)


def _lines(path: Path) -> list[str]:
    try:
        return path.read_text("ascii", "replace").splitlines()
    except OSError:
        return []


def keep_heap_small() -> None:
    """Let glibc give large arrays back to the system as soon as they are free (mallopt(3)).

    Otherwise glibc raises the size from which it does so up to 32 MB, and has an arena per thread.
    Bodies in pieces of up to 256 kB would then fragment the heap.
    """
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None) if os.name == "posix" else None
    if mallopt is not None:
        for parameter, value in ((_M_MMAP_THRESHOLD, _LARGE_BYTES), (_M_ARENA_MAX, 2)):
            mallopt(parameter, value)


_M_MMAP_THRESHOLD, _M_ARENA_MAX = -3, -8  # malloc.h

_LARGE_BYTES = 128 * 1024
"""Size from which memory is not taken from the heap: glibc's own, which it would raise."""


def return_free_pages() -> None:
    """Give the free pages of the heap back to the system."""
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None) if os.name == "posix" else None
    if trim is not None:
        trim(0)
