"""Compiled functions over plain arrays: compilation, cache, and the check whether code is stale.

With ``NUMBA_DISABLE_JIT=1`` the decorators return the function as it is: debuggers and coverage
tools see plain Python.
"""

from gamutcore.kernels.cache import (
    ENTRY_POINTS,
    GROUPS,
    compilation_lock,
    compile_command,
    ensure_compiled,
    is_compiled,
    mark_compiled,
    stamps_can_be_kept,
    watchers,
)
from gamutcore.kernels.decorators import (
    KERNELS,
    inlined_kernel,
    kernel,
    leaf_kernel,
    load_kernels,
)

__all__ = [
    "ENTRY_POINTS",
    "GROUPS",
    "KERNELS",
    "compilation_lock",
    "compile_command",
    "ensure_compiled",
    "inlined_kernel",
    "is_compiled",
    "kernel",
    "leaf_kernel",
    "load_kernels",
    "mark_compiled",
    "stamps_can_be_kept",
    "watchers",
]
