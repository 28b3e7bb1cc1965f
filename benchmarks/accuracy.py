"""Measure volumes and coverage of ten devices beside other programs, for docs/accuracy.md.

``python -m benchmarks.accuracy`` writes ``benchmarks/accuracy.json`` and the tables. ``--only
NAME ...`` repeats some devices. A device whose file is missing keeps its figures, and a program
that is missing prints none. The document says how to install the programs.
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import tempfile
from dataclasses import dataclass
from functools import cache, cached_property, partial
from pathlib import Path
from typing import Any

import colour
import numpy as np

import gamutcore
from benchmarks.common import FOGRA39L, ROOT, SHARED, FloatArray, Rows, machine
from benchmarks.dense import D50, Solid, display_model, ink_model
from benchmarks.lcms import descriptor_volume, relative_lab
from benchmarks.markdown import rows_table, store

RESULTS = Path(__file__).with_name("accuracy.json")
DOCUMENT = ROOT / "docs" / "accuracy.md"
ARGYLL = Path("/usr/share/color/argyll/ref")
"""Profiles of Debian's package ``argyll``."""

HULL_POINTS = 20_000
"""Points of the dense surface that the hull programs are given, about."""

MONTE_CARLO_SAMPLES = 1_000_000

HULLS = ("scipy", "trimesh", "manifold3d hull", "pymeshlab", "lcms2")
SOLIDS = ("Argyll", "Argyll, absolute", "iccDEV", "cielab-gamut-tools", "manifold3d")
COVERAGES = ("Argyll", "cielab-gamut-tools", "manifold3d")
"""Programs of the tables: hulls of points, solids, and coverage of sRGB."""

PHOTO_MARK = "https://www.photo-mark.com/notes/calculating-color-space-volumes/"
LINDBLOOM = "http://www.brucelindbloom.com/WorkingSpaceInfo.html"
GAMUT_VOLUME = "https://github.com/CIELab-gamut-tools/gamut-volume-m"
PUBLISHED = (
    ("sRGB", f"[Lindbloom]({LINDBLOOM})", 832_870, "sampling, not stated"),
    ("Adobe RGB", f"[Lindbloom]({LINDBLOOM})", 1_208_631, "sampling, not stated"),
    ("ProPhoto RGB", f"[Lindbloom]({LINDBLOOM})", 2_879_568, "sampling, not stated"),
    ("sRGB", f"[gamut-volume-m, IDMS method]({GAMUT_VOLUME})", 830_732, "602 colours"),
    ("Adobe RGB", f"[ColorThink Pro, cited by Meyer]({PHOTO_MARK})", 1_306_820, "not published"),
)
"""Device, source, volume and reason of the difference, all in CIELAB D50."""


@dataclass(frozen=True)
class Device:
    """A device or space that anyone can get."""

    name: str
    path: Path

    colour_space: str = ""
    """Name in colour-science, for spaces."""

    @property
    def is_profile(self) -> bool:
        """Whether an ICC profile describes the device; else measurements."""
        return self.path.suffix in {".icc", ".icm"}

    @cached_property
    def solid(self) -> Solid:
        """The independent solid."""
        if self.is_profile:
            return Solid(partial(relative_lab, self.path), channels(self.path))
        if self.path.suffix == ".ti3":
            return Solid(ink_model(self.path), 4)
        return Solid(display_model(self.path), 3)


DEVICES = (
    Device("sRGB", ARGYLL / "sRGB.icm", "sRGB"),
    Device("Display P3", ARGYLL / "DisplayP3.icm", "Display P3"),
    Device("BT.2020", ARGYLL / "Rec2020.icm", "ITU-R BT.2020"),
    Device("Adobe RGB", ARGYLL / "ClayRGB1998.icm", "Adobe RGB (1998)"),
    Device("ProPhoto RGB", ARGYLL / "ProPhoto.icm", "ProPhoto RGB"),
    Device("Acer XB271HU", SHARED / "display/Acer_XB271HU.icc"),
    Device("phone, RGBW", SHARED / "display/phone_RGBW_LCD_602.txt"),
    Device("ISO Coated v2 300", SHARED / "press/ISOcoated_v2_300_bas.icc"),
    Device("FOGRA39L", FOGRA39L),
    Device("TR 002", SHARED / "press/TR002.ti3"),
)
SRGB = DEVICES[0]

PACKAGES = ("colour-science", "scipy", "iccdev", "cielab-gamut-tools", "manifold3d", "pymeshlab")
"""Packages whose versions the document states."""


