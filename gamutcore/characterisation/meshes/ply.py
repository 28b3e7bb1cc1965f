"""PLY (Turk, Stanford 1994): text, and binary of both byte orders, with polygons of any size.

Vertices need the properties x, y and z, which are L*, a* and b*. Comments ``name: value`` are notes
about the mesh, as the exports of this package write them. Properties ``device_C`` of vertices are
device values; comments give the full channel names. Counts in the header are checked against the
length of the file.
"""

from __future__ import annotations

import re
import struct
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gamutcore.characterisation.meshes.mesh import (
    MAX_TRIANGLES,
    MAX_VERTICES,
    TOO_MANY_DEVICE_VALUES,
    by_channel,
    gamut_mesh,
    numbers_of,
    polygon_triangles,
    reads_device_values,
    refuse_too_many,
    unescaped,
)
from gamutcore.errors import MalformedFileError, SampleLimitError

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray, LongArray
    from gamutcore.characterisation.meshes.mesh import GamutMesh

__all__ = ["looks_like_ply", "ply_mesh"]

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
    lists, empty for single numbers.
    """

    name: str
    kind: str
    length: str = ""


@dataclass
class Element:
    """An element: its name, number of rows, line in the header, and properties.

    `device` names the properties with device values, and `reads_device` tells whether these are
    within the limits.
    """

    name: str
    count: int
    line: int
    properties: list[Property] = field(default_factory=list)
    device: list[str] = field(default_factory=list)
    reads_device: bool = True

    def keeps(self, prop: Property) -> bool:
        """Return whether the values of a property are used."""
        return prop.name in _WANTED or (self.reads_device and prop.name in self.device)


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
        elif words[0] == "property" and elements and (prop := _property(words)):
            elements[-1].properties.append(prop)
        else:
            raise _broken(line, f"{content[:60]!r} is not a line of a PLY header.")
    if order is None:
        raise _broken(1, "The header has no format.")
    _check(elements)
    return Header(order, elements, said, len(lines) + 1, end.end())


def _check(elements: list[Element]) -> None:
    """Check names and counts, and find the properties with device values."""
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
        if element.name == "vertex":
            element.device = [
                prop.name
                for prop in element.properties
                if prop.name.startswith(DEVICE) and prop.kind.startswith("f") and not prop.length
            ]
        element.reads_device = reads_device_values(element.count, len(element.device))


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


MAX_NUMBERS = 24_000_000
"""Maximum number of numbers in a text: 3 million vertices of 6, 1 million faces of 4, and 2 million
more. They take 190 MB."""

MAX_WALKED = 2_000_000
"""Maximum number of values that are read one by one because rows differ in length: about 1 s."""

_STRUCT_CODES = {"i1": "b", "u1": "B", "i2": "h", "u2": "H", "i4": "i", "u4": "I", "f8": "d"}


def looks_like_ply(data: bytes) -> bool:
    """Return whether bytes start as PLY files do."""
    return re.match(rb"ply[ \t]*[\r\n]", data) is not None


def ply_mesh(data: bytes) -> GamutMesh:
    """Return the mesh in a PLY file. Errors state the line of the header, or of the text."""
    header = ply_header(data)
    reader = _Rows(data if header.order else _as_binary(data, header), header)
    vertices: FloatArray | None = None
    faces: LongArray | None = None
    device: dict[str, FloatArray] = {}
    unread = False
    for element in header.elements:
        if vertices is not None and faces is not None:
            break
        columns = reader.columns(element)
        if element.name == "vertex" and vertices is None:
            vertices = _positions(element, columns)
            unread = not element.reads_device
            device = by_channel(
                (
                    unescaped(header.said.pop(name, name.removeprefix(DEVICE))),
                    columns.values.get(name, np.empty(0)),
                )
                for name in ([] if unread else element.device)
            )
        elif element.name == "face" and faces is None:
            faces = _triangles(element, columns)
    if vertices is None or faces is None:
        missing = "vertex" if vertices is None else "face"
        raise MalformedFileError(
            f"The file has no element {missing}.",
            where={"field": missing},
            remedy="A mesh has elements vertex (with x, y, z) and face (with vertex_indices).",
        )
    return gamut_mesh(
        "ply",
        vertices,
        faces,
        stated=header.said,
        device=device,
        warnings=[TOO_MANY_DEVICE_VALUES] * unread,
    )


class _Columns(NamedTuple):
    """Values of an element: the numbers of each property, and the lengths of its lists."""

    values: dict[str, FloatArray]
    lengths: dict[str, LongArray]


def _as_binary(data: bytes, header: Header) -> bytes:
    """Return the numbers of a text as 64-bit floats, and change the header to say so."""
    numbers = numbers_of(data[header.size :], header.lines + 1, MAX_NUMBERS + 1)
    if len(numbers) > MAX_NUMBERS:
        raise SampleLimitError(
            f"The file has more than {MAX_NUMBERS} numbers.",
            remedy="Send the mesh alone, without further elements.",
        )
    for element in header.elements:
        for prop in element.properties:
            prop.kind, prop.length = "f8", prop.length and "f8"
    header.order, header.size = "<", 0
    return np.asarray(numbers, "<f8").tobytes()


class _Rows:
    """Rows of the elements of a binary file, in their order."""

    def __init__(self, data: bytes, header: Header) -> None:
        self.data, self.order, self.place = data, header.order, header.size
        self.walked = 0

    def columns(self, element: Element) -> _Columns:
        """Return the values of the next element."""
        if not element.properties or not element.count:
            return _Columns({}, {})
        spans, _ = self._row(element, self.place)
        found = self._equal_rows(element, [length for _, length in spans])
        if found is not None:
            return found
        if not any(prop.length for prop in element.properties):
            raise self._cut_off(element)
        return self._unequal_rows(element)

    def _row(self, element: Element, place: int) -> tuple[list[tuple[int, int]], int]:
        """Return where the numbers of each property start and how many they are; and the end."""
        spans = []
        for prop in element.properties:
            length = 1
            if prop.length:
                length = self._length(prop, place, element)
                place += int(prop.length[1])
            spans.append((place, length))
            place += length * int(prop.kind[1])
        if place > len(self.data):
            raise self._cut_off(element)
        return spans, place

    def _equal_rows(self, element: Element, lengths: list[int]) -> _Columns | None:
        """Return the values if every row has lists of the same lengths as the first one."""
        fields: list[tuple[str, str] | tuple[str, str, tuple[int]]] = []
        for prop, length in zip(element.properties, lengths, strict=True):
            if prop.length:
                fields.append((f"#{prop.name}", self.order + prop.length))
            fields.append((f"={prop.name}", self.order + prop.kind, (length,)))
        kind = np.dtype(fields)
        end = self.place + element.count * kind.itemsize
        if end > len(self.data):
            return None
        rows = np.frombuffer(self.data, kind, element.count, self.place)
        found = _Columns({}, {})
        for prop, length in zip(element.properties, lengths, strict=True):
            if prop.length:
                if not (rows[f"#{prop.name}"] == length).all():
                    return None
                found.lengths[prop.name] = np.full(element.count, length, np.int64)
            if element.keeps(prop):
                found.values[prop.name] = _doubles(rows[f"={prop.name}"].ravel())
        self.place = end
        return found

    def _unequal_rows(self, element: Element) -> _Columns:
        self.walked += element.count * len(element.properties)
        if self.walked > MAX_WALKED:
            raise SampleLimitError(
                f"The element {element.name} has {element.count} rows of different lengths.",
                where={"line": element.line},
                remedy="Send the mesh with triangles only, and without further properties.",
            )
        lengths: dict[str, list[int]] = {prop.name: [] for prop in element.properties}
        pieces: dict[str, list[bytes]] = {
            prop.name: [] for prop in element.properties if element.keeps(prop)
        }
        for _ in range(element.count):
            spans, self.place = self._row(element, self.place)
            for prop, (start, length) in zip(element.properties, spans, strict=True):
                lengths[prop.name].append(length)
                if prop.name in pieces:
                    end = start + length * int(prop.kind[1])
                    pieces[prop.name].append(self.data[start:end])
        found = _Columns({}, {})
        for prop in element.properties:
            if prop.length:
                found.lengths[prop.name] = np.array(lengths[prop.name], np.int64)
            if prop.name in pieces:
                joined = b"".join(pieces[prop.name])
                found.values[prop.name] = _doubles(np.frombuffer(joined, self.order + prop.kind))
        return found

    def _length(self, prop: Property, place: int, element: Element) -> int:
        if place + int(prop.length[1]) > len(self.data):
            raise self._cut_off(element)
        code = self.order + _STRUCT_CODES[prop.length]
        (length,) = struct.unpack_from(code, self.data, place)
        if length > len(self.data):
            raise self._cut_off(element)
        if not length >= 0 or length != int(length):
            raise MalformedFileError(
                f"A list of the element {element.name} has the length {length:g}.",
                where={"field": prop.name, "line": element.line},
                remedy="The length of a list is a whole number, 0 or more, and the list follows.",
            )
        return int(length)

    def _cut_off(self, element: Element) -> MalformedFileError:
        return MalformedFileError(
            f"The file ends within the {element.count} rows of the element {element.name}.",
            where={"field": element.name, "line": element.line},
            remedy="Send the whole file.",
        )


def _doubles(values: np.ndarray) -> FloatArray:
    with np.errstate(invalid="ignore"):  # a signalling NaN becomes a quiet one
        return values.astype(np.float64)


def _positions(element: Element, columns: _Columns) -> FloatArray:
    if not element.count:
        return np.empty((0, 3))
    if any(name not in columns.values or name in columns.lengths for name in "xyz"):
        raise MalformedFileError(
            "The vertices do not have the properties x, y and z.",
            where={"line": element.line, "field": "vertex"},
            remedy="Give them as L*, a* and b*.",
        )
    return np.stack([columns.values[name] for name in "xyz"], axis=1)


def _triangles(element: Element, columns: _Columns) -> LongArray:
    if not element.count:
        return np.empty((0, 3), np.int64)
    name = next((name for name in FACE_LISTS if name in columns.lengths), None)
    if name is None:
        raise MalformedFileError(
            "The faces have no list vertex_indices.",
            where={"line": element.line, "field": "face"},
            remedy="A face is a list of the indices of its vertices.",
        )
    sides, corners = columns.lengths[name], columns.values[name]
    refuse_too_many(0, int(np.maximum(sides - 2, 0).sum()), where={"line": element.line})
    whole = np.abs(corners) < 2**31
    if not (whole.all() and (corners == np.rint(corners)).all()):
        raise MalformedFileError(
            "A face has a vertex index that is not a whole number.",
            where={"field": "face"},
            remedy="Vertices are numbered from 0.",
        )
    return polygon_triangles(sides, corners.astype(np.int64))
