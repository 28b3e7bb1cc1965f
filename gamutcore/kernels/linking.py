"""Optimise each kernel once: in the entry point that uses it.

Numba optimises a function when it compiles it, and again in every function that links it. With
chains of calls ten deep this took four of five minutes of installation and 54 MB of machine code.
Here a subroutine stays plain LLVM IR. An entry point links all subroutines that it reaches, makes
them internal, and optimises the whole once. LLVM then drops each subroutine that it has inlined.
Measured: docs/decisions/kernels.md.

The classes extend numba's compiler at three points: the library that receives the IR, the step that
makes a function callable from Python, and the form in which the cache keeps a library.
"""

from __future__ import annotations

import itertools
from typing import Any

import llvmlite.binding as llvm
from numba import _dynfunc
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, Flags

__all__ = ["EntryCompiler", "SubroutineCompiler"]

_numbers = itertools.count()
"""Names of libraries must differ within a process."""


class SubroutineLibrary(JITCodeLibrary):
    """LLVM IR of one kernel, to be linked into entry points."""

    def add_linking_library(self, library: Any) -> None:  # noqa: ANN401
        """Remember what this kernel calls; the entry point links it."""
        self._linking_libraries.append(library)

    def finalize(self) -> None:
        """Optimise nothing and generate no machine code."""
        self._finalized = True

    def _get_module_for_linking(self) -> Any:  # noqa: ANN401
        if self._shared_module is None:
            for function in self._final_module.functions:
                if not function.is_declaration and function.linkage == llvm.Linkage.external:
                    # several entry points link a copy each
                    function.linkage = "weak_odr"
            self._shared_module = self._final_module
        return self._shared_module


class EntryLibrary(JITCodeLibrary):
    """Complete machine code of one kernel and all that it calls."""

    def add_linking_library(self, library: Any) -> None:  # noqa: ANN401
        """Link a library and, if it is a subroutine's, all that the subroutine reaches."""
        if library in self._linking_libraries:
            return
        super().add_linking_library(library)
        if isinstance(library, SubroutineLibrary):
            for reached in library._linking_libraries:  # noqa: SLF001
                self.add_linking_library(reached)

    def finalize(self) -> None:
        """Link, optimise and generate machine code."""
        # Numba's own libraries define functions that LLVM links only where something linked before
        # refers to them: the subroutines come first.
        self._linking_libraries.sort(key=lambda each: not isinstance(each, SubroutineLibrary))
        super().finalize()

    def _optimize_final_module(self) -> None:
        copies = (llvm.Linkage.weak_odr, llvm.Linkage.linkonce_odr)
        for function in self._final_module.functions:
            # numba's pass that prunes reference counts finds the counting functions by name
            if function.linkage in copies and not function.name.startswith("NRT_"):
                function.linkage = "internal"
        super()._optimize_final_module()

    def serialize_using_object_code(self) -> tuple[str, str, tuple[bytes, bytes]]:
        """Return what the cache keeps: machine code, and the names of its functions.

        Numba adds the whole IR, for callers to link. No kernel links an entry point.
        """
        self._ensure_finalized()
        names = [
            function.name
            for function in self._final_module.functions
            if not function.is_declaration and function.linkage == llvm.Linkage.external
        ]
        stubs = "\n".join(f'define void @"{name}"() {{ unreachable }}' for name in names)
        return (
            self.name,
            "object",
            (self._get_compiled_object(), llvm.parse_assembly(stubs).as_bitcode()),
        )


class ComparedFlags(Flags):
    """Numba's options of a compilation, compared in less time.

    They are part of the key of every call that numba types. Its own comparison builds two
    dictionaries each time: a tenth of the time to compile.
    """

    __slots__ = ()

    def __hash__(self) -> int:
        """Return the hash of all options with the same names, as numba does."""
        return _FLAGS_HASH

    def __eq__(self, other: object) -> bool:
        """Compare what is set; options that are set to their default take numba's comparison."""
        same = isinstance(other, Flags) and self._values == other._values
        return same or super().__eq__(other)


_FLAGS_HASH = hash(Flags())


class EntryCompiler(Compiler):
    """Numba's compiler with an `EntryLibrary`."""

    def __init__(self, *arguments: Any) -> None:  # noqa: ANN401
        super().__init__(*arguments)
        self.state.flags = ComparedFlags(self.state.flags)
        self.state.library = EntryLibrary(
            self.state.targetctx.codegen(), f"entry_point_{next(_numbers)}"
        )
        self.state.library.enable_object_caching()


class SubroutineCompiler(Compiler):
    """Numba's compiler with a `SubroutineLibrary`."""

    def __init__(self, *arguments: Any) -> None:  # noqa: ANN401
        super().__init__(*arguments)
        self.state.flags = ComparedFlags(self.state.flags)
        # the context is this compilation's own copy
        self.state.targetctx.get_executable = _not_executable
        self.state.library = SubroutineLibrary(
            self.state.targetctx.codegen(), f"subroutine_{next(_numbers)}"
        )


def _not_executable(library: SubroutineLibrary, description: Any, environment: Any) -> Any:  # noqa: ANN401
    """Return the object that stands for a subroutine in numba's tables; Python never calls it."""
    name = description.qualname.split(".")[-1]
    module = description.lookup_module()
    return _dynfunc.make_function(module, name, "", 0, environment, (library,))
