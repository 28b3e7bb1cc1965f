"""Attack a server that has a budget of memory with work on many large gamuts.

The gamuts are FOGRA39L with different ink limits, of 140,000 triangles each. `ATTACKS` is the table
of the requests. All requests of an attack are sent at the same time. Each must get 200 or 429,
the memory of the API process may exceed the budget by at most 15 %, and after the rest it must be
at most 20 % above the memory of the idle process and what is charged. The program prints one line
of JSON and exits with 1 if a condition fails.
"""

import argparse
import asyncio
import http.client
import itertools
import json
import re
import sys
import tempfile
import threading
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from serving import PATIENCE, Serving

from benchmarks.common import FOGRA39L, proportional_bytes

MOST_OVER_BUDGET = 1.15
MOST_KEPT = 1.2
STATUSES = {200, 429}
FULL_QUESTION = json.dumps({"colours": [[50, 0, 0]], "max_error": 0})

ATTACKS = {
    "contains": (1.0, ("POST /v1/gamuts/{one}/contains",)),
    "comparisons": (
        2.5,
        tuple(
            f"GET /v1/comparisons?a={{one}}&b={{other}}&max_error=0{lost}"
            for lost in ("", "&lost=true")
        ),
    ),
    "viewers": (1.875, ("GET /v1/gamuts/{one}/viewer.html",)),
    "pictures": (0.5, ("GET /v1/gamuts/{one}/picture.png?size=2048",)),
    "meshes": (
        1.0,
        tuple(f"GET /v1/gamuts/{{one}}/mesh.{kind}?max_error=0" for kind in ("glb", "3mf", "stl")),
    ),
}
"""Requests per gamut, and what is requested in turn. Pictures have the largest size."""


def built(store, count):
    """Build the gamuts that the store lacks; return the ids of all, a small one last."""
    store.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        server = Serving(store, Path(folder) / "log", build_workers=2, build_queue=count + 1)

        def post(**body):
            answer = server.client.post("/v1/gamuts", **body, headers={"Prefer": "wait=300"})
            assert answer.status_code in {200, 201}, answer.text
            return answer.json()["id"]

        def large(number):
            options = json.dumps({"ink_limit": 221 + number})
            return post(files={"file": ("file", FOGRA39L.read_bytes())}, data={"options": options})

        try:
            server.wait_ready()
            directions = np.random.default_rng(0).normal(size=(300, 3))
            directions /= np.linalg.norm(directions, axis=1, keepdims=True)
            with ThreadPoolExecutor(2) as threads:
                ids = list(threads.map(large, range(count)))
            return [*ids, post(json={"samples": (40 * directions + (50, 0, 0)).tolist()})]
        finally:
            server.end()


@dataclass
class Watch:
    """Latencies of ``/livez`` in seconds, and the largest PSS of the server and its workers."""

    server: Serving
    stopped: threading.Event = field(default_factory=threading.Event)
    latencies: list[float] = field(default_factory=list)
    most: int = 0

    def __enter__(self):
        self.threads = [threading.Thread(target=each) for each in (self.ask, self.weigh)]
        for thread in self.threads:
            thread.start()
        return self

    def __exit__(self, *_):
        self.stopped.set()
        for thread in self.threads:
            thread.join()

    def ask(self):
        connection = http.client.HTTPConnection("127.0.0.1", self.server.port, timeout=PATIENCE)
        while True:
            start = time.perf_counter()
            connection.request("GET", "/livez")
            connection.getresponse().read()
            self.latencies.append(time.perf_counter() - start)
            if self.stopped.wait(0.02):
                break

    def weigh(self):
        while True:
            self.most = max(self.most, proportional_bytes(self.server.process.pid))
            if self.stopped.wait(0.5):
                break


async def status(port, request):
    """Send a request, read all of the answer, and return its status."""
    method, path = request.split(" ")
    body = FULL_QUESTION if method == "POST" else ""
    fields = f"Connection: close\r\nContent-Type: application/json\r\nContent-Length: {len(body)}"
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    writer.write(f"{method} {path} HTTP/1.1\r\nHost: localhost\r\n{fields}\r\n\r\n{body}".encode())
    head = await reader.readline()
    while await reader.read(1 << 20):
        pass
    writer.close()
    return int(head.split()[1]) if head else 0


