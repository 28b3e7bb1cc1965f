"""glTF, binary and as JSON: accessors, views, strides, nodes, strips and fans."""

import base64
import json

import fuzz
import numpy as np

_ply = fuzz.target("ply")
check = _ply.check

_POSITIONS = _ply.OCTAHEDRON.astype("<f4").tobytes()
_INDICES = _ply.FACES.astype("<u2").tobytes()


def document(**changes: object) -> dict:
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


def glb(content: dict, chunk: bytes = _INDICES + _POSITIONS) -> bytes:
    """Return a binary glTF."""
    text = json.dumps(content).encode()
    text += b" " * (-len(text) % 4)
    body = len(text).to_bytes(4, "little") + b"JSON" + text
    body += len(chunk).to_bytes(4, "little") + b"BIN\0" + chunk
    return b"glTF" + (2).to_bytes(4, "little") + (12 + len(body)).to_bytes(4, "little") + body


def embedded(content: dict, chunk: bytes = _INDICES + _POSITIONS) -> bytes:
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
SEEDS = [
    glb(document()),
    embedded(document()),
    glb(_FAN, np.array([0, 2, 4, 3, 5, 2, 1, 2, 5, 3, 4, 2], "u1").tobytes() + _POSITIONS),
    glb(document(nodes=[{"mesh": 0, "rotation": [0.7071067811865476, 0.7071067811865476, 0, 0]}])),
]
TOKENS = [
    b'"sparse":{}', b'"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]', b'"children":[0]', b'"mesh":9',
    b"5120", b"5121", b"5122", b"5125", b"5126", b"VEC2", b"VEC4", b"SCALAR", b"normalized",
    b"true", b"null", b"{}", b"[]", b"[", b"}", b",", b'"', b"1e400", b"4294967296",
    b"99999999", b"NaN",
    b"byteStride", b"byteOffset", b"extensionsRequired", b"KHR_draco_mesh_compression", b"mode",
    b"http://a/b.bin", b"data:,", b"JSON", b"BIN\0", b"\xff\xff\xff\xff", b"gamutcore 0", b"space",
]  # fmt: skip
