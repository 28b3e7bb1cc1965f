"""Show that the installed kernels are loaded, not compiled, on a machine with another CPU.

The host's CPU is renamed and stripped of its features before numba sees it, which is all that numba
knows of it. Exits with 1 where a kernel had to be compiled, or where none was loaded.
"""

from __future__ import annotations

import platform
import sys

import llvmlite.binding

__all__: list[str] = []

OLD_CPU = "nocona" if platform.machine() == "x86_64" else "cortex-a53"
"""One that LLVM knows and no machine of today is."""


def main() -> int:
    """Print how many kernels were loaded and compiled; return the exit code."""
    llvmlite.binding.get_host_cpu_name = lambda: OLD_CPU
    llvmlite.binding.get_host_cpu_features = llvmlite.binding.FeatureMap

    from numba.core.dispatcher import Dispatcher

    from gamutcore.warm import compile_kernels

    compile_kernels()
    kernels = {
        value
        for name, module in list(sys.modules.items())
        if name.split(".")[0] == "gamutcore"
        for value in vars(module).values()
        if isinstance(value, Dispatcher)
    }
    loaded = sum(sum(kernel.stats.cache_hits.values()) for kernel in kernels)
    compiled = sum(sum(kernel.stats.cache_misses.values()) for kernel in kernels)
    print(f"on another CPU: {loaded} kernels loaded, {compiled} compiled")
    return int(compiled > 0 or loaded == 0)


if __name__ == "__main__":
    raise SystemExit(main())
