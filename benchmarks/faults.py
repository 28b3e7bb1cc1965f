"""Inject the faults that the service promises to survive: ``make faults``.

Each step runs a program of ``tests/faults`` or a part of the tests on the loopback interface. Its
result goes to ``docs/reliability.md`` at once, so an interrupted run keeps what it has measured.
``--only`` selects steps. ``--scale 0.1`` runs a tenth of each, prints the results and records
nothing.
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

from benchmarks.common import FOGRA39L, ROOT, sphere_samples
from benchmarks.reliability import Result, record

__all__ = ["main"]

FAULTS = ROOT / "tests" / "faults"
SERVICE_TESTS = ROOT / "tests" / "service"


def run_python(*arguments: object) -> subprocess.CompletedProcess[str]:
    """Run a Python program in the repository and return its output."""
    return subprocess.run(
        [sys.executable, *map(str, arguments)],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )


def reported_figures(done: subprocess.CompletedProcess[str]) -> dict[str, Any]:
    """Return the JSON object on the last line of a program's output."""
    if not done.stdout.strip():
        raise RuntimeError(f"The program printed no figures. Its messages: {done.stderr[-2000:]}")
    figures: dict[str, Any] = json.loads(done.stdout.strip().splitlines()[-1])
    return figures


@contextlib.contextmanager
def server_factory() -> Iterator[Callable[..., Any]]:
    """Yield a function that starts a server as the tests do. All servers end with the context."""
    sys.path[:0] = [str(SERVICE_TESTS), str(FAULTS)]
    from conftest import Server

    started: list[Any] = []
    with tempfile.TemporaryDirectory(prefix="gamut-faults-") as folder:

        def start(data: Path | None = None, **settings: object) -> Any:  # noqa: ANN401  # test class
            home = Path(folder) / str(len(started))
            home.mkdir()
            started.append(Server(data or home / "data", home / "log", **settings))
            return started[-1]

        try:
            yield start
        finally:
            for server in started:
                if server.process.poll() is None:
                    server.kill()


def press(surface_samples: int = 150_000) -> dict[str, Any]:
    """Return the arguments of a POST whose build takes some seconds."""
    return {
        "files": {"file": (FOGRA39L.name, FOGRA39L.read_bytes())},
        "data": {"options": json.dumps({"surface_samples": surface_samples})},
    }


def store_kills(scale: float) -> list[Result]:
    """SIGKILL at the system calls that write to the store."""
    # A child that ends before its call is not counted, hence 560 attempts for 500 kills.
    done = run_python(FAULTS / "store_kills.py", "--kills", max(10, int(560 * scale)))
    figures = reported_figures(done)
    kills, losses = figures["kills"], len(figures["losses"])
    met = kills >= 500 * min(scale, 1) and not losses and done.returncode == 0
    return [Result("faults-store-kills", f"{kills} kills, {losses} losses", met)]


def jobs(scale: float) -> list[Result]:
    """Kill workers and the whole service, ask at the same time, and damage what is stored."""
    with server_factory() as start:
        import job_faults
        import stored_damage

        kills = job_faults.killed_workers_cost_time_only(
            start, press, kills=max(2, int(100 * scale))
        )
        ends = sum(
            job_faults.accepted_jobs_finish(start, press, kills=3, stops=3, seed=seed)
            for seed in range(max(1, int(5 * scale)))
        )
        clients = max(20, int(200 * scale))
        server = start()
        server.wait_ready()
        job_faults.identical_requests_are_one_build(server, press(100_000), clients=clients)
        server.stop()
        bodies = [sphere_samples(seed) for seed in range(max(2, int(25 * scale)))]
        files = stored_damage.every_damage_is_noticed(start, bodies)
    noticed = f"{files} of {files} detected, counted and built again to the same bytes"
    return [
        Result("faults-worker-kills", f"{kills} kills, 0 builds failed", kills >= 100 * scale),
        Result("faults-service-kills", f"{ends} kills and stops, 0 builds lost", ends > 0),
        Result("faults-identical-1", f"{clients} requests, 1 build, 1 answer", True),
        Result("faults-damage", noticed, files > 0),
    ]


