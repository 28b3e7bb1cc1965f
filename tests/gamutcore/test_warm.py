"""After warming nothing makes the compiler start: checked in fresh processes."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

SIGNATURES = """
import json, sys
from pathlib import Path
from gamutcore.kernels.decorators import KERNELS
from gamutcore.warm import use_kernels

def signatures():
    return {f"{k.py_func.__module__}.{k.py_func.__name__}": len(k.signatures) for k in KERNELS}

def report(before):
    after = signatures()
    new = sorted(name for name in after if after[name] != before.get(name, 0))
    several = sorted(name for name in after if after[name] > 1)
    print(json.dumps({"used": sum(before.values()), "new": new, "several": several}))

from gamutcore.export import FORMATS, mesh_file
from gamutcore import Gamut, Options

def write(level):
    three = level.device is not None and len(level.device.channels) == 3
    for name in FORMATS:
        if three or name != "cge":
            mesh_file(level, name, {"title": "x"})
"""

DEFAULT = """
use_kernels("default")
before = signatures()
root = Path(sys.argv[1])
for path in ("examples/FOGRA39L.ti3", "tests/data/sRGB-v4.icc", "tests/data/DisplayP3-v4.icc"):
    gamut = Gamut((root / path).read_bytes(), surface_samples=20000)
    read = Gamut.from_bytes(gamut.to_bytes())
    write(read.level(300))
report(before)
"""

OPTIONS = """
use_kernels("default")
use_kernels("optional")
before = signatures()
from gamutcore.metric import mismatch, voxel_mismatch
root = Path(sys.argv[1])
for path in ("examples/FOGRA39L.ti3", "tests/data/sRGB-v4.icc", "tests/data/DisplayP3-v4.icc"):
    for options in (
        Options(surface_samples=2000, cost="finest"),
        Options(surface_samples=2000, cost="quadric", boundary="convex-hull", intent="absolute"),
        Options(surface_samples=2000, boundary="segment-maxima"),
        Options(surface_samples=2000, boundary="usv"),
    ):
        gamut = Gamut((root / path).read_bytes(), options)
read = Gamut.from_bytes(gamut.to_bytes())
cursor = read.history.cursor(100)
cursor.finer(20)
cursor.coarser(30)
mismatch(read.history.full(), cursor.mesh)
voxel_mismatch(read.history.full(), cursor.mesh)
report(before)
"""

READING = """
use_kernels("default")
before = signatures()
from gamutcore.metric.level_search import Bounds, LevelSearch
for path in Path(sys.argv[1]).iterdir():
    read = Gamut.from_bytes(path.read_bytes())
    LevelSearch(read.description["levels"]).find(read.history, Bounds(1e-3, 1e-3))
    for triangles in (4, 100, read.history.triangles):
        write(read.level(triangles))
report(before)
"""


def outcome(script, argument):
    ended = subprocess.run(
        [sys.executable, "-c", SIGNATURES + script, str(argument)],
        cwd=ROOT,
        check=False,
        capture_output=True,
        text=True,
    )
    assert ended.returncode == 0, ended.stderr
    return json.loads(ended.stdout)


@pytest.mark.slow
def test_a_build_with_default_options_needs_the_default_group_alone():
    found = outcome(DEFAULT, ROOT)
    assert found["used"] > 10
    assert found["new"] == []


@pytest.mark.slow
def test_other_options_and_metrics_need_no_further_kernel():
    found = outcome(OPTIONS, ROOT)
    assert found["new"] == []


@pytest.mark.slow
def test_reading_needs_the_default_group_alone(small_gamut, fogra39_gamut, tmp_path):
    """Of bare colours, and with device values."""
    (tmp_path / "bare").write_bytes(small_gamut.to_bytes())
    (tmp_path / "device").write_bytes(fogra39_gamut.to_bytes())
    assert outcome(READING, tmp_path)["new"] == []


@pytest.mark.slow
def test_from_a_shell():
    ended = subprocess.run(
        [sys.executable, "-m", "gamutcore.warm", "default"],
        cwd=ROOT,
        check=False,
        capture_output=True,
        text=True,
    )
    assert (ended.returncode, ended.stdout) == (0, ""), ended.stderr
