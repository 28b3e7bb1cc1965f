"""API keys, which the service stores as digests only.

A key is ``gamut_NAME_SECRET``. The setting holds ``NAME:SCOPES:DIGEST``, where the digest is the
SHA-256 of the whole key. The secret has 256 random bits, so a slow hash is not needed. The name is
public and selects the digest, which is compared in constant time. See
``docs/decisions/api-keys.md``.
"""

from __future__ import annotations

import hashlib
import hmac
import re
import secrets
from dataclasses import dataclass

__all__ = ["READ", "SCOPES", "WRITE", "ApiKey", "ApiKeys", "new_key"]

READ = "read"
WRITE = "write"
SCOPES = (READ, WRITE)
"""``read``: list, describe and download. ``write``: build and delete."""

_NAME = re.compile(r"[a-z0-9][a-z0-9-]{0,31}\Z")
_DIGEST = re.compile(r"[0-9a-f]{64}\Z")
_KEY = re.compile(rb"gamut_([a-z0-9-]{1,32})_[A-Za-z0-9_-]{43}\Z")

_NOBODY = "0" * 64
"""Digest that is compared for unknown names, so that the time is the same."""


@dataclass(frozen=True)
class ApiKey:
    """A key as the service knows it.

    Attributes
    ----------
    name : str
        Public name, used in settings and limits.
    scopes : frozenset of str
        Of `SCOPES`.
    digest : str
        SHA-256 of the key, hexadecimal.
    """

    name: str
    scopes: frozenset[str]
    digest: str

    @property
    def entry(self) -> str:
        """The entry for the setting."""
        return f"{self.name}:{'+'.join(sorted(self.scopes))}:{self.digest}"


class ApiKeys:
    """All keys of a service.

    Parameters
    ----------
    text : str
        Entries ``NAME:SCOPES:DIGEST`` separated by commas or spaces; scopes are joined by ``+``.

    Raises
    ------
    ValueError
        An entry is malformed, or a name occurs twice.
    """

    def __init__(self, text: str) -> None:
        self._keys: dict[str, ApiKey] = {}
        for number, entry in enumerate(text.replace(",", " ").split(), 1):
            key = _parse_entry(entry, number)
            if key.name in self._keys:
                message = f"two keys have the name {key.name}"
                raise ValueError(message)
            self._keys[key.name] = key

    def __len__(self) -> int:
        return len(self._keys)

    def find(self, key: bytes) -> ApiKey | None:
        """Return the entry of a key that a client presents; None if it is not valid."""
        match = _KEY.match(key)
        name = match[1].decode("ascii") if match else ""
        known = self._keys.get(name)
        digest = hashlib.sha256(key).hexdigest()
        same = hmac.compare_digest(digest, _NOBODY if known is None else known.digest)
        return known if same else None


def new_key(name: str, scopes: frozenset[str]) -> tuple[str, ApiKey]:
    """Return a new key and its entry. The key is stored nowhere.

    Raises
    ------
    ValueError
        The name is malformed, or there is no scope.
    """
    key = f"gamut_{name}_{secrets.token_urlsafe(32)}"
    known = ApiKey(name, scopes, hashlib.sha256(key.encode()).hexdigest())
    return key, _parse_entry(known.entry, 1)


def _parse_entry(entry: str, number: int) -> ApiKey:
    # The message does not repeat the entry, which may be a key pasted by mistake.
    name, _, rest = entry.partition(":")
    scopes, _, digest = rest.partition(":")
    wanted = frozenset(scopes.split("+"))
    if not _NAME.match(name):
        fault = "the name is not of 1 to 32 lower-case letters, digits and hyphens"
    elif not wanted <= set(SCOPES):
        fault = "the scopes are not read, write or read+write"
    elif not _DIGEST.match(digest):
        fault = "the digest is not of 64 hexadecimal digits in lower case"
    else:
        return ApiKey(name, wanted, digest)
    message = f"entry {number} is not NAME:SCOPES:SHA256, as `gamut key` prints it: {fault}"
    raise ValueError(message)
