"""Observe the compute package of a revision through its public face.

The file runs unchanged in both revisions, so it imports `gamutcore` and `gamutclient` alone.
``python -m benchmarks.same.probe INPUTS RESULTS AREA...``
"""

from __future__ import annotations

import importlib
import inspect
import json
import os
import re
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

import gamutcore
from benchmarks.same.observations import Observations

__all__ = ["AREAS", "main"]

Array = np.ndarray[Any, Any]

COLOURS = 10_000

QUERIED: dict[str, tuple[str, dict[str, object]]] = {
    "press": ("FOGRA39L.ti3", {"surface_samples": 20_000, "ink_limit": 300}),
    "display": ("sRGB-v4.icc", {"surface_samples": 20_000}),
    "7 inks": ("7inks.txt", {"surface_samples": 8000}),
    "picture": ("rgb.png", {}),
    "colours in Oklab": ("lch.csv", {"space": "Oklab"}),
}

FORMATS = ("glb", "gltf", "ply", "stl", "obj", "3mf", "gam", "icc", "cge", "fbx")

PICTURES = ("rgb.png", "rgba.png", "rgb16.tif", "rgb.jpg", "palette.png")


def main() -> None:
    """Observe the areas that the command line names."""
    if not Path(gamutcore.__file__).is_relative_to(os.environ["SAME_TREE"]):
        raise RuntimeError(f"gamutcore is that of {gamutcore.__file__}.")
    inputs, results = Path(sys.argv[1]), Path(sys.argv[2])
    for area in sys.argv[3:]:
        observations = Observations(results, area)
        AREAS[area](inputs, observations)
        observations.save()


def observe_histories(inputs: Path, found: Observations) -> None:
    """Build every case: description, bytes of the history, levels and device values."""

    def build(name: str, file: str, options: dict[str, Any]) -> str:
        gamut = gamutcore.Gamut(inputs / "files" / file, options)
        data = gamut.to_bytes()
        found.record(f"{name}: bytes", data)
        found.record(f"{name}: description", gamut.description)
        same = gamutcore.Gamut.from_bytes(data)
        for triangles in (4, 100, gamut.history.triangles):
            mesh = same.level(min(triangles, gamut.history.triangles))
            for part in ("vertices", "faces"):
                found.record(f"{name}: {part} of {triangles}", getattr(mesh, part))
            if mesh.device is not None:
                found.record(f"{name}: device of {triangles}", mesh.device)
        return repr(gamut)

    for name, (file, options) in json.loads((inputs / "cases.json").read_text()).items():
        found.attempt(f"{name}: text", build, name, file, options)
    for name in ("sRGB", "Display P3", "no such reference"):
        found.attempt(f"reference {name}", lambda n: gamutcore.reference(n).description, name)


def _queried(inputs: Path) -> Iterator[tuple[str, Any, Array, float]]:
    """Yield gamuts with colours, some of them outside, and the lightness of white."""
    for name, (file, options) in QUERIED.items():
        gamut = gamutcore.Gamut(inputs / "files" / file, options)
        vertices = gamut.level(gamut.history.triangles).vertices.astype(np.float64)
        low, high = vertices.min(axis=0), vertices.max(axis=0)
        noise = np.random.default_rng(7).random((COLOURS, 3))
        colours = low - 0.2 * (high - low) + 1.4 * noise * (high - low)
        surface = vertices[:100]
        colours[: len(surface)] = surface
        yield name, gamut, colours, float(high[0])


def observe_queries(inputs: Path, found: Observations) -> None:
    """Ask everything of some gamuts, at several levels."""
    display = gamutcore.Gamut(inputs / "files" / "sRGB-v4.icc", {"surface_samples": 5000})
    for name, gamut, colours, white in _queried(inputs):
        other = gamut if "Oklab" in name else display
        levels: dict[str, dict[str, Any]] = {
            "default": {},
            "1000 triangles": {"triangles": min(1000, gamut.history.triangles)},
            "full": {"max_error": 0},
            "limit": {"max_error": white / 200},
        }
        for title, level in levels.items():
            for method, args, named in _questions(colours, white, other):
                words = [f"{v:.4g}" if isinstance(v, float) else v for v in args if np.ndim(v) == 0]
                shown = " ".join(map(str, [*words, *named.values()])).replace(repr(other), "")
                question = f"{name}, {title}: {method} {shown}"
                found.attempt(question, getattr(gamut, method), *args, **named, **level)
        found.attempt(f"{name}: convert", gamut.convert, colours, "CIELAB")
        found.attempt(f"{name}: coverage", gamut.coverage_of, other)
        found.attempt(f"{name}: and", lambda a, b: a & b, gamut, other)
        found.attempt(f"{name}: bad", gamut.contains, [(0, 0, np.nan)])


def _questions(
    colours: Array,
    white: float,
    other: object,
) -> Iterator[tuple[str, tuple[Any, ...], dict[str, Any]]]:
    """Yield the methods of a gamut with their arguments."""
    hue = 360 * np.random.default_rng(8).random(COLOURS)
    yield "contains", (colours,), {}
    yield "contains", (colours,), {"space": "LCHab"}
    yield "contains", (colours / white,), {"space": "sRGB"}
    yield "distance", (colours,), {}
    yield "classify", (colours,), {"tolerance": white / 50}
    for metric in ("CIE 1976", "CIE 2000", "CIE 1994"):
        yield "nearest", (colours,), {"metric": metric}
    for kind in ("segment", "ray", "line", "arc"):
        yield "crossings", (colours, colours[::-1]), {"kind": kind}
    for how in ("nearest", "hue", "lightness", "chroma", "focal", "up"):
        yield "map", (colours, f"clip-{how}"), {}
    for focus in ("cusp", (white / 2, 0.0, 0.0)):
        yield "map", (colours, "clip-focal"), {"focus": focus}
    yield "map", (colours, "sgck"), {"source": other}
    yield "cusps", (), {}
    yield "cusps", (hue[:500],), {}
    yield "leaf", (40,), {}
    yield "leaves", (90, 111), {}
    yield "max_chroma", (white * hue / 360, hue[::-1]), {}
    for plane in ({"L": white / 2}, {"hue": 200}, {"plane": (1, 0.5, -1, white / 2)}):
        yield "slice", (), plane
    yield "rings", (), {}
    yield "rings", (other,), {"sectors": 36}
    yield "compare", (other,), {}