def main() -> None:
    """Measure, and write the figures and the document."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.accuracy", description=__doc__)
    names = [device.name for device in DEVICES]
    parser.add_argument("--only", nargs="+", choices=names, default=names, metavar="NAME")
    asked = parser.parse_args().only
    results = json.loads(RESULTS.read_text()) if RESULTS.exists() else {}
    rows = {row["device"]: row for row in results.get("devices", [])}
    for device in DEVICES:
        if device.name in asked and device.path.exists():
            rows[device.name] = device_row(device)
            results = {
                "machine": [{**machine(*PACKAGES), "argyll": argyll_version()}],
                "devices": [rows[name] for name in names if name in rows],
            }
            store(results, RESULTS, DOCUMENT, document_blocks(results))


def device_row(device: Device) -> dict[str, Any]:
    """Return the figures of a device; coverage is that of sRGB, in per cent."""
    gamut = gamutcore.Gamut(device.path)
    volumes: dict[str, float] = {}
    coverages: dict[str, float] = {}
    for program in (argyll, iccdev, cielab_gamut_tools, manifold, colour_science, hulls):
        found, covered = program(device)
        volumes |= found
        coverages |= covered
    return {
        "device": device.name,
        "input": device.path.name,
        "ours": gamut.volume,
        "dense": device.solid.volume,
        "covers": 100 * gamut.coverage_of(own_srgb()),
        "dense covers": 100 * device.solid.coverage_of(SRGB.solid),
        "volumes": volumes,
        "coverages": coverages,
    }


Printed = tuple[dict[str, float], dict[str, float]]
"""Volumes and coverage of sRGB in per cent, by program."""

NOTHING: Printed = ({}, {})


@cache
def own_srgb() -> gamutcore.Gamut:
    """Return our gamut of the profile of sRGB."""
    return gamutcore.Gamut(SRGB.path)


def channels(path: Path) -> int:
    """Return the channels of a profile of RGB or CMYK, from its header."""
    return {b"RGB ": 3, b"CMYK": 4}[path.read_bytes()[16:20]]


def argyll(device: Device) -> Printed:
    """Return what iccgamut and viewgam print, relative and absolute, without an ink limit.

    Measurements of a press become a profile by colprof.
    """
    if not device.is_profile and device.path.suffix != ".ti3":
        return NOTHING
    volumes = {}
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "srgb.icc").write_bytes(SRGB.path.read_bytes())
        Path(folder, f"device{device.path.suffix}").write_bytes(device.path.read_bytes())
        if device.is_profile:
            Path(folder, f"device{device.path.suffix}").rename(Path(folder, "device.icc"))
        else:
            run("colprof", "-qm", "-bn", "device", folder=folder)
        limit = ["-l400"] if device.solid.channels == 4 else []
        # the last pair is intersected
        for name, intent in (("Argyll, absolute", "-ia"), ("Argyll", "-ir")):
            text = run("iccgamut", "-v", "-ff", intent, *limit, "device.icc", folder=folder)
            printed = re.search(r"volume of gamut is ([\d.]+)", text)
            if printed:
                volumes[name] = float(printed[1])
        run("iccgamut", "-ff", "-ir", "srgb.icc", folder=folder)
        text = run("viewgam", "-i", "device.gam", "srgb.gam", "both", folder=folder)
    covered = re.search(r"'srgb.gam' volume = .* intersect = ([\d.]+)%", text)
    return volumes, {"Argyll": float(covered[1])} if covered else {}


def run(*command: str, folder: str) -> str:
    """Return what a program prints."""
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True)
    return done.stdout


def argyll_version() -> str:
    """Return the version that Argyll's programs print."""
    text = subprocess.run(["iccgamut"], capture_output=True, text=True, check=False).stderr
    printed = re.search(r"Version ([\d.]+)", text)
    return printed[1] if printed else "–"


def iccdev(device: Device) -> Printed:
    """Return the dense integral of colours that iccDEV computes; it has no volume of its own."""
    if not device.is_profile:
        return NOTHING
    from iccdev import ColorSpace, IccCmm, Intent

    cmm = IccCmm(dst_space=ColorSpace.Lab)
    cmm.attach(str(device.path), intent=Intent.RelativeColorimetric)
    cmm.begin()

    def model(values: FloatArray) -> FloatArray:
        encoded = np.asarray(cmm.apply_ndarray(values.astype(np.float32)), np.float64)
        return encoded * (100.0, 255.0, 255.0) - (0.0, 128.0, 128.0)

    return {"iccDEV": Solid(model, device.solid.channels).volume}, {}


def cielab_gamut_tools(device: Device) -> Printed:
    """Return the volume and coverage by rings of 602 colours."""
    if device.solid.channels != 3:
        return NOTHING
    from cielab_gamut_tools import Gamut, make_rgb_signals

    def gamut(source: Device) -> Any:  # noqa: ANN401  # untyped
        if not source.is_profile:
            return Gamut.from_cgats(source.path)
        signals = make_rgb_signals()
        xy = colour.XYZ_to_xy(D50)
        xyz = colour.Lab_to_XYZ(source.solid.model(signals / 255), xy)
        return Gamut.from_xyz(signals, xyz)

    theirs, srgb = gamut(device), gamut(SRGB)
    covered = theirs.intersect(srgb).volume() / srgb.volume()
    name = "cielab-gamut-tools"
    return {name: float(theirs.volume())}, {name: 100 * float(covered)}


