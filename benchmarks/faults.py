"""What is promised about faults, tried out as often as it takes: ``make faults``.

Each step runs a program or a part of the tests on this machine's loopback, says what became of it,
and records its row in docs/reliability.md at once, so that a run that is ended early has recorded
what it has done. ``--only`` runs the steps that are named; ``--scale 0.1`` a tenth of everything.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.compute import FOGRA39L, ROOT
from benchmarks.reliability import Row, recorded

__all__ = ["main"]

FAULTS = ROOT / "tests" / "faults"
SERVICE_TESTS = ROOT / "tests" / "service"

Steps = dict[str, Callable[[float], list[Row]]]


def program(name: str, *arguments: object) -> tuple[int, str, str]:
    """Run a program of tests/faults; exit status, output and the end of its messages."""
    done = subprocess.run(
        [sys.executable, str(FAULTS / name), *map(str, arguments)],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    return done.returncode, done.stdout, done.stderr[-2000:]


@contextlib.contextmanager
def servers() -> Iterator[Callable[..., Any]]:
    """Yield what starts servers as the tests do; those that still run are killed at the end."""
    sys.path[:0] = [str(SERVICE_TESTS), str(FAULTS)]
    from conftest import Server

    started: list[Any] = []
    with tempfile.TemporaryDirectory(prefix="gamut-faults-") as folder:

        def start(data: Path | None = None, **settings: object) -> Any:  # noqa: ANN401 - of the tests
            place = Path(folder) / str(len(started))
            place.mkdir()
            started.append(Server(data or place / "data", place / "log", **settings))
            return started[-1]

        try:
            yield start
        finally:
            for server in started:
                if server.process.poll() is None:
                    server.kill()


def press(surface_samples: int = 150_000) -> dict[str, Any]:
    """What to post for a build of some seconds."""
    return {
        "files": {"file": (FOGRA39L.name, FOGRA39L.read_bytes())},
        "data": {"options": json.dumps({"surface_samples": surface_samples})},
    }


def sphere(seed: int, count: int = 300) -> dict[str, Any]:
    """Return a small body to post."""
    directions = np.random.default_rng(seed).normal(size=(count, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return {"samples": (directions * 40 + (50, 0, 0)).tolist()}


def store_kills(scale: float) -> list[Row]:
    """SIGKILL at the system calls of writes to the store."""
    # Some children have ended before their call comes; they are not counted as kills.
    status, output, errors = program("store_kills.py", "--kills", max(10, int(560 * scale)))
    if status and not output:
        raise RuntimeError(errors)
    figures = json.loads(output.strip().splitlines()[-1])
    kills, lost = figures["kills"], figures["losses"]
    return [
        Row(
            "faults-store-kills",
            "faults",
            "SIGKILL at every write, fsync, link, rename and unlink of the store",
            "≥ 500 kills, nothing lost, nothing corrupt, every restart clean",
            f"{kills} kills, {len(lost)} losses",
            kills >= 500 * min(scale, 1) and not lost and status == 0,
        )
    ]


def worker_kills(scale: float) -> list[Row]:
    """SIGKILL of the worker in mid-build."""
    with servers() as start:
        import job_faults

        wanted = max(2, int(100 * scale))
        kills = job_faults.killed_workers_cost_time_only(start, press, kills=wanted)
    return [
        Row(
            "faults-worker-kills",
            "faults",
            "SIGKILL of the build worker in mid-build, one machine",
            "100 kills, every accepted build succeeds",
            f"{kills} kills, 0 builds failed",
            kills >= 100 * min(scale, 1),
        )
    ]


def service_kills(scale: float) -> list[Row]:
    """Kill -9 and SIGTERM of the whole service with builds running and waiting."""
    ends = 0
    with servers() as start:
        import job_faults

        for seed in range(max(1, int(5 * scale))):
            ends += job_faults.accepted_jobs_finish(start, press, kills=3, stops=3, seed=seed)
    return [
        Row(
            "faults-service-kills",
            "faults",
            "kill -9 and SIGTERM of the service in turn, with builds running and waiting",
            "every build that was accepted (202) succeeds after a restart",
            f"{ends} ends of the service, 0 builds lost",
            ends > 0,
        )
    ]


def identical(scale: float) -> list[Row]:
    """Identical requests at once, at one replica."""
    with servers() as start:
        import job_faults

        clients = max(20, int(200 * scale))
        server = start()
        server.wait_ready()
        job_faults.identical_requests_are_one_build(server, press(100_000), clients=clients)
        server.stop()
    return [
        Row(
            "faults-identical-1",
            "faults",
            "identical POSTs at the same time, one replica",
            "200 requests, one build, identical bytes",
            f"{clients} requests, 1 build, 1 answer",
            clients >= 200 * min(scale, 1),
        )
    ]


def damage(scale: float) -> list[Row]:
    """Flip or truncate the files of every gamut."""
    with servers() as start:
        import stored_damage

        bodies = [sphere(seed) for seed in range(max(2, int(25 * scale)))]
        files = stored_damage.every_damage_is_noticed(start, bodies)
    return [
        Row(
            "faults-damage",
            "faults",
            "every stored history and record with a flipped bit, then truncated",
            "all noticed on read, counted, built again, never served",
            f"{files} of {files} noticed, counted and built again to the same bytes",
            files > 0,
        )
    ]


def cluster(scale: float) -> list[Row]:
    """Kills in a deployment with a broker and a shared store, and identical requests."""
    rows = []
    # A kill costs the lease, so RabbitMQ, which differs in the transport only, has fewer.
    for broker, most_kills, most_posts in (("redis", 100, 200), ("rabbitmq", 10, 50)):
        kills, posts = max(1, int(most_kills * scale)), max(20, int(most_posts * scale))
        status, output, errors = program(
            "cluster.py",
            *("--broker", broker, "--kills", kills, "--posts", posts),
            *(("--write",) if broker == "redis" else ()),
        )
        told = [
            line for line in output.splitlines() if not line.startswith(("{", "kill "))
        ] or errors.splitlines()[-3:]
        name = {"redis": "Redis", "rabbitmq": "RabbitMQ"}[broker]
        rows.append(
            Row(
                f"faults-cluster-{broker}",
                "faults",
                f"three API replicas, two workers, {name}, an S3 server: {posts} identical POSTs, "
                f"workers killed {kills} times in mid-build, replicas that had accepted as well",
                "one build, identical bytes; every accepted build succeeds",
                "; ".join(told),
                status == 0,
            )
        )
    return rows


def hostile(scale: float) -> list[Row]:
    """Bodies without an end, bombs, large forms, slow clients."""
    status, output, errors = program("hostile_clients.py", *(("--full",) if scale >= 1 else ()))
    if not output:
        raise RuntimeError(errors)
    figures = json.loads(output.strip().splitlines()[-1])
    wrong = [row["attack"] for row in figures["attacks"] if not row["as_deserved"]]
    return [
        Row(
            "hostile-clients",
            "hostile",
            "10 GB chunked, decompression bombs, large forms, slow heads, bodies and readers, "
            "searches for levels: "
            f"{len(figures['attacks'])} attacks",
            "413, 415, 408 or their levels; memory grows by ≤ 64 MB; good clients unharmed",
            f"{len(wrong)} answered otherwise; + {figures['growth_mb']:.0f} MB; "
            f"{figures['good_requests']:,} good requests, {len(figures['good_failures'])} failed, "
            f"p99 {figures['good_p99_ms']:.0f} ms",
            status == 0,
        )
    ]


def properties(scale: float) -> list[Row]:
    """Requests that schemathesis makes of the OpenAPI document, stateful."""
    seconds = max(20, int(600 * scale))
    status, output, errors = program("api_properties.py", "--seconds", seconds)
    if status:
        sys.stderr.write(output[-8000:] + errors)
    cases = re.findall(r"^\s*✅?\s*([\d,]+ (?:generated|passed).*)$", output, re.MULTILINE)
    summary = [line.strip() for line in output.splitlines() if re.search(r"\d+ generated", line)]
    told = "; ".join(summary or cases) or f"exit status {status}"
    return [
        Row(
            "hostile-schemathesis",
            "hostile",
            f"schemathesis on the OpenAPI document, examples, coverage, fuzzing and stateful, "
            f"{seconds} s",
            "0 failures",
            told,
            status == 0,
        )
    ]


def fuzz(scale: float) -> list[Row]:
    """Mutated files for every parser."""
    seconds = max(10, int(300 * scale))
    done = subprocess.run(
        [sys.executable, str(ROOT / "tests" / "fuzz" / "fuzz.py"), "--seconds", str(seconds)],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    cases = dict(re.findall(r"^(\w+): (\d+) cases", done.stdout, re.MULTILINE))
    told = [f"{parser} {int(count):,}" for parser, count in cases.items()]
    if done.returncode:
        told += done.stderr.strip().splitlines()[-1:]
    return [
        Row(
            "hostile-fuzz",
            "hostile",
            f"mutated files for every parser, {seconds} s",
            "no crash, none above 2 s of processor time or 512 MB",
            "cases: " + ", ".join(told),
            done.returncode == 0,
        )
    ]


TESTED = {
    "faults-full-disk": (
        "faults",
        "disk full (a small file system, and injected errors)",
        "507, existing gamuts served, recovers without a restart",
        "full_disk or full_store",
        ["tests/service/storage"],
    ),
    "faults-poison": (
        "faults",
        "inputs that exhaust memory or time, or crash every worker",
        "≤ 3 attempts, then failed with the reason; other jobs unaffected",
        "poisonous or given_up or deadline or fills_the_memory or beyond_the_memory",
        ["tests/service/building", "tests/service/routes/gamuts/test_failures.py"],
    ),
    "faults-disconnect": (
        "faults",
        "the first client disconnects in mid-build",
        "the build finishes, others get it",
        "first_client_disconnects or first_to_ask_leaves",
        ["tests/service/routes/test_jobs.py", "tests/service/caching/test_single_flight.py"],
    ),
    "faults-formats": (
        "faults",
        "every GLB by Khronos' validator, every PLY by two other readers",
        "no errors",
        "",
        ["tests/gltf", "tests/gamutcore/export"],
    ),
}
"""Rows that parts of the tests show: group, what, goal, which tests, where they are."""


def tested(_scale: float) -> list[Row]:
    """Return the rows of what the tests show."""
    rows = []
    for key, (group, what, goal, chosen, places) in TESTED.items():
        done = subprocess.run(
            [
                *(sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"),
                *(("-k", chosen) if chosen else ()),
                *places,
            ],
            cwd=ROOT,
            env={**os.environ, "PYTHONPATH": str(ROOT)},
            capture_output=True,
            text=True,
            check=False,
        )
        summary = done.stdout.strip().splitlines()[-1]
        summary = re.sub(r",? *\d+ deselected|in [\d.:]+s.*|=", "", summary).strip(" ,")
        rows.append(Row(key, group, what, goal, f"tests: {summary}", done.returncode == 0))
    return rows


STEPS: Steps = {
    "store-kills": store_kills,
    "worker-kills": worker_kills,
    "service-kills": service_kills,
    "identical": identical,
    "damage": damage,
    "hostile": hostile,
    "tested": tested,
    "fuzz": fuzz,
    "properties": properties,
    "cluster": cluster,
}


def main() -> int:
    """Run the steps, and return whether a promise was broken."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", nargs="+", choices=[*STEPS], default=[*STEPS])
    parser.add_argument("--scale", type=float, default=1.0)
    parsed = parser.parse_args()
    kept = True
    for name in parsed.only:
        start = time.perf_counter()
        rows = STEPS[name](parsed.scale)
        # A small run shows that the programs work, and no more.
        met = recorded(rows) if parsed.scale >= 1 else all(row.met for row in rows)
        kept &= met
        for row in rows:
            mark = "ok " if row.met else "NOT"
            sys.stdout.write(f"{mark} {row.what}: {row.measured}\n")
        sys.stdout.write(f"    {name}: {time.perf_counter() - start:.0f} s\n")
        sys.stdout.flush()
    return 0 if kept else 1


if __name__ == "__main__":
    sys.exit(main())
