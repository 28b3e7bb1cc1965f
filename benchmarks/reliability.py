"""Record the promises of reliability and the results of their last run.

``make soak`` and ``make faults`` pass their results to `record`, which merges them into
``benchmarks/reliability.json`` and updates the tables of ``docs/reliability.md``. A broken promise
is recorded like a kept one.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, NamedTuple

from benchmarks.common import machine
from benchmarks.markdown import table, update_document

__all__ = ["DOCUMENT", "PROMISES", "RESULTS", "Promise", "Result", "document_blocks", "record"]

RESULTS = Path(__file__).with_name("reliability.json")
DOCUMENT = Path(__file__).parent.parent / "docs" / "reliability.md"

GROUPS = ("soak", "faults", "hostile")


class Promise(NamedTuple):
    """A promise: its group, the situation, and what must hold in it."""

    group: str
    situation: str
    target: str


PROMISES = {
    "soak-answers": Promise("soak", "answers to a long mixture of requests", "all as expected"),
    "soak-livez": Promise(
        "soak", "`/livez` while builds wait and two workers build", "p99 ≤ 50 ms"
    ),
    "soak-memory": Promise(
        "soak",
        "memory of an API process during the mixture, after as many requests for warming up",
        "slope ≤ 1 MiB per 10,000 requests",
    ),
    "faults-cluster-rabbitmq": Promise(
        "faults",
        "three API replicas, two workers, RabbitMQ and a shared bucket: identical POSTs, and "
        "processes killed during builds",
        "one build of identical requests, identical bytes, every accepted build succeeds",
    ),
    "faults-cluster-redis": Promise(
        "faults",
        "three API replicas, two workers, Redis and a shared bucket: identical POSTs, and "
        "processes killed during builds",
        "one build of identical requests, identical bytes, every accepted build succeeds",
    ),
    "faults-damage": Promise(
        "faults",
        "every stored history and record with a flipped bit, then truncated",
        "detected on read, counted, built again, never served",
    ),
    "faults-disconnect": Promise(
        "faults",
        "the first client disconnects during a build",
        "the build finishes and other clients get it",
    ),
    "faults-formats": Promise(
        "faults", "GLB through the Khronos validator, PLY through two other readers", "no errors"
    ),
    "faults-full-disk": Promise(
        "faults",
        "disk full (a small file system, and injected errors)",
        "507, existing gamuts are served, recovery without a restart",
    ),
    "faults-identical-1": Promise(
        "faults", "identical POSTs at the same time, one replica", "one build, identical bytes"
    ),
    "faults-poison": Promise(
        "faults",
        "inputs that exhaust memory or time, or crash every worker",
        "at most 3 attempts, then failed with the reason; other jobs are not affected",
    ),
    "faults-service-kills": Promise(
        "faults",
        "SIGKILL and SIGTERM of the service in turn, with builds running and waiting",
        "every accepted build (202) succeeds after a restart",
    ),
    "faults-store-kills": Promise(
        "faults",
        "SIGKILL at every write, fsync, link, rename and unlink of the store",
        "≥ 500 kills, nothing lost or corrupt, every restart clean",
    ),
    "faults-worker-kills": Promise(
        "faults",
        "SIGKILL of the build worker during a build, one machine",
        "100 kills, every accepted build succeeds",
    ),
    "hostile-clients": Promise(
        "hostile",
        "10 GB chunked body, decompression bombs, large forms, slow heads, slow bodies, slow "
        "readers, expensive level searches",
        "answered with 413, 415, 408 or the level; memory grows by at most 64 MB; other clients "
        "are served",
    ),
    "hostile-fuzz": Promise(
        "hostile",
        "mutated files for every parser",
        "no crash; at most 2 s of processor time and 512 MB per file",
    ),
    "hostile-schemathesis": Promise(
        "hostile", "requests that schemathesis generates from the OpenAPI document", "no failures"
    ),
}


@dataclass(frozen=True)
class Result:
    """The result of a run.

    Attributes
    ----------
    key : str
        Key of `PROMISES`. A later run replaces the result.
    measured : str
        Figures with their units.
    met : bool
        Whether the promise was kept.
    """

    key: str
    measured: str
    met: bool

    def __str__(self) -> str:
        mark = "ok " if self.met else "NOT"
        return f"{mark} {PROMISES[self.key].situation}: {self.measured}"


def record(results: Iterable[Result]) -> None:
    """Merge results into the file and update the document."""
    stored: dict[str, Any] = json.loads(RESULTS.read_text()) if RESULTS.exists() else {}
    made_on = machine()
    for result in results:
        stored[result.key] = {**asdict(result), "machine": made_on}
    RESULTS.write_text(json.dumps(stored, indent=1, ensure_ascii=False, sort_keys=True) + "\n")
    update_document(DOCUMENT, document_blocks(stored))


def document_blocks(stored: dict[str, Any]) -> dict[str, str]:
    """Return the generated blocks of docs/reliability.md."""
    contents = {}
    for group in GROUPS:
        rows = [
            [
                promise.situation,
                promise.target,
                stored[key]["measured"] if key in stored else "not run",
                "–" if key not in stored else "yes" if stored[key]["met"] else "**no**",
            ]
            for key, promise in PROMISES.items()
            if promise.group == group
        ]
        contents[group] = table(["situation", "target", "measured", "met"], rows)
    machines = {
        f"- {made_on['date']}: {made_on['cpu']}, {made_on['cores']} cores, {made_on['system']}, "
        f"Python {made_on['python']}"
        for made_on in (row["machine"] for row in stored.values())
    }
    return {**contents, "machines": "\n".join(sorted(machines))}
