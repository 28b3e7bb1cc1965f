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
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import httpx
import numpy as np
import uvloop

from benchmarks.common import FOGRA39L, ROOT, run_module

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


async def generate(port: int, messages: list[str], requests: int) -> dict[str, Any]:
    """Send all requests. Each connection sends one when the previous one is answered."""
    sent = [message.encode() for message in messages]
    numbers = iter(range(requests))
    latencies: list[float] = []
    sizes: list[int] = []

    async def connection() -> None:
        reader, writer = await asyncio.open_connection("127.0.0.1", port)
        for number in numbers:
            start = time.perf_counter()
            writer.write(sent[number % len(sent)])
            head = (await reader.readuntil(b"\r\n\r\n")).lower()
            length = int(head.partition(b"content-length:")[2].partition(b"\r\n")[0] or 0)
            await reader.readexactly(length)
            latencies.append(time.perf_counter() - start)
            if head[9:12] not in {b"200", b"304"}:
                raise RuntimeError(head.decode())
            sizes.append(len(head) + length)
        writer.close()

    start = time.perf_counter()
    await asyncio.gather(*(connection() for _ in range(CONNECTIONS)))
    seconds = time.perf_counter() - start
    middle, most = np.percentile(latencies, [50, 99])
    return {
        "requests": requests,
        "requests/s": requests / seconds,
        "p50, ms": 1e3 * middle,
        "p99, ms": 1e3 * most,
        "bytes per answer": sum(sizes) / requests,
    }


if __name__ == "__main__":
    print(json.dumps(uvloop.run(generate(*json.loads(input())))))
