"""Measure what the service promises under load and faults: ``make soak``, ``make faults``.

Loads a service on the loopback interface, and runs programs of ``tests``. Each result
goes to ``benchmarks/reliability.json`` and ``docs/reliability.md`` at once, so an interrupted run
keeps what it has measured. ``--scale 0.1`` runs a tenth of each, prints the results and records
nothing.
"""

from __future__ import annotations

import argparse
import asyncio
import functools
import io
import json
import os
import random
import re
import subprocess
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import httpx
import numpy as np
import uvloop

from benchmarks.common import ROOT, machine, proportional_bytes, resident_bytes
from benchmarks.http import Server, server
from benchmarks.markdown import table, update_document
from gamutcore.arrays import FloatArray

RESULTS = Path(__file__).with_name("reliability.json")
DOCUMENT = ROOT / "docs" / "reliability.md"


class Promise(NamedTuple):
    """A situation, what must hold in it, and the program that tells so by its exit status.

    Numbers among its arguments are scaled. The summary is a regular expression for what it prints.
    """

    situation: str
    target: str
    program: tuple[str | int, ...] = ()
    summary: str = ""


JOBS = (
    "tests/faults/job_faults.py",
    *(
        "--worker-kills",
        30,
        "--service-kills",
        30,
        "--both-kills",
        30,
        "--clients",
        200,
        "--damaged",
        25,
    ),
)
LOAD = ("tests/faults/load_attacks.py", "--gamuts", 8, "--only")
LOAD_LINE = r"^[\w. ]+: (p99 of .* MB)$"
OTHER_CLIENT = "peak ≤ budget, and of another client, all with status 200, p99:"

CLUSTER = "tests/faults/cluster.py"
CLUSTER_TARGET = "one build of identical requests, identical bytes, every accepted build succeeds"
CLUSTER_LINES = r"^(?!kill |\{).*"

