"""glTF: structure, transforms, and documents that break it."""

import base64
import copy
import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gamutcore.characterisation import read_characterisation
from gamutcore.errors import GamutError, MalformedFileError, SampleLimitError

POSITIONS = np.array([(10, 0, 0), (90, 0, 0), (50, 40, 0), (50, 0, 40)], "<f4")
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
CONTENT = POSITIONS.tobytes() + FACES.astype("<u2").tobytes()


def document(**changes):
    return {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 24},
        ],
        "buffers": [{"byteLength": 72}],
        **changes,
    }


def written(content, chunk=CONTENT):
    uri = "data:application/octet-stream;base64," + base64.b64encode(chunk).decode()
    content = copy.deepcopy(content)
    content["buffers"] = [{"byteLength": len(chunk), "uri": uri}]
    return json.dumps(content).encode()


def binary(content, chunk=CONTENT):
    text = json.dumps(content).encode()
    text += b" " * (-len(text) % 4)
    parts = len(text).to_bytes(4, "little") + b"JSON" + text
    parts += len(chunk).to_bytes(4, "little") + b"BIN\0" + chunk
    return b"glTF" + (2).to_bytes(4, "little") + (12 + len(parts)).to_bytes(4, "little") + parts


@pytest.mark.parametrize(("write", "name"), [(written, "gltf"), (binary, "glb")])
def test_both_forms(write, name):
    mesh = read_characterisation(write(document()))
    np.testing.assert_array_equal(mesh.vertices, POSITIONS)
    np.testing.assert_array_equal(mesh.faces, FACES)
    assert mesh.format == mesh.provenance["format"] == name
    assert mesh.warnings == ()


def test_vertices_may_be_interleaved_and_without_indices():
    rows = np.zeros(12, [("normal", "<f4", 3), ("p", "<f4", 3)])
    rows["p"] = POSITIONS[FACES].reshape(-1, 3)
    mesh = read_characterisation(
        written(
            document(
                meshes=[{"primitives": [{"attributes": {"POSITION": 0}}]}],
                accessors=[
                    {
                        "bufferView": 0,
                        "byteOffset": 12,
                        "componentType": 5126,
                        "count": 12,
                        "type": "VEC3",
                    }
                ],
                bufferViews=[{"buffer": 0, "byteLength": 288, "byteStride": 24}],
            ),
            rows.tobytes(),
        )
    )
    np.testing.assert_array_equal(mesh.vertices[mesh.faces], POSITIONS[FACES])


@pytest.mark.parametrize(
    ("mode", "indices", "triangles"),
    [
        # glTF 2.0, 3.7.2.1: strips pᵢ = {vᵢ, vᵢ₊₍₁₊ᵢ﹪₂₎, vᵢ₊₍₂₋ᵢ﹪₂₎}, fans pᵢ = {vᵢ₊₁, vᵢ₊₂, v₀}
        (5, [0, 2, 1, 3, 0, 2], [[0, 2, 1], [2, 3, 1], [1, 3, 0], [3, 2, 0]]),
        (6, [0, 2, 1, 3, 2, 1], [[2, 1, 0], [1, 3, 0], [3, 2, 0], [2, 1, 0]]),
    ],
)
def test_strips_and_fans(mode, indices, triangles):
    content = document()
    content["meshes"][0]["primitives"][0]["mode"] = mode
    content["accessors"][1]["count"] = 6
    mesh = read_characterisation(
        written(content, POSITIONS.tobytes() + np.array(indices, "<u2").tobytes() * 2)
    )
    assert mesh.faces.tolist() == triangles


