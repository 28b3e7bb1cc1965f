"""Names and owners of gamuts: small sealed documents beside the gamuts.

They are no part of a gamut's id, its record or anything immutable. A name is stored as
``names/<aa>/<id>.name``, and the last write counts. It replaces the document by compare-and-swap
until it succeeds. So it is durable when it returns, and every replica reads it from then on.
Simultaneous writes leave one of the names.

Without a given name, clients see the data's descriptor, the description of the profile, or the name
of the file. A reference gamut has its name in the catalogue.
"""

from __future__ import annotations

import json
import unicodedata
from typing import Any, NamedTuple

from gamutcore.references import stated_name
from service.storage.blobs import (
    BlobDamagedError,
    BlobNotFoundError,
    Blobs,
    StoreUnavailableError,
    seal,
    unseal,
)
from service.storage.published import PublishedGamut, blob_key

__all__ = [
    "LONGEST_NAME",
    "GamutName",
    "InvalidNameError",
    "Names",
    "Owners",
    "checked_name",
    "cleaned_name",
    "display_name",
]

LONGEST_NAME = 200
"""Largest number of characters of a name."""

_ATTEMPTS = 50
"""Number of attempts to replace a document while others replace it."""

_FORBIDDEN = frozenset({"Cc", "Cf", "Cn", "Co", "Cs", "Zl", "Zp"})
"""Unicode categories that no name contains, because they are invisible or disguise other text:
controls, formats, unassigned, private use, surrogates, line separators. Joiners are an exception.
"""

_FILLERS = frozenset("\u115f\u1160\u3164\uffa0")
"""Letters of Hangul that are invisible."""

_BRAILLE_BLANK = "\u2800"

_JOINERS = frozenset("\u200c\u200d")

_EMOJI_PRESENTATION = "\ufe0f"

_VIRAMA = 9
"""Canonical combining class of viramas, after which a joiner selects a form (RFC 5892, A.1)."""

_JOINING_SCRIPTS = frozenset({"ARABIC", "MANDAIC", "MONGOLIAN", "NKO", "PHAGS-PA", "SYRIAC"})
"""First words of the names of letters that connect, as joiners decide (RFC 5892, A.1)."""


class InvalidNameError(ValueError):
    """A text is not a name. The message is a sentence with the reason."""


class GamutName(NamedTuple):
    """The names of a gamut: `given` by a client, and `file` of the posted data; empty if missing.

    `revision` grows with every write, so that no version of the document recurs.
    """

    given: str = ""
    file: str = ""
    revision: int = 0


def checked_name(text: object) -> str:
    """Return a name in its canonical form: NFC, without white space at the ends.

    Raise `InvalidNameError` if the text is empty, too long, or has characters that no name
    contains.
    """
    if not isinstance(text, str):
        message = "The name is not a text."
        raise InvalidNameError(message)
    stripped = text.strip()
    bad = next((place for place in range(len(stripped)) if _is_forbidden(stripped, place)), None)
    if bad is not None:
        message = (
            f"The name contains the character U+{ord(stripped[bad]):04X} at position {bad + 1}, "
            "which is invisible there."
        )
        raise InvalidNameError(message)
    name = unicodedata.normalize("NFC", stripped)
    if not name or len(name) > LONGEST_NAME:
        message = f"The name has {len(name)} characters; it needs 1 to {LONGEST_NAME}."
        raise InvalidNameError(message)
    if not _is_visible(name):
        message = "The name has no visible character."
        raise InvalidNameError(message)
    return name


def cleaned_name(text: str) -> str:
    """Return a text from a file as a name: without forbidden characters, not too long.

    The result is empty if nothing of the text is visible.
    """
    name = "".join(
        _replacement(character) if _is_forbidden(text, place) else character
        for place, character in enumerate(text)
    )
    name = unicodedata.normalize("NFC", " ".join(name.split()))[:LONGEST_NAME].strip()
    return name if _is_visible(name) else ""


def _replacement(character: str) -> str:
    """Return what takes the place of a forbidden character: formats have no width."""
    return "" if unicodedata.category(character) == "Cf" else " "


def _is_forbidden(text: str, place: int) -> bool:
    character = text[place]
    if character in _JOINERS:
        return not _joins(text[:place], text[place + 1 :])
    return character in _FILLERS or unicodedata.category(character) in _FORBIDDEN


