"""Update the generated blocks of all documents from the committed results and declarations.

``python -m benchmarks.documents`` writes the blocks. A test compares them with the documents.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from pathlib import Path

from benchmarks import accuracy, decimation_tables, intervals, matches, reliability, summary
from benchmarks.common import DOCUMENT, RESULTS, ROOT
from benchmarks.markdown import table, update_document
from gamutcore.characterisation import FORMATS as INPUT_FORMATS
from gamutcore.export import FORMATS
from gamutcore.options import OPTIONS
from service.settings import settings_table


def option_table(names: Iterable[str]) -> str:
    """Return a Markdown table of options: name, accepted values, default, description."""
    lines = ["| option | values | default | meaning |", "|---|---|---|---|"]
    for option in (OPTIONS[name] for name in names):
        cells = (f"`{option.name}`", option.accepted, option.default_text, option.description)
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return "\n".join(lines)


def export_table() -> str:
    """Return a Markdown table of the formats that meshes are written in."""
    rows = [
        (f"`{each.name}`", f"`{each.media_type}`", f"`{each.suffix}`", each.content, each.readers)
        for each in FORMATS.values()
    ]
    return table(("`format=`", "media type", "suffix", "content", "who reads it"), rows)


def input_table() -> str:
    """Return a Markdown table of the formats of characterisation data."""
    rows = [(each.title, each.kind, " ".join(each.extensions)) for each in INPUT_FORMATS]
    return table(("format", "content", "extensions"), rows)


DOCUMENTS: dict[Path, Callable[[], dict[str, str]]] = {
    ROOT / "docs" / "options.md": lambda: {"options": option_table(OPTIONS)},
    ROOT / "docs" / "exports.md": lambda: {"formats": export_table()},
    ROOT / "docs" / "characterisation.md": lambda: {"formats": input_table()},
    ROOT / "docs" / "settings.md": lambda: {"settings": settings_table()},
    DOCUMENT: lambda: {
        **summary.document_blocks(json.loads(RESULTS.read_text())),
        **matches.document_blocks(json.loads(matches.RESULTS.read_text())),
    },
    accuracy.DOCUMENT: lambda: accuracy.document_blocks(json.loads(accuracy.RESULTS.read_text())),
    decimation_tables.DOCUMENT: lambda: decimation_tables.document_blocks(
        json.loads(decimation_tables.RESULTS.read_text())
    ),
    intervals.DOCUMENT: lambda: intervals.document_blocks(
        json.loads(intervals.RESULTS.read_text())
    ),
    reliability.DOCUMENT: lambda: reliability.document_blocks(
        json.loads(reliability.RESULTS.read_text())
    ),
}
"""Documents with generated blocks, and the functions that compute the blocks."""


def main() -> None:
    """Update all documents."""
    for path, blocks in DOCUMENTS.items():
        update_document(path, blocks())


if __name__ == "__main__":
    main()
