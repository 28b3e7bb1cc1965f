"""Amounts that clients share, such as bytes of bodies or rows of queries."""

from __future__ import annotations

from collections import Counter
from enum import Enum

__all__ = ["Refused", "SharedAmount"]


class Refused(Enum):
    """Why a client cannot have more of an amount."""

    FULL = "full"
    SHARE = "share"


class SharedAmount:
    """An amount that clients take parts of. Belongs to the event loop's thread.

    A client may exceed its share as long as a share remains for others. So a single client can use
    most of the amount, and another client always finds some. What is taken alone always fits.

    Parameters
    ----------
    most : int
        Largest amount that is taken at a time.
    share : float
        The part of it that belongs to one client if others compete, from 0 to 1.

    Attributes
    ----------
    used : int
        The amount taken.
    """

    def __init__(self, most: int, share: float) -> None:
        self.most = most
        self.used = 0
        self._share = int(most * share)
        self._of: Counter[str] = Counter()

    def refusal(self, client: str, amount: int, own: int = 0) -> Refused | None:
        """Return why an amount cannot be taken; None if it can.

        `own` is what the same request has taken already.
        """
        if self.used == own:
            return None
        after = self.used + amount
        exceeds_share = self._of[client] + amount > self._share
        if exceeds_share and after > self.most - self._share:
            return Refused.SHARE
        return Refused.FULL if after > self.most else None

    def take(self, client: str, amount: int) -> None:
        """Take an amount, or give it back if it is negative."""
        self.used += amount
        self._of[client] += amount
        if not self._of[client]:
            del self._of[client]
