"""Markdown tables, and the blocks of a document that a program writes.

The documents are written by hand. A generated block is the text between the two comments
``<!-- begin NAME -->`` and ``<!-- end NAME -->``. A benchmark replaces the blocks that it
measures and leaves the rest of the document alone.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from benchmarks.common import Rows

_BLOCK = re.compile(r"<!-- begin ([\w-]+) -->\n(.*?)\n?<!-- end \1 -->", re.DOTALL)


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def rows_table(rows: Rows) -> str:
    """Return rows as a Markdown table, with numbers to three significant digits."""

    def cell(value: object) -> str:
        if isinstance(value, int | float):
            whole = isinstance(value, int) or abs(value) >= 1000
            return f"{value:,.0f}" if whole else f"{value:.3g}"
        return "–" if value is None else str(value)

    head = list(dict.fromkeys(name for row in rows for name in row))
    return table(head, [[cell(row.get(name)) for name in head] for row in rows])


def blocks(text: str) -> dict[str, str]:
    """Return the generated blocks of a document by name."""
    return {match[1]: match[2] for match in _BLOCK.finditer(text)}


def replace_blocks(text: str, contents: Mapping[str, str]) -> str:
    """Return a document with the contents of some of its blocks replaced by name."""
    names = [match[1] for match in _BLOCK.finditer(text)]
    for name in contents:
        if names.count(name) != 1:
            raise ValueError(
                f"The document must contain the block {name!r} once. "
                f"Found: {names.count(name)}. Add the comments '<!-- begin {name} -->' and "
                f"'<!-- end {name} -->' where the block belongs."
            )

    def replacement(match: re.Match[str]) -> str:
        content = contents.get(match[1], match[2]).strip("\n")
        lines = f"{content}\n" if content else ""
        return f"<!-- begin {match[1]} -->\n{lines}<!-- end {match[1]} -->"

    return _BLOCK.sub(replacement, text)


def update_document(path: Path, contents: Mapping[str, str]) -> None:
    """Replace blocks in a file. See `replace_blocks`."""
    path.write_text(replace_blocks(path.read_text(), contents))


def store(results: dict[str, Any], file: Path, document: Path, contents: Mapping[str, str]) -> None:
    """Write results as JSON, replace the blocks of a document, and print them.

    A table row takes a line of the file. Numbers have six significant digits.
    """

    def rounded(value: Any) -> Any:  # noqa: ANN401  # any JSON value
        if isinstance(value, float):
            return float(f"{value:.6g}")
        if isinstance(value, dict):
            return {name: rounded(each) for name, each in value.items()}
        return [rounded(each) for each in value] if isinstance(value, list) else value

    parts = []
    for name, value in rounded(results).items():
        text = json.dumps(value, ensure_ascii=False)
        if isinstance(value, list) and value and isinstance(value[0], dict):
            rows = ",\n  ".join(json.dumps(row, ensure_ascii=False) for row in value)
            text = f"[\n  {rows}\n ]"
        parts.append(f"{json.dumps(name)}: {text}")
    file.write_text("{\n " + ",\n ".join(parts) + "\n}\n")
    update_document(document, contents)
    print(*contents.values(), sep="\n\n")
