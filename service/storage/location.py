"""From a storage location, a directory or the address of a bucket, to a gamut store."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

from service.storage.gamuts import GamutStore
from service.storage.local import LocalBlobs

if TYPE_CHECKING:
    from service.storage.blobs import Blobs

__all__ = ["StoreLocationError", "blobs_at", "gamut_store", "is_address"]

_ADDRESS = re.compile(r"[a-z][a-z0-9+.-]*://")


class StoreLocationError(ValueError):
    """The location cannot be used as a store."""


def is_address(location: str) -> bool:
    """Return whether a location is the address of a bucket, and not a directory."""
    return _ADDRESS.match(location) is not None


def blobs_at(location: str, limit: int = 0, reserve: int = 0) -> Blobs:
    """Return the storage at a directory, or at an address with ``s3://``, ``gs://`` or ``az://``.

    `limit` and `reserve` are for a directory (see `LocalBlobs`). Raise `StoreLocationError` if the
    address is not supported or the extra for buckets is not installed.
    """
    if is_address(location):
        try:
            # Slow to import, and not installed by default.
            from service.storage.cloud import CloudBlobs  # noqa: PLC0415
        except ModuleNotFoundError as error:
            message = (
                "A store in a bucket needs the extra `cloud`: "
                'pip install "gamut-boundary-service[cloud]"'
            )
            raise StoreLocationError(message) from error
        try:
            return CloudBlobs(location)
        except ValueError as error:
            raise StoreLocationError(str(error)) from None
    return LocalBlobs(Path(location), limit, reserve)


def gamut_store(
    location: str, limit: int = 0, reserve: int = 0, *, keep_inputs: bool = True
) -> GamutStore:
    """Return the gamut store at a location, not yet opened; parameters as for `blobs_at`."""
    return GamutStore(blobs_at(location, limit, reserve), keep_inputs=keep_inputs)
