"""What the machine code of a kernel depends on, as a digest.

A kernel's code depends on its own bytecode and the constants that it names. It also depends on the
kernels that it calls and their decorators, in turn. Comments, docstrings, line numbers and other
functions of the same module do not count: an edit compiles exactly the entry points that reach the
edited code.
"""

from __future__ import annotations

import hashlib
import types
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

__all__ = ["fingerprint", "reached_functions"]

PACKAGE = __name__.partition(".")[0]

Function = Callable[..., Any]


def fingerprint(function: Function) -> bytes:
    """SHA-256 of all that a kernel's machine code depends on within the package.

    `function` is the plain Python function.
    """
    digest = hashlib.sha256(f"numpy {np.__version__}".encode())
    for reached in _reached(function):
        digest.update(reached)
    return digest.digest()


def reached_functions(function: Function) -> list[Function]:
    """Return a kernel's Python function and those of all kernels that it reaches, each once."""
    seen: dict[int, Any] = {}
    for _ in _described(function, seen):
        pass
    return [each for each in seen.values() if isinstance(each, types.FunctionType)]


def _reached(function: Function) -> Iterator[bytes]:
    yield from _described(function, {})


def _described(value: Any, seen: dict[int, Any]) -> Iterator[bytes]:  # noqa: ANN401
    """Describe a value that compiled code may depend on, and what it depends on in turn."""
    function = getattr(value, "py_func", value)
    if isinstance(function, types.FunctionType):
        options = sorted(getattr(value, "targetoptions", {}).items())  # those of its decorator
        yield f"function {function.__module__}.{function.__qualname__} {options};".encode()
        if id(function) not in seen and _is_ours(function.__module__):
            seen[id(function)] = function
            yield from _code(function, function.__code__, seen)
            for cell in function.__closure__ or ():
                yield from _described(cell.cell_contents, seen)
    elif isinstance(value, types.ModuleType):
        yield f"module {value.__name__};".encode()
    elif isinstance(value, type):
        fields = getattr(value, "_fields", ())
        yield f"class {value.__module__}.{value.__qualname__}{fields};".encode()
    elif isinstance(value, np.ndarray | np.generic):
        yield f"array {value.dtype} {np.shape(value)}".encode() + value.tobytes()
    elif isinstance(value, tuple | list):
        yield f"sequence of {len(value)}:".encode()
        for each in value:
            yield from _described(each, seen)
    elif isinstance(value, str | int | float | complex | bool | None):
        yield f"{value!r};".encode()
    else:
        yield f"{type(value).__qualname__} {getattr(value, '__name__', '')};".encode()


def _code(
    function: types.FunctionType, code: types.CodeType, seen: dict[int, Any]
) -> Iterator[bytes]:
    yield code.co_code
    yield repr((code.co_argcount, code.co_varnames, code.co_names)).encode()
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            yield from _code(function, constant, seen)
        elif constant is not function.__doc__:
            yield f"{constant!r};".encode()
    # of an attribute of a module, the module is a global and the attribute a name of its own
    modules = [
        value
        for value in map(function.__globals__.get, code.co_names)
        if isinstance(value, types.ModuleType) and _is_ours(value.__name__)
    ]
    for name in code.co_names:
        for names in (function.__globals__, *(vars(module) for module in modules)):
            if name in names:
                yield from _described(names[name], seen)


def _is_ours(module: str) -> bool:
    """Whether a function's code is read: numpy's and numba's go by their names."""
    return module.partition(".")[0] not in {"numpy", "numba", "math"}
