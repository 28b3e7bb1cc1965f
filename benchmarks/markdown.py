"""Markdown tables, and the blocks of a document that a program writes.

The documents are written by hand. A generated block is the text between the two comments
``<!-- begin NAME -->`` and ``<!-- end NAME -->``. A benchmark replaces the blocks that it
measures and leaves the rest of the document alone.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

__all__ = ["blocks", "count_text", "percent", "replace_blocks", "table", "update_document"]

_BLOCK = re.compile(r"<!-- begin ([\w-]+) -->\n(.*?)\n?<!-- end \1 -->", re.DOTALL)


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def percent(part: float | None) -> str:
    """Format a fraction in per cent, without the sign and with three significant digits."""
    if part is None:
        return "–"
    value = 100 * part
    return f"{value:.1f}" if value >= 10 else f"{value:#.3g}"


def count_text(count: int) -> str:
    """Format a count with thousands separators."""
    return f"{count:,}"


def blocks(text: str) -> dict[str, str]:
    """Return the generated blocks of a document by name."""
    return {match[1]: match[2] for match in _BLOCK.finditer(text)}


def replace_blocks(text: str, contents: Mapping[str, str]) -> str:
    r"""Return a document with the contents of some of its blocks replaced.

    Parameters
    ----------
    text : str
        The document.
    contents : mapping of str to str
        New content of each block by its name. Blocks that are not named keep their content.

    Raises
    ------
    ValueError
        If the document does not contain a named block exactly once.

    Examples
    --------
    >>> replace_blocks("<!-- begin a -->\nold\n<!-- end a -->", {"a": "new"})
    '<!-- begin a -->\nnew\n<!-- end a -->'
    """
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