def test_transforms_of_nodes_are_applied_and_told():
    """Scale, then a quarter turn about z, then a shift; and a parent's matrix, column by column."""
    half = np.sqrt(0.5)
    nodes = [
        {"children": [1], "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 7, 1]},
        {
            "mesh": 0,
            "scale": [2, 1, 1],
            "rotation": [0, 0, half, half],
            "translation": [1, 0, 0],
        },
    ]
    mesh = read_characterisation(written(document(nodes=nodes)))
    x, y, z = POSITIONS.T.astype(float)
    np.testing.assert_allclose(mesh.vertices, np.stack([1 - y, 2 * x, z + 7], axis=1), atol=1e-5)
    assert "transforms" in mesh.warnings[0]


@pytest.mark.parametrize("generator", ["gamutcore 0.1.0", "another program"])
def test_the_turn_for_display_is_never_applied(generator):
    half = 0.7071067811865476
    content = document(nodes=[{"mesh": 0, "rotation": [half, half, 0.0, 0.0]}])
    content["asset"]["generator"] = generator
    mesh = read_characterisation(written(content))
    np.testing.assert_array_equal(mesh.vertices, POSITIONS)
    assert bool(mesh.warnings) == (generator == "another program")


def test_extras_state_the_centre_and_the_space():
    asset = {"version": "2.0", "extras": {"centre": "50 1 2.5", "space": "CIELAB", "n": 5}}
    mesh = read_characterisation(written(document(asset=asset)))
    assert mesh.centre.tolist() == [50, 1, 2.5]
    asset["extras"]["space"] = "Oklab"
    assert read_characterisation(written(document(asset=asset))).space_notes["space"] == "Oklab"


DEVICE = np.array([0.0, 0.25, 0.5, 1.0], "<f4")


def with_device_values(count, **changes):
    content = document(**changes)
    accessor = {"bufferView": 2, "componentType": 5126, "count": 4, "type": "SCALAR"}
    content["accessors"].append(accessor)
    content["bufferViews"].append({"buffer": 0, "byteOffset": 72, "byteLength": 16})
    attributes = content["meshes"][0]["primitives"][0]["attributes"]
    attributes |= {f"_DEVICE_{number}": 2 for number in range(count)}
    return read_characterisation(written(content, CONTENT + DEVICE.tobytes()))


@pytest.mark.parametrize("count", [2, 15, 16])
def test_device_values_are_read_up_to_fifteen_channels(count):
    mesh = with_device_values(count)
    np.testing.assert_array_equal(mesh.vertices, POSITIONS)
    if count <= 15:
        np.testing.assert_array_equal(mesh.device.values, np.tile(DEVICE, (count, 1)).T)
        assert mesh.warnings == ()
    else:
        assert mesh.device is None
        assert "channels" in mesh.warnings[0]


def test_device_values_of_all_places_of_a_mesh_are_bounded(monkeypatch):
    monkeypatch.setattr("gamutcore.characterisation.meshes.mesh.MAX_DEVICE_VALUES", 12)
    assert with_device_values(2).device is not None
    twice = {"nodes": [{"mesh": 0}, {"mesh": 0}], "scenes": [{"nodes": [0, 1]}]}
    mesh = with_device_values(2, **twice)
    assert len(mesh.vertices) == 8
    assert mesh.device is None
    assert "channels" in mesh.warnings[0]


def test_statements_are_bounded():
    extras = {f"name {number}" * 50: "x" * 10_000 for number in range(300)}
    mesh = read_characterisation(written(document(asset={"version": "2.0", "extras": extras})))
    told = mesh.provenance["stated"]
    assert len(told) <= 200
    assert all(len(name) <= 80 and len(text) <= 500 for name, text in told.items())


def changed(path, value):
    content = document()
    inner = content
    for step in path[:-1]:
        inner = inner[step]
    inner[path[-1]] = value
    return content


@pytest.mark.parametrize(
    ("path", "value", "problem"),
    [
        (["asset"], {"version": "1.0"}, "asset"),
        (["extensionsRequired"], ["KHR_draco_mesh_compression"], "draco"),
        (["nodes", 0, "mesh"], 4, "meshes\\[4\\]"),
        (["nodes", 0, "children"], [0], "twice"),
        (["scenes", 0, "nodes"], [3], "nodes\\[3\\]"),
        (["nodes", 0, "scale"], [1, 2], "3 numbers"),
        (["nodes", 0, "rotation"], [0, 0, 0, 0], "rotation"),
        (["nodes", 0, "matrix"], [1e300] * 16, "range"),
        (["accessors", 0, "count"], 5, "needs"),
        (["accessors", 0, "count"], -1, "whole number"),
        (["accessors", 0, "type"], "VEC4", "VEC3"),
        (["accessors", 0, "sparse"], {}, "sparse"),
        (["accessors", 0, "bufferView"], True, "whole number"),
        (["accessors", 1, "componentType"], 5126, "unsigned"),
        (["accessors", 1, "count"], 11, "multiple of 3"),
        (["bufferViews", 0, "byteStride"], 4, "needs"),
        (["bufferViews", 0, "byteLength"], 47, "needs"),
        (["bufferViews", 1, "byteOffset"], 2**31, "needs"),
        (["meshes", 0, "primitives"], [], "no triangles"),
        (["meshes", 0, "primitives", 0, "mode"], 1, "no triangles"),
    ],
)
def test_what_breaks_the_format_is_named(path, value, problem):
    with pytest.raises(MalformedFileError, match=problem) as caught:
        read_characterisation(written(changed(path, value)))
    assert caught.value.where["field"]


@pytest.mark.parametrize("uri", ["mesh.bin", "http://localhost/mesh.bin", "file:///etc/passwd"])
def test_nothing_outside_the_file_is_read(uri):
    data = json.dumps(document(buffers=[{"byteLength": 72, "uri": uri}])).encode()
    with pytest.raises(MalformedFileError, match="nothing outside"):
        read_characterisation(data)


def test_a_mesh_in_many_places_is_bounded():
    nodes = [{"mesh": 0} for _ in range(1500)]
    content = document(nodes=nodes, scenes=[{"nodes": list(range(1500))}])
    with pytest.raises(SampleLimitError):
        read_characterisation(written(content))
    with pytest.raises(SampleLimitError):
        read_characterisation(written(document(extras=[[]] * 60_000)))


def test_a_binary_that_ends_early_is_refused():
    data = binary(document())
    for end in (10, 20, 60, len(data) - 1):
        with pytest.raises(MalformedFileError):
            read_characterisation(data[:end])


JSON_VALUE = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner),
    max_leaves=4,
)


def paths(value, path=()):
    inner = value.items() if isinstance(value, dict) else enumerate(value)
    for key, item in inner:
        yield (*path, key)
        if isinstance(item, dict | list):
            yield from paths(item, (*path, key))


@given(st.data(), JSON_VALUE)
@pytest.mark.slow
def test_any_value_anywhere_gives_a_mesh_or_a_named_error(data, value):
    path = data.draw(st.sampled_from(list(paths(document()))))
    try:
        mesh = read_characterisation(binary(changed(path, value)))
    except GamutError:
        return
    assert mesh.faces.max() < len(mesh.vertices)
