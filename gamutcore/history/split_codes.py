"""What a history file keeps of each split: what its writer and its reader have in common.

A group of splits is one stream of bits. Of each split it tells the parent, where its ring is cut,
where the parent and the new slot go, and which neighbours move with them; places are small
differences from what the ring lets one expect (`gamutcore.history.replay`). Both directions replay
the history, so nothing is stored that the level before the split shows.
"""

from __future__ import annotations

import numpy as np

from gamutcore.history.bit_codes import Contexts
from gamutcore.history.replay import CLASSES

__all__ = [
    "ADDED_ALONG",
    "ADDED_OFF",
    "KEPT",
    "LARGEST_COORDINATE",
    "MINIMUM_SPLIT_BITS",
    "PARENT_ALONG",
    "PARENT_OFF",
    "SHIFTED_ALONG",
    "SHIFTED_OFF",
    "first_contexts",
]

LARGEST_COORDINATE = 2**24
"""Steps: whole numbers up to this are exact in float32."""

MINIMUM_SPLIT_BITS = 10
"""The parent, one of four slots or more, takes two bits, each of the two places where its ring is
cut one, and each of six differences one."""

KINDS = 7

KEPT, PARENT_ALONG, PARENT_OFF, ADDED_ALONG, ADDED_OFF, SHIFTED_ALONG, SHIFTED_OFF = (
    CLASSES * kind for kind in range(KINDS)
)
"""First context of each kind of number: faces that the parent keeps, then differences of places
along the plane of the ring and off it."""


def first_contexts() -> Contexts:
    """Return the contexts as they are at the beginning of a file: a guess for each length class.

    Returns
    -------
    Contexts
    """
    total = np.tile(2 ** np.arange(CLASSES, dtype=np.int64) // 2, KINDS)
    return Contexts(total, np.ones(KINDS * CLASSES, np.int64))
