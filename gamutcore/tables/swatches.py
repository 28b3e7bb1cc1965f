"""Adobe Swatch Exchange (.ase): the colours of a palette, with their names.

The format is that of Adobe's applications, as their exports have it: big-endian blocks, of which
0x0001 is a colour and 0xC001 and 0xC002 begin and end a group.
"""

from __future__ import annotations

import struct
from typing import NamedTuple

from gamutcore.errors import MalformedFileError

__all__ = ["MAGIC", "Swatch", "swatches"]

MAGIC = b"ASEF"
_COLOUR, _GROUP, _GROUP_END = 0x0001, 0xC001, 0xC002
_COMPONENTS = {"RGB": 3, "LAB": 3, "CMYK": 4, "Gray": 1}


class Swatch(NamedTuple):
    """A colour: its name, its group, its model, and the components as in the file."""

    name: str
    group: str
    model: str
    values: tuple[float, ...]


def swatches(data: bytes) -> list[Swatch]:
    """Return the colours of a palette; errors have the number of the block, from 1."""
    found: list[Swatch] = []
    group, place, block = "", 12, 0
    try:
        (count,) = struct.unpack_from(">I", data, 8)
        for block in range(1, count + 1):  # noqa: B007  # named in the error
            kind, size = struct.unpack_from(">HI", data, place)
            content = data[place + 6 : place + 6 + size]
            if len(content) != size:
                raise struct.error("the file ends within a block")  # noqa: TRY301
            place += 6 + size
            if kind == _GROUP:
                group, _ = _text(content)
            elif kind == _GROUP_END:
                group = ""
            elif kind == _COLOUR:
                name, end = _text(content)
                model = content[end : end + 4].decode("ascii").strip()
                if model not in _COMPONENTS:
                    raise struct.error(f"the colour model is {model!r}")  # noqa: TRY301
                values = struct.unpack_from(f">{_COMPONENTS[model]}f", content, end + 4)
                found.append(Swatch(name, group, model, values))
    except (struct.error, UnicodeDecodeError) as error:
        raise MalformedFileError(
            f"The palette is damaged: {error}.",
            where={"block": block},
            remedy="Export the swatches again as Adobe Swatch Exchange (.ase).",
        ) from None
    return found


def _text(content: bytes) -> tuple[str, int]:
    """Return the text at the start of a block, and where it ends."""
    (length,) = struct.unpack_from(">H", content)
    end = 2 + 2 * length
    if end > len(content):
        raise struct.error("a name is longer than its block")
    return content[2:end].decode("utf-16-be").rstrip("\0"), end
