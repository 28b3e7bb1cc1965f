"""The input of a gamut as bytes: arrays and meshes become files that the readers read."""

import numpy as np
import pytest

from gamutcore.characterisation import characterisation
from gamutcore.content import content_of
from gamutcore.mesh import DeviceValues, TriangleMesh

CORNERS = np.vstack([np.zeros(3), np.eye(3)]) + 1 / 3
FACES = np.array([(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)])


def test_a_mesh_is_read_back_exactly():
    values = DeviceValues(("Reflex Blue", "é"), np.linspace(0, 1, 8).reshape(4, 2))
    read = characterisation(content_of(TriangleMesh(CORNERS, FACES, values)))
    np.testing.assert_array_equal(read.vertices, CORNERS)
    np.testing.assert_array_equal(read.faces, FACES)
    np.testing.assert_array_equal(read.device.values, values.values)
    assert read.device.channels[0] == "Reflex Blue"


def test_a_structured_array_has_columns():
    names = ("LAB_L", "LAB_A", "LAB_B", "RGB_R", "RGB_G", "RGB_B")
    read = characterisation(content_of(np.zeros(2, [(name, "f8") for name in names])))
    assert read.channels == ("R", "G", "B")


def test_bytes_stay(tmp_path):
    (tmp_path / "data").write_bytes(b"some data")
    for data in (b"some data", bytearray(b"some data"), tmp_path / "data", str(tmp_path / "data")):
        assert content_of(data) == b"some data"


@pytest.mark.parametrize("data", [np.zeros(3), np.zeros((2, 4)), np.array([["a", "b", "c"]]), 7])
def test_what_is_no_input(data):
    with pytest.raises(TypeError, match=r"\(n, 3\)"):
        content_of(data)
