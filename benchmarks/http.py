"""A running service over real connections: how fast it answers.

A server runs on a free loopback port with a fresh data directory and one API process. The load
comes from another process (``python -m benchmarks.http PORT``). With more than one core, the server
and its build worker are pinned to the first core and the load generator to the second.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import io
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
import urllib.error
import urllib.request
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from statistics import median
from typing import Any, NamedTuple, cast

import numpy as np
import uvloop

from benchmarks.common import FOGRA39L, ROOT, Rows, resident_bytes, run_module

__all__ = ["Server", "mesh_rates", "posted", "query_figures", "request", "server"]

SERVE = (sys.executable, "-c", "from service.__main__ import main; main()", "serve")
START_SECONDS = 900.0
"""A server that is not ready after so long has failed. A fresh clone compiles for minutes."""

NPY, JSON = "application/x-npy", "application/json"
MILLION = 1_000_000


class Server(NamedTuple):
    """A running server: its port, the seconds until it was ready, its process and its log."""

    port: int
    ready: float
    process: subprocess.Popen[bytes]
    log: Path


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
        kept = {name: value for name, value in os.environ.items() if name != "MAKEFLAGS"}
        environment = {
            **kept,
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
            yield Server(port, time.perf_counter() - start, process, log)
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
            with contextlib.suppress(OSError):
                if request(int(found[1]), "/readyz")[0] == 200:
                    return int(found[1])
        time.sleep(0.02)
    raise TimeoutError(f"The server was not ready in time. Its log:\n{log.read_text()}")


def request(
    port: int, path: str, body: bytes | None = None, fields: Mapping[str, str] | None = None
) -> tuple[int, bytes]:
    """Return status and content of an answer. A body is posted."""
    asked = urllib.request.Request(
        f"http://127.0.0.1:{port}{path}", data=body, headers=dict(fields or {})
    )
    try:
        with urllib.request.urlopen(asked, timeout=600) as answer:
            return answer.status, answer.read()
    except urllib.error.HTTPError as error:
        return error.code, error.read()


def posted(
    port: int,
    options: Mapping[str, object],
    data: bytes | None = None,
    prefer: str = "wait=600",
) -> tuple[int, float, dict[str, Any]]:
    """Post a file (default FOGRA39L); return status, seconds and the answer's JSON content."""
    border = "benchmark-border"
    parts = [
        f'--{border}\r\nContent-Disposition: form-data; name="options"\r\n\r\n'
        f"{json.dumps(options)}\r\n".encode(),
        f'--{border}\r\nContent-Disposition: form-data; name="file"; filename="f"\r\n\r\n'.encode(),
        FOGRA39L.read_bytes() if data is None else data,
        f"\r\n--{border}--\r\n".encode(),
    ]
    fields = {"Content-Type": f"multipart/form-data; boundary={border}", "Prefer": prefer}
    start = time.perf_counter()
    status, content = request(port, "/v1/gamuts", b"".join(parts), fields)
    return status, time.perf_counter() - start, json.loads(content)


