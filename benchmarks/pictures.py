"""Time and memory from pictures of 24 megapixels to their gamuts.

The picture is a sum of waves with noise. Each gamut is built in a fresh process
(``python -m benchmarks.pictures FILE``), whose peak memory includes the compiled kernels.
"""

from __future__ import annotations

import io
import json
import struct
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from benchmarks import http
from benchmarks.common import ROOT, resident_bytes, run_module
from gamutcore import Gamut
from gamutcore.arrays import Float32Array
from gamutcore.warm import compile_kernels

__all__ = ["picture_times"]

HEIGHT, WIDTH = 4000, 6000
MAX_BODY_BYTES = str(320 * 2**20)
"""Limit of the server. 24 megapixels of floats exceed the default limit."""

PROFILE = ROOT / "tests" / "data" / "DisplayP3-v4.icc"


def photograph() -> Float32Array:
    """Return six octaves of waves with 1 % noise: (height, width, 3) float32, 0 to 1."""
    chance = np.random.default_rng(0)
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH].astype(np.float32)
    picture = np.zeros((HEIGHT, WIDTH, 3), np.float32)
    for channel in range(3):
        for octave in range(6):
            frequency, phases = 2.0**octave * 2 * np.pi / WIDTH, chance.uniform(0, 2 * np.pi, 2)
            waves = np.sin(frequency * x + phases[0]) * np.sin(1.3 * frequency * y + phases[1])
            picture[:, :, channel] += waves / 1.4**octave
    picture = (picture - picture.min()) / (picture.max() - picture.min())
    picture += chance.normal(0, 0.01, picture.shape).astype(np.float32)
    clipped: Float32Array = np.clip(picture, 0, 1)
    return clipped


def plain_tiff(samples: np.ndarray) -> bytes:
    """Return an uncompressed TIFF file with one strip."""
    data, bits = samples.tobytes(), 8 * samples.dtype.itemsize
    tags = [
        (256, 4, WIDTH), (257, 4, HEIGHT), (258, 3, bits), (259, 3, 1), (262, 3, 2), (273, 4, 8),
        (277, 3, 3), (278, 4, HEIGHT), (279, 4, len(data)),
        (339, 3, 3 if samples.dtype.kind == "f" else 1),
    ]  # fmt: skip
    table = b"".join(struct.pack("<HHII", tag, kind, 1, value) for tag, kind, value in tags)
    head = struct.pack("<2sHI", b"II", 42, 8 + len(data))
    return head + data + struct.pack("<H", len(tags)) + table + bytes(4)


def by_pillow(samples: np.ndarray, file_format: str, **how: object) -> bytes:
    """Return a file with an embedded profile, written by Pillow."""
    file = io.BytesIO()
    Image.fromarray(samples).save(file, file_format, icc_profile=PROFILE.read_bytes(), **how)
    return file.getvalue()


def picture_times(runs: int) -> list[dict[str, Any]]:
    """Measure median time and peak memory for every kind of picture."""
    picture = photograph()
    eight = np.round(picture * 255).astype(np.uint8)
    files: dict[str, Callable[[], bytes]] = {
        "JPEG": lambda: by_pillow(eight, "JPEG", quality=92),
        "PNG, 8 bits": lambda: by_pillow(eight, "PNG", compress_level=1),
        "TIFF, LZW, 8 bits": lambda: by_pillow(eight, "TIFF", compression="tiff_lzw"),
        "TIFF, 16 bits": lambda: plain_tiff(np.round(picture * 65535).astype("<u2")),
        "TIFF, floats": lambda: plain_tiff(picture.astype("<f4")),
    }
    rows = []
    limits = {"max_body_bytes": MAX_BODY_BYTES}
    with tempfile.TemporaryDirectory() as folder, http.server(limits) as service:
        path = Path(folder) / "picture"
        for name, content in files.items():
            path.write_bytes(content())
            found = sorted(
                (_build_in_process(path) for _ in range(runs)), key=lambda row: row["seconds"]
            )
            status, seconds, _ = http.posted(service.port, {}, path.read_bytes())
            row = {"picture": name, **found[len(found) // 2], "http_s": seconds}
            rows.append({**row, "status": status})
    return rows


def _build_in_process(path: Path) -> dict[str, Any]:
    row: dict[str, Any] = json.loads(run_module("pictures", str(path)))
    return row


def main() -> None:
    """Build the gamut of one file and print time and memory as JSON."""
    compile_kernels()
    data = Path(sys.argv[1]).read_bytes()
    start = time.perf_counter()
    found = Gamut(data).description
    seconds = time.perf_counter() - start
    row = {
        "file_mb": len(data) / 1e6,
        "distinct_values": found["provenance"]["distinct_values"],
        "triangles": found["counts"]["triangles"],
        "seconds": seconds,
        "peak_mb": resident_bytes("VmHWM") / 2**20,
    }
    print(json.dumps(row))


if __name__ == "__main__":
    main()
