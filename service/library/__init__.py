"""Everything in memory that is made of gamuts: open gamuts, levels and encoded answers."""

from service.library.encoding import (
    MEDIA_TYPES,
    SUFFIXES,
    EncodedLevel,
    EncodedResponse,
    PictureOptions,
)
from service.library.library import Library, OpenGamut, QueryLevel
from service.library.memory import (
    PROCESS_BYTES,
    ByteBoundedCache,
    Charge,
    ChargedResponse,
    Cost,
    Ledger,
    keep_heap_small,
    memory_budget,
)

__all__ = [
    "MEDIA_TYPES",
    "PROCESS_BYTES",
    "SUFFIXES",
    "ByteBoundedCache",
    "Charge",
    "ChargedResponse",
    "Cost",
    "EncodedLevel",
    "EncodedResponse",
    "Ledger",
    "Library",
    "OpenGamut",
    "PictureOptions",
    "QueryLevel",
    "keep_heap_small",
    "memory_budget",
]
