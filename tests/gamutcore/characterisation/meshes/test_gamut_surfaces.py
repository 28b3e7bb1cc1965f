"""Argyll's .gam files, and the boundary in an iccMAX profile (ICC.2:2019, 10.2.11)."""

import shutil
import struct
import subprocess

import numpy as np
import pytest

from gamutcore import Gamut
from gamutcore.boundary import mesh_boundary
from gamutcore.characterisation import GamutMesh, Samples, embedded_boundary, read_characterisation
from gamutcore.colours import lab_to_xyz
from gamutcore.errors import (
    MalformedFileError,
    MalformedProfileError,
    MeshError,
    OptionError,
    SampleLimitError,
)

TEXT = """GAMUT

DESCRIPTOR "made for a test"
COLOR_REP "LAB"
GAMUT_CENTER "50.0 5.0 5.0"
CUSP_RED "49.8 71.1 50.8"
# First come the vertices, numbered as they like
NUMBER_OF_FIELDS 4
BEGIN_DATA_FORMAT
VERTEX_NO LAB_L LAB_A LAB_B
END_DATA_FORMAT

NUMBER_OF_SETS 4
BEGIN_DATA
10 10 0 0
11 90 0 0
13 50 40 0
12 50 0 40
END_DATA

NUMBER_OF_FIELDS 3
BEGIN_DATA_FORMAT
VERTEX_0 VERTEX_1 VERTEX_2
END_DATA_FORMAT

NUMBER_OF_SETS 4
BEGIN_DATA
11 13 10
12 11 10
13 12 10
12 13 11
END_DATA
"""


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_tables_are_joined_by_the_vertices_numbers(end):
    text = TEXT.replace("\n", end)
    mesh = read_characterisation(text.encode())
    np.testing.assert_array_equal(mesh.vertices, [(10, 0, 0), (90, 0, 0), (50, 40, 0), (50, 0, 40)])
    assert mesh.centre.tolist() == [50, 5, 5]
    assert mesh.provenance["stated"]["cusp_red"] == "49.8 71.1 50.8"
    boundary, provenance = mesh_boundary(mesh)
    # a tetrahedron of the edges 80, 40, 40: one sixth of their product
    assert boundary.mesh.volume == pytest.approx(80 * 40 * 40 / 6)
    assert boundary.centre.tolist() == [50, 5, 5]
    assert provenance["mesh"]["turned"] == 0


def test_a_surface_in_appearance_coordinates_is_refused():
    with pytest.raises(MeshError, match="CIECAM02") as caught:
        read_characterisation(TEXT.replace('"LAB"', '"JAB"').encode())
    assert caught.value.where == {"field": "COLOR_REP"}


@pytest.mark.parametrize(
    ("old", "new", "where"),
    [
        ("90 0 0", "90 0 zero", {"line": 16}),
        ("90 0 0", "90 0", {"line": 15}),
        ("LAB_B", "LAB_C", {"line": 9}),
        ("VERTEX_2", "VERTEX_9", {"line": 22}),
        ("12 13 11", "12 13 14", {"face": 3}),
        ("VERTEX_NO", "SAMPLE_ID", {"line": 9}),
        ("BEGIN_DATA\n11", "11", {"line": 19}),
    ],
)
def test_what_is_broken_is_named_with_its_place(old, new, where):
    with pytest.raises(MalformedFileError) as caught:
        read_characterisation(TEXT.replace(old, new).encode())
    assert where.items() <= caught.value.where.items(), caught.value.where


def test_a_surface_that_is_cut_anywhere_is_refused_with_its_place():
    for end in range(TEXT.index("END_DATA\n"), TEXT.rindex("11\nEND_DATA")):
        with pytest.raises(MalformedFileError) as caught:
            read_characterisation(TEXT[:end].encode())
        assert caught.value.code == "malformed-file"
        assert {"line", "face", "field"} & set(caught.value.where)


@pytest.mark.parametrize("head", ["CTI3\n# GAMUT", "CTI3\nGAMUT yes", "GAMUT_CENTER 1"])
def test_samples_are_not_taken_for_surfaces(head):
    text = f"{head}\nBEGIN_DATA_FORMAT\nLAB_L LAB_A LAB_B\nEND_DATA_FORMAT\nBEGIN_DATA\n50 1 2\n"
    assert isinstance(read_characterisation(f"{text}END_DATA\n".encode()), Samples)


@pytest.mark.parametrize("name", ["press/ISOcoated_v2_300_bas.icc", "spaces/sRGB-v2-magic.icc"])
def test_a_surface_that_argyll_made(name, shared_data, tmp_path):
    tool = shutil.which("iccgamut")
    if tool is None:
        pytest.skip("iccgamut is not installed: Debian's package argyll has it")
    profile = tmp_path / "profile.icc"
    profile.write_bytes((shared_data / name).read_bytes())
    arguments = [tool, "-d", "15", "-ir", profile.name]
    said = subprocess.run(arguments, check=True, capture_output=True, cwd=tmp_path, timeout=600)
    data = profile.with_suffix(".gam").read_bytes()
    mesh = read_characterisation(data)
    assert isinstance(mesh, GamutMesh), said
    boundary, provenance = mesh_boundary(mesh)
    assert provenance["mesh"]["centre"]["from"] == "the file"
    assert (provenance["mesh"]["turned"], provenance["mesh"]["dropped"]) == (0, 0)
    assert boundary.mesh.triangles == provenance["mesh"]["triangles_read"]
    # Argyll's own figure of the volume, in the text of `iccgamut -v`... is of the same surface
    verbose = subprocess.run(
        [tool, "-v", *arguments[1:]],
        check=True,
        capture_output=True,
        cwd=tmp_path,
        timeout=600,
        text=True,
    )
    (line,) = [line for line in verbose.stdout.splitlines() if "volume" in line.lower()]
    stated = next(float(word) for word in line.split() if word.replace(".", "").isdigit())
    assert boundary.mesh.volume == pytest.approx(stated, rel=1e-4)


