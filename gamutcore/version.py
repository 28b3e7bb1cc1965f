"""Versions of the distribution and of the algorithm. The latter is part of every gamut id."""

__all__ = ["ALGORITHM_VERSION", "__version__"]

__version__ = "0.1.0"

ALGORITHM_VERSION = 23
"""Raised whenever the same input and options would give another history; part of every gamut id."""