def manifold(device: Device) -> Printed:
    """Return the volume and coverage of the mesh of the cube's faces."""
    if device.solid.channels != 3:
        return NOTHING
    from manifold3d import Manifold, Mesh64

    def body(solid: Solid) -> Any:  # noqa: ANN401  # untyped
        corners = solid.triangles.reshape(-1, 3).round(6)
        vertices, numbers = np.unique(corners, axis=0, return_inverse=True)
        mesh = numbers.reshape(-1, 3).astype(np.uint64)
        whole = Manifold(Mesh64(vertices, mesh))
        return whole if whole.volume() > 0 else Manifold(Mesh64(vertices, mesh[:, ::-1].copy()))

    theirs, srgb = body(device.solid), body(SRGB.solid)
    if not theirs.volume():
        return NOTHING
    covered = (theirs ^ srgb).volume() / srgb.volume()
    return {"manifold3d": theirs.volume()}, {"manifold3d": 100 * covered}


def colour_science(device: Device) -> Printed:
    """Return the Monte Carlo volume of a space with the function's defaults."""
    if not device.colour_space:
        return NOTHING
    space = colour.RGB_COLOURSPACES[device.colour_space]
    state = np.random.RandomState(1)
    volume = colour.RGB_colourspace_volume_MonteCarlo(
        space, MONTE_CARLO_SAMPLES, random_state=state
    )
    return {"colour-science": float(volume)}, {}


def hulls(device: Device) -> Printed:
    """Return volumes of convex hulls, and of lcms2's descriptor."""
    import pymeshlab
    import trimesh
    from manifold3d import Manifold
    from scipy.spatial import ConvexHull

    points = device.solid.points
    points = np.ascontiguousarray(points[:: max(1, len(points) // HULL_POINTS)])
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(points))
    meshes.generate_convex_hull()
    return {
        "scipy": float(ConvexHull(points).volume),
        "trimesh": float(trimesh.PointCloud(points).convex_hull.volume),
        "manifold3d hull": Manifold.hull_points(points).volume(),
        "pymeshlab": float(meshes.get_geometric_measures()["mesh_volume"]),
        "lcms2": descriptor_volume(points),
    }, {}


def document_blocks(results: dict[str, Any]) -> dict[str, str]:
    """Return the generated blocks of docs/accuracy.md."""
    devices = results["devices"]
    dense = {row["device"]: row["dense"] for row in devices}

    def beside(volume: float | None, exact: float) -> str:
        return "–" if volume is None else f"{volume:,.0f} ({100 * (volume / exact - 1):+.2f})"

    def volumes(names: tuple[str, ...]) -> Rows:
        return [
            {
                "device": row["device"],
                **{name: beside(row["volumes"].get(name), row["dense"]) for name in names},
            }
            for row in devices
        ]

    ours = [
        {
            "device": row["device"],
            "input": f"`{row['input']}`",
            "our volume": f"{row['ours']:,.0f}",
            "dense integral": f"{row['dense']:,.0f}",
            "difference, %": f"{100 * (row['ours'] / row['dense'] - 1):+.2f}",
            "covers sRGB, ours, %": f"{row['covers']:.2f}",
            "dense, %": f"{row['dense covers']:.2f}",
        }
        for row in devices
    ]
    coverages = [
        {
            "device": row["device"],
            "ours": f"{row['covers']:.2f}",
            "dense": f"{row['dense covers']:.2f}",
            **{
                name: f"{row['coverages'][name]:.2f}" if name in row["coverages"] else None
                for name in COVERAGES
            },
        }
        for row in devices
    ]
    published = [
        {
            "device": name,
            "as published by": source,
            "volume (difference, %)": beside(volume, dense[name]),
            "reason": reason,
        }
        for name, source, volume, reason in PUBLISHED
        if name in dense
    ]
    tables = {
        "machine": [_machine(results["machine"][0])],
        "ours": ours,
        "solids": volumes(SOLIDS),
        "hulls": volumes(HULLS),
        "spaces": [row for row in volumes(("colour-science",)) if row["colour-science"] != "–"],
        "coverage": coverages,
        "published": published,
    }
    return {name: rows_table(rows) for name, rows in tables.items()}


def _machine(facts: dict[str, Any]) -> dict[str, Any]:
    """Return the machine as a row, with the versions of programs in one cell."""
    columns = ("date", "cpu", "system")
    versions = [f"{name} {text}" for name, text in facts.items() if name not in (*columns, "cores")]
    return {**{name: facts[name] for name in columns}, "versions": ", ".join(versions)}


if __name__ == "__main__":
    main()
