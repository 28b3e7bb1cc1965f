"""Attack a server with hostile clients while other clients use it: ``--full`` for the figures.

`attacks` is the table of what they do. Each attack must end with its expected status, the memory of
the server may grow by at most 64 MB above the idle server (128 MB when hundreds of connections
send megabytes at once), and a client at another address must be served. The program prints one line
of JSON and exits with 1 if a condition fails.
"""

import argparse
import asyncio
import contextlib
import gzip
import http.client
import io
import itertools
import json
import sys
import threading
import time
import zlib
from collections import Counter
from collections.abc import AsyncIterator, Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))

from serving import PATIENCE, Serving, serving

MOST_GROWTH = 64 << 20
BURST_GROWTH = 128 << 20
"""Growth while all connections send 1 MB at once: of each, the server reads 256 kB at a time, and
has them twice for a moment."""

CONNECTIONS = 200
"""Connection limit of the server in these runs."""

FEW = CONNECTIONS // 2

CLAIM = 32_000_000
"""Length of a body of 400,000 rows as CSV, which never arrives."""

COLOURS = json.dumps({"colours": [[50, 0, 0]] * 20})
"""More rows than are answered on the event loop."""

LARGE = 64
"""Limit of large bodies: each takes up to 0.6 MB for a moment, when all of it comes at once."""

SECONDS = 1.0
"""Time limit for a body of the server that slow clients attack. The other server has none that a
busy machine could reach. Slow heads, silent clients and slow readers are the task of a proxy."""

FORM = "Content-Type: multipart/form-data; boundary=hostile\r\n"
PART = '--hostile\r\nContent-Disposition: form-data; name="{}"\r\n\r\n'
FILE = PART.format('file"; filename="f').encode()
END = b"\r\n--hostile--\r\n"
JSON = "Content-Type: application/json\r\n"
NPY = "Content-Type: application/x-npy\r\n"
CSV = "Content-Type: text/csv\r\n"
CHUNKED = "Transfer-Encoding: chunked\r\n"


@dataclass
class Attack:
    """A kind of hostile client, and how many there are at the same time.

    A status of 0 is a connection that is closed without an answer. A slow attack lasts until a time
    limit of the server ends it. A stubborn client sends to the end, whatever is answered. The
    clients have one address, or are strangers to each other.
    """

    name: str
    statuses: set[int]
    head: str
    chunks: Callable[[], AsyncIterator[bytes]]
    clients: int = 1
    slow: bool = False
    reads: bool = True
    stubborn: bool = False
    strangers: bool = False
    most_growth: int = MOST_GROWTH

    async def client(self, port, number):
        """Send a request until the server answers; return the status of the answer, 0 for none."""
        address = f"127.0.1.{number % 250 + 1}" if self.strangers else "127.0.0.2"
        reader, writer = await asyncio.open_connection(
            "127.0.0.1", port, local_addr=(address, 0) if sys.platform == "linux" else None
        )
        listening = asyncio.create_task(reader.readline()) if self.reads else None
        line = b""
        with contextlib.suppress(OSError):
            writer.write(self.head.encode())
            async for chunk in self.chunks():
                answered = (listening is not None and listening.done()) or reader.at_eof()
                if answered and not self.stubborn:
                    break
                writer.write(chunk)
                await writer.drain()
        if listening is not None:
            with contextlib.suppress(OSError, asyncio.TimeoutError):
                line = await asyncio.wait_for(listening, PATIENCE)
        writer.close()
        with contextlib.suppress(OSError):
            await writer.wait_closed()
        return int(line.split()[1]) if line else 0


async def once(content):
    for start in range(0, len(content), 1 << 18):
        yield content[start : start + (1 << 18)]


async def endless(first, size):
    """Iterate over the chunks of a body with that many bytes."""
    if first:
        yield b"%x\r\n%b\r\n" % (len(first), first)
    block = b"%x\r\n" % (1 << 20) + bytes(1 << 20) + b"\r\n"
    for _ in range(size >> 20):
        yield block


