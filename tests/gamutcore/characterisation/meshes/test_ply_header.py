"""Headers of PLY files."""

import pytest

from gamutcore.characterisation.meshes.ply_header import device_properties, ply_header
from gamutcore.errors import MalformedFileError

HEADER = (
    b"ply\nformat ascii 1.0\ncomment Space: CIELAB\nelement vertex 4\nproperty float x\n"
    b"property float device_C\nproperty list uchar float device_list\nproperty int device_n\n"
    b"element face 4\nproperty float device_face\nproperty list uchar int vertex_indices\n"
    b"end_header\n0 0 0"
)


def test_elements_notes_and_the_place_where_rows_begin():
    header = ply_header(HEADER)
    assert header.said == {"Space": "CIELAB"}
    assert [(element.name, element.count) for element in header.elements] == [
        ("vertex", 4),
        ("face", 4),
    ]
    assert HEADER[header.size :] == b"0 0 0"


def test_device_values_are_fractions_at_vertices():
    vertex, face = ply_header(HEADER).elements
    assert device_properties(vertex) == ["device_C"]
    assert device_properties(face) == []
    assert [prop.name for prop in vertex.properties if prop.kept] == ["x", "device_C"]


def test_a_header_without_a_format_is_refused():
    with pytest.raises(MalformedFileError) as caught:
        ply_header(HEADER.replace(b"format ascii 1.0\n", b""))
    assert caught.value.where == {"line": 1}
