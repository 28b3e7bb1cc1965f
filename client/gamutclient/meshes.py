"""Levels as meshes, and how they are read from binary PLY."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from gamutclient.results import TabularRepr

if TYPE_CHECKING:
    import trimesh

__all__ = ["Mesh", "mesh_of_ply"]

TYPES = {"float": "<f4", "double": "<f8", "uchar": "u1", "int": "<i4"}
"""NumPy's names of the types that the service writes."""

DEVICE = "device_"
"""Prefix of properties with device values; a comment of the same name has the channel's name."""


def _not_loaded(_format_name: str) -> NoReturn:
    raise TypeError("Use `await gamut.mesh_file(format_name, ...)` for a file in another format.")


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class Mesh(TabularRepr):
    """A level as a triangle mesh.

    Attributes
    ----------
    vertices : (n, 3) float32
        In the space of the gamut.
    faces : (m, 3) int32
        Anticlockwise as seen from outside.
    device : (n, k) float32 or None
        Device values from 0 to 1.
    channels : tuple of str
    max_error : float or None
        Upper bound of the distance from the full boundary.
    """

    vertices: NDArray[np.float32]
    faces: NDArray[np.int32]
    device: NDArray[np.float32] | None
    channels: tuple[str, ...]
    max_error: float | None
    load: Callable[[str], bytes] = field(default=_not_loaded, repr=False)

    @property
    def triangles(self) -> int:
        """Number of triangles."""
        return len(self.faces)

    @property
    def volume(self) -> float:
        """Enclosed volume."""
        one, two, three = (self.vertices[self.faces[:, k]].astype(np.float64) for k in range(3))
        return float(np.einsum("ij,ij->", one, np.cross(two, three)) / 6.0)

    def to_bytes(self, format_name: str) -> bytes:
        """Return the mesh as a file of a format of the service, such as ``"glb"``."""
        return self.load(format_name)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the mesh to a file in the format of its suffix, such as ``.glb``."""
        Path(path).write_bytes(self.load(Path(path).suffix.removeprefix(".").lower()))

    def to_trimesh(self) -> trimesh.Trimesh:
        """Return a `trimesh.Trimesh`, none of whose vertices are merged."""
        import trimesh as library  # noqa: PLC0415  # optional

        made: Any = library.Trimesh(self.vertices, self.faces, process=False, validate=False)
        return made  # type: ignore[no-any-return]


def mesh_of_ply(content: bytes, max_error: float | None) -> Mesh:
    """Return the mesh in a file of the service: binary little-endian PLY of triangles."""
    head, mark, body = content.partition(b"end_header\n")
    lines = head.decode("latin-1").splitlines()
    if not mark or lines[:2] != ["ply", "format binary_little_endian 1.0"]:
        raise ValueError("The answer is not a binary little-endian PLY file.")
    words = [line.split() for line in lines]
    counts = {word[1]: int(word[2]) for word in words if word[0] == "element"}
    fields = [
        (word[2], TYPES[word[1]]) for word in words if word[0] == "property" and word[1] != "list"
    ]
    comments = dict(
        line.removeprefix("comment ").split(": ", 1)
        for line in lines
        if line.startswith("comment ") and ": " in line
    )
    vertices = np.frombuffer(body, fields, counts["vertex"])
    faces = np.frombuffer(
        body, [("corners", "u1"), ("vertices", "<i4", 3)], counts["face"], vertices.nbytes
    )
    names = [name for name, _ in fields if name.startswith(DEVICE)]
    device = np.column_stack([vertices[name] for name in names]) if names else None
    return Mesh(
        vertices=np.column_stack([vertices[axis] for axis in "xyz"]),
        faces=np.array(faces["vertices"]),
        device=device,
        channels=tuple(comments.get(name, name.removeprefix(DEVICE)) for name in names),
        max_error=max_error,
    )
