"""The inputs that gamuts are built from, kept beside them.

An input is durable before a client learns that its job was accepted, so the job survives the
process. Afterwards the input allows a damaged gamut to be built again. A blob has three parts: the
SHA-256 of the next line, a line of JSON, and the data as posted. The JSON has the options and the
SHA-256 of the data.
"""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any, BinaryIO

from service.storage.blobs import BlobDamagedError, BlobNotFoundError, Blobs, StoreUnavailableError
from service.storage.published import input_key
from service.storage.quarantine import Quarantine

__all__ = ["Inputs"]

_CHUNK = 1 << 20

_ATTEMPTS = 3
"""Number of attempts to store an input during concurrent drops."""

_HEAD_LIMIT = 1 << 20
"""Largest line of options in bytes. A few hundred are usual."""


class Inputs:
    """The inputs in a storage; damaged inputs are moved to the quarantine."""

    def __init__(self, blobs: Blobs, quarantine: Quarantine) -> None:
        self._blobs = blobs
        self._quarantine = quarantine

    def keep(self, gamut_id: str, data: bytes, options: dict[str, Any], sha256: str) -> None:
        """Store an input durably. An existing intact input is used instead.

        `sha256` is the hexadecimal digest of the data.
        """
        head = {"options": options, "sha256": sha256}
        line = json.dumps(head, separators=(",", ":")).encode() + b"\n"
        pieces = [hashlib.sha256(line).hexdigest().encode() + b"\n", line, data]
        for _ in range(_ATTEMPTS):
            if self._blobs.create(input_key(gamut_id), pieces) is not None:
                return
            if self._is_intact(gamut_id):
                return
        message = "the input is being stored and dropped at the same time"
        raise StoreUnavailableError(message)

    def path(self, gamut_id: str) -> Path:
        """Return a new scratch file with the data; raises `BlobNotFoundError` if there is none."""
        path = self._blobs.scratch(".input")
        try:
            with path.open("xb") as target:
                self._options(gamut_id, target)
        except BaseException:
            path.unlink(missing_ok=True)
            raise
        return path

    def options(self, gamut_id: str) -> dict[str, Any]:
        """Return the options of an input; raises `BlobNotFoundError` if there is none."""
        return self._options(gamut_id, None)

    def kept(self, gamut_id: str) -> bool:
        """Return whether there is an input."""
        return self.nbytes(gamut_id) > 0

    def nbytes(self, gamut_id: str) -> int:
        """Return the size of an input as stored; 0 if there is none."""
        try:
            return self._blobs.size(input_key(gamut_id))
        except BlobNotFoundError:
            return 0

    def drop(self, gamut_id: str) -> bool:
        """Remove an input; return whether there was one."""
        return self._blobs.delete(input_key(gamut_id))

    def _is_intact(self, gamut_id: str) -> bool:
        try:
            self._options(gamut_id, None)
        except BlobNotFoundError:
            return False
        return True

    def _options(self, gamut_id: str, target: BinaryIO | None) -> dict[str, Any]:
        """Return the options and copy the data; move a damaged input to the quarantine."""
        key = input_key(gamut_id)
        for last in (False, True):
            with self._blobs.stream(key) as source:
                try:
                    return _copy_verified(source, target)
                except BlobDamagedError as error:
                    # It may have been damaged in transit only, so it is read twice.
                    if last:
                        self._quarantine.put([key], f"damaged input: {error}")
            if target is not None:
                target.seek(0)
                target.truncate()
        raise BlobNotFoundError(key)


def _copy_verified(source: BinaryIO, target: BinaryIO | None) -> dict[str, Any]:
    """Return the options of an input, and copy its data to `target` if there is one.

    Raise `BlobDamagedError` if the content does not match its digests.
    """
    expected = source.read(65)
    line = source.readline(_HEAD_LIMIT)
    digest = hashlib.sha256(line)
    head: dict[str, Any] = {}
    if digest.hexdigest().encode() + b"\n" == expected:
        head = json.loads(line)
    if "sha256" in head:
        expected, digest = head["sha256"].encode() + b"\n", hashlib.sha256()
    # Otherwise the first line is the digest of everything after it, as earlier versions wrote it.
    while chunk := source.read(_CHUNK):
        digest.update(chunk)
        if target is not None:
            target.write(chunk)
    if digest.hexdigest().encode() + b"\n" != expected:
        message = "the content does not match its digest"
        raise BlobDamagedError(message)
    options: dict[str, Any] = head["options"] if "sha256" in head else json.loads(line)
    return options
