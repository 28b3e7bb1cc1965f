"""A level as a mesh with the facts of its file: space, error and provenance."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from gamutcore.colours.spaces import CIELAB, ColourSpace
from gamutcore.errors import errors_in
from gamutcore.export import format_of_suffix, mesh_file
from gamutcore.export.picture_file import atomic_write
from gamutcore.geometry import TriangleMesh
from gamutcore.results import TabularRepr

__all__ = ["LevelMesh"]


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class LevelMesh(TabularRepr, TriangleMesh):
    """A level of a gamut as a triangle mesh.

    Attributes
    ----------
    space : ColourSpace
        Of the vertices.
    max_error : float or None
        Upper bound of the distance from the full boundary, in both directions, in units of the
        space; None if not known for the triangle count.
    provenance : mapping of str to str
        Origin of the mesh, which files carry.
    """

    space: ColourSpace = CIELAB
    max_error: float | None = None
    provenance: Mapping[str, str] = field(default_factory=dict)

    def to_bytes(
        self, format_name: str, *, into: bytes | str | os.PathLike[str] | None = None
    ) -> bytes:
        """Return the mesh as a file with colours, space and provenance.

        Parameters
        ----------
        format_name : str
            A key of `gamutcore.export.FORMATS`.
        into : bytes or path, optional
            ICC profile of version 5 that the mesh becomes the gamut boundary of, with device
            values, for the format ``icc``. All else in the profile is kept.

        Raises
        ------
        OptionError
            There is no such format, or it cannot hold the mesh, or the profile has another version
            or other channels.
        MalformedProfileError, UnsupportedProfileError
            The profile is damaged, or is not of a device.
        """
        profile = Path(into).read_bytes() if isinstance(into, str | os.PathLike) else into
        with errors_in(into):
            return mesh_file(self, format_name, self.provenance, self.space, profile)

    def save(
        self,
        path: str | os.PathLike[str],
        *,
        into: bytes | str | os.PathLike[str] | None = None,
    ) -> None:
        """Write the mesh to a file in the format of its suffix, complete or not at all.

        Parameters
        ----------
        path : path
            With the suffix of a format, such as ``.glb``.
        into : bytes or path, optional
            As for `to_bytes`. The file may be the profile itself.

        Raises
        ------
        GamutError
            There is no format with the suffix, or as for `to_bytes`.
        OSError
            The profile cannot be read, or the file cannot be written.
        """
        mesh_format = format_of_suffix(Path(path).suffix)
        data = self.to_bytes(mesh_format.name, into=into)
        with atomic_write(Path(path)) as draft:
            draft.write_bytes(data)
