"""The kernel cache under another CPU, which the image relies on, and the image's name.

``make image-check`` builds and runs the image itself.
"""

import os
import platform
import re
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from gamutcore.version import __version__

ROOT = Path(__file__).parent.parent
DOCKERFILE = (ROOT / "Dockerfile").read_text()
STAGES = DOCKERFILE.split("\nFROM ")[1:]
FIXED_CPU = dict(re.findall(r'(NUMBA_CPU_\w+)="?(\w*)', STAGES[-1]))

OLD_CPU = "nocona" if platform.machine() == "x86_64" else "cortex-a53"
"""A CPU that LLVM knows and that no current machine has."""

MAIN = f"""
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
    (tmp_path / "main.py").write_text(MAIN)
    return tmp_path


def loads_and_compilations(folder, cpu, variables):
    """Call the kernel in a new process; count how often it was loaded and compiled."""
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


@pytest.mark.slow
def test_kernels_for_a_fixed_cpu_load_on_another_and_after_a_copy(folder):
    assert loads_and_compilations(folder, "this", FIXED_CPU) == (0, 1)
    # Copying from one stage of the image to the next may round the times of files.
    os.utime(folder / "twice.py", (1_000_000_000, 1_000_000_000))
    assert loads_and_compilations(folder, "another", FIXED_CPU) == (1, 0)


@pytest.mark.slow
def test_kernels_for_the_host_do_not_load_on_another_cpu(folder):
    """The control of the test above."""
    assert loads_and_compilations(folder, "this", {}) == (0, 1)
    assert loads_and_compilations(folder, "this", {}) == (1, 0)
    assert loads_and_compilations(folder, "another", {}) == (0, 1)


def test_both_stages_have_one_base_and_one_cpu():
    assert re.search(r"^ARG BASE=python:3\.11\.\d+-slim-bookworm$", DOCKERFILE, re.MULTILINE)
    assert len(STAGES) == 2
    for stage in STAGES:
        assert stage.startswith("${BASE}")
        assert "NUMBA_CPU_NAME=generic" in stage
        assert 'NUMBA_CPU_FEATURES=""' in stage


def test_compose_and_the_chart_name_the_image_that_is_built():
    compose = (ROOT / "deploy" / "compose.yaml").read_text()
    assert f"${{GAMUT_IMAGE:-gamut-boundary-service:{__version__}}}" in compose
    chart = ROOT / "deploy" / "helm" / "gamut"
    values = yaml.safe_load((chart / "values.yaml").read_text())["image"]
    version = yaml.safe_load((chart / "Chart.yaml").read_text())["appVersion"]
    assert (values["repository"], values["tag"]) == ("gamut-boundary-service", "")
    assert version == __version__
    built = (ROOT / "docker" / "image.py").read_text()
    assert 'f"gamut-boundary-service:{__version__}"' in built
