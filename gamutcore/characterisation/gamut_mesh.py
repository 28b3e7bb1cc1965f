"""A gamut mesh: the boundary itself, as other software computed it, rather than colours to wrap.

All readers of meshes (`gamutcore.characterisation.meshes`) end here: `gamut_mesh` checks what they
found and bounds it. Nothing is repaired; whether the triangles enclose a gamut is judged where they
become a boundary, in `gamutcore.boundary.given_mesh`.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gamutcore.characterisation.samples import JSON
from gamutcore.errors import InvalidPointsError, MalformedFileError, MeshError, SampleLimitError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from gamutcore.arrays import FloatArray, LongArray
    from gamutcore.errors import Where

__all__ = [
    "MAX_TRIANGLES",
    "MAX_VERTICES",
    "GamutMesh",
    "Statements",
    "gamut_mesh",
    "refuse_too_many",
    "statements",
]

MAX_TRIANGLES = 1_000_000
"""Triangles of a mesh at most: five times what the densest sampling of a device gives, and some ten
bytes each of the largest file that the service takes by default."""

MAX_VERTICES = 3 * MAX_TRIANGLES
"""Vertices at most: formats without shared vertices write three for every triangle."""

LARGEST_COORDINATE = 1e4
"""No colour has a coordinate beyond this in CIELAB, and the cubes of such numbers are harmless."""

MAX_STATED = 200
MAX_STATED_LENGTH = 500
SPACES = {"CIELAB": "CIELAB", "LAB": "CIELAB", "CIE LAB": "CIELAB", "CIEXYZ": "CIEXYZ"}
_NUMBER = re.compile(r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d{1,3})?")


@dataclass(frozen=True, eq=False)
class GamutMesh:
    """Triangles that somebody calls the boundary of a gamut.

    Parameters
    ----------
    format : str
        ``"ply"``, ``"glb"``, ``"gltf"``, ``"argyll-gam"``, ``"icc"``, ``"stl"`` or ``"obj"``.
    vertices : (v, 3) float
        In the coordinates of `space`, as the file has them.
    faces : (f, 3) int
        Indices of vertices, counter-clockwise seen from outside if the file keeps to its format.
    space : str
        ``"CIELAB"``, or ``"CIEXYZ"`` with Y = 1 for the white, for D50.
    centre : (3,) float or None
        The point that the file says its radii were taken from, in CIELAB.
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


class Statements(NamedTuple):
    """What a mesh file says of itself.

    Attributes
    ----------
    said : dict of str
        Everything, as text.
    space : str
        Its colour space, as `GamutMesh` names it; CIELAB where nothing is said.
    centre : (3,) float or None
    """

    said: dict[str, str]
    space: str
    centre: FloatArray | None


def statements(said: Mapping[str, str], *, where: Where | None = None) -> Statements:
    """Return what the notes of a mesh file, such as those of this package's own exports, state.

    Parameters
    ----------
    said : mapping of str to str
        Names, in lower case, to text. ``space`` and ``centre`` (three numbers) have a meaning.
    where : dict, optional
        Where the notes stand, for errors.

    Returns
    -------
    Statements

    Raises
    ------
    MeshError
        They are for another colour space than CIELAB.
    """
    kept = {name[:80]: text[:MAX_STATED_LENGTH] for name, text in list(said.items())[:MAX_STATED]}
    space = kept.get("space", "CIELAB")
    if SPACES.get(space.strip().upper()) != "CIELAB":
        raise MeshError(
            f"The mesh is in the colour space {space[:40]!r}.",
            where={**(where or {}), "field": "space"},
            remedy="Meshes in CIELAB (L*, a*, b* for D50) are read.",
        )
    words = kept.get("centre", "").split()
    centre = None
    if len(words) == 3 and all(_NUMBER.fullmatch(word) for word in words):
        centre = np.array([float(word) for word in words])
        centre = centre if (np.abs(centre) < LARGEST_COORDINATE).all() else None
    return Statements(kept, "CIELAB", centre)


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
    told = stated or Statements({}, space, None)
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
            "intent": told.said.get("intent", "as in the file"),
            "illuminant": "D50 (assumed, not stated)",
            "observer": "2° (assumed, not stated)",
            "adaptation": "none: the mesh is taken as it is",
            **said,
            **(provenance or {}),
        },
        tuple(warnings),
    )
