"""Machine code on disk: what it depends on, where it is, and whether all of it is there.

Numba's own cache notices a change only in the file of a kernel, not in the kernels that it calls
from other files. It refuses a directory that cannot be written to, such as the read-only root of a
container, and it fails on a damaged file. Here each kernel, signature and processor has a file,
stamped with the `fingerprint` of the kernel. What cannot be read is compiled again.

Machine code lies beside the sources, in the user's cache where that folder cannot be written, or in
``NUMBA_CACHE_DIR``. A wheel may bring machine code in `SHIPPED`, compiled for every processor of
the architecture, so that nothing is compiled after an installation.

Kernels are compiled in three groups. The ``default`` group is what a build with default options and
every reader of a gamut need. The ``ciede2000`` group searches by CIEDE2000, and the ``optional``
group is the rest. A stamp beside the machine code says that a group is complete for the present
source, processor and versions. Services wait for the first group, compile the second in the
background at a low priority, and the third when a request needs it. A kernel without machine code
compiles on its first call, so a missing stamp costs time and nothing else.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import logging
import os
import pickle
import subprocess
import sys
import types
import uuid
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numba
import numpy as np
import platformdirs
from numba.core import config
from numba.core.caching import NullCache, UserProvidedCacheLocator
from numba.core.compiler import CompileResult
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import cpu_target
from numba.core.serialize import dumps

__all__ = [
    "ENTRY_POINTS",
    "GROUPS",
    "KernelCache",
    "compilation_lock",
    "compile_command",
    "ensure_compiled",
    "fingerprint",
    "is_compiled",
    "mark_compiled",
    "stamps_can_be_kept",
    "watchers",
]

logger = logging.getLogger(__name__)

GROUPS = ("default", "optional", "ciede2000")
"""Names of the groups, in the order in which a service compiles them."""

ENTRY_POINTS = {"default": 56, "optional": 65, "ciede2000": 11}
"""Number of entry points that compiling a group compiles or loads."""

watchers: list[Callable[[str], None]] = []
"""Called with the name of each entry point whose machine code has been loaded or compiled."""

SECONDS_PER_BYTE = 3.0e-4
"""Compile time per byte of Python bytecode, for estimates. Measured on `collapse_edges` and
`radial_hull` (2 to 4 × 10⁻⁴ on one core of an AMD EPYC)."""

LONG_COMPILATION = 2.0
"""Estimates of more seconds than this are logged: shorter waits go unnoticed."""

PACKAGE = Path(__file__).parents[1]

SHIPPED = PACKAGE / "kernels" / "compiled"
"""Machine code that came with the installation; ``.ci/wheels.py`` makes it."""

VERSIONS = (
    f"numba {numba.__version__} numpy {np.__version__.partition('.')[0]} "
    f"{sys.implementation.cache_tag}"
)
"""Numba writes the machine code. Of NumPy, its code knows what stays within a major version."""


# --- what the machine code of a kernel depends on ------------------------------------------------


def fingerprint(kernel: Callable[..., Any]) -> bytes:
    """SHA-256 of all that a kernel's machine code depends on within the package.

    The code depends on the kernel's own bytecode, on the constants that it names, and on the
    kernels that it calls and their decorators, in turn. Comments, docstrings, line numbers and
    other functions of the module do not count: an edit compiles exactly the entry points that reach
    the edited code.
    """
    return hashlib.sha256(b"".join(_described(kernel, {}))).digest()


def _bytecode_size(kernel: Callable[..., Any]) -> int:
    """Bytes of the Python bytecode of a kernel and of all kernels that it reaches."""
    reached: dict[int, types.FunctionType] = {}
    for _ in _described(kernel, reached):
        pass
    return sum(len(function.__code__.co_code) for function in reached.values())


def _described(value: Any, reached: dict[int, types.FunctionType]) -> Iterator[bytes]:  # noqa: ANN401
    """Describe a value that compiled code may depend on, and what it depends on in turn.

    The functions whose code is described are added to `reached`, by their `id`.
    """
    function = getattr(value, "py_func", value)
    if isinstance(function, types.FunctionType):
        options = sorted(getattr(value, "targetoptions", {}).items())  # those of its decorator
        yield f"function {function.__module__}.{function.__qualname__} {options};".encode()
        if id(function) not in reached and _is_ours(function.__module__):
            reached[id(function)] = function
            yield from _code(function, function.__code__, reached)
            for cell in function.__closure__ or ():
                yield from _described(cell.cell_contents, reached)
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
            yield from _described(each, reached)
    elif isinstance(value, str | int | float | complex | bool | None):
        yield f"{value!r};".encode()
    else:
        yield f"{type(value).__qualname__} {getattr(value, '__name__', '')};".encode()


def _code(
    function: types.FunctionType, code: types.CodeType, reached: dict[int, types.FunctionType]
) -> Iterator[bytes]:
    yield code.co_code
    yield repr((code.co_argcount, code.co_varnames, code.co_names)).encode()
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            yield from _code(function, constant, reached)
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
                yield from _described(names[name], reached)


def _is_ours(module: str) -> bool:
    """Whether a function's code is read: numpy's and numba's go by their versions."""
    return module.partition(".")[0] not in {"numpy", "numba", "math"}


