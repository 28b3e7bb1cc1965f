"""Access control: API keys with scopes, and rate limits.

The middleware is installed only if something is limited. Probes, HTML pages and the OpenAPI
document need no key. If reading needs a key, shared caches must not store the answers.
"""

from __future__ import annotations

import math
import re
import time
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING

from service.access.api_keys import BUILD, READ, WRITE, ApiKey, ApiKeys
from service.access.clients import client_of
from service.access.rate_limits import Allowance, TokenBuckets
from service.problems.problem import Problem, problem_response

if TYPE_CHECKING:
    from collections.abc import Callable

    from starlette.types import ASGIApp, Message, Receive, Scope, Send

__all__ = [
    "ANONYMOUS_SCOPES",
    "Access",
    "AccessRules",
    "OpenToAllError",
    "client_key",
]

_OPEN = frozenset({"/", "/livez", "/readyz", "/docs", "/openapi.json", "/problems", "/view"})
"""Paths that need no key and are not counted."""

_OPEN_PREFIXES = ("/problems/", "/docs/", "/view/")

ANONYMOUS_SCOPES = {
    "none": frozenset[str](),
    "read": frozenset({READ}),
    "all": frozenset({READ, WRITE}),
}
"""Scopes of requests without a key, by the value of the setting."""

_BEARER = b"bearer "

_STATE = "api_key"
"""Name of the key in the state of a request. Outer middleware sees the state of inner scopes."""


class OpenToAllError(ValueError):
    """Everybody could use the service, and the settings do not say that this is intended."""


@dataclass(frozen=True)
class AccessRules:
    """Keys, anonymous scopes and limits.

    `requests` limits all requests, `builds` those that build; None is no limit. `clock` gives
    seconds since 1970, for the expiry of keys.
    """

    keys: ApiKeys
    anonymous: frozenset[str]
    requests: TokenBuckets | None
    builds: TokenBuckets | None
    clock: Callable[[], float] = field(default=time.time)

    @property
    def limiting(self) -> bool:
        """Whether anything is limited."""
        # Buckets without clients are empty and therefore false.
        limits = self.requests is not None or self.builds is not None
        return limits or bool(self.keys) or WRITE not in self.anonymous


def client_key(scope: Scope) -> ApiKey | None:
    """Return the valid key of a request that passed `Access`; None without a key."""
    key: ApiKey | None = scope.get("state", {}).get(_STATE)
    return key


