"""Rate limits of clients: their names, and a bucket of tokens for each, in bounded memory."""

from __future__ import annotations

import ipaddress
import time
from collections import OrderedDict
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

    from starlette.types import Scope

__all__ = ["Allowance", "TokenBuckets", "client_of"]

_MOST_CLIENTS = 50_000
"""Number of clients in memory, about 10 MB. The client not seen for longest is forgotten."""


def client_of(scope: Scope) -> str:
    """Return the name of a request's client: the name of its key, else its address."""
    name: str | None = scope.get("gamut_client")
    if name is None:
        # Not behind `Access`, which is installed only if something is limited.
        host = scope["client"][0] if scope.get("client") else ""
        name = f"address {_network(host)}"
    return name


@lru_cache(maxsize=4096)
def _network(host: str) -> str:
    """Return the address that limits count by: the /64 network for IPv6."""
    try:
        address = ipaddress.ip_address(host)
    except ValueError:
        return host
    if isinstance(address, ipaddress.IPv4Address):
        return host
    if address.ipv4_mapped is not None:
        return str(address.ipv4_mapped)
    return str(ipaddress.IPv6Network((int(address) >> 64 << 64, 64)))


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
