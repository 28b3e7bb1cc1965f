"""Exactness, speed and continuity of recipes, beside Argyll's xicclu: ``make bench-recipes``.

The colours are those of random device values within the ink limit. ``xicclu -fif`` gets the colours
that ``xicclu -ff`` gives for the same device values, so all of them are in its gamut. It reads
profiles only, so ``colprof`` makes one of measurements. Times are processor times of one thread.
"""

from __future__ import annotations

import resource
import shutil
import subprocess
import tempfile
import time
from functools import cache
from pathlib import Path
from statistics import median
from typing import Any, NamedTuple

import numpy as np

from benchmarks.common import FOGRA39L, SHARED, FloatArray, Rows
from gamutcore import Gamut
from gamutcore.characterisation import Samples, read_characterisation
from gamutcore.questions import black_rule
from gamutcore.recipes import SHARE, BlackRule, InverseModel
from gamutcore.search import delta_e_2000

STEP, LINES = 0.5, 200
"""Distance of neighbouring colours in CIELAB, and the number of lines that they are on."""

IN_GAMUT = 0.1
"""Largest ΔE00 of a colour that counts for continuity: a line can leave the gamut."""

NEUTRAL = np.arange(94.0, 0.0, -STEP)
"""L* of the neutral axis. All devices have the lightest colour; the darkest is their own."""


class Device(NamedTuple):
    """A file, its total ink limit in per cent, and the options of colprof for measurements."""

    path: Path
    ink_limit: float | None = None
    colprof: tuple[str, ...] = ()


PRESS = ("-ql", "-bn")
"""Quality `l`, which takes 6 s instead of 17 for FOGRA39L; xicclu is faster with it."""

DEVICES = {
    "FOGRA39L, fit": Device(FOGRA39L, 300, PRESS),
    "TR002, fit": Device(SHARED / "press" / "TR002.ti3", 260, PRESS),
    "phone, fit": Device(SHARED / "display" / "phone_RGBW_LCD_602.txt", None, ("-ql", "-ax")),
    "ISOcoated v2 300, profile": Device(SHARED / "press" / "ISOcoated_v2_300_bas.icc", 300),
    "CMYKOGV, profile": Device(SHARED / "oracle" / "Ref-ECG-CMYKOGV_FOGRA55_TAC300.icc", 300),
    "Acer, profile of tables": Device(SHARED / "display" / "Acer_XB271HU.icc"),
    "Panasonic, profile of curves": Device(SHARED / "display" / "Panasonic-TV_2014.icc"),
}

RULES: dict[str, tuple[BlackRule, str]] = {
    "medium": (black_rule("medium"), "-kr"),
    "none": (BlackRule(SHARE, 0.0), "-kz"),
}
"""Rules of black, and the option of xicclu that is like it."""


@cache
def gamuts() -> dict[str, Gamut]:
    """Return the gamuts of the files that are there."""
    found = {}
    for name, device in DEVICES.items():
        if device.path.is_file():
            limit = {} if device.ink_limit is None else {"ink_limit": device.ink_limit}
            found[name] = Gamut(device.path, {"surface_samples": 20_000, **limit})
        else:
            print(f"{name} is left out: {device.path} is not there.", flush=True)
    return found


def printable(name: str, count: int) -> FloatArray:
    """Return random device values within the limit; of more than four inks, three and black."""
    random = np.random.default_rng(1)
    gamut, limit = gamuts()[name], DEVICES[name].ink_limit
    values = random.random((8 * count, len(gamut.device_model.channels)))
    black = gamut.inverse_model.black
    inks = [i for i in range(values.shape[1]) if i != black]
    if len(inks) > 3:
        unused = random.permuted(np.tile(inks, (len(values), 1)), axis=1)[:, 3:]
        np.put_along_axis(values, unused, 0.0, axis=1)
    printed: FloatArray = values[values.sum(axis=1) <= (limit or np.inf) / 100][:count]
    return printed


def recipes(quick: bool) -> Rows:
    """Residuals and times of recipes, and those of xicclu for the same device values."""
    rows = []
    for name, gamut in gamuts().items():
        device = printable(name, 2000 if quick else 20_000)
        has_black = gamut.inverse_model.black is not None
        with tempfile.TemporaryDirectory() as folder:
            profile = peer_profile(DEVICES[name], Path(folder))
            for black in ("medium", "none") if has_black else ("none",):
                row: dict[str, Any] = {"device": name, "black": black if has_black else None}
                row |= own_figures(gamut, device, black)
                if profile is not None:
                    row |= peer_figures(profile, device, black, DEVICES[name].ink_limit)
                    row["xicclu ÷ ours"] = row["xicclu, µs"] / row["µs per colour"]
                rows.append(row)
    return rows


def own_figures(gamut: Gamut, device: FloatArray, black: str) -> dict[str, Any]:
    """Preparation with the first recipe, residuals by the model, and the time of `to_device`."""
    rule, lab = RULES[black][0], gamut.device_model.lab(device)
    points = gamut.to_colour(device)
    gamut.to_device(points[:1000], black=black)  # compiles
    start = time.thread_time()
    inverse = InverseModel(gamut.device_model)
    inverse.recipes(lab[:1], rule)
    row: dict[str, Any] = {"preparation, s": time.thread_time() - start}
    row |= residuals(lab, inverse.recipes(lab, rule).lab)
    seconds = []
    for _ in range(3):
        start = time.thread_time()
        gamut.to_device(points, black=black)
        seconds.append(time.thread_time() - start)
    return row | {"µs per colour": 1e6 * median(seconds) / len(device)}