def observe_exports(inputs: Path, found: Observations) -> None:
    """Write levels in every format, pictures, sections and pages; map pictures."""

    def write(gamut: Any, suffix: str, **level: Any) -> bytes:  # noqa: ANN401
        written: bytes = gamut.mesh(**level).to_bytes(suffix)
        return written

    def mapped(gamut: Any, file: str) -> bytes:  # noqa: ANN401
        output = found.folder / f"mapped-{file}"
        found.record(f"mapped {file}", gamut.map_picture(inputs / "files" / file, output))
        # the writer of TIFF adds the time
        return re.sub(rb"20\d\d(:\d\d){2} \d\d(:\d\d){2}", b"TIME", output.read_bytes())

    for name, gamut, _, white in _queried(inputs):
        levels: tuple[dict[str, float], ...] = ({"triangles": 100}, {"max_error": white / 50})
        for level in levels:
            for suffix in FORMATS:
                found.attempt(f"{name} {[*level]} {suffix}", write, gamut, suffix, **level)
            for side in ("inside", "outside", "left"):
                found.attempt(f"{name} {[*level]} {side}", write, gamut, "ply", side=side, **level)
        found.attempt(f"{name} by mismatch", write, gamut, "stl", max_mismatch=0.01)
        found.attempt(f"{name} too coarse", write, gamut, "stl", triangles=3)
        found.attempt(f"{name} page", gamut.to_html, name)
        for size, view, background in ((200, "standard", "white"), (64, "top", "transparent")):
            found.attempt(f"{name} {view}", gamut.picture, size, view, background=background)
        found.attempt(f"{name} tiny picture", gamut.picture, 3)
        found.attempt(f"{name} in a notebook", gamut._repr_html_)
        for file in PICTURES if name == "press" else ():
            found.attempt(f"mapped {file}: bytes", mapped, gamut, file)


def observe_errors(inputs: Path, found: Observations) -> None:
    """Read damaged files and histories, and wrong options."""

    def build(file: Path, **options: object) -> object:
        return gamutcore.Gamut(file, options).description

    def unpack(data: bytes) -> object:
        gamut = gamutcore.Gamut.from_bytes(data)
        return gamut.level(gamut.history.triangles).vertices

    for path in sorted((inputs / "damaged").iterdir()):
        has_surface = not path.name[2:].startswith(("mesh", "lab", "lch"))
        options = {"surface_samples": 500} if has_surface else {}
        found.attempt(path.name, build, path, **options)
    for wrong in json.loads((inputs / "wrong.json").read_text()):
        for file, samples in (("cmyk.txt", 500), ("rgb.png", 0), ("mesh.ply", 0), ("six.icc", 500)):
            options = {**({"surface_samples": samples} if samples else {}), **wrong}
            name = f"{file} {json.dumps(wrong)}"
            found.attempt(name, build, inputs / "files" / file, **options)
    data = gamutcore.Gamut(inputs / "files" / "lch.csv").to_bytes()
    for place in range(0, len(data), len(data) // 40):
        found.attempt(f"history ends at {place}", unpack, data[:place])
        flipped = data[:place] + bytes([data[place] ^ 0x55]) + data[place + 1 :]
        found.attempt(f"history differs at {place}", unpack, flipped)


def observe_names(_inputs: Path, found: Observations) -> None:
    """List public names, signatures and members of the packages and of their errors."""
    sys.path.append(os.environ["SAME_PACKAGES"])  # last: httpx, if it is not installed
    for package in ("gamutcore", "gamutcore.errors", "gamutclient"):
        module = importlib.import_module(package)
        found.record(package, sorted(module.__all__))
        for name in module.__all__:
            value = getattr(module, name)
            found.record(f"{package}.{name}", _signature(value))
            if isinstance(value, type):
                if issubclass(value, Exception):
                    bases = [each.__name__ for each in value.__mro__]
                    found.record(f"{package}.{name} bases", bases)
                for member in sorted(each for each in dir(value) if not each.startswith("_")):
                    static = inspect.getattr_static(value, member)
                    found.record(f"{package}.{name}.{member}", _signature(static))
    found.record("options", str(gamutcore.Options()))


def _signature(value: Any) -> str:  # noqa: ANN401
    """Return the signature of a function or the kind of another value; modules are left out."""
    for inner in ("__func__", "fget", "func"):  # of class methods, properties, cached properties
        value = getattr(value, inner, None) or value
    try:
        text = re.sub(r" at 0x[0-9a-f]+", "", str(inspect.signature(value)))
        return re.sub(r"\b(?:[a-z_]+\.)+(?=[A-Z])", "", text)
    except (TypeError, ValueError):
        is_plain = isinstance(value, str | int | float | tuple)
        return repr(value) if is_plain else type(value).__name__


AREAS: dict[str, Callable[[Path, Observations], None]] = {
    "histories": observe_histories,
    "queries": observe_queries,
    "exports": observe_exports,
    "errors": observe_errors,
    "names": observe_names,
}
"""What is observed, by name."""

if __name__ == "__main__":
    main()
