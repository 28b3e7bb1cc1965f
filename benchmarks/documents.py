"""Update the generated blocks of all documents from the committed results and declarations.

``python -m benchmarks.documents`` writes the blocks. A test compares them with the documents.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

from benchmarks import decimation_tables, reliability
from benchmarks.common import DOCUMENT, RESULTS, ROOT
from benchmarks.markdown import rows_table, update_document
from gamutcore.colours import SPACE_PARAMETERS
from gamutcore.option_types import option_table
from gamutcore.options import OPTIONS


def _options(names: list[str]) -> dict[str, str]:
    return {"options": option_table([OPTIONS[name] for name in names]).strip()}


DOCUMENTS: dict[Path, Callable[[], dict[str, str]]] = {
    ROOT / "README.md": lambda: _options([name for name in OPTIONS if OPTIONS[name].common]),
    ROOT / "docs" / "options.md": lambda: _options(list(OPTIONS)),
    ROOT / "docs" / "colour-spaces.md": lambda: _options(list(SPACE_PARAMETERS)),
    DOCUMENT: lambda: {
        name: rows_table(rows) for name, rows in json.loads(RESULTS.read_text()).items()
    },
    decimation_tables.DOCUMENT: lambda: decimation_tables.document_blocks(
        json.loads(decimation_tables.RESULTS.read_text())
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
