"""PLY, STL and OBJ: what the formats allow is read, what breaks them is named."""

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from gamutcore.characterisation import GamutMesh, read_characterisation
from gamutcore.errors import GamutError, MalformedFileError, SampleLimitError

VERTICES = np.array([(10.0, 0, 0), (90, 0, 0), (50, 40, 0), (50, 0, 40.5)])
FACES = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]


def header(order, *, vertices=4, faces=4, number="float", extra="", notes="", lists="uchar int"):
    return (
        f"ply\nformat {order} 1.0\n{notes}element vertex {vertices}\nproperty {number} x\n"
        f"property {number} y\nproperty {number} z\n{extra}element face {faces}\n"
        f"property list {lists} vertex_indices\nend_header\n"
    ).encode()


def text(faces=FACES, vertices=VERTICES, **parts):
    rows = [" ".join(map(str, row)) for row in np.asarray(vertices).tolist()]
    rows += [" ".join(map(str, [len(face), *face])) for face in faces]
    head = header("ascii", vertices=len(vertices), faces=len(faces), **parts)
    return head + "\n".join(rows).encode() + b"\n"


def binary(mark, kind, length, index):
    rows = VERTICES.astype(f"{mark}{kind}").tobytes()
    for face in FACES:
        rows += np.array([3], f"{mark}{length}").tobytes()
        rows += np.array(face, f"{mark}{index}").tobytes()
    order = {"<": "binary_little_endian", ">": "binary_big_endian"}[mark]
    names = {"f4": "float", "f8": "float64", "i4": "int", "u2": "ushort", "u1": "uint8"}
    return header(order, number=names[kind], lists=f"{names[length]} {names[index]}") + rows


@pytest.mark.parametrize("mark", ["<", ">"])
@pytest.mark.parametrize("kind", ["f4", "f8"])
@pytest.mark.parametrize(("length", "index"), [("u1", "i4"), ("i4", "u2"), ("u2", "u1")])
def test_binary_of_every_kind(mark, kind, length, index):
    mesh = read_characterisation(binary(mark, kind, length, index))
    np.testing.assert_array_equal(mesh.vertices, VERTICES)
    np.testing.assert_array_equal(mesh.faces, FACES)
    assert mesh.provenance["format"] == "ply"


@pytest.mark.parametrize("end", [b"\n", b"\r\n", b"\r"])
def test_text_with_every_line_end(end):
    data = text().replace(b"\n", end)
    mesh = read_characterisation(data)
    np.testing.assert_array_equal(mesh.vertices, VERTICES)
    np.testing.assert_array_equal(mesh.faces, FACES)


def test_polygons_are_fans_of_triangles():
    """Of n corners n − 2 triangles, all from the first corner, in the polygon's orientation."""
    vertices = [(0, x, y) for x in range(3) for y in range(3)]
    mesh = read_characterisation(
        text(faces=[[0, 1, 2, 5, 8], [3, 4], [0, 1, 4, 3]], vertices=vertices)
    )
    assert mesh.faces.tolist() == [[0, 1, 2], [0, 2, 5], [0, 5, 8], [0, 1, 4], [0, 4, 3]]


def test_further_properties_and_elements_are_passed_over():
    data = text(extra="property uchar red\nproperty list uchar float weights\n")
    rows = [f"{' '.join(map(str, row))} 7 2 0.5 0.25" for row in VERTICES.tolist()]
    rows += [f"3 {' '.join(map(str, face))}" for face in FACES]
    end = data.index(b"end_header\n") + len(b"end_header\n")
    head = data[:end].replace(b"element vertex", b"element edge 1\nproperty int a\nelement vertex")
    mesh = read_characterisation(head + b"5\n" + "\n".join(rows).encode())
    np.testing.assert_array_equal(mesh.vertices, VERTICES)
    np.testing.assert_array_equal(mesh.faces, FACES)


