"""Small pieces of Markdown: tables and numbers as the documents write them."""

from __future__ import annotations

from collections.abc import Sequence

__all__ = ["count_text", "percent", "table"]


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def percent(part: float | None) -> str:
    """Write a part in per cent with three significant digits, without the sign."""
    if part is None:
        return "–"
    value = 100 * part
    return f"{value:.1f}" if value >= 10 else f"{value:#.3g}"


def count_text(count: int) -> str:
    """Write a count with its thousands marked."""
    return f"{count:,}"
