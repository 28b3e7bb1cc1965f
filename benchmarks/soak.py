"""Load the service for minutes: ``make soak``.

Starts one API process on the loopback interface, as ``gamut serve`` does. Measures the latency of
``/livez`` while builds saturate the machine, and the memory of the process over 100,000 mixed
requests. The results go to ``docs/reliability.md``.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import random
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

import httpx
import numpy as np
import uvloop

from benchmarks.common import resident_bytes, sphere_samples
from benchmarks.http import Server, posted, server
from benchmarks.reliability import Result, record

__all__ = ["main"]

MEBIBYTE = 2**20
CONNECTIONS = 16


@dataclass(frozen=True)
class MixedRequest:
    """A request and the statuses that answer it correctly."""

    method: str
    path: str
    expected: set[int]
    headers: dict[str, str] = field(default_factory=dict)
    content: bytes = b""
    check: Callable[[httpx.Response], bool] | None = None


def sphere_body(seed: int) -> bytes:
    """Return the body of a POST, which differs by seed."""
    return json.dumps(sphere_samples(seed)).encode()


def mixed_requests(gamuts: list[tuple[str, int]], known: bytes) -> Iterator[MixedRequest]:
    """Iterate over a reproducible mixture of valid and invalid requests, without end.

    Parameters
    ----------
    gamuts : list of (str, int)
        Ids and triangle counts of stored gamuts: spheres of `sphere_samples`, and another one last.
    known : bytes
        A body whose gamut is stored.
    """
    chance = random.Random(0)  # noqa: S311  # not used for security
    json_body = {"Content-Type": "application/json"}
    posts = 0

    def gamut() -> str:
        return f"/v1/gamuts/{chance.choice(gamuts)[0]}"

    def any_mesh() -> MixedRequest:
        identifier, triangles = chance.choice(gamuts)
        count = min(triangles, int(4 * 10 ** chance.uniform(0, 3.3)))
        suffix = chance.choice(("", ".glb", ".ply", ".gltf", ".stl", ".obj"))
        method = "HEAD" if chance.random() < 0.05 else "GET"
        return MixedRequest(
            method, f"/v1/gamuts/{identifier}/mesh{suffix}?triangles={count}", {200}
        )

    def description() -> MixedRequest:
        path = chance.choice((gamut(), f"{gamut()}/levels", "/v1/gamuts"))
        return MixedRequest("GET", path, {200})

    def history_range() -> MixedRequest:
        start = chance.randrange(1000)
        fields = {"Range": f"bytes={start}-{start + 4095}"}
        return MixedRequest("GET", f"{gamut()}/history", {206}, fields)

    def error() -> MixedRequest:
        return chance.choice(
            (
                MixedRequest("GET", "/v1/gamuts/" + "0" * 64, {404}),
                MixedRequest("GET", f"{gamut()}/mesh?triangles=3", {422}),
                MixedRequest("GET", f"{gamut()}/mesh", {406}, {"Accept": "text/csv"}),
                MixedRequest("POST", "/v1/gamuts", {400}, json_body, b"{"),
                MixedRequest("DELETE", "/v1/gamuts", {405}),
                MixedRequest("GET", f"/{chance.random()}", {404}),
            )
        )

    def state() -> MixedRequest:
        path = chance.choice(("/livez", "/readyz", "/metrics", "/", "/problems"))
        return MixedRequest("GET", path, {200})

    def query() -> MixedRequest:
        if chance.random() < 0.3:
            (one, _), (two, _) = chance.choices(gamuts, k=2)
            views = ("cusps", "leaves?hues=36", "slice?lightness=50", "slice.svg?hue=40", "rings")
            paths = (*(f"{gamut()}/{view}" for view in views), f"/v1/comparisons?a={one}&b={two}")
            return MixedRequest("GET", chance.choice(paths), {200, 429})
        sphere = f"/v1/gamuts/{chance.choice(gamuts[:-1])[0]}"
        return sphere_query(sphere, chance)

    def new_post() -> MixedRequest:
        nonlocal posts
        posts += 1
        fields = {**json_body, "Prefer": "respond-async"}
        return MixedRequest("POST", "/v1/gamuts", {202, 429}, fields, sphere_body(1000 + posts))

    kinds: list[tuple[float, Callable[[], MixedRequest]]] = [
        (0.35, any_mesh),
        (0.10, query),
        (0.20, lambda: MixedRequest("GET", f"{gamut()}/mesh", {200})),
        (0.08, lambda: MixedRequest("GET", f"{gamut()}/mesh", {304}, {"If-None-Match": "*"})),
        (0.10, description),
        (0.05, history_range),
        (0.04, error),
        (0.05, state),
        (0.02, lambda: MixedRequest("POST", "/v1/gamuts", {200}, json_body, known)),
        (0.01, new_post),
    ]
    shares = [share for share, _ in kinds]
    while True:
        yield chance.choices(kinds, shares)[0][1]()


def sphere_query(gamut: str, chance: random.Random) -> MixedRequest:
    """Return a query about rays of a sphere, with a check of the answer.

    The spheres of `sphere_samples` have a radius of 40. Chords of 300 points are at most 10 inside.
    """
    numbers = np.random.default_rng(chance.randrange(2**32))
    rays = numbers.normal(size=(20, 3))
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    radii = numbers.uniform((1, 45), (30, 80), (10, 2)).reshape(-1)
    centre, outside = np.array([50.0, 0.0, 0.0]), radii > 40
    colours = centre + rays * radii[:, np.newaxis]
    name = chance.choice(("contains", "nearest", "map"))
    asked: dict[str, object] = {"colours": colours.tolist()}
    if name == "map":
        asked["method"] = chance.choice(("clip-nearest", "clip-hue", "clip-focal"))

    def check(answer: httpx.Response) -> bool:
        found = answer.json()
        if name == "contains":
            return bool(found["inside"] == (~outside).tolist())
        if name == "nearest":
            gap = np.abs(np.array(found["distance"]) - np.abs(40 - radii))
            return bool(gap.max() < 10)
        reached = np.linalg.norm(np.array(found["mapped"]) - centre, axis=1)
        return bool(found["moved"] == outside.tolist() and reached.max() < 40.2)

    fields = {"Content-Type": "application/json"}
    content = json.dumps(asked).encode()
    return MixedRequest("POST", f"{gamut}/{name}", {200, 429}, fields, content, check)


class MixedRun(NamedTuple):
    """Memory in bytes by the number of requests sent, statuses, and unexpected answers."""

    memory: list[tuple[int, int]]
    statuses: Counter[int]
    unexpected: list[str]


async def run_mixture(
    found: Server, requests: Iterator[MixedRequest], known: bytes, count: int
) -> MixedRun:
    """Post the known body, then send a number of mixed requests over several connections."""
    run = MixedRun([], Counter(), [])
    numbers = iter(range(1, count + 1))
    limits = httpx.Limits(max_connections=CONNECTIONS)
    base = f"http://127.0.0.1:{found.port}"
    async with httpx.AsyncClient(base_url=base, limits=limits, timeout=60) as client:
        headers = {"Content-Type": "application/json", "Prefer": "wait=60"}
        (await client.post("/v1/gamuts", content=known, headers=headers)).raise_for_status()

        async def send_all() -> None:
            for number in numbers:
                sent = next(requests)
                try:
                    answer = await client.request(
                        sent.method, sent.path, headers=sent.headers, content=sent.content
                    )
                except httpx.TransportError as error:
                    run.unexpected.append(f"{error!r}: {sent.method} {sent.path}")
                    continue
                run.statuses[answer.status_code] += 1
                if answer.status_code not in sent.expected:
                    run.unexpected.append(f"{answer.status_code}: {sent.method} {sent.path}")
                elif sent.check and answer.status_code == 200 and not sent.check(answer):
                    run.unexpected.append(f"wrong: {sent.method} {sent.path}: {answer.text[:200]}")
                if number % max(1, count // 200) == 0:
                    run.memory.append((number, resident_bytes(pid=found.process.pid)))

        await asyncio.gather(*(send_all() for _ in range(CONNECTIONS)))
    run.memory.sort()
    return run


def memory_slope(memory: list[tuple[int, int]]) -> float:
    """Return the growth of memory in MiB per 10,000 requests, by least squares."""
    requests, used = np.array(memory, dtype=float).T
    return float(np.polyfit(requests, used, 1)[0]) * 10_000 / MEBIBYTE


def mixture_results(requests: int) -> list[Result]:
    """Measure memory and answers over mixed requests, after as many for warming up."""
    # Small caches are full early, so their growth does not count as a leak.
    small = {"history_cache_bytes": str(8 * MEBIBYTE), "mesh_cache_bytes": str(8 * MEBIBYTE)}
    known = sphere_body(5000)
    with server(small) as found:
        bodies = [sphere_body(seed) for seed in range(12)]
        gamuts = []
        for body in (*bodies, None):
            description = posted(found.port, {}, body)[2]
            gamuts.append((description["id"], description["counts"]["triangles"]))
        start = time.perf_counter()
        run = uvloop.run(run_mixture(found, mixed_requests(gamuts, known), known, 2 * requests))
        seconds = time.perf_counter() - start
        log = found.log.read_text()
    faults = log.count("Traceback")
    if faults:
        print(log[log.index("Traceback") :][:20_000])
    for line in run.unexpected[:10]:
        print(line)
    half = len(run.memory) // 2
    warming, growth = memory_slope(run.memory[:half]), memory_slope(run.memory[half:])
    statuses = ", ".join(f"{status}: {number:,}" for status, number in sorted(run.statuses.items()))
    first, middle, last = (used / MEBIBYTE for _, used in (run.memory[i] for i in (0, half, -1)))
    return [
        Result(
            "soak-memory",
            f"{growth:+.2f} MiB per 10,000 of {requests:,} requests ({warming:+.2f} while warming "
            f"up); {first:.0f} MiB after {run.memory[0][0]:,} requests, {middle:.0f} after "
            f"{run.memory[half][0]:,}, {last:.0f} at the end",
            growth <= 1,
        ),
        Result(
            "soak-answers",
            f"{len(run.unexpected)} unexpected of {2 * requests:,} at "
            f"{2 * requests / seconds:,.0f} requests/s ({statuses}); {faults} errors in the log",
            not run.unexpected and not faults,
        ),
    ]


def livez_results(builds: int, seconds: float) -> list[Result]:
    """Measure the latency of ``/livez`` while builds wait and run."""
    with server({"build_workers": "2", "build_queue": str(builds)}, pin=False) as found:
        statuses = [
            posted(found.port, {"surface_samples": 100_000 + build}, None, "respond-async")[0]
            for build in range(builds)
        ]
        times = []
        end = time.perf_counter() + seconds
        with httpx.Client(base_url=f"http://127.0.0.1:{found.port}") as client:
            while (start := time.perf_counter()) < end:
                client.get("/livez").raise_for_status()
                times.append(1e3 * (time.perf_counter() - start))
                time.sleep(0.005)
    times.sort()
    percentile = times[int(len(times) * 0.99)]
    return [
        Result(
            "soak-livez",
            f"{statuses.count(202)} builds accepted; p50 {times[len(times) // 2]:.1f} ms, "
            f"p99 {percentile:.1f} ms, longest {times[-1]:.0f} ms",
            percentile <= 50,
        )
    ]


def main() -> int:
    """Run the measurements, record the results, and return 1 if a promise was broken."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--requests", type=int, default=100_000, help="mixed, after as many")
    parser.add_argument("--builds", type=int, default=100)
    parser.add_argument("--seconds", type=float, default=30)
    parser.add_argument("--dry-run", action="store_true", help="print the results only")
    steps: dict[str, Callable[[], list[Result]]] = {
        "livez": lambda: livez_results(arguments.builds, arguments.seconds),
        "mixed": lambda: mixture_results(arguments.requests),
    }
    parser.add_argument("--only", nargs="+", choices=[*steps], default=[*steps])
    arguments = parser.parse_args()
    met = True
    for name in arguments.only:
        results = steps[name]()
        met &= all(result.met for result in results)
        print(*results, sep="\n", flush=True)
        if not arguments.dry_run:
            record(results)
    return 0 if met else 1


if __name__ == "__main__":
    raise SystemExit(main())
