"""Measure the tables of ``docs/benchmarks.md``: ``make bench``.

Writes the tables to ``benchmarks/results.json`` and into the document. ``--only NAME ...`` selects
tables and keeps the others. Without it, builds, levels and the service are measured. ``--quick``
takes fewer runs and writes nothing.
"""

from __future__ import annotations

import argparse
import functools
import io
import json
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
import OpenImageIO
from PIL import Image

from benchmarks import markdown, summary
from benchmarks.boundaries import boundaries
from benchmarks.common import (
    DOCUMENT,
    FOGRA39L,
    P3,
    SHARED,
    SRGB,
    Rows,
    build_mesh_history,
    machine,
    resident_bytes,
    run_module,
    surface_points,
    times_of,
    use_one_core,
)
from benchmarks.http import load, message, server
from benchmarks.links import clips, links
from benchmarks.profiles import profiles
from benchmarks.queries import colour_queries, level_queries
from benchmarks.recipes import continuity, recipes
from benchmarks.startup import startup
from benchmarks.viewer import viewer
from gamutcore import Gamut
from gamutcore.boundary import modified_convex_hull
from gamutcore.warm import compile_kernels

__all__ = ["DOCUMENT", "main"]

FILES = {
    "press, 1,617 patches": FOGRA39L,
    "display profile, matrix": SRGB,
    "press profile, CMYK": SHARED / "press" / "ISOcoated_v2_300_bas.icc",
    "press profile, 7 inks": SHARED / "oracle" / "Ref-ECG-CMYKOGV_FOGRA55_TAC300.icc",
}
"""Files whose licence does not allow shipping are measured only beside the shared data."""

HEIGHT, WIDTH = 4000, 6000
MILLION = 1_000_000


