"""Argyll's gamut surfaces, and OBJ and STL, the other meshes that are texts."""

import fuzz
import numpy as np

_ply = fuzz.target("ply")
check = _ply.check

_ROWS = _ply.OCTAHEDRON.tolist()
_FACES = _ply.FACES.tolist()
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
_facets["corners"] = _ply.OCTAHEDRON[_ply.FACES]
SEEDS = [
    _GAM.encode(),
    _GAM.replace("\n", "\r\n").encode(),
    _OBJ.encode(),
    _STL.encode(),
    bytes(80) + (8).to_bytes(4, "little") + _facets.tobytes(),
]
TOKENS = [
    *b"GAMUT COLOR_REP JAB LAB XYZ GAMUT_CENTER BEGIN_DATA END_DATA BEGIN_DATA_FORMAT".split(),
    *b"END_DATA_FORMAT VERTEX_NO VERTEX_0 VERTEX_3 LAB_L LAB_A solid facet vertex endsolid".split(),
    *b"v f vn vt usemtl 1/2/3 -1 0 2147483648 99999999999 1e400 nan space: CIEXYZ".split(),
    *(b"\n", b"\r", b"\r\n", b"\t", b'"', b"#", b"/", b"//", b"\0\0\xc0\x7f"),
]
