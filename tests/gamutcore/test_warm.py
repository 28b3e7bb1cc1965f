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
from gamutcore.kernels import KERNELS
from gamutcore.warm import use_kernels

def signatures():
    return {f"{k.py_func.__module__}.{k.py_func.__name__}": len(k.signatures) for k in KERNELS}

def report(before):
    after = signatures()
    new = sorted(name for name in after if after[name] != before.get(name, 0))
    print(json.dumps({"used": sum(before.values()), "new": new}))

from gamutcore.export import FORMATS, mesh_file
from gamutcore import Gamut, Options

def write(level):
    three = level.device is not None and len(level.device.channels) == 3
    for name in FORMATS:
        if three or name != "cge":
            mesh_file(level, name, {"title": "x"})
"""

BUILDS_AND_READING = """
use_kernels("default")
before = signatures()
from gamutcore.levels import LevelRequest, LevelSearch
root, folder = Path(sys.argv[1]), Path(sys.argv[2])
built = [
    Gamut((root / path).read_bytes(), surface_samples=2000).to_bytes()
    for path in ("examples/FOGRA39L.ti3", "tests/data/sRGB-v4.icc", "tests/data/DisplayP3-v4.icc")
]
for data in (*built, *(path.read_bytes() for path in folder.iterdir())):
    read = Gamut.from_bytes(data)
    search, request = LevelSearch(read.description["levels"]), LevelRequest(None, 1e-3, 1e-3)
    search.find(read.history, request)
    for triangles in (4, 300, read.history.triangles):
        write(read.level(triangles))
report(before)
"""

OPTIONS = """
use_kernels("default")
use_kernels("optional")
before = signatures()
from gamutcore.levels import voxel_mismatch
root = Path(sys.argv[1])
press, lut, matrix = (
    (root / path).read_bytes()
    for path in ("examples/FOGRA39L.ti3", "tests/data/sRGB-v4.icc", "tests/data/DisplayP3-v4.icc")
)
hull = {"cost": "quadric", "boundary": "convex-hull", "intent": "absolute"}
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


def outcome(script, *arguments):
    ended = subprocess.run(
        [sys.executable, "-c", SIGNATURES + script, *map(str, arguments)],
        cwd=ROOT,
        check=False,
        capture_output=True,
        text=True,
    )
    assert ended.returncode == 0, ended.stderr
    return json.loads(ended.stdout)


@pytest.mark.slow
def test_builds_with_default_options_and_reading_need_the_default_group_alone(
    small_gamut, fogra39_gamut, tmp_path
):
    """Of bare colours, and with device values."""
    (tmp_path / "bare").write_bytes(small_gamut.to_bytes())
    (tmp_path / "device").write_bytes(fogra39_gamut.to_bytes())
    found = outcome(BUILDS_AND_READING, ROOT, tmp_path)
    assert found["used"] > 10
    assert found["new"] == []


@pytest.mark.slow
def test_other_options_and_metrics_need_no_further_kernel():
    assert outcome(OPTIONS, ROOT)["new"] == []


@pytest.mark.slow
@pytest.mark.parametrize("group", kernels.GROUPS)
def test_the_number_of_kernels_that_a_service_promises_is_right(group):
    script = (
        "import sys\n"
        "from gamutcore.kernels import watchers\n"
        "from gamutcore.warm import use_kernels\n"
        "names = set()\n"
        "watchers.append(names.add)\n"
        "use_kernels(sys.argv[1])\n"
        "print(len(names))\n"
    )
    ended = subprocess.run(
        [sys.executable, "-c", script, group], cwd=ROOT, check=True, capture_output=True, text=True
    )
    assert int(ended.stdout) == kernels.ENTRY_POINTS[group]


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
