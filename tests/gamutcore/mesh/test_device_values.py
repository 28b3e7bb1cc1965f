"""Device values at vertices: accepted arrays."""

import numpy as np
import pytest

from gamutcore.errors import MeshError
from gamutcore.mesh import DeviceValues, TriangleMesh

FACES = np.array([(0, 1, 2), (0, 2, 3), (0, 3, 1), (1, 3, 2)], np.int32)
CORNERS = np.array([(50, 0, 40), (50, 40, -20), (50, -40, -20), (90, 0, 0)], np.float32)


def test_there_is_a_row_for_each_vertex():
    device = DeviceValues(("C", "M"), np.zeros((4, 2)))
    assert len(device) == 4
    assert TriangleMesh(CORNERS, FACES, device).device is device
    with pytest.raises(MeshError, match="3 rows for 4 vertices"):
        TriangleMesh(CORNERS, FACES, DeviceValues(("C", "M"), np.zeros((3, 2))))


@pytest.mark.parametrize(
    ("channels", "values"),
    [
        (("C",), np.zeros((4, 2))),
        ((), np.zeros((4, 0))),
        (("C",), np.zeros(4)),
        (("C",), np.zeros((4, 1), int)),
        (("C",), np.full((4, 1), 1.001)),
        (("C",), np.full((4, 1), -0.001)),
        (("C",), np.full((4, 1), np.nan)),
    ],
)
def test_other_arrays_are_refused(channels, values):
    with pytest.raises(MeshError):
        DeviceValues(channels, values)


def test_meshes_differ_by_them():
    one, other = (DeviceValues(("C",), np.full((4, 1), value)) for value in (0.25, 0.5))
    assert one == DeviceValues(("C",), np.full((4, 1), 0.25))
    assert one != other
    assert one != DeviceValues(("M",), np.full((4, 1), 0.25))
    assert TriangleMesh(CORNERS, FACES, one) == TriangleMesh(CORNERS, FACES, one)
    assert TriangleMesh(CORNERS, FACES, one) != TriangleMesh(CORNERS, FACES, other)
    assert TriangleMesh(CORNERS, FACES, one) != TriangleMesh(CORNERS, FACES)