def mesh_rates(requests: int, runs: int) -> Rows:
    """Rates of meshes of about 1,000 triangles: encoded anew, repeated, and not modified."""
    rows = []
    uncached, counts = {"mesh_cache_bytes": "0"}, range(502, 1502, 2)
    glb, ply = [f"triangles={n}" for n in counts], [f"triangles={n}&format=ply" for n in counts]
    for name, settings, queries in (
        ("uncached, 500 counts in turn", uncached, glb),
        ("uncached PLY, 500 counts in turn", uncached, ply),
        ("repeated, 1000 triangles", {}, ["triangles=1000"]),
        ("repeated, 1000 triangles, not modified", {}, ["triangles=1000"]),
    ):
        with server(settings) as found:
            mesh = f"/v1/gamuts/{posted(found.port, {})[2]['id']}/mesh"
            fields = ["--header", "If-None-Match: *"] if name.endswith("not modified") else []
            paths = [f"{mesh}?{query}" for query in queries]
            figures = [load(found.port, paths, requests, fields) for _ in range(runs)]
        figures.sort(key=lambda row: row["requests/s"])
        rows.append({"request": name, **figures[len(figures) // 2]})
    return rows


def load(port: int, paths: list[str], requests: int, arguments: Sequence[str]) -> dict[str, Any]:
    """Return the figures of a load from another process."""
    words = [str(port), "--requests", str(requests), *arguments]
    figures: dict[str, Any] = json.loads(
        run_module("http", *words, prefix=pinned(1), text=json.dumps(paths))
    )
    return figures


# --- queries --------------------------------------------------------------------------------------


def query_figures(runs: int) -> Rows:
    """Time and memory of queries about FOGRA39L and its default level, with the goals."""
    rows: Rows = []
    colours = np.random.default_rng(0).uniform((0, -110, -110), (100, 110, 110), (MILLION, 3))
    file = io.BytesIO()
    np.save(file, colours)
    million = file.getvalue()
    with server(pin=False) as found:
        gamut = f"/v1/gamuts/{posted(found.port, {})[2]['id']}"

        def add(figure: str, measured: float, goal: str) -> None:
            rows.append({"figure": figure, "measured": measured, "goal": goal})

        def seconds(name: str, body: bytes, kind: str, runs: int) -> float:
            times = []
            for _ in range(runs + 1):
                start = time.perf_counter()
                status, _content = request(
                    found.port, f"{gamut}/{name}", body, {"Content-Type": kind}
                )
                if status != 200:
                    raise RuntimeError(f"{name} was answered with {status}")
                times.append(time.perf_counter() - start)
            return median(times[1:])

        thousand = json.dumps({"colours": colours[:1000].round(3).tolist()}).encode()
        for name, goal in (("contains", "≤ 0.25"), ("nearest", "≤ 2")):
            taken = 1e3 * seconds(name, thousand, JSON, 7 * runs)
            add(f"1,000 colours as JSON, `{name}`, ms", taken, "≤ 5")
            pid = found.process.pid
            before = resident_bytes(pid=pid)
            Path(f"/proc/{pid}/clear_refs").write_text("5")  # the peak begins anew
            seconds(name, million, NPY, 1)
            growth = resident_bytes("VmHWM", pid) - before - len(million)
            add(f"memory of `{name}` beyond the body, bytes per row", growth / MILLION, "≤ 64")
            taken = seconds(name, million, NPY, runs)
            add(f"1,000,000 colours as .npy, `{name}`, s", taken, goal)
        body = json.dumps({"colours": colours[:1].round(3).tolist()})
        single = load(found.port, [f"{gamut}/contains"], 2000 * runs, ["--body", body])
        add("single colours as JSON, `contains`, requests/s", single["requests/s"], "≥ 3,000")
        taken = 1e3 * busy_livez(found.port, f"{gamut}/contains?max_error=0", million, 1.5 * runs)
        add("`/livez` while queries use all cores, 99th percentile, ms", taken, "≤ 50")
    return rows


def busy_livez(port: int, path: str, body: bytes, seconds: float) -> float:
    """Return the 99th percentile of the time of ``/livez`` while four clients send queries."""
    end = time.perf_counter() + seconds

    def send() -> None:
        while time.perf_counter() < end:
            status = 429
            with contextlib.suppress(OSError):  # refused before the body was sent
                status, _ = request(port, path, body, {"Content-Type": NPY})
            if status == 429:
                time.sleep(0.1)

    threads = [threading.Thread(target=send) for _ in range(4)]
    for thread in threads:
        thread.start()
    times = []
    while (start := time.perf_counter()) < end:
        request(port, "/livez")
        times.append(time.perf_counter() - start)
        time.sleep(0.005)
    for thread in threads:
        thread.join()
    return sorted(times)[int(0.99 * len(times))]


# --- the load generator ---------------------------------------------------------------------------


class Load:
    """Requests that remain, and what was answered."""

    def __init__(self, messages: list[bytes], requests: int) -> None:
        self.messages = messages
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


async def generate(run: Load, port: int, connections: int) -> dict[str, Any]:
    """Send all requests and return the figures."""
    start = time.perf_counter()
    loop = asyncio.get_running_loop()
    opened = [
        (await loop.create_connection(lambda: Connection(run), "127.0.0.1", port))[1]
        for _ in range(connections)
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


def main() -> None:
    """Run one load and print its figures. The paths are a JSON list on standard input."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("port", type=int)
    parser.add_argument("--requests", type=int, default=20_000)
    parser.add_argument("--connections", type=int, default=16)
    parser.add_argument("--header", action="append", default=[], help="such as 'Accept: */*'")
    parser.add_argument("--body", default="", help="JSON to post")
    parsed = parser.parse_args()
    sent = ["Content-Type: application/json", f"Content-Length: {len(parsed.body)}"]
    fields = ["Host: 127.0.0.1", *(sent if parsed.body else []), *parsed.header]
    head = "".join(f"{field}\r\n" for field in fields)
    method = "POST" if parsed.body else "GET"
    messages = [
        f"{method} {path} HTTP/1.1\r\n{head}\r\n{parsed.body}".encode()
        for path in json.loads(input())
    ]
    run = Load(messages, parsed.requests)
    print(json.dumps(uvloop.run(generate(run, parsed.port, parsed.connections))))


if __name__ == "__main__":
    main()
