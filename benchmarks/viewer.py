"""Measure the viewer in Chromium (``make bench-viewer``), and take its pictures for the documents.

Starts the service, builds examples, and drives the viewer without a graphics processor: with
``web/viewer/tests/measure.mjs``, or with ``web/viewer/pictures.mjs`` for the pictures
(``make viewer-pictures``). They go to ``docs/pictures/viewer``; ``slider.webp`` moves.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import tempfile
from pathlib import Path

from PIL import Image

from benchmarks.common import ROOT, Rows
from benchmarks.http import server

GOALS = {
    "bundle_kilobytes": ("page, script, worker and style with brotli, kB", "≤ 180"),
    "first_picture_seconds": ("first picture of a stored gamut, s after opening the page", "≤ 1"),
    "first_picture_triangles": ("triangles of the first picture", "–"),
    "first_picture_kilobytes": ("bytes of the history that were read for it, kB", "≤ 24.6"),
    "whole_triangles": ("triangles of the full boundary", "–"),
    "whole_seconds": ("last byte of the history to the picture of the full boundary, s", "≤ 2"),
    "level_milliseconds": ("from one level of about 10,000 triangles to another, ms", "≤ 16.7"),
    "pictures_per_second": ("pictures per second while dragging below 10,000 triangles", "≥ 60"),
    "levels_per_second": ("new levels per second meanwhile", "≥ 60"),
    "slowest_picture_ms": ("time between two pictures, 95th percentile, ms", "–"),
    "script_milliseconds": ("of which the script of the page, ms per picture", "≤ 4"),
    "undrawn_pictures_per_second": ("pictures per second with nothing drawn", "≥ 60"),
    "cleared_pictures_per_second": ("pictures per second of an empty view", "–"),
}
"""What the script measures: title and goal."""

TARGET = ROOT / "docs" / "pictures" / "viewer"
WIDTH = 720
FRAME_MILLISECONDS, HELD_MILLISECONDS = 110, 1500


def viewer(_quick: bool) -> Rows:
    """Measure the viewer with FOGRA39L."""
    with server(pin=False) as running:
        gamut = running.build()["id"]
        measured = json.loads(drive("tests/measure.mjs", running.port, GAMUT=gamut))
    return [
        {"figure": title, "measured": measured[name], "goal": goal}
        for name, (title, goal) in GOALS.items()
    ]


def drive(script: str, port: int, **variables: str) -> str:
    """Run a script of the viewer with a browser, and return what it prints."""
    chromium = next(filter(None, map(shutil.which, ("chromium", "google-chrome"))))
    environment = {"VIEWER_URL": f"http://127.0.0.1:{port}", "CHROMIUM": chromium, **variables}
    return subprocess.run(
        ["node", str(ROOT / "web" / "viewer" / script)],
        env={**os.environ, **environment},
        check=True,
        stdout=subprocess.PIPE,
        text=True,
    ).stdout


def take_pictures() -> None:
    """Take all pictures."""
    TARGET.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder, server(pin=False) as running:
        press, other = (
            running.build((ROOT / "examples" / name).read_bytes())["id"]
            for name in ("FOGRA39L.ti3", "FOGRA29L.ti3")
        )
        drive("pictures.mjs", running.port, FOLDER=folder, PRESS=press, OTHER=other)
        frames = sorted(Path(folder).glob("slider-*.png"))
        for path in sorted(set(Path(folder).glob("*.png")) - set(frames)):
            picture = TARGET / f"{path.stem}.webp"
            Image.open(path).convert("RGB").save(picture, quality=82, method=6)
        save_moving(frames, TARGET / "slider.webp")


def save_moving(paths: list[Path], target: Path) -> None:
    """Save frames as a moving picture that starts again at its end."""
    frames = [Image.open(path).convert("RGB") for path in paths]
    height = round(frames[0].height * WIDTH / frames[0].width)
    small = [frame.resize((WIDTH, height), Image.Resampling.LANCZOS) for frame in frames]
    times = [FRAME_MILLISECONDS] * len(small)
    times[0] = times[-1] = HELD_MILLISECONDS
    small[0].save(
        target, save_all=True, append_images=small[1:], duration=times, loop=0, quality=70, method=6
    )


if __name__ == "__main__":
    take_pictures()
