"""Time from the bytes of different inputs to surface colours, and over HTTP to a gamut.

Inputs whose licence does not allow shipping are measured only beside the shared data.
"""

from __future__ import annotations

import functools
import hashlib
import json
import time
from collections import Counter
from collections.abc import Iterator
from statistics import median
from typing import Any

from benchmarks import http
from benchmarks.common import FOGRA39L, SHARED, SRGB, device_data, times_of
from gamutcore import Gamut
from gamutcore.colours import surface_colours

__all__ = ["found", "gamut_sizes", "input_times"]

FILES = {
    "press, 1,617 patches": FOGRA39L,
    "display profile, matrix": SRGB,
    "press profile, CMYK": SHARED / "press" / "ISOcoated_v2_300_bas.icc",
    "press profile, 7 inks": SHARED / "oracle" / "Ref-ECG-CMYKOGV_FOGRA55_TAC300.icc",
}


def input_times(runs: int) -> list[dict[str, Any]]:
    """Time each file to at most 100,000 surface colours, and from its POST to the answer 201."""
    rows = []
    for name, data in found():
        sampled = functools.partial(_surface_points, data)
        rows.append(
            {
                "input": name,
                "points": sampled(),
                "colours_s": median(times_of(sampled, runs)),
            }
        )
    with http.server() as service:
        for row, (_name, data) in zip(rows, found(), strict=True):
            # A slightly different γ makes each request a new build.
            answers = [
                http.posted(service.port, {"gamma": 0.2 + 1e-6 * run}, data)
                for run in range(runs + 1)
            ]
            row["http_s"] = median(seconds for _, seconds, _ in answers[1:])
            row["statuses"] = dict(Counter(str(status) for status, _, _ in answers))
    return rows


def gamut_sizes(runs: int = 5) -> list[dict[str, Any]]:
    """Return sizes and opening times of a gamut of each available input."""
    rows = []
    for name, data in found():
        gamut = Gamut(data)
        content = gamut.to_bytes()
        seconds = []
        for _ in range(runs):
            start = time.perf_counter()
            hashlib.sha256(content).digest()  # the store checks the digest
            opened = Gamut.from_bytes(content)
            opened.level(1000)
            seconds.append(time.perf_counter() - start)
        rows.append(
            {
                "input": name,
                "triangles": gamut.history.triangles,
                "input_bytes": len(data),
                "history_bytes": len(content),
                "record_bytes": len(json.dumps(gamut.description, separators=(",", ":"))),
                "open_bytes": opened.nbytes,
                "opening_s": median(seconds),
            }
        )
    return rows


def _surface_points(data: bytes) -> int:
    return len(surface_colours(device_data(data)).points)


def found() -> Iterator[tuple[str, bytes]]:
    """Iterate over names and contents of the available files."""
    for name, path in FILES.items():
        if path.is_file():
            yield name, path.read_bytes()
