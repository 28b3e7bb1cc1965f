"""HTTP load generator: ``python -m benchmarks.load PORT``, run as a process of its own.

Each connection sends one request after the other, without pipelining. The paths are a JSON list on
standard input. Prints rate, latencies and statuses as JSON.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import time
from collections import Counter
from typing import cast

import uvloop

__all__ = ["Run", "main"]


class Run:
    """A number of requests to a loopback port, spread over several connections.

    They are GET without a body, and POST with one, which is JSON.
    """

    def __init__(
        self, port: int, paths: list[str], requests: int, fields: list[str], body: str = ""
    ) -> None:
        sent = [f"Content-Length: {len(body)}", "Content-Type: application/json"] if body else []
        fields = ["Host: 127.0.0.1", "Accept: */*", *sent, *fields]
        head = "".join(f"{field}\r\n" for field in fields)
        method = "POST" if body else "GET"
        self.port = port
        self.messages = [f"{method} {path} HTTP/1.1\r\n{head}\r\n{body}".encode() for path in paths]
        self.remaining = requests
        self.latencies: list[float] = []
        self.statuses: Counter[int] = Counter()
        self.bytes = 0

    def next_message(self) -> bytes | None:
        """Return the next request, None after the last."""
        if self.remaining == 0:
            return None
        self.remaining -= 1
        return self.messages[self.remaining % len(self.messages)]

    async def figures(self, connections: int) -> dict[str, object]:
        """Send all requests and return the figures."""
        loop = asyncio.get_running_loop()
        start = time.perf_counter()
        opened = [
            (await loop.create_connection(lambda: Connection(self), "127.0.0.1", self.port))[1]
            for _ in range(connections)
        ]
        await asyncio.wait_for(asyncio.gather(*(each.closed for each in opened)), 120)
        seconds = time.perf_counter() - start
        ordered = sorted(self.latencies)
        return {
            "requests": len(ordered),
            "connections": connections,
            "requests_per_s": len(ordered) / seconds,
            "p50_ms": 1e3 * ordered[len(ordered) // 2],
            "p99_ms": 1e3 * ordered[int(len(ordered) * 0.99)],
            "bytes_per_answer": self.bytes / len(ordered),
            "statuses": {str(status): count for status, count in self.statuses.items()},
        }


class Connection(asyncio.Protocol):
    """A keep-alive connection that sends the next request after each complete answer."""

    def __init__(self, run: Run) -> None:
        self.run = run
        self.buffer = bytearray()
        self.answer_bytes = 0
        self.closed: asyncio.Future[None] = asyncio.get_running_loop().create_future()

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        # uvloop's transports implement asyncio.Transport without inheriting from it.
        self.transport = cast("asyncio.Transport", transport)
        self.send()

    def send(self) -> None:
        """Send the next request, or close the connection after the last."""
        message = self.run.next_message()
        if message is None:
            self.transport.close()
            return
        self.sent = time.perf_counter()
        self.transport.write(message)

    def data_received(self, data: bytes) -> None:
        self.buffer += data
        if not self.answer_bytes:
            end = self.buffer.find(b"\r\n\r\n")
            if end < 0:
                return
            head = bytes(self.buffer[:end]).lower()
            self.run.statuses[int(head[9:12])] += 1
            length = head.partition(b"content-length:")[2].partition(b"\r\n")[0]
            self.answer_bytes = end + 4 + int(length or 0)
        if len(self.buffer) >= self.answer_bytes:
            self.run.latencies.append(time.perf_counter() - self.sent)
            self.run.bytes += self.answer_bytes
            del self.buffer[: self.answer_bytes]
            self.answer_bytes = 0
            self.send()

    def connection_lost(self, error: Exception | None) -> None:
        if error is not None:
            self.closed.set_exception(error)
        else:
            self.closed.set_result(None)


def main() -> None:
    """Run one load and print its figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("port", type=int)
    parser.add_argument("--requests", type=int, default=20_000)
    parser.add_argument("--connections", type=int, default=16)
    parser.add_argument("--header", action="append", default=[], help="such as 'Accept: */*'")
    parser.add_argument("--body", default="", help="JSON to post")
    parsed = parser.parse_args()
    run = Run(parsed.port, json.loads(input()), parsed.requests, parsed.header, parsed.body)
    print(json.dumps(uvloop.run(run.figures(parsed.connections))))


if __name__ == "__main__":
    main()
