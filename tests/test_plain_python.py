"""Kernels of boundary and colours give the same results with and without Numba's compiler."""

import hashlib
import os
import subprocess
import sys

import numpy as np
import pytest

from gamutcore.boundary import BOUNDARIES, compute_boundary
from gamutcore.colours.device_model import scattered_model
from gamutcore.colours.ink_limits import InkCube
from gamutcore.colours.sampling import device_surface
from gamutcore.colours.spaces import srgb

ROUNDING = 12
"""Decimals that are compared where a compiler may fuse or reorder operations."""


def results():
    """Return digests of what the kernels compute, by name."""
    device = np.stack(np.meshgrid(*[np.linspace(0, 1, 3)] * 3), axis=-1).reshape(-1, 3)
    lab = np.column_stack([100 * device.mean(axis=1), 80 * (device[:, :2] - device[:, 2:])])
    arrays = {"srgb": srgb(lab).round(ROUNDING)}
    bent = lab + 1e-3 * np.sin(7 * device)
    cube = device_surface(InkCube(np.zeros(4), np.ones(4)), lambda values: values[:, :3], 200)
    inks = cube.device[:, :3] * 60 - 25 * cube.device[:, 3:] + np.sin(3 * cube.device[:, 1:])
    for method, entry in BOUNDARIES.items():
        boundary = (
            compute_boundary(inks, method, faces=cube.faces)
            if entry.needs_faces
            else compute_boundary(bent, method)
        )
        arrays[method] = boundary.mesh.vertices[boundary.mesh.faces]
        arrays[f"{method} sources"] = boundary.sources
    arrays["scattered"] = scattered_model(device, lab).colours(device / 2).round(ROUNDING - 3) + 0.0
    return {name: hashlib.sha256(values.tobytes()).hexdigest() for name, values in arrays.items()}


@pytest.mark.slow
def test_plain_python_gives_the_same():
    program = f"import sys; sys.path.insert(0, {os.path.dirname(__file__)!r})\n"  # noqa: PTH120
    program += "import test_plain_python as this; print(this.results())"
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    plain = subprocess.run(
        [sys.executable, "-W", "error", "-c", program],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert plain.returncode == 0, plain.stderr
    assert plain.stdout.strip() == str(results())