def test_comments_state_space_and_centre():
    notes = "comment space: CIELAB\ncomment centre: 50.5 1.0 -2\ncomment intent: absolute\n"
    mesh = read_characterisation(text(notes=notes))
    assert mesh.centre.tolist() == [50.5, 1, -2]
    assert mesh.provenance["stated"]["intent"] == mesh.provenance["intent"] == "absolute"
    assert mesh.space_notes["space"] == "CIELAB"
    other = read_characterisation(text(notes="comment space: Oklab\ncomment adaptation: CAT16\n"))
    assert other.space_notes == {"space": "Oklab", "adaptation": "CAT16"}


@pytest.mark.parametrize(
    ("data", "where"),
    [
        (b"ply\nformat ascii 1.0\n", {"line": 1}),
        (text().replace(b"format ascii", b"format morse"), {"line": 2}),
        (text().replace(b"property float y", b"property quad y"), {"line": 5}),
        (text().replace(b"property float y", b"property float x"), {"line": 3}),
        (text().replace(b"10.0", b"ten"), {"line": 10}),
        (text().replace(b"10.0", b"1_0"), {"line": 10}),
        (text()[:-9], {"field": "face"}),
        (text().replace(b"element face", b"element edge"), {"field": "face"}),
        (text().replace(b"float z", b"float w"), {"field": "vertex"}),
        (text(faces=[[0, 1, 2.5], *FACES[1:]]), {"field": "face"}),
        (text(faces=[[0, 1, 9], *FACES[1:]]), {"face": 0}),
        (text(faces=[[0, -1, 2], *FACES[1:]]), {"face": 0}),
        (binary("<", "f4", "u1", "i4")[:-1], {"field": "face"}),
        (text(faces=FACES[:3]), {"field": "faces"}),
        (text().replace(b"format ascii 1.0\n", b""), {"line": 1}),
        (text().replace(b"10.0", b"1" * 1_200_000), {}),
    ],
)
def test_what_is_broken_is_named_with_its_place(data, where):
    with pytest.raises(MalformedFileError) as caught:
        read_characterisation(data)
    assert where.items() <= caught.value.where.items(), caught.value.where
    assert caught.value.remedy


@pytest.mark.parametrize("word", ["nan", "inf", "1e999", "2e10"])
def test_coordinates_that_are_no_colours_are_refused(word):
    with pytest.raises(GamutError, match="Vertex 0 is at"):
        read_characterisation(text().replace(b"10.0", word.encode()))


@pytest.mark.parametrize(("vertices", "faces"), [(10**9, 4), (4, 10**9)])
def test_sizes_are_refused_before_anything_is_read(vertices, faces):
    with pytest.raises(SampleLimitError):
        read_characterisation(header("binary_little_endian", vertices=vertices, faces=faces))


def test_a_list_longer_than_the_file_is_refused():
    data = binary("<", "f4", "i4", "u2")
    broken = data[:-40] + (2**31 - 1).to_bytes(4, "little") + data[-36:]
    with pytest.raises(MalformedFileError, match="ends within"):
        read_characterisation(broken)


@given(st.integers(0, 2**32 - 1), st.integers(1, 8), st.sampled_from([1, 7, 60, 1 << 20]))
def test_any_polygons_are_read_as_text_and_binary_alike(seed, count, block):
    """Row by row where their sizes differ, all at once where they do not; text in blocks."""
    chance = np.random.default_rng(seed)
    faces = [chance.integers(0, 4, chance.integers(0, 6)).tolist() for _ in range(count)]
    faces += FACES
    lists = b"".join(bytes([len(f)]) + np.array(f, "<i4").tobytes() for f in faces)
    head = header("binary_little_endian", faces=len(faces))
    one = read_characterisation(head + VERTICES.astype("<f4").tobytes() + lists)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("gamutcore.characterisation.meshes.mesh._BLOCK", block)
        two = read_characterisation(text(faces=faces))
    np.testing.assert_array_equal(one.vertices, two.vertices)
    np.testing.assert_array_equal(one.faces, two.faces)
    assert len(one.faces) == sum(max(len(face) - 2, 0) for face in faces)


