"""What the container image relies on: a kernel cache that is found again under another CPU.

The image's own steps are carried out by ``make image-check``, which needs root; this needs none.
"""

import os
import platform
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
FIXED_CPU = dict(
    re.findall(r'(NUMBA_CPU_\w+)="?(\w*)', (ROOT / "Dockerfile").read_text().split("\nFROM ")[-1])
)

OLD_CPU = "nocona" if platform.machine() == "x86_64" else "cortex-a53"
"""One that LLVM knows and no machine of today is."""

MODULE = f"""
import sys
import llvmlite.binding
if sys.argv[1] == "another":
    llvmlite.binding.get_host_cpu_name = lambda: "{OLD_CPU}"
    llvmlite.binding.get_host_cpu_features = llvmlite.binding.FeatureMap
from twice import twice
assert twice(21.0) == 42.0
print(sum(twice.stats.cache_hits.values()), sum(twice.stats.cache_misses.values()))
"""

KERNEL = """
from gamutcore.kernels import kernel

@kernel
def twice(value):
    return 2.0 * value
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "twice.py").write_text(KERNEL)
    (tmp_path / "main.py").write_text(MODULE)
    return tmp_path


def loaded_and_compiled(folder, cpu, variables):
    """Call the kernel in a new process; return how often it was loaded and compiled."""
    environment = {
        name: value for name, value in os.environ.items() if not name.startswith("NUMBA")
    }
    environment |= {**variables, "PYTHONPATH": str(ROOT)}
    output = subprocess.run(
        [sys.executable, "main.py", cpu],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    return tuple(map(int, output.split()))


def test_the_image_fixes_name_and_features():
    assert set(FIXED_CPU) == {"NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES"}


def test_kernels_compiled_for_a_fixed_cpu_are_loaded_on_another(folder):
    assert loaded_and_compiled(folder, "this", FIXED_CPU) == (0, 1)
    assert loaded_and_compiled(folder, "another", FIXED_CPU) == (1, 0)


def test_kernels_compiled_for_the_host_are_not(folder):
    """Otherwise the test above would show nothing."""
    assert loaded_and_compiled(folder, "this", {}) == (0, 1)
    assert loaded_and_compiled(folder, "this", {}) == (1, 0)
    assert loaded_and_compiled(folder, "another", {}) == (0, 1)


def test_kernels_are_loaded_after_their_files_got_another_time(folder):
    """Copying from one stage of the image to the next may round the times of files."""
    assert loaded_and_compiled(folder, "this", FIXED_CPU) == (0, 1)
    os.utime(folder / "twice.py", (1_000_000_000, 1_000_000_000))
    assert loaded_and_compiled(folder, "this", FIXED_CPU) == (1, 0)
