"""Bodies of queries: JSON, .npy and CSV, and the answers to what is read."""

import io
import json
from typing import Any

import numpy as np

from gamutcore import Gamut
from gamutcore.errors import GamutError
from service.problems.problem import ProblemError
from service.queries.answers import WRITERS
from service.queries.bodies import CSV, JSON, NPY, parse_body
from service.queries.levels import QueryLevel
from service.queries.operations import OPERATIONS
from service.queries.parameters import values_of

CUBE = Gamut((2.0 * np.array(list(np.ndindex(2, 2, 2))) - 1) * 20 + (50, 0, 0), gamma=1)
LEVEL = QueryLevel(CUBE, CUBE.history.triangles, 0.0)


def npy(array: np.ndarray) -> bytes:
    """Return an array as a file."""
    file = io.BytesIO()
    np.save(file, array)
    return file.getvalue()


COLOURS = np.array([[50, 0, 0], [50, 90, 0], [10.5, -3, 1e-3]])
ENDS = np.hstack([COLOURS, COLOURS[::-1]])
SEEDS = [
    json.dumps({"colours": COLOURS.tolist(), "distance": True, "tolerance": 0.5}).encode(),
    json.dumps({"colours": COLOURS.tolist(), "metric": "CIE 2000", "space": "LCHab"}).encode(),
    json.dumps({"colours": COLOURS.tolist(), "method": "clip-focal", "focus": [50, 0, 0]}).encode(),
    json.dumps({"from": COLOURS.tolist(), "to": COLOURS[::-1].tolist(), "kind": "ray"}).encode(),
    npy(COLOURS),
    npy(COLOURS.astype(np.float32)),
    npy(np.asfortranarray(ENDS)),
    b"name,L*,a*,b*\nRed,48,68,48\nBlue,20,60,-90\n",
    b'name;LAB_L;LAB_A;LAB_B\r\n"Red; pale";48,5;68;48\r\n',
    b"from_L*,from_a*,from_b*,to_L*,to_a*,to_b*\n50,0,0,50,90,0\n",
]
TOKENS = [
    *b"colours from to triangles max_error space metric method focus source kind tolerance".split(),
    *b"distance true false null cusp sgck clip-nearest clip-hue clip-lightness LCHab sRGB".split(),
    *b"L* a* b* LAB_L from_L* to_b* descr fortran_order shape <f4 <f8 >f8 |O (3,) (0, 3)".split(),
    *(b"[", b"]", b"{", b"}", b",", b";", b'"', b"\n", b"\r\n", b"[" * 500, b"1e308", b"1e-320"),
]


def check(data: bytes) -> None:
    """Raise unless each operation refuses the body by name, or answers every row."""
    form = NPY if data.startswith(b"\x93NUMPY") else JSON if data.startswith(b"{") else CSV
    for operation in OPERATIONS.values():
        try:
            body = parse_body(bytearray(data), form, operation, LEVEL.axes)
            values = values_of(operation.all_parameters, {}, body.members)
            if values.get("source") is not None:
                continue
            result = operation.answer(LEVEL, body.inputs, values)
            written: Any = WRITERS[form](operation, LEVEL, body)
            content = written.head(result, body.rows) + written.piece(0, result)
        except (GamutError, ProblemError):
            continue
        assert all(np.isfinite(points).all() for points in body.inputs)
        if form == JSON:
            columns = json.loads(content)
            assert all(len(columns[name]) == body.rows for name in result.columns)