@pytest.mark.parametrize("order", ["ascii", "binary_little_endian"])
def test_device_values_of_vertices(order):
    """By the names in comments, where there are any; what is no fraction is none of them."""
    extra = "property float device_C\nproperty uchar device_note\nproperty double device_Spot\n"
    notes = "comment device_C: Cyan ink\ncomment device_scale: 100\n"
    values = np.array([(0, 7, 1), (0.5, 8, 0), (1, 9, 0.25), (0.125, 9, 0.5)])
    head = header(order, extra=extra, notes=notes)
    if order == "ascii":
        rows = [" ".join(map(str, row)) for row in np.hstack([VERTICES, values]).tolist()]
        rows += ["3 " + " ".join(map(str, face)) for face in FACES]
        data = head + "\n".join(rows).encode()
    else:
        kind = [("xyz", "<f4", 3), ("c", "<f4"), ("n", "u1"), ("s", "<f8")]
        table = np.array(
            [(tuple(p), *v) for p, v in zip(VERTICES.tolist(), values.tolist(), strict=True)], kind
        )
        faces = b"".join(b"\3" + np.array(face, "<i4").tobytes() for face in FACES)
        data = head + table.tobytes() + faces
    mesh = read_characterisation(data)
    assert mesh.device.channels == ("Cyan ink", "Spot")
    np.testing.assert_array_equal(mesh.device.values, values[:, [0, 2]])
    assert mesh.provenance["stated"] == {"device_scale": "100"}


def test_device_values_of_too_many_channels_are_not_read():
    extra = "".join(f"property float device_{number}\n" for number in range(16))
    vertices = np.hstack([VERTICES, np.zeros((4, 16))])
    mesh = read_characterisation(text(vertices=vertices, extra=extra))
    assert mesh.device is None
    assert "channels" in mesh.warnings[0]


def test_stl_of_another_length_than_it_says_is_not_taken_for_one():
    data = BOX.export(file_type="stl")
    with pytest.raises(GamutError):
        read_characterisation(data[:-1])


def test_obj_with_polygons_references_and_notes():
    text = (
        b"# centre: 1 2 3\n# made by hand\nmtllib a.mtl\n\nv 0 0 0\nv 1 0 0 0.5 0.5 0.5\nv 1 1 0\n"
        b"v 0 1 0\nvt 0 0\nf 1/1 2/1 3/1 4/1\nv 0 0 1\nf -1 -5//2 4/1/2\nf 1 2 5\n"
        b"f 2 3 5\nf 3 4 5\n"
    )
    mesh = read_characterisation(text)
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
        read_characterisation(text)
    assert place.items() <= caught.value.where.items()


def test_too_many_triangles_are_refused_before_their_coordinates_are_read(monkeypatch):
    for limit in (
        "meshes.mesh.MAX_TRIANGLES",
        "meshes.triangle_files.MAX_TRIANGLES",
        "meshes.triangle_files.MAX_TEXT_TRIANGLES",
        "meshes.triangle_files.MAX_SHARED_VERTICES",
    ):
        monkeypatch.setattr(f"gamutcore.characterisation.{limit}", 1000)
    for data in (
        bytes(80) + (1001).to_bytes(4, "little") + bytes(50 * 1001),
        b"solid a\nfacet\n" + b"vertex 0 0 0\n" * 3003,
        b"v 0 0 0\n" * 1001 + b"f 1 1 1\n",
        b"v 0 0 0\n" + b"f 1 1 1\n" * 1001,
    ):
        with pytest.raises(SampleLimitError):
            read_characterisation(data)


@pytest.mark.parametrize(
    ("corner", "where"),
    [
        (b"vertex a 2 3", {"line": 5}),
        (b"vertex 1 2", {"line": 5}),
        (b"vertex 1 2\nvertex 3 4 5 6\nvertex 7 8 9", {"line": 5}),
        (b"vertex 1 2 3", {"field": "vertex"}),
    ],
)
@pytest.mark.parametrize("end", [b"\n", b"\r", b"\r\n"])
def test_a_wrong_corner_in_the_text_of_stl_is_named_with_its_line(corner, where, end):
    first, *lines = BOX.export(file_type="stl_ascii").encode().split(b"\n")
    assert lines[2].startswith(b"vertex")
    data = end.join([first, *lines[:3], *corner.split(b"\n"), *lines[3:]])
    with pytest.raises(MalformedFileError) as caught:
        read_characterisation(data)
    assert caught.value.where == where


