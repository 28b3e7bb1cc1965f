"""Names of the service, and pages of other origins.

A service without keys on a loopback address trusts everybody who reaches it. A browser reaches it
on behalf of any page. The page's own name may resolve to 127.0.0.1 (DNS rebinding), or the page may
send a request across sites. So such a service answers requests for its own names only, and pages of
other origins neither change nor compute anything. See ``docs/decisions/hosts.md``.
"""

from __future__ import annotations

import ipaddress
import re
from typing import TYPE_CHECKING

from service.problems.problem import Problem, ProblemError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from starlette.types import Scope

__all__ = ["Hosts", "follows_link", "host_names", "is_loopback"]

_PROBES = frozenset({"/livez", "/readyz", "/metrics"})
"""Paths of balancers and monitors, which address the service by any name."""

_FIELD = re.compile(r"(?P<host>\[[0-9a-f:.]+\]|[a-z0-9._~%!$&'()*+,;=-]*)(?::(?P<port>[0-9]*))?\Z")
"""Value of ``Host`` in lower case (RFC 9110, section 7.2)."""

_NAME = re.compile(r"(?:\*\.)?[a-z0-9._-]+(?::[0-9]+)?\Z|\[[0-9a-f:.]+\](?::[0-9]+)?\Z")

_DEFAULT_PORTS = {"http": "80", "https": "443"}


def host_names(text: str) -> tuple[str, ...]:
    """Return the names in a setting, separated by commas or spaces, in lower case.

    Raise ValueError if an entry is not a name with an optional port.
    """
    names = tuple(text.lower().replace(",", " ").split())
    for name in names:
        if not _NAME.match(name):
            message = (
                f"{name} is not a host. Give a name or an address with an optional port, such as "
                "gamut.example.org:8443 or *.example.org."
            )
            raise ValueError(message)
    return names


def is_loopback(host: str) -> bool:
    """Return whether a listening address is reachable from this machine only."""
    try:
        return ipaddress.ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return host == "localhost"


class Hosts:
    """Checks of ``Host``, ``Origin`` and ``Sec-Fetch-Site``.

    `trusting` tells that everybody who reaches the loopback address may use the service. Pages of
    `origins` may use it.
    """

    def __init__(self, names: Sequence[str], *, trusting: bool, origins: Sequence[str]) -> None:
        self._names = frozenset(names)
        self._checks_names = trusting or bool(names)
        self._trusting = trusting
        self._origins = frozenset(origins)

    def check_name(self, scope: Scope) -> None:
        """Raise a problem if ``Host`` is malformed, or not a name of this service."""
        hosts = [value for name, value in scope["headers"] if name == b"host"]
        if len(hosts) > 1 or (not hosts and scope["http_version"] != "1.0"):
            # RFC 9112, section 3.2.
            count = "more than one" if hosts else "no"
            detail = f"There is {count} Host header field."
            raise ProblemError(
                Problem("bad-request", detail, {"header": "Host"}, "Send exactly one.")
            )
        host = hosts[0].decode("latin-1").lower() if hosts else ""
        parts = _FIELD.match(host)
        if parts is None:
            detail = f"The Host header field is {host[:80]!r}, which is not a host with a port."
            remedy = "Send the host and the port of the address."
            raise ProblemError(Problem("bad-request", detail, {"header": "Host"}, remedy))
        # Clients of HTTP/1.0 may omit the field, browsers never do.
        checked = self._checks_names and hosts and scope["path"] not in _PROBES
        if checked and not self._is_own(parts["host"], host):
            detail = f"The service is not called {host[:80]!r}."
            raise ProblemError(Problem("host-not-allowed", detail, {"header": "Host"}))

    def _is_own(self, name: str, host: str) -> bool:
        """Return whether a name or address without and with its port is one of this service."""
        if is_loopback(name) or not self._names.isdisjoint((name, host)):
            return True
        labels = name.split(".")
        return any(
            f"*.{'.'.join(labels[start:])}{port}" in self._names
            for start in range(1, len(labels))
            for port in {"", host.removeprefix(name)}
        )

    def foreign(self, scope: Scope) -> Problem | None:
        """Return the problem of requests by a page of another origin; None for other requests."""
        if not self._trusting or scope["path"] in _PROBES:
            return None
        fields = dict(scope["headers"])
        host = fields.get(b"host", b"").decode("latin-1").lower()
        origin = fields.get(b"origin", b"").decode("latin-1").lower()
        site = fields.get(b"sec-fetch-site", b"none").decode("latin-1")
        if origin:
            if "*" in self._origins or origin in self._origins or _is_origin_of(origin, host):
                return None
            detail = f"A page of {origin[:80]} may not use this service."
            return Problem("origin-not-allowed", detail, {"header": "Origin"})
        if site in {"none", "same-origin"} or "*" in self._origins:
            return None
        detail = "A page of another origin may not use this service."
        return Problem("origin-not-allowed", detail, {"header": "Sec-Fetch-Site"})


def follows_link(scope: Scope) -> bool:
    """Return whether a person follows a link, or a page of the same site shows a picture.

    Both are GET without ``Origin``, and differ from a page that makes the service work unseen.
    """
    fields = dict(scope["headers"])
    if scope["method"] != "GET" or b"origin" in fields:
        return False
    navigates = fields.get(b"sec-fetch-mode") == b"navigate"
    shown = navigates and fields.get(b"sec-fetch-dest") == b"document"
    return shown or fields.get(b"sec-fetch-site") == b"same-site"


def _is_origin_of(origin: str, host: str) -> bool:
    """Return whether a page of an origin comes from a host. The scheme may be a proxy's."""
    scheme, _, authority = origin.partition("://")
    port = _DEFAULT_PORTS.get(scheme, "")
    return bool(authority) and authority.removesuffix(f":{port}") == host.removesuffix(f":{port}")
