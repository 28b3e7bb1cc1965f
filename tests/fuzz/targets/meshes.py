"""Meshes: PLY, glTF, Argyll's gamuts, OBJ and STL, and profiles that describe their boundary."""

import base64
import io
import json
import zipfile

import numpy as np

from gamutcore.export.triangle_files import threemf
from gamutcore.geometry import TriangleMesh
from targets.checks import Target, check_described_boundary
from targets.profiles import profile

OCTAHEDRON = np.array(
    [(90, 0, 0), (10, 0, 0), (50, 40, 0), (50, -40, 0), (50, 0, 40), (50, 0, -40)], float
)
FACES = np.array(
    [(0, 2, 4), (0, 4, 3), (0, 3, 5), (0, 5, 2), (1, 4, 2), (1, 3, 4), (1, 5, 3), (1, 2, 5)]
)
CUBE = np.array([(x, y, z) for x in (10, 90) for y in (-40, 40) for z in (-40, 40)], float)
SQUARES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def header(order, vertices, faces, number="float", notes=""):
    """Return the header of a mesh with colours and triangles."""
    return (
        f"ply\nformat {order} 1.0\ncomment generator: fuzz\n{notes}"
        f"element vertex {vertices}\nproperty {number} x\nproperty {number} y\n"
        f"property {number} z\nproperty uchar red\nelement face {faces}\n"
        "property list uchar int vertex_indices\nend_header\n"
    ).encode()


def binary(order):
    """Return an octahedron in binary PLY."""
    mark = {"binary_little_endian": "<", "binary_big_endian": ">"}[order]
    rows = np.zeros(len(OCTAHEDRON), [("p", f"{mark}f4", 3), ("red", "u1")])
    rows["p"] = OCTAHEDRON
    faces = np.zeros(len(FACES), [("n", "u1"), ("v", f"{mark}i4", 3)])
    faces["n"], faces["v"] = 3, FACES
    head = header(order, len(rows), len(faces), notes="comment centre: 50 0 0\n")
    return head + rows.tobytes() + faces.tobytes()


def text(vertices, faces):
    """Return a mesh of polygons in PLY as text."""
    rows = [" ".join(map(repr, row)) + " 255" for row in vertices.tolist()]
    rows += [" ".join(map(str, [len(face), *face])) for face in faces]
    head = header("ascii", len(vertices), len(faces), "double")
    return head + ("\n".join(rows) + "\n").encode()


def mixed():
    """Return a cube of squares, one of them as triangles, in binary."""
    faces = [*SQUARES[1:], SQUARES[0][:3], (0, 3, 2)]
    rows = np.zeros(len(CUBE), [("p", "<f4", 3), ("red", "u1")])
    rows["p"] = CUBE
    lists = b"".join(bytes([len(f)]) + np.array(f, "<i4").tobytes() for f in faces)
    return header("binary_little_endian", len(CUBE), len(faces)) + rows.tobytes() + lists


_PLY = [
    binary("binary_little_endian"),
    binary("binary_big_endian"),
    text(OCTAHEDRON, FACES.tolist()),
    text(CUBE, SQUARES),
    mixed(),
]
_PLY_TOKENS = [
    *b"ply format ascii binary_little_endian binary_big_endian 1.0 comment element vertex".split(),
    *b"face property list uchar int float double uint char short x y z vertex_indices".split(),
    *b"vertex_index end_header obj_info centre: space: CIELAB CIEXYZ 4294967295 2147483648".split(),
    *(b"\n", b"\r\n", b" ", b"\xff\xff\xff\xff", b"\xff\xff\xff\x7f", b"\0\0\xc0\x7f", b"\0" * 8),
]


