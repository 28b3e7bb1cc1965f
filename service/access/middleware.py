"""Access control: names of the service, API keys with scopes, rate limits, and owners of gamuts.

Probes, HTML pages and the OpenAPI document need no key. If reading needs a key, shared caches must
not store the answers. Keys with the scope ``build`` may change what they built themselves.
"""

from __future__ import annotations

import asyncio
import math
import re
import time
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING

from service.access.api_keys import BUILD, READ, WRITE, ApiKey, ApiKeys
from service.access.hosts import follows_link
from service.access.rate_limits import Allowance, TokenBuckets, client_of
from service.problems.problem import Problem, ProblemError, problem_response

if TYPE_CHECKING:
    from collections.abc import Callable

    from fastapi import Request
    from starlette.types import ASGIApp, Message, Receive, Scope, Send

    from service.access.hosts import Hosts
    from service.storage.gamut_store import GamutStore

__all__ = [
    "ANONYMOUS_SCOPES",
    "Access",
    "AccessRules",
    "OpenToAllError",
    "check_owner",
    "claim",
    "client_key",
    "may_change",
]

_OPEN = frozenset(
    {"/", "/status", "/livez", "/readyz", "/docs", "/openapi.json", "/problems", "/view"}
)
"""Paths that need no key and are not counted."""

_OPEN_PREFIXES = ("/problems/", "/docs/", "/view/")

ANONYMOUS_SCOPES = {
    "none": frozenset[str](),
    "read": frozenset({READ}),
    "all": frozenset({READ, WRITE}),
}
"""Scopes of requests without a key, by the value of the setting."""

WRONG_KEY_RATE, WRONG_KEY_BURST = 1.0, 20
"""Requests per second, and at once, with wrong keys from one address. A program with an expired key
that tries again after the time in ``Retry-After`` is told the reason."""

_BEARER = b"bearer "

_STATE = "api_key"
"""Name of the key in the state of a request. Outer middleware sees the state of inner scopes."""


class OpenToAllError(ValueError):
    """Everybody could use the service, and the settings do not say that this is intended."""


