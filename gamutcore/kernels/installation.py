"""Whether this installation's kernels are compiled, and how they get compiled and loaded.

Kernels are compiled in two groups. The ``default`` group is what a build with default options and
every reader of a gamut need; the ``optional`` group is the rest. A stamp beside the machine code
says that a group is complete for the present source, processor and versions. Services wait for the
first group and compile the second in the background. A kernel without machine code compiles on its
first call, so a missing stamp costs time and nothing else.
"""

from __future__ import annotations

import contextlib
import hashlib
import logging
import os
import subprocess
import sys
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import numba
import numpy as np
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import cpu_target

from gamutcore.kernels.cache import cache_folder
from gamutcore.kernels.decorators import KERNELS

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = [
    "GROUPS",
    "compilation_lock",
    "compile_command",
    "ensure_compiled",
    "is_compiled",
    "load_kernels",
    "mark_compiled",
    "stamps_can_be_kept",
]

logger = logging.getLogger(__name__)

GROUPS = ("default", "optional")
"""Names of the groups, in the order in which a service compiles them."""

PACKAGE = Path(__file__).parents[1]


def is_compiled(group: str) -> bool:
    """Whether the machine code of a group of `GROUPS` is complete."""
    try:
        return _stamp(group).read_text() == _state()
    except OSError:
        return False


def mark_compiled(group: str) -> None:
    """Note that all kernels of a group are compiled; where nothing can be written, do nothing."""
    with contextlib.suppress(OSError):
        path = _stamp(group)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(_state())


def stamps_can_be_kept() -> bool:
    """Whether machine code and stamps can be written."""
    path = _stamp(GROUPS[0])
    existing = next(folder for folder in path.parents if folder.exists())
    return os.access(existing, os.W_OK)


def compile_command(group: str) -> list[str]:
    """Return the command line that compiles a group, and ends when its standard input does."""
    return [sys.executable, "-m", "gamutcore.warm", "--while-stdin-is-open", group]


def ensure_compiled(group: str) -> None:
    """Compile a group of `GROUPS` in processes of its own, if it is not compiled.

    A process that compiles holds some hundred megabytes until it ends, so a server does not do it
    itself. Of several processes that call this at once, one compiles and the others wait.
    """
    if is_compiled(group) or not stamps_can_be_kept():
        return
    with subprocess.Popen(compile_command(group), stdin=subprocess.PIPE) as process:  # noqa: S603  # no input
        process.wait()
    if process.returncode:
        logger.error("the %s kernels were not compiled: exit status %d", group, process.returncode)


def load_kernels(modules: tuple[str, ...] = ("gamutcore",)) -> int:
    """Load machine code that is cached for this processor and return how many kernels have it.

    Only kernels of the given modules and packages are loaded, as far as they are imported.
    """
    return sum(kernel.load() for kernel in KERNELS if kernel.py_func.__module__.startswith(modules))


@contextlib.contextmanager
def compilation_lock(group: str) -> Iterator[None]:
    """Let one process at a time compile a group."""
    try:
        import fcntl  # noqa: PLC0415  # not on Windows, where no service runs
    except ImportError:
        yield
        return
    if not stamps_can_be_kept():
        yield
        return

    path = _stamp(group).with_suffix(".lock")
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


def _stamp(group: str) -> Path:
    name = f"kernels-{group}.py{sys.version_info.major}{sys.version_info.minor}.stamp"
    return cache_folder(str(PACKAGE / "warm.py")) / name


@cache
def _sources() -> str:
    digest = hashlib.sha256()
    for path in sorted(PACKAGE.rglob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def _state() -> str:
    """Return all that machine code depends on: sources, versions and processor."""
    with global_compiler_lock:
        cpu_target.target_context.refresh()
    processor = cpu_target.target_context.codegen().magic_tuple()
    return f"{_sources()} numba {numba.__version__} numpy {np.__version__} {processor}\n"