_ROWS = OCTAHEDRON.tolist()
_FACES = FACES.tolist()
_GAM = (
    'GAMUT  \n\nCOLOR_REP "LAB"\nGAMUT_CENTER "50.000000 0.000000 0.000000"\n'
    'CUSP_RED "49.8 71.0 50.8"\n# First come the vertices\nNUMBER_OF_FIELDS 4\n'
    "BEGIN_DATA_FORMAT\nVERTEX_NO LAB_L LAB_A LAB_B \nEND_DATA_FORMAT\nNUMBER_OF_SETS 6\n"
    "BEGIN_DATA\n"
    + "".join(f"{i} {row[0]} {row[1]} {row[2]} \n" for i, row in enumerate(_ROWS))
    + "END_DATA\nNUMBER_OF_FIELDS 3\nBEGIN_DATA_FORMAT\nVERTEX_0 VERTEX_1 VERTEX_2 \n"
    "END_DATA_FORMAT\nNUMBER_OF_SETS 8\nBEGIN_DATA\n"
    + "".join(f"{a} {c} {b} \n" for a, b, c in _FACES)
    + "END_DATA\n"
)
_OBJ = "# centre: 50 0 0\no gamut\n" + "".join(
    [
        *(f"v {x} {y} {z} 0.1 0.2 0.3\n" for x, y, z in _ROWS),
        *(f"f {a + 1}/1/1 {b + 1}//2 {c - 6}\n" for a, b, c in _FACES),
    ]
)
_STL = (
    "solid gamut\n"
    + "".join(
        "facet normal 0 0 0\nouter loop\n"
        + "".join("vertex {} {} {}\n".format(*_ROWS[corner]) for corner in face)
        + "endloop\nendfacet\n"
        for face in _FACES
    )
    + "endsolid gamut\n"
)
_facets = np.zeros(8, [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attributes", "<u2")])
_facets["corners"] = OCTAHEDRON[FACES]
_3MF = threemf(TriangleMesh(OCTAHEDRON.astype(np.float32), FACES), {"centre": "50 0 0"})
with zipfile.ZipFile(io.BytesIO(_3MF)) as _package:
    _STORED = io.BytesIO()  # without compression, so that changes reach the XML
    with zipfile.ZipFile(_STORED, "w") as _plain:
        for _name in _package.namelist():
            _plain.writestr(zipfile.ZipInfo(_name), _package.read(_name))
_MESH_TEXTS = [
    _3MF,
    _STORED.getvalue(),
    _GAM.encode(),
    _GAM.replace("\n", "\r\n").encode(),
    _OBJ.encode(),
    _STL.encode(),
    bytes(80) + (8).to_bytes(4, "little") + _facets.tobytes(),
]
_MESH_TEXTS_TOKENS = [
    *b"GAMUT COLOR_REP JAB LAB XYZ GAMUT_CENTER BEGIN_DATA END_DATA BEGIN_DATA_FORMAT".split(),
    *b"END_DATA_FORMAT VERTEX_NO VERTEX_0 VERTEX_3 LAB_L LAB_A solid facet vertex endsolid".split(),
    *b"v f vn vt usemtl 1/2/3 -1 0 2147483648 99999999999 1e400 nan space: CIEXYZ".split(),
    *(b"\n", b"\r", b"\r\n", b"\t", b'"', b"#", b"/", b"//", b"\0\0\xc0\x7f"),
    *(b"PK\3\4", b"PK\1\2", b"PK\5\6", b".model", b"<mesh>", b"</mesh>", b"<!DOCTYPE a>"),
]


_POSITIONS = OCTAHEDRON.astype("<f4").tobytes()
_INDICES = FACES.astype("<u2").tobytes()


def document(**changes):
    """Return the JSON of an octahedron; `changes` replace its members."""
    return {
        "asset": {"version": "2.0", "generator": "fuzz", "extras": {"centre": "50 0 0"}},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"children": [1], "translation": [0, 0, 0]}, {"mesh": 0, "scale": [1, 1, 1]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 1}, "indices": 0, "mode": 4}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5123, "count": 24, "type": "SCALAR"},
            {"bufferView": 1, "componentType": 5126, "count": 6, "type": "VEC3"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 72, "byteStride": 12},
        ],
        "buffers": [{"byteLength": 120}],
        **changes,
    }


def glb(content, chunk=_INDICES + _POSITIONS):
    """Return a binary glTF."""
    text = json.dumps(content).encode()
    text += b" " * (-len(text) % 4)
    body = len(text).to_bytes(4, "little") + b"JSON" + text
    body += len(chunk).to_bytes(4, "little") + b"BIN\0" + chunk
    return b"glTF" + (2).to_bytes(4, "little") + (12 + len(body)).to_bytes(4, "little") + body


