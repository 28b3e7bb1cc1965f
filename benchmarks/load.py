"""A small HTTP load generator: ``python -m benchmarks.load``, run as a process of its own.

It keeps a number of connections busy with one request after the other, none of them pipelined, for
a number of requests, and prints what it saw as JSON. Only loopback addresses are accepted.
"""

from __future__ import annotations

import argparse
import asyncio
import ipaddress
import json
import time
from collections.abc import Sequence
from typing import cast

import uvloop

__all__ = ["main"]


class Connection(asyncio.Protocol):
    """One keep-alive connection that sends the next request when an answer is complete."""

    def __init__(self, run: Run) -> None:
        self.run = run
        self.buffer = bytearray()
        self.wanted = -1

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        # asyncio's promise for TCP; uvloop's transports keep it without being of the class
        self.transport = cast("asyncio.Transport", transport)
        self.send()

    def send(self) -> None:
        """Send the next request, or close when there is none left."""
        request = self.run.next_request()
        if request is None:
            self.transport.close()
            return
        self.sent = time.perf_counter()
        self.transport.write(request)

    def data_received(self, data: bytes) -> None:
        self.buffer += data
        if self.wanted < 0:
            end = self.buffer.find(b"\r\n\r\n")
            if end < 0:
                return
            head = bytes(self.buffer[:end]).lower()
            self.status = int(head[9:12])
            length = head.split(b"content-length:", 1)
            body = int(length[1].split(b"\r\n", 1)[0]) if len(length) == 2 else 0
            self.wanted = end + 4 + body
        if len(self.buffer) >= self.wanted:
            self.run.answered(self.status, time.perf_counter() - self.sent, self.wanted)
            del self.buffer[: self.wanted]
            self.wanted = -1
            self.send()

    def connection_lost(self, error: Exception | None) -> None:
        self.run.closed(error)


class Run:
    """A number of requests, taken in turn from a list of paths, and what became of them."""

    def __init__(
        self, host: str, paths: list[str], requests: int, connections: int, fields: Sequence[str]
    ) -> None:
        head = "".join(f"{field}\r\n" for field in (f"Host: {host}", "Accept: */*", *fields))
        self.requests = [f"GET {path} HTTP/1.1\r\n{head}\r\n".encode() for path in paths]
        self.left = requests
        self.open = connections
        self.latencies: list[float] = []
        self.statuses: dict[int, int] = {}
        self.bytes = 0
        self.done: asyncio.Future[None] = asyncio.get_running_loop().create_future()

    def next_request(self) -> bytes | None:
        """Return the next request, None when enough were sent."""
        if self.left == 0:
            return None
        self.left -= 1
        return self.requests[self.left % len(self.requests)]

    def answered(self, status: int, latency: float, size: int) -> None:
        """Count an answer."""
        self.latencies.append(latency)
        self.statuses[status] = self.statuses.get(status, 0) + 1
        self.bytes += size

    def closed(self, error: Exception | None) -> None:
        """Count a connection that is gone; the last one ends the run."""
        self.open -= 1
        if (error is not None or self.open == 0) and not self.done.done():
            self.done.set_result(None)


async def measured(
    host: str,
    port: int,
    paths: list[str],
    requests: int,
    connections: int,
    fields: Sequence[str] = (),
) -> dict[str, object]:
    """Return requests per second, latencies and statuses of a run."""
    loop = asyncio.get_running_loop()
    run = Run(host, paths, requests, connections, fields)
    start = time.perf_counter()
    for _ in range(connections):
        await loop.create_connection(lambda: Connection(run), host, port)
    await asyncio.wait_for(run.done, 120)
    seconds = time.perf_counter() - start
    ordered = sorted(run.latencies)
    return {
        "requests": len(ordered),
        "connections": connections,
        "requests_per_s": len(ordered) / seconds,
        "p50_ms": 1e3 * ordered[len(ordered) // 2],
        "p99_ms": 1e3 * ordered[int(len(ordered) * 0.99)],
        "bytes_per_answer": run.bytes / len(ordered),
        "statuses": {str(status): count for status, count in run.statuses.items()},
    }


def main() -> None:
    """Run one load and print its figures as a line of JSON; paths come on standard input."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("host")
    parser.add_argument("port", type=int)
    parser.add_argument("--requests", type=int, default=20_000)
    parser.add_argument("--connections", type=int, default=16)
    parser.add_argument("--header", action="append", default=[], help="a field, as in 'Name: x'")
    parsed = parser.parse_args()
    if not ipaddress.ip_address(parsed.host).is_loopback:
        parser.error("only loopback addresses are measured")
    paths = json.loads(input())
    figures = uvloop.run(
        measured(
            parsed.host, parsed.port, paths, parsed.requests, parsed.connections, parsed.header
        )
    )
    print(json.dumps(figures))


if __name__ == "__main__":
    main()
