"""Gamut boundaries at any triangle count: colour and geometry, no web, no storage.

Data flows one way, and the folders are named after its stations: `characterisation` → `colours` →
`boundary` → `decimation` → `history` → level (`mesh`) → `export`, `metric`. `gamut` walks the path.
"""

from gamutcore.version import __version__

__all__ = ["__version__"]
