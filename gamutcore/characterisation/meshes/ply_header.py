"""The header of a PLY file: elements with their properties, and the notes in its comments."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from gamutcore.characterisation.gamut_mesh import (
    MAX_TRIANGLES,
    MAX_VERTICES,
    reads_device_values,
    refuse_too_many,
)
from gamutcore.errors import MalformedFileError

__all__ = [
    "DEVICE",
    "FACE_LISTS",
    "Element",
    "Header",
    "Property",
    "device_properties",
    "ply_header",
]

MAX_HEADER = 64 * 1024
"""Maximum size of a header in bytes. Real headers have some hundred."""

_TYPES = {
    **dict.fromkeys(("char", "int8"), "i1"),
    **dict.fromkeys(("uchar", "uint8"), "u1"),
    **dict.fromkeys(("short", "int16"), "i2"),
    **dict.fromkeys(("ushort", "uint16"), "u2"),
    **dict.fromkeys(("int", "int32"), "i4"),
    **dict.fromkeys(("uint", "uint32"), "u4"),
    **dict.fromkeys(("float", "float32"), "f4"),
    **dict.fromkeys(("double", "float64"), "f8"),
}
_ORDERS = {"binary_little_endian": "<", "binary_big_endian": ">", "ascii": ""}
_END = re.compile(rb"(?:^|[\r\n])end_header[ \t]*(\r\n|\r|\n|$)")
_NOTE = re.compile(r"([\w ./-]{1,80}):\s+(.*)")
FACE_LISTS = ("vertex_indices", "vertex_index")
_WANTED = {"x", "y", "z", *FACE_LISTS}
DEVICE = "device_"

_MOST = {"vertex": MAX_VERTICES, "face": MAX_TRIANGLES}


@dataclass
class Property:
    """A property of an element.

    `kind` is the NumPy type of the numbers without byte order. `length` is that of the length of
    lists, empty for single numbers. `kept` marks needed values, and `device` device values.
    """

    name: str
    kind: str
    length: str = ""
    kept: bool = False
    device: bool = False


@dataclass
class Element:
    """An element: its name, number of rows, line in the header, and properties."""

    name: str
    count: int
    line: int
    properties: list[Property] = field(default_factory=list)


@dataclass
class Header:
    """A header: byte order (empty for text), elements, notes, number of lines, and size."""

    order: str
    elements: list[Element]
    said: dict[str, str]
    lines: int
    size: int


def ply_header(data: bytes) -> Header:
    """Return the header of a PLY file, whose counts of rows are within limits."""
    end = _END.search(data, 0, MAX_HEADER)
    if end is None:
        raise MalformedFileError(
            f"The header does not end within {MAX_HEADER} bytes.",
            where={"line": 1},
            remedy="A PLY header ends with the line end_header.",
        )
    lines = re.split(r"\r\n|\r|\n", data[: end.start() + 1].decode("latin-1").rstrip("\r\n"))
    order: str | None = None
    elements: list[Element] = []
    said: dict[str, str] = {}
    for line, content in enumerate(lines, start=1):
        words = content.split()
        if line == 1 or not words or words[0] == "obj_info":
            continue
        if words[0] == "comment":
            note = _NOTE.fullmatch(content.strip()[len("comment") :].strip())
            if note:
                said.setdefault(note[1].strip(), note[2])
        elif words[0] == "format" and len(words) == 3 and words[1] in _ORDERS:
            order = _ORDERS[words[1]]
        elif words[0] == "element" and len(words) == 3 and re.fullmatch(r"\d{1,12}", words[2]):
            elements.append(Element(words[1], int(words[2]), line))
        elif words[0] == "property" and elements and _property(words) is not None:
            elements[-1].properties.append(_property(words) or Property("", ""))
        else:
            raise _broken(line, f"{content[:60]!r} is not a line of a PLY header.")
    if order is None:
        raise _broken(1, "The header has no format.")
    _check(elements)
    _mark_properties(elements)
    return Header(order, elements, said, len(lines) + 1, end.end())


def _mark_properties(elements: list[Element]) -> None:
    """Mark the properties that hold device values, and those that are needed."""
    for element in elements:
        for prop in element.properties:
            fraction = prop.kind.startswith("f") and not prop.length
            prop.device = element.name == "vertex" and prop.name.startswith(DEVICE) and fraction
        reads = reads_device_values(element.count, len(device_properties(element)))
        for prop in element.properties:
            prop.kept = prop.name in _WANTED or (reads and prop.device)


def device_properties(element: Element) -> list[str]:
    """Return the names of the properties that are device values."""
    return [prop.name for prop in element.properties if prop.device]


def _check(elements: list[Element]) -> None:
    for element in elements:
        names = [prop.name for prop in element.properties]
        if len(set(names)) < len(names):
            raise _broken(
                element.line, f"The element {element.name} has two properties with one name."
            )
        if element.count > _MOST.get(element.name, MAX_VERTICES):
            refuse_too_many(
                *((element.count, 0) if element.name == "vertex" else (0, element.count)),
                where={"line": element.line},
            )


def _property(words: list[str]) -> Property | None:
    if len(words) == 3 and words[1] in _TYPES:
        return Property(words[2], _TYPES[words[1]])
    if len(words) == 5 and words[1] == "list" and words[2] in _TYPES and words[3] in _TYPES:
        length = _TYPES[words[2]]
        return None if length.startswith("f") else Property(words[4], _TYPES[words[3]], length)
    return None


def _broken(line: int, problem: str) -> MalformedFileError:
    return MalformedFileError(
        problem,
        where={"line": line},
        remedy="A PLY header has format, comment, element and property lines.",
    )
