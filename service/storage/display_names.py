"""The name of a gamut that clients see: the given name, else a default from the data.

The default is the data's descriptor, the description of the profile, or the name of the file. A
reference gamut has its name in the catalogue.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from gamutcore.references import REFERENCES
from service.storage.names import GamutName, cleaned_name

if TYPE_CHECKING:
    from service.storage.published import PublishedGamut

__all__ = ["display_name"]

_DESCRIPTORS = ("DESCRIPTOR", "DESCRIPTION", "FILE_DESCRIPTOR")
"""Keywords of characterisation data that describe it, in order."""


def display_name(record: PublishedGamut, stored: GamutName) -> str:
    """Return the name of a gamut; `stored` is the store's document about the name."""
    provenance: dict[str, Any] = record.description.get("provenance", {})
    if provenance.get("format") == "reference":
        reference = REFERENCES.get(provenance["reference"])
        return str(provenance["reference"]) if reference is None else reference.name
    if stored.given:
        return stored.given
    conditions = provenance.get("conditions", {})
    descriptors = [conditions.get(keyword) for keyword in _DESCRIPTORS]
    for text in (*descriptors, provenance.get("description"), stored.file):
        if isinstance(text, str) and (name := cleaned_name(text)):
            return name
    return f"Gamut {record.id[:12]}"
