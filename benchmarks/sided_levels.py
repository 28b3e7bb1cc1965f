"""Mismatch and time of levels on one side, at 1,000 triangles.

``python -m benchmarks.sided_levels`` writes ``benchmarks/sided_levels.json`` and prints a table for
``docs/decisions/sided-levels.md``.
"""

from __future__ import annotations

import json
import time

from benchmarks.common import ROOT, build_mesh_history
from benchmarks.devices import devices
from benchmarks.markdown import table
from gamutcore.metric.radial_overlay import radial_difference
from gamutcore.sides import sided_level

TRIANGLES = 1000


def main() -> None:
    """Measure all devices and write the results."""
    rows = []
    for device in devices():
        mesh, centre = device.boundary.mesh, device.boundary.centre
        history = build_mesh_history(mesh, centre)
        full = history.full()
        both = radial_difference(full, history.level(TRIANGLES), centre).mismatch
        row: dict[str, float | str] = {"device": device.name, "both": both}
        for side in ("inside", "outside"):
            sided_level(history, TRIANGLES, side)
            start = time.process_time()
            level = sided_level(history, TRIANGLES, side)
            row[f"{side}_s"] = time.process_time() - start
            row[side] = radial_difference(full, level, centre).mismatch / both
        rows.append(row)
    path = ROOT / "benchmarks" / "sided_levels.json"
    path.write_text(json.dumps({"triangles": TRIANGLES, "rows": rows}, indent=1) + "\n")
    head = ["device", "inside ÷ both", "outside ÷ both", "time, ms"]
    print(
        table(
            head,
            [
                [
                    str(row["device"]),
                    f"{row['inside']:.2f}",
                    f"{row['outside']:.2f}",
                    f"{1e3 * max(float(row['inside_s']), float(row['outside_s'])):.0f}",
                ]
                for row in rows
            ],
        )
    )


if __name__ == "__main__":
    main()