VERTICES = [(10, 0, 0), (90, 0, 0), (50, 40, 0), (50, 0, 40)]
CLOCKWISE = [(0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)]


def element(vertices=VERTICES, faces=CLOCKWISE, inks=0, channels=3, counts=None):
    counted = counts or (len(vertices), len(faces))
    data = b"gbd " + bytes(4) + struct.pack(">HHII", channels, inks, *counted)
    data += b"".join(struct.pack(">3I", *face) for face in faces)
    data += b"".join(struct.pack(">3f", *vertex) for vertex in vertices)
    return data + struct.pack(f">{inks * len(vertices)}f", *[0.5] * inks * len(vertices))


@pytest.fixture
def profile(made_profile):
    """Return a function from tags to an iccMAX profile of a display."""

    def read(tags, pcs="Lab "):
        return read_characterisation(made_profile(tags, pcs=pcs, kind="mntr", version=5))

    return read


@pytest.mark.parametrize("inks", [0, 3, 4])
def test_vertices_and_clockwise_triangles_are_read(profile, inks):
    mesh = embedded_boundary(profile({"gbd1": element(inks=inks)}), "relative")
    assert mesh.vertices.tolist() == [list(vertex) for vertex in VERTICES]
    boundary, provenance = mesh_boundary(mesh)
    # a tetrahedron of the edges 80, 40, 40: one sixth of their product
    assert boundary.mesh.volume == pytest.approx(80 * 40 * 40 / 6)
    assert provenance["mesh"]["turned"] == 0
    assert (provenance["tag"], provenance["intent"]) == ("gbd1", "relative")


def test_each_intent_has_its_tag(profile):
    boundaries = {
        f"gbd{number}": element([(10 + number, 0, 0), *VERTICES[1:]]) for number in range(4)
    }
    read = profile(boundaries)
    for number, intent in enumerate(("perceptual", "relative", "saturation", "absolute")):
        assert embedded_boundary(read, intent).vertices[0, 0] == 10 + number


def test_a_boundary_in_xyz_says_so(profile):
    xyz = [(0.1, 0.1, 0.1), (0.9, 0.1, 0.1), (0.1, 0.9, 0.1), (0.1, 0.1, 0.7)]
    mesh = embedded_boundary(profile({"gbd1": element(xyz)}, "XYZ "), "relative")
    assert mesh.space == "CIEXYZ"
    boundary, _ = mesh_boundary(mesh)
    # the colours' lightness by CIE 15: Y 0.9 and three times Y 0.1
    lightness = [116 * 0.9 ** (1 / 3) - 16, 116 * 0.1 ** (1 / 3) - 16]
    np.testing.assert_allclose(sorted(boundary.mesh.vertices[:, 0])[2:], lightness[::-1], atol=1e-3)


def test_a_boundary_in_xyz_has_the_chromaticities_of_the_same_colours_in_cielab(made_profile):
    lab = np.array([(30, -20, -20), (90, 0, 0), (50, 60, 0), (50, 0, 60)], dtype=float)
    described = []
    for pcs, vertices in (("Lab ", lab), ("XYZ ", lab_to_xyz(lab))):
        data = made_profile({"gbd1": element(vertices)}, pcs=pcs, kind="mntr", version=5)
        described.append(Gamut(data, {"source": "boundary"}).chromaticity().xy)
    described = [xy[np.argsort(xy[:, 0])] for xy in described]
    assert len(described[0]) >= 3
    # float32 of the file
    np.testing.assert_allclose(described[1], described[0], atol=1e-5)


def test_vertices_that_are_numbered_from_one_are_understood(profile):
    """As in the ICC's own example of the type in XML."""
    faces = [tuple(corner + 1 for corner in face) for face in CLOCKWISE]
    mesh = embedded_boundary(profile({"gbd1": element(faces=faces)}), "relative")
    assert mesh.faces.min() == 0
    assert "from 1" in mesh.warnings[-1]


def test_an_intent_without_a_boundary_is_refused_with_those_that_have_one(profile):
    with pytest.raises(OptionError) as caught:
        embedded_boundary(profile({"gbd0": element()}), "relative")
    assert caught.value.where == {"field": "intent", "tag": "gbd1"}
    assert "perceptual" in caught.value.remedy


def test_data_without_a_boundary_is_refused(profile):
    with pytest.raises(OptionError) as caught:
        embedded_boundary(profile({"desc": bytes(8)}), "relative")
    assert caught.value.where["field"] == "source"
    with pytest.raises(OptionError):
        embedded_boundary(read_characterisation(b"L,a,b\n50,0,0\n"), "relative")


@pytest.mark.parametrize(
    "data",
    [
        element()[:-1],
        element()[:15],
        element(inks=4)[:-1],
        element(channels=36),
        element(counts=(4, 5)),
        b"mft2" + element()[4:],
    ],
)
def test_what_is_broken_names_the_tag(profile, data):
    with pytest.raises(MalformedProfileError) as caught:
        embedded_boundary(profile({"gbd1": data}), "relative")
    assert caught.value.where["tag"] == "gbd1"


@pytest.mark.parametrize("counts", [(2**32 - 1, 4), (4, 2**32 - 1), (4, 0x55555556)])
def test_sizes_are_refused_before_anything_is_read(profile, counts):
    with pytest.raises(SampleLimitError):
        embedded_boundary(profile({"gbd1": element(counts=counts)}), "relative")
