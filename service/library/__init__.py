"""Everything in memory that is made of gamuts: open gamuts, levels and encoded answers."""

from service.library.cache import ByteBoundedCache
from service.library.encoding import (
    MEDIA_TYPES,
    SUFFIXES,
    EncodedLevel,
    EncodedResponse,
    PictureOptions,
)
from service.library.library import Library, QueryLevel
from service.library.open_gamut import OpenGamut
from service.library.process_memory import (
    PROCESS_BYTES,
    keep_heap_small,
    memory_budget,
    return_free_pages,
)

__all__ = [
    "MEDIA_TYPES",
    "PROCESS_BYTES",
    "SUFFIXES",
    "ByteBoundedCache",
    "EncodedLevel",
    "EncodedResponse",
    "Library",
    "OpenGamut",
    "PictureOptions",
    "QueryLevel",
    "keep_heap_small",
    "memory_budget",
    "return_free_pages",
]
