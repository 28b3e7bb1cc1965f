"""Measure speed, memory and accuracy of builds, levels and the service: ``make bench``.

Writes the tables of ``docs/benchmarks.md`` to ``benchmarks/results.json`` and into the document.
``--only NAME ...`` repeats some measurements and keeps the figures of the others. ``--quick`` takes
fewer runs and writes nothing.
"""

from __future__ import annotations

import argparse
import functools
import io
import json
import struct
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from PIL import Image

from benchmarks import http, markdown
from benchmarks.common import (
    DOCUMENT,
    FOGRA39L,
    P3,
    RESULTS,
    SHARED,
    SRGB,
    FloatArray,
    Rows,
    build_mesh_history,
    machine,
    resident_bytes,
    run_module,
    surface_points,
    times_of,
    use_one_core,
)
from gamutcore import Gamut
from gamutcore.boundary import modified_convex_hull
from gamutcore.characterisation import IccProfile, Samples, characterisation
from gamutcore.colours.device.scattered_model import scattered_model
from gamutcore.colours.measured_colours import measured_colours
from gamutcore.colours.profile_colours import profile_colours
from gamutcore.warm import compile_kernels

if TYPE_CHECKING:
    from gamutcore.mesh import DeviceValues

__all__ = ["DOCUMENT", "RESULTS", "machine", "main"]

FILES = {
    "press, 1,617 patches": FOGRA39L,
    "display profile, matrix": SRGB,
    "press profile, CMYK": SHARED / "press" / "ISOcoated_v2_300_bas.icc",
    "press profile, 7 inks": SHARED / "oracle" / "Ref-ECG-CMYKOGV_FOGRA55_TAC300.icc",
}
"""Files whose licence does not allow shipping are measured only beside the shared data."""

HEIGHT, WIDTH = 4000, 6000
SERVICE = {"max_body_bytes": str(320 * 2**20)}
"""24 megapixels of floats exceed the default limit."""


