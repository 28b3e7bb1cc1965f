"""Delimited text, JSON and NumPy arrays with named columns."""

import io

import fuzz
import numpy as np

_cgats = fuzz.target("cgats")
check = _cgats.check

_DEVICE = [(0, 0, 0), (255, 0, 0), (0, 255, 0), (0, 0, 255), (255, 255, 255)]


def _npy() -> bytes:
    fields = [("name", "U4"), ("R", "u1"), ("G", "u1"), ("B", "u1"), ("CONDITION", "S2")]
    array = np.zeros(5, [*fields, *((f"SPEC_{nm}", "f4") for nm in range(380, 740, 20))])
    for name, column in zip("RGB", zip(*_DEVICE, strict=True), strict=True):
        array[name] = column
    array["CONDITION"] = b"M1"
    file = io.BytesIO()
    np.save(file, array)
    return file.getvalue()


_ROWS = [[*device, 20 * i, i, -i] for i, device in enumerate(_DEVICE)]
SEEDS = [
    ("R;G;B;L*;C*;h\n" + "\n".join(";".join(map(str, row)) for row in _ROWS)).encode(),
    (
        "R,G,B,x,y,Y\n" + "\n".join(f"{r},{g},{b},0.31,0.33,{s}" for r, g, b, s, *_ in _ROWS)
    ).encode(),
    ",".join(map(str, range(400, 710, 10))).encode() + b"\n" + b",".join([b"0.5"] * 31),
    (
        '{"columns": ["RGB_R", "RGB_G", "RGB_B", "XYZ_X", "XYZ_Y", "XYZ_Z"], "white": [9, 9, 9], '
        f'"samples": {_ROWS}, "conditions": {{"ILLUMINANT": "D65"}}}}'
    ).encode(),
    _npy(),
]
TOKENS = [
    b",", b";", b"\t", b"\n", b'"', b"[", b"]", b"{", b"}", b"null", b"true", b"1e5", b"LAB_L",
    b"M0_", b"CONDITION", b"samples", b"columns", b"white", b"x", b"Y", b"SPEC_380", b"<f8", b"|O",
    b"descr", b"shape", b"(5,)", b"(99999999999,)", b"fortran_order", b"True", b"U999999",
]  # fmt: skip
