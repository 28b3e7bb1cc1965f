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
from numba.core.dispatcher import Dispatcher

def signatures():
    return {
        (name, attribute): len(value.signatures)
        for name, module in list(sys.modules.items()) if name.startswith("gamutcore.")
        for attribute, value in vars(module).items() if isinstance(value, Dispatcher)
    }

def changed(before):
    after = signatures()
    return sorted(".".join(k) for k in after if after[k] != before.get(k, 0))
"""

BUILDING = """
from gamutcore.warm import compile_kernels
compile_kernels()
before = signatures()
from gamutcore.export import FORMATS, mesh_file
from gamutcore.gamut import Gamut, Options, build_gamut
from gamutcore.metric import mismatch, voxel_mismatch
root = Path(sys.argv[1])
for path in ("examples/FOGRA39L.ti3", "tests/data/sRGB-v4.icc", "tests/data/DisplayP3-v4.icc"):
    for options in (
        Options(surface_samples=2000),
        Options(surface_samples=2000, cost="quadric", boundary="convex-hull", intent="absolute"),
        Options(surface_samples=2000, boundary="segment-maxima"),
        Options(surface_samples=2000, boundary="usv"),
    ):
        gamut = build_gamut((root / path).read_bytes(), options)
read = Gamut.from_bytes(gamut.to_bytes())
for name in FORMATS:
    mesh_file(read.level(300), name, {"title": "x"})
cursor = read.history.cursor(100)
cursor.finer(20)
cursor.coarser(30)
mismatch(read.history.full(), cursor.mesh)
voxel_mismatch(read.history.full(), cursor.mesh)
print(json.dumps({"compiled": sum(before.values()), "new": changed(before)}))
"""

READING = """
from gamutcore.warm import compile_reading_kernels
compile_reading_kernels()
before = signatures()
from gamutcore.export import FORMATS, mesh_file
from gamutcore.gamut import Gamut
from gamutcore.metric.level_search import Bounds, LevelSearch
read = Gamut.from_bytes(Path(sys.argv[1]).read_bytes())
LevelSearch(read.history.triangles, []).find(read.history, Bounds(1e-3, 1e-3))
for triangles in (4, 100, read.history.triangles):
    for name in FORMATS:
        mesh_file(read.level(triangles), name, {"title": "x"})
print(json.dumps({"compiled": sum(before.values()), "new": changed(before)}))
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


def test_building_and_reading_need_no_further_compilation():
    found = outcome(BUILDING, ROOT)
    assert found["compiled"] > 10
    assert found["new"] == []


@pytest.mark.parametrize("name", ["small_gamut", "fogra39_gamut"])
def test_reading_needs_only_its_own_kernels(request, name, tmp_path):
    """Of bare colours, and with device values."""
    path = tmp_path / "gamut"
    path.write_bytes(request.getfixturevalue(name).to_bytes())
    found = outcome(READING, path)
    assert found["compiled"] > 3
    assert found["new"] == []


def test_from_a_shell():
    ended = subprocess.run(
        [sys.executable, "-m", "gamutcore.warm"],
        cwd=ROOT,
        check=False,
        capture_output=True,
        text=True,
    )
    assert (ended.returncode, ended.stdout) == (0, ""), ended.stderr
