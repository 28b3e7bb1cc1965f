"""The input of a gamut as the bytes of a file, from any Python object that holds it.

An array becomes the `.npy` file that `numpy.save` writes, and a mesh becomes a PLY file. The gamut
of an array therefore has the id of the gamut of such a file.
"""

from __future__ import annotations

import io
import os
from errno import ENOENT
from pathlib import Path
from typing import Any

import numpy as np

from gamutcore.errors import ReferenceNameError
from gamutcore.export.provenance import comment_lines, property_names
from gamutcore.geometry import DeviceValues, TriangleMesh
from gamutcore.references import Reference, find_reference

__all__ = ["content_of", "gamut_source", "is_saved_gamut"]

_SAVED = (b'{"format":"gamut-history"', b'{"__metadata__":{')
"""First bytes of a saved gamut's header, after eight bytes. The second is that of version 2."""


def is_saved_gamut(data: bytes) -> bool:
    """Return whether a file is a saved gamut."""
    return data[8:64].startswith(_SAVED)


def gamut_source(given: str | os.PathLike[str]) -> bytes | Reference:
    """Return the content of a file, or the reference gamut of a name if no such file exists.

    A name without file or reference raises ReferenceNameError. Other missing or unreadable files
    raise OSError.
    """
    path = Path(given)
    if path.exists():
        return path.read_bytes()
    if isinstance(given, str):
        try:
            return find_reference(given)
        except ReferenceNameError as error:
            if not path.suffix and len(path.parts) == 1:
                error.remedy = f"There is no file of this name either. {error.remedy}"
                raise
    raise FileNotFoundError(ENOENT, "There is no such file.", str(path))


def content_of(data: object) -> bytes:
    r"""Return the input of a gamut, in any form that `gamutcore.Gamut` accepts, as a file's bytes.

    Other objects raise TypeError.
    """
    if isinstance(data, bytes | bytearray | memoryview):
        return bytes(data)
    if isinstance(data, os.PathLike) or (isinstance(data, str) and "\n" not in data):
        return Path(data).read_bytes()
    if isinstance(data, str):
        raise TypeError(
            "The data is text of several lines. Give the bytes of a file, such as text.encode(), "
            "or the path of a file."
        )
    vertices, faces = getattr(data, "vertices", None), getattr(data, "faces", None)
    if vertices is not None and faces is not None:  # TriangleMesh, trimesh.Trimesh
        device = data.device if isinstance(data, TriangleMesh) else None
        return _ply(TriangleMesh(np.asarray(vertices), np.asarray(faces), device))
    if callable(getattr(data, "to_csv", None)):  # a table of named columns, such as pandas has
        table: str = data.to_csv(index=False)  # type: ignore[attr-defined]
        return table.encode()
    if hasattr(data, "profile") and callable(getattr(data, "tobytes", None)):  # PIL.ImageCms
        profile: bytes = data.tobytes()  # type: ignore[attr-defined]
        return profile
    if isinstance(data, np.ndarray | list | tuple):
        return _npy(data)
    raise TypeError(
        f"The data is of the type {type(data).__name__}. Give a path, bytes, an (n, 3) array of "
        "colours, a mesh with vertices and faces, or an ICC profile."
    )


def _npy(data: Any) -> bytes:  # noqa: ANN401  # anything that NumPy takes as an array
    colours = np.asarray(data)
    if colours.dtype.names is None:
        if colours.ndim < 2 or colours.shape[-1] != 3 or colours.dtype.kind not in "fiu":
            raise TypeError(
                f"The data is an array of shape {colours.shape} and type {colours.dtype}. Give an "
                "(n, 3) array of L*, a*, b*, or a structured array whose fields are columns."
            )
        colours = colours.reshape(-1, 3).astype(np.float64)
    file = io.BytesIO()
    np.save(file, colours, allow_pickle=False)
    return file.getvalue()


def _ply(mesh: TriangleMesh) -> bytes:
    """Return a mesh as PLY in double precision, which keeps all coordinates exactly."""
    device = mesh.device or DeviceValues(("",), np.zeros((0, 1)))
    names = () if mesh.device is None else property_names(device.channels)
    columns = [("x", "<f8"), ("y", "<f8"), ("z", "<f8"), *((name, "<f8") for name in names)]
    vertices = np.empty(len(mesh.vertices), columns)
    for axis, (name, _) in enumerate(columns):
        table = mesh.vertices if axis < 3 else device.values
        vertices[name] = table[:, axis if axis < 3 else axis - 3]
    faces = np.empty(len(mesh.faces), [("corners", "u1"), ("vertices", "<i4", 3)])
    faces["corners"], faces["vertices"] = 3, mesh.faces
    facts = dict(zip(names, device.channels, strict=False))
    header = [
        "ply",
        "format binary_little_endian 1.0",
        *(f"comment {line}" for line in comment_lines(facts)[1:]),
        f"element vertex {len(vertices)}",
        *(f"property double {name}" for name, _ in columns),
        f"element face {len(faces)}",
        "property list uchar int vertex_indices",
        "end_header\n",
    ]
    head = "\n".join(header).encode("ascii", "backslashreplace")
    return head + vertices.tobytes() + faces.tobytes()
