"""The standard observer that a file declares, in the usual spellings.

Argyll and DisplayCAL write ``1931_2``, others ``2 degree``, ``CIE 1964``, ``TEN`` or ``D50/2``.
Other observers (Judd-Vos, Stiles and Burch, Shaw and Fairchild, CIE 170-2) share an angle with
those of CIE 15 and must not be mistaken for them.
"""

from __future__ import annotations

import re

__all__ = ["declared_observer"]

_PART = re.compile(r"[0-9]+(?:\.[0-9]+)?|[A-Z]+")
_DEGREES = {"TWO": "2", "TEN": "10", "1931": "2", "1964": "10"}
_FOREIGN = frozenset(
    {
        *("1951", "SCOTOPIC"),
        *("1955", "1959", "STILES", "BURCH"),
        *("1978", "JUDD", "VOS"),
        *("2006", "2012", "2015", "170"),
        *("SHAW", "FAIRCHILD"),
    }
)
"""Years and names of other observers; Argyll has 1955_2, 1955_10, 1978_2, 2012_2, 2012_10 and
shaw."""


def declared_observer(text: str) -> str | None:
    """Return the standard observer that a text such as ``"1931_2"`` or ``"10 degree"`` names.

    ``"2"`` stands for CIE 1931 and ``"10"`` for CIE 1964 (CIE 15:2018, 6.1 and 6.2). None if the
    text names another observer, both, or none.
    """
    parts = _PART.findall(text.upper())
    if not _FOREIGN.isdisjoint(parts):
        return None
    found = {_DEGREES[part] for part in parts if part in _DEGREES}
    angles = (float(part) for part in parts if part[0].isdigit())
    found |= {f"{angle:.0f}" for angle in angles if angle in (2.0, 10.0)}
    return found.pop() if len(found) == 1 else None
