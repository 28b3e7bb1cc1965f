"""Token buckets: how often each client may ask, in memory that no number of clients exhausts."""

from __future__ import annotations

import time
from collections import OrderedDict
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["Allowance", "TokenBuckets"]

_MOST_CLIENTS = 50_000
"""Clients that are remembered, those seen last; about 10 MB. Whoever is forgotten begins anew."""


@dataclass(frozen=True)
class Allowance:
    """What a client has left.

    Attributes
    ----------
    granted : bool
        Whether this request is within the limit.
    remaining : int
        Requests that it may send at once from now on.
    seconds : float
        Until it may send one more than that.
    """

    granted: bool
    remaining: int
    seconds: float


class TokenBuckets:
    """A bucket of tokens for every client; a request takes one.

    Parameters
    ----------
    rate : float
        Tokens per second that come back.
    burst : int
        Tokens that a bucket holds.
    clock : callable
        Seconds that never go back.
    """

    def __init__(
        self, rate: float, burst: int, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self.rate = rate
        self.burst = burst
        self._clock = clock
        self._buckets: OrderedDict[str, tuple[float, float]] = OrderedDict()

    def __len__(self) -> int:
        return len(self._buckets)

    def take(self, client: str) -> Allowance:
        """Take a token of a client's, if it has one."""
        now = self._clock()
        tokens, then = self._buckets.pop(client, (float(self.burst), now))
        tokens = min(tokens + (now - then) * self.rate, float(self.burst))
        granted = tokens >= 1.0
        if granted:
            tokens -= 1.0
        self._buckets[client] = (tokens, now)
        if len(self._buckets) > _MOST_CLIENTS:
            self._buckets.popitem(last=False)
        remaining = int(tokens)
        return Allowance(granted, remaining, (remaining + 1 - tokens) / self.rate)
