"""The provenance of mesh files: where a level comes from, in a few texts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

__all__ = ["mesh_provenance"]


def mesh_provenance(description: Mapping[str, Any]) -> dict[str, str]:
    """Return the simple values of a gamut's description, for the provenance of mesh files.

    Numbers are written as in the description, without loss. The centre is the computed one, not the
    option.
    """
    provenance = description.get("provenance", {})
    facts = {"gamut": str(description["id"])}
    for name, triple in (("centre", description.get("centre")), ("white", provenance.get("white"))):
        if triple:
            facts[name] = " ".join(map(repr, triple))
    for name, part_name, member in (
        ("input_sha256", "input", "sha256"),
        ("algorithm_version", "algorithm", "version"),
    ):
        part = provenance.get(part_name, {})
        if member in part:
            facts[name] = str(part[member])
    options = description.get("options", {})
    white = options.get("reference_white")
    if isinstance(white, list):
        facts["reference_white"] = " ".join(map(repr, white))
    if white is not None or "scale" in options:
        # The space's adaptation, even if the provenance has another one for an earlier step.
        facts["adaptation"] = str(options.get("adaptation", "Bradford"))
    for part in ("options", "provenance"):
        for name, value in description.get(part, {}).items():
            if isinstance(value, str | int | float):
                facts.setdefault(name, str(value))
    return facts
