"""Owners of gamuts: the name of the API key whose request built a gamut.

The first key that posts the data is the owner until the gamut is deleted. The name is stored as
``owners/<aa>/<id>.owner`` with a seal, beside the record, because records are the same whoever
builds. Gamuts that were built without a key, or by an earlier version, have no owner.
"""

from __future__ import annotations

from service.storage.blobs import BlobDamagedError, BlobNotFoundError, Blobs
from service.storage.published import seal, unseal

__all__ = ["Owners"]


class Owners:
    """The owners in a storage."""

    def __init__(self, blobs: Blobs) -> None:
        self._blobs = blobs

    def read(self, gamut_id: str) -> str:
        """Return the owner of a gamut; empty if none is stored, or the document is damaged."""
        try:
            return unseal(self._blobs.read(_key(gamut_id)).data).decode()
        except (BlobNotFoundError, BlobDamagedError):
            return ""

    def claim(self, gamut_id: str, name: str) -> None:
        """Store the owner of a gamut, unless it has one."""
        self._blobs.create(_key(gamut_id), seal(name.encode()))

    def drop(self, gamut_id: str) -> None:
        """Remove the owner of a gamut."""
        self._blobs.delete(_key(gamut_id))


def _key(gamut_id: str) -> str:
    return f"owners/{gamut_id[:2]}/{gamut_id}.owner"
