"""Text in formats that know only lines of ASCII characters in quotation marks."""

from __future__ import annotations

__all__ = ["ascii_line"]


def ascii_line(text: str) -> str:
    r"""Return a text as one line of ASCII without double quotation marks.

    Other characters become escapes such as ``\xe9``.
    """
    line = " ".join(text.split()).replace('"', "'")
    return line.encode("ascii", "backslashreplace").decode()
