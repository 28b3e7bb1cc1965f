"""STL, OBJ and 3MF: triangles of 3-D programs and printers. x, y, z are L*, a*, b*.

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
from typing import IO, TYPE_CHECKING, NoReturn
from xml.parsers import expat

import numpy as np

from gamutcore.characterisation.meshes.mesh import (
    MAX_STATED,
    MAX_TRIANGLES,
    gamut_mesh,
    numbers_of,
    polygon_triangles,
    refuse_too_many,
)
from gamutcore.errors import MalformedFileError, SampleLimitError

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from gamutcore.characterisation.meshes.mesh import GamutMesh
    from gamutcore.errors import Where

__all__ = [
    "looks_like_obj",
    "looks_like_stl",
    "looks_like_threemf",
    "obj_mesh",
    "stl_mesh",
    "threemf_mesh",
]

_HEADER = 84
_FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attributes", "<u2")])
_TEXT = re.compile(rb"\s*solid\b[^\r\n]*[\r\n]+\s*facet\b")
_CORNER = re.compile(rb"\bvertex[ \t]+([^\r\n]{1,1200})")
_OBJ_VERTEX = re.compile(r"^[ \t]*v[ \t]+[-+.0-9]", re.MULTILINE)
_OBJ_FACE = re.compile(r"^[ \t]*f[ \t]+[-0-9]", re.MULTILINE)
_NOTE = re.compile(r"#\s*([\w ./-]{1,80}):\s+(.*)")
_REFERENCE = re.compile(rb"(-?\d{1,10})(?:/-?\d{0,10}){0,2}")
MAX_NOTES = 200
MAX_TEXT_TRIANGLES = 500_000
"""Maximum number of triangles in an STL text: about 100 MB."""

MAX_VERTICES = 1_000_000
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
        count = data.count(b"vertex")
        if count > 3 * MAX_TEXT_TRIANGLES:
            raise SampleLimitError(
                f"The text has more than {MAX_TEXT_TRIANGLES} triangles.",
                remedy="Send the mesh as binary STL, PLY or glTF.",
            )
        found = _CORNER.findall(data)
        vertices = numbers_of(b" ".join(found), 1, 3 * len(found) + 1)
        if len(vertices) != 3 * len(found) or len(found) % 3:
            raise MalformedFileError(
                f"The {len(found)} corners, of {len(found) / 3:g} facets, have {len(vertices)} "
                "coordinates.",
                where={"field": "vertex"},
                remedy="A facet has three lines `vertex x y z`.",
            )
        vertices = vertices.reshape(-1, 3)
    faces = np.arange(len(vertices)).reshape(-1, 3)
    return gamut_mesh("stl", vertices, faces)


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
                raise _broken(content, line, "v x y z, with plain numbers") from None
            if b"_" in content:  # float() ignores underscores
                raise _broken(content, line, "v x y z, with plain numbers")
        elif words[0] == b"f":
            count = len(vertices) // 3
            for word in words[1:]:
                match = _REFERENCE.fullmatch(word)
                if match is None:
                    raise _broken(content, line, "f a b c, with whole numbers from 1")
                number = int(match[1])
                corners.append(number - 1 if number > 0 else count + number if number else -1)
            sides.append(len(words) - 1)
            if len(corners) > 3 * MAX_TRIANGLES or len(sides) > MAX_TRIANGLES:
                refuse_too_many(0, MAX_TRIANGLES + 1, where={"line": line})
        elif words[0].startswith(b"#") and len(said) < MAX_NOTES:
            note = _NOTE.fullmatch(content[:2000].decode("utf-8", "replace").strip())
            if note:
                said.setdefault(note[1].strip(), note[2])
        if len(vertices) > 3 * MAX_VERTICES:
            raise SampleLimitError(
                f"The mesh has more than {MAX_VERTICES} vertices.",
                where={"line": line},
                remedy="Send it as PLY or glTF, with vertices that faces share.",
            )
    faces = polygon_triangles(np.array(sides, np.int64), np.array(corners, np.int64))
    positions = np.array(vertices, np.float64).reshape(-1, 3)
    return gamut_mesh("obj", positions, faces, stated=said)


def _lines(data: bytes) -> Iterator[tuple[int, bytes]]:
    """Yield the lines with their numbers, one at a time."""
    unified = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n") if b"\r" in data else data
    for line, content in enumerate(io.BytesIO(unified), start=1):
        if len(content) > MAX_LINE or line > MAX_LINES:
            raise SampleLimitError(
                f"The text has more than {MAX_LINES} lines, or one of more than {MAX_LINE} bytes.",
                where={"line": line},
                remedy="Send the mesh as PLY or glTF.",
            )
        yield line, content


def _broken(content: bytes, line: int, right: str) -> MalformedFileError:
    shown = content[:60].decode("ascii", "backslashreplace")
    return MalformedFileError(
        f"{shown!r} is not a line of an OBJ file.", where={"line": line}, remedy=f"Write {right}."
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
_ARCHIVE, _END, _END_SIZE, _LONG_END = b"PK\3\4", b"PK\5\6", 22, b"PK\6\7"
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
    place = data.rfind(_END, max(0, len(data) - 2**16 - _END_SIZE))
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
        if len(self.vertices) > 3 * MAX_VERTICES or len(self.corners) > 3 * MAX_TRIANGLES:
            self._too_many(f"{MAX_VERTICES} vertices or {MAX_TRIANGLES} triangles")

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