@dataclass(frozen=True)
class AccessRules:
    """Keys, anonymous scopes and limits.

    `requests` limits all requests, `builds` those that build; None is no limit. `wrong_keys` limits
    the requests of an address whose keys are unknown or expired; a valid key is not affected.
    `clock` gives seconds since 1970, for the expiry of keys.
    """

    keys: ApiKeys
    anonymous: frozenset[str]
    requests: TokenBuckets | None
    builds: TokenBuckets | None
    clock: Callable[[], float] = field(default=time.time)
    wrong_keys: TokenBuckets = field(
        default_factory=lambda: TokenBuckets(WRONG_KEY_RATE, WRONG_KEY_BURST)
    )

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
    """ASGI middleware that checks names of the service, origins, keys and rate limits.

    `reading` matches the paths of operations that only read, although their method is POST.
    """

    def __init__(
        self, app: ASGIApp, hosts: Hosts, rules: AccessRules, reading: re.Pattern[str]
    ) -> None:
        self.app = app
        self._hosts = hosts
        self.rules = rules
        self._reading = reading
        self._limiting = rules.limiting
        self._private = READ not in rules.anonymous

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass the request on, or answer with the problem."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        limited = self._limiting and not _is_open(scope["path"])
        counted: list[tuple[bytes, bytes]] = []

        async def send_with_limits(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = [*message["headers"], *counted]
                message["headers"] = _private(headers) if self._private else headers
            await send(message)

        answer = self.app
        try:
            self._check(scope, counted, limited=limited)
        except ProblemError as error:
            answer = problem_response(error.problem)
        await answer(scope, receive, send_with_limits if limited else send)

    def _check(self, scope: Scope, counted: list[tuple[bytes, bytes]], *, limited: bool) -> None:
        """Raise a problem if the client may not send this request."""
        self._hosts.check_name(scope)
        foreign = self._hosts.foreign(scope)
        if foreign is not None:
            # The browser hides an answer from the page, but the work would be done.
            if not (_is_open(scope["path"]) or follows_link(scope)):
                raise ProblemError(foreign)
            # With options, an address of a reference gamut builds another gamut.
            scope["refuse_build"] = lambda is_write: foreign if is_write else None
        if limited:
            client, scopes = self._client(scope)
            needed = READ if self._reads(scope) else WRITE
            if not _allows(scopes, needed):
                raise _missing(needed, client)
            self._count(scope, client, counted)
            scope["gamut_client"] = client
            scope["refuse_build"] = partial(self._refuse_build, client, scopes, foreign)

    def _reads(self, scope: Scope) -> bool:
        """Return whether a request changes nothing."""
        method: str = scope["method"]
        if method in {"GET", "OPTIONS"}:
            return True
        return method == "POST" and self._reading.match(scope["path"]) is not None

    def _client(self, scope: Scope) -> tuple[str, frozenset[str]]:
        """Return the client's name and scopes; raise the problem with its key if there is one."""
        if sum(name == b"authorization" for name, _ in scope["headers"]) > 1:
            # The field is not a list (RFC 9110, section 5.3). An intermediary may have read another
            # value.
            detail = "There is more than one Authorization header field."
            where = {"header": "Authorization"}
            raise ProblemError(Problem("bad-request", detail, where, "Send exactly one."))
        text = _key_in_headers(scope)
        if text is None:
            return client_of(scope), self.rules.anonymous
        key = self.rules.keys.find(text)
        if key is not None:
            scope.setdefault("state", {})[_STATE] = key
            if not key.is_expired(self.rules.clock()):
                return f"key {key.name}", key.scopes
            detail = f"The API key {key.name} expired at {key.expiry}."
        else:
            detail = "The API key is not known to this service."
        left = self.rules.wrong_keys.take(client_of(scope))
        if not left.granted:
            raise ProblemError(_too_often("wrong keys", self.rules.wrong_keys, left))
        challenge = {"WWW-Authenticate": 'Bearer realm="gamut", error="invalid_token"'}
        raise ProblemError(Problem("api-key-required", detail, headers=challenge))

    def _refuse_build(
        self, client: str, scopes: frozenset[str], foreign: Problem | None, is_write: bool
    ) -> Problem | None:
        """Count a build that a GET starts; return the problem if the client may not start it."""
        if is_write and foreign is not None:
            return foreign
        if is_write and not _allows(scopes, WRITE):
            return _missing(WRITE, client).problem
        if self.rules.builds is None:
            return None
        left = self.rules.builds.take(client)
        return None if left.granted else _too_often("builds", self.rules.builds, left)

    def _count(self, scope: Scope, client: str, fields: list[tuple[bytes, bytes]]) -> None:
        """Count a request and add its rate-limit header fields; raise if it is one too many."""
        limits = [("requests", self.rules.requests)]
        if scope["method"] == "POST" and not self._reads(scope):
            limits.append(("builds", self.rules.builds))
        policies, states = [], []
        refused: Problem | None = None
        for name, buckets in limits:
            if buckets is None or refused is not None:
                continue
            left = buckets.take(client)
            window = math.ceil(buckets.burst / buckets.rate)
            policies.append(f'"{name}";q={buckets.burst};w={window}')
            states.append(f'"{name}";r={left.remaining};t={math.ceil(left.seconds)}')
            if not left.granted:
                refused = _too_often(name, buckets, left)
        if policies:
            fields.append((b"ratelimit-policy", ", ".join(policies).encode()))
            fields.append((b"ratelimit", ", ".join(states).encode()))
        if refused is not None:
            raise ProblemError(refused)


def _missing(needed: str, client: str) -> ProblemError:
    """Return the error of a client without a scope."""
    challenge, code = 'Bearer realm="gamut"', "api-key-required"
    detail = f"This operation needs an API key with the scope {needed}."
    if not client.startswith("address "):
        challenge, code = f'{challenge}, error="insufficient_scope"', "scope-missing"
        detail = f"The API key does not have the scope {needed}."
    headers = {"WWW-Authenticate": f'{challenge}, scope="{needed}"'}
    return ProblemError(Problem(code, detail, {"scope": needed}, headers=headers))


def _is_open(path: str) -> bool:
    return path in _OPEN or path.startswith(_OPEN_PREFIXES)


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


async def claim(request: Request, store: GamutStore, gamut_id: str) -> None:
    """Make the key of a request the owner of a gamut that is being built, if there is no owner."""
    key = client_key(request.scope)
    if key is not None:
        await asyncio.to_thread(store.owners.claim, gamut_id, key.name)


async def may_change(request: Request, store: GamutStore, gamut_id: str) -> bool:
    """Return whether the client may name, delete or cancel a gamut."""
    key = client_key(request.scope)
    if key is None or WRITE in key.scopes:
        return True
    return await asyncio.to_thread(store.owners.read, gamut_id) == key.name


async def check_owner(request: Request, store: GamutStore, gamut_id: str) -> None:
    """Raise the problem ``built-by-another`` unless the client may change a gamut."""
    if not await may_change(request, store, gamut_id):
        detail = "The key has the scope build, and another client built the gamut."
        raise ProblemError(Problem("built-by-another", detail, {"scope": WRITE}))
