"""Names of downloaded files (RFC 6266 and RFC 8187)."""

from __future__ import annotations

import re
import unicodedata
from urllib.parse import quote

from gamutcore.characterisation.recognition import FORMATS

__all__ = ["content_disposition"]

_FORBIDDEN = re.compile(r'[\x00-\x1f\x7f\\/:*?"<>|%;]+')
"""Characters that some file systems or clients do not accept in a name."""

_LONGEST = 180
"""Bytes of a name in UTF-8; file systems accept 255."""

_INPUT_SUFFIXES = tuple(suffix for each in FORMATS for suffix in each.extensions)
"""A gamut may have the name of the file that was posted. Other files do not get its suffix."""


def content_disposition(kind: str, name: str, rest: str) -> str:
    r"""Return the value of ``Content-Disposition``.

    Parameters
    ----------
    kind : str
        ``inline`` or ``attachment``.
    name : str
        Of the gamut; any text. The suffix of a format that is read is left out.
    rest : str
        What follows the name in the name of the file, with the suffix; in ASCII.

    Returns
    -------
    str
        ``filename`` in ASCII, and ``filename*`` if that is not the whole name.

    Examples
    --------
    >>> content_disposition("inline", "Coated 300 %", "-1000.glb")
    'inline; filename="Coated 300 _-1000.glb"'
    >>> content_disposition("attachment", "Blätter", ".gamut")
    'attachment; filename="Blatter.gamut"; filename*=UTF-8\'\'Bl%C3%A4tter.gamut'
    >>> content_disposition("inline", "ball.npy", "-996.glb")
    'inline; filename="ball-996.glb"'
    """
    whole = _cleaned(_without_suffix(name))
    plain = unicodedata.normalize("NFKD", whole).encode("ascii", "ignore").decode()
    value = f'{kind}; filename="{_cleaned(plain)}{rest}"'
    if plain == whole:
        return value
    return f"{value}; filename*=UTF-8''{quote(whole + rest, safe='')}"


def _without_suffix(name: str) -> str:
    """Return the name of a file without the suffix of a format that is read."""
    stem, dot, suffix = name.rpartition(".")
    return stem if stem and f"{dot}{suffix}".lower() in _INPUT_SUFFIXES else name


def _cleaned(name: str) -> str:
    """Return a name that file systems accept."""
    kept = _FORBIDDEN.sub("_", name).strip().lstrip(".")
    short = kept.encode("utf-8", "replace")[:_LONGEST].decode("utf-8", "ignore").strip()
    return short or "gamut"