def cluster(scale: float) -> list[Result]:
    """Kills and identical requests in a deployment with a broker and a shared store."""
    results = []
    # Each kill costs a lease. RabbitMQ differs in the transport only, so it gets fewer kills.
    for broker, most_kills, most_posts in (("redis", 100, 200), ("rabbitmq", 10, 50)):
        kills, posts = max(1, int(most_kills * scale)), max(20, int(most_posts * scale))
        done = run_python(
            FAULTS / "cluster.py", "--broker", broker, "--kills", kills, "--posts", posts
        )
        lines = [
            line for line in done.stdout.splitlines() if not line.startswith(("{", "kill "))
        ] or done.stderr.splitlines()[-3:]
        results.append(Result(f"faults-cluster-{broker}", "; ".join(lines), done.returncode == 0))
    return results


def hostile(scale: float) -> list[Result]:
    """Endless bodies, decompression bombs, large forms and slow clients."""
    done = run_python(FAULTS / "hostile_clients.py", *(("--full",) if scale >= 1 else ()))
    figures = reported_figures(done)
    wrong = sum(not row["as_deserved"] for row in figures["attacks"])
    measured = (
        f"{len(figures['attacks'])} attacks, {wrong} with another answer; "
        f"memory + {figures['growth_mb']:.0f} MB; {figures['good_requests']:,} requests of other "
        f"clients, {len(figures['good_failures'])} failed, p99 {figures['good_p99_ms']:.0f} ms"
    )
    return [Result("hostile-clients", measured, done.returncode == 0)]


def properties(scale: float) -> list[Result]:
    """Requests that schemathesis generates from the OpenAPI document."""
    seconds = max(20, int(600 * scale))
    done = run_python(FAULTS / "api_properties.py", "--seconds", seconds)
    if done.returncode:
        sys.stderr.write(done.stdout[-8000:] + done.stderr[-2000:])
    summary = [
        line.strip() for line in done.stdout.splitlines() if re.search(r"\d generated", line)
    ]
    measured = "; ".join([f"{seconds} s", *summary]) if summary else f"status {done.returncode}"
    return [Result("hostile-schemathesis", measured, done.returncode == 0)]


def fuzz(scale: float) -> list[Result]:
    """Mutated files for every parser."""
    seconds = max(10, int(300 * scale))
    done = run_python(ROOT / "tests" / "fuzz" / "fuzz.py", "--seconds", seconds)
    cases = re.findall(r"^(\w+): (\d+) cases", done.stdout, re.MULTILINE)
    counts = [f"{parser} {int(count):,}" for parser, count in cases]
    if done.returncode:
        counts += done.stderr.strip().splitlines()[-1:]
    measured = f"{seconds} s; cases: {', '.join(counts)}"
    return [Result("hostile-fuzz", measured, done.returncode == 0)]


TESTED = {
    "faults-full-disk": ("full_disk or full_store", ["tests/service"]),
    "faults-poison": (
        "poisonous or given_up or deadline or fills_the_memory or beyond_the_memory",
        ["tests/service"],
    ),
    "faults-disconnect": (
        "first_client_disconnects or first_to_ask_leaves",
        ["tests/service"],
    ),
    "faults-formats": ("", ["tests/gltf", "tests/gamutcore/export"]),
}
"""Promises that tests check: expression that selects the tests (``pytest -k``), and their paths."""


def tested(_scale: float) -> list[Result]:
    """Run the tests behind some promises."""
    results = []
    for key, (expression, paths) in TESTED.items():
        select = ("-k", expression) if expression else ()
        done = run_python("-m", "pytest", "-q", "-p", "no:cacheprovider", *select, *paths)
        summary = done.stdout.strip().splitlines()[-1]
        summary = re.sub(r",? *\d+ deselected|in [\d.:]+s.*|=", "", summary).strip(" ,")
        results.append(Result(key, f"tests: {summary}", done.returncode == 0))
    return results


STEPS: dict[str, Callable[[float], list[Result]]] = {
    "store-kills": store_kills,
    "jobs": jobs,
    "hostile": hostile,
    "tested": tested,
    "fuzz": fuzz,
    "properties": properties,
    "cluster": cluster,
}


def main() -> int:
    """Run the steps and return 1 if a promise was broken."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", nargs="+", choices=[*STEPS], default=[*STEPS])
    parser.add_argument("--scale", type=float, default=1.0)
    arguments = parser.parse_args()
    met = True
    for name in arguments.only:
        start = time.perf_counter()
        results = STEPS[name](arguments.scale)
        met &= all(result.met for result in results)
        if arguments.scale >= 1:
            record(results)
        print(*results, f"    {name}: {time.perf_counter() - start:.0f} s", sep="\n", flush=True)
    return 0 if met else 1


if __name__ == "__main__":
    raise SystemExit(main())
