"""The cache of machine code on disk.

Numba's own file cache notices a change only in the file of the kernel itself, not in the kernels
that it calls from other files. It refuses a directory that cannot be written to, such as the
read-only root of a container. And it fails where a file cannot be unpickled. The classes here stamp
each entry with the `fingerprint` of the kernel. They read the cache from wherever the package lies,
and compile again what cannot be unpickled.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import cached_property
from pathlib import Path
from typing import Any

from numba.core import config
from numba.core.caching import (
    CompileResultCacheImpl,
    FunctionCache,
    IndexDataCacheFile,
    UserProvidedCacheLocator,
    _CacheLocator,
)
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import cpu_target

from gamutcore.kernels.fingerprint import fingerprint

__all__ = ["KernelCache", "cache_folder"]


def cache_folder(source: str) -> Path:
    """Directory of the machine code of a source file: beside it, or in ``NUMBA_CACHE_DIR``."""
    chosen: str = getattr(config, "CACHE_DIR", "")
    if chosen:
        return Path(chosen) / UserProvidedCacheLocator.get_suitable_cache_subpath(source)
    return Path(source).parent / "__pycache__"


class KernelCacheLocator(_CacheLocator):
    """Where the machine code of a function is."""

    def __init__(self, source: str) -> None:
        self._path = str(cache_folder(source))

    def get_cache_path(self) -> str:
        """Return the directory."""
        return self._path

    def get_source_stamp(self) -> bytes:
        """Return nothing: the stamp is computed when a file is read or written."""
        return b""

    def get_disambiguator(self) -> str:
        """Return the same for all functions: qualified names differ within a file."""
        return "kernel"

    @classmethod
    def from_function(cls, function: Callable[..., Any], source: str) -> KernelCacheLocator:  # noqa: ARG003
        """Return the locator of a function, whether or not its directory can be written to."""
        return cls(source)


class _KernelCacheImpl(CompileResultCacheImpl):
    _locator_classes: list[type[object]] = [KernelCacheLocator]  # noqa: RUF012  # as numba has it


class _KernelCacheFile(IndexDataCacheFile):
    # Unpickling can raise anything: it depends on the names in the file and on the damage.

    def __init__(self, path: str, name: str, function: Callable[..., Any]) -> None:
        self._function = function
        super().__init__(cache_path=path, filename_base=name, source_stamp=b"")
        del self._source_stamp

    @cached_property
    def _source_stamp(self) -> bytes:
        # computed on first use: when a decorator runs, later names of the module do not exist yet
        return fingerprint(self._function)

    def load(self, key: object) -> object:
        """Return compiled code, or None where none can be loaded."""
        try:
            return super().load(key)
        except Exception:  # noqa: BLE001
            return None

    def _load_index(self) -> dict[tuple[Any, ...], str]:
        """Return the names of the data files, or nothing where the index cannot be loaded."""
        try:
            index: dict[tuple[Any, ...], str] = super()._load_index()
        except Exception:  # noqa: BLE001
            return {}
        return index


class KernelCache(FunctionCache):
    """The cached machine code of one kernel, for all of its signatures."""

    _impl_class = _KernelCacheImpl

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)
        self._cache_file = _KernelCacheFile(self._cache_path, self._impl.filename_base, function)

    def signatures(self) -> list[tuple[Any, ...]]:
        """Return the argument types of all entries for this processor."""
        # Refreshing is not safe for threads: those of a service load kernels at the same time.
        with global_compiler_lock:
            cpu_target.target_context.refresh()
        codegen = cpu_target.target_context.codegen()
        return [
            key[0]
            for key in self._cache_file._load_index()  # noqa: SLF001
            if key == self._index_key(key[0], codegen)
        ]

    def save_overload(self, signature: object, data: object) -> None:
        """Keep compiled code, unless the directory cannot be written to."""
        path = Path(self.cache_path)
        existing = next(folder for folder in (path, *path.parents) if folder.exists())
        if os.access(existing, os.W_OK):
            super().save_overload(signature, data)