class Access:
    """ASGI middleware that checks keys and rate limits.

    `reading` matches the paths of operations that only read, although their method is POST.
    """

    def __init__(
        self, app: ASGIApp, rules: AccessRules, reading: re.Pattern[str] | None = None
    ) -> None:
        self.app = app
        self.rules = rules
        self._reading = reading
        self._private = READ not in rules.anonymous

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass the request on, or answer with the problem."""
        path = scope.get("path", "")
        if scope["type"] != "http" or path in _OPEN or path.startswith(_OPEN_PREFIXES):
            await self.app(scope, receive, send)
            return
        client, scopes, problem = self._client(scope)
        counted: list[tuple[bytes, bytes]] = []
        if problem is None:
            needed = READ if self._reads(scope) else WRITE
            if not _allows(scopes, needed):
                problem = self._missing(needed, anonymous=client.startswith("address "))
        if problem is None:
            problem, counted = self._count(scope, client)

        async def send_with_limits(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = [*message["headers"], *counted]
                message["headers"] = _private(headers) if self._private else headers
            await send(message)

        if problem is None:
            scope["gamut_client"] = client
            earlier = scope.get("refuse_build")
            scope["refuse_build"] = partial(self._refuse_build, client, scopes, earlier)
            await self.app(scope, receive, send_with_limits)
        else:
            await problem_response(problem)(scope, receive, send_with_limits)

    def _reads(self, scope: Scope) -> bool:
        """Return whether a request changes nothing."""
        if scope["method"] in {"GET", "OPTIONS"}:
            return True
        is_query = self._reading is not None and self._reading.match(scope["path"])
        return scope["method"] == "POST" and bool(is_query)

    def _client(self, scope: Scope) -> tuple[str, frozenset[str], Problem | None]:
        """Return the client's name and scopes, and the problem with its key if there is one."""
        if sum(name == b"authorization" for name, _ in scope["headers"]) > 1:
            # The field is not a list (RFC 9110, section 5.3). An intermediary may have read another
            # value.
            detail = "There is more than one Authorization header field."
            problem = Problem(
                "bad-request", detail, {"header": "Authorization"}, "Send exactly one."
            )
            return "", frozenset(), problem
        given = _key_in_headers(scope)
        if given is None:
            return client_of(scope), self.rules.anonymous, None
        key = self.rules.keys.find(given)
        if key is None:
            challenge = {"WWW-Authenticate": 'Bearer realm="gamut", error="invalid_token"'}
            detail = "The API key is not known to this service."
            problem = Problem("api-key-required", detail, headers=challenge)
            return "", frozenset(), problem
        scope.setdefault("state", {})[_STATE] = key
        if key.is_expired(self.rules.clock()):
            challenge = {"WWW-Authenticate": 'Bearer realm="gamut", error="invalid_token"'}
            detail = f"The API key {key.name} expired at {key.expiry}."
            problem = Problem("api-key-required", detail, headers=challenge)
            return "", frozenset(), problem
        return f"key {key.name}", key.scopes, None

    def _missing(self, needed: str, *, anonymous: bool) -> Problem:
        if anonymous:
            challenge = {"WWW-Authenticate": f'Bearer realm="gamut", scope="{needed}"'}
            detail = f"This operation needs an API key with the scope {needed}."
            return Problem("api-key-required", detail, {"scope": needed}, headers=challenge)
        challenge = {
            "WWW-Authenticate": f'Bearer realm="gamut", error="insufficient_scope", '
            f'scope="{needed}"'
        }
        detail = f"The API key does not have the scope {needed}."
        return Problem("scope-missing", detail, {"scope": needed}, headers=challenge)

    def _refuse_build(
        self,
        client: str,
        scopes: frozenset[str],
        earlier: Callable[[bool], Problem | None] | None,
        is_write: bool,
    ) -> Problem | None:
        """Count a build that a GET starts; return the problem if the client may not start it."""
        if earlier is not None and (problem := earlier(is_write)) is not None:
            return problem
        if is_write and not _allows(scopes, WRITE):
            return self._missing(WRITE, anonymous=client.startswith("address "))
        if self.rules.builds is None:
            return None
        left = self.rules.builds.take(client)
        return None if left.granted else _too_often("builds", self.rules.builds, left)

    def _count(self, scope: Scope, client: str) -> tuple[Problem | None, list[tuple[bytes, bytes]]]:
        """Count a request. Return the problem, if any, and the rate-limit header fields."""
        limits = [("requests", self.rules.requests)]
        if scope["method"] == "POST" and not self._reads(scope):
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


def _allows(scopes: frozenset[str], needed: str) -> bool:
    """Return whether scopes allow an operation. Routes restrict the changes of ``build`` keys."""
    return needed in scopes or (needed == WRITE and BUILD in scopes)


def _too_often(name: str, buckets: TokenBuckets, left: Allowance) -> Problem:
    detail = f"The limit is {buckets.burst} {name} at once and {buckets.rate:g} per second."
    wait = {"Retry-After": str(max(1, math.ceil(left.seconds)))}
    return Problem("rate-limited", detail, {"limit": name}, headers=wait)


def _key_in_headers(scope: Scope) -> bytes | None:
    """Return the key in a request's header fields. Keys in the address would be logged."""
    shown = None
    for name, value in scope["headers"]:
        if name == b"authorization" and value[: len(_BEARER)].lower() == _BEARER:
            bearer: bytes = value[len(_BEARER) :].strip()
            return bearer
        if name == b"x-api-key":
            shown = value.strip()
    return shown


def _private(headers: list[tuple[bytes, bytes]]) -> list[tuple[bytes, bytes]]:
    return [
        (name, value.replace(b"public", b"private", 1) if name == b"cache-control" else value)
        for name, value in headers
    ]
