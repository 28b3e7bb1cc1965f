"""3MF (3MF Consortium, core specification 1.3): one mesh object, parsed within limits.

The package is a ZIP archive, and the model in it is XML. Expat is driven directly, as for CxF3, and
document type declarations are refused. This package's exports have the coordinates of the colour
space as vertices, and a transform for printers in the build item. That transform is never applied.
"""

from __future__ import annotations

import io
import struct
import zipfile
import zlib
from array import array
from typing import IO, TYPE_CHECKING, NoReturn
from xml.parsers import expat

import numpy as np

from gamutcore.characterisation.gamut_mesh import (
    MAX_STATED,
    MAX_TRIANGLES,
    gamut_mesh,
    statements,
)
from gamutcore.errors import MalformedFileError, SampleLimitError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from gamutcore.characterisation.gamut_mesh import GamutMesh
    from gamutcore.errors import Where

__all__ = ["looks_like_threemf", "threemf_mesh"]

MAX_MODEL_BYTES = 2**28
"""Maximum size of the unpacked model. One of `MAX_TRIANGLES` with colours has 150 MB."""

MAX_DIRECTORY = 2**20
"""Maximum size of the archive's directory in bytes: about 10,000 files."""

MAX_VERTICES = 1_000_000
"""Maximum number of vertices: twice those of the largest closed mesh."""

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
    return gamut_mesh("3mf", vertices, faces, stated=statements(reader.notes()), warnings=warnings)


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
