"""Mesh formats are told by their content; everything else is left to the other readers."""

import pytest
import trimesh

from gamutcore.characterisation import GamutMesh, Samples, characterisation
from gamutcore.characterisation.meshes import binary_mesh, text_mesh
from gamutcore.errors import OptionError

BOX = trimesh.creation.box((60.0, 50.0, 40.0))
ARGYLL = b"""GAMUT
COLOR_REP "LAB"
BEGIN_DATA_FORMAT
VERTEX_NO LAB_L LAB_A LAB_B
END_DATA_FORMAT
BEGIN_DATA
0 10 0 0
1 90 0 0
2 50 40 0
3 50 0 40
END_DATA
BEGIN_DATA_FORMAT
VERTEX_0 VERTEX_1 VERTEX_2
END_DATA_FORMAT
BEGIN_DATA
0 1 2
0 3 1
0 2 3
1 3 2
END_DATA
"""


def exported(kind):
    data = (
        trimesh.exchange.gltf.export_gltf(trimesh.Scene(BOX), embed_buffers=True)["model.gltf"]
        if kind == "gltf"
        else BOX.export(file_type=kind)
    )
    return data if isinstance(data, bytes) else data.encode()


@pytest.mark.parametrize("kind", ["ply", "glb", "gltf", "stl", "stl_ascii", "obj"])
def test_what_trimesh_writes_is_recognised(kind):
    mesh = characterisation(exported(kind))
    assert isinstance(mesh, GamutMesh)
    assert mesh.format == kind.removesuffix("_ascii")
    assert len(mesh.faces) == 12


def test_argylls_surfaces_are_recognised_before_its_samples():
    mesh = characterisation(ARGYLL)
    assert isinstance(mesh, GamutMesh)
    samples = characterisation(ARGYLL.replace(b"GAMUT", b"CTI3", 1))
    assert isinstance(samples, Samples)


@pytest.mark.parametrize(
    "data", [b"L,a,b\n50,0,0\n", b"v f g\n1 2 3\n", b'{"samples": [[1, 2, 3]]}', b"\x93NUMPY", b""]
)
def test_other_data_is_left_alone(data):
    assert binary_mesh(data) is None
    assert text_mesh(data.decode("latin-1")) is None


def test_a_mesh_has_no_measurement_condition():
    with pytest.raises(OptionError) as caught:
        characterisation(exported("ply"), condition="M1")
    assert caught.value.where == {"field": "condition"}
