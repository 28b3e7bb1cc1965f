"""Update the generated blocks of all documents from the committed results and declarations.

``python -m benchmarks.documents`` writes the blocks. A test compares them with the documents.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

from benchmarks import bench, decimation_tables, figures, reliability, scaling
from benchmarks.common import ROOT
from benchmarks.markdown import update_document
from gamutcore.colours.spaces.parameters import SPACE_PARAMETERS
from gamutcore.option_types import option_table
from gamutcore.options import OPTIONS

__all__ = ["DOCUMENTS", "main"]


def _common_options() -> dict[str, str]:
    common = [declared for declared in OPTIONS.values() if declared.common]
    return {"options": option_table(common).strip()}


def _space_options() -> dict[str, str]:
    declared = [OPTIONS[name] for name in SPACE_PARAMETERS]
    return {"options": option_table(declared).strip()}


DOCUMENTS: dict[Path, Callable[[], dict[str, str]]] = {
    ROOT / "README.md": _common_options,
    ROOT / "docs" / "options.md": lambda: {"options": option_table(OPTIONS.values()).strip()},
    ROOT / "docs" / "colour-spaces.md": _space_options,
    bench.DOCUMENT: lambda: bench.document_blocks(json.loads(bench.RESULTS.read_text())),
    figures.DOCUMENT: lambda: decimation_tables.document_blocks(
        json.loads(figures.RESULTS.read_text())
    ),
    reliability.DOCUMENT: lambda: reliability.document_blocks(
        json.loads(reliability.RESULTS.read_text())
    ),
    scaling.DOCUMENT: lambda: scaling.document_blocks(*scaling.read_results(), scaling.Load()),
}
"""Documents with generated blocks, and the functions that compute the blocks."""


def main() -> None:
    """Update all documents."""
    for path, blocks in DOCUMENTS.items():
        update_document(path, blocks())


if __name__ == "__main__":
    main()
