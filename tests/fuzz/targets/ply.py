"""PLY files, text and binary of both byte orders: triangles, polygons, further properties."""

import numpy as np

from gamutcore.boundary import mesh_boundary
from gamutcore.characterisation import GamutMesh, characterisation
from gamutcore.errors import GamutError

OCTAHEDRON = np.array(
    [(90, 0, 0), (10, 0, 0), (50, 40, 0), (50, -40, 0), (50, 0, 40), (50, 0, -40)], float
)
FACES = np.array(
    [(0, 2, 4), (0, 4, 3), (0, 3, 5), (0, 5, 2), (1, 4, 2), (1, 3, 4), (1, 5, 3), (1, 2, 5)]
)
CUBE = np.array([(x, y, z) for x in (10, 90) for y in (-40, 40) for z in (-40, 40)], float)
SQUARES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def header(order: str, vertices: int, faces: int, number: str = "float", notes: str = "") -> bytes:
    """Return the header of a mesh with colours and triangles."""
    return (
        f"ply\nformat {order} 1.0\ncomment generator: fuzz\n{notes}"
        f"element vertex {vertices}\nproperty {number} x\nproperty {number} y\n"
        f"property {number} z\nproperty uchar red\nelement face {faces}\n"
        "property list uchar int vertex_indices\nend_header\n"
    ).encode()


def binary(order: str) -> bytes:
    """Return an octahedron in binary PLY."""
    mark = {"binary_little_endian": "<", "binary_big_endian": ">"}[order]
    rows = np.zeros(len(OCTAHEDRON), [("p", f"{mark}f4", 3), ("red", "u1")])
    rows["p"] = OCTAHEDRON
    faces = np.zeros(len(FACES), [("n", "u1"), ("v", f"{mark}i4", 3)])
    faces["n"], faces["v"] = 3, FACES
    head = header(order, len(rows), len(faces), notes="comment centre: 50 0 0\n")
    return head + rows.tobytes() + faces.tobytes()


def text(vertices: np.ndarray, faces: list) -> bytes:
    """Return a mesh of polygons in PLY as text."""
    rows = [" ".join(map(repr, row)) + " 255" for row in vertices.tolist()]
    rows += [" ".join(map(str, [len(face), *face])) for face in faces]
    head = header("ascii", len(vertices), len(faces), "double")
    return head + ("\n".join(rows) + "\n").encode()


def mixed() -> bytes:
    """Return a cube of squares, one of them as triangles, in binary."""
    faces = [*SQUARES[1:], SQUARES[0][:3], (0, 3, 2)]
    rows = np.zeros(len(CUBE), [("p", "<f4", 3), ("red", "u1")])
    rows["p"] = CUBE
    lists = b"".join(bytes([len(f)]) + np.array(f, "<i4").tobytes() for f in faces)
    return header("binary_little_endian", len(CUBE), len(faces)) + rows.tobytes() + lists


SEEDS = [
    binary("binary_little_endian"),
    binary("binary_big_endian"),
    text(OCTAHEDRON, FACES.tolist()),
    text(CUBE, SQUARES),
    mixed(),
]
TOKENS = [
    *b"ply format ascii binary_little_endian binary_big_endian 1.0 comment element vertex".split(),
    *b"face property list uchar int float double uint char short x y z vertex_indices".split(),
    *b"vertex_index end_header obj_info centre: space: CIELAB CIEXYZ 4294967295 2147483648".split(),
    *(b"\n", b"\r\n", b" ", b"\xff\xff\xff\xff", b"\xff\xff\xff\x7f", b"\0\0\xc0\x7f", b"\0" * 8),
]


def check(data: bytes) -> None:
    """Raise unless the file is refused by name, or read, and a gamut or refused by name."""
    try:
        read = characterisation(data)
        if not isinstance(read, GamutMesh):
            return
        check_mesh(read)
        boundary, provenance = mesh_boundary(read)
    except GamutError:
        return
    assert boundary.mesh.validity(boundary.centre).is_gamut
    assert provenance["mesh"]


def check_mesh(mesh: GamutMesh) -> None:
    """Raise unless a mesh is as its class says."""
    assert np.isfinite(mesh.vertices).all()
    assert mesh.vertices.shape[1:] == mesh.faces.shape[1:] == (3,)
    assert mesh.faces.min() >= 0
    assert mesh.faces.max() < len(mesh.vertices)
    assert mesh.device is None or len(mesh.device) == len(mesh.vertices)
