"""Take the pictures of the viewer in the documents: ``make viewer-pictures``.

The program starts the service, builds two presses of ``examples`` and drives the viewer in Chromium
(``web/viewer/pictures.mjs``). The results are WebP files in ``docs/pictures/viewer``, and
``slider.webp`` moves.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from pathlib import Path

from PIL import Image

from benchmarks.common import ROOT
from benchmarks.http import posted, server

__all__ = ["main"]

TARGET = ROOT / "docs" / "pictures" / "viewer"
LARGEST = 150_000
LARGEST_MOVING = 1_000_000
WIDTH = 720
FRAME_MILLISECONDS = 110
HELD_MILLISECONDS = 1500


def main() -> None:
    """Take all pictures."""
    chromium = next(filter(None, map(shutil.which, ("chromium", "google-chrome"))))
    TARGET.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder, server(pin=False) as running:
        address = f"http://127.0.0.1:{running.port}"
        subprocess.run(
            ["node", str(ROOT / "web" / "viewer" / "pictures.mjs")],
            env={
                **os.environ,
                "VIEWER_URL": address,
                "CHROMIUM": str(chromium),
                "FOLDER": folder,
                "PRESS": built(running.port, "FOGRA39L.ti3"),
                "OTHER": built(running.port, "FOGRA29L.ti3"),
            },
            check=True,
        )
        frames = sorted(Path(folder).glob("slider-*.png"))
        for path in sorted(set(Path(folder).glob("*.png")) - set(frames)):
            picture = TARGET / f"{path.stem}.webp"
            Image.open(path).convert("RGB").save(picture, quality=82, method=6)
            check(picture, LARGEST)
        save_moving(frames, TARGET / "slider.webp")


def built(port: int, name: str) -> str:
    """Return the id of a gamut that the service builds from an example."""
    content = (ROOT / "examples" / name).read_bytes()
    return str(posted(port, {}, content, "wait=120")[2]["id"])


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
    check(target, LARGEST_MOVING)


def check(path: Path, largest: int) -> None:
    """Fail if a picture is too large for the repository."""
    size = path.stat().st_size
    print(f"{path.name}: {size / 1000:.0f} kB")
    if size > largest:
        raise SystemExit(f"{path} has {size} bytes; at most {largest} are accepted.")


if __name__ == "__main__":
    main()
