"""PLY, STL, OBJ and 3MF: triangles of 3-D programs and printers. x, y, z are L*, a*, b*.

PLY (Turk, Stanford 1994) is text, or binary of both byte orders, with polygons of any size.
Comments ``name: value`` are notes about the mesh, as this package's exports write them. Properties
``device_C`` of vertices are device values; comments give the full channel names. Counts in the
header are checked against the length of the file.

STL (3D Systems 1988), binary or text, has no shared vertices. Vertices and faces of OBJ (Wavefront)
are read. Comments ``# name: value`` are notes, as this package's exports write them.

A 3MF package (3MF Consortium, core specification 1.3) is a ZIP archive, and the model in it is XML
with one mesh. Expat is driven directly, as for CxF3, and document type declarations are refused.
This package's exports have the coordinates of the colour space as vertices, and a transform for
printers in the build item. That transform is never applied.
"""

from __future__ import annotations

import io
import re
import struct
import zipfile
import zlib
from array import array
from dataclasses import dataclass, field
from typing import IO, TYPE_CHECKING, NamedTuple, NoReturn
from xml.parsers import expat

import numpy as np

from gamutcore.characterisation.meshes.mesh import (
    MAX_STATED,
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
    from collections.abc import Iterator, Mapping

    from gamutcore.arrays import FloatArray, LongArray
    from gamutcore.characterisation.meshes.mesh import GamutMesh
    from gamutcore.errors import Where

__all__ = [
    "looks_like_obj",
    "looks_like_ply",
    "looks_like_stl",
    "looks_like_threemf",
    "obj_mesh",
    "ply_mesh",
    "stl_mesh",
    "threemf_mesh",
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


def _ply_rows(data: bytes) -> _Rows:
    """Read the header of a PLY file, whose counts of rows must be within limits."""
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
    return _Rows(data, order, end.end(), elements, said, len(lines) + 2)


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
    rows = _ply_rows(data)
    if not rows.order:
        rows.convert_text()
    vertices: FloatArray | None = None
    faces: LongArray | None = None
    device: dict[str, FloatArray] = {}
    unread = False
    for element in rows.elements:
        if vertices is not None and faces is not None:
            break
        columns = rows.columns(element)
        if element.name == "vertex" and vertices is None:
            vertices = _positions(element, columns)
            unread = not element.reads_device
            device = by_channel(
                (
                    unescaped(rows.said.pop(name, name.removeprefix(DEVICE))),
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
        stated=rows.said,
        device=device,
        warnings=[TOO_MANY_DEVICE_VALUES] * unread,
    )


class _Columns(NamedTuple):
    """Values of an element: the numbers of each property, and the lengths of its lists."""

    values: dict[str, FloatArray]
    lengths: dict[str, LongArray]


@dataclass
class _Rows:
    """Rows of the elements of a file, in their order: the header, and the place of the next row.

    The byte `order` is empty for text. `line` is that of the first row of a text, and `walked` the
    number of values that were read one by one.
    """

    data: bytes
    order: str
    place: int
    elements: list[Element]
    said: dict[str, str]
    line: int
    walked: int = 0

    def convert_text(self) -> None:
        """Convert the numbers of a text to 64-bit floats."""
        numbers = numbers_of(self.data[self.place :], self.line, MAX_NUMBERS + 1)
        if len(numbers) > MAX_NUMBERS:
            raise SampleLimitError(
                f"The file has more than {MAX_NUMBERS} numbers.",
                remedy="Send the mesh alone, without further elements.",
            )
        for element in self.elements:
            for prop in element.properties:
                prop.kind, prop.length = "f8", prop.length and "f8"
        self.data, self.order, self.place = np.asarray(numbers, "<f8").tobytes(), "<", 0

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


_HEADER = 84
_FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attributes", "<u2")])
_TEXT = re.compile(rb"\s*solid\b[^\r\n]*[\r\n]+\s*facet\b", re.IGNORECASE)
_WORD = rb"[ \t]+[^\s]{1,400}"
_CORNER = re.compile(
    rb"(?:^|[\r\n])[ \t]*vertex(" + 3 * _WORD + rb")[ \t]*(?=[\r\n]|$)", re.IGNORECASE
)
_OBJ_VERTEX = re.compile(r"^[ \t]*v[ \t]+[-+.0-9]", re.MULTILINE)
_OBJ_FACE = re.compile(r"^[ \t]*f[ \t]+[-0-9]", re.MULTILINE)
_OBJ_NOTE = re.compile(r"#\s*([\w ./-]{1,80}):\s+(.*)")
_REFERENCE = re.compile(rb"(-?\d{1,10})(?:/-?\d{0,10}){0,2}")
MAX_NOTES = 200
MAX_TEXT_TRIANGLES = 500_000
"""Maximum number of triangles in an STL text: about 100 MB."""

MAX_SHARED_VERTICES = 1_000_000
"""Maximum number of vertices in OBJ and 3MF: twice those of the largest closed mesh."""

MAX_LINES = 6_000_000
MAX_LINE = 1_000_000
"""Maximum number of lines, and maximum length of a line in bytes."""

_OBJ_WORDS = {"v", "vn", "vt", "vp", "o", "g", "s", "mtllib", "usemtl", "f"}


def looks_like_stl(data: bytes) -> bool:
    """Return whether bytes are STL: a length that fits the number of facets, or text."""
    if len(data) > _HEADER and len(data) == _HEADER + 50 * int.from_bytes(data[80:84], "little"):
        return True
    return _TEXT.match(data[:2000]) is not None


def stl_mesh(data: bytes) -> GamutMesh:
    """Return the mesh in an STL file. Each triangle has three vertices of its own."""
    count = (len(data) - _HEADER) // 50
    if len(data) == _HEADER + 50 * int.from_bytes(data[80:84], "little"):
        refuse_too_many(3 * count, count)
        corners = np.frombuffer(data, _FACET, count, _HEADER)["corners"]
        with np.errstate(invalid="ignore"):  # a signalling NaN becomes a quiet one
            vertices = corners.reshape(-1, 3).astype(np.float64)
    else:
        if max(data.count(b"vertex"), data.count(b"VERTEX")) > 3 * MAX_TEXT_TRIANGLES:
            raise SampleLimitError(
                f"The text has more than {MAX_TEXT_TRIANGLES} triangles.",
                remedy="Send the mesh as binary STL, PLY or glTF.",
            )
        texts = _CORNER.findall(data)
        if len(texts) % 3 or len(texts) != data.count(b"vertex"):
            _check_corners(data, len(texts))
        try:
            vertices = numbers_of(b" ".join(texts), 1, 3 * len(texts))
        except MalformedFileError:
            _check_corners(data, len(texts))
            raise
        vertices = vertices.reshape(-1, 3)
    faces = np.arange(len(vertices)).reshape(-1, 3)
    return gamut_mesh("stl", vertices, faces)


def _check_corners(data: bytes, matches: int) -> None:
    """Refuse an STL text at its first corner that has not three numbers, or for their number."""
    corners = 0
    for line, content in _lines(data):
        word, *numbers = content.split() or [b""]
        if word.lower() == b"vertex":
            corners += 1
            if len(numbers) != 3 or len(numbers_of(b" ".join(numbers), line, 3)) != 3:
                raise _no_line(content, line, "vertex x y z, with plain numbers", "an STL")
    if corners % 3 or corners != matches:
        raise MalformedFileError(
            f"The file has {corners} corners, of which {matches} have three numbers.",
            where={"field": "vertex"},
            remedy="A facet has three lines `vertex x y z`.",
        )


def looks_like_obj(text: str) -> bool:
    """Return whether a text has lines of vertices and faces, as OBJ files do."""
    # The first line excludes nearly all other texts without a search through them.
    for line in text[:100_000].splitlines():
        words = line.split(None, 1)
        if words and not words[0].startswith("#"):
            return (
                words[0] in _OBJ_WORDS
                and _OBJ_VERTEX.search(text) is not None
                and _OBJ_FACE.search(text) is not None
            )
    return False


def obj_mesh(text: str) -> GamutMesh:
    """Return the mesh in the text of an OBJ file."""
    data = text.encode("utf-8", "replace")
    vertices, sides, corners = array("d"), array("q"), array("q")
    said: dict[str, str] = {}
    for line, content in _lines(data):
        words = content.split(None, 4) if content[:1] == b"v" else content.split()
        if not words:
            continue
        if words[0] == b"v":
            try:
                vertices.extend([float(words[1]), float(words[2]), float(words[3])])
            except (ValueError, IndexError):
                raise _no_line(content, line, "v x y z, with plain numbers") from None
            if b"_" in content:  # float() ignores underscores
                raise _no_line(content, line, "v x y z, with plain numbers")
        elif words[0] == b"f":
            count = len(vertices) // 3
            for word in words[1:]:
                match = _REFERENCE.fullmatch(word)
                if match is None:
                    raise _no_line(content, line, "f a b c, with whole numbers from 1")
                number = int(match[1])
                corners.append(number - 1 if number > 0 else count + number if number else -1)
            sides.append(len(words) - 1)
            if len(corners) > 3 * MAX_TRIANGLES or len(sides) > MAX_TRIANGLES:
                refuse_too_many(0, MAX_TRIANGLES + 1, where={"line": line})
        elif words[0].startswith(b"#") and len(said) < MAX_NOTES:
            note = _OBJ_NOTE.fullmatch(content[:2000].decode("utf-8", "replace").strip())
            if note:
                said.setdefault(note[1].strip(), note[2])
        if len(vertices) > 3 * MAX_SHARED_VERTICES:
            raise SampleLimitError(
                f"The mesh has more than {MAX_SHARED_VERTICES} vertices.",
                where={"line": line},
                remedy="Send it as PLY or glTF, with vertices that faces share.",
            )
    faces = polygon_triangles(np.array(sides, np.int64), np.array(corners, np.int64))
    positions = np.array(vertices, np.float64).reshape(-1, 3)
    return gamut_mesh("obj", positions, faces, stated=said)


def _lines(data: bytes) -> Iterator[tuple[int, bytes]]:
    """Yield the lines with their numbers, one at a time; a backslash continues a line."""
    unified = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n") if b"\r" in data else data
    begin = b""
    for line, end in enumerate(io.BytesIO(unified), start=1):
        content = begin + end
        if len(content) > MAX_LINE or line > MAX_LINES:
            raise SampleLimitError(
                f"The text has more than {MAX_LINES} lines, or one of more than {MAX_LINE} bytes.",
                where={"line": line},
                remedy="Send the mesh as PLY or glTF.",
            )
        begin = content[:-2] + b" " if content.endswith(b"\\\n") else b""
        if not begin:
            yield line, content


def _no_line(content: bytes, line: int, right: str, kind: str = "an OBJ") -> MalformedFileError:
    shown = content[:60].decode("ascii", "backslashreplace")
    return MalformedFileError(
        f"{shown!r} is not a line of {kind} file.", where={"line": line}, remedy=f"Write {right}."
    )


MAX_MODEL_BYTES = 2**28
"""Maximum size of the unpacked model. One of `MAX_TRIANGLES` with colours has 150 MB."""

MAX_DIRECTORY = 2**20
"""Maximum size of the archive's directory in bytes: about 10,000 files."""

MAX_ELEMENTS = 4_000_000
"""Maximum number of elements: vertices, triangles, and colours of each of these."""

MAX_TEXT = 100_000
"""Maximum number of characters of the description."""

_CHUNK = 2**20
_CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
_ARCHIVE, _END_RECORD, _END_SIZE, _LONG_END = b"PK\3\4", b"PK\5\6", 22, b"PK\6\7"
_MODEL = "3D/3dmodel.model"
_DAMAGED = (
    *(zipfile.BadZipFile, zlib.error, EOFError, OSError, struct.error),
    *(RuntimeError, NotImplementedError, ValueError, LookupError, OverflowError),
)
"""What zipfile raises for damaged, encrypted and unusual archives."""


def looks_like_threemf(data: bytes) -> bool:
    """Return whether bytes are a ZIP archive with a 3MF model in its directory."""
    return data.startswith(_ARCHIVE) and b".model" in data[-MAX_DIRECTORY - 2**16 :]


def threemf_mesh(data: bytes) -> GamutMesh:
    """Return the mesh in a 3MF file, which must have exactly one mesh."""
    reader = _Reader()
    try:
        with _package(data) as package:
            names = [name for name in package.namelist() if name.endswith(".model")]
            if _MODEL not in names and len(names) != 1:
                raise _damaged(f"The package has {len(names)} models, none of them {_MODEL}.")
            with package.open(_MODEL if _MODEL in names else names[0]) as model:
                reader.read(model)
    except _DAMAGED as error:
        raise _damaged("The package is damaged, encrypted or packed by another method.") from error
    if reader.meshes != 1 or reader.has_components:
        raise MalformedFileError(
            f"The model has {reader.meshes} meshes"
            f"{' and components' if reader.has_components else ''}.",
            where={"field": "resources"},
            remedy="Send a model with one object, which has a mesh.",
        )
    vertices = np.array(reader.vertices).reshape(-1, 3)
    warnings = []
    if reader.application.startswith("gamutcore "):
        vertices = vertices.astype(np.float32).astype(np.float64)  # exact, from nine digits
    elif reader.transform:
        vertices = vertices @ reader.transform_rows()[:3] + reader.transform_rows()[3]
        warnings.append("The transform of the build item was applied.")
    faces = np.array(reader.corners, np.int64).reshape(-1, 3)
    return gamut_mesh("3mf", vertices, faces, stated=reader.notes(), warnings=warnings)


def _package(data: bytes) -> zipfile.ZipFile:
    """Open an archive whose directory is small. Its reader makes an object of each entry."""
    place = data.rfind(_END_RECORD, max(0, len(data) - 2**16 - _END_SIZE))
    if place < 0 or len(data) < place + _END_SIZE:
        raise _damaged("The package ends early.")
    if (
        data[max(0, place - 20) : place].startswith(_LONG_END)
        or int.from_bytes(data[place + 12 : place + 16], "little") > MAX_DIRECTORY
    ):
        raise _damaged(f"The directory of the package has more than {MAX_DIRECTORY} bytes.")
    return zipfile.ZipFile(io.BytesIO(data))


def _damaged(message: str, where: Where | None = None) -> MalformedFileError:
    return MalformedFileError(
        message,
        where=where or {"field": "package"},
        remedy="Send the whole file, as a ZIP archive of 3MF.",
    )


class _Reader:
    """Expat handlers that collect the numbers of a model and enforce the limits."""

    def __init__(self) -> None:
        self.vertices, self.corners = array("d"), array("q")
        self.meshes = self.elements = 0
        self.has_components = False
        self.application = self.transform = ""
        self.metadata: dict[str, str] = {}
        self._text: list[str] | None = None  # of the current metadata
        self._name = ""
        self._length = 0
        self.expat = expat.ParserCreate(namespace_separator="}")
        self.expat.buffer_text = True
        self.expat.StartDoctypeDeclHandler = self._refuse_declaration
        self.expat.EntityDeclHandler = self._refuse_declaration
        self.expat.StartElementHandler = self._start
        self.expat.EndElementHandler = self._end
        self.expat.CharacterDataHandler = self._add_text

    def read(self, model: IO[bytes]) -> None:
        unpacked = 0
        try:
            while chunk := model.read(_CHUNK):
                unpacked += len(chunk)
                if unpacked > MAX_MODEL_BYTES:
                    raise SampleLimitError(
                        f"The unpacked model has more than {MAX_MODEL_BYTES} bytes.",
                        where={"field": "model"},
                        remedy="Send the mesh as PLY or glTF.",
                    )
                self.expat.Parse(chunk, False)
            self.expat.Parse(b"", True)
        except expat.ExpatError as error:
            raise _damaged(
                f"The XML of the model is not well formed: {expat.ErrorString(error.code)}.",
                {"line": error.lineno, "column": error.offset + 1},
            ) from None
        self.application = self.metadata.get("Application", "")

    def notes(self) -> dict[str, str]:
        """Return the lines ``name: value`` of the description, as this package writes them."""
        lines = self.metadata.get("Description", "").split("\n", MAX_STATED)[:MAX_STATED]
        pairs = (line.partition(": ") for line in lines)
        said: dict[str, str] = {}
        for name, colon, text in pairs:
            if colon:
                said.setdefault(name.strip(), text.strip())
        return said

    def transform_rows(self) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
        """Return the transform (4, 3) of row vectors."""
        words = self.transform.split()
        if len(words) != 12:
            raise _damaged("A transform has not twelve numbers.", {"field": "item"})
        return np.array([self._number(word) for word in words]).reshape(4, 3)

    def _place(self) -> Where:
        return {
            "line": self.expat.CurrentLineNumber,
            "column": self.expat.CurrentColumnNumber + 1,
        }

    def _refuse_declaration(self, *_: object) -> NoReturn:
        raise _damaged("The XML has a document type declaration.", self._place())

    def _start(self, name: str, attributes: Mapping[str, str]) -> None:
        self.elements += 1
        if self.elements > MAX_ELEMENTS:
            self._too_many(f"{MAX_ELEMENTS} elements")
        namespace, _, local = name.rpartition("}")
        if namespace != _CORE:
            return
        if local == "vertex":
            self.vertices.extend([self._number(attributes.get(axis, "")) for axis in "xyz"])
        elif local == "triangle":
            self.corners.extend(
                [self._whole(attributes.get(corner, "")) for corner in ("v1", "v2", "v3")]
            )
        elif local == "mesh":
            self.meshes += 1
        elif local == "components":
            self.has_components = True
        elif local == "item":
            self.transform = attributes.get("transform", "")
        elif local == "metadata":
            self._name, self._text = attributes.get("name", ""), []
        if len(self.vertices) > 3 * MAX_SHARED_VERTICES or len(self.corners) > 3 * MAX_TRIANGLES:
            self._too_many(f"{MAX_SHARED_VERTICES} vertices or {MAX_TRIANGLES} triangles")

    def _too_many(self, limit: str) -> NoReturn:
        raise SampleLimitError(
            f"The model has more than {limit}.",
            where=self._place(),
            remedy="Send a smaller mesh, or send it as PLY or glTF.",
        )

    def _end(self, name: str) -> None:
        if self._text is not None and name.rpartition("}")[2] == "metadata":
            self.metadata[self._name] = "".join(self._text)
            self._text = None

    def _add_text(self, text: str) -> None:
        if self._text is None:
            return
        self._length += len(text)
        if self._length > MAX_TEXT:
            raise _damaged(f"The metadata have more than {MAX_TEXT} characters.", self._place())
        self._text.append(text)

    def _number(self, word: str) -> float:
        try:
            if "_" not in word:  # float() ignores underscores
                return float(word)
        except ValueError:
            pass
        raise _damaged(f"{word[:40]!r} is not a number.", self._place())

    def _whole(self, word: str) -> int:
        if not (word.isascii() and word.isdecimal() and len(word) <= 10):
            raise _damaged(f"{word[:40]!r} is not an index of a vertex.", self._place())
        return int(word)
