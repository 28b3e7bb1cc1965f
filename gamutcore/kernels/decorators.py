"""The decorators of all compiled functions.

Every decorated function compiles in up to two forms. A call from Python compiles an *entry point*:
complete machine code, kept in the cache. A call from another kernel compiles a *subroutine*: LLVM
IR alone, which becomes part of the caller's entry point (`gamutcore.kernels.linking` says why).

No kernel uses fast-math: reruns must be bit-identical, and the star test relies on the sign of a
determinant as IEEE arithmetic gives it. Division by zero gives an infinity, not an exception.
"""

from __future__ import annotations

import functools
import logging
from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba.core import config, sigutils, types
from numba.core.registry import CPUDispatcher

from gamutcore.kernels.cache import KernelCache
from gamutcore.kernels.fingerprint import reached_functions
from gamutcore.kernels.linking import EntryCompiler, SubroutineCompiler

__all__ = ["KERNELS", "Kernel", "inlined_kernel", "kernel", "leaf_kernel"]

logger = logging.getLogger(__name__)

Function = TypeVar("Function", bound=Callable[..., Any])

OPTIONS: dict[str, Any] = {
    "nopython": True,
    "boundscheck": None,
    "nogil": True,
    "error_model": "numpy",
    "no_cfunc_wrapper": True,
}

SECONDS_PER_BYTE = 3.0e-4
"""Compile time per byte of Python bytecode, for estimates. Measured on `collapse_edges` and
`radial_hull` (2 to 4 × 10⁻⁴ on one core of an AMD EPYC)."""

LONG_COMPILATION = 2.0
"""Estimates of more seconds than this are logged: shorter waits go unnoticed."""


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
        self._cache = KernelCache(function)
        self._flags = flags

    @functools.cached_property
    def _subroutine(self) -> CPUDispatcher:
        return CPUDispatcher(
            self.py_func,
            locals={},
            targetoptions={**OPTIONS, **self._flags, "no_cpython_wrapper": True},
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
            super().compile(signature)
        return bool(signatures)

    def compile(self, sig: Any) -> Any:  # noqa: ANN401
        """Load the entry point for a signature from the cache, or compile it.

        A compilation that takes long is logged as a warning, because the caller waits for it.
        """
        arguments, _ = sigutils.normalize_signature(sig)
        if arguments not in self.overloads and arguments not in self._cache.signatures():
            seconds = SECONDS_PER_BYTE * sum(
                len(function.__code__.co_code) for function in reached_functions(self.py_func)
            )
            if seconds > LONG_COMPILATION:
                logger.warning(
                    "compiling %s.%s for this processor: about %.0f s, once; kept in %s",
                    self.py_func.__module__,
                    self.py_func.__qualname__,
                    seconds,
                    self._cache.cache_path,
                )
        return super().compile(sig)


def kernel(function: Function) -> Function:
    """Compile a function that Python calls.

    Parameters
    ----------
    function : callable
        Takes and returns NumPy arrays, scalars and tuples of these. It may allocate arrays.

    Returns
    -------
    callable
        The same function, compiled on its first call for each signature.
    """
    return _compiled(function)


def leaf_kernel(function: Function) -> Function:
    """Compile a function that neither allocates an array nor takes a slice of one.

    Such a function needs none of numba's reference counting. Its atomic operations otherwise take a
    third of the time of small functions that run millions of times (measured on decimation).

    Parameters
    ----------
    function : callable

    Returns
    -------
    callable
    """
    return _compiled(function, _nrt=False)


def inlined_kernel(function: Function) -> Function:
    """Compile as `leaf_kernel` does, and inline the function into every caller.

    For small functions that take several arrays and run for every number of a stream.

    Parameters
    ----------
    function : callable

    Returns
    -------
    callable
    """
    return _compiled(function, _nrt=False, forceinline=True)


def _widened(argument: types.Type) -> types.Type:
    is_signed = isinstance(argument, types.Integer) and argument.signed
    return types.int64 if is_signed else argument


def _compiled(function: Function, **flags: bool) -> Function:
    if config.DISABLE_JIT:
        return function
    compiled = Kernel(function, flags)
    KERNELS.append(compiled)
    return cast("Function", compiled)