async def drops(data):
    """Iterate over single bytes with pauses."""
    for number in data:
        yield bytes([number])
        await asyncio.sleep(SECONDS / 10)


async def trickle(seconds):
    """Iterate over rows at 5 kB/s, and stop before the body is complete."""
    for _ in range(int(seconds * 10)):
        yield b"50,0,0\n" * 70
        await asyncio.sleep(0.1)


async def silence(seconds, first=b""):
    yield first
    await asyncio.sleep(seconds)
    yield b""


async def repeated(block, times):
    for _ in range(times):
        yield block


def npy(rows, shown=None):
    """Return an .npy file of neutral colours; its header may claim another number of rows."""
    file = io.BytesIO()
    header = {"descr": "<f4", "fortran_order": False, "shape": (shown or rows, 3)}
    np.lib.format.write_array_header_1_0(file, header)
    return file.getvalue() + np.tile(np.float32([50, 0, 0]), rows).tobytes()


def png_bomb():
    """Return a picture of 100,000 × 100,000 pixels in 30 kB of data."""

    def chunk(name, data):
        return len(data).to_bytes(4) + name + data + zlib.crc32(name + data).to_bytes(4)

    size = (100_000).to_bytes(4) * 2 + bytes([8, 2, 0, 0, 0])
    pixels = zlib.compress(bytes(30_000_000), 9)
    chunks = chunk(b"IHDR", size) + chunk(b"IDAT", pixels) + chunk(b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + chunks


def attacks(mesh, *, full):
    """Return all attacks, in full size or at most a tenth of it."""
    size = 10 << 30 if full else 200 << 20
    bomb = gzip.compress(bytes(1 << 30 if full else 1 << 26))
    picture = FILE + png_bomb() + END
    fields = b"".join(f"{PART.format(n)}x\r\n".encode() for n in range(100_000)) + END
    get = f"GET {mesh} HTTP/1.1\r\nHost: localhost\r\n"
    ahead = 2000 * f"{get}\r\n"
    distance = "contains?distance=true"
    ignored = {"clients": FEW, "reads": False}
    counted = itertools.count()
    megabyte = b'{"samples": [' + b"[50,0,0]," * 110_000
    burst = {"clients": 600, "most_growth": BURST_GROWTH} if full else {"clients": 40}
    nearly = bytes((1 << 20) - 100) + b"\r\n"
    unknown = PART.format("comment").encode() + nearly
    options = PART.format("options").encode() + nearly

    def post(fields, name=""):
        path = f"{mesh.partition('/mesh')[0]}/{name}" if name else "/v1/gamuts"
        return f"POST {path} HTTP/1.1\r\nHost: localhost\r\n{fields}\r\n"

    def whole(name, statuses, fields, content, to="", **how):
        head = post(f"{fields}Content-Length: {len(content)}\r\n", to)
        return Attack(name, statuses, head, lambda: once(content), **how)

    def never_ends(name, statuses, fields, first, to="", **how):
        head = post(fields + CHUNKED, to)
        return Attack(name, statuses, head, lambda: endless(first, size), **how)

    def unheard_of_limits():
        limits = [1e-3 * 1.002**number for number in itertools.islice(counted, 20)]
        asked = [get.replace("triangles=1000", f"max_error={limit}") for limit in limits]
        return silence(1, "".join(f"{one}\r\n" for one in asked).encode())

    def forty(name, statuses, part):
        head = post(f"{FORM}Content-Length: {40 * len(part)}\r\n")
        many = {"clients": 70 if full else 20, "strangers": True}
        return Attack(name, statuses, head, lambda: repeated(part, 40), **many)

    claimed = post(f"{CSV}Content-Length: {CLAIM}\r\n", "contains")
    body_of_10_gb = post(f"{FORM}Content-Length: {10 << 30}\r\n")
    body_by_the_byte = post(f"{JSON}Content-Length: 100000\r\n")
    many, block = npy(100_000), b"a" * 65536
    fast = [
        never_ends("endless file", {413}, FORM, FILE),
        never_ends("endless file, whatever is answered", {413}, FORM, FILE, stubborn=True),
        never_ends("endless JSON", {413}, JSON, b'{"samples": ['),
        never_ends("endless preamble", {400, 413}, FORM, b""),
        whole("compressed body", {415}, JSON + "Content-Encoding: gzip\r\n", bomb),
        whole("picture that unpacks to 30 GB", {422}, FORM, picture),
        whole("form of 100,000 fields", {413}, FORM, fields, clients=4),
        forty("forty parts of 1 MiB that nobody knows", {413}, unknown),
        forty("forty times options of 1 MiB", {413}, options),
        whole(
            "crowd of JSON bodies of 1 MB",
            {0, 400, 408, 429, 503},
            JSON,
            megabyte,
            strangers=True,
            **burst,
        ),
        Attack("declared body of 10 GB", {413}, body_of_10_gb, lambda: once(FILE)),
        Attack("endless head", {0, 400}, get + "A: ", lambda: repeated(block, size >> 20), 4),
        Attack(
            "limits to the error that nobody asked for before",
            {200, 429},  # beyond the requests of a client that may wait
            "",
            unheard_of_limits,
            FEW,
        ),
        never_ends("endless query", {413}, JSON, b'{"colours": [', "contains"),
        whole("query of 70 MB", {413}, NPY, npy(6_000_000), "contains"),
        whole("query that claims a billion rows", {422}, NPY, npy(10, 10**9), "contains"),
        whole("query of half of its rows", {422}, NPY, npy(1000, 2000), "nearest"),
        Attack(
            "all rows claimed, and sent at 5 kB/s",
            {0},
            claimed,
            lambda: trickle(20 if full else 3),
            clients=8 if full else 2,
            reads=False,
        ),
        whole("crowd of large queries", {200, 429}, NPY, many, "map", clients=FEW),
    ]
    slow = [
        Attack(
            "body by the byte", {408, 429, 503}, body_by_the_byte, lambda: drops(bytes(1000)), FEW
        ),
        Attack(
            "crowd of JSON bodies that lack the end",
            {0, 408, 429, 503},
            post(f"{JSON}Content-Length: {len(megabyte) + 1}\r\n"),
            lambda: once(megabyte),
            strangers=True,
            **burst,
        ),
        whole("crowd of queries whose answer nobody takes", {0}, NPY, many, distance, **ignored),
        Attack("thousands of requests ahead", {0}, ahead, lambda: silence(1), **ignored),
    ]
    for attack in slow:
        attack.slow = True
    return fast + slow


@dataclass
class Good:
    """A client that requests a mesh, a query and ``/livez`` repeatedly.

    A busy machine may reach short time limits of the server: a patient client asks again.
    """

    server: Serving
    path: str
    patient: bool
    stopped: threading.Event = field(default_factory=threading.Event)
    latencies: list[float] = field(default_factory=list)
    failures: list[str] = field(default_factory=list)
    during: str = ""

    def run(self):
        connection = http.client.HTTPConnection("127.0.0.1", self.server.port, timeout=PATIENCE)
        while not self.stopped.wait(0.005):
            for path in (self.path, self.path.replace("mesh", "contains"), "/livez"):
                start = time.perf_counter()
                for _ in range(30 if self.patient else 2):
                    status = self.status(connection, path)
                    if status not in {0, 408}:
                        break
                self.failures += [f"{path}: {status}"] if status != 200 else []
                self.latencies.append(time.perf_counter() - start)
                if self.latencies[-1] > 0.5:
                    print(f"{path} took long, {self.during}", file=sys.stderr)

    @staticmethod
    def status(connection, path):
        """Return the status of an answer; 0 for a connection that the server has closed."""
        try:
            if "contains" in path:
                connection.request("POST", path, COLOURS, {"Content-Type": "application/json"})
            else:
                connection.request("GET", path)
            answer = connection.getresponse()
            answer.read()
        except (http.client.HTTPException, OSError):
            connection.close()
            return 0
        return answer.status


async def suffered(server, good, *, full):
    """Run the attacks one after the other and return their results."""
    rows, idle = [], server.resident()
    for attack in attacks(good.path, full=full):
        if attack.slow != good.patient:
            continue
        good.during = attack.name
        start = time.perf_counter()
        server.reset_peak()
        clients = (attack.client(server.port, number) for number in range(attack.clients))
        statuses = await asyncio.gather(*clients, return_exceptions=True)
        growth = server.peak() - idle
        # A refused or reset connection counts as closed without an answer.
        found = Counter(0 if isinstance(one, OSError) else one for one in statuses)
        rows.append(
            {
                "attack": attack.name,
                "clients": attack.clients,
                "statuses": {str(status): count for status, count in found.items()},
                "as_deserved": set(found) <= attack.statuses and growth <= attack.most_growth,
                "seconds": round(time.perf_counter() - start, 1),
                "growth_mb": round(growth / 1e6, 1),
                "kept_mb": round((server.resident() - idle) / 1e6, 1),
            }
        )
    return rows


def attacked(*, full, slow):
    """Attack a server that has short time limits, or none that is reached.

    Returns the good client, the results of the attacks, and the log of the server.
    """
    seconds = SECONDS if slow else PATIENCE
    directions = np.random.default_rng(0).normal(size=(2000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    body = {"samples": (40 * directions + (50, 0, 0)).tolist()}
    # An open port, whose parser limits heads.
    access = {"host": "0.0.0.0", "allow_anonymous": "all"}  # noqa: S104 - of this machine
    limits = {"max_connections": CONNECTIONS, "large_bodies": LARGE}
    with serving(body_timeout=seconds, **limits, **access) as server:
        gamut = server.client.post("/v1/gamuts", json=body, headers={"Prefer": "wait=300"}).json()
        for path in ("map", "nearest", "contains?distance=true"):  # loads kernels
            answer = server.client.post(
                f"/v1/gamuts/{gamut['id']}/{path}", json=json.loads(COLOURS)
            )
            answer.raise_for_status()
        good = Good(server, f"/v1/gamuts/{gamut['id']}/mesh?triangles=1000", patient=slow)
        thread = threading.Thread(target=good.run)
        thread.start()
        while len(good.latencies) < 20:
            time.sleep(0.01)
        try:
            rows = asyncio.run(suffered(server, good, full=full))
        finally:
            good.stopped.set()
            thread.join()
        return good, rows, server.log()


def main():
    """Run all attacks and return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--full", action="store_true", help="10 GB and thousands of clients")
    full = parser.parse_args().full
    runs = [attacked(full=full, slow=slow) for slow in (False, True)]
    latencies = sorted(latency for good, *_ in runs for latency in good.latencies)
    failures = [failure for good, *_ in runs for failure in good.failures]
    rows = [row for _, rows, _ in runs for row in rows]
    logs = "".join(log for *_, log in runs)
    figures = {
        "attacks": rows,
        "growth_mb": max(row["growth_mb"] for row in rows),
        "good_requests": len(latencies),
        "good_failures": failures[:10],
        "good_p99_ms": round(1e3 * latencies[int(0.99 * len(latencies))], 1),
        "tracebacks": logs.count("Traceback"),
    }
    sys.stderr.write(logs[logs.find("Traceback") :][:5000] if figures["tracebacks"] else "")
    print(json.dumps(figures))
    right = all(row["as_deserved"] for row in rows)
    return 0 if right and not failures and not figures["tracebacks"] else 1


if __name__ == "__main__":
    sys.exit(main())
