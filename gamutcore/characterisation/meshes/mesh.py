"""A gamut mesh: a boundary that other software computed, rather than colours to wrap.

All readers of this folder call `gamut_mesh`, which checks and limits the numbers. Nothing is
repaired. Whether the triangles enclose a gamut is judged where they become a boundary, in
`gamutcore.boundary.mesh_boundary`. Text is converted to numbers in blocks, so the memory for words
is a few times the size of a block.

The formats of colour management are read here. Argyll's `.gam`, as iccgamut and tiffgamut write it,
is a CGATS text with the first word GAMUT. It has two tables: vertices (VERTEX_NO LAB_L LAB_A LAB_B)
and triangles (VERTEX_0 VERTEX_1 VERTEX_2). GAMUT_CENTER is the centre of the radii, and COLOR_REP
the colour space. Surfaces in CIECAM02 (JAB) are refused. A profile has tags gbd0 to gbd3, one for
each intent. Their type gamutBoundaryDescType (ICC.2:2019, 10.2.11) has triangles, vertices in the
connection space as 32-bit floats, and optionally their device values.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from gamutcore.characterisation.columns import MAX_CHANNELS
from gamutcore.characterisation.icc import IccProfile
from gamutcore.characterisation.samples import JSON
from gamutcore.errors import (
    InvalidPointsError,
    MalformedFileError,
    MeshError,
    OptionError,
    SampleLimitError,
)
from gamutcore.geometry import DeviceValues

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from gamutcore.arrays import FloatArray, LongArray
    from gamutcore.errors import Where

__all__ = [
    "GAMUT_BOUNDARY_TAGS",
    "MAX_TRIANGLES",
    "MAX_VERTICES",
    "TOO_MANY_DEVICE_VALUES",
    "GamutMesh",
    "argyll_mesh",
    "by_channel",
    "embedded_boundary",
    "gamut_mesh",
    "looks_like_argyll",
    "numbers_of",
    "polygon_triangles",
    "reads_device_values",
    "refuse_too_many",
    "unescaped",
]

MAX_TRIANGLES = 1_000_000
"""Maximum number of triangles: five times the densest sampling of a device."""

MAX_VERTICES = 3 * MAX_TRIANGLES
"""Maximum number of vertices. Formats without shared vertices have three per triangle."""

LARGEST_COORDINATE = 1e10
"""Maximum absolute coordinate. No colour space exceeds it, and cubes of such numbers are finite."""

MAX_STATED = 200
MAX_STATED_LENGTH = 500
MAX_DEVICE_VALUES = 8_000_000
"""Maximum number of device values: 15 inks for 500,000 vertices, the largest closed mesh."""

TOO_MANY_DEVICE_VALUES = (
    f"The vertices have more than {MAX_CHANNELS} channels, or more than {MAX_DEVICE_VALUES} device "
    "values; these are not used."
)
MAX_CHANNEL_NAME = 200
ASSUMED = "D50 (assumed, not stated)"
_ESCAPE = re.compile(r"\\(?:x([0-9a-f]{2})|u([0-9a-f]{4})|U([0-9a-f]{8}))")
_NUMBER = re.compile(r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d{1,3})?")


@dataclass(frozen=True, eq=False)
class GamutMesh:
    """Triangles that a file declares to be the boundary of a gamut.

    Parameters
    ----------
    format : str
        ``"ply"``, ``"glb"``, ``"gltf"``, ``"argyll-gam"``, ``"icc"``, ``"3mf"``,
        ``"stl"`` or ``"obj"``.
    vertices : (v, 3) float
        As in the file.
    faces : (f, 3) int
        Indices of vertices, counter-clockwise seen from outside in correct files.
    space : str
        ``"CIELAB"``, or ``"CIEXYZ"`` (D50, white Y = 1) if the format has such vertices, which must
        be converted. The space that the file itself declares is in `space_notes`.
    centre : (3,) float or None
        Centre of the radii that the file states.
    space_notes : dict of str
        Notes about the space of the vertices: names in lower case, to texts;
        see `gamutcore.colours.spaces`.
    device : DeviceValues or None
        Device values of the vertices, if the file has them.
    provenance : dict
        Format, counts and notes of the file; JSON-able.
    warnings : tuple of str
        Faults that the reader tolerated.
    """

    format: str
    vertices: FloatArray
    faces: LongArray
    space: str = "CIELAB"
    centre: FloatArray | None = None
    provenance: dict[str, JSON] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    space_notes: dict[str, str] = field(default_factory=dict)
    device: DeviceValues | None = None


def unescaped(text: str) -> str:
    """Return an ASCII text with Python's escapes replaced by the characters.

    Escapes of ASCII characters, and of no character, are kept.
    """

    def letter(match: re.Match[str]) -> str:
        code = int(match[1] or match[2] or match[3], 16)
        valid = 0x80 <= code < 0xD800 or 0xE000 <= code <= 0x10FFFF
        return chr(code) if valid else match[0]

    return _ESCAPE.sub(letter, text)


def refuse_too_many(vertices: int, triangles: int, *, where: Where | None = None) -> None:
    """Refuse a mesh that is too large. Readers call it before they allocate memory."""
    if vertices > MAX_VERTICES or triangles > MAX_TRIANGLES:
        raise SampleLimitError(
            f"The mesh has {vertices} vertices and {triangles} triangles.",
            where=where,
            remedy=f"At most {MAX_VERTICES} vertices and {MAX_TRIANGLES} triangles are accepted.",
        )


def gamut_mesh(
    file_format: str,
    vertices: FloatArray,
    faces: LongArray,
    *,
    stated: Mapping[str, str] | None = None,
    centre: str | None = None,
    space: str = "CIELAB",
    space_notes: Mapping[str, str] | None = None,
    device: Mapping[str, FloatArray] | None = None,
    clockwise: bool = False,
    provenance: Mapping[str, JSON] | None = None,
    warnings: Sequence[str] = (),
) -> GamutMesh:
    r"""Return a checked mesh from arrays of numbers; indices out of range are refused.

    `stated` are the notes of the file about itself, such as those of this package's exports.
    ``centre`` (three numbers), ``space`` with its parameters, and facts about the device have a
    meaning, in any letter case. Escapes such as ``\xb0``, which this package writes in ASCII
    formats, are decoded. `centre` and `space_notes` replace what the notes say of these.

    `device` has (v,) values by channel name; values outside 0 to 1, and too many channels, give a
    warning and are not used. `clockwise` states whether corners are clockwise in the format, seen
    from outside.
    """
    refuse_too_many(len(vertices), len(faces))
    if len(faces) < 4 or len(vertices) < 4:
        raise MalformedFileError(
            f"The mesh has {len(vertices)} vertices and {len(faces)} triangles.",
            where={"field": "faces"},
            remedy="A gamut's boundary is a closed surface of triangles, at least four.",
        )
    with np.errstate(invalid="ignore"):
        bad = ~(np.abs(vertices) <= LARGEST_COORDINATE).all(axis=1)
    if bad.any():
        vertex = int(np.argmax(bad))
        raise InvalidPointsError(
            f"Vertex {vertex} is at {[float(value) for value in vertices[vertex]]}.",
            where={"field": "vertices", "vertex": vertex},
            remedy="Coordinates are finite numbers, such as L* 50, a* 20, b* -30.",
        )
    wrong = ((faces < 0) | (faces >= len(vertices))).any(axis=1)
    if wrong.any():
        face = int(np.argmax(wrong))
        raise MalformedFileError(
            f"Face {face} has the vertices {[int(corner) for corner in faces[face]]}; the mesh has "
            f"{len(vertices)}, counted from 0.",
            where={"field": "faces", "face": face},
            remedy="Faces have indices of vertices of the same mesh.",
        )
    values, told_of_values = _device_values(device or {})
    channels = {} if values is None else {"channels": list[JSON](values.channels)}
    kept = list((stated or {}).items())[:MAX_STATED]
    said = {name[:80]: text[:MAX_STATED_LENGTH] for name, text in kept}
    if said.get("generator", "").startswith("gamutcore "):
        said = {name: unescaped(text) for name, text in said.items()}
    notes = {name.lower(): text for name, text in reversed(said.items())}
    middle = _numbers(notes.get("centre", "") if centre is None else centre, 3)
    white = _numbers(notes.get("white", ""), 3)
    luminance = _numbers(notes.get("white_luminance", ""), 1)
    return GamutMesh(
        file_format,
        np.ascontiguousarray(vertices, np.float64),
        np.ascontiguousarray(faces[:, ::-1] if clockwise else faces, np.int64),
        space,
        None if middle is None else np.array(middle),
        {
            "format": file_format,
            "vertices_read": len(vertices),
            "triangles_read": len(faces),
            "intent": notes.get("intent", "as in the file"),
            "illuminant": notes.get("illuminant", ASSUMED),
            "observer": notes.get("observer", "2° (assumed, not stated)"),
            "adaptation": notes.get("adaptation", "none: the mesh is taken as it is"),
            **({"white": list[JSON](white)} if white else {}),
            **({"white_luminance": luminance[0]} if luminance else {}),
            **channels,
            **({"stated": dict[str, JSON](said)} if said else {}),
            **(provenance or {}),
        },
        (*warnings, *told_of_values),
        dict(notes if space_notes is None else space_notes),
        values,
    )


def reads_device_values(vertices: int, channels: int) -> bool:
    """Return whether the number of device values is within the limits."""
    return channels <= MAX_CHANNELS and vertices * channels <= MAX_DEVICE_VALUES


def by_channel(found: Iterable[tuple[str, FloatArray]]) -> dict[str, FloatArray]:
    """Return device values (v,) by channel name, in the file's order.

    Repeated names get underscores.
    """
    values: dict[str, FloatArray] = {}
    for name, column in found:
        channel = name[:MAX_CHANNEL_NAME].encode("utf-8", "replace").decode()
        while channel in values:
            channel += "_"
        values[channel] = column
    return values


def _device_values(found: Mapping[str, FloatArray]) -> tuple[DeviceValues | None, list[str]]:
    """Return valid device values of vertices, or None, and warnings."""
    if not found:
        return None, []
    if not reads_device_values(len(next(iter(found.values()))), len(found)):
        return None, [TOO_MANY_DEVICE_VALUES]
    values = np.stack(list(found.values()), axis=1)
    if not ((values >= 0) & (values <= 1)).all():
        return None, ["The vertices have device values outside 0 to 1; these are not used."]
    return DeviceValues(tuple(found), values), []


def _numbers(text: str, count: int) -> list[float] | None:
    """Return the numbers of a note; None unless there are `count`, in the range of coordinates."""
    words = text.split()
    if len(words) != count or not all(_NUMBER.fullmatch(word) for word in words):
        return None
    numbers = [float(word) for word in words]
    return numbers if max(map(abs, numbers)) < LARGEST_COORDINATE else None


_BLOCK = 1 << 20
"""Bytes of text that are converted together."""

_SPACE = re.compile(rb"\s")
_PLAIN = re.compile(rb"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d{1,3})?")
LONGEST_WORD = 400
"""Maximum length of a number. A double with all its decimals has about 330 characters."""


def numbers_of(text: bytes, line: int, most: int) -> FloatArray:
    """Return at most `most` numbers of a text that are separated by white space.

    Words such as ``nan``, ``inf`` or ``1e999`` give infinite values or NaN. `line` is the line at
    the start of the text; errors state the line.
    """
    blocks, found, place = [], 0, 0
    while place < len(text) and found < most:
        end = min(place + _BLOCK, len(text))
        if end < len(text):
            space = _SPACE.search(text, end, end + LONGEST_WORD)
            if space is None and len(text) > end + LONGEST_WORD:
                raise _no_number(text[end : end + 40], text, end, line)
            end = len(text) if space is None else space.end()
        words = text[place:end].split()
        try:
            block = np.array([float(word) for word in words])
        except ValueError:
            block = None
        # float() also accepts 1_000.
        if block is None or b"_" in text[place:end]:
            raise _first_fault(text, place, line)
        blocks.append(block)
        found += len(block)
        place = end
    numbers = np.concatenate(blocks) if blocks else np.empty(0)
    return numbers[:most]


def _first_fault(text: bytes, place: int, line: int) -> MalformedFileError:
    for word in re.finditer(rb"\S+", text[place : place + _BLOCK + LONGEST_WORD]):
        if len(word[0]) > LONGEST_WORD or not _PLAIN.fullmatch(word[0]):
            return _no_number(word[0], text, place + word.start(), line)
    return _no_number(b"", text, place, line)


def _no_number(word: bytes, text: bytes, place: int, line: int) -> MalformedFileError:
    shown = word[:40].decode("ascii", "backslashreplace")
    return MalformedFileError(
        f"{shown!r} is not a number.",
        where={"line": line + text.count(b"\n", 0, place)},
        remedy="Write plain decimal numbers, such as 12.5.",
    )


def polygon_triangles(sides: LongArray, corners: LongArray) -> LongArray:
    """Return the triangles (m, 3) of polygons, each split from its first corner.

    `sides` has the number of corners of each polygon, and `corners` their vertices, polygon by
    polygon. Polygons with fewer than three corners have no triangles.
    """
    triangles = np.maximum(sides - 2, 0)
    starts = np.repeat(np.cumsum(sides) - sides, triangles)
    # Number of each triangle in its polygon.
    within = np.arange(int(triangles.sum())) - np.repeat(
        np.cumsum(triangles) - triangles, triangles
    )
    places = np.stack([starts, starts + within + 1, starts + within + 2], axis=1)
    return np.asarray(corners[places], np.int64)


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


def embedded_boundary(data: object, intent: str) -> GamutMesh:
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
