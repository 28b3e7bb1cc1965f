"""A level as a mesh with what its file says about it: space, error and provenance."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from gamutcore.colours.spaces import CIELAB, ColourSpace
from gamutcore.errors import OptionError
from gamutcore.export import FORMATS, mesh_file
from gamutcore.mesh import TriangleMesh

__all__ = ["LevelMesh"]


@dataclass(frozen=True, eq=False, kw_only=True)
class LevelMesh(TriangleMesh):
    """A level of a gamut as a triangle mesh.

    Attributes
    ----------
    space : ColourSpace
        Of the vertices.
    max_error : float or None
        Upper bound of the distance from the full boundary, in both directions, in units of the
        space; None if it is not known for the triangle count.
    provenance : mapping of str to str
        Origin of the mesh, which files carry.
    """

    space: ColourSpace = CIELAB
    max_error: float | None = None
    provenance: Mapping[str, str] = field(default_factory=dict)

    def to_bytes(self, format_name: str) -> bytes:
        """Return the mesh as a file with colours, space and provenance.

        Parameters
        ----------
        format_name : str
            A key of `gamutcore.export.FORMATS`.

        Raises
        ------
        OptionError
            There is no such format.
        """
        return mesh_file(self, format_name, self.provenance, self.space)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the mesh to a file in the format of its suffix.

        Parameters
        ----------
        path : path
            With the suffix ``.glb``, ``.gltf``, ``.ply``, ``.stl`` or ``.obj``.

        Raises
        ------
        OptionError
            There is no format with the suffix.
        OSError
            The file cannot be written.
        """
        suffix = Path(path).suffix.lower()
        for name, each in FORMATS.items():
            if each.suffix == suffix:
                Path(path).write_bytes(self.to_bytes(name))
                return
        known = ", ".join(each.suffix for each in FORMATS.values())
        raise OptionError(
            f"There is no mesh format with the suffix {suffix!r}.",
            where={"field": "path"},
            remedy=f"Give a name that ends in one of {known}.",
        )
