"""The viewer in Chromium, without a graphics processor: ``make bench-viewer``.

Starts the service and drives the viewer with ``web/viewer/tests/measure.mjs``.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess

from benchmarks.common import ROOT, Rows
from benchmarks.http import server

GOALS = {
    "bundle_kilobytes": ("page, script, worker and style with brotli, kB", "≤ 230"),
    "first_screen_seconds": (
        "first picture of `/` on a warm service, s after opening the page",
        "≤ 1",
    ),
    "first_picture_seconds": ("first picture of a stored gamut, s after opening the page", "≤ 1"),
    "first_picture_kilobytes": ("bytes of the history that were read for it, kB", "≤ 32.8"),
    "level_milliseconds": ("from one level of about 10,000 triangles to another, ms", "≤ 16.7"),
    "pictures_per_second": ("pictures per second while dragging below 10,000 triangles", "≥ 60"),
    "levels_per_second": ("new levels per second meanwhile", "≥ 60"),
    "script_milliseconds": ("script of the page meanwhile, ms per picture", "≤ 4"),
    "turn_milliseconds": (
        "script while two gamuts of 10,000 triangles turn, ms per picture",
        "≤ 4",
    ),
    "turn_outside_milliseconds": ("the same, only the part outside in colour", "≤ 4"),
    "turn_whole_milliseconds": ("script while two full boundaries turn, ms per picture", "≤ 10"),
    "turn_whole_outside_milliseconds": ("the same, only the part outside in colour", "≤ 10"),
    "slice_milliseconds": ("script of a step of the section, 10,000 triangles each, ms", "≤ 16.7"),
    "cleared_pictures_per_second": ("pictures per second of an empty view", "–"),
}
"""What the script measures: title and goal."""


def viewer(_quick: bool) -> Rows:
    """Measure the viewer with FOGRA39L, and with sRGB as the second gamut."""
    with server(pin=False) as running:
        press = running.build()
        other = running.client.get("/v1/gamuts/srgb", headers={"Prefer": "wait=600"}).json()
        gamuts = {
            "GAMUT": press["id"],
            "OTHER": other["id"],
            "GAMUT_FINEST": str(press["counts"]["triangles"]),
            "OTHER_FINEST": str(other["counts"]["triangles"]),
        }
        measured = json.loads(drive("tests/measure.mjs", running.port, **gamuts))
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
