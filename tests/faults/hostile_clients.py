"""Attack a server with hostile clients while other clients use it: ``--full`` for the figures.

Attacks: endless chunked bodies, compressed bodies and pictures that unpack to gigabytes, forms of
100,000 fields, endless heads, heads and bodies sent byte by byte, crowds of silent connections,
error limits with expensive searches, queries that are endless, too large or too many, and clients
that do not read the answer. Each attack must end
with its expected status, the memory of the server may grow by at most 64 MB, and other clients must
be served. The program prints one line of JSON and exits with 1 if a condition fails.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import gzip
import http.client
import itertools
import json
import math
import struct
import sys
import threading
import time
import zlib
from collections import Counter
from collections.abc import AsyncIterator, Callable, Coroutine
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))

from serving import Serving, serving  # noqa: E402 - a program beside this one

MOST_GROWTH = 64 << 20
CONNECTIONS = 200
"""Connection limit of the server in these runs."""

QUERY_ROWS = 400_000
"""Limit of the rows under way in these runs."""

SECONDS = 1.0
"""Time limit for a head, a body and an answer of the server that slow clients attack. The other
server has none that a busy machine could reach."""

PATIENCE = 600
"""Seconds that end a client that hangs."""

BORDER = "hostile"
FORM = f"Content-Type: multipart/form-data; boundary={BORDER}\r\n"
FILE = f'--{BORDER}\r\nContent-Disposition: form-data; name="file"; filename="f"\r\n\r\n'.encode()
JSON = "Content-Type: application/json\r\n"


@dataclass
class Attack:
    """A kind of hostile client.

    Attributes
    ----------
    name : str
    statuses : set of int
        Expected statuses; 0 for a connection that is closed without an answer.
    client : callable
        (port) → status.
    clients : int
        Number of clients at the same time.
    slow : bool
        Whether the attack lasts until a time limit of the server ends it.
    """

    name: str
    statuses: set[int]
    client: Callable[[int], Coroutine[Any, Any, int]]
    clients: int = 1
    slow: bool = False


@dataclass
class Good:
    """A client that requests a mesh and ``/livez`` repeatedly.

    A busy machine may reach short time limits of the server: a patient client asks again.
    """

    server: Serving
    path: str
    patient: bool
    stopped: threading.Event = field(default_factory=threading.Event)
    latencies: list[float] = field(default_factory=list)
    failures: list[str] = field(default_factory=list)
    during: str = ""

    def run(self) -> None:
        connection = http.client.HTTPConnection("127.0.0.1", self.server.port, timeout=PATIENCE)
        while not self.stopped.wait(0.005):
            for path in (self.path, "/livez"):
                start = time.perf_counter()
                for left in reversed(range(30 if self.patient else 2)):
                    try:
                        status = self.status(connection, path)
                        failure = "" if status == 200 else f"{path}: {status}"
                    except (http.client.HTTPException, OSError) as error:
                        # The server may have closed the idle connection.
                        connection.close()
                        status, failure = 408, f"{path}: {error!r}"
                    if status != 408 or not left:
                        break
                self.failures += [failure] if failure else []
                elapsed = time.perf_counter() - start
                self.latencies.append(elapsed)
                if elapsed > 0.5:
                    sys.stderr.write(f"{path} took {elapsed:.2f} s, {self.during}\n")

    def status(self, connection: http.client.HTTPConnection, path: str) -> int:
        connection.request("GET", path)
        answer = connection.getresponse()
        answer.read()
        return answer.status


async def sent(
    port: int,
    head: str,
    chunks: AsyncIterator[bytes],
    *,
    reads: bool = True,
    stubborn: bool = False,
) -> int:
    """Send a request until the server answers or, if `stubborn`, to the end.

    Returns the status of the answer, 0 for none.
    """
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    status = 0

    async def answer() -> None:
        nonlocal status
        line = await reader.readline()
        if line:
            status = int(line.split()[1])

    listening = asyncio.create_task(answer()) if reads else None
    with contextlib.suppress(OSError):
        writer.write(head.encode())
        async for chunk in chunks:
            answered = (listening is not None and listening.done()) or reader.at_eof()
            if answered and not stubborn:
                break
            writer.write(chunk)
            await writer.drain()
    if listening is not None:
        with contextlib.suppress(OSError, asyncio.TimeoutError):
            await asyncio.wait_for(listening, PATIENCE)
    writer.close()
    with contextlib.suppress(OSError):
        await writer.wait_closed()
    return status


def post(fields: str) -> str:
    return f"POST /v1/gamuts HTTP/1.1\r\nHost: localhost\r\n{fields}\r\n"


async def once(content: bytes) -> AsyncIterator[bytes]:
    for start in range(0, len(content), 1 << 18):
        yield content[start : start + (1 << 18)]


async def endless(first: bytes, size: int) -> AsyncIterator[bytes]:
    """Iterate over the chunks of a body with that many bytes."""
    if first:
        yield b"%x\r\n%b\r\n" % (len(first), first)
    block = b"%x\r\n" % (1 << 20) + bytes(1 << 20) + b"\r\n"
    for _ in range(size >> 20):
        yield block


async def drops(data: bytes, seconds: float) -> AsyncIterator[bytes]:
    """Iterate over single bytes with pauses."""
    for number in data:
        yield bytes([number])
        await asyncio.sleep(seconds)


async def silence(seconds: float) -> AsyncIterator[bytes]:
    await asyncio.sleep(seconds)
    yield b""


async def forever(block: bytes, size: int) -> AsyncIterator[bytes]:
    for _ in range(size // len(block)):
        yield block


def npy(rows: int, shown: int | None = None) -> bytes:
    """Return an .npy file of neutral colours; its header may claim another number of rows."""
    shape = f"({rows if shown is None else shown}, 3)"
    text = f"{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}, }}".ljust(117) + "\n"
    head = b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text.encode()
    return head + struct.pack("<3f", 50, 0, 0) * rows


def png_bomb() -> bytes:
    """Return a picture of 100,000 × 100,000 pixels in 30 kB of data."""

    def chunk(name: bytes, data: bytes) -> bytes:
        return len(data).to_bytes(4) + name + data + zlib.crc32(name + data).to_bytes(4)

    size = (100_000).to_bytes(4) * 2 + bytes([8, 2, 0, 0, 0])
    pixels = zlib.compress(bytes(30_000_000), 9)
    return (
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", size) + chunk(b"IDAT", pixels) + chunk(b"IEND", b"")
    )


def form(parts: int) -> bytes:
    part = f'--{BORDER}\r\nContent-Disposition: form-data; name="f{{}}"\r\n\r\nx\r\n'
    return "".join(part.format(n) for n in range(parts)).encode() + f"--{BORDER}--\r\n".encode()


def attacks(mesh: str, *, full: bool) -> list[Attack]:
    """Return all attacks, in full size or at most a tenth of it."""
    size = 10 << 30 if full else 200 << 20
    bomb = gzip.compress(bytes(1 << 30 if full else 1 << 26))
    picture = FILE + png_bomb() + f"\r\n--{BORDER}--\r\n".encode()
    fields = form(100_000)
    crowd = 2000 if full else 250
    few = CONNECTIONS // 2

    def chunked(
        kind: str, first: bytes, *, stubborn: bool = False
    ) -> Callable[[int], Coroutine[Any, Any, int]]:
        head = post(kind + "Transfer-Encoding: chunked\r\n")
        return lambda port: sent(port, head, endless(first, size), stubborn=stubborn)

    def whole(kind: str, content: bytes) -> Callable[[int], Coroutine[Any, Any, int]]:
        head = post(f"{kind}Content-Length: {len(content)}\r\n")
        return lambda port: sent(port, head, once(content))

    get = f"GET {mesh} HTTP/1.1\r\nHost: localhost\r\n"
    numbers = itertools.count()

    def unheard_of_limits(port: int) -> Coroutine[Any, Any, int]:
        numbered = itertools.islice(numbers, 20)
        asked = [get.replace("triangles=1000", f"max_error={1e-3 * 1.002**n}") for n in numbered]
        return sent(port, "".join(f"{one}\r\n" for one in asked), silence(1))

    def query(name: str, fields: str) -> str:
        path = f"{mesh.partition('/mesh')[0]}/{name}"
        return f"POST {path} HTTP/1.1\r\nHost: localhost\r\n{fields}\r\n"

    def asked(name: str, content: bytes, **how: bool) -> Callable[[int], Coroutine[Any, Any, int]]:
        fields = f"Content-Type: application/x-npy\r\nContent-Length: {len(content)}\r\n"
        return lambda port: sent(port, query(name, fields), once(content), **how)

    endless_query = query("contains", JSON + "Transfer-Encoding: chunked\r\n")
    many = npy(100_000)
    whole_mesh = get.replace("triangles=1000", "max_error=0")
    return [
        Attack("endless file", {413}, chunked(FORM, FILE)),
        Attack("endless file, whatever is answered", {413}, chunked(FORM, FILE, stubborn=True)),
        Attack("endless JSON", {413}, chunked(JSON, b'{"samples": [')),
        Attack("endless preamble", {400, 413}, chunked(FORM, b"")),
        Attack("compressed body", {415}, whole(JSON + "Content-Encoding: gzip\r\n", bomb)),
        Attack("picture that unpacks to 30 GB", {422}, whole(FORM, picture)),
        Attack("form of 100,000 fields", {413}, whole(FORM, fields), 4),
        Attack(
            "declared body of 10 GB",
            {413},
            lambda port: sent(port, post(FORM + f"Content-Length: {10 << 30}\r\n"), once(FILE)),
        ),
        Attack(
            "endless head",
            {431},
            lambda port: sent(port, get + "A: ", forever(b"a" * 65536, size >> 4)),
            4,
        ),
        Attack(
            "head by the byte",
            {0, 408},
            lambda port: sent(port, "", drops(get.encode() * 50, 0.1)),
            CONNECTIONS * 2,
            slow=True,
        ),
        Attack(
            "body by the byte",
            {408, 503},
            lambda port: sent(
                port, post(JSON + "Content-Length: 100000\r\n"), drops(bytes(1000), 0.1)
            ),
            few,
            slow=True,
        ),
        Attack(
            "crowd that says nothing",
            {0},
            lambda port: sent(port, "", silence(SECONDS + 0.7)),
            crowd,
            slow=True,
        ),
        Attack(
            "no answer is taken",
            {0},
            lambda port: sent(
                port, (whole_mesh + "\r\n") * 30, silence(SECONDS + 1.2), reads=False
            ),
            few,
            slow=True,
        ),
        Attack("limits to the error that nobody asked for before", {200}, unheard_of_limits, few),
        Attack(
            "endless query",
            {413},
            lambda port: sent(port, endless_query, endless(b'{"colours": [', size)),
        ),
        Attack("query of 70 MB", {413}, asked("contains", npy(6_000_000))),
        Attack("query that claims a billion rows", {422}, asked("contains", npy(10, 10**9))),
        Attack("query of half of its rows", {422}, asked("nearest", npy(1000, 2000))),
        Attack("crowd of large queries", {200, 429}, asked("map", many), few),
        Attack(
            "crowd of queries whose answer nobody takes",
            {0},
            asked("contains?distance=true", many, reads=False),
            few,
            slow=True,
        ),
        Attack(
            "thousands of requests ahead",
            {0},
            lambda port: sent(port, (get + "\r\n") * 2000, silence(1), reads=False),
            few,
            slow=True,
        ),
    ]


async def suffered(server: Serving, good: Good, *, full: bool) -> list[dict[str, Any]]:
    """Run the attacks one after the other and return their results."""
    rows = []
    for attack in attacks(good.path, full=full):
        if attack.slow != good.patient:
            continue
        good.during = attack.name
        start, before = time.perf_counter(), server.resident()
        statuses = await asyncio.gather(
            *(attack.client(server.port) for _ in range(attack.clients)), return_exceptions=True
        )
        # A refused or reset connection counts as closed without an answer.
        found = Counter(0 if isinstance(one, OSError) else one for one in statuses)
        rows.append(
            {
                "attack": attack.name,
                "clients": attack.clients,
                "statuses": {str(status): count for status, count in found.items()},
                "as_deserved": set(found) <= attack.statuses,
                "seconds": round(time.perf_counter() - start, 1),
                "growth_mb": round((server.resident() - before) / 1e6, 1),
            }
        )
    return rows


def sphere(count: int) -> list[list[float]]:
    """Return evenly spread colours on a sphere."""
    turn = math.pi * (3 - math.sqrt(5))
    points = []
    for number in range(count):
        z = 1 - 2 * (number + 0.5) / count
        radius = math.sqrt(1 - z * z)
        points.append(
            [
                50 + 40 * z,
                40 * radius * math.cos(turn * number),
                40 * radius * math.sin(turn * number),
            ]
        )
    return points


def main() -> int:
    """Run all attacks and return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--full", action="store_true", help="10 GB and thousands of clients")
    full = parser.parse_args().full
    runs = [attacked(full=full, slow=slow) for slow in (False, True)]
    latencies = sorted(itertools.chain(*(run["latencies"] for run in runs)))
    failures = list(itertools.chain(*(run["failures"] for run in runs)))
    figures = {
        "attacks": list(itertools.chain(*(run["attacks"] for run in runs))),
        "growth_mb": round(max(run["growth"] for run in runs) / 1e6, 1),
        "good_requests": len(latencies),
        "good_failures": failures[:10],
        "good_p50_ms": round(1e3 * latencies[len(latencies) // 2], 1),
        "good_p99_ms": round(1e3 * latencies[int(0.99 * len(latencies))], 1),
        "good_worst_ms": round(1e3 * latencies[-1], 1),
        "tracebacks": sum(run["defects"] for run in runs),
    }
    sys.stdout.write(json.dumps(figures) + "\n")
    right = all(row["as_deserved"] for row in figures["attacks"])
    right = right and not failures and not figures["tracebacks"]
    return 0 if right and all(run["growth"] <= MOST_GROWTH for run in runs) else 1


def attacked(*, full: bool, slow: bool) -> dict[str, Any]:
    """Attack a server that has short time limits, or none that is reached."""
    seconds = SECONDS if slow else PATIENCE
    limits = {
        **dict.fromkeys(("head_timeout", "body_timeout", "write_timeout"), seconds),
        "max_connections": CONNECTIONS,
        "query_rows": QUERY_ROWS,
    }
    with serving(**limits) as server:
        gamut = server.built(sphere(2000))
        good = Good(server, f"/v1/gamuts/{gamut['id']}/mesh?triangles=1000", patient=slow)
        thread = threading.Thread(target=good.run)
        thread.start()
        while len(good.latencies) < 20:
            time.sleep(0.01)
        quiet = server.resident()
        peak = [quiet]

        def watch() -> None:
            while not good.stopped.wait(0.02):
                peak[0] = max(peak[0], server.resident())

        watching = threading.Thread(target=watch)
        watching.start()
        try:
            rows = asyncio.run(suffered(server, good, full=full))
        finally:
            good.stopped.set()
            thread.join()
            watching.join()
        log = server.log.read_text()
        sys.stderr.write(log[log.find("Traceback") :][:5000] if "Traceback" in log else "")
    return {
        "attacks": rows,
        "growth": peak[0] - quiet,
        "latencies": good.latencies,
        "failures": good.failures,
        "defects": log.count("Traceback"),
    }


if __name__ == "__main__":
    sys.exit(main())
