"""API keys, which the service stores as digests only.

A key is ``gamut_NAME_SECRET``. Its entry is ``NAME:SCOPES:DIGEST``, or with ``:EXPIRY`` at the end.
The digest is the SHA-256 of the whole key. The secret has 256 random bits, so a slow hash is not
needed. The name is public and selects the digest, which is compared in constant time. Entries are
in a setting and in a file, which can be read again. See ``docs/decisions/api-keys.md``.
"""

from __future__ import annotations

import hashlib
import hmac
import re
import secrets
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

__all__ = ["BUILD", "READ", "SCOPES", "WRITE", "ApiKey", "ApiKeys", "KeyFileError", "new_key"]

READ = "read"
BUILD = "build"
WRITE = "write"
SCOPES = (READ, BUILD, WRITE)
"""``read``: list, describe and download. ``build``: build, and delete and name what the key built.
``write``: build, and delete and name everything."""

_NAME = re.compile(r"[a-z0-9][a-z0-9-]{0,31}\Z")
_DIGEST = re.compile(r"[0-9a-f]{64}\Z")
_EXPIRY = re.compile(r"[0-9]{4}-[0-9]{2}-[0-9]{2}(?:T[0-9]{2}:[0-9]{2}(?::[0-9]{2})?Z)?\Z")
_KEY = re.compile(rb"gamut_([a-z0-9-]{1,32})_[A-Za-z0-9_-]{43}\Z")

_NOBODY = "0" * 64
"""Digest that is compared for unknown names, so that the time is the same."""


class KeyFileError(ValueError):
    """The file of the API keys cannot be read. The message names the file and the fault."""


@dataclass(frozen=True)
class ApiKey:
    """A key as the service knows it: its public name, scopes, and SHA-256 in hexadecimal.

    `expiry` is the time from which it is invalid, RFC 3339 in UTC; a date is its beginning.
    """

    name: str
    scopes: frozenset[str]
    digest: str
    expiry: str = ""

    @property
    def entry(self) -> str:
        """The entry for the setting."""
        entry = f"{self.name}:{'+'.join(sorted(self.scopes))}:{self.digest}"
        return f"{entry}:{self.expiry}" if self.expiry else entry

    def is_expired(self, now: float) -> bool:
        """Return whether the key is invalid at a time in seconds since 1970."""
        return bool(self.expiry) and now >= _seconds(self.expiry)


class ApiKeys:
    """All keys of a service, from the entries in a setting and in a file.

    Commas or spaces separate the entries in `text`; the file has one entry per line, which a
    comment after ``#`` may end. Raise ValueError (`KeyFileError` for the file) if an entry is
    malformed or a name recurs.
    """

    def __init__(self, text: str, file: Path | None = None) -> None:
        self._file = file
        self._of_setting: dict[str, ApiKey] = {}
        for number, entry in enumerate(text.replace(",", " ").split(), 1):
            _add(_parse_entry(entry, f"entry {number}"), self._of_setting)
        self._keys = self._of_setting
        if file is not None:
            self.read_file()

    def __len__(self) -> int:
        return len(self._keys)

    def __bool__(self) -> bool:
        """Whether clients need keys. A file may be empty for now."""
        return bool(self._keys) or self._file is not None

    def read_file(self) -> None:
        """Read the file again. If it has a fault, raise `KeyFileError`; the present keys stay."""
        if self._file is None:
            return
        keys = dict(self._of_setting)
        try:
            lines = self._file.read_text("utf-8").splitlines()
            for number, line in enumerate(lines, 1):
                if entry := line.partition("#")[0].strip():
                    _add(_parse_entry(entry, f"line {number}"), keys)
        except OSError as error:
            message = f"{self._file}: {error.strerror}"
            raise KeyFileError(message) from error
        except UnicodeDecodeError:
            message = f"{self._file} is not UTF-8"
            raise KeyFileError(message) from None
        except ValueError as error:
            message = f"{self._file}: {error}"
            raise KeyFileError(message) from error
        self._keys = keys

    def find(self, key: bytes) -> ApiKey | None:
        """Return the entry of a key that a client presents; None if it is not known.

        The key may have expired.
        """
        match = _KEY.match(key)
        name = match[1].decode("ascii") if match else ""
        known = self._keys.get(name)
        digest = hashlib.sha256(key).hexdigest()
        same = hmac.compare_digest(digest, _NOBODY if known is None else known.digest)
        return known if same else None


def new_key(name: str, scopes: frozenset[str], expiry: str = "") -> tuple[str, ApiKey]:
    """Return a new key and its entry. The key is stored nowhere.

    Raise ValueError if the name or the expiry is malformed, or if there is no scope.
    """
    key = f"gamut_{name}_{secrets.token_urlsafe(32)}"
    known = ApiKey(name, scopes, hashlib.sha256(key.encode()).hexdigest(), expiry)
    return key, _parse_entry(known.entry, "entry 1")


def _add(key: ApiKey, keys: dict[str, ApiKey]) -> None:
    if key.name in keys:
        message = f"two keys have the name {key.name}"
        raise ValueError(message)
    keys[key.name] = key


def _parse_entry(entry: str, place: str) -> ApiKey:
    # The message does not repeat the entry, which may be a key pasted by mistake. An expiry
    # contains colons.
    name, scopes, digest, expiry = (*entry.split(":", 3), *[""] * 4)[:4]
    wanted = frozenset(scopes.split("+"))
    if not _NAME.match(name):
        fault = "the name is not of 1 to 32 lower-case letters, digits and hyphens"
    elif not wanted <= set(SCOPES):
        fault = "the scopes are not read, build or write, joined by +"
    elif not _DIGEST.match(digest):
        fault = "the digest is not of 64 hexadecimal digits in lower case"
    elif entry.count(":") > 2 and not _is_expiry(expiry):
        fault = "the expiry is not a date or a time in UTC such as 2027-01-31 or 2027-01-31T12:00Z"
    else:
        return ApiKey(name, wanted, digest, expiry)
    message = f"{place} is not NAME:SCOPES:SHA256, as `gamut key` prints it: {fault}"
    raise ValueError(message)


def _is_expiry(text: str) -> bool:
    try:
        return _EXPIRY.match(text) is not None and _seconds(text) > 0
    except ValueError:
        return False


def _seconds(expiry: str) -> float:
    """Return a time as seconds since 1970."""
    return datetime.fromisoformat(expiry).replace(tzinfo=UTC).timestamp()
