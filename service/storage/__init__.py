"""Storage of gamuts, inputs and jobs: a local directory, or a bucket at S3, GCS or Azure.

A location names a storage: a path, or an address such as ``s3://bucket/prefix``.
"""

from __future__ import annotations

import re
from pathlib import Path

from service.storage.blobs import Blobs
from service.storage.gamut_store import GamutStore
from service.storage.local import LocalBlobs

__all__ = ["StoreLocationError", "blobs_at", "is_address", "store_at"]


class StoreLocationError(ValueError):
    """The location cannot be used as a store."""


def is_address(location: str) -> bool:
    """Return whether a location is the address of a bucket, and not a directory."""
    return re.match(r"[a-z][a-z0-9+.-]*://", location) is not None


def blobs_at(location: str, limit: int = 0, reserve: int = 0) -> Blobs:
    """Return the storage at a location; `limit` and `reserve` are for a directory (`LocalBlobs`).

    Raise `StoreLocationError` if the address is not supported or the extra for buckets is not
    installed.
    """
    if not is_address(location):
        return LocalBlobs(Path(location), limit, reserve)
    try:
        # Slow to import, and not installed by default.
        from service.storage.cloud import CloudBlobs  # noqa: PLC0415

        return CloudBlobs(location)
    except ModuleNotFoundError as error:
        message = (
            "A store in a bucket needs the extra `cloud`: "
            'pip install "gamut-boundary-service[cloud]"'
        )
        raise StoreLocationError(message) from error
    except ValueError as error:
        raise StoreLocationError(str(error)) from None


def store_at(
    location: str, limit: int = 0, reserve: int = 0, *, keep_inputs: bool = True
) -> GamutStore:
    """Return the gamut store at a location, not yet opened; parameters as for `blobs_at`."""
    return GamutStore(blobs_at(location, limit, reserve), keep_inputs=keep_inputs)