def main() -> int:
    """Measure, print and write."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.bench", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="take fewer runs and write nothing")
    parser.add_argument("--build", metavar="FILE", help=argparse.SUPPRESS)
    parser.add_argument("--only", nargs="+", metavar="NAME")
    arguments = parser.parse_args()
    if arguments.build:
        print(json.dumps(build(Path(arguments.build).read_bytes())))
        return 0
    quick = arguments.quick
    measurements: dict[str, Callable[[], Rows]] = {
        "machine": lambda: [machine("scipy", "trimesh", "uvicorn")],
        "inputs": lambda: inputs(1 if quick else 5),
        "meshes": lambda: http.mesh_rates(*((2000, 1) if quick else (20_000, 5))),
        "queries-http": lambda: http.query_figures(1 if quick else 7),
        "device-values": device_values,
        "levels": lambda: levels([10_000] if quick else [10_000, 100_000, 1_000_000]),
    }
    if unknown := set(arguments.only or []) - set(measurements):
        parser.error(f"Unknown: {', '.join(unknown)}. Known: {', '.join(measurements)}.")
    compile_kernels()
    for name in [each for each in measurements if each in (arguments.only or measurements)]:
        rows = measurements[name]()
        if quick:
            print(markdown.rows_table(rows), flush=True)
        else:
            markdown.record({name: rows})
    return 0


def inputs(runs: int) -> Rows:
    """Time from a POST to the answer 201, memory, and sizes, for every kind of input."""
    rows = []
    with tempfile.TemporaryDirectory() as folder, http.server(SERVICE) as service:
        path = Path(folder) / "input"
        for name, data in contents():
            path.write_bytes(data)
            sizes = json.loads(run_module("bench", "--build", str(path)))
            # A slightly different γ makes each request a new build.
            answers = [
                http.posted(service.port, {"gamma": 0.2 + 1e-6 * run}, data) for run in range(runs)
            ]
            if any(status != 201 for status, *_ in answers):
                raise RuntimeError(f"{name}: {answers[0]}")
            taken = median(seconds for _, seconds, _ in answers)
            rows.append({"input": name, "POST to 201, s": taken, **sizes})
    return rows


def build(data: bytes) -> dict[str, Any]:
    """Build the gamut of a file in this process, and open it again."""
    compile_kernels()
    history = Gamut(data)
    peak = resident_bytes("VmHWM")
    content = history.to_bytes()
    opened = Gamut.from_bytes(content)
    opened.level(1000)
    times = times_of(lambda: Gamut.from_bytes(content).level(1000), 5, time.process_time)
    return {
        "peak memory, MB": peak / 1e6,
        "file, kB": len(data) / 1e3,
        "triangles": history.history.triangles,
        "history, kB": len(content) / 1e3,
        "open history, kB": opened.nbytes / 1e3,
        "opened, to 1,000 triangles, ms": 1e3 * median(times),
    }


def contents() -> Iterator[tuple[str, bytes]]:
    """Iterate over names and contents of inputs: files, and pictures of 24 megapixels."""
    for name, path in FILES.items():
        if path.is_file():
            yield name, path.read_bytes()
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
    picture = np.clip(picture, 0, 1)
    for kind, how in (("JPEG", {"quality": 92}), ("PNG", {"compress_level": 1})):
        file = io.BytesIO()
        Image.fromarray(np.round(picture * 255).astype(np.uint8)).save(
            file, kind, icc_profile=P3.read_bytes(), **how
        )
        yield f"{kind}, 24 megapixels", file.getvalue()
    yield "TIFF, 16 bits", plain_tiff(np.round(picture * 65535).astype("<u2"))
    yield "TIFF, floats", plain_tiff(picture.astype("<f4"))


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


def levels(sizes: list[int]) -> Rows:
    """Time to read levels of open histories of different sizes."""
    use_one_core()  # comes last: servers that start later would inherit it
    rows = []
    for samples in sizes:
        boundary = modified_convex_hull(surface_points(SRGB, samples))
        history = build_mesh_history(boundary.mesh, boundary.centre, "quadric")
        row = {
            "triangles": history.triangles,
            "memory, bytes per triangle": history.nbytes / history.triangles,
        }
        for count in (100, 1000, 10_000, history.triangles):
            name = "all, ms" if count == history.triangles else f"{count:,}, ms"
            row[name] = 1e3 * median(times_of(functools.partial(history.level, count), 200))
        rows.append(row)
    return rows


def device_values() -> Rows:
    """Difference ΔE*ab of vertices from the colours of their device values, mean / largest."""
    rows = []
    for name, path, cost in (
        ("FOGRA39L", FOGRA39L, "volume"),
        ("FOGRA39L", FOGRA39L, "finest"),
        ("sRGB", SRGB, "volume"),
        ("Display P3", P3, "volume"),
    ):
        gamut, model = Gamut(path.read_bytes(), cost=cost), device_model(path)
        row: dict[str, Any] = {"device": name, "cost": cost}
        for count in (100, 300, 1000, 10_000, 40_000):
            level = gamut.level(count)
            predicted = model(cast("DeviceValues", level.device).values.astype(np.float64))
            found = np.linalg.norm(predicted - level.vertices, axis=1)
            row[f"ΔE at {count:,}"] = f"{found.mean():.3f} / {found.max():.2f}"
        rows.append(row)
    return rows


def device_model(path: Path) -> Callable[[FloatArray], FloatArray]:
    """Return the function from device values to media-relative CIELAB."""
    device = characterisation(path.read_bytes())
    if isinstance(device, IccProfile):
        return lambda values: profile_colours(device, values, "relative").lab
    if not isinstance(device, Samples):
        raise TypeError(f"{path.name} contains neither a profile nor measurements.")
    lab = measured_colours(device, "relative").lab
    given = cast("FloatArray", device.device)
    values, which, counts = np.unique(given, axis=0, return_inverse=True, return_counts=True)
    sums = np.zeros((len(values), 3))
    np.add.at(sums, which.reshape(-1), lab)
    return scattered_model(values, sums / counts[:, np.newaxis]).colours


if __name__ == "__main__":
    sys.exit(main())
