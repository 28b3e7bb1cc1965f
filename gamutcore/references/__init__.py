"""Reference gamuts: RGB spaces, Pointer's gamut and the optimal colours, by slug.

`REFERENCES` is the catalogue. A reference is built from its definition, a small JSON document, as
any gamut is built from its data. `gamutcore.reference` builds one by name. The colours are computed
in `gamutcore.colours.reference`. See ``docs/decisions/references.md``.
"""

from gamutcore.references.catalogue import (
    NOT_OFFERED,
    REFERENCES,
    Reference,
    find_reference,
    parse_definition,
    search_references,
)

__all__ = [
    "NOT_OFFERED",
    "REFERENCES",
    "Reference",
    "find_reference",
    "parse_definition",
    "search_references",
]
