"""The inputs that gamuts are built from, kept beside them.

An input is durable before its job is accepted, so an accepted job can be done whatever happens to
the process; kept after that, it lets a gamut that was damaged or evicted be built again. Its blob
is a line with the SHA-256 of the rest, a line of JSON with the options, and the data as they came.
"""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any, BinaryIO

from service.storage.blobs import BlobDamagedError, BlobNotFoundError, Blobs, StoreUnavailableError
from service.storage.quarantine import Quarantine
from service.storage.records import input_key

__all__ = ["Inputs"]

_CHUNK = 1 << 20

_ATTEMPTS = 3
"""How often an input is stored while others drop it and set it aside at the same time."""

_HEAD_LIMIT = 1 << 20
"""Bytes of the longest line of options that is read; a few hundred are usual."""


class Inputs:
    """The inputs in a storage.

    Parameters
    ----------
    blobs : Blobs
        The storage.
    quarantine : Quarantine
        Where damaged ones go.
    """

    def __init__(self, blobs: Blobs, quarantine: Quarantine) -> None:
        self._blobs = blobs
        self._quarantine = quarantine

    def keep(self, gamut_id: str, data: bytes, options: dict[str, Any]) -> None:
        """Store an input, durably. One that is there already is used if it is sound."""
        head = json.dumps(options, separators=(",", ":")).encode() + b"\n"
        digest = hashlib.sha256(head)
        digest.update(data)
        pieces = [digest.hexdigest().encode() + b"\n", head, data]
        for _ in range(_ATTEMPTS):
            if self._blobs.create(input_key(gamut_id), pieces) is not None:
                return
            if self._is_sound(gamut_id):
                return
        message = "the input is being kept and dropped at the same time"
        raise StoreUnavailableError(message)

    def path(self, gamut_id: str) -> Path:
        """Return a new scratch file with the data of an input; `BlobNotFoundError` if none is."""
        path = self._blobs.scratch(".input")
        try:
            with path.open("xb") as target:
                self._options(gamut_id, target)
        except BaseException:
            path.unlink(missing_ok=True)
            raise
        return path

    def options(self, gamut_id: str) -> dict[str, Any]:
        """Return the options that an input was kept with; `BlobNotFoundError` if none is."""
        return self._options(gamut_id, None)

    def kept(self, gamut_id: str) -> bool:
        """Whether there is an input."""
        return self.nbytes(gamut_id) > 0

    def nbytes(self, gamut_id: str) -> int:
        """Return the size of an input as it is stored; 0 if there is none."""
        try:
            return self._blobs.size(input_key(gamut_id))
        except BlobNotFoundError:
            return 0

    def drop(self, gamut_id: str) -> bool:
        """Remove an input; whether there was one."""
        return self._blobs.delete(input_key(gamut_id))

    def _is_sound(self, gamut_id: str) -> bool:
        try:
            self._options(gamut_id, None)
        except BlobNotFoundError:
            return False
        return True

    def _options(self, gamut_id: str, target: BinaryIO | None) -> dict[str, Any]:
        """Return an input's options and copy its data; what is damaged goes to the quarantine."""
        key = input_key(gamut_id)
        for last in (False, True):
            with self._blobs.stream(key) as source:
                try:
                    return _verified_options(source, target)
                except BlobDamagedError as error:
                    # It may have been damaged on the way only: the second look decides.
                    if last:
                        self._quarantine.put([key], f"damaged input: {error}")
            if target is not None:
                target.seek(0)
                target.truncate()
        raise BlobNotFoundError(key)


def _verified_options(source: BinaryIO, target: BinaryIO | None) -> dict[str, Any]:
    expected = source.read(65)
    head = source.readline(_HEAD_LIMIT)
    digest = hashlib.sha256(head)
    while chunk := source.read(_CHUNK):
        digest.update(chunk)
        if target is not None:
            target.write(chunk)
    if digest.hexdigest().encode() + b"\n" != expected:
        message = "the content does not match its digest"
        raise BlobDamagedError(message)
    options: dict[str, Any] = json.loads(head)
    return options
