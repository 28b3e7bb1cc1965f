"""Take the pictures of the viewer for README and docs/tour.md. Run by ``make viewer-pictures``.

Serves examples and drives the viewer with ``web/viewer/pictures.mjs``. The crops go to
``docs/pictures/viewer``, at most `MOST_BYTES` each.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

from PIL import Image

from benchmarks.http import server
from benchmarks.viewer import drive

FOLDER = Path(__file__).parent / "viewer"
EXAMPLES = Path(__file__).parents[2] / "examples"
PHOTO = Path(__file__).parents[2] / "gamutcore" / "export" / "examples" / "photo.jpg"
QUALITIES = (80, 70, 60, 50, 40)
MOST_BYTES = 60_000


def take_pictures() -> None:
    """Take all pictures."""
    FOLDER.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder, server(pin=False) as running:
        data = (EXAMPLES / "FOGRA29L.ti3").read_bytes()
        # The line makes it another file, which the service has to build.
        file = Path(folder) / "Uncoated paper.ti3"
        file.write_bytes(data + b"\n")
        drive(
            "pictures.mjs",
            running.port,
            FOLDER=folder,
            FILE=str(file),
            PHOTO=str(PHOTO),
        )
        save(Path(folder))


def save(folder: Path) -> None:
    """Save the pictures of a folder as WebP, each with the best quality that fits."""
    for path in sorted(folder.glob("*.png")):
        picture = Image.open(path).convert("RGB")
        target = FOLDER / f"{path.stem}.webp"
        for quality in QUALITIES:
            picture.save(target, quality=quality, method=6)
            if target.stat().st_size <= MOST_BYTES:
                break
        else:
            raise ValueError(f"{target.name} has more than {MOST_BYTES} bytes")


if __name__ == "__main__":
    take_pictures()
