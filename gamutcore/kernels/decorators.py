"""The decorators of all compiled functions.

Every decorated function compiles in up to two forms. A call from Python compiles an *entry point*:
complete machine code, kept in the cache. A call from another kernel compiles a *subroutine*: LLVM
IR alone, which becomes part of the caller's entry point (`gamutcore.kernels.linking` says why).

No kernel uses fast-math: reruns must be bit-identical, and the star test relies on the sign of a
determinant as IEEE arithmetic gives it. Division by zero gives an infinity, not an exception.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba.core import config, types
from numba.core.registry import CPUDispatcher

from gamutcore.kernels.cache import KernelCache
from gamutcore.kernels.linking import EntryCompiler, SubroutineCompiler

__all__ = [
    "KERNELS",
    "Kernel",
    "inlined_kernel",
    "kernel",
    "leaf_kernel",
    "load_kernels",
]

Function = TypeVar("Function", bound=Callable[..., Any])

OPTIONS: dict[str, Any] = {
    "nopython": True,
    "boundscheck": None,
    "nogil": True,
    "error_model": "numpy",
    "no_cfunc_wrapper": True,
}

KERNELS: list[Kernel] = []
"""All kernels of the modules that are imported."""


class Kernel(CPUDispatcher):
    """A compiled function that both Python and other kernels may call.

    `flags` are Numba's flags beside `OPTIONS`.
    """

    def __init__(self, function: Callable[..., Any], flags: dict[str, bool]) -> None:
        super().__init__(
            function, locals={}, targetoptions={**OPTIONS, **flags}, pipeline_class=EntryCompiler
        )
        self._cache = KernelCache(self)

    @functools.cached_property
    def _subroutine(self) -> CPUDispatcher:
        return CPUDispatcher(
            self.py_func,
            locals={},
            targetoptions={**self.targetoptions, "no_cpython_wrapper": True},
            pipeline_class=SubroutineCompiler,
        )

    def get_call_template(self, args: Any, kws: Any) -> Any:  # noqa: ANN401
        """Return the type of a call from another kernel, which gets the subroutine.

        Integers are passed as int64, whether they are literals, int32 or int64. The subroutine is
        then compiled once for all of them.
        """
        wide = tuple(_widened(argument) for argument in args)
        return self._subroutine.get_call_template(wide, kws)

    def get_overload(self, sig: Any) -> Any:  # noqa: ANN401
        """Return the function that a call from another kernel is linked to."""
        return self._subroutine.get_overload(sig)

    def load(self) -> bool:
        """Load the cached machine code of all signatures; return whether there is any."""
        signatures = self._cache.signatures()
        for signature in signatures:
            self.compile(signature)
        return bool(signatures)


def kernel(function: Function) -> Function:
    """Compile a function that Python calls, on its first call for each signature.

    It takes and returns NumPy arrays, scalars and tuples of these. It may allocate arrays.
    """
    return _compiled(function)


def leaf_kernel(function: Function) -> Function:
    """Compile a function that neither allocates an array nor takes a slice of one.

    Such a function needs none of numba's reference counting. Its atomic operations otherwise take a
    third of the time of small functions that run millions of times (measured on decimation).
    """
    return _compiled(function, _nrt=False)


def inlined_kernel(function: Function) -> Function:
    """Compile as `leaf_kernel` does, and inline the function into every caller.

    For small functions that take several arrays and run for every number of a stream.
    """
    return _compiled(function, _nrt=False, forceinline=True)


def load_kernels(modules: tuple[str, ...] = ("gamutcore",)) -> int:
    """Load machine code that is cached for this processor and return how many kernels have it.

    Only kernels of the given modules and packages are loaded, as far as they are imported.
    """
    return sum(kernel.load() for kernel in KERNELS if kernel.py_func.__module__.startswith(modules))


def _widened(argument: types.Type) -> types.Type:
    is_signed = isinstance(argument, types.Integer) and argument.signed
    return types.int64 if is_signed else argument


def _compiled(function: Function, **flags: bool) -> Function:
    if config.DISABLE_JIT:
        return function
    compiled = Kernel(function, flags)
    KERNELS.append(compiled)
    return cast("Function", compiled)
