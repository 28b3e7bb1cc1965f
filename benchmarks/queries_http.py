"""Speed and memory of queries over HTTP: ``make bench-queries-http``.

One API process answers on the loopback interface, with FOGRA39L and its default level. Times are
from the first byte of the request to the last byte of the answer, and the median of several.
Figures go to ``benchmarks/queries_http.json`` and into ``docs/benchmarks.md``.
"""

from __future__ import annotations

import http.client
import io
import json
import threading
import time
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from benchmarks import markdown
from benchmarks.bench import DOCUMENT
from benchmarks.common import resident_bytes
from benchmarks.http import Server, load, posted, server

__all__ = ["RESULTS", "document_blocks", "main"]

RESULTS = Path(__file__).with_suffix(".json")

NPY, JSON = "application/x-npy", "application/json"
MILLION = 1_000_000
RUNS = 7

GOALS = {
    "contains_million_s": ("1,000,000 colours as .npy, `contains`, s", "≤ 0.25"),
    "nearest_million_s": ("1,000,000 colours as .npy, `nearest`, s", "≤ 2"),
    "contains_thousand_ms": ("1,000 colours as JSON, `contains`, ms", "≤ 5"),
    "nearest_thousand_ms": ("1,000 colours as JSON, `nearest`, ms", "≤ 5"),
    "single_per_s": ("single colours as JSON, `contains`, requests/s", "≥ 3,000"),
    "contains_row_bytes": ("memory of `contains` beyond the body, bytes per row", "≤ 64"),
    "nearest_row_bytes": ("memory of `nearest` beyond the body, bytes per row", "≤ 64"),
    "livez_p99_ms": ("`/livez` while queries use all cores, 99th percentile, ms", "≤ 50"),
}
"""Figures with their titles and goals."""


def main() -> None:
    """Measure, and write the figures and the table."""
    results: dict[str, float] = {}
    with server(pin=False) as found:
        address = f"/v1/gamuts/{posted(found.port, {})[2]['id']}"
        colours = _colours(MILLION)
        million = _npy(colours)
        thousand = json.dumps({"colours": colours[:1000].round(3).tolist()}).encode()
        for name in ("contains", "nearest"):
            path = f"{address}/{name}"
            results[f"{name}_million_s"] = _seconds(found, path, million, NPY)
            results[f"{name}_thousand_ms"] = 1e3 * _seconds(found, path, thousand, JSON, 50)
            results[f"{name}_row_bytes"] = _row_bytes(found, path, million)
        body = json.dumps({"colours": colours[:1].round(3).tolist()})
        single = load(found.port, [f"{address}/contains"], 20_000, ["--body", body])
        results["single_per_s"] = single["requests_per_s"]
        results["livez_p99_ms"] = 1e3 * _livez(found, f"{address}/contains?max_error=0", million)
    RESULTS.write_text(json.dumps(results, indent=2) + "\n")
    blocks = document_blocks(results)
    print(*blocks.values(), sep="\n")
    markdown.update_document(DOCUMENT, blocks)


def document_blocks(results: dict[str, float]) -> dict[str, str]:
    """Return the generated block of the document."""
    rows = [
        [title, f"{results[name]:,.3g}" if results[name] < 1000 else f"{results[name]:,.0f}", goal]
        for name, (title, goal) in GOALS.items()
        if name in results
    ]
    return {"queries-http": markdown.table(["figure", "measured", "goal"], rows)}


def _colours(count: int) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Return random colours in CIELAB, of which a tenth is in gamut."""
    return np.random.default_rng(0).uniform((0, -110, -110), (100, 110, 110), (count, 3))


def _npy(colours: np.ndarray[Any, np.dtype[np.float64]]) -> bytes:
    file = io.BytesIO()
    np.save(file, colours)
    return file.getvalue()


def _post(found: Server, path: str, body: bytes, media_type: str) -> int:
    """Post a body and read the whole answer; return the status."""
    connection = http.client.HTTPConnection("127.0.0.1", found.port, timeout=120)
    connection.request("POST", path, body, {"Content-Type": media_type})
    answer = connection.getresponse()
    answer.read()
    connection.close()
    return answer.status


def _seconds(found: Server, path: str, body: bytes, media_type: str, runs: int = RUNS) -> float:
    _post(found, path, body, media_type)
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        if _post(found, path, body, media_type) != 200:
            raise RuntimeError(path)
        times.append(time.perf_counter() - start)
    return median(times)


def _row_bytes(found: Server, path: str, body: bytes) -> float:
    """Return the growth of the peak memory ÷ rows, without the body."""
    pid = found.process.pid
    before = resident_bytes(pid=pid)
    Path(f"/proc/{pid}/clear_refs").write_text("5")  # the peak begins anew
    _post(found, path, body, NPY)
    return (resident_bytes("VmHWM", pid) - before - len(body)) / MILLION


def _livez(found: Server, path: str, body: bytes, seconds: float = 10.0) -> float:
    """Return the 99th percentile of the time of ``/livez`` while four clients send queries."""
    end = time.perf_counter() + seconds

    def send() -> None:
        while time.perf_counter() < end:
            if _post(found, path, body, NPY) == 429:
                time.sleep(0.1)

    threads = [threading.Thread(target=send) for _ in range(4)]
    for thread in threads:
        thread.start()
    times = []
    connection = http.client.HTTPConnection("127.0.0.1", found.port, timeout=60)
    while (start := time.perf_counter()) < end:
        connection.request("GET", "/livez")
        connection.getresponse().read()
        times.append(time.perf_counter() - start)
        time.sleep(0.005)
    connection.close()
    for thread in threads:
        thread.join()
    times.sort()
    return times[int(0.99 * len(times))]


if __name__ == "__main__":
    main()
