"""Meshes of the service: binary PLY to arrays."""

from __future__ import annotations

import numpy as np

from gamutclient.results import Mesh

__all__ = ["mesh_of_ply"]

TYPES = {"float": "<f4", "double": "<f8", "uchar": "u1", "int": "<i4"}
"""NumPy's names of the types that the service writes."""

DEVICE = "device_"
"""Prefix of properties with device values; a comment of the same name has the channel's name."""


def mesh_of_ply(content: bytes, max_error: float | None) -> Mesh:
    """Return the mesh in a PLY file of the service.

    Parameters
    ----------
    content : bytes
        Binary little-endian PLY of vertices and triangles.
    max_error : float or None
        Upper bound of the distance from the full boundary.

    Raises
    ------
    ValueError
        The file has another form.
    """
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
