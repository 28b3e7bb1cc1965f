"""Kernels as plain Python: the same bytes, levels and errors as their machine code."""

import hashlib
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from gamutcore.geometry import DeviceValues
from gamutcore.history import (
    History,
    build_device_history,
    history_bytes,
    history_from_bytes,
)
from gamutcore.levels import curve_counts, error_curve, radial_difference


def digests(path):
    """Return digests of the levels, bytes and errors that a history file gives."""
    history, _ = history_from_bytes(Path(path).read_bytes())
    cursor = history.cursor(20)
    cursor.finer(9)
    cursor.coarser(2)
    meshes = [cursor.mesh, *(history.level(count) for count in (4, 30, history.triangles))]
    values = history.device_values(30).values
    coarse = radial_difference(history.full(), history.level(30), history.centre)
    curve = error_curve(history, curve_counts(history.triangles))
    parts = {
        "file": history_bytes(history),
        "levels": b"".join(mesh.vertices.tobytes() + mesh.faces.tobytes() for mesh in meshes),
        "values": values.tobytes(),
        "difference": repr([float(coarse.difference), float(coarse.to_reference.maximum)]).encode(),
        "curve": json.dumps([level.to_mapping() for level in curve]).encode(),
    }
    return {name: hashlib.sha256(part).hexdigest() for name, part in parts.items()}


@pytest.mark.parametrize("name", ["small_history", "shifting_history"])
@pytest.mark.slow
def test_plain_python_gives_the_same_bytes(name, request, tmp_path, first_levels):
    path = tmp_path / "history"
    history = first_levels(request.getfixturevalue(name), 60)
    values = DeviceValues(("K",), np.random.default_rng(1).random((60, 1), np.float32))
    device = build_device_history(values, np.arange(60, dtype=np.int32), history.splits)
    path.write_bytes(history_bytes(History(history.splits, history.centre, history.step, device)))
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    command = [sys.executable, "-W", "error:overflow", __file__, str(path)]
    plain = subprocess.run(command, check=False, capture_output=True, env=environment, text=True)
    assert plain.returncode == 0, plain.stderr
    assert json.loads(plain.stdout) == digests(path)


if __name__ == "__main__":
    sys.stdout.write(json.dumps(digests(sys.argv[1])))
