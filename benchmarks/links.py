"""Links and clipping beside Argyll's collink and lcms' transicc: ``make bench-links``.

Links between profiles are judged by colours that both gamuts contain, which should not move. Every
link becomes a file, which `transicc` applies.

Clipping is judged by 3,000 random colours of sRGB and by the edges of its cube. All programs map
media-relative colours without black-point compensation, so that they have the same goal. The
profile of the destination says what colours device values have. ``collink -G`` inverts this
profile, and `transicc` takes the maker's table. `collink` of Argyll 2.3.1 crashes with profiles of
version 4 and refuses seven inks; it is left out there.
"""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from colour.difference.delta_e import intermediate_attributes_CIE2000

from benchmarks.common import SHARED, FloatArray, Rows
from benchmarks.recipes import PRESS as COLPROF_PRESS
from benchmarks.recipes import Device, argyll_text
from gamutcore import Gamut, link
from gamutcore.questions import PICTURE_SPACE
from gamutcore.search import delta_e_2000

ARGYLL = Path("/usr/share/color/argyll/ref")
"""Profiles of RGB spaces, version 2, in the Debian package argyll."""

SRGB = ARGYLL / "sRGB.icm"

ISO_COATED = SHARED / "press" / "ISOcoated_v2_300_bas.icc"

LINKS = {
    "sRGB to itself": (SRGB, SRGB),
    "sRGB to Display P3": (SRGB, ARGYLL / "DisplayP3.icm"),
    "BT.2020 to Display P3": (ARGYLL / "Rec2020.icm", ARGYLL / "DisplayP3.icm"),
    "ISO Coated v2 to itself": (ISO_COATED, ISO_COATED),
}

DESTINATIONS = {
    "ISO Coated v2 300": Device(ISO_COATED),
    "TR002": Device(SHARED / "press" / "TR002.ti3", None, COLPROF_PRESS),
    "CMYKOGV": Device(SHARED / "oracle" / "Ref-ECG-CMYKOGV_FOGRA55_TAC300.icc"),
    "Acer": Device(SHARED / "display" / "Acer_XB271HU.icc"),
    "Canon projector": Device(SHARED / "display" / "Canon_projector.icc"),
}
"""Profiles, and measurements with the options of colprof, which makes a profile of them."""

CLIPS = ("clip-hue", "clip-nearest")

COLOURS = 3000


def links(quick: bool) -> Rows:
    """ΔE00 of colours that both devices of a link have."""
    rows: Rows = []
    count = COLOURS // 10 if quick else COLOURS
    for name, (source, destination) in LINKS.items():
        if not (source.is_file() and destination.is_file()):
            print(f"{name} is left out: its profiles are not there.", flush=True)
            continue
        channels = 4 if source == ISO_COATED else 3
        device = np.random.default_rng(46).random((8 * count, channels))
        grey = np.repeat(np.linspace(0, 1, 33)[:, None], channels, axis=1)
        grey = grey if channels == 3 else grey * (0, 0, 0, 1)
        lab, greys = (_colours(source, each) for each in (device, grey))
        gamut = Gamut(destination, surface_samples=20_000)
        keep = gamut.contains(lab) & (device.sum(axis=1) <= 3.0 if channels == 4 else True)
        device, lab = device[keep][:count], lab[keep][:count]
        there = gamut.contains(greys)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "link.icc"
            link(source, destination, surface_samples=20_000).save(path)
            options = {"gamut link": [f"-l{path}"]}
            # the medium quality takes more than five minutes for four inks
            peer = _collink(source, destination, Path(folder), quick or channels == 4)
            if peer is not None:
                options["collink -G"] = [f"-l{peer}"]
            options["transicc"] = [f"-i{source}", f"-o{destination}"]
            for program, each in options.items():
                error = delta_e_2000(lab, _colours(destination, _values(each, device)))
                row: dict[str, Any] = {"link": name, "program": program}
                row |= {"mean": error.mean(), "95 %": np.percentile(error, 95)}
                row |= {"worst": error.max()}
                error = delta_e_2000(greys, _colours(destination, _values(each, grey)))[there]
                rows.append(row | {"greys, worst": error.max()})
    return rows


