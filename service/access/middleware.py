"""Who may do what, and how often: API keys, their scopes, and rate limits.

The layer is only there where something is limited. What lives without a key: probes, the pages for
people and the OpenAPI document. Where reading needs a key, no shared cache may keep what is read.
"""

from __future__ import annotations

import ipaddress
import math
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

from service.access.api_keys import READ, WRITE, ApiKeys
from service.access.rate_limits import Allowance, TokenBuckets
from service.problems.problem import Problem, problem_response

if TYPE_CHECKING:
    from starlette.types import ASGIApp, Message, Receive, Scope, Send

    from service.settings import Settings

__all__ = ["Access", "AccessRules", "OpenToAllError", "is_loopback"]

_OPEN = frozenset({"/", "/livez", "/readyz", "/docs", "/openapi.json", "/problems"})
"""What needs no key and is not counted."""

_OPEN_PREFIXES = ("/problems/", "/docs/")

_ANONYMOUS = {
    "none": frozenset[str](),
    "read": frozenset({READ}),
    "all": frozenset({READ, WRITE}),
}

_BEARER = b"bearer "


class OpenToAllError(ValueError):
    """The service would be open to everybody who reaches its address, and nobody said so."""


@dataclass(frozen=True)
class AccessRules:
    """What the settings say.

    Attributes
    ----------
    keys : ApiKeys
    anonymous : frozenset of str
        Scopes of requests without a key.
    requests, builds : TokenBuckets or None
        Limits of all requests and of those that build; None for no limit.
    """

    keys: ApiKeys
    anonymous: frozenset[str]
    requests: TokenBuckets | None
    builds: TokenBuckets | None

    @classmethod
    def of(cls, settings: Settings) -> AccessRules:
        """Return the rules of settings.

        Raises
        ------
        OpenToAllError
            Not only this machine reaches the service, there are no keys, and it is not stated that
            none are wanted.
        """
        keys = ApiKeys(settings.api_keys)
        anonymous = settings.allow_anonymous
        if anonymous == "auto":
            if not keys and not is_loopback(settings.host):
                message = (
                    f"{settings.host} is not a loopback address, and there are no API keys: set "
                    "GAMUT_API_KEYS to what `gamut key NAME` prints, or GAMUT_ALLOW_ANONYMOUS=all "
                    "if everybody who reaches this address may build and delete"
                )
                raise OpenToAllError(message)
            anonymous = "none" if keys else "all"
        requests = builds = None
        if settings.rate_limit:
            requests = TokenBuckets(settings.rate_limit, settings.rate_burst)
        if settings.build_rate_limit:
            builds = TokenBuckets(settings.build_rate_limit / 60.0, settings.build_rate_burst)
        return cls(keys, _ANONYMOUS[anonymous], requests, builds)

    @property
    def limiting(self) -> bool:
        """Whether anything is limited at all."""
        # Buckets that nobody has come to yet are empty, and so would be false.
        limits = self.requests is not None or self.builds is not None
        return limits or bool(self.keys) or WRITE not in self.anonymous


def is_loopback(host: str) -> bool:
    """Whether an address to listen on can only be reached from this machine."""
    try:
        return ipaddress.ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return host == "localhost"


