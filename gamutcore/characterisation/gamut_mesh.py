"""A gamut mesh: the boundary itself, as other software computed it, rather than colours to wrap.

All readers of meshes (`gamutcore.characterisation.meshes`) end here: `gamut_mesh` checks what they
found and bounds it. Nothing is repaired; whether the triangles enclose a gamut is judged where they
become a boundary, in `gamutcore.boundary.mesh_boundary`.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gamutcore.characterisation.columns import MAX_CHANNELS
from gamutcore.characterisation.samples import JSON
from gamutcore.errors import InvalidPointsError, MalformedFileError, SampleLimitError
from gamutcore.mesh import DeviceValues

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from gamutcore.arrays import FloatArray, LongArray
    from gamutcore.errors import Where

__all__ = [
    "MAX_TRIANGLES",
    "MAX_VERTICES",
    "TOO_MANY_DEVICE_VALUES",
    "GamutMesh",
    "Statements",
    "by_channel",
    "gamut_mesh",
    "reads_device_values",
    "refuse_too_many",
    "statements",
    "unescaped",
]

MAX_TRIANGLES = 1_000_000
"""Triangles of a mesh at most: five times what the densest sampling of a device gives, and some ten
bytes each of the largest file that the service takes by default."""

MAX_VERTICES = 3 * MAX_TRIANGLES
"""Vertices at most: formats without shared vertices write three for every triangle."""

LARGEST_COORDINATE = 1e10
"""No colour has a coordinate beyond this in any space of the largest scale, and the cubes of such
numbers are harmless."""

MAX_STATED = 200
MAX_STATED_LENGTH = 500
MAX_DEVICE_VALUES = 8_000_000
"""Device values of all vertices: 15 inks at each of the 500,000 of the largest closed mesh."""

TOO_MANY_DEVICE_VALUES = (
    f"The vertices' device values are of more than {MAX_CHANNELS} channels, or more than "
    f"{MAX_DEVICE_VALUES}, and not used."
)
MAX_CHANNEL_NAME = 200
ASSUMED = "D50 (assumed, not stated)"
_ESCAPE = re.compile(r"\\(?:x([0-9a-f]{2})|u([0-9a-f]{4})|U([0-9a-f]{8}))")
_NUMBER = re.compile(r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d{1,3})?")


@dataclass(frozen=True, eq=False)
class GamutMesh:
    """Triangles that somebody calls the boundary of a gamut.

    Parameters
    ----------
    format : str
        ``"ply"``, ``"glb"``, ``"gltf"``, ``"argyll-gam"``, ``"icc"``, ``"stl"`` or ``"obj"``.
    vertices : (v, 3) float
        As the file has them.
    faces : (f, 3) int
        Indices of vertices, counter-clockwise seen from outside if the file keeps to its format.
    space : str
        ``"CIELAB"``; ``"CIEXYZ"`` where the format has X, Y, Z with Y = 1 for the white, for D50,
        that are to be brought to CIELAB. What the file itself says of its space is in
        `space_notes`, and then the vertices are taken as they are.
    centre : (3,) float or None
        The point that the file says its radii were taken from.
    space_notes : dict of str
        Names in lower case, to text: what says in which space the vertices are, if anything does;
        see `gamutcore.colours.spaces.declared`.
    device : DeviceValues or None
        Of the vertices, where the file has them.
    provenance : dict
        Format, counts, what the file says of itself; JSON-able.
    warnings : tuple of str
        What was tolerated in reading.
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


class Statements(NamedTuple):
    """What a mesh file says of itself.

    Attributes
    ----------
    said : dict of str
        Everything, as text.
    centre : (3,) float or None
    """

    said: dict[str, str]
    centre: FloatArray | None

    @property
    def by_name(self) -> dict[str, str]:
        """The same with names in lower case."""
        return {name.lower(): text for name, text in reversed(self.said.items())}


def statements(said: Mapping[str, str]) -> Statements:
    r"""Return what the notes of a mesh file, such as those of this package's own exports, state.

    Parameters
    ----------
    said : mapping of str to str
        Names to text. ``centre`` (three numbers), ``space`` with its parameters, and what the
        provenance tells of the device have a meaning, in capitals or not. What this package has
        written as ``\xb0`` where a format has no other letters than those of ASCII is read as it
        was.

    Returns
    -------
    Statements
    """
    kept = {name[:80]: text[:MAX_STATED_LENGTH] for name, text in list(said.items())[:MAX_STATED]}
    if kept.get("generator", "").startswith("gamutcore "):
        kept = {name: unescaped(text) for name, text in kept.items()}
    words = Statements(kept, None).by_name.get("centre", "").split()
    centre = None
    if len(words) == 3 and all(_NUMBER.fullmatch(word) for word in words):
        centre = np.array([float(word) for word in words])
        centre = centre if (np.abs(centre) < LARGEST_COORDINATE).all() else None
    return Statements(kept, centre)


def unescaped(text: str) -> str:
    """Return a text of letters of ASCII with those beyond them, as Python's escapes have them.

    Parameters
    ----------
    text : str

    Returns
    -------
    str
        Escapes of what ASCII has, and of no character, stay as they are.
    """

    def letter(match: re.Match[str]) -> str:
        code = int(match[1] or match[2] or match[3], 16)
        valid = 0x80 <= code < 0xD800 or 0xE000 <= code <= 0x10FFFF
        return chr(code) if valid else match[0]

    return _ESCAPE.sub(letter, text)


