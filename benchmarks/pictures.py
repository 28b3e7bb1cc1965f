"""Pictures of 24 megapixels, from the file to the gamut: `python -m benchmarks.pictures`.

Waves and noise in the place of a photograph, written by Pillow and by hand, each built in a process
of its own, whose peak memory includes the compiled kernels.
"""

from __future__ import annotations

import io
import re
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from PIL import Image

HEIGHT, WIDTH = 4000, 6000
PROFILE = Path(__file__).parents[1] / "tests" / "data" / "DisplayP3-v4.icc"


def photograph() -> np.ndarray:
    """Return (height, width, 3) float32 values from 0 to 1: six octaves of waves, 1 % of noise."""
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
    return np.clip(picture, 0, 1)


def plain_tiff(samples: np.ndarray) -> bytes:
    """Return a TIFF file of one strip without compression."""
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
    """Return a file that Pillow wrote, with a profile."""
    file = io.BytesIO()
    Image.fromarray(samples).save(file, file_format, icc_profile=PROFILE.read_bytes(), **how)
    return file.getvalue()


def measured(path: str) -> None:
    """Print a row for one file: seconds, processor seconds, megabytes, and what it holds."""
    from gamutcore.gamut import Options, build_gamut
    from gamutcore.warm import compile_kernels

    compile_kernels()
    data = Path(path).read_bytes()
    begun, processor = time.perf_counter(), time.process_time()
    found = build_gamut(data, Options()).description
    seconds, processor = time.perf_counter() - begun, time.process_time() - processor
    # Not from getrusage, whose peak a process takes over from the one that started it.
    status = Path("/proc/self/status").read_text()
    peak = int(re.search(r"VmHWM:\s*(\d+)", status)[1]) / 1024
    print(
        f"| {Path(path).name} | {len(data) / 1e6:.0f} MB "
        f"| {found['provenance']['distinct_values']} | {found['counts']['triangles']} "
        f"| {seconds:.1f} s | {processor:.1f} s | {peak:.0f} MB |"
    )


def main() -> None:
    """Measure every kind of file."""
    if len(sys.argv) > 1:
        measured(sys.argv[1])
        return
    picture = photograph()
    eight = np.round(picture * 255).astype(np.uint8)
    files = {
        "JPEG": lambda: by_pillow(eight, "JPEG", quality=92),
        "PNG, 8 bits": lambda: by_pillow(eight, "PNG", compress_level=1),
        "TIFF, LZW, 8 bits": lambda: by_pillow(eight, "TIFF", compression="tiff_lzw"),
        "TIFF, 16 bits": lambda: plain_tiff(np.round(picture * 65535).astype("<u2")),
        "TIFF, floats": lambda: plain_tiff(picture.astype("<f4")),
    }
    print("| file | size | distinct values | triangles | time | processor | peak |")
    print("|---|---|---|---|---|---|---|", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        for name, content in files.items():
            path = Path(folder) / name
            path.write_bytes(content())
            subprocess.run([sys.executable, "-m", "benchmarks.pictures", str(path)], check=True)
            path.unlink()


if __name__ == "__main__":
    main()
