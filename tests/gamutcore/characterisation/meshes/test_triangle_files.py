"""STL and OBJ: triangles, wherever and however they are numbered."""

import numpy as np
import pytest
import trimesh

from gamutcore.characterisation.meshes.triangle_files import (
    looks_like_obj,
    looks_like_stl,
    obj_mesh,
    stl_mesh,
)
from gamutcore.errors import GamutError, MalformedFileError, SampleLimitError

BOX = trimesh.creation.box((60.0, 50.0, 40.0))
CORNERS = np.asarray(BOX.vertices)[BOX.faces]


@pytest.mark.parametrize("kind", ["stl", "stl_ascii"])
def test_stl_of_trimesh_in_both_forms(kind):
    data = BOX.export(file_type=kind)
    data = data if isinstance(data, bytes) else data.encode()
    assert looks_like_stl(data)
    mesh = stl_mesh(data)
    np.testing.assert_allclose(mesh.vertices[mesh.faces], CORNERS, atol=1e-6)
    assert mesh.format == "stl"


def test_stl_of_another_length_than_it_says_is_not_taken_for_one():
    data = BOX.export(file_type="stl")
    assert not looks_like_stl(data[:-1])
    assert not looks_like_stl(b"R,G,B,L,a,b\n" * 20)


def test_obj_of_trimesh():
    data = BOX.export(file_type="obj").encode()
    assert looks_like_obj(data)
    mesh = obj_mesh(data)
    np.testing.assert_allclose(mesh.vertices[mesh.faces], CORNERS, atol=1e-6)


def test_obj_with_polygons_references_and_notes():
    text = (
        b"# centre: 1 2 3\n# made by hand\nmtllib a.mtl\n\nv 0 0 0\nv 1 0 0 0.5 0.5 0.5\nv 1 1 0\n"
        b"v 0 1 0\nvt 0 0\nf 1/1 2/1 3/1 4/1\nv 0 0 1\nf -1 -5//2 4/1/2\nf 1 2 5\n"
        b"f 2 3 5\nf 3 4 5\n"
    )
    mesh = obj_mesh(text)
    assert mesh.faces.tolist()[:3] == [[0, 1, 2], [0, 2, 3], [4, 0, 3]]
    assert mesh.centre.tolist() == [1, 2, 3]


@pytest.mark.parametrize(
    ("line", "place"),
    [
        (b"v 1 2", {"line": 5}),
        (b"v 1 2 x", {"line": 5}),
        (b"v 1 2 1_0", {"line": 5}),
        (b"f 1 2 three", {"line": 5}),
        (b"f 1 2 7", {"face": 0}),
        (b"f 1 2 0", {"face": 0}),
        (b"f -9 1 2", {"face": 0}),
    ],
)
def test_what_is_broken_in_obj_is_named(line, place):
    text = (
        b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 1\n" + line + b"\nf 1 2 3\nf 1 2 4\nf 2 3 4\nf 1 3 4\n"
    )
    with pytest.raises(MalformedFileError) as caught:
        obj_mesh(text)
    assert place.items() <= caught.value.where.items()


def test_obj_states_its_space():
    faces = "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
    data = f"# space: CIEXYZ\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n{faces}"
    assert obj_mesh(data.encode()).space_notes == {"space": "CIEXYZ"}


@pytest.mark.slow
def test_too_many_triangles_are_refused():
    count = 1_000_001
    with pytest.raises(SampleLimitError):
        stl_mesh(bytes(80) + count.to_bytes(4, "little") + bytes(50 * count))
    with pytest.raises(SampleLimitError):
        stl_mesh(b"solid a\nfacet\n" + b"vertex 0 0 0\n" * 1_500_001)
    with pytest.raises(SampleLimitError):
        obj_mesh(b"v 0 0 0\n" * 1_000_001 + b"f 1 1 1\n")
    with pytest.raises(SampleLimitError):
        obj_mesh(b"v 0 0 0\n" + b"f 1 1 1\n" * (count + 1))


def test_text_of_stl_with_a_broken_corner_is_refused():
    data = BOX.export(file_type="stl_ascii").encode()
    place = data.index(b"vertex ")
    for broken in (b"vertex a", b"vertex 1 2 3 4 5"):
        with pytest.raises(GamutError):
            stl_mesh(data[:place] + broken + b"\n" + data[place:])
