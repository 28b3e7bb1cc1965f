"""The decorator of all compiled kernels, and the cache that their machine code is kept in.

Numba's own file cache has three habits that do not suit a packaged service: it notices a change
only in the file of the kernel itself and not in the kernels that it calls from other files; it
refuses a cache directory that cannot be written to, such as the read-only root of a container whose
kernels were compiled when the image was built; and it fails where a file of it cannot be unpickled,
as when a kernel was compiled for a function of a module that is there no more. The locator here
stamps every cache entry with the content of all of them and reads from wherever the code lies, and
what cannot be unpickled is compiled anew.
"""

from __future__ import annotations

import functools
import hashlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
from numba.core import config
from numba.core.caching import (
    CompileResultCacheImpl,
    FunctionCache,
    IndexDataCacheFile,
    UserProvidedCacheLocator,
    _CacheLocator,
)

__all__ = ["inlined_kernel", "kernel", "leaf_kernel"]

PACKAGE = Path(__file__).parent

Kernel = TypeVar("Kernel", bound=Callable[..., Any])


@functools.cache
def package_digest() -> bytes:
    """SHA-256 of the package's source files that have to do with kernels, in the order of paths.

    Returns
    -------
    bytes, 32 long
    """
    digest = hashlib.sha256()
    for path in sorted(PACKAGE.rglob("*.py")):
        source = path.read_bytes()
        if b"gamutcore.kernels" in source or b"numba" in source:
            digest.update(str(path.relative_to(PACKAGE)).encode())
            digest.update(source)
    return digest.digest()


class KernelCacheLocator(_CacheLocator):
    """Where machine code is kept: ``NUMBA_CACHE_DIR``, else ``__pycache__`` beside the kernel."""

    def __init__(self, function: Callable[..., Any], source: str) -> None:
        self._line = function.__code__.co_firstlineno
        chosen: str = getattr(config, "CACHE_DIR", "")
        subpath: str = UserProvidedCacheLocator.get_suitable_cache_subpath(source)
        self._path = str(Path(chosen) / subpath if chosen else Path(source).parent / "__pycache__")

    def get_cache_path(self) -> str:
        """Return the directory."""
        return self._path

    def get_source_stamp(self) -> bytes:
        """Return what must be unchanged for an entry to be used."""
        return package_digest()

    def get_disambiguator(self) -> str:
        """Return what tells functions of one name in one file apart."""
        return str(self._line)

    @classmethod
    def from_function(cls, function: Callable[..., Any], source: str) -> KernelCacheLocator:
        """Return the locator of a function; unlike numba's, whether or not it can be written to."""
        return cls(function, source)


class _KernelCacheImpl(CompileResultCacheImpl):
    _locator_classes: list[type[object]] = [KernelCacheLocator]  # noqa: RUF012  # as numba has it


class _KernelCacheFile(IndexDataCacheFile):
    # whatever unpickling raises: that depends on what the file names, and on how it is damaged

    def load(self, key: object) -> object:
        """Return compiled code; None where there is none that can be loaded."""
        try:
            return super().load(key)  # type: ignore[no-untyped-call]
        except Exception:  # noqa: BLE001
            return None

    def _load_index(self) -> dict[object, str]:
        """Return which file has what; nothing where that cannot be loaded, to be written anew."""
        try:
            index: dict[object, str] = super()._load_index()  # type: ignore[no-untyped-call]
        except Exception:  # noqa: BLE001
            return {}
        return index


class _KernelCache(FunctionCache):
    _impl_class = _KernelCacheImpl

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)  # type: ignore[no-untyped-call]
        self._cache_file = _KernelCacheFile(  # type: ignore[no-untyped-call]
            cache_path=self._cache_path,
            filename_base=self._impl.filename_base,
            source_stamp=self._impl.locator.get_source_stamp(),
        )

    def save_overload(self, signature: object, data: object) -> None:
        """Keep compiled code; where the directory cannot be written to, do without."""
        path = Path(self.cache_path)
        existing = next(folder for folder in (path, *path.parents) if folder.exists())
        if os.access(existing, os.W_OK):
            super().save_overload(signature, data)  # type: ignore[no-untyped-call]


def kernel(function: Kernel) -> Kernel:
    """Compile a function over plain arrays with numba: without the GIL, cached, no fast-math.

    Fast-math stays off because reruns must be bit-identical and the star test relies on the sign of
    a determinant as IEEE arithmetic gives it. Division by zero follows IEEE as well and gives
    infinities, which the kernels test for, instead of an exception.

    Parameters
    ----------
    function : callable
        Takes and returns NumPy arrays, scalars and tuples of these.

    Returns
    -------
    callable
        The same function, compiled on its first call for each signature.
    """
    return _compiled(function)


def leaf_kernel(function: Kernel) -> Kernel:
    """Compile, as `kernel` does, a function that allocates no array and takes no slice of one.

    Such a function needs none of numba's reference counting, whose atomic operations otherwise
    take a third of the time of small functions that are called millions of times (measured on
    decimation).

    Parameters
    ----------
    function : callable

    Returns
    -------
    callable
    """
    return _compiled(function, _nrt=False)


def inlined_kernel(function: Kernel) -> Kernel:
    """Compile, as `leaf_kernel` does, a function that becomes part of each kernel that calls it.

    For small functions that take several arrays and are called for every number of a stream:
    handing the arrays over takes longer than what they do (reading a history in less than half the
    time, measured). So it is for larger ones that take dozens of arrays, such as those of a
    collapse, and are called from one or two places. Others grow the machine code and the time to
    compile it for nothing.

    Parameters
    ----------
    function : callable

    Returns
    -------
    callable
    """
    return _compiled(function, _nrt=False, forceinline=True)


def _compiled(function: Kernel, **flags: bool) -> Kernel:
    # numba's annotations do not know all of its flags
    compiler = cast("Callable[..., Any]", numba.njit)
    compiled = compiler(nogil=True, error_model="numpy", **flags)(function)
    # what numba's own enable_caching does, with another class of cache
    compiled._cache = _KernelCache(function)  # noqa: SLF001
    return cast("Kernel", compiled)
