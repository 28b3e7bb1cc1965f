"""Kernels as plain Python: with NUMBA_DISABLE_JIT=1 a decimation is the same bit for bit."""

import os
import subprocess
import sys

import numpy as np
import pytest

from gamutcore.decimation import COSTS

PROGRAM = """
import sys
import numpy as np
from gamutcore.decimation import COSTS, collapse, schedule
from gamutcore.decimation.costs import Trials, cost_named
from gamutcore.geometry import TriangleMesh

def small(name):
    # few samples and trials, because plain Python is hundreds of times slower
    cost = cost_named(name)
    parameters = cost.parameters._replace(samples=min(cost.parameters.samples, 100))
    return cost._replace(parameters=parameters, trials=cost.trials and Trials(16, 2, 10))

schedule.cost_named = small
source = np.load(sys.argv[1])
mesh = TriangleMesh(source["vertices"], source["faces"])
found = {}
for name in COSTS:
    result = schedule.decimate(mesh, source["centre"], name)
    found.update({f"{name} {field}": array for field, array in result.record._asdict().items()})
    found[f"{name} vertex"], found[f"{name} positions"] = result.vertex, result.positions
np.savez(sys.argv[2], signatures=len(getattr(collapse.collapse_edges, "signatures", ())), **found)
"""


@pytest.fixture(scope="module")
def both(tmp_path_factory, icosphere):
    """Return the decimations of a small boundary by compiled kernels and by plain Python."""
    folder, mesh = tmp_path_factory.mktemp("plain"), icosphere(1, 40.0)
    random = np.random.default_rng(0)
    vertices = mesh.vertices * random.uniform(0.95, 1.05, (len(mesh.vertices), 1))
    assert len(vertices) == 42
    source = folder / "mesh.npz"
    np.savez(source, vertices=vertices.astype(np.float32), faces=mesh.faces, centre=np.zeros(3))
    found = []
    for disabled in ("0", "1"):
        target = folder / f"{disabled}.npz"
        subprocess.run(
            [sys.executable, "-W", "error::RuntimeWarning", "-c", PROGRAM, source, target],
            check=True,
            env=os.environ | {"NUMBA_DISABLE_JIT": disabled},
        )
        found.append(np.load(target))
    return found


@pytest.mark.parametrize("cost", COSTS)
@pytest.mark.slow
def test_the_records_are_equal_bit_for_bit(both, cost):
    compiled, plain = both
    names = [name for name in compiled.files if name.startswith(cost)]
    assert len(names) == 12
    assert len(compiled[f"{cost} kept"]) == 38
    for name in names:
        assert compiled[name].tobytes() == plain[name].tobytes(), name


@pytest.mark.slow
def test_one_signature_of_the_collapse_loop_serves_all_costs(both):
    compiled, plain = both
    assert compiled["signatures"] == 1
    assert plain["signatures"] == 0
