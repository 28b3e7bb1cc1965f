"""How results are shown: in one line, and as a small table in notebooks.

`gamutcore` and `gamutclient` have the same module, since neither may import the other. A test
compares the two files.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import Field, fields
from html import escape
from typing import Any, ClassVar

import numpy as np

__all__ = ["Shown"]

SMALL = 3
"""Arrays of so many numbers are shown whole: a colour."""

LONGEST = 60
"""Longest text of a field, in characters."""


class Shown:
    """A base of data classes with ``repr=False``: arrays are shown by their shape or range."""

    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]

    def __repr__(self) -> str:
        facts = ", ".join(f"{name} {text}" for name, text in self._facts())
        return f"<{type(self).__name__}: {facts}>"

    def _repr_html_(self) -> str:
        """Return the fields as a table, for notebooks."""
        rows = "".join(
            f"<tr><th style='text-align:left'>{escape(name)}</th><td>{escape(text)}</td></tr>"
            for name, text in self._facts()
        )
        return f"<table><caption>{type(self).__name__}</caption>{rows}</table>"

    def _facts(self) -> Iterator[tuple[str, str]]:
        """Yield names and texts of the fields that have a short text."""
        for field in fields(self):
            text = _text(getattr(self, field.name)) if field.repr else ""
            if text:
                yield field.name, text


def _text(value: object) -> str:
    """Return a value in a few words; empty for what has no short text, such as a mapping."""
    if isinstance(value, np.ndarray):
        return _array_text(value)
    if isinstance(value, float | np.floating):
        return f"{value:.6g}"
    if isinstance(value, tuple):
        text = " ".join("-" if part is None else _text(part) for part in value)
        return text if len(text) <= LONGEST else f"{text[: LONGEST - 1]}…"
    return " ".join(str(value).split())[:LONGEST] if isinstance(value, str | int) else ""


def _array_text(values: np.ndarray[Any, Any]) -> str:
    if values.dtype == np.bool_:
        return f"{np.count_nonzero(values)} of {values.size}"
    if values.size <= SMALL and values.ndim <= 1:
        return " ".join(f"{value:.4g}" for value in values.ravel())
    finite = values[np.isfinite(values)]
    if values.ndim == 1 and finite.size:
        return f"{finite.min():.4g} to {finite.max():.4g} ({values.size})"
    return " × ".join(map(str, values.shape))
