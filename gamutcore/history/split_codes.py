"""How a history file describes a split: contexts and bounds that writer and reader share.

A group of splits is one stream of bits. For each split it stores the parent, where the ring of the
parent is cut, the positions of the parent and the new slot, and which neighbours move. Positions
are small differences from a prediction (`gamutcore.history.prediction`). Writer and reader both
replay the history, so nothing is stored that the level before the split shows.
"""

from __future__ import annotations

import numpy as np

from gamutcore.history.bit_codes import Contexts
from gamutcore.history.prediction import CLASSES

__all__ = [
    "ADDED_ALONG",
    "ADDED_OFF",
    "KEPT",
    "LARGEST_COORDINATE",
    "MINIMUM_SPLIT_BITS",
    "MOVED_PER_VERTEX",
    "PARENT_ALONG",
    "PARENT_OFF",
    "SHIFTED_ALONG",
    "SHIFTED_OFF",
    "first_contexts",
]

LARGEST_COORDINATE = 2**24
"""In steps: integers up to this are exact in float32."""

MINIMUM_SPLIT_BITS = 10
"""Two bits for the parent, one of at least four slots; one for each of the two cuts of its ring;
one for each of six differences."""

MOVED_PER_VERTEX = 24
"""Limit of the moved corners ÷ vertices of the full boundary. Real histories move three. Writers
give the smaller part of a ring to the new slot, so each corner moves about log₂ V times at most.
Writers refuse histories beyond the limit."""

KINDS = 7

KEPT, PARENT_ALONG, PARENT_OFF, ADDED_ALONG, ADDED_OFF, SHIFTED_ALONG, SHIFTED_OFF = (
    CLASSES * kind for kind in range(KINDS)
)
"""First context of each kind of number: faces that the parent keeps; then differences of positions
along the plane of the ring and off it."""


def first_contexts() -> Contexts:
    """Return the contexts at the beginning of a file: a guess for each length class."""
    total = np.tile(2 ** np.arange(CLASSES, dtype=np.int64) // 2, KINDS)
    return Contexts(total, np.ones(KINDS * CLASSES, np.int64))