def _processor() -> tuple[str, ...]:
    """Name and features of the processor, as numba knows them."""
    # Refreshing is not safe for threads: those of a service load kernels at the same time.
    with global_compiler_lock:
        cpu_target.target_context.refresh()
    processor: tuple[str, ...] = cpu_target.target_context.codegen().magic_tuple()
    return processor


def _processors() -> tuple[tuple[str, ...], ...]:
    """Return the processors whose machine code runs here: this one, and the generic one."""
    own = _processor()
    return own, (own[0], "generic", "")


# --- the machine code of one kernel --------------------------------------------------------------


class KernelCache(NullCache):
    """The machine code of one kernel: a file for each signature and processor."""

    def __init__(self, kernel: Any) -> None:  # noqa: ANN401
        self._kernel = kernel
        self._source = kernel.py_func.__code__.co_filename
        function = kernel.py_func
        name = hashlib.sha256(f"{function.__module__}.{function.__qualname__}".encode()).hexdigest()
        self._name = f"{function.__name__}-{name[:8]}"

    @property
    def cache_path(self) -> str:
        """The directory."""
        return str(_folders(self._source)[0])

    @functools.cached_property
    def _stamp(self) -> tuple[str, bytes]:
        # computed on first use: when a decorator runs, later names of the module do not exist yet
        return VERSIONS, fingerprint(self._kernel)

    def _file_name(self, signature: object, processor: tuple[str, ...]) -> str:
        digest = hashlib.sha256(f"{signature} {processor}".encode()).hexdigest()
        return f"{self._name}-{digest[:16]}.nbc"

    def _paths(self, signature: object) -> Iterator[Path]:
        """Return the files that may have the code of a signature, the best first."""
        for processor in dict.fromkeys(_processors()):
            name = self._file_name(signature, processor)
            yield from (folder / name for folder in _folders(self._source))

    def signatures(self) -> list[tuple[Any, ...]]:
        """Return the argument types of all entries for this processor."""
        entries = {}
        for folder in _folders(self._source):
            for path in folder.glob(f"{self._name}-*.nbc"):
                # Unpickling can raise anything: it depends on the names in the file and on damage.
                with contextlib.suppress(Exception), path.open("rb") as file:
                    stamp, signature = pickle.load(file)  # noqa: S301  # our own
                    if stamp == self._stamp and path in self._paths(signature):
                        entries[str(signature)] = signature
        return list(entries.values())

    def load_overload(self, signature: object, context: Any) -> Any:  # noqa: ANN401
        """Return compiled code. Where none can be loaded, say so if it will take long."""
        for path in self._paths(signature):
            with contextlib.suppress(Exception), path.open("rb") as file:
                if pickle.load(file) == (self._stamp, signature):  # noqa: S301  # our own
                    content = pickle.load(file)  # noqa: S301
                    code = CompileResult._rebuild(context, *content)  # noqa: SLF001
                    _tell_watchers(path)
                    return code
        seconds = SECONDS_PER_BYTE * _bytecode_size(self._kernel)
        if seconds > LONG_COMPILATION:
            logger.warning(
                "compiling %s.%s for this processor: about %.0f s, once; kept in %s%s",
                self._kernel.py_func.__module__,
                self._kernel.py_func.__qualname__,
                seconds,
                self.cache_path,
                _shipped_note(),
            )
        return None

    def save_overload(self, signature: object, compiled: Any) -> None:  # noqa: ANN401
        """Keep compiled code; where nothing can be written, do nothing."""
        if compiled.library.has_dynamic_globals:  # such code holds addresses of this process
            return
        content = dumps((self._stamp, signature)) + dumps(compiled._reduce())  # noqa: SLF001
        path = _folders(self._source)[0] / self._file_name(signature, _processor())
        _write(path, content)
        _tell_watchers(path)


def _tell_watchers(path: Path) -> None:
    for watcher in watchers:
        watcher(path.stem)


