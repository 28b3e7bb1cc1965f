"""Make the built-in examples of the viewer, ``gamutcore/export/examples``: ``make examples``.

A press, three displays and a photograph: the description of each gamut, and the beginning of its
history file, which gives 8,188 triangles. Their ids are those of the whole gamuts, so the
service answers questions about them once it has built them from the same data. The index has the
comparison of each pair, which the page states before the service can compute it. ``photo.jpg``
stays as it is; ``LICENSE`` has its origin.
"""

from __future__ import annotations

import gzip
import io
import itertools
import json
from pathlib import Path

from PIL import Image

from gamutcore import Gamut
from gamutcore.export.viewer_page import EXAMPLE_FILES, PageGamut
from gamutcore.references import REFERENCES

PRESS = Path(__file__).parents[2] / "examples" / "FOGRA39L.ti3"
GROUPS = 10
"""Groups of splits in the beginning of a history file. The last one ends with 4096 vertices."""

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
    _write_compressed(PRESS.name, PRESS.read_bytes())
    index = []
    gamuts = {}
    for key, name, sentence, file in EXAMPLES:
        reference = REFERENCES.get(key)
        kind = "reference" if reference else "picture" if key == "photo" else "file"
        source = {"FOGRA39L.ti3": PRESS, "photo.jpg": EXAMPLE_FILES / "photo.jpg"}.get(file or "")
        gamut = Gamut(source or reference.data)
        shown = PageGamut(reference.name if reference else name, gamut.description, b"")
        gamuts[gamut.id] = gamut
        history = gamut.to_bytes()
        description = {**shown.document, "state": "ready", "history_bytes": len(history)}
        _write_json(f"{key}.json", description)
        (EXAMPLE_FILES / f"{key}.gamut").write_bytes(history[: _end(history)])
        index.append({"key": key, "name": shown.name, "text": sentence, "kind": kind, "file": file})
        if key == "press":
            picture = Image.open(io.BytesIO(gamut.picture(size=STILL, background="transparent")))
            picture.save(EXAMPLE_FILES / "still.webp", quality=80, method=6)
    _write_json("index.json", {"examples": index, "comparisons": _compare_pairs(gamuts)})


def _compare_pairs(gamuts: dict[str, Gamut]) -> list[dict[str, object]]:
    """Return coverage and summary of each ordered pair: as the service answers, by ids."""
    pairs = []
    for (a, first), (b, second) in itertools.permutations(gamuts.items(), 2):
        comparison = first.compare(second)
        pairs.append(
            {
                "a": a,
                "b": b,
                "a_covers_b": round(comparison.a_covers_b, 4),
                "b_covers_a": round(comparison.b_covers_a, 4),
                "summary": list(comparison.summary),
            }
        )
    return pairs


def _write_json(name: str, content: object) -> None:
    text = json.dumps(content, ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    _write_compressed(name, text.encode())


def _write_compressed(name: str, content: bytes) -> None:
    # A time in the file would change it with every run.
    (EXAMPLE_FILES / f"{name}.gz").write_bytes(gzip.compress(content, 9, mtime=0))


def _end(history: bytes) -> int:
    """Return where the last group ends (docs/history-format.md)."""
    begin = 8 + int.from_bytes(history[:4], "little")
    groups = json.loads(history[8:begin])["groups"]
    return begin + sum(group["bytes"] for group in groups[:GROUPS])


if __name__ == "__main__":
    make_examples()
