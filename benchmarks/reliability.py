"""What is promised about running for long and failing well, and what was measured of it.

The programs of `make soak` and `make faults` end by recording their rows here: they are merged into
``benchmarks/reliability.json``, and ``docs/reliability.md`` is written anew from all of it. A row
that was not met is recorded like one that was.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from benchmarks.bench import machine
from benchmarks.markdown import table

__all__ = ["Row", "recorded"]

RECORD = Path(__file__).with_name("reliability.json")
DOCUMENT = Path(__file__).parent.parent / "docs" / "reliability.md"

GROUPS = {
    "speed": "Speed of one API process",
    "soak": "Under load, for long",
    "faults": "Faults",
    "hostile": "Hostile clients and files",
}

INTRODUCTION = """\
Written by `make soak` and `make faults` (benchmarks/reliability.py), each row by the run that it
tells of; the same figures are in benchmarks/reliability.json. What the service promises: the
content of a 200 answer always matches its ETag's digest; a job that was reported as succeeded
survives `kill -9`; identical requests build once, and once more after a crash; losing a cache costs
time, never correctness. Emulators stand for the cloud's stores: they prove what the client does,
not the durability of a bucket.
"""


@dataclass(frozen=True)
class Row:
    """One promise and what was measured.

    Attributes
    ----------
    key : str
        Stable name; a later run with the same key replaces the row.
    group : str
        A key of `GROUPS`.
    what, goal, measured : str
        In words, with units.
    met : bool
        Whether what was measured keeps to the goal.
    """

    key: str
    group: str
    what: str
    goal: str
    measured: str
    met: bool


def recorded(rows: Iterable[Row]) -> bool:
    """Record rows, write the document, and return whether all of these rows were met."""
    rows = list(rows)
    kept: dict[str, Any] = json.loads(RECORD.read_text()) if RECORD.exists() else {}
    made_on = machine()
    for row in rows:
        kept[row.key] = {**asdict(row), "machine": made_on}
    RECORD.write_text(json.dumps(kept, indent=1, ensure_ascii=False, sort_keys=True) + "\n")
    DOCUMENT.write_text(document(kept))
    return all(row.met for row in rows)


def document(kept: dict[str, Any]) -> str:
    """Return the text of docs/reliability.md."""
    parts = ["# Reliability", INTRODUCTION]
    for group, title in GROUPS.items():
        rows = [row for _, row in sorted(kept.items()) if row["group"] == group]
        if rows:
            lines = [
                [row["what"], row["goal"], row["measured"], "yes" if row["met"] else "**no**"]
                for row in rows
            ]
            parts += [f"## {title}", table(("what", "goal", "measured", "met"), lines) + "\n"]
    made_on = (row["machine"] for row in kept.values())
    machines = sorted(
        {
            f"- {one['date']}: {one['cpu']}, {one['cores']} cores, {one['system']}, "
            f"Python {one['python']}"
            for one in made_on
        }
    )
    parts += ["## Machines", "\n".join(machines) + "\n"]
    return "\n\n".join(part.strip() for part in parts) + "\n"