def _folders(source: str) -> tuple[Path, ...]:
    """Return the directories that may have machine code of a source file.

    The first one is written to.
    """
    chosen: str = getattr(config, "CACHE_DIR", "")
    if chosen:
        return Path(chosen) / UserProvidedCacheLocator.get_suitable_cache_subpath(source), SHIPPED
    beside = Path(source).parent / "__pycache__"
    if _is_writable(beside):
        return beside, SHIPPED
    cache = platformdirs.user_cache_path("gamut-boundary-service", appauthor=False) / "kernels"
    below = UserProvidedCacheLocator.get_suitable_cache_subpath(source)
    return cache / below, beside, SHIPPED


def _is_writable(folder: Path) -> bool:
    """Whether a directory can be written, or made."""
    existing = next(each for each in (folder, *folder.parents) if each.exists())
    return os.access(existing, os.W_OK)


@functools.cache
def _shipped_note() -> str:
    """Say for which versions there is machine code, if it is not for those of this process."""
    name = _stamp_files(GROUPS[0])[0].name
    with contextlib.suppress(OSError, IndexError):
        numba_version = (SHIPPED / name).read_text().split()[2]
        if numba_version != numba.__version__:
            return f"; the installation has machine code for numba {numba_version}"
    return ""


def _write(path: Path, content: bytes) -> None:
    """Write a file at once, so that another process reads all of it or nothing."""
    scratch = path.with_suffix(f".{uuid.uuid4().hex}")
    with contextlib.suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        scratch.write_bytes(content)
        scratch.replace(path)


# --- the kernels of an installation --------------------------------------------------------------


def is_compiled(group: str) -> bool:
    """Whether the machine code of a group of `GROUPS` is complete."""
    states = {_state(processor) for processor in _processors()}
    for path in _stamp_files(group):
        with contextlib.suppress(OSError):
            if path.read_text() in states:
                return True
    return False


def mark_compiled(group: str) -> None:
    """Note that all kernels of a group are compiled; where nothing can be written, do nothing."""
    _write(_stamp_files(group)[0], _state(_processor()).encode())


def stamps_can_be_kept() -> bool:
    """Whether machine code and stamps can be written."""
    folders = _stamp_files(GROUPS[0])[0].parents
    return os.access(next(folder for folder in folders if folder.exists()), os.W_OK)


def compile_command(group: str) -> list[str]:
    """Return the command line that compiles a group, and ends when its standard input does.

    It prints the name of each kernel that is usable; names can repeat. Builds and requests go
    before the optional group.
    """
    options = ["--while-stdin-is-open", "--print", *(["--nice"] if group == "optional" else [])]
    return [sys.executable, "-m", "gamutcore.warm", *options, group]


def ensure_compiled(group: str) -> None:
    """Compile a group of `GROUPS` in processes of its own, if it is not compiled.

    A process that compiles holds some hundred megabytes until it ends, so a server does not do it
    itself. Of several processes that call this at once, one compiles and the others wait.
    """
    if is_compiled(group) or not stamps_can_be_kept():
        return
    with subprocess.Popen(  # noqa: S603  # no input
        compile_command(group), stdin=subprocess.PIPE, stdout=subprocess.DEVNULL
    ) as process:
        process.wait()
    if process.returncode:
        logger.error("the %s kernels were not compiled: exit status %d", group, process.returncode)


@contextlib.contextmanager
def compilation_lock(group: str) -> Iterator[None]:
    """Let one process at a time compile a group."""
    with contextlib.ExitStack() as held:
        # Windows has no such lock, and no service runs there. Nothing is kept where nothing can be
        # written, so nothing is locked.
        with contextlib.suppress(ImportError, OSError):
            import fcntl  # noqa: PLC0415

            path = _stamp_files(group)[0].with_suffix(".lock")
            path.parent.mkdir(parents=True, exist_ok=True)
            fcntl.flock(held.enter_context(path.open("w")), fcntl.LOCK_EX)
        yield


def _stamp_files(group: str) -> list[Path]:
    name = f"kernels-{group}.py{sys.version_info.major}{sys.version_info.minor}.stamp"
    return [folder / name for folder in _folders(str(PACKAGE / "warm.py"))]


@functools.cache
def _sources() -> str:
    digest = hashlib.sha256()
    for path in sorted(PACKAGE.rglob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def _state(processor: tuple[str, ...]) -> str:
    """Return all that machine code depends on: sources, versions and processor."""
    return f"{_sources()} {VERSIONS} {processor}\n"