def refuse_too_many(vertices: int, triangles: int, *, where: Where | None = None) -> None:
    """Refuse a mesh that is too large, best by its own numbers before anything is allocated.

    Parameters
    ----------
    vertices, triangles : int
        How many it has, or says that it has.
    where : dict, optional

    Raises
    ------
    SampleLimitError
        They are more than `MAX_VERTICES` or `MAX_TRIANGLES`.
    """
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
    stated: Statements | None = None,
    space: str = "CIELAB",
    space_notes: Mapping[str, str] | None = None,
    device: Mapping[str, FloatArray] | None = None,
    clockwise: bool = False,
    provenance: Mapping[str, JSON] | None = None,
    warnings: Sequence[str] = (),
) -> GamutMesh:
    """Return a checked mesh from arrays of numbers.

    Parameters
    ----------
    file_format : str
        Name of the format that they were read from.
    vertices : (v, 3) float
    faces : (f, 3) int
        Any numbers; those that are no vertices are refused here.
    stated : Statements, optional
        What the file says of itself.
    space : str
        As for `GamutMesh`.
    space_notes : mapping, optional
        As for `GamutMesh`; what the file says of itself where not given.
    device : mapping of str to (v,) float, optional
        Device values of the vertices by the names of their channels. If they are not all numbers
        from 0 to 1, or of too many channels, they are not taken, and a warning says so.
    clockwise : bool
        Whether the format has its corners clockwise, seen from outside.
    provenance : mapping, optional
        What else is to be told.
    warnings : sequence of str

    Returns
    -------
    GamutMesh

    Raises
    ------
    SampleLimitError
        It is too large.
    MalformedFileError
        It has no triangles, or a face names a vertex that there is not.
    InvalidPointsError
        A coordinate is not finite, or beyond any colour.
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
            f"Face {face} names the vertices {[int(corner) for corner in faces[face]]}; there are "
            f"{len(vertices)}, from 0.",
            where={"field": "faces", "face": face},
            remedy="Faces name vertices of the same mesh.",
        )
    values, told_of_values = _device_values(device or {})
    channels = {} if values is None else {"channels": list[JSON](values.channels)}
    told = stated or Statements({}, None)
    notes = told.by_name
    said: dict[str, JSON] = {"stated": dict[str, JSON](told.said)} if told.said else {}
    return GamutMesh(
        file_format,
        np.ascontiguousarray(vertices, np.float64),
        np.ascontiguousarray(faces[:, ::-1] if clockwise else faces, np.int64),
        space,
        told.centre,
        {
            "format": file_format,
            "vertices_read": len(vertices),
            "triangles_read": len(faces),
            "intent": notes.get("intent", "as in the file"),
            "illuminant": notes.get("illuminant", ASSUMED),
            "observer": notes.get("observer", "2° (assumed, not stated)"),
            "adaptation": notes.get("adaptation", "none: the mesh is taken as it is"),
            **_white(notes),
            **channels,
            **said,
            **(provenance or {}),
        },
        (*warnings, *told_of_values),
        dict(notes if space_notes is None else space_notes),
        values,
    )


def reads_device_values(vertices: int, channels: int) -> bool:
    """Return whether device values are few enough to be read.

    Parameters
    ----------
    vertices, channels : int

    Returns
    -------
    bool
    """
    return channels <= MAX_CHANNELS and vertices * channels <= MAX_DEVICE_VALUES


def by_channel(found: Iterable[tuple[str, FloatArray]]) -> dict[str, FloatArray]:
    """Return device values by the names of their channels, which become distinct.

    Parameters
    ----------
    found : iterable of (str, (v,) float)
        In the order of the file.

    Returns
    -------
    dict of str
    """
    values: dict[str, FloatArray] = {}
    for name, column in found:
        channel = name[:MAX_CHANNEL_NAME].encode("utf-8", "replace").decode()
        while channel in values:
            channel += "_"
        values[channel] = column
    return values


def _device_values(found: Mapping[str, FloatArray]) -> tuple[DeviceValues | None, list[str]]:
    """Return the device values of vertices if they are such, and warnings."""
    if not found:
        return None, []
    if not reads_device_values(len(next(iter(found.values()))), len(found)):
        return None, [TOO_MANY_DEVICE_VALUES]
    values = np.stack(list(found.values()), axis=1)
    if not ((values >= 0) & (values <= 1)).all():
        return None, ["The vertices' device values are not all from 0 to 1, and not used."]
    return DeviceValues(tuple(found), values), []


def _white(notes: Mapping[str, str]) -> dict[str, JSON]:
    """Return the measured white of the device, and its luminance, where they are stated."""
    found: dict[str, JSON] = {}
    for name, count in (("white", 3), ("white_luminance", 1)):
        words = notes.get(name, "").split()
        if len(words) == count and all(_NUMBER.fullmatch(word) for word in words):
            numbers = [float(word) for word in words]
            if max(map(abs, numbers)) < LARGEST_COORDINATE:
                found[name] = list[JSON](numbers) if count > 1 else numbers[0]
    return found
