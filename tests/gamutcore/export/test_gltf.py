"""GLB and glTF: accepted by Khronos' validator, with all elements of the design."""

import io
import json
from dataclasses import replace

import numpy as np
import pygltflib
import pytest
import trimesh

from gamutcore.colours.spaces import SPACES, ColourSpace
from gamutcore.export import mesh_file
from gamutcore.geometry import DeviceValues, TriangleMesh


def asset_of(data, kind):
    if kind == "glb":
        return pygltflib.GLTF2.load_from_bytes(data)
    return pygltflib.GLTF2.gltf_from_json(data.decode())


@pytest.fixture(params=["glb", "gltf"])
def kind(request):
    return request.param


@pytest.fixture
def written(level, kind, provenance):
    return mesh_file(level, kind, provenance)


class TestValidity:
    @pytest.mark.slow
    def test_khronos_validator_finds_nothing(self, gltf_report, written, level):
        report = gltf_report(written)
        assert report["issues"]["numErrors"] == 0, report["issues"]["messages"]
        assert report["issues"]["numWarnings"] == 0, report["issues"]["messages"]
        assert report["info"]["totalTriangleCount"] == level.triangles
        assert report["info"]["totalVertexCount"] == len(level.vertices)


class TestGeometry:
    def test_positions_and_faces_are_bit_equal(self, written, kind, level, gltf_accessor):
        asset = asset_of(written, kind)
        (primitive,) = asset.meshes[0].primitives
        positions = gltf_accessor(asset, primitive.attributes.POSITION)
        assert positions.astype("<f4").tobytes() == level.vertices.astype("<f4").tobytes()
        faces = gltf_accessor(asset, primitive.indices).reshape(-1, 3)
        np.testing.assert_array_equal(faces, level.faces)
        assert primitive.mode in {None, 4}


class TestAnotherReader:
    """trimesh reads the files correctly."""

    def test_reads_the_same_mesh_upright(self, written, kind, level):
        scene = trimesh.load_scene(io.BytesIO(written), file_type=kind, process=False)
        (mesh,) = scene.geometry.values()
        np.testing.assert_array_equal(mesh.vertices, level.vertices.astype(np.float32))
        np.testing.assert_array_equal(mesh.faces, level.faces)
        (node,) = scene.graph.nodes_geometry
        matrix, _ = scene.graph[node]
        turned = level.vertices @ matrix[:3, :3].T
        upright = level.vertices[:, [1, 0, 2]] * (1, 1, -1)  # a* to the right, L* up, b* away
        np.testing.assert_allclose(turned, upright, atol=1e-4)


class TestAppearance:
    @pytest.mark.slow
    def test_colours_are_linear_16_bit_integers(
        self, written, kind, level, gltf_accessor, displayed
    ):
        asset = asset_of(written, kind)
        (primitive,) = asset.meshes[0].primitives
        accessor = asset.accessors[primitive.attributes.COLOR_0]
        assert (accessor.componentType, accessor.type, accessor.normalized) == (5123, "VEC4", True)
        stored = gltf_accessor(asset, primitive.attributes.COLOR_0)
        assert (stored[:, 3] == 65535).all()
        linear = displayed(level.vertices, encoded=False)
        np.testing.assert_allclose(stored[:, :3] / 65535, linear, atol=1e-5)


class TestProvenance:
    def test_is_in_the_assets_extras(self, written, kind, provenance):
        asset = asset_of(written, kind)
        assert asset.asset.extras == provenance
        assert asset.asset.generator.startswith("gamutcore ")


class TestDeviceValues:
    """Each channel is a 32-bit scalar attribute, named in the extras of the mesh."""

    def test_are_attributes(self, press_gamut, kind, provenance, gltf_accessor):
        level = press_gamut.level(1000)
        document = tree_of(mesh_file(level, kind, provenance), kind)
        asset = asset_of(mesh_file(level, kind, provenance), kind)
        (mesh,) = document["meshes"]
        names = mesh["extras"]["device_channels"]
        assert names == {f"_DEVICE_{ink}": ink for ink in "CMYK"}
        attributes = mesh["primitives"][0]["attributes"]
        assert set(attributes) == {"POSITION", "COLOR_0", *names}
        for channel, name in enumerate(names):
            accessor = document["accessors"][attributes[name]]
            assert (accessor["componentType"], accessor["type"]) == (5126, "SCALAR")
            values = gltf_accessor(asset, attributes[name])
            np.testing.assert_array_equal(values, level.device.values[:, channel])
            assert accessor["min"] == [values.min()]
            assert accessor["max"] == [values.max()]

    @pytest.mark.parametrize("triangles", [4, 1000])
    def test_are_valid(self, gltf_report, press_gamut, kind, triangles):
        issues = gltf_report(mesh_file(press_gamut.level(triangles), kind))["issues"]
        assert issues["numErrors"] == issues["numWarnings"] == 0, issues["messages"]

    def test_of_strange_and_of_many_channels(self, gltf_report, level, kind):
        channels = ("Größe", "gold", "GOLD", "\ud800", "", *map(str, range(60)))
        values = np.zeros((len(level.vertices), len(channels)), np.float32)
        values[:, ::3] = 1.0
        mesh = replace(level, device=DeviceValues(channels, values))
        written = mesh_file(mesh, kind)
        report = gltf_report(written)
        assert report["issues"]["numErrors"] == 0, report["issues"]["messages"]
        extras = tree_of(written, kind)["meshes"][0]["extras"]["device_channels"]
        assert len(extras) == len(channels)
        assert extras["_DEVICE_GR_E"] == "Größe"


def tree_of(data, kind):
    """Return the JSON of a glTF asset."""
    if kind == "glb":
        length = int.from_bytes(data[12:16], "little")
        data = data[20 : 20 + length]
    return json.loads(data)


@pytest.mark.parametrize("name", SPACES)
def test_every_space_shows_lightness_upwards_and_the_same_colours(
    press_gamut, kind, name, gltf_accessor, displayed
):
    level = press_gamut.history.level(1000)  # coarser ones have vertices of imaginary colours
    space = ColourSpace(name)
    positions, _ = space.coordinates(np.asarray(level.vertices, np.float64))
    mesh = TriangleMesh(positions.astype(np.float32), level.faces)
    asset = asset_of(mesh_file(mesh, kind, {}, space), kind)
    (node,) = [node for node in asset.nodes if node.mesh is not None]
    assert node.rotation == list(space.rotation)
    (primitive,) = asset.meshes[0].primitives
    stored = gltf_accessor(asset, primitive.attributes.COLOR_0)[:, :3] / 65535
    assert np.abs(stored - displayed(level.vertices, encoded=False)).max() < 1e-4
