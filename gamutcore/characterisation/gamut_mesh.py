"""A gamut mesh: a boundary that other software computed, rather than colours to wrap.

All readers in `gamutcore.characterisation.meshes` call `gamut_mesh`, which checks and limits the
numbers. Nothing is repaired. Whether the triangles enclose a gamut is judged where they
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
from gamutcore.geometry import DeviceValues

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


class Statements(NamedTuple):
    """Notes of a mesh file about itself, all as texts in `said`, and its centre (3,), if any."""

    said: dict[str, str]
    centre: FloatArray | None

    @property
    def by_name(self) -> dict[str, str]:
        """The notes, with names in lower case."""
        return {name.lower(): text for name, text in reversed(self.said.items())}


def statements(said: Mapping[str, str]) -> Statements:
    r"""Return the notes of a mesh file, such as those of this package's exports.

    ``centre`` (three numbers), ``space`` with its parameters, and facts about the device have a
    meaning, in any letter case. Escapes such as ``\xb0``, which this package writes in ASCII
    formats, are decoded.
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
    stated: Statements | None = None,
    space: str = "CIELAB",
    space_notes: Mapping[str, str] | None = None,
    device: Mapping[str, FloatArray] | None = None,
    clockwise: bool = False,
    provenance: Mapping[str, JSON] | None = None,
    warnings: Sequence[str] = (),
) -> GamutMesh:
    """Return a checked mesh from arrays of numbers; indices out of range are refused.

    Notes of the space are those of the file unless `space_notes` are given. `device` has (v,)
    values by channel name; values outside 0 to 1, and too many channels, give a warning and are not
    used. `clockwise` states whether corners are clockwise in the format, seen from outside.
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


def _white(notes: Mapping[str, str]) -> dict[str, JSON]:
    """Return the measured white of the device, and its luminance, if stated."""
    found: dict[str, JSON] = {}
    for name, count in (("white", 3), ("white_luminance", 1)):
        words = notes.get(name, "").split()
        if len(words) == count and all(_NUMBER.fullmatch(word) for word in words):
            numbers = [float(word) for word in words]
            if max(map(abs, numbers)) < LARGEST_COORDINATE:
                found[name] = list[JSON](numbers) if count > 1 else numbers[0]
    return found