def _joins(before: str, after: str) -> bool:
    """Return whether a joiner has an effect between two texts: in Indic, Arabic, emoji."""
    if not before:
        return False
    if unicodedata.combining(before[-1]) == _VIRAMA:
        return True
    neighbours = before[-1] + after[:1]
    return len(neighbours) == 2 and (
        all(_is_emoji(each) for each in neighbours)
        or all(unicodedata.name(each, "").split(" ")[0] in _JOINING_SCRIPTS for each in neighbours)
    )


def _is_emoji(character: str) -> bool:
    return character == _EMOJI_PRESENTATION or unicodedata.category(character) in {"So", "Sk"}


def _is_visible(text: str) -> bool:
    """Return whether a text has a letter, number, punctuation mark or symbol."""
    return any(unicodedata.category(each)[0] in "LNPS" and each != _BRAILLE_BLANK for each in text)


class Names:
    """The names in a storage."""

    def __init__(self, blobs: Blobs) -> None:
        self._blobs = blobs

    def read(self, gamut_id: str) -> GamutName:
        """Return the name of a gamut; empty if none is stored, or the document is damaged."""
        return self._read(gamut_id)[0]

    def give(self, gamut_id: str, name: str) -> None:
        """Store a name that a client gave. It is durable on return, and replaces earlier ones.

        Raise `StoreUnavailableError` if others replaced the name at every attempt.
        """
        for _ in range(_ATTEMPTS):
            present, version = self._read(gamut_id)
            data = _document(GamutName(name, present.file, present.revision + 1))
            if version is None:
                if self._blobs.create(blob_key(gamut_id, "name"), data) is not None:
                    return
            elif self._blobs.replace(blob_key(gamut_id, "name"), data, version) is not None:
                return
        message = "The name is being replaced by others all the time."
        raise StoreUnavailableError(message)

    def keep_file(self, gamut_id: str, file: str) -> None:
        """Store the name of a gamut's file, unless something is stored already."""
        self._blobs.create(blob_key(gamut_id, "name"), _document(GamutName(file=file)))

    def drop(self, gamut_id: str) -> None:
        """Remove the name of a gamut."""
        self._blobs.delete(blob_key(gamut_id, "name"))

    def _read(self, gamut_id: str) -> tuple[GamutName, str | None]:
        """Return the name and its version; None for no document."""
        try:
            blob = self._blobs.read(blob_key(gamut_id, "name"))
        except BlobNotFoundError:
            return GamutName(), None
        try:
            return GamutName(**json.loads(unseal(blob.data))), blob.version
        except (ValueError, TypeError):
            return GamutName(), blob.version


def _document(name: GamutName) -> bytes:
    return seal(json.dumps(name._asdict()).encode())


class Owners:
    """Owners of gamuts: the name of the API key whose request built a gamut.

    The first key that posts the data is the owner until the gamut is deleted. Gamuts that were
    built without a key, or by an earlier version, have no owner.
    """

    def __init__(self, blobs: Blobs) -> None:
        self._blobs = blobs

    def read(self, gamut_id: str) -> str:
        """Return the owner of a gamut; empty if none is stored, or the document is damaged."""
        try:
            return unseal(self._blobs.read(blob_key(gamut_id, "owner")).data).decode()
        except (BlobNotFoundError, BlobDamagedError):
            return ""

    def claim(self, gamut_id: str, name: str) -> None:
        """Store the owner of a gamut, unless it has one."""
        self._blobs.create(blob_key(gamut_id, "owner"), seal(name.encode()))

    def drop(self, gamut_id: str) -> None:
        """Remove the owner of a gamut."""
        self._blobs.delete(blob_key(gamut_id, "owner"))


def display_name(record: PublishedGamut, stored: GamutName) -> str:
    """Return the name of a gamut; `stored` is the store's document about the name."""
    provenance: dict[str, Any] = record.description.get("provenance", {})
    if stored.given and provenance.get("format") != "reference":
        return stored.given
    for text in (stated_name(record.description), stored.file):
        if text and (name := cleaned_name(text)):
            return name
    return f"Gamut {record.id[:12]}"