class Access:
    """ASGI layer that lets requests pass that may.

    Parameters
    ----------
    app : ASGI app
    rules : AccessRules
    """

    def __init__(self, app: ASGIApp, rules: AccessRules) -> None:
        self.app = app
        self.rules = rules
        self._private = READ not in rules.anonymous

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass the request on, or answer what is missing."""
        path = scope.get("path", "")
        if scope["type"] != "http" or path in _OPEN or path.startswith(_OPEN_PREFIXES):
            await self.app(scope, receive, send)
            return
        client, scopes, problem = self._client(scope)
        counted: list[tuple[bytes, bytes]] = []
        if problem is None:
            needed = READ if scope["method"] in {"GET", "OPTIONS"} else WRITE
            if needed not in scopes:
                problem = self._missing(needed, anonymous=client.startswith("address "))
        if problem is None:
            problem, counted = self._counted(scope, client)

        async def send_with_limits(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = [*message["headers"], *counted]
                message["headers"] = _private(headers) if self._private else headers
            await send(message)

        if problem is None:
            await self.app(scope, receive, send_with_limits)
        else:
            await problem_response(problem)(scope, receive, send_with_limits)

    def _client(self, scope: Scope) -> tuple[str, frozenset[str], Problem | None]:
        """Return who asks, what it may do, and what is wrong with its key."""
        if sum(name == b"authorization" for name, _ in scope["headers"]) > 1:
            # RFC 9110, 5.3: it is no list. Whoever is in between may have believed another one.
            detail = "There is more than one header field Authorization."
            problem = Problem("bad-request", detail, {"header": "Authorization"}, "Send one.")
            return "", frozenset(), problem
        given = _shown_key(scope)
        if given is None:
            host = scope["client"][0] if scope.get("client") else ""
            return f"address {_network(host)}", self.rules.anonymous, None
        key = self.rules.keys.found(given)
        if key is None:
            challenge = {"WWW-Authenticate": 'Bearer realm="gamut", error="invalid_token"'}
            detail = "The API key is none of this service's."
            problem = Problem("api-key-required", detail, headers=challenge)
            return "", frozenset(), problem
        return f"key {key.name}", key.scopes, None

    def _missing(self, needed: str, *, anonymous: bool) -> Problem:
        if anonymous:
            challenge = {"WWW-Authenticate": f'Bearer realm="gamut", scope="{needed}"'}
            detail = f"This needs an API key with the scope {needed}."
            return Problem("api-key-required", detail, {"scope": needed}, headers=challenge)
        challenge = {
            "WWW-Authenticate": f'Bearer realm="gamut", error="insufficient_scope", '
            f'scope="{needed}"'
        }
        detail = f"The API key does not have the scope {needed}."
        return Problem("scope-missing", detail, {"scope": needed}, headers=challenge)

    def _counted(
        self, scope: Scope, client: str
    ) -> tuple[Problem | None, list[tuple[bytes, bytes]]]:
        """Count a request; the header fields say what is left."""
        limits = [("requests", self.rules.requests)]
        if scope["method"] == "POST":
            limits.append(("builds", self.rules.builds))
        policies, states = [], []
        refused: Problem | None = None
        for name, buckets in limits:
            if buckets is None:
                continue
            left = buckets.take(client)
            window = math.ceil(buckets.burst / buckets.rate)
            policies.append(f'"{name}";q={buckets.burst};w={window}')
            states.append(f'"{name}";r={left.remaining};t={math.ceil(left.seconds)}')
            if not left.granted:
                refused = _too_often(name, buckets, left)
                break
        if not policies:
            return None, []
        fields = [
            (b"ratelimit-policy", ", ".join(policies).encode()),
            (b"ratelimit", ", ".join(states).encode()),
        ]
        return refused, fields


def _too_often(name: str, buckets: TokenBuckets, left: Allowance) -> Problem:
    detail = f"There were more than {buckets.burst} {name} at once, and {buckets.rate:g} a second."
    wait = {"Retry-After": str(max(1, math.ceil(left.seconds)))}
    return Problem("rate-limited", detail, {"limit": name}, headers=wait)


def _shown_key(scope: Scope) -> bytes | None:
    """Return the key in a request's header fields; never one in its address, which is logged."""
    shown = None
    for name, value in scope["headers"]:
        if name == b"authorization" and value[: len(_BEARER)].lower() == _BEARER:
            bearer: bytes = value[len(_BEARER) :].strip()
            return bearer
        if name == b"x-api-key":
            shown = value.strip()
    return shown


@lru_cache(maxsize=4096)
def _network(host: str) -> str:
    """Return what counts as one address: of IPv6 the half that a site is given as a whole."""
    try:
        address = ipaddress.ip_address(host)
    except ValueError:
        return host
    if isinstance(address, ipaddress.IPv4Address):
        return host
    if address.ipv4_mapped is not None:
        return str(address.ipv4_mapped)
    return str(ipaddress.IPv6Network((int(address) >> 64 << 64, 64)))


def _private(headers: list[tuple[bytes, bytes]]) -> list[tuple[bytes, bytes]]:
    return [
        (name, value.replace(b"public", b"private", 1) if name == b"cache-control" else value)
        for name, value in headers
    ]