def test_text_of_stl_in_capitals_and_with_any_name():
    data = BOX.export(file_type="stl_ascii").encode().upper()
    mesh = read_characterisation(data.replace(b"SOLID", b"SOLID vertex 7", 1))
    np.testing.assert_allclose(mesh.vertices[mesh.faces], CORNERS, atol=1e-6)


def test_a_backslash_continues_a_line_of_obj():
    """Wavefront's Advanced Visualizer manual, appendix B1."""
    text = "v 0 0 0\nv 60 \\\n0 0\nv 0 60 0\nv 0 0 60\nf 1 \\\n3 \\\n2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
    mesh = read_characterisation(text.encode())
    assert mesh.vertices[1].tolist() == [60, 0, 0]
    assert mesh.faces[0].tolist() == [0, 2, 1]


def test_negative_references_count_back_from_their_own_line():
    text = "v 0 0 0\nv 60 0 0\nv 0 60 0\nf -3 -1 -2\nv 0 0 60\nf 1 2 4\nf 1 4 3\nf 2 3 -1\n"
    assert read_characterisation(text.encode()).faces.tolist() == FACES


BOX = trimesh.creation.box((60.0, 50.0, 40.0))
CORNERS = np.asarray(BOX.vertices)[BOX.faces]


def exported(kind):
    data = (
        trimesh.exchange.gltf.export_gltf(trimesh.Scene(BOX), embed_buffers=True)["model.gltf"]
        if kind == "gltf"
        else BOX.export(file_type=kind)
    )
    return data if isinstance(data, bytes) else data.encode()


@pytest.mark.parametrize("kind", ["ply", "glb", "gltf", "stl", "stl_ascii", "obj"])
def test_what_trimesh_writes_is_read(kind):
    mesh = read_characterisation(exported(kind))
    assert isinstance(mesh, GamutMesh)
    assert mesh.format == kind.removesuffix("_ascii")
    np.testing.assert_allclose(mesh.vertices[mesh.faces], CORNERS, atol=1e-6)


def obj_notes(*notes):
    """Return what a mesh with these comments is told to be."""
    lines = "".join(f"# {note}\n" for note in notes)
    corners = "v 0 0 0\nv 60 0 0\nv 0 60 0\nv 0 0 60\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
    return read_characterisation((lines + corners).encode())


@pytest.mark.parametrize("centre", ["", "1 2", "1 2 nan", "1 2 1e11", "1 2 x", "1 2 1_0"])
def test_a_centre_that_is_none_is_passed_over(centre):
    assert obj_notes(f"centre: {centre}").centre is None


def test_names_have_a_meaning_in_capitals_too():
    mesh = obj_notes("Centre: 1 2 3", "Illuminant: D65")
    assert mesh.centre.tolist() == [1, 2, 3]
    assert mesh.provenance["illuminant"] == mesh.provenance["stated"]["Illuminant"] == "D65"
    assert mesh.space_notes["illuminant"] == "D65"


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        (r"2\xb0", "2°"),
        (r"Gr\xf6\xdfe \u9ed2 \U0001f3a8", "Größe 黒 🎨"),
        (r"C:\x41 \ud800 \U00110000 \x0a", r"C:\x41 \ud800 \U00110000 \x0a"),
    ],
)
def test_escapes_of_our_own_files_are_undone(written, meant):
    own = obj_notes("generator: gamutcore 1", f"note: {written}")
    assert own.provenance["stated"]["note"] == meant
    assert obj_notes(f"note: {written}").provenance["stated"]["note"] == written


@pytest.mark.parametrize("value", [1.01, float("nan")])
def test_device_values_that_are_none_are_not_taken(value):
    """A note says so; the mesh is still the boundary."""
    vertices = np.hstack([VERTICES, [[0.0], [0.5], [1.0], [value]]])
    mesh = read_characterisation(text(vertices=vertices, extra="property float device_C\n"))
    assert mesh.device is None
    assert len(mesh.warnings) == 1
    assert "channels" not in mesh.provenance
