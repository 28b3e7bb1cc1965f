"""Ablation of the decimation: switch one mechanism off, and measure accuracy and time.

``python -m benchmarks.ablation`` measures the mechanisms of the present code on all devices, merges
the rows into ``benchmarks/ablation.json`` and writes the table of ``docs/decisions/costs.md``. Rows
of mechanisms that no switch reaches, or that are no longer in the code, stay in the file as they
were measured. The column *version* gives the algorithm version of each measurement.

A switch replaces a parameter of a cost, or a constant of a module. Kernels compile constants in, so
each row runs in a process of its own with an empty cache directory. That takes about 15 minutes.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from benchmarks.devices import devices, exact_mismatch, sphere
from benchmarks.markdown import table, update_document
from gamutcore.decimation import decimate, decimation
from gamutcore.decimation.costs import cost_named
from gamutcore.history import build_history
from gamutcore.version import ALGORITHM_VERSION

__all__ = ["MECHANISMS", "Mechanism"]

RESULTS = Path(__file__).with_suffix(".json")
DOCUMENT = Path(__file__).parent.parent / "docs/decisions/costs.md"
COUNTS = (1000, 500, 100, 50, 20)
COSTS = ("volume", "finest")
REPEATS = 3
NEVER = 1 << 40
PACKAGE = "gamutcore.decimation"


class Mechanism(NamedTuple):
    """How to switch a mechanism off.

    Attributes
    ----------
    parameters : dict
        Parameters of the cost to replace.
    cost : dict
        Other fields of the cost to replace.
    constants : dict
        Constants to replace, by module and name.
    """

    parameters: dict[str, Any] = {}  # noqa: RUF012  # not mutated
    cost: dict[str, Any] = {}  # noqa: RUF012
    constants: dict[str, Any] = {}  # noqa: RUF012


MECHANISMS = {
    "nothing": Mechanism(),
    "errors by mismatch": Mechanism(
        {"compared_vertices": 0, "moved_vertices": 0}, {"trials": None}
    ),
    "trials": Mechanism(cost={"trials": None}),
    "compaction": Mechanism(cost={"compacted": ()}),
    "refinement": Mechanism(constants={"costs.refinement.REFINEMENTS": 0}),
    "second step of refinement": Mechanism(constants={"costs.refinement.REFINEMENTS": 1}),
    "moves of `finest`": Mechanism({"moved_vertices": 0}),
    "rounds of moves 2 to 4": Mechanism(constants={"relaxation.ROUNDS": 1}),
    "thinning of samples": Mechanism({"samples_per_face": NEVER}),
    "eager evaluation near the end": Mechanism({"eager_collapses": 0}),
    "lazy evaluation before": Mechanism({"eager_collapses": NEVER}),
    "large errors wait": Mechanism(constants={"collapse.LARGE": np.inf}),
    "sweeps": Mechanism(constants={"stages.SWEPT_DOWN_TO": NEVER}),
    "blocks of sweeps": Mechanism(constants={"sweeps.WHOLE": np.inf}),
    "dense links wait": Mechanism(constants={"costs.deviation.DENSE_LINK": NEVER}),
    "limit of enclosed volume": Mechanism(constants={"costs.deviation.GROWTH": np.inf}),
    "limit of repayment": Mechanism(constants={"costs.dispatch.LARGEST_REPAYMENT": np.inf}),
    "protection from slivers": Mechanism(constants={"relaxation.FATNESS": 0.0}),
    "length penalty of quadrics": Mechanism(constants={"costs.memoryless_quadrics.FLATNESS": 0.0}),
    "length penalty of mismatch": Mechanism(constants={"costs.deviation.FLATNESS": 0.0}),
}
"""The mechanisms of the present code. The first one is the reference."""


def main() -> int:
    """Measure the mechanisms that the command line names, all of them if none."""
    if sys.argv[1:2] == ["--one"]:
        json.dump(measure(MECHANISMS[sys.argv[2]]), sys.stdout)
        return 0
    results = json.loads(RESULTS.read_text()) if RESULTS.exists() else {}
    reference = in_process("nothing")
    for name in sys.argv[1:] or list(MECHANISMS)[1:]:
        row = in_process(name)
        results[name] = results.get(name, {}) | {
            "version": ALGORITHM_VERSION,
            "compile": round(reference["compile"] - row["compile"], 1),
            **{cost: relative(row[cost], reference[cost]) for cost in COSTS},
        }
        # an interrupted run keeps its rows
        RESULTS.write_text(json.dumps(results, indent=1, ensure_ascii=False) + "\n")
        update_document(DOCUMENT, {"ablation": ablation_table(results)})
        print(name, file=sys.stderr)
    return 0


def in_process(name: str) -> Any:  # noqa: ANN401  # what JSON holds
    """Measure a mechanism in a process of its own, with an empty cache of kernels."""
    with tempfile.TemporaryDirectory() as cache:
        done = subprocess.run(
            [sys.executable, "-m", "benchmarks.ablation", "--one", name],
            env=os.environ | {"NUMBA_CACHE_DIR": cache},
            stdout=subprocess.PIPE,
            check=True,
        )
    return json.loads(done.stdout)


def measure(mechanism: Mechanism) -> dict[str, Any]:
    """Return the results without a mechanism.

    By cost, these are mismatches and seconds of each device. ``compile`` is the processor time of
    the first decimations.
    """
    for place, value in mechanism.constants.items():
        module, _, constant = place.rpartition(".")
        setattr(import_module(f"{PACKAGE}.{module}"), constant, value)

    def changed(name: str) -> Any:  # noqa: ANN401
        cost = cost_named(name)
        # a mechanism that a cost does not have stays off
        replaced = {
            key: value
            for key, value in mechanism.parameters.items()
            if getattr(cost.parameters, key)
        }
        return cost._replace(parameters=cost.parameters._replace(**replaced), **mechanism.cost)

    setattr(decimation, "cost_named", changed)  # noqa: B010  # a module attribute
    found: dict[str, Any] = {cost: {"mismatch": [], "seconds": []} for cost in COSTS}
    small, start = sphere(200), time.process_time()
    for cost in COSTS:
        decimate(small, (50.0, 0.0, 0.0), cost)
    found["compile"] = time.process_time() - start
    for device in devices():
        mesh, centre = device.boundary.mesh, device.boundary.centre
        for cost in COSTS:
            seconds = []
            for _ in range(REPEATS):
                start = time.process_time()
                result = decimate(mesh, centre, cost)
                seconds.append(time.process_time() - start)
            history = build_history(result)
            found[cost]["mismatch"].append(
                [exact_mismatch(mesh, history.level(count), centre) for count in COUNTS]
            )
            found[cost]["seconds"].append(min(seconds))
    return found


def relative(row: dict[str, Any], reference: dict[str, Any]) -> dict[str, Any]:
    """Return mean mismatches and the time of a row, relative to the reference."""
    ratios = np.array(row["mismatch"]) / np.array(reference["mismatch"])
    return {
        "mismatch": [round(float(ratio), 3) for ratio in ratios.mean(axis=0)],
        "time": round(sum(row["seconds"]) / sum(reference["seconds"]), 2),
    }


def ablation_table(results: dict[str, Any]) -> str:
    """Return the table of all rows."""
    head = ["without", "lines", "compile, s", "decision", "version"]
    for cost in COSTS:
        head += [f"`{cost}` at {COUNTS[0]}", *map(str, COUNTS[1:]), "time"]
    rows = []
    for name, row in results.items():
        cells = [name, str(row.get("lines", "–")), str(row.get("compile", "–"))]
        cells += [row.get("decision", "kept"), str(row.get("version", "10"))]
        for cost in COSTS:
            if cost in row:
                cells += [f"{value:.3f}" for value in row[cost]["mismatch"]]
                cells.append(f"{row[cost]['time']:.2f}")
            else:
                cells += ["–"] * (len(COUNTS) + 1)
        rows.append(cells)
    return table(head, rows)


if __name__ == "__main__":
    sys.exit(main())
