"""A service on a loopback port, and a load generator in another process.

A server has a fresh data directory and one API process. With more than one core, the server and its
build worker are pinned to the first core and the load generator to the second.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, cast

import httpx
import uvloop

from benchmarks.common import FOGRA39L, ROOT, run_module

__all__ = ["SERVE", "Server", "load", "message", "server"]

SERVE = (sys.executable, "-c", "from service.__main__ import main; main()", "serve")
START_SECONDS = 900.0
"""A server that is not ready after so long has failed. A fresh clone compiles for minutes."""
CONNECTIONS = 16


class Server(NamedTuple):
    """A running server: its port, the seconds until it was ready, its process and its log."""

    port: int
    ready: float
    process: subprocess.Popen[bytes]
    log: Path
    client: httpx.Client

    def post(
        self, options: Mapping[str, object], data: bytes | None = None, prefer: str = "wait=600"
    ) -> httpx.Response:
        """Post a file (default FOGRA39L)."""
        files = {"file": ("file", FOGRA39L.read_bytes() if data is None else data)}
        fields = {"options": json.dumps(options)}
        return self.client.post("/v1/gamuts", files=files, data=fields, headers={"Prefer": prefer})

    def build(self, data: bytes | None = None) -> dict[str, Any]:
        """Build the gamut of a file (default FOGRA39L), and return its description."""
        answer = self.post({}, data)
        answer.raise_for_status()
        description: dict[str, Any] = answer.json()
        return description


@contextlib.contextmanager
def server(
    settings: Mapping[str, str] | None = None,
    *,
    pin: bool = True,
    command: Sequence[str] = SERVE,
    folder: Path = ROOT,
) -> Iterator[Server]:
    """Run a server with a fresh store, pinned to the first core or not."""
    with tempfile.TemporaryDirectory() as data:
        environment = {
            **{name: value for name, value in os.environ.items() if name != "MAKEFLAGS"},
            **{f"GAMUT_{name.upper()}": value for name, value in (settings or {}).items()},
            "GAMUT_PORT": "0",
            "GAMUT_STORE": str(Path(data) / "data"),
            "PYTHONUNBUFFERED": "1",
            "MALLOC_ARENA_MAX": "2",  # the setting of the container image
        }
        start = time.perf_counter()
        log = Path(data) / "log"
        with log.open("wb") as output:
            process = subprocess.Popen(
                [*(pinned(0) if pin else []), *command],
                cwd=folder,
                env=environment,
                stdout=output,
                stderr=output,
                start_new_session=True,
            )
        try:
            port = ready_port(process, log)
            ready = time.perf_counter() - start
            with httpx.Client(base_url=f"http://127.0.0.1:{port}", timeout=600) as client:
                yield Server(port, ready, process, log, client)
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGTERM)
            process.wait(60)


def pinned(core: int) -> list[str]:
    """Return the words that pin a command to a core, if `taskset` and several cores exist."""
    if sys.platform == "linux" and (os.cpu_count() or 1) > 1 and Path("/usr/bin/taskset").exists():
        return ["/usr/bin/taskset", "--cpu-list", str(core)]
    return []


def ready_port(process: subprocess.Popen[bytes], log: Path) -> int:
    """Wait until the server is ready and return the port, which its log names."""
    end = time.monotonic() + START_SECONDS
    while time.monotonic() < end:
        if process.poll() is not None:
            raise RuntimeError(log.read_text())
        if found := re.search(r"http://127\.0\.0\.1:(\d+)", log.read_text()):
            with contextlib.suppress(httpx.TransportError):
                if httpx.get(f"{found[0]}/readyz").status_code == 200:
                    return int(found[1])
        time.sleep(0.02)
    raise TimeoutError(f"The server was not ready in time. Its log:\n{log.read_text()}")


# --- the load generator ---------------------------------------------------------------------------


def load(port: int, messages: list[str], requests: int) -> dict[str, Any]:
    """Send messages in turn over several connections, from another process; return the figures."""
    text = json.dumps([port, messages, requests])
    figures: dict[str, Any] = json.loads(run_module("http", prefix=pinned(1), text=text))
    return figures


def message(path: str, fields: Sequence[str] = (), body: str = "") -> str:
    """Return a request as text. A body is JSON that is posted."""
    kind = ["Content-Type: application/json", f"Content-Length: {len(body)}"] if body else []
    head = [f"{'POST' if body else 'GET'} {path} HTTP/1.1", "Host: 127.0.0.1", *kind, *fields]
    return "\r\n".join([*head, "", body])


class Load:
    """Requests that remain, and what was answered."""

    def __init__(self, messages: list[str], requests: int) -> None:
        self.messages = [message.encode() for message in messages]
        self.remaining = requests
        self.latencies: list[float] = []
        self.statuses: Counter[int] = Counter()
        self.bytes = 0


class Connection(asyncio.Protocol):
    """A connection that sends a request when the previous one is answered, until none remains."""

    def __init__(self, run: Load) -> None:
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
        if self.run.remaining == 0:
            self.transport.close()
            return
        self.run.remaining -= 1
        self.sent = time.perf_counter()
        self.transport.write(self.run.messages[self.run.remaining % len(self.run.messages)])

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


async def generate(port: int, messages: list[str], requests: int) -> dict[str, Any]:
    """Send all requests and return the figures."""
    run, loop = Load(messages, requests), asyncio.get_running_loop()
    start = time.perf_counter()
    opened = [
        (await loop.create_connection(lambda: Connection(run), "127.0.0.1", port))[1]
        for _ in range(CONNECTIONS)
    ]
    await asyncio.gather(*(each.closed for each in opened))
    seconds = time.perf_counter() - start
    ordered = sorted(run.latencies)
    return {
        "requests": len(ordered),
        "requests/s": len(ordered) / seconds,
        "p50, ms": 1e3 * ordered[len(ordered) // 2],
        "p99, ms": 1e3 * ordered[int(0.99 * len(ordered))],
        "bytes per answer": run.bytes / len(ordered),
        "statuses": {str(status): count for status, count in run.statuses.items()},
    }


if __name__ == "__main__":
    print(json.dumps(uvloop.run(generate(*json.loads(input())))))
