"""The validator that the export tests rely on: it must pass a valid asset and name each fault."""

import base64
import json
import struct

POSITIONS = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)


def triangle(**accessor):
    """Return a glTF document of one triangle, the smallest asset with geometry."""
    uri = "data:application/octet-stream;base64," + base64.b64encode(POSITIONS).decode()
    return {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "buffers": [{"byteLength": len(POSITIONS), "uri": uri}],
        "bufferViews": [{"buffer": 0, "byteLength": len(POSITIONS), "target": 34962}],
        "accessors": [
            {
                "bufferView": 0,
                "componentType": 5126,
                "count": 3,
                "type": "VEC3",
                "min": [0, 0, 0],
                "max": [1, 1, 0],
                **accessor,
            }
        ],
    }


def codes(report):
    return {message["code"] for message in report["issues"]["messages"]}


def test_a_valid_asset_has_no_errors(gltf_report):
    report = gltf_report(json.dumps(triangle()).encode())
    assert report["issues"]["numErrors"] == 0
    assert report["info"]["totalTriangleCount"] == 1


def test_bounds_that_the_positions_exceed_are_an_error(gltf_report):
    report = gltf_report(json.dumps(triangle(max=[0.5, 1, 0])).encode())
    assert report["issues"]["numErrors"] > 0
    assert "ACCESSOR_ELEMENT_OUT_OF_MAX_BOUND" in codes(report)


def test_a_file_is_read_from_its_path(gltf_report, tmp_path):
    document = triangle()
    document["buffers"][0]["uri"] = "positions.bin"
    (tmp_path / "positions.bin").write_bytes(POSITIONS)
    path = tmp_path / "triangle.gltf"
    path.write_text(json.dumps(document))
    assert gltf_report(path)["issues"]["numErrors"] == 0


def test_a_glb_with_a_wrong_length_is_an_error(gltf_report):
    chunk = json.dumps(triangle()).encode()
    chunk += b" " * (-len(chunk) % 4)
    header = struct.pack("<4sIIII", b"glTF", 2, 20 + len(chunk) + 4, len(chunk), 0x4E4F534A)
    assert "GLB_LENGTH_MISMATCH" in codes(gltf_report(header + chunk))