PROMISES = {
    "soak-answers": Promise("answers to a long mixture of requests", "all as expected"),
    "soak-livez": Promise("`/livez` while builds wait and two workers build", "p99 ≤ 50 ms"),
    "soak-clients": Promise(
        "200 clients at the same time send small queries, meshes, large queries and pictures",
        "all queries p99 ≤ 2 s, `/livez` p99 ≤ 100 ms, no other status than 200, 429 and 503",
    ),
    "soak-small": Promise(
        "the same 200 clients during builds, with the budgets of a container of 1 GB",
        "peak < 1 GB, no build fails, no other status than 200, 429 and 503",
    ),
    "soak-memory": Promise(
        "memory of an API process during the mixture, after its first 2,000 requests",
        "growth ≤ 30 MB at any time",
    ),
    "faults-cluster-redis": Promise(
        "three API replicas, two workers, Redis and a bucket: processes killed during builds",
        CLUSTER_TARGET,
        (CLUSTER, "--kills", 100, "--posts", 200),
        CLUSTER_LINES,
    ),
    "faults-damage": Promise(
        "every stored history and record with a flipped bit, then truncated",
        "detected on read, counted, built again, never served",
        JOBS,
        r"^\d+ damaged files.*",
    ),
    "faults-identical-1": Promise(
        "identical POSTs at the same time, one replica",
        "one build, identical bytes",
        JOBS,
        r"^\d+ identical requests.*",
    ),
    "faults-service-kills": Promise(
        "SIGKILL and SIGTERM of the service, alone and with its worker, while builds run and wait",
        "every accepted build (202) succeeds after a restart",
        JOBS,
        r"^\d+ kills and stops.*",
    ),
    # A child that ends before its call is not counted, hence 560 attempts for 500 kills.
    "faults-store-kills": Promise(
        "SIGKILL at every write, fsync, link, rename and unlink of the store",
        "nothing lost or corrupt, every restart clean",
        ("tests/faults/store_kills.py", "--kills", 560),
        r'"(?:kills|losses)": [^,}]+',
    ),
    "faults-worker-kills": Promise(
        "SIGKILL of the build worker during a build, one machine",
        "every accepted build succeeds",
        JOBS,
        r"^\d+ kills of a worker.*",
    ),
    "hostile-clients": Promise(
        "10 GB chunked body, decompression bombs, large forms, endless heads, slow bodies, "
        "hundreds of JSON bodies, expensive level searches",
        "answered with 4xx, 503 or the level; memory grows by at most 64 MB, 128 MB while 200 "
        "connections send 1 MB at once; other clients are served",
        ("tests/faults/hostile_clients.py", "--full"),
        r'"growth_mb": [\d.]+, "good_requests".*?"good_p99_ms": [\d.]+',
    ),
    "hostile-fuzz": Promise(
        "mutated files for every parser",
        "no crash; at most 2 s of processor time and 512 MB per file",
        ("tests/fuzz/fuzz.py", "--seconds", 300),
        r"^\w+: \d+ cases",
    ),
    "hostile-load-comparisons": Promise(
        "one client sends 100 comparisons of full boundaries at once, in 800 MB",
        f"{OTHER_CLIENT} single colours ≤ 1 s, cusps and slice ≤ 3 s",
        (*LOAD, "comparisons"),
        LOAD_LINE,
    ),
    "hostile-load-many-comparisons": Promise(
        "the same with 200 comparisons in 1.93 GB",
        f"{OTHER_CLIENT} single colours ≤ 1 s, cusps and slice ≤ 3 s",
        (*LOAD, "comparisons of 1.93 GB"),
        LOAD_LINE,
    ),
    "hostile-load-pictures": Promise(
        "one client maps six pictures of 4 megapixels spatially at once",
        f"{OTHER_CLIENT} picture of 40 × 40 ≤ 1.2 × one large picture",
        (*LOAD, "pictures"),
        LOAD_LINE,
    ),
    "hostile-load-recipes": Promise(
        "one client asks for six tables of 100,000 recipes at once",
        f"{OTHER_CLIENT} single colours ≤ 1 s",
        (*LOAD, "recipes"),
        LOAD_LINE,
    ),
    "hostile-load-mixed": Promise(
        "200 clients ask questions of six kinds",
        f"{OTHER_CLIENT} single colours ≤ 1 s",
        (*LOAD, "mixed"),
        LOAD_LINE,
    ),
    "hostile-memory": Promise(
        "80 large gamuts in 800 MB: 80 queries, 200 comparisons, 150 viewers, 40 pictures, or 80 "
        "full meshes at once",
        "peak ≤ 1.15 × budget; all get 200 or 429; a minute later ≤ 1.2 × idle and charged memory",
        ("tests/faults/memory_attacks.py", "--gamuts", 80, "--rest", 60),
        r"^\w+ .*, kept [\d.]+$",
    ),
    "hostile-schemathesis": Promise(
        "requests that schemathesis generates from the OpenAPI document",
        "no failures",
        ("tests/faults/api_properties.py", "--seconds", 600),
        r"\d+ generated.*",
    ),
}
"""Promises by the key in the results. A key begins with the name of its table."""

MEBIBYTE = 2**20
CONNECTIONS = 16
JSON = {"Content-Type": "application/json"}


