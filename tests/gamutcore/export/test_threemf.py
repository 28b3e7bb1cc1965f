"""3MF, read by lib3mf, the reference implementation."""

import importlib.util

import numpy as np
import pytest

from gamutcore.colours.spaces import CIELAB, ColourSpace, srgb
from gamutcore.export import mesh_file
from gamutcore.geometry import TriangleMesh
from tests.conftest import missing


@pytest.fixture(scope="module")
def model():
    """Return a function from a file to the model that lib3mf reads strictly."""
    if importlib.util.find_spec("lib3mf") is None:
        missing("lib3mf is not installed")
    library = pytest.importorskip("lib3mf").get_wrapper()

    def read(data):
        found = library.CreateModel()
        reader = found.QueryReader("3mf")
        reader.SetStrictModeActive(True)
        reader.ReadFromBuffer(data)
        assert reader.GetWarningCount() == 0
        return found

    return read


def only_object(found):
    objects = found.GetMeshObjects()
    assert objects.MoveNext()
    return objects.GetCurrentMeshObject()


@pytest.mark.slow
def test_the_reference_implementation_reads_the_mesh_with_its_colours(model, level, provenance):
    found = model(mesh_file(level, "3mf", provenance))
    mesh = only_object(found)
    assert mesh.IsManifoldAndOriented()
    vertices = np.array([list(each.Coordinates) for each in mesh.GetVertices()], np.float32)
    faces = np.array([list(each.Indices) for each in mesh.GetTriangleIndices()])
    np.testing.assert_array_equal(vertices, level.vertices)
    np.testing.assert_array_equal(faces, level.faces)
    first = mesh.GetTriangleProperties(0)
    group = found.GetColorGroupByID(first.ResourceID)
    expected = np.rint(srgb(level.vertices[level.faces[0]]) * 255).astype(int)
    for place, colour in zip(first.PropertyIDs, expected.tolist(), strict=True):
        read = group.GetColor(place)
        assert [read.Red, read.Green, read.Blue] == colour


@pytest.mark.parametrize("space", [CIELAB, ColourSpace("Oklab"), ColourSpace("CIEXYZ")])
@pytest.mark.slow
def test_on_the_table_it_stands_upright_and_100_mm_high(model, space):
    """A tetrahedron from black to white and to two sides."""
    up = space.definition.lightness
    white = space.coordinates(np.array([[100.0, 0.0, 0.0]]))[0][0, up]
    corners = np.zeros((4, 3), np.float32)
    corners[1, up] = white
    corners[2, (up + 1) % 3] = white / 2
    corners[3, (up + 2) % 3] = -white / 4
    faces = np.array([(0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)])
    mesh = TriangleMesh(corners, faces)
    items = model(mesh_file(mesh, "3mf", {}, space)).GetBuildItems()
    assert items.MoveNext()
    transform = np.array([list(row) for row in items.GetCurrent().GetObjectTransform().Fields])
    placed = corners @ transform[:3] + transform[3]
    np.testing.assert_allclose(placed.min(axis=0), (0, 0, 0), atol=1e-3)
    np.testing.assert_allclose(placed.max(axis=0), (50, 25, 100), atol=1e-3)
    np.testing.assert_allclose(placed[1] - placed[0], (0, 0, 100), atol=1e-3)
    assert np.linalg.det(transform[:3]) > 0  # turned, not mirrored
