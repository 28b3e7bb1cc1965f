"""The service under load for long: ``make soak``.

One API process on this machine's loopback, as `gamut serve` starts it. Measured: rates of meshes
(cached, encoded anew, not modified), the time of ``/livez`` while builds saturate the machine, and
the memory of the process over 100,000 mixed requests. Ends with rows in docs/reliability.md.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import random
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import uvloop

from benchmarks.http import Server, mesh_rates, posted, server
from benchmarks.reliability import Row, recorded

__all__ = ["main"]

_MEBIBYTE = 2**20
_TOLERANCE = 1e-9

GOALS = {
    # Requests per second, and milliseconds of the 99th percentile where there is a goal for it.
    "repeated, 1000 triangles": (5000.0, 15.0),
    "uncached, 500 counts in turn": (1800.0, None),
    "repeated, 1000 triangles, not modified": (6000.0, None),
}


class Answer(NamedTuple):
    """Status, header fields and content."""

    status: int
    fields: dict[bytes, bytes]
    body: bytes


class Client:
    """One keep-alive connection."""

    def __init__(self, port: int) -> None:
        self.port = port
        self.reader: asyncio.StreamReader | None = None

    async def answer(self, request: bytes) -> Answer:
        """Send a request and return its answer; connections that the server closed are renewed."""
        for _ in range(2):
            if self.reader is None:
                self.reader, self.writer = await asyncio.open_connection("127.0.0.1", self.port)
            try:
                self.writer.write(request)
                return await self._read(request.startswith(b"HEAD"))
            except (asyncio.IncompleteReadError, ConnectionError):
                self.close()
        message = "the server closed the connection twice"
        raise ConnectionError(message)

    def close(self) -> None:
        """Close the connection."""
        if self.reader is not None:
            self.writer.close()
            self.reader = None

    async def _read(self, head_only: bool) -> Answer:
        assert self.reader is not None  # noqa: S101 - opened by `answer`
        head = await self.reader.readuntil(b"\r\n\r\n")
        lines = head[:-4].split(b"\r\n")
        fields = {
            name.lower(): value.strip()
            for name, _, value in (line.partition(b":") for line in lines[1:])
        }
        status = int(lines[0].split()[1])
        body = b""
        if head_only or status in {204, 304}:
            pass
        elif b"content-length" in fields:
            body = await self.reader.readexactly(int(fields[b"content-length"]))
        elif fields.get(b"transfer-encoding") == b"chunked":
            while size := int(await self.reader.readuntil(b"\r\n"), 16):
                body += (await self.reader.readexactly(size + 2))[:-2]
            await self.reader.readuntil(b"\r\n")
        if fields.get(b"connection") == b"close":
            self.close()
        return Answer(status, fields, body)


def request(method: str, path: str, body: bytes = b"", **fields: str) -> bytes:
    """Return the bytes of a request."""
    lines = [f"{method} {path} HTTP/1.1", "Host: 127.0.0.1"]
    lines += [f"{name.replace('_', '-')}: {value}" for name, value in fields.items()]
    if body:
        lines.append(f"Content-Length: {len(body)}")
    return "\r\n".join([*lines, "", ""]).encode() + body


def samples(seed: int) -> bytes:
    """Return a small body to post: 300 colours on a sphere, others for another seed."""
    directions = np.random.default_rng(seed).normal(size=(300, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    points = np.round(directions * 40 + (50, 0, 0), 6).tolist()
    return json.dumps({"samples": points}).encode()


class Mixture:
    """Requests as many clients send them, in an order that a seed determines."""

    def __init__(self, gamuts: list[tuple[str, int]], known: bytes, seed: int = 0) -> None:
        self.gamuts = gamuts
        self.known = known
        self.chance = random.Random(seed)  # noqa: S311 - nothing secret
        self.posts = 0

    def __iter__(self) -> Iterator[tuple[bytes, set[int]]]:
        kinds: list[tuple[float, Callable[[], tuple[bytes, set[int]]]]] = [
            (0.45, self._any_mesh),
            (0.20, self._usual_mesh),
            (0.08, self._not_modified),
            (0.10, self._description),
            (0.05, self._part_of_history),
            (0.04, self._error),
            (0.05, self._state),
            (0.02, self._posted_again),
            (0.01, self._posted_anew),
        ]
        shares = [share for share, _ in kinds]
        while True:
            yield self.chance.choices(kinds, shares)[0][1]()

    def _gamut(self) -> tuple[str, int]:
        name, triangles = self.chance.choice(self.gamuts)
        return f"/v1/gamuts/{name}", triangles

    def _any_mesh(self) -> tuple[bytes, set[int]]:
        path, largest = self._gamut()
        count = min(largest, int(4 * 10 ** self.chance.uniform(0, 3.3)))
        suffix = self.chance.choice(("", ".glb", ".ply", ".gltf", ".stl", ".obj"))
        method = "HEAD" if self.chance.random() < 0.05 else "GET"
        return request(method, f"{path}/mesh{suffix}?triangles={count}"), {200}

    def _usual_mesh(self) -> tuple[bytes, set[int]]:
        return request("GET", f"{self._gamut()[0]}/mesh"), {200}

    def _not_modified(self) -> tuple[bytes, set[int]]:
        return request("GET", f"{self._gamut()[0]}/mesh", If_None_Match="*"), {304}

    def _description(self) -> tuple[bytes, set[int]]:
        path = self.chance.choice(("", "/levels", "?"))
        return request("GET", "/v1/gamuts" if path == "?" else self._gamut()[0] + path), {200}

    def _part_of_history(self) -> tuple[bytes, set[int]]:
        start = self.chance.randrange(1000)
        wanted = f"bytes={start}-{start + 4095}"
        return request("GET", f"{self._gamut()[0]}/history", Range=wanted), {206}

    def _error(self) -> tuple[bytes, set[int]]:
        errors = (
            (request("GET", "/v1/gamuts/" + "0" * 64), 404),
            (request("GET", f"{self._gamut()[0]}/mesh?triangles=3"), 422),
            (request("GET", f"{self._gamut()[0]}/mesh", Accept="text/csv"), 406),
            (request("POST", "/v1/gamuts", b"{", Content_Type="application/json"), 400),
            (request("DELETE", "/v1/gamuts"), 405),
            (request("GET", f"/{self.chance.random()}"), 404),
        )
        content, status = self.chance.choice(errors)
        return content, {status}

    def _state(self) -> tuple[bytes, set[int]]:
        path = self.chance.choice(("/livez", "/readyz", "/metrics", "/", "/problems"))
        return request("GET", path), {200}

    def _posted_again(self) -> tuple[bytes, set[int]]:
        return request("POST", "/v1/gamuts", self.known, Content_Type="application/json"), {200}

    def _posted_anew(self) -> tuple[bytes, set[int]]:
        self.posts += 1
        fields = {"Content_Type": "application/json", "Prefer": "respond-async"}
        return request("POST", "/v1/gamuts", samples(1000 + self.posts), **fields), {202, 429}


def resident_bytes(pid: int) -> int:
    """Return the memory that a process has in RAM (VmRSS)."""
    for line in Path(f"/proc/{pid}/status").read_text().splitlines():
        if line.startswith("VmRSS:"):
            return int(line.split()[1]) * 1024
    raise ProcessLookupError(pid)


async def mixed(
    found: Server, mixture: Mixture, requests: int, connections: int
) -> tuple[list[tuple[int, int]], Counter[int], list[str]]:
    """Send mixed requests; memory by requests sent, statuses, and answers that were wrong."""
    sent = 0
    memory: list[tuple[int, int]] = []
    statuses: Counter[int] = Counter()
    wrong: list[str] = []
    stream = iter(mixture)

    async def client() -> None:
        nonlocal sent
        connection = Client(found.port)
        while sent < requests:
            sent += 1
            number = sent
            content, expected = next(stream)
            answer = await connection.answer(content)
            statuses[answer.status] += 1
            if answer.status not in expected:
                wrong.append(f"{answer.status} for {content[:120]!r}: {answer.body[:200]!r}")
            if number % 1000 == 0:
                memory.append((number, resident_bytes(found.process.pid)))
        connection.close()

    await asyncio.gather(*(client() for _ in range(connections)))
    return sorted(memory), statuses, wrong


def slope(memory: list[tuple[int, int]]) -> float:
    """Return how memory grows, in MiB per 10,000 requests, by least squares."""
    requests, used = np.array(memory, dtype=float).T
    return float(np.polyfit(requests, used, 1)[0]) * 10_000 / _MEBIBYTE


def soaked(requests: int) -> list[Row]:
    """Return the rows of mixed requests: that many twice, the first time to become warm."""
    # Caches that are full early: what they may take is not what is looked for.
    small = {"history_cache_bytes": str(8 * _MEBIBYTE), "mesh_cache_bytes": str(8 * _MEBIBYTE)}
    with server(small) as found:
        gamuts = []
        for seed in range(12):
            _, _, description = posted(found.port, {}, samples(seed))
            gamuts.append((description["id"], description["counts"]["triangles"]))
        _, _, description = posted(found.port, {})
        gamuts.append((description["id"], description["counts"]["triangles"]))
        known = samples(5000)
        uvloop.run(_posted(found.port, known))
        start = time.perf_counter()
        memory, statuses, wrong = uvloop.run(mixed(found, Mixture(gamuts, known), 2 * requests, 16))
        seconds = time.perf_counter() - start
    half = len(memory) // 2
    growth = slope(memory[half:])
    told = ", ".join(f"{status}: {count:,}" for status, count in sorted(statuses.items()))
    for line in wrong[:10]:
        sys.stderr.write(line + "\n")
    return [
        Row(
            "soak-memory",
            "soak",
            f"memory of the API process over {requests:,} mixed requests after {requests:,} that "
            "warm it up, 16 connections, with the image's MALLOC_ARENA_MAX=2",
            "slope ≤ 1 MiB per 10,000",
            f"{growth:+.2f} MiB per 10,000 ({slope(memory[:half]):+.2f} while it warms up); "
            f"{memory[0][1] / _MEBIBYTE:.0f} MiB after 1,000, "
            f"{memory[half][1] / _MEBIBYTE:.0f} after {memory[half][0]:,}, "
            f"{memory[-1][1] / _MEBIBYTE:.0f} at the end",
            growth <= 1,
        ),
        Row(
            "soak-answers",
            "soak",
            "answers to these that were not as expected",
            "0",
            f"{len(wrong)} ({told}; {2 * requests / seconds:,.0f} requests/s)",
            not wrong,
        ),
    ]


async def _posted(port: int, body: bytes) -> None:
    connection = Client(port)
    answer = await connection.answer(
        request("POST", "/v1/gamuts", body, Content_Type="application/json")
    )
    connection.close()
    if answer.status != 201:
        raise RuntimeError(answer.body)


def live_while_building(builds: int, seconds: float) -> list[Row]:
    """Return the row of ``/livez`` while builds wait and run."""

    async def measured(found: Server) -> tuple[list[float], int]:
        connection = Client(found.port)
        accepted = 0
        for seed in range(builds):
            options = {"surface_samples": 100_000 + seed}
            status, _, _ = await asyncio.to_thread(
                posted, found.port, options, None, "respond-async"
            )
            accepted += status == 202
        times = []
        end = time.perf_counter() + seconds
        while time.perf_counter() < end:
            start = time.perf_counter()
            answer = await connection.answer(request("GET", "/livez"))
            times.append(time.perf_counter() - start)
            assert answer.status == 200  # noqa: S101 - nothing else is an answer
            await asyncio.sleep(0.005)
        connection.close()
        return sorted(times), accepted

    with server({"build_workers": "2", "build_queue": str(builds)}, pin=False) as found:
        times, accepted = uvloop.run(measured(found))
    percentile = 1e3 * times[int(len(times) * 0.99)]
    return [
        Row(
            "soak-livez",
            "soak",
            f"`/livez` for {seconds:g} s while {accepted} builds wait and two workers build",
            "p99 ≤ 50 ms",
            f"p50 {1e3 * times[len(times) // 2]:.1f} ms, p99 {percentile:.1f} ms, "
            f"longest {1e3 * times[-1]:.0f} ms",
            percentile <= 50,
        )
    ]


def rates(requests: int, runs: int) -> list[Row]:
    """Return the rows of meshes per second."""
    rows = []
    for figures in mesh_rates(requests, runs):
        name = figures["request"]
        if name not in GOALS:
            continue
        least, longest = GOALS[name]
        kind = name.replace(", 1000 triangles", "").replace(", ", "-").replace(" ", "-")
        goal = f"≥ {least:,.0f} requests/s" + (f", p99 ≤ {longest:g} ms" if longest else "")
        met = figures["requests_per_s"] >= least
        met &= longest is None or figures["p99_ms"] <= longest
        rows.append(
            Row(
                f"speed-{kind}",
                "speed",
                f"GLB {name}, {figures['connections']} connections",
                goal,
                f"{figures['requests_per_s']:,.0f} requests/s, p99 {figures['p99_ms']:.1f} ms",
                bool(met),
            )
        )
    return rows


def main() -> int:
    """Run all, record the rows, and return whether something was not met."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--requests", type=int, default=100_000, help="mixed, after as many")
    parser.add_argument("--builds", type=int, default=100)
    parser.add_argument("--seconds", type=float, default=30)
    parser.add_argument("--runs", type=int, default=5)
    steps: dict[str, Callable[[], list[Row]]] = {
        "rates": lambda: rates(20_000, parsed.runs),
        "livez": lambda: live_while_building(parsed.builds, parsed.seconds),
        "mixed": lambda: soaked(parsed.requests),
    }
    parser.add_argument("--only", nargs="+", choices=[*steps], default=[*steps])
    parsed = parser.parse_args()
    met = True
    for name in parsed.only:
        rows = steps[name]()
        met &= recorded(rows)
        for row in rows:
            sys.stdout.write(f"{'ok ' if row.met else 'NOT'} {row.what}: {row.measured}\n")
            sys.stdout.flush()
    return 0 if met else 1


if __name__ == "__main__":
    sys.exit(main())