def sphere_body(seed: int) -> str:
    """Return the body of a POST: colours on a sphere, which differ by seed."""
    directions = np.random.default_rng(seed).normal(size=(300, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return json.dumps({"samples": np.round(directions * 40 + (50, 0, 0), 6).tolist()})


KNOWN = sphere_body(5000)
COLOURS = json.dumps({"colours": [[50, 0, 0], [50, 90, 90]]})
"""Every gamut of the mixture contains the first of these colours, and none the second."""


class Mixed(NamedTuple):
    """Some requests of the mixture. Words in braces are chosen for each, and a new body."""

    share: int
    method: str
    path: str
    statuses: tuple[int, ...] = (200,)
    fields: dict[str, str] | None = None
    body: str = ""
    contains: str = ""


MIXTURE = (
    Mixed(33, "GET", "{gamut}/mesh{suffix}?triangles={count}"),
    Mixed(2, "HEAD", "{gamut}/mesh{suffix}?triangles={count}"),
    Mixed(20, "GET", "{gamut}/mesh"),
    Mixed(8, "GET", "{gamut}/mesh", (304,), {"If-None-Match": "*"}),
    Mixed(4, "GET", "{gamut}"),
    Mixed(3, "GET", "{gamut}/levels"),
    Mixed(3, "GET", "/v1/gamuts"),
    Mixed(5, "GET", "{gamut}/history", (206,), {"Range": "bytes=500-4595"}),
    Mixed(5, "GET", "{page}"),
    Mixed(3, "GET", "{gamut}/{view}", (200, 429)),
    Mixed(1, "GET", "/v1/comparisons?a={id}&b={other}", (200, 429)),
    Mixed(6, "POST", "{gamut}/contains", (200, 429), JSON, COLOURS, '"inside":[true,false]'),
    Mixed(2, "POST", "/v1/gamuts", (200,), JSON, KNOWN),
    Mixed(1, "POST", "/v1/gamuts", (202, 429), {**JSON, "Prefer": "respond-async"}, "new"),
    Mixed(1, "GET", "/v1/gamuts/" + "0" * 64, (404,)),
    Mixed(1, "GET", "{gamut}/mesh?triangles=3", (422,)),
    Mixed(1, "GET", "{gamut}/mesh", (406,), {"Accept": "text/csv"}),
    Mixed(1, "POST", "/v1/gamuts", (400,), JSON, "{"),
)
CHOICES = {
    "suffix": ("", ".glb", ".ply", ".gltf", ".stl", ".obj"),
    "page": ("/livez", "/readyz", "/metrics", "/", "/problems"),
    "view": ("cusps", "leaves?hues=36", "slice?lightness=50", "slice?hue=40", "rings"),
    "count": range(4, 500),
}


class MixedRun:
    """Memory in bytes by the number of requests sent, statuses, and unexpected answers."""

    def __init__(self, found: Server, count: int) -> None:
        self.found, self.count = found, count
        self.chance = random.Random(0)  # noqa: S311  # not used for security
        self.numbers = iter(range(1, count + 1))
        self.memory: list[tuple[int, int]] = []
        self.statuses: Counter[int] = Counter()
        self.unexpected: list[str] = []

    async def send_all(self) -> None:
        """Build some gamuts, then send the mixture over several connections."""
        bodies = [sphere_body(seed).encode() for seed in range(12)]
        self.gamuts = [self.found.build(body)["id"] for body in (*bodies, None)]
        limits = httpx.Limits(max_connections=CONNECTIONS)
        base = f"http://127.0.0.1:{self.found.port}"
        async with httpx.AsyncClient(base_url=base, limits=limits, timeout=60) as client:
            known = await client.post("/v1/gamuts", content=KNOWN, headers=JSON)
            known.raise_for_status()
            await asyncio.gather(*(self.send(client) for _ in range(CONNECTIONS)))
        self.memory.sort()

    async def send(self, client: httpx.AsyncClient) -> None:
        """Send requests of the mixture one after another, until none remains."""
        for number in self.numbers:
            asked = self.chance.choices(MIXTURE, [each.share for each in MIXTURE])[0]
            words = {name: self.chance.choice(values) for name, values in CHOICES.items()}
            one, other = self.chance.choices(self.gamuts, k=2)
            path = asked.path.format(**words, gamut=f"/v1/gamuts/{one}", id=one, other=other)
            body = sphere_body(9000 + number) if asked.body == "new" else asked.body
            try:
                answer = await client.request(
                    asked.method, path, headers=asked.fields, content=body
                )
            except httpx.TransportError as error:
                self.unexpected.append(f"{error!r}: {asked.method} {path}")
                continue
            self.statuses[answer.status_code] += 1
            wrong = answer.status_code == 200 and asked.contains not in answer.text
            if wrong or answer.status_code not in asked.statuses:
                text = answer.text[:200]
                self.unexpected.append(f"{answer.status_code}: {asked.method} {path}: {text}")
            if number % max(1, self.count // 200) == 0:
                self.memory.append((number, resident_bytes(pid=self.found.process.pid)))


@functools.cache
def mixture(scale: float) -> dict[str, tuple[str, bool]]:
    """Measure memory and answers over mixed requests."""
    # Small caches are full early, so their growth does not count as a leak.
    small = {"history_cache_bytes": str(8 * MEBIBYTE), "mesh_cache_bytes": str(8 * MEBIBYTE)}
    requests = int(20_000 * scale)
    with server(small) as found:
        run = MixedRun(found, requests)
        start = time.perf_counter()
        uvloop.run(run.send_all())
        seconds = time.perf_counter() - start
        log = found.log.read_text()
    errors = log.count("Traceback")
    print(*run.unexpected[:10], log[log.index("Traceback") :][:20_000] if errors else "", sep="\n")
    warm = [nbytes for number, nbytes in run.memory if number > requests // 10]
    growth = (max(warm) - warm[0]) / 1e6
    statuses = ", ".join(f"{status}: {number:,}" for status, number in sorted(run.statuses.items()))
    memory = (
        f"{warm[0] / 1e6:.0f} MB, at most {growth:+.1f} MB in {requests:,} requests, "
        f"{warm[-1] / 1e6:.0f} MB at the end"
    )
    answers = (
        f"{len(run.unexpected)} unexpected of {requests:,} at "
        f"{requests / seconds:,.0f} requests/s ({statuses}); {errors} errors in the log"
    )
    return {
        "soak-memory": (memory, growth <= 30),
        "soak-answers": (answers, not run.unexpected and not errors),
    }


def livez(scale: float) -> dict[str, tuple[str, bool]]:
    """Measure the latency of ``/livez`` while builds wait and run."""
    builds, times = int(100 * scale), []
    with server({"build_workers": "2", "build_queue": str(builds)}, pin=False) as found:
        statuses = [
            found.post({"surface_samples": 100_000 + build}, None, "respond-async").status_code
            for build in range(builds)
        ]
        end = time.perf_counter() + 30 * scale
        while (start := time.perf_counter()) < end:
            found.client.get("/livez").raise_for_status()
            times.append(1e3 * (time.perf_counter() - start))
            time.sleep(0.005)
    half, most = np.percentile(times, [50, 99])
    measured = f"p50 {half:.1f} ms, p99 {most:.1f} ms, longest {max(times):.0f} ms"
    return {"soak-livez": (f"{statuses.count(202)} builds accepted; {measured}", bool(most <= 50))}


CLIENTS = 200
REQUESTS: tuple[tuple[int, str, str, int | None], ...] = (
    (11, "small query", "/contains", 1),
    (11, "small query", "/nearest", 20),
    (11, "small query", "/contains", 200),
    (11, "small query", "/nearest", 200),
    (11, "small query", "/crossings", 100),
    (10, "mesh", "/mesh?triangles=20", None),
    (10, "mesh", "/mesh?triangles=500", None),
    (10, "mesh", "/mesh?triangles=5000", None),
    (2, "mesh", "/picture.png?size=300", None),
    (5, "large query", "/contains", 10_000),
    (5, "large query", "/nearest", 10_000),
    (3, "large query", "/contains", 200_000),
)
"""Share, kind, path below a gamut, and rows of the requests of many clients."""


class ClientsRun:
    """Latencies in seconds by kind, and statuses, of many clients with requests of all sizes."""

    def __init__(self, port: int, gamuts: list[str]) -> None:
        self.port = port
        self.chance = random.Random(0)  # noqa: S311  # not used for security
        kinds = [kind for _, kind, _, _ in REQUESTS]
        self.latencies: dict[str, list[float]] = {kind: [] for kind in (*kinds, "livez")}
        self.statuses: Counter[int] = Counter()
        colours = np.random.default_rng(0).uniform((0, -90, -90), (100, 90, 90), (200_000, 3))
        self.requests = [
            (share, kind, self.message(gamut + path, None if rows is None else colours[:rows]))
            for gamut in gamuts
            for share, kind, path, rows in REQUESTS
        ]

    @staticmethod
    def message(path: str, rows: FloatArray | None) -> bytes:
        """Return a request: a GET, or a POST of rows, as JSON if they are few."""
        if rows is None:
            return f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n".encode()
        if len(rows) <= 1000:
            names = ("from", "to") if "crossings" in path else ("colours",)
            # each line goes to the colour that is as far from the end of the list
            lists = zip(names, (rows.tolist(), rows[::-1].tolist()), strict=False)
            body, kind = json.dumps(dict(lists)).encode(), "json"
        else:
            file = io.BytesIO()
            np.save(file, rows.astype(np.float32))
            body, kind = file.getvalue(), "x-npy"
        return (
            f"POST {path} HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Type: application/{kind}\r\n"
            f"Content-Length: {len(body)}\r\n\r\n"
        ).encode() + body

    async def client(self, end: float, kind: str = "") -> None:
        """Send requests one after another until the end. Of one kind: only ``/livez``."""
        reader, writer = await asyncio.open_connection("127.0.0.1", self.port, limit=2**24)
        shares = [share for share, _, _ in self.requests]
        while time.perf_counter() < end:
            if kind:
                await asyncio.sleep(0.02)
                sent = self.message("/livez", None)
            else:
                _, asked, sent = self.chance.choices(self.requests, shares)[0]
            start = time.perf_counter()
            writer.write(sent)
            head = (await reader.readuntil(b"\r\n\r\n")).lower()
            if b"transfer-encoding: chunked" in head:
                while size := int(await reader.readline(), 16):
                    await reader.readexactly(size + 2)
                await reader.readline()
            else:
                length = head.partition(b"content-length:")[2].partition(b"\r\n")[0]
                await reader.readexactly(int(length or 0))
            self.statuses[int(head[9:12])] += 1
            if head[9:12] == b"200":
                self.latencies[kind or asked].append(time.perf_counter() - start)
        writer.close()

    async def run(self, seconds: float) -> None:
        """Let all clients send for some seconds."""
        end = time.perf_counter() + seconds
        await asyncio.gather(self.client(end, "livez"), *(self.client(end) for _ in range(CLIENTS)))


def clients_of(found: Server) -> ClientsRun:
    """Return many clients of a server with a few gamuts, whose levels are in memory."""
    gamuts = [
        found.post({"gamma": 0.2 + 0.01 * number}).json()["links"]["self"] for number in range(4)
    ]
    run = ClientsRun(found.port, gamuts)
    for _, _, sent in run.requests:
        path = sent.split(b" ")[1].decode()
        if sent.startswith(b"GET"):
            found.client.get(path)
    return run


def counted(statuses: Counter[int]) -> str:
    """Return statuses with their numbers."""
    return ", ".join(f"{status}: {number:,}" for status, number in sorted(statuses.items()))


def clients(scale: float) -> dict[str, tuple[str, bool]]:
    """Measure latencies under many clients with requests of all sizes."""
    with server(pin=False) as found:
        run = clients_of(found)
        uvloop.run(run.run(60 * scale))
    figures = {
        kind: np.percentile(found, [50, 99]) for kind, found in run.latencies.items() if found
    }
    measured = "; ".join(
        f"{kind} p50 {1e3 * half:.0f} ms, p99 {1e3 * most:,.0f} ms"
        for kind, (half, most) in figures.items()
    )
    queries = np.concatenate([run.latencies["small query"], run.latencies["large query"]])
    met = np.percentile(queries, 99) <= 2 and figures["livez"][1] <= 0.1
    met &= set(run.statuses) <= {200, 429, 503}
    measured += f"; all queries p99 {1e3 * np.percentile(queries, 99):,.0f} ms"
    return {"soak-clients": (f"{measured} ({counted(run.statuses)})", bool(met))}


def small(scale: float) -> dict[str, tuple[str, bool]]:
    """Measure the memory of API and build worker with the budgets of a container of 1 GB."""
    builds = max(3, int(30 * scale))
    settings = {
        "memory_bytes": str(448 * MEBIBYTE),  # what the service takes by default
        "build_memory_bytes": str(384 * MEBIBYTE),
        "max_body_bytes": str(32 * MEBIBYTE),
        "build_queue": str(builds),
    }
    sizes, stopped = [0], threading.Event()
    with server(settings, pin=False) as found:

        def weigh() -> None:
            while not stopped.wait(0.2):
                sizes.append(proportional_bytes(found.process.pid))

        weighing = threading.Thread(target=weigh)
        weighing.start()
        try:
            run = clients_of(found)
            jobs = [
                found.post({"ink_limit": 221 + number}, None, "respond-async").headers["location"]
                for number in range(builds)
            ]
            uvloop.run(run.run(60 * scale))
            ended = Counter(found.client.get(job).json()["state"] for job in jobs)
        finally:
            stopped.set()
            weighing.join()
    states = ", ".join(f"{count} {state}" for state, count in sorted(ended.items()))
    measured = (
        f"peak {max(sizes) / 1e6:.0f} MB of {len(sizes)} samples; builds: {states} "
        f"({counted(run.statuses)})"
    )
    met = max(sizes) < 1e9 and set(run.statuses) <= {200, 429, 503} and "failed" not in ended
    return {"soak-small": (measured, met and ended["succeeded"] > 0)}


# --- faults ---------------------------------------------------------------------------------------


@functools.cache
def output(program: tuple[str | int, ...], scale: float) -> tuple[bool, str]:
    """Run a program in the repository; return whether it succeeded, and what it printed."""
    words = [str(max(2, int(word * scale)) if isinstance(word, int) else word) for word in program]
    done = subprocess.run(
        [sys.executable, *words],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        text=True,
        check=False,
    )
    if done.returncode:
        sys.stderr.write(done.stdout[-8000:])
    return done.returncode == 0, done.stdout


def told(promise: Promise, scale: float) -> tuple[str, bool]:
    """Return what a program tells about a promise."""
    succeeded, text = output(promise.program, scale)
    lines = "; ".join(re.findall(promise.summary, text, re.MULTILINE)).replace('"', "")
    return lines or "no result", succeeded and bool(lines)


def revision() -> str:
    """Return the short name of the commit that is checked out."""
    command = ["git", "-C", str(ROOT), "rev-parse", "--short=8", "HEAD"]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()


def record(key: str, measured: str, *, met: bool) -> None:
    """Replace a result in the file and update the document."""
    stored: dict[str, Any] = json.loads(RESULTS.read_text())
    stored[key] = {"measured": measured, "met": met, "revision": revision(), "machine": machine()}
    RESULTS.write_text(json.dumps(stored, indent=1, ensure_ascii=False, sort_keys=True) + "\n")
    update_document(DOCUMENT, document_blocks(stored))


def document_blocks(stored: dict[str, Any]) -> dict[str, str]:
    """Return the generated blocks of docs/reliability.md."""
    groups: dict[str, list[list[str]]] = {}
    for key, promise in PROMISES.items():
        found = stored.get(key, {"measured": "not run", "met": False, "machine": {"date": ""}})
        row = [
            promise.situation,
            promise.target,
            found["measured"],
            "yes" if found["met"] else "**no**",
            ", ".join(filter(None, (found["machine"]["date"], found.get("revision")))),
        ]
        groups.setdefault(key.partition("-")[0], []).append(row)
    machines = {
        "- {date}: {cpu}, {cores} cores, {system}, Python {python}".format(**row["machine"])
        for key, row in stored.items()
        if key in PROMISES
    }
    head = ["situation", "target", "measured", "met", "date, revision"]
    contents = {group: table(head, rows) for group, rows in groups.items()}
    return {**contents, "machines": "\n".join(sorted(machines))}


MEASURED: dict[str, Callable[[float], dict[str, tuple[str, bool]]]] = {
    "soak-answers": mixture,
    "soak-clients": clients,
    "soak-livez": livez,
    "soak-memory": mixture,
    "soak-small": small,
}
"""What measures the promises that have no program."""


def main() -> int:
    """Check promises and return 1 if one was broken."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.reliability", description=__doc__)
    parser.add_argument("--only", nargs="+", default=[""], metavar="PREFIX", help="of the keys")
    parser.add_argument("--scale", type=float, default=1.0)
    arguments = parser.parse_args()
    scale, broken = arguments.scale, False
    for key in [each for each in PROMISES if each.startswith(tuple(arguments.only))]:
        if PROMISES[key].program:
            measured, met = told(PROMISES[key], scale)
        else:
            measured, met = MEASURED[key](scale)[key]
        print(f"{'ok ' if met else 'NOT'} {key}: {measured}", flush=True)
        broken |= not met
        if scale >= 1:
            record(key, measured, met=met)
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
