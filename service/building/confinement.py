"""Confinement of a build worker, so that a decoder that a file takes over finds nothing to use.

A worker is a separate program and shares neither memory nor open files with the service. Here its
environment, its privileges and its resources are limited. The service also closes its own memory
and environment to other processes of its user. The worker keeps the rights of this user: it can
read and write a store in a directory, and connect to addresses. See
``docs/decisions/builds-in-a-worker-process.md``.
"""

from __future__ import annotations

import contextlib
import ctypes
import logging
import math
import os
import re
import resource
import sys
import time

__all__ = ["confine", "hide_memory", "limit_processor_time", "worker_environment"]

logger = logging.getLogger(__name__)

_ALLOWED = re.compile(
    r"PATH|HOME|TMPDIR|TZ|LANG|LANGUAGE|LC_[A-Z]+|LD_LIBRARY_PATH|PYTHON[A-Z]+"
    r"|(NUMBA|OPENBLAS|OMP|MALLOC|GAMUT_LOG)_[A-Z_]+"
)
"""Variables that a worker gets: paths, language, threads, allocator, compiler and log. Everything
else may be a credential."""

_PR_SET_DUMPABLE, _PR_SET_NO_NEW_PRIVS = 4, 38
"""Operations of prctl(2)."""

_OPEN_FILES = 1024
"""A build has less than 20 open files. Compilers of kernels have more."""

_FILE_BYTES = 4 << 30
"""Largest file in bytes. Histories have less than 0.1 GB, temporary copies of pictures the size of
the request."""

_MARGIN_SECONDS = 10.0


def worker_environment() -> dict[str, str]:
    """Return the variables of this process that a worker gets."""
    allowed = {name: value for name, value in os.environ.items() if _ALLOWED.fullmatch(name)}
    # glibc gives every thread an arena, and never returns its memory.
    return {**allowed, "MALLOC_ARENA_MAX": "2"}


def confine() -> None:
    """Give up all rights that a worker does not need, before it reads any input.

    The number of processes is not limited. Such a limit counts all processes of the user on the
    host, including other containers, so neighbours would fail builds.
    """
    _prctl(_PR_SET_NO_NEW_PRIVS, 1)
    for limit, most in (
        (resource.RLIMIT_CORE, 0),
        (resource.RLIMIT_NOFILE, _OPEN_FILES),
        (resource.RLIMIT_FSIZE, _FILE_BYTES),
    ):
        _, hard = resource.getrlimit(limit)
        lowered = most if hard == resource.RLIM_INFINITY else min(most, hard)
        with contextlib.suppress(OSError, ValueError):
            resource.setrlimit(limit, (lowered, lowered))


def limit_processor_time(seconds: float) -> None:
    """End this process when it uses all cores for longer than `seconds` plus a margin from now on.

    The service ends builds by the clock. This limit ends a build whose service is gone.
    """
    cores = os.cpu_count() or 1
    used = time.process_time()
    _, hard = resource.getrlimit(resource.RLIMIT_CPU)
    most = math.ceil(used + cores * (seconds + _MARGIN_SECONDS))
    with contextlib.suppress(OSError, ValueError):
        resource.setrlimit(
            resource.RLIMIT_CPU, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard)
        )


def hide_memory() -> None:
    """Close the memory and the environment of this process to other processes of its user.

    They hold the credentials of bucket and broker. Root can still read them.
    """
    _prctl(_PR_SET_DUMPABLE, 0)


def _prctl(operation: int, argument: int) -> None:
    if sys.platform != "linux":
        return
    if ctypes.CDLL(None, use_errno=True).prctl(operation, argument, 0, 0, 0) != 0:
        logger.warning("prctl(%d) failed: %s", operation, os.strerror(ctypes.get_errno()))
