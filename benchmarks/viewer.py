"""Measure the viewer in Chromium: ``make bench-viewer``.

Starts the service, builds the example, and drives the viewer without a graphics
processor (``web/viewer/tests/measure.mjs``). The figures go to ``benchmarks/viewer.json`` and into
``docs/benchmarks.md``.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import tempfile
import time
import urllib.request
from pathlib import Path
from typing import Any

from benchmarks import markdown
from benchmarks.bench import DOCUMENT, machine
from benchmarks.common import ROOT
from benchmarks.http import posted

__all__ = ["GOALS", "main", "measure", "table_of"]

RESULTS = Path(__file__).with_name("viewer.json")
PORT = 18765
START_SECONDS = 120.0

GOALS: dict[str, tuple[str, str]] = {
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
    "undrawn_levels_per_second": ("new levels per second meanwhile", "≥ 60"),
    "cleared_pictures_per_second": (
        "pictures per second of an empty view: the browser's and rasteriser's limit",
        "–",
    ),
}
"""What is measured, and the goal."""


def main() -> None:
    """Measure and write the figures."""
    results = {"machine": machine(), "now": measure()}
    RESULTS.write_text(json.dumps(results, indent=2) + "\n")
    text = table_of(results)
    print(text)
    markdown.update_document(DOCUMENT, {"viewer": text})


def table_of(results: dict[str, Any]) -> str:
    """Return the figures as a Markdown table."""
    rows = [
        [
            title,
            f"{results['now'][name]:,.4g}"
            if name != "whole_triangles"
            else f"{results['now'][name]:,}",
            goal,
        ]
        for name, (title, goal) in GOALS.items()
    ]
    return markdown.table(["figure", "measured", "goal"], rows)


def measure() -> dict[str, float]:
    """Return the figures by the names of `GOALS`."""
    chromium = next(filter(None, map(shutil.which, ("chromium", "google-chrome"))))
    with tempfile.TemporaryDirectory() as folder:
        command = [str(ROOT / ".venv/bin/gamut"), "serve", "--port", str(PORT), "--store", folder]
        with subprocess.Popen(command, stderr=subprocess.DEVNULL) as server:
            try:
                _wait_ready()
                posted(PORT, {})
                gamut = _get("/v1/gamuts")["gamuts"][0]["id"]
                ended = subprocess.run(
                    ["node", str(ROOT / "web/viewer/tests/measure.mjs")],
                    env={
                        **os.environ,
                        "VIEWER_URL": f"http://127.0.0.1:{PORT}",
                        "CHROMIUM": str(chromium),
                        "GAMUT": gamut,
                    },
                    check=True,
                    capture_output=True,
                    text=True,
                )
            finally:
                server.terminate()
    return dict(json.loads(ended.stdout))


def _get(path: str) -> dict[str, Any]:
    with urllib.request.urlopen(f"http://127.0.0.1:{PORT}{path}", timeout=60) as answer:
        return dict(json.load(answer))


def _wait_ready() -> None:
    deadline = time.monotonic() + START_SECONDS
    while True:
        try:
            _get("/readyz")
        except OSError:
            if time.monotonic() > deadline:
                raise
            time.sleep(0.2)
        else:
            return


if __name__ == "__main__":
    main()
