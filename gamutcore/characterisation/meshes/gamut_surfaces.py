"""Gamut surfaces of colour management: Argyll CMS's `.gam`, and the boundary in iccMAX profiles.

Argyll's file, as iccgamut and tiffgamut write it, is a CGATS text with the first word GAMUT. It has
two tables: vertices (VERTEX_NO LAB_L LAB_A LAB_B) and triangles (VERTEX_0 VERTEX_1 VERTEX_2).
GAMUT_CENTER is the centre of the radii, and COLOR_REP the colour space. Surfaces in CIECAM02 (JAB)
are refused.

A profile has tags gbd0 to gbd3, one for each intent. Their type gamutBoundaryDescType (ICC.2:2019,
10.2.11) has triangles, vertices in the connection space as 32-bit floats, and optionally their
device values.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import numpy as np

from gamutcore.characterisation.icc import IccProfile
from gamutcore.characterisation.meshes.mesh import (
    MAX_TRIANGLES,
    MAX_VERTICES,
    gamut_mesh,
    numbers_of,
    refuse_too_many,
)
from gamutcore.errors import MalformedFileError, MeshError, OptionError

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray, LongArray
    from gamutcore.characterisation.meshes.mesh import GamutMesh

__all__ = ["GAMUT_BOUNDARY_TAGS", "argyll_mesh", "described_boundary", "looks_like_argyll"]

MAX_COLUMNS = 100
MAX_LAYOUT = 4_000
"""Maximum number of bytes between BEGIN_DATA_FORMAT and END_DATA_FORMAT."""

MAX_KEYWORD_LINES = 2_000

_FIRST = re.compile(r"(?:\s|#[^\r\n]*[\r\n])*GAMUT\b(?!_)")
_BEGIN = re.compile(rb"^[ \t]*BEGIN_DATA[ \t]*(?:\r\n|\r|\n)", re.MULTILINE)
_END = re.compile(rb"^[ \t]*END_DATA\b", re.MULTILINE)
_KEYWORD = re.compile(r'[ \t]*(?P<name>[A-Z][A-Z0-9_]{0,79})[ \t]+"(?P<text>[^"]*)"')
_VERTEX = ("VERTEX_NO", "LAB_L", "LAB_A", "LAB_B")
_TRIANGLE = ("VERTEX_0", "VERTEX_1", "VERTEX_2")


def looks_like_argyll(text: str) -> bool:
    """Return whether a decoded text has the type GAMUT."""
    return _FIRST.match(text[:10_000]) is not None and "BEGIN_DATA" in text


def argyll_mesh(text: str) -> GamutMesh:
    """Return the mesh in a decoded Argyll gamut file. Errors of its tables state the line."""
    data = text.replace("\r\n", "\n").replace("\r", "\n").encode("utf-8", "replace")
    said = _keywords(data)
    stated = said.get("color_rep")
    space = (stated or "LAB").strip().upper()
    if space != "LAB":
        what = ": the appearance space CIECAM02" if space == "JAB" else ""
        raise MeshError(
            f"The gamut surface's COLOR_REP is {space[:20]!r}{what}.",
            where={"field": "COLOR_REP"},
            remedy="Send a surface in CIELAB: run iccgamut without -pj.",
        )
    warnings = [] if stated else ["COLOR_REP is missing; CIELAB is assumed."]
    table, end = _table(data, 0, _VERTEX, MAX_VERTICES, "vertices")
    triangles, _ = _table(data, end, _TRIANGLE, MAX_TRIANGLES, "triangles")
    # Argyll writes corners clockwise.
    return gamut_mesh(
        "argyll-gam",
        table[:, 1:],
        _places(table[:, 0], triangles),
        stated=said,
        centre=said.get("gamut_center", ""),
        space_notes={"space": "CIELAB"},
        clockwise=True,
        warnings=warnings,
    )


def _keywords(data: bytes) -> dict[str, str]:
    begin = _BEGIN.search(data)
    head = data[: begin.start() if begin else len(data)][:200_000].decode("utf-8", "replace")
    found: dict[str, str] = {}
    for line in head.split("\n")[:MAX_KEYWORD_LINES]:
        match = _KEYWORD.match(line)
        if match:
            found.setdefault(match["name"].lower(), match["text"])
    return found


def _table(
    data: bytes, start: int, wanted: tuple[str, ...], most: int, what: str
) -> tuple[FloatArray, int]:
    """Return the wanted columns of the next table, and the end of the table."""
    opened = data.find(b"BEGIN_DATA_FORMAT", start)
    closed = data.find(b"END_DATA_FORMAT", opened + 17, opened + 17 + MAX_LAYOUT)
    begin = _BEGIN.search(data, closed) if min(opened, closed) >= 0 else None
    if begin is None:
        raise MalformedFileError(
            f"The file has no table of {what}.",
            where={"line": data.count(b"\n", 0, start) + 1},
            remedy=f"A gamut file has a table of vertices ({' '.join(_VERTEX)}) and one of "
            f"triangles ({' '.join(_TRIANGLE)}).",
        )
    names = data[opened + 17 : closed].decode("utf-8", "replace").upper().split()
    line = data.count(b"\n", 0, opened) + 1
    missing = [name for name in wanted if name not in names]
    if missing or len(names) > MAX_COLUMNS:
        raise MalformedFileError(
            f"The table of {what} has no column {missing[0]}."
            if missing
            else f"The table of {what} has {len(names)} columns.",
            where={"line": line},
            remedy=f"Its columns are {' '.join(wanted)}.",
        )
    line = data.count(b"\n", 0, begin.end()) + 1
    close = _END.search(data, begin.end())
    stop = close.start() if close else len(data)
    numbers = numbers_of(data[begin.end() : stop], line, most * len(names) + 1)
    rows, rest = divmod(len(numbers), len(names))
    if rows > most or (rows == most and rest):
        refuse_too_many(
            *((rows + 1, 0) if wanted is _VERTEX else (0, rows + 1)), where={"line": line}
        )
    if rest:
        raise MalformedFileError(
            f"The table of {what} has {len(numbers)} numbers for {len(names)} columns.",
            where={"line": line},
            remedy="Every row needs one number for each column.",
        )
    columns = [names.index(name) for name in wanted]
    return numbers.reshape(rows, len(names))[:, columns], stop


def _places(numbers: FloatArray, triangles: FloatArray) -> np.ndarray:
    """Return the rows of vertices by their numbers in triangles."""
    order = np.argsort(numbers, kind="stable")
    ranked = numbers[order]
    places = np.searchsorted(ranked, triangles)
    found = places < len(ranked)
    found[found] = ranked[places[found]] == triangles[found]
    if not found.all():
        face = int(np.argmax(~found.all(axis=1)))
        raise MalformedFileError(
            f"Triangle {face} has the vertices {[f'{n:g}' for n in triangles[face]]}; not all of "
            "them are in the table of vertices.",
            where={"field": "VERTEX_0", "face": face},
            remedy="Triangles refer to vertices by VERTEX_NO.",
        )
    return np.asarray(order[places], np.int64)


GAMUT_BOUNDARY_TAGS = {
    "perceptual": "gbd0",
    "relative": "gbd1",
    "saturation": "gbd2",
    "absolute": "gbd3",
}
"""The tag of each intent (ICC.2:2019, 9.2.80 to 9.2.83)."""

_HEAD = 20
_KIND = "gbd "
_SPACES = {"Lab": "CIELAB", "XYZ": "CIEXYZ"}


def described_boundary(data: object, intent: str) -> GamutMesh:
    """Return the gamut boundary of a profile for an intent.

    Parameters
    ----------
    data : object
        Characterisation data. Only an `IccProfile` is accepted.
    intent : str
        One of `GAMUT_BOUNDARY_TAGS`.

    Raises
    ------
    OptionError
        The data is not a profile, or has no boundary for this intent.
    MalformedProfileError
        The tag is malformed; ``where["tag"]`` names it.
    SampleLimitError, MalformedFileError, InvalidPointsError
        The mesh is too large, or a number or an index is out of range.
    """
    if not isinstance(data, IccProfile):
        raise OptionError(
            "source is 'boundary', but the data is not an ICC profile.",
            where={"field": "source"},
            remedy="Leave source out: a mesh is always used as the boundary.",
        )
    tag = GAMUT_BOUNDARY_TAGS[intent]
    if tag not in data.tags:
        others = [name for name, other in GAMUT_BOUNDARY_TAGS.items() if other in data.tags]
        raise OptionError(
            f"source is 'boundary', but the profile has none for the intent {intent}.",
            where={"field": "intent" if others else "source", "tag": tag},
            remedy=f"Ask for the intent {' or '.join(others)}."
            if others
            else "Leave it out: the profile has no gamut boundary description (gbd0 to gbd3).",
        )
    element = data.element(tag)
    if element.kind != _KIND:
        raise element.malformed(f"is of the type {element.kind!r}", f"Its type is {_KIND!r}.")
    channels, inks = element.unsigned(8, 2), element.unsigned(10, 2)
    count, triangles = element.unsigned(12, 4), element.unsigned(16, 4)
    if channels != 3:
        raise element.malformed(
            f"has {channels} channels of the connection space", f"{data.pcs} has 3."
        )
    refuse_too_many(count, triangles, where={"tag": tag})
    corners = element.raw(_HEAD, 12 * triangles)
    faces = np.frombuffer(corners, ">u4").astype(np.int64).reshape(-1, 3)
    start = _HEAD + 12 * triangles
    vertices = element.floats(start, 3 * count).reshape(-1, 3)
    if inks:  # device values are not used, but must be complete
        element.raw(start + 12 * count, 4 * inks * count)
    faces, warnings = _from_zero(faces, count)
    return gamut_mesh(
        "icc",
        vertices,
        faces,
        space=_SPACES[data.pcs],
        space_notes={"space": "CIELAB"},
        clockwise=True,  # ICC.2:2019, 10.2.11
        provenance={
            **data.provenance,
            "source": "boundary",
            "tag": tag,
            "intent": intent,
            "illuminant": "D50",
            "observer": "2°",
        },
        warnings=[*data.warnings, *warnings],
    )


def _from_zero(faces: LongArray, count: int) -> tuple[LongArray, list[str]]:
    """Return faces with indices from 0 (ICC.2:2019, 10.2.11), and warnings."""
    # The ICC's example in XML counts from 1.
    if faces.size and faces.min() == 1 and faces.max() == count:
        return faces - 1, ["The boundary counts vertices from 1 instead of 0."]
    return faces, []
