"""Names of clients, for limits: the name of the key, or the address."""

from __future__ import annotations

import ipaddress
from functools import lru_cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from starlette.types import Scope

__all__ = ["client_of", "network"]


def client_of(scope: Scope) -> str:
    """Return the name of a request's client: the name of its key, else its address."""
    name: str | None = scope.get("gamut_client")
    if name is None:
        # Not behind `Access`, which is installed only if something is limited.
        host = scope["client"][0] if scope.get("client") else ""
        name = f"address {network(host)}"
    return name


@lru_cache(maxsize=4096)
def network(host: str) -> str:
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
