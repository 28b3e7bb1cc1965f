"""Compiled functions over plain arrays: how they are compiled, cached and found out of date.

Public names: the decorators `kernel`, `leaf_kernel` and `inlined_kernel`. With
``NUMBA_DISABLE_JIT=1`` they return the function as it is: debuggers and coverage tools see plain
Python.
"""

from gamutcore.kernels.decorators import inlined_kernel, kernel, leaf_kernel

__all__ = ["inlined_kernel", "kernel", "leaf_kernel"]
