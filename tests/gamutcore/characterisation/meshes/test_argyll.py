"""Argyll's gamut surfaces: files of iccgamut where it is installed, and one made here."""

import shutil
import subprocess

import numpy as np
import pytest

from gamutcore.boundary import mesh_boundary
from gamutcore.characterisation import GamutMesh, characterisation
from gamutcore.characterisation.meshes.argyll import argyll_mesh, looks_like_argyll
from gamutcore.errors import GamutError, MalformedFileError, MeshError

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
    assert looks_like_argyll(text)
    mesh = argyll_mesh(text)
    np.testing.assert_array_equal(mesh.vertices, [(10, 0, 0), (90, 0, 0), (50, 40, 0), (50, 0, 40)])
    assert mesh.centre.tolist() == [50, 5, 5]
    assert mesh.provenance["stated"]["cusp_red"] == "49.8 71.1 50.8"
    boundary, provenance = mesh_boundary(mesh)
    # a tetrahedron of the edges 80, 40, 40: one sixth of their product
    assert boundary.mesh.volume == pytest.approx(80 * 40 * 40 / 6)
    assert boundary.centre.tolist() == [50, 5, 5]
    assert provenance["mesh"]["turned"] == 0


def test_samples_of_the_family_are_no_surfaces():
    assert not looks_like_argyll("CTI3\nBEGIN_DATA_FORMAT\nLAB_L\nEND_DATA_FORMAT\nBEGIN_DATA\n")
    assert not looks_like_argyll("GAMUT_CENTER 5\nBEGIN_DATA\n")


def test_a_surface_in_appearance_coordinates_is_refused():
    with pytest.raises(MeshError, match="CIECAM02") as caught:
        argyll_mesh(TEXT.replace('"LAB"', '"JAB"'))
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
        argyll_mesh(TEXT.replace(old, new))
    assert where.items() <= caught.value.where.items(), caught.value.where


def test_every_cut_is_a_named_error_or_a_mesh():
    for end in range(0, len(TEXT), 7):
        try:
            read = characterisation(TEXT[:end].encode())
        except GamutError:
            continue
        assert read.format


@pytest.mark.parametrize("name", ["press/ISOcoated_v2_300_bas.icc", "spaces/sRGB-v2-magic.icc"])
def test_a_surface_that_argyll_made(name, shared_data, tmp_path):
    tool = shutil.which("iccgamut")
    if tool is None:
        pytest.skip("iccgamut is not installed: Debian's package argyll has it")
    profile = tmp_path / "profile.icc"
    profile.write_bytes((shared_data / name).read_bytes())
    arguments = [tool, "-d", "15", "-ir", profile.name]
    said = subprocess.run(arguments, check=True, capture_output=True, cwd=tmp_path, timeout=60)
    data = profile.with_suffix(".gam").read_bytes()
    mesh = characterisation(data)
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
        timeout=60,
        text=True,
    )
    (line,) = [line for line in verbose.stdout.splitlines() if "volume" in line.lower()]
    stated = next(float(word) for word in line.split() if word.replace(".", "").isdigit())
    assert boundary.mesh.volume == pytest.approx(stated, rel=1e-4)
