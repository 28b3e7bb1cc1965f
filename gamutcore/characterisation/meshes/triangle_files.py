"""STL and OBJ: triangles without a declared space. x, y, z are L*, a*, b*.

STL (3D Systems 1988), binary or text, has no shared vertices. Vertices and faces of OBJ (Wavefront)
are read. Comments ``# name: value`` are notes, as this package's exports write them.
"""

from __future__ import annotations

import io
import re
from array import array
from typing import TYPE_CHECKING

import numpy as np

from gamutcore.characterisation.gamut_mesh import (
    MAX_TRIANGLES,
    gamut_mesh,
    refuse_too_many,
    statements,
)
from gamutcore.characterisation.meshes.numbers import numbers_of, polygon_triangles
from gamutcore.errors import MalformedFileError, SampleLimitError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from gamutcore.characterisation.gamut_mesh import GamutMesh

__all__ = ["looks_like_obj", "looks_like_stl", "obj_mesh", "stl_mesh"]

_HEADER = 84
_FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attributes", "<u2")])
_TEXT = re.compile(rb"\s*solid\b[^\r\n]*[\r\n]+\s*facet\b")
_CORNER = re.compile(rb"\bvertex[ \t]+([^\r\n]{1,1200})")
_OBJ_VERTEX = re.compile(rb"^[ \t]*v[ \t]+[-+.\d]", re.MULTILINE)
_OBJ_FACE = re.compile(rb"^[ \t]*f[ \t]+[-\d]", re.MULTILINE)
_NOTE = re.compile(r"#\s*([\w ./-]{1,80}):\s+(.*)")
_REFERENCE = re.compile(rb"(-?\d{1,10})(?:/-?\d{0,10}){0,2}")
MAX_NOTES = 200
MAX_TEXT_TRIANGLES = 500_000
"""Maximum number of triangles in an STL text: about 100 MB."""

MAX_OBJ_VERTICES = 1_000_000
"""Maximum number of vertices in an OBJ: twice those of the largest closed mesh."""

MAX_LINES = 6_000_000
MAX_LINE = 1_000_000
"""Maximum number of lines, and maximum length of a line in bytes."""

_OBJ_WORDS = {b"v", b"vn", b"vt", b"vp", b"o", b"g", b"s", b"mtllib", b"usemtl", b"f"}


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


def looks_like_obj(data: bytes) -> bool:
    """Return whether bytes have lines of vertices and faces, as OBJ files do."""
    # The first line excludes nearly all other texts without a search through them.
    for line in data[:100_000].splitlines():
        words = line.split(None, 1)
        if words and not words[0].startswith(b"#"):
            return (
                words[0] in _OBJ_WORDS
                and _OBJ_VERTEX.search(data) is not None
                and _OBJ_FACE.search(data) is not None
            )
    return False


def obj_mesh(data: bytes) -> GamutMesh:
    """Return the mesh in an OBJ file."""
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
        if len(vertices) > 3 * MAX_OBJ_VERTICES:
            raise SampleLimitError(
                f"The mesh has more than {MAX_OBJ_VERTICES} vertices.",
                where={"line": line},
                remedy="Send it as PLY or glTF, with vertices that faces share.",
            )
    faces = polygon_triangles(np.array(sides, np.int64), np.array(corners, np.int64))
    positions = np.array(vertices, np.float64).reshape(-1, 3)
    return gamut_mesh("obj", positions, faces, stated=statements(said))


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
