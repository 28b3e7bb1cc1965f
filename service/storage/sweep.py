"""Removal of histories whose publisher died before it created the record."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from itertools import groupby
from typing import TYPE_CHECKING

from service.storage.blobs import BlobNotFoundError
from service.storage.published import PublishedGamut, id_of, published_key

if TYPE_CHECKING:
    from service.storage.blobs import Blobs

__all__ = ["remove_uncommitted"]


def remove_uncommitted(
    blobs: Blobs, is_being_published: Callable[[str], bool], goes_on: Callable[[], bool]
) -> int:
    """Remove the histories that no record names, and return their number.

    The storage must belong to this process: in a shared one, other publishers are unknown.
    `goes_on` tells whether to continue.
    """
    removed = 0
    for gamut_id, keys in groupby(blobs.keys("published/"), id_of):
        if not goes_on():
            break
        histories = [key for key in keys if key.endswith(".gamut")]
        # The keys are read first: a gamut that is not being published now was committed before.
        if not is_being_published(gamut_id):
            removed += sum(map(blobs.delete, _uncommitted(blobs, gamut_id, histories)))
    return removed


def _uncommitted(blobs: Blobs, gamut_id: str, histories: list[str]) -> Iterable[str]:
    if len(histories) == 1 and _exists(blobs, published_key(gamut_id)):
        # The usual case, without a read. A record that names another history is damaged, and
        # reading it will show that.
        return []
    try:
        committed = PublishedGamut.from_bytes(blobs.read(published_key(gamut_id)).data).key
    except BlobNotFoundError:
        return histories
    except (ValueError, TypeError):
        return []  # for the quarantine
    return [key for key in histories if key != committed]


def _exists(blobs: Blobs, key: str) -> bool:
    try:
        blobs.size(key)
    except BlobNotFoundError:
        return False
    return True
