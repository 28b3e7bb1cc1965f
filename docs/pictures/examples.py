"""Make the built-in examples of the viewer, ``gamutcore/export/examples``: ``make examples``.

A press, three displays and a photograph: the description of each gamut, and the beginning of its
history file, which gives about 6,000 triangles. Their ids are those of the whole gamuts, so the
service answers questions about them once it has built them from the same data. ``photo.jpg`` stays
as it is; ``LICENSE`` has its origin.
"""

from __future__ import annotations

import gzip
import io
import json
from pathlib import Path

from PIL import Image

from gamutcore import Gamut
from gamutcore.export.viewer_page import EXAMPLE_FILES, PageGamut
from gamutcore.references import REFERENCES

PRESS = Path(__file__).parents[2] / "examples" / "FOGRA39L.ti3"
PREFIX = 46 * 1024
"""Bytes of a history file."""

STILL = 640
"""Width and height of the picture that is shown until the script has drawn."""

EXAMPLES = (
    ("press", "FOGRA39L", "Offset printing on coated paper.", "FOGRA39L.ti3"),
    ("srgb", "", "The colours of most screens and of the web.", None),
    ("display-p3", "", "The colours of current phones and laptops.", None),
    ("bt2020", "", "The colours of ultra-high-definition television.", None),
    ("photo", "Coffee", "The colours of a photograph.", "photo.jpg"),
)
"""Key, name, sentence and file of each; references have the name of the catalogue and no file."""


def make_examples() -> None:
    """Write all files but the photograph and the licences."""
    # A time in the file would change it with every run.
    press = gzip.compress(PRESS.read_bytes(), 9, mtime=0)
    (EXAMPLE_FILES / "FOGRA39L.ti3.gz").write_bytes(press)
    index = []
    for key, name, sentence, file in EXAMPLES:
        reference = REFERENCES.get(key)
        kind = "reference" if reference else "picture" if key == "photo" else "file"
        source = {"FOGRA39L.ti3": PRESS, "photo.jpg": EXAMPLE_FILES / "photo.jpg"}.get(file or "")
        gamut = Gamut(source or reference.data)
        shown = PageGamut(reference.name if reference else name, gamut.description, b"")
        history = gamut.to_bytes()
        description = {**shown.document, "state": "ready", "history_bytes": len(history)}
        _write_json(f"{key}.json", description)
        (EXAMPLE_FILES / f"{key}.gamut").write_bytes(history[:PREFIX])
        index.append({"key": key, "name": shown.name, "text": sentence, "kind": kind, "file": file})
        if key == "press":
            picture = Image.open(io.BytesIO(gamut.picture(size=STILL, background="transparent")))
            picture.save(EXAMPLE_FILES / "still.webp", quality=80, method=6)
    _write_json("index.json", {"examples": index})


def _write_json(name: str, content: object) -> None:
    text = json.dumps(content, ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    (EXAMPLE_FILES / name).write_text(text, "utf-8")


if __name__ == "__main__":
    make_examples()
