"""After warming nothing makes the compiler start: checked in fresh processes."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from gamutcore import kernels

ROOT = Path(__file__).parents[2]

SIGNATURES = """
import json, sys
from pathlib import Path
import numpy as np
from gamutcore.kernels import KERNELS, watchers
from gamutcore.warm import use_kernels

names = set()
watchers.append(names.add)
group, root = sys.argv[1], Path(sys.argv[2])
use_kernels(group)
entry_points = len(names)

def signatures():
    return {f"{k.py_func.__module__}.{k.py_func.__name__}": len(k.signatures) for k in KERNELS}

def report(before):
    after = signatures()
    new = sorted(name for name in after if after[name] != before.get(name, 0))
    print(json.dumps({"entry_points": entry_points, "used": sum(before.values()), "new": new}))

from gamutcore.export import FORMATS, mesh_file
from gamutcore import Gamut, Options

press, lut, matrix = (
    (root / path).read_bytes()
    for path in ("examples/FOGRA39L.ti3", "tests/data/sRGB-v4.icc", "tests/data/DisplayP3-v4.icc")
)

def write(level):
    three = level.device is not None and len(level.device.channels) == 3
    for name in FORMATS:
        if three or name != "cge":
            mesh_file(level, name, {"title": "x"})
"""

DEFAULT = """
before = signatures()
from gamutcore.levels import LevelRequest, LevelSearch
bare = np.random.default_rng(0).normal(size=(300, 3))
bare = 40 * bare / np.linalg.norm(bare, axis=1, keepdims=True) + (50, 0, 0)
for data in (press, lut, matrix, bare):
    samples = {} if data is bare else {"surface_samples": 2000}
    read = Gamut.from_bytes(Gamut(data, **samples).to_bytes())
    search, request = LevelSearch(read.description["levels"]), LevelRequest(None, 1e-3, 1e-3)
    search.find(read.history, request)
    for triangles in (4, 300, read.history.triangles):
        write(read.level(triangles))
report(before)
"""

OPTIONAL = """
use_kernels("default")
before = signatures()
from gamutcore.boundary import voxel_mismatch
hull = {"cost": "quadric", "gamma": 1, "intent": "absolute"}
for data, options in (
    *((press, each) for each in ({"cost": "finest"}, hull, {"boundary": "segment-maxima"})),
    (lut, {"boundary": "usv"}), (lut, {"cost": "finest"}),
    (matrix, hull), (matrix, {"boundary": "segment-maxima"}), (press, {"boundary": "usv"}),
):
    gamut = Gamut(data, Options(surface_samples=1000, **options))
read = Gamut.from_bytes(gamut.to_bytes())
cursor = read.history.cursor(100)
cursor.finer(20)
cursor.coarser(30)
voxel_mismatch(read.history.full(), cursor.mesh)
report(before)
"""

CIEDE2000 = "report(signatures())"

USES = {"default": DEFAULT, "optional": OPTIONAL, "ciede2000": CIEDE2000}
"""What needs no kernel beyond a group: builds with default options, of bare colours and with device
values, and reading; then other options and metrics, beside the first group."""


@pytest.mark.slow
@pytest.mark.parametrize("group", kernels.GROUPS)
def test_a_group_has_the_promised_kernels_and_its_uses_need_no_others(group):
    """One process for each group: importing and loading the kernels takes most of the time."""
    ended = subprocess.run(
        [sys.executable, "-c", SIGNATURES + USES[group], group, str(ROOT)],
        cwd=ROOT,
        check=False,
        capture_output=True,
        text=True,
    )
    assert ended.returncode == 0, ended.stderr
    told = json.loads(ended.stdout)
    assert told["entry_points"] == kernels.ENTRY_POINTS[group]
    assert told["used"] > 10
    assert told["new"] == []


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
