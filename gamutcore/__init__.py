"""Gamut boundaries at any triangle count: colour and geometry, without web or storage.

Data flows one way, and the folders are named after the stages: `characterisation` → `colours` →
`boundary` → `decimation` → `history` → level (`mesh`) → `export` and `metric`. `gamut.build_gamut`
runs all of them. The package needs none of the web packages of the extra ``service``.
"""

from gamutcore.version import __version__

__all__ = ["__version__"]
