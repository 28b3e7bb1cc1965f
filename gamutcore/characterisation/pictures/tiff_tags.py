"""The directories of TIFF files: tags and their values, checked against the file's size.

TIFF 6.0 (Adobe 1992), section 2, and BigTIFF. Exif metadata is a TIFF file as well.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

from gamutcore.characterisation.pictures.bounds import malformed

__all__ = ["Directory", "tiff_directory"]

_MAX_ENTRIES = 4096

_MAX_VALUES = 2**20
"""Values of a tag at most: one strip per row, and three tables of 16 bits, are fewer."""

_TYPES = {
    # Bytes of a value, and its letter for struct; rationals are two numbers (TIFF 6.0, section 2).
    1: (1, "B"), 2: (1, "B"), 3: (2, "H"), 4: (4, "I"), 5: (8, "II"), 6: (1, "b"), 7: (1, "B"),
    8: (2, "h"), 9: (4, "i"), 10: (8, "ii"), 11: (4, "f"), 12: (8, "d"), 13: (4, "I"),
    16: (8, "Q"), 17: (8, "q"), 18: (8, "Q"),
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class Directory:
    """The tags of one picture.

    Parameters
    ----------
    data : bytes
        The file.
    order : str
        ``"<"`` or ``">"``.
    entries : dict
        Tag to type, count, and the byte that its values begin at; all within the file.
    """

    data: bytes
    order: str
    entries: dict[int, tuple[int, int, int]]

    def content(self, tag: int) -> bytes:
        """Return the bytes of a tag's values; empty without the tag."""
        if tag not in self.entries:
            return b""
        kind, count, place = self.entries[tag]
        return self.data[place : place + count * _TYPES[kind][0]]

    def numbers(self, tag: int) -> tuple[float, ...]:
        """Return a tag's values as numbers; empty without the tag."""
        if tag not in self.entries:
            return ()
        kind, count, place = self.entries[tag]
        if count > _MAX_VALUES:
            raise malformed(f"The tag {tag} has {count} values.", {"tag": str(tag)})
        letters = _TYPES[kind][1]
        if len(letters) == 2:
            pairs = struct.unpack_from(f"{self.order}{2 * count}{letters[0]}", self.data, place)
            return tuple(a / b if b else 0.0 for a, b in zip(pairs[::2], pairs[1::2], strict=True))
        return struct.unpack_from(f"{self.order}{count}{letters}", self.data, place)

    def whole(self, tag: int, default: int) -> int:
        """Return a tag's first value as a whole number; the default without the tag.

        Raises
        ------
        MalformedFileError
            It is no whole number.
        """
        values = self.numbers(tag)
        if not values:
            return default
        if not isinstance(values[0], int):
            raise malformed(f"The tag {tag} is no whole number.", {"tag": str(tag)})
        return values[0]


def tiff_directory(data: bytes, place: int) -> tuple[Directory, int]:
    """Return a directory of a TIFF file, and where the next one is.

    Parameters
    ----------
    data : bytes
        The file.
    place : int
        Where the directory begins; 0 for the first one.

    Returns
    -------
    directory : Directory
    following : int
        Where the next one begins; 0 after the last.

    Raises
    ------
    MalformedFileError
        The header or the directory is broken, or a tag's values are not within the file.
    """
    order = {b"II": "<", b"MM": ">"}.get(data[:2])
    version = struct.unpack_from(f"{order}H", data, 2)[0] if order and len(data) >= 8 else 0
    if order is None or version not in {42, 43}:
        raise malformed("The header of the TIFF file is broken.", {"byte": 0})
    big = version == 43
    counter, entry, offset = ("Q", "HHQ8s", "Q") if big else ("H", "HHI4s", "I")
    try:
        if not place:
            (place,) = struct.unpack_from(order + offset, data, 8 if big else 4)
        (count,) = struct.unpack_from(order + counter, data, place)
        start = place + struct.calcsize(order + counter)
        size = struct.calcsize(order + entry)
        if not 0 < count <= _MAX_ENTRIES:
            raise malformed(f"A directory of the file has {count} tags.", {"byte": place})
        (following,) = struct.unpack_from(order + offset, data, start + count * size)
        entries: dict[int, tuple[int, int, int]] = {}
        for index in range(count):
            at = start + index * size
            tag, kind, values, _ = struct.unpack_from(order + entry, data, at)
            if kind not in _TYPES:
                continue  # readers skip types that they do not know (TIFF 6.0, section 2)
            room = 8 if big else 4
            bytes_needed = values * _TYPES[kind][0]
            where = at + size - room
            if bytes_needed > room:
                (where,) = struct.unpack_from(order + offset, data, where)
            if where + bytes_needed > len(data):
                raise malformed(
                    f"The values of the tag {tag} are not within the file.", {"tag": str(tag)}
                )
            entries.setdefault(tag, (kind, values, where))
    except (struct.error, OverflowError) as error:
        raise malformed("The file ends within a directory.", {"byte": place}) from error
    return Directory(data, order, entries), following
