"""Metrics: what two gamuts have in common and how far they are apart."""

from gamutcore.metric.mismatch import intersection_volume, mismatch

__all__ = ["intersection_volume", "mismatch"]