def residuals(wanted: FloatArray, found: FloatArray, title: str = "") -> dict[str, float]:
    """Return the median, the 99.9th percentile and the maximum of ΔE00."""
    errors = delta_e_2000(wanted, found)
    figures = {"median ΔE00": 50, "99.9 %": 99.9, "worst": 100}
    return {f"{title}{name}": float(np.percentile(errors, at)) for name, at in figures.items()}


def peer_profile(device: Device, folder: Path) -> Path | None:
    """Return a profile that xicclu reads, made by colprof if there are measurements."""
    if shutil.which("xicclu") is None or "CMYKOGV" in device.path.name:  # at most four inks
        return None
    if not device.colprof:
        return device.path
    path = folder / "device.ti3"
    path.write_text(argyll_text(device.path))
    subprocess.run(["colprof", *device.colprof, str(path.with_suffix(""))], check=True)
    return path.with_suffix(".icc")


def peer_figures(
    profile: Path, device: FloatArray, black: str, limit: float | None
) -> dict[str, float]:
    """Residuals by its own evaluator, and time per colour without its start."""
    options = ["-fif", RULES[black][1], *([] if limit is None else [f"-l{limit:g}"])]
    if device.shape[1] == 3:
        options = ["-fif"]
    targets, _ = xicclu(profile, ["-ff"], device, 3)
    few = len(device) // 10
    found, seconds = xicclu(profile, options, targets, device.shape[1])
    _, start = xicclu(profile, options, targets[:few], device.shape[1])
    made, _ = xicclu(profile, ["-ff"], found, 3)
    row = {"xicclu, µs": 1e6 * (seconds - start) / (len(device) - few)}
    return row | residuals(targets, made, "xicclu, ")


def xicclu(
    profile: Path, options: list[str], rows: FloatArray, columns: int
) -> tuple[FloatArray, float]:
    """Return what xicclu prints for rows, and its processor time in seconds."""
    text = "".join(" ".join(f"{value:.6f}" for value in row) + "\n" for row in rows)
    command = ["xicclu", "-v0", "-ir", "-pl", *options, str(profile)]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(command, input=text, capture_output=True, text=True, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    found = [line.split()[:columns] for line in done.stdout.splitlines() if line.strip()]
    return np.array(found, float), after.ru_utime - before.ru_utime


def continuity(quick: bool) -> Rows:
    """Change of inks in per cent between neighbours, along lines and the neutral axis."""
    rows = []
    for name, gamut in gamuts().items():
        ends = gamut.device_model.lab(printable(name, 2 * (20 if quick else LINES)))
        lines = []
        for one, two in ends.reshape(-1, 2, 3):
            along = np.arange(0.0, np.linalg.norm(two - one), STEP)
            lines.append(one + along[:, None] * (two - one) / np.linalg.norm(two - one))
        neutral = np.zeros((len(NEUTRAL), 3))
        neutral[:, 0] = NEUTRAL
        has_black = gamut.inverse_model.black is not None
        for black in RULES if has_black else ("none",):
            changes = changes_of_inks(gamut, lines, black)
            gray = changes_of_inks(gamut, [neutral], black)
            light = changes_of_inks(gamut, [neutral[NEUTRAL >= 20.0]], black)
            rows.append(
                {
                    "device": name,
                    "black": black if has_black else None,
                    "largest": float(changes.max()),
                    "neutral, L* 20 to 94": float(light.max()),
                    "neutral, to black": float(gray.max()),
                }
            )
    return rows


def changes_of_inks(gamut: Gamut, lines: list[FloatArray], black: str) -> FloatArray:
    """Return the largest change of an ink in per cent between neighbours that are in gamut."""
    targets = np.concatenate(lines)
    found = gamut.inverse_model.recipes(targets, RULES[black][0])
    usable = delta_e_2000(targets, found.lab) <= IN_GAMUT
    same = np.diff(np.repeat(np.arange(len(lines)), [len(line) for line in lines])) == 0
    changes = 100.0 * np.abs(np.diff(found.device, axis=0)).max(axis=1)
    counted: FloatArray = changes[same & usable[1:] & usable[:-1]]
    return counted


def argyll_text(path: Path) -> str:
    """Return measurements as colprof reads them: those of displays become of its form."""
    text = path.read_text(errors="replace")
    samples = read_characterisation(text.encode())
    if text.startswith("CTI3"):
        return text
    if not isinstance(samples, Samples) or samples.device is None or samples.xyz is None:
        raise TypeError(f"{path.name} has no device values with tristimulus values.")
    values = 100.0 * np.hstack([samples.device, samples.xyz / samples.xyz[:, 1].max()])
    rows = [" ".join(f"{value:.5f}" for value in (i, *row)) for i, row in enumerate(values)]
    return (
        'CTI3\nDEVICE_CLASS "DISPLAY"\nCOLOR_REP "RGB_XYZ"\n'
        "NUMBER_OF_FIELDS 7\nBEGIN_DATA_FORMAT\n"
        "SAMPLE_ID RGB_R RGB_G RGB_B XYZ_X XYZ_Y XYZ_Z\nEND_DATA_FORMAT\n"
        f"NUMBER_OF_SETS {len(rows)}\nBEGIN_DATA\n" + "\n".join(rows) + "\nEND_DATA\n"
    )