def embedded(content, chunk=_INDICES + _POSITIONS):
    """Return a glTF with its buffer embedded."""
    uri = "data:application/octet-stream;base64," + base64.b64encode(chunk).decode()
    return json.dumps({**content, "buffers": [{"byteLength": len(chunk), "uri": uri}]}).encode()


_FAN = document(
    meshes=[
        {
            "primitives": [
                {"attributes": {"POSITION": 1}, "indices": 0, "mode": 6},
                {"attributes": {"POSITION": 1}, "indices": 2, "mode": 6},
            ]
        }
    ],
    accessors=[
        {"bufferView": 0, "componentType": 5121, "count": 6, "type": "SCALAR"},
        {"bufferView": 1, "componentType": 5126, "count": 6, "type": "VEC3"},
        {"bufferView": 0, "byteOffset": 6, "componentType": 5121, "count": 6, "type": "SCALAR"},
    ],
    bufferViews=[
        {"buffer": 0, "byteOffset": 0, "byteLength": 12},
        {"buffer": 0, "byteOffset": 12, "byteLength": 72},
    ],
)
_GLTF = [
    glb(document()),
    embedded(document()),
    glb(_FAN, np.array([0, 2, 4, 3, 5, 2, 1, 2, 5, 3, 4, 2], "u1").tobytes() + _POSITIONS),
    glb(document(nodes=[{"mesh": 0, "rotation": [0.7071067811865476, 0.7071067811865476, 0, 0]}])),
]
_GLTF_TOKENS = [
    b'"sparse":{}', b'"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]', b'"children":[0]', b'"mesh":9',
    b"5120", b"5121", b"5122", b"5125", b"5126", b"VEC2", b"VEC4", b"SCALAR", b"normalized",
    b"true", b"null", b"{}", b"[]", b"[", b"}", b",", b'"', b"1e400", b"4294967296",
    b"99999999", b"NaN",
    b"byteStride", b"byteOffset", b"extensionsRequired", b"KHR_draco_mesh_compression", b"mode",
    b"http://a/b.bin", b"data:,", b"JSON", b"BIN\0", b"\xff\xff\xff\xff", b"gamutcore 0", b"space",
]  # fmt: skip


def element(vertices, faces, inks=0):
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


_CLOCKWISE = FACES[:, ::-1]
_XYZ = np.array([(0.1, 0.1, 0.1), (0.9, 0.1, 0.1), (0.1, 0.9, 0.1), (0.1, 0.1, 0.7)])
_TETRAHEDRON = np.array([(0, 1, 2), (0, 2, 3), (0, 3, 1), (1, 3, 2)])
_BOUNDARIES = [
    profile({"gbd1": element(OCTAHEDRON, _CLOCKWISE, inks=3)}, version=5),
    profile({"gbd0": element(_XYZ, _TETRAHEDRON)}, pcs="XYZ ", version=5),
    profile({"gbd3": element(OCTAHEDRON, _CLOCKWISE + 1)}, version=5),
]
_BOUNDARIES_TOKENS = [
    b"gbd ", b"gbd0", b"gbd1", b"gbd2", b"gbd3", b"Lab ", b"XYZ ", b"acsp", b"mntr", b"RGB ",
    b"\0\3", b"\0\0\0\x06", b"\0\0\0\x08", b"\x7f\xff\xff\xff", b"\xff\xff\xff\xff", b"\0\0\0\0",
    b"\x7f\x80\0\0", b"\x7f\xc0\0\0", b"\x55\x55\x55\x56",
]  # fmt: skip


TARGETS = {
    "ply": Target(_PLY, _PLY_TOKENS),
    "argyll": Target(_MESH_TEXTS, _MESH_TEXTS_TOKENS),
    "gltf": Target(_GLTF, _GLTF_TOKENS),
    "gamut_boundary": Target(_BOUNDARIES, _BOUNDARIES_TOKENS, check_described_boundary),
}
