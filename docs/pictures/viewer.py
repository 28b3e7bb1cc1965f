"""Take the pictures of the viewer for README and docs/tour.md. Run by ``make viewer-pictures``.

Serves examples and drives the viewer with ``web/viewer/pictures.mjs``. The pictures go to
``docs/pictures/viewer``; ``slider.webp`` moves.
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
QUALITY, QUALITY_OF_FRAMES = 60, 50
WIDTH = 640
FRAME_MILLISECONDS, HELD_MILLISECONDS = 110, 1500


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
    """Save the pictures of a folder as WebP, and the frames of the slider as one that moves."""
    frames = sorted(folder.glob("slider-*.png"))
    for path in sorted(set(folder.glob("*.png")) - set(frames)):
        Image.open(path).convert("RGB").save(
            FOLDER / f"{path.stem}.webp", quality=QUALITY, method=6
        )
    save_moving(frames, FOLDER / "slider.webp")


def save_moving(paths: list[Path], target: Path) -> None:
    """Save frames as a moving picture that starts again at its end."""
    frames = [Image.open(path).convert("RGB") for path in paths]
    height = round(frames[0].height * WIDTH / frames[0].width)
    small = [frame.resize((WIDTH, height), Image.Resampling.LANCZOS) for frame in frames]
    times = [FRAME_MILLISECONDS] * len(small)
    times[0] = times[-1] = HELD_MILLISECONDS
    small[0].save(
        target,
        save_all=True,
        append_images=small[1:],
        duration=times,
        loop=0,
        quality=QUALITY_OF_FRAMES,
        method=6,
    )


if __name__ == "__main__":
    take_pictures()
