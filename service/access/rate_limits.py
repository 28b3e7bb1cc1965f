"""Token buckets: a rate limit per client, in bounded memory."""

from __future__ import annotations

import time
from collections import OrderedDict
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["Allowance", "TokenBuckets"]

_MOST_CLIENTS = 50_000
"""Number of clients in memory, about 10 MB. The client not seen for longest is forgotten."""


@dataclass(frozen=True)
class Allowance:
    """Result of taking a token.

    `remaining` is the number of requests that the client may now send at once, and `seconds` the
    time until one more is allowed.
    """

    granted: bool
    remaining: int
    seconds: float


class TokenBuckets:
    """One bucket of tokens per client; a request takes one token.

    A bucket holds `burst` tokens and gains `rate` tokens per second. `clock` is monotonic, in
    seconds.
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
        """Take one of a client's tokens, if there is one."""
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