async def sent(port, templates, ids, count):
    """Send that many requests at the same time; return their statuses."""
    pairs = [(ids[n % len(ids)], ids[(7 * n + 1) % len(ids)]) for n in range(count)]
    turns = zip(pairs, itertools.cycle(templates), strict=False)
    return Counter(
        await asyncio.gather(
            *(status(port, each.format(one=one, other=other)) for (one, other), each in turns)
        )
    )


def charged(server):
    """Return the charged bytes by kind."""
    pattern = r'^gamut_memory_charged_bytes\{kind="(\w+)"\} (\S+)'
    found = re.findall(pattern, server.client.get("/metrics").text, re.MULTILINE)
    return {kind: int(float(nbytes)) for kind, nbytes in found}


def attacked(server, ids, idle, rest):
    """Run the attacks one after the other; return their results."""
    rows = []
    for name, (share, templates) in ATTACKS.items():
        server.reset_peak()
        start = time.perf_counter()
        with Watch(server) as watch:
            found = asyncio.run(sent(server.port, templates, ids, max(2, int(share * len(ids)))))
        seconds = time.perf_counter() - start
        peak = server.peak()
        time.sleep(rest)
        kinds = charged(server)
        kept = server.resident()
        rows.append(
            {
                "attack": name,
                "statuses": {str(each): count for each, count in sorted(found.items())},
                "peak_mb": round(peak / 1e6),
                "livez_p99_ms": round(1e3 * float(np.percentile(watch.latencies, 99)), 1),
                "kept_ratio": round(kept / (idle + sum(kinds.values())), 2),
                "kept_mb": round(kept / 1e6),
                "charged_mb": {kind: round(nbytes / 1e6) for kind, nbytes in kinds.items()},
                "tree_pss_mb": round(watch.most / 1e6),
                "seconds": round(seconds, 1),
            }
        )
        print(rows[-1], file=sys.stderr)
    return rows


def main():
    """Run all attacks and return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--gamuts", type=int, default=80)
    parser.add_argument("--budget", type=int, default=800, metavar="MB")
    parser.add_argument("--rest", type=int, default=60, help="seconds after each attack")
    parser.add_argument("--store", type=Path, help="directory that keeps the gamuts")
    arguments = parser.parse_args()
    budget = arguments.budget * 1_000_000
    with tempfile.TemporaryDirectory() as folder:
        store = arguments.store or Path(folder) / "store"
        *ids, small = built(store, arguments.gamuts)
        server = Serving(store, Path(folder) / "log", memory_bytes=budget)
        try:
            server.wait_ready()
            for _, templates in ATTACKS.values():  # kernels and libraries are loaded at first use
                asyncio.run(sent(server.port, templates, [small], len(templates)))
            idle = server.resident() - sum(charged(server).values())
            rows = attacked(server, ids, idle, arguments.rest)
            tracebacks = server.log().count("Traceback")
        finally:
            server.end()
    peak = max(row["peak_mb"] for row in rows)
    kept = max(row["kept_ratio"] for row in rows)
    figures = {
        "gamuts": len(ids),
        "budget_mb": arguments.budget,
        "idle_mb": round(idle / 1e6),
        "attacks": rows,
        "peak_mb": peak,
        "kept_ratio": kept,
        "livez_p99_ms": max(row["livez_p99_ms"] for row in rows),
        "other_statuses": sum(not set(map(int, row["statuses"])) <= STATUSES for row in rows),
        "tracebacks": tracebacks,
    }
    for row in rows:
        statuses = ", ".join(f"{count} × {status}" for status, count in row["statuses"].items())
        print(f"{row['attack']} {statuses}, peak {row['peak_mb']} MB, kept {row['kept_ratio']:.2f}")
    print(json.dumps(figures))
    right = peak <= MOST_OVER_BUDGET * arguments.budget and kept <= MOST_KEPT
    return 0 if right and not figures["other_statuses"] and not tracebacks else 1


if __name__ == "__main__":
    sys.exit(main())