def main() -> None:
    """Measure, print and write."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.bench", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="take fewer runs and write nothing")
    parser.add_argument("--build", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--only", nargs="+", choices=[*MEASUREMENTS], default=DEFAULT)
    arguments = parser.parse_args()
    compile_kernels()
    if arguments.build:
        print(json.dumps(build(arguments.build.read_bytes())))
        return
    for name in [each for each in MEASUREMENTS if each in arguments.only]:
        rows = MEASUREMENTS[name](arguments.quick)
        if arguments.quick:
            print(markdown.rows_table(rows), flush=True)
        else:
            summary.record({name: rows})


def inputs(quick: bool) -> Rows:
    """Time from a POST to the answer 201, memory, and sizes, for every kind of input."""
    rows = []
    settings = {"max_body_bytes": str(320 * 2**20)}  # 24 megapixels of floats exceed the default
    with tempfile.TemporaryDirectory() as folder, server(settings) as service:
        path = Path(folder) / "input"
        for name, data in contents():
            path.write_bytes(data)
            sizes = json.loads(run_module("bench", "--build", str(path)))
            seconds = []
            for run in range(1 if quick else 5):
                # A slightly different γ makes each request a new build.
                answer = service.post({"gamma": 0.2 + 1e-6 * run}, data)
                answer.raise_for_status()
                seconds.append(answer.elapsed.total_seconds())
            rows.append({"input": name, "POST to 201, s": median(seconds), **sizes})
    return rows


def build(data: bytes) -> dict[str, Any]:
    """Build the gamut of a file in this process."""
    gamut = Gamut(data)
    return {
        "peak memory, MB": resident_bytes("VmHWM") / 1e6,
        "file, kB": len(data) / 1e3,
        "triangles": gamut.history.triangles,
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
    yield "TIFF, 16 bits", plain_tiff(np.round(picture * 65535).astype(np.uint16))
    yield "TIFF, floats", plain_tiff(picture)


def plain_tiff(samples: np.ndarray) -> bytes:
    """Return an uncompressed TIFF file."""
    with tempfile.NamedTemporaryFile(suffix=".tif") as file:
        image = OpenImageIO.ImageBuf(samples)
        image.specmod()["compression"] = "none"
        image.write(file.name)
        return Path(file.name).read_bytes()


def meshes(quick: bool) -> Rows:
    """Rates of meshes of about 1,000 triangles: encoded anew, repeated, and not modified."""
    rows = []
    uncached, counts = {"mesh_cache_bytes": "0"}, range(502, 1502, 2)
    glb, ply = [f"triangles={n}" for n in counts], [f"triangles={n}&format=ply" for n in counts]
    for name, settings, queries, fields in (
        ("uncached, 500 counts in turn", uncached, glb, []),
        ("uncached PLY, 500 counts in turn", uncached, ply, []),
        ("repeated, 1000 triangles", {}, ["triangles=1000"], []),
        ("repeated, 1000 triangles, not modified", {}, ["triangles=1000"], ["If-None-Match: *"]),
    ):
        with server(settings) as found:
            mesh = f"/v1/gamuts/{found.build()['id']}/mesh"
            messages = [message(f"{mesh}?{query}", fields) for query in queries]
            requests, runs = (2000, 1) if quick else (20_000, 5)
            figures = [load(found.port, messages, requests) for _ in range(runs)]
        figures.sort(key=lambda row: row["requests/s"])
        rows.append({"request": name, **figures[runs // 2]})
    return rows


def plain_fastapi(quick: bool) -> Rows:
    """Rates of a repeated mesh beside those of a plain FastAPI application, in turns."""
    requests, runs = (2000, 3) if quick else (10_000, 7)
    ratios, rates = [], []
    with tempfile.NamedTemporaryFile() as file, server() as found:
        path = f"/v1/gamuts/{found.build()['id']}/mesh?triangles=1000"
        file.write(found.client.get(path).content)
        file.flush()
        command = (sys.executable, "-m", "benchmarks.plain_fastapi", file.name)
        with server(command=command) as plain:
            for _ in range(runs):
                ours, theirs = (
                    load(each.port, [message(path)], requests)["requests/s"]
                    for each in (found, plain)
                )
                ratios.append(ours / theirs)
                rates.append((ours, theirs))
    ours, theirs = np.median(rates, axis=0)
    return [
        {
            "request": "repeated, 1000 triangles",
            "requests/s": ours,
            "plain FastAPI, requests/s": theirs,
            "ratio": float(np.median(ratios)),
            "goal": 1.2,
        }
    ]


def http_queries(quick: bool) -> Rows:
    """Time and memory of queries about FOGRA39L and its default level, with the goals."""
    rows: Rows = []
    runs = 1 if quick else 7
    colours = np.random.default_rng(0).uniform((0, -110, -110), (100, 110, 110), (MILLION, 3))
    file = io.BytesIO()
    np.save(file, colours)
    million = file.getvalue()
    thousand = json.dumps({"colours": colours[:1000].round(3).tolist()}).encode()
    with server(pin=False) as found:
        gamut, pid = f"/v1/gamuts/{found.build()['id']}", found.process.pid

        def post(name: str, body: bytes, kind: str) -> None:
            fields = {"Content-Type": f"application/{kind}"}
            answer = found.client.post(f"{gamut}/{name}", content=body, headers=fields)
            answer.raise_for_status()

        def add(figure: str, measured: float, goal: str) -> None:
            rows.append({"figure": figure, "measured": measured, "goal": goal})

        for name, goal in (("contains", "≤ 0.25"), ("nearest", "≤ 2")):
            taken = 1e3 * median(
                times_of(functools.partial(post, name, thousand, "json"), 7 * runs)
            )
            add(f"1,000 colours as JSON, `{name}`, ms", taken, "≤ 5")
            before = resident_bytes(pid=pid)
            Path(f"/proc/{pid}/clear_refs").write_text("5")  # the peak begins anew
            taken = median(times_of(functools.partial(post, name, million, "x-npy"), runs))
            growth = resident_bytes("VmHWM", pid) - before - len(million)
            add(f"memory of `{name}` beyond the body, bytes per row", growth / MILLION, "≤ 64")
            add(f"1,000,000 colours as .npy, `{name}`, s", taken, goal)
        single = message(f"{gamut}/contains", body=json.dumps({"colours": [[50, 20, 30]]}))
        rate = load(found.port, [single], 2000 * runs)["requests/s"]
        add("single colours as JSON, `contains`, requests/s", rate, "≥ 3,000")
    return rows


def levels(quick: bool) -> Rows:
    """Time to read levels of open histories of different sizes."""
    use_one_core()  # comes last: servers that start later would inherit it
    rows = []
    for samples in [10_000] if quick else [10_000, 100_000, 1_000_000]:
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


MEASUREMENTS: dict[str, Callable[[bool], Rows]] = {
    "machine": lambda _: [machine("scipy", "trimesh", "uvicorn")],
    "inputs": inputs,
    "meshes": meshes,
    "plain-fastapi": plain_fastapi,
    "queries-http": http_queries,
    "startup": startup,
    "viewer": viewer,
    "boundaries": boundaries,
    "queries": colour_queries,
    "level-queries": level_queries,
    "recipes": recipes,
    "recipes-continuity": continuity,
    "profiles": profiles,
    "links": links,
    "clips": clips,
    "levels": levels,
}
DEFAULT = ("machine", "inputs", "meshes", "plain-fastapi", "queries-http", "levels")

if __name__ == "__main__":
    main()
