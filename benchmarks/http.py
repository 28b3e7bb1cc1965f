"""Speed of the running service over real connections: builds and meshes.

A server runs on a free loopback port with a fresh data directory and one API process. The load
comes from another process. With more than one core, the server and its build worker are pinned to
the first core and the load generator to the second.
"""

from __future__ import annotations

import contextlib
import json
import os
import re
import subprocess
import sys
import tempfile
import time
import urllib.request
from collections.abc import Iterator, Mapping
from pathlib import Path
from statistics import median
from typing import Any, NamedTuple

from benchmarks.common import FOGRA39L, ROOT, run_module

__all__ = ["Server", "build_over_http", "mesh_rates", "posted", "server"]


class Server(NamedTuple):
    """A running server: its port, the seconds until it was ready, its process and its log."""

    port: int
    ready: float
    process: subprocess.Popen[bytes]
    log: Path


@contextlib.contextmanager
def server(settings: Mapping[str, str] | None = None, *, pin: bool = True) -> Iterator[Server]:
    """Run a server with a fresh store, pinned to the first core or not."""
    with tempfile.TemporaryDirectory() as folder:
        environment = {
            **os.environ,
            **{f"GAMUT_{name.upper()}": value for name, value in (settings or {}).items()},
            "GAMUT_STORE": str(Path(folder) / "data"),
            "PYTHONUNBUFFERED": "1",
            "MALLOC_ARENA_MAX": "2",  # the setting of the container image
        }
        start = time.perf_counter()
        command = [sys.executable, "-c", "from service.__main__ import main; main()"]
        log = Path(folder) / "log"
        with log.open("wb") as output:
            process = subprocess.Popen(
                [*(pinned(0) if pin else []), *command, "serve", "--port", "0"],
                cwd=ROOT,
                env=environment,
                stdout=output,
                stderr=output,
            )
        try:
            port = ready_port(process, log)
            yield Server(port, time.perf_counter() - start, process, log)
        finally:
            process.terminate()
            process.wait(30)


def pinned(core: int) -> list[str]:
    """Return the words that pin a command to a core, if `taskset` and several cores exist."""
    if sys.platform == "linux" and (os.cpu_count() or 1) > 1 and Path("/usr/bin/taskset").exists():
        return ["/usr/bin/taskset", "--cpu-list", str(core)]
    return []


def ready_port(process: subprocess.Popen[bytes], log: Path) -> int:
    """Wait until the server is ready and return the port, which its log names."""
    for _ in range(1200):
        if process.poll() is not None:
            raise RuntimeError(log.read_text())
        found = re.search(r"http://127\.0\.0\.1:(\d+)", log.read_text())
        if found:
            port = int(found[1])
            url = f"http://127.0.0.1:{port}/readyz"
            with contextlib.suppress(OSError), urllib.request.urlopen(url, timeout=5) as answer:
                if answer.status == 200:
                    return port
        time.sleep(0.05)
    raise TimeoutError(f"The server was not ready within a minute. Its log:\n{log.read_text()}")


def posted(
    port: int,
    options: Mapping[str, object],
    data: bytes | None = None,
    prefer: str = "wait=60",
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
    request = urllib.request.Request(
        f"http://127.0.0.1:{port}/v1/gamuts",
        data=b"".join(parts),
        headers={
            "Content-Type": f"multipart/form-data; boundary={border}",
            "Prefer": prefer,
        },
    )
    start = time.perf_counter()
    with urllib.request.urlopen(request, timeout=120) as answer:
        description = json.load(answer)
        return answer.status, time.perf_counter() - start, description


def build_over_http(runs: int) -> dict[str, Any]:
    """Time the first POST of FOGRA39L to a fresh server, and the median of the following ones."""
    with server() as found:
        status, first, _ = posted(found.port, {})
        # A slightly different γ makes each request a new build.
        further = [posted(found.port, {"gamma": 0.2 + 1e-6 * (run + 1)})[1] for run in range(runs)]
    return {"ready_s": found.ready, "status": status, "first_s": first, "median_s": median(further)}


def mesh_rates(requests: int, runs: int) -> list[dict[str, Any]]:
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
            paths = [f"{mesh}?{query}" for query in queries]
            fields = []
            if name.endswith("not modified"):
                with urllib.request.urlopen(f"http://127.0.0.1:{found.port}{paths[0]}") as answer:
                    fields = ["--header", f"If-None-Match: {answer.headers['ETag']}"]
            figures = [load(found.port, paths, requests, fields) for _ in range(runs)]
        figures.sort(key=lambda row: row["requests_per_s"])
        rows.append({"request": name, **figures[len(figures) // 2]})
    return rows


def load(port: int, paths: list[str], requests: int, arguments: list[str]) -> dict[str, Any]:
    """Return the figures of a load from another process."""
    words = [str(port), "--requests", str(requests), *arguments]
    figures: dict[str, Any] = json.loads(
        run_module("load", *words, prefix=pinned(1), text=json.dumps(paths))
    )
    return figures
