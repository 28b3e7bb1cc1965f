"""Gamut boundaries at any triangle count: colour and geometry, without web or storage.

`Gamut` builds a gamut from characterisation data and answers questions about it. `link` makes files
that apply a gamut mapping in other programs, and `profile` makes ICC profiles. `match` and
`compare_all` ask many gamuts, `drift` compares readings of one device, and `report` measures a
gamut by a published standard. Data flows one way, and the folders are named after the stages:
`characterisation` → `colours` → `boundary` → `decimation` → `history` → `levels` → `search` and
`export`. The package needs none of the web packages of the extra ``service``.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from gamutcore.version import __version__

if TYPE_CHECKING:
    from collections.abc import Callable

    from gamutcore.gamut import Gamut
    from gamutcore.links import link, profile
    from gamutcore.options import Options
    from gamutcore.reports import compare_all, report
    from gamutcore.reports.drift import drift
    from gamutcore.reports.match import match

__all__ = [
    "Gamut",
    "Options",
    "__version__",
    "compare_all",
    "drift",
    "link",
    "match",
    "profile",
    "reference",
    "report",
]

_HOME = {
    "Gamut": "gamutcore.gamut",
    "Options": "gamutcore.options",
    "compare_all": "gamutcore.reports",
    "drift": "gamutcore.reports",
    "link": "gamutcore.links",
    "match": "gamutcore.reports.match",
    "profile": "gamutcore.links",
    "report": "gamutcore.reports",
}
"""Modules of the names that are imported on first use. Their import takes a tenth of a second,
which `gamutcore.errors` and the command line's help do not need."""


def __getattr__(name: str) -> object:
    """Import a public name on first use."""
    if name not in _HOME:
        raise AttributeError(f"module 'gamutcore' has no attribute {name!r}")
    value: object = getattr(importlib.import_module(_HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """Return the names of the module, including those imported on first use."""
    return sorted({*globals(), *_HOME})


def reference(
    name: str,
    *,
    progress: bool | Callable[[str, float], None] = False,
    **options: Any,  # noqa: ANN401  # checked by Options
) -> Gamut:
    """Build a reference gamut: an RGB space, Pointer's gamut or the optimal colours.

    Parameters
    ----------
    name : str
        A slug, a name or an unambiguous alias of `gamutcore.references.REFERENCES`, such as
        ``"Display P3"`` or ``"Rec2020"``.
    progress : bool or callable, optional
        As for `Gamut`.
    **options
        How the gamut is built, as for `Gamut`.

    Returns
    -------
    Gamut

    Raises
    ------
    ReferenceNameError
        There is no such reference, or several have the name; the remedy names the candidates.
    GamutError
        An option is not accepted, or the boundary cannot be built with it.

    Examples
    --------
    >>> reference("sRGB", surface_samples=1000).level(100).triangles
    100
    """
    from gamutcore.gamut import Gamut  # noqa: PLC0415  # as in __getattr__
    from gamutcore.references import find_reference  # noqa: PLC0415

    return Gamut(find_reference(name).data, progress=progress, **options)
