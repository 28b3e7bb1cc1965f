"""ICC profiles that describe their gamut's boundary: tags gbd0 to gbd3, in Lab and XYZ."""

import fuzz
import numpy as np

from gamutcore.boundary import mesh_boundary
from gamutcore.characterisation import characterisation, described_boundary
from gamutcore.characterisation.meshes import GAMUT_BOUNDARY_TAGS
from gamutcore.errors import GamutError

_ply = fuzz.target("ply")


def element(vertices: np.ndarray, faces: np.ndarray, inks: int = 0) -> bytes:
    """Return a tag of the type gamutBoundaryDescType (ICC.2:2019, 10.2.11)."""
    counts = np.array([len(vertices), len(faces)], ">u4").tobytes()
    return (
        b"gbd \0\0\0\0"
        + np.array([3, inks], ">u2").tobytes()
        + counts
        + faces.astype(">u4").tobytes()
        + vertices.astype(">f4").tobytes()
        + np.zeros((len(vertices), inks), ">f4").tobytes()
    )


def profile(space: bytes, tags: dict[bytes, bytes]) -> bytes:
    """Return a profile of version 5 with tags."""
    table, content, offset = b"", b"", 132 + 12 * len(tags)
    for name, data in tags.items():
        table += name + offset.to_bytes(4, "big") + len(data).to_bytes(4, "big")
        content, offset = content + data, offset + len(data)
    head = bytearray(128)
    head[0:4] = offset.to_bytes(4, "big")
    head[8:12], head[12:24] = bytes([5, 0, 0, 0]), b"mntrRGB " + space
    head[36:40] = b"acsp"
    return bytes(head) + len(tags).to_bytes(4, "big") + table + content


_CLOCKWISE = _ply.FACES[:, ::-1]
_XYZ = np.array([(0.1, 0.1, 0.1), (0.9, 0.1, 0.1), (0.1, 0.9, 0.1), (0.1, 0.1, 0.7)])
SEEDS = [
    profile(b"Lab ", {b"gbd1": element(_ply.OCTAHEDRON, _CLOCKWISE, inks=3)}),
    profile(
        b"XYZ ",
        {b"gbd0": element(_XYZ, np.array([(0, 1, 2), (0, 2, 3), (0, 3, 1), (1, 3, 2)]))},
    ),
    profile(b"Lab ", {b"gbd3": element(_ply.OCTAHEDRON, _CLOCKWISE + 1)}),
]
TOKENS = [
    b"gbd ", b"gbd0", b"gbd1", b"gbd2", b"gbd3", b"Lab ", b"XYZ ", b"acsp", b"mntr", b"RGB ",
    b"\0\3", b"\0\0\0\x06", b"\0\0\0\x08", b"\x7f\xff\xff\xff", b"\xff\xff\xff\xff", b"\0\0\0\0",
    b"\x7f\x80\0\0", b"\x7f\xc0\0\0", b"\x55\x55\x55\x56",
]  # fmt: skip


def check(data: bytes) -> None:
    """Raise unless each intent's boundary is a gamut, or refused by name."""
    for intent in GAMUT_BOUNDARY_TAGS:
        try:
            mesh = described_boundary(characterisation(data), intent)
            _ply.check_mesh(mesh)
            boundary, _ = mesh_boundary(mesh)
        except GamutError:
            continue
        assert boundary.mesh.validity(boundary.centre).is_gamut