def clips(quick: bool) -> Rows:
    """ΔE00 and change of hue of colours of sRGB, clipped into devices."""
    rows: Rows = []
    rgb = _srgb(COLOURS // 10 if quick else COLOURS)
    for name, device in DESTINATIONS.items():
        if not (device.path.is_file() and SRGB.is_file()):
            print(f"{name} is left out: its data is not there.", flush=True)
            continue
        lab = _colours(SRGB, rgb)
        with tempfile.TemporaryDirectory() as folder:
            profile = device.path
            if device.colprof:
                text = Path(folder) / "device.ti3"
                text.write_text(argyll_text(device.path))
                subprocess.run(["colprof", *device.colprof, str(text.with_suffix(""))], check=True)
                profile = text.with_suffix(".icc")
            found: dict[str, FloatArray] = {}
            gamut = Gamut(profile, space=PICTURE_SPACE, surface_samples=20_000)
            for method in CLIPS:
                mapped = gamut.map(lab, method, space="CIELAB", max_error=0)
                found[method] = mapped.points
            peer = _collink(SRGB, profile, Path(folder), quick)
            if peer is not None:
                found["collink -G"] = _colours(profile, _values([f"-l{peer}"], rgb))
            made = _values([f"-i{SRGB}", f"-o{profile}"], rgb)
            found["transicc, maker's table"] = _colours(profile, made)
        rows += [
            {"destination": name, "clipping": clipping} | _figures(lab, points, len(rgb) - EDGES)
            for clipping, points in found.items()
        ]
    return rows


def _srgb(count: int) -> FloatArray:
    """Return random values, then `EDGES` values on the edges of the cube, blue last."""
    steps, rows = np.linspace(0.0, 1.0, 33)[:-1], []
    for axis, ends in product(range(3), product((0.0, 1.0), repeat=2)):
        edge = np.insert(np.broadcast_to(ends, (len(steps), 2)), axis, steps, axis=1)
        rows.append(edge)
    random = np.random.default_rng(46).random((count, 3))
    return np.concatenate([random, *rows, [(0.0, 0.0, 1.0)]])


EDGES = 12 * 32 + 1


def _figures(lab: FloatArray, points: FloatArray, count: int) -> dict[str, float]:
    """Return the figures of clipped colours; those from `count` on are of the edges."""
    error = delta_e_2000(lab, points)
    parts = intermediate_attributes_CIE2000(lab, points)
    change = np.abs(np.asarray(parts.delta_H_p) / np.asarray(parts.S_H))
    return {
        "mean": float(error[:count].mean()),
        "95 %": float(np.percentile(error[:count], 95)),
        "worst": float(error[:count].max()),
        "edges, worst": float(error[count:].max()),
        "ΔH, 95 %": float(np.percentile(change, 95)),
        "turn of sRGB's blue, °": float(_turn(lab, points)[-1]),
    }


def _turn(one: FloatArray, two: FloatArray) -> FloatArray:
    """Return the angles between hues in degrees."""
    angles = [np.arctan2(each[:, 2], each[:, 1]) for each in (one, two)]
    return np.abs(np.degrees(np.angle(np.exp(1j * (angles[1] - angles[0])))))


def _collink(source: Path, destination: Path, folder: Path, quick: bool) -> Path | None:
    """Return a link by the inverse of the destination's A2B table; None if collink makes none."""
    path = folder / "peer.icc"
    if shutil.which("collink") is None:
        return None
    size = ["-r9"] if quick else ["-qm"]
    command = ["collink", "-G", "-ir", *size, str(source), str(destination), str(path)]
    done = subprocess.run(command, check=False, capture_output=True)
    return path if done.returncode == 0 else None


def _colours(profile: Path, device: FloatArray) -> FloatArray:
    """Return the media-relative CIELAB colours of device values."""
    return _transicc([f"-i{profile}", "-o*Lab4"], device)


def _values(options: list[str], rows: FloatArray) -> FloatArray:
    """Return the device values that a link or two profiles give."""
    found = _transicc(options, rows)
    return found / _unit(options, found)


def _unit(options: list[str], values: FloatArray) -> float:
    """Return the device value 1 of transicc: 1 if a link names its channels, 255 of RGB, or 100."""
    if options[0].startswith("-l") and b"clrt" in Path(options[0][2:]).read_bytes()[:512]:
        return 1.0
    return 100.0 if values.shape[1] > 3 else 255.0


def _transicc(options: list[str], rows: FloatArray) -> FloatArray:
    """Return what transicc prints for device values, by the relative intent."""
    unit = _unit(options, rows)
    text = "".join(" ".join(f"{unit * value:.6f}" for value in row) + "\n" for row in rows)
    command = ["transicc", "-n", "-t1", "-c0", *options]
    done = subprocess.run(command, input=text, capture_output=True, text=True, check=True)
    return np.array([line.split() for line in done.stdout.splitlines() if line.strip()], float)
