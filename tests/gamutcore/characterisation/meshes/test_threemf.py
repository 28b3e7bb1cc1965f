"""3MF: exports read back, files of other programs, and archives made to harm."""

import io
import zipfile

import numpy as np
import pytest

from gamutcore.characterisation import read_characterisation
from gamutcore.characterisation.meshes import triangle_files
from gamutcore.errors import GamutError, MalformedFileError, SampleLimitError
from gamutcore.export import mesh_file
from gamutcore.geometry import TriangleMesh

CORNERS = np.array([(10, 0, 0), (90, 0.1, 0), (50, 40, -1 / 3), (50, -20, 30)], np.float32)
MESH = TriangleMesh(CORNERS, np.array([(0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)]))
NOTES = {"gamut": 'a; space: "Oklab"', "centre": "50 1 2", "space": "CIELAB"}
NAME = "3D/3dmodel.model"


def model_of(data):
    with zipfile.ZipFile(io.BytesIO(data)) as package:
        return package.read(NAME).decode()


def package_of(model, name=NAME, method=zipfile.ZIP_DEFLATED):
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", method) as package:
        package.writestr(name, model)
    return file.getvalue()


OURS = mesh_file(MESH, "3mf", NOTES)
THEIRS = model_of(OURS).replace("gamutcore ", "another program ")


def test_an_export_is_read_back_with_the_same_numbers_and_notes():
    found = read_characterisation(OURS)
    np.testing.assert_array_equal(found.vertices, CORNERS)
    np.testing.assert_array_equal(found.faces, MESH.faces)
    assert found.centre.tolist() == [50, 1, 2]
    assert found.space_notes["space"] == "CIELAB"
    assert not found.warnings


def test_the_transform_of_another_program_is_applied():
    found = read_characterisation(package_of(THEIRS, "3D/part.model"))
    assert "transform" in found.warnings[0]
    # upright, 100 mm high for the white, from the corner of the table
    span = CORNERS.max(axis=0) - CORNERS.min(axis=0)
    np.testing.assert_allclose(np.ptp(found.vertices, axis=0), span[[1, 2, 0]], atol=1e-4)
    np.testing.assert_allclose(found.vertices.min(axis=0), 0, atol=1e-4)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('x="10"', 'x="ten"'),
        ('x="10"', 'x="1_0"'),
        ('x="10"', ""),
        ('v1="0"', 'v1="-1"'),
        ('v1="0"', 'v1="9"'),
        ('v1="0"', ""),
        ("</mesh>", "</mesh><mesh/>"),
        ("</object>", "<components/></object>"),
        ('transform="', 'transform="1 '),
        ("</model>", ""),
        ("<model ", "<!DOCTYPE a [<!ENTITY b 'c'>]><model "),
        ('<metadata name="Title">', f'<metadata name="Title">{"t" * 200_000}'),
    ],
)
def test_a_malformed_model_is_refused(old, new):
    assert old in THEIRS
    with pytest.raises(MalformedFileError) as caught:
        read_characterisation(package_of(THEIRS.replace(old, new, 1)))
    assert caught.value.where
    assert caught.value.remedy


@pytest.mark.parametrize("end", [200, len(OURS) // 2, len(OURS) - 30, len(OURS) - 1])
def test_a_package_that_ends_early_is_refused(end):
    with pytest.raises(GamutError):
        read_characterisation(OURS[:end])


def test_packages_packed_otherwise_and_with_wrong_sums_are_refused():
    encrypted = bytearray(OURS)
    place = encrypted.rindex(b"PK\1\2")
    encrypted[place + 8] |= 1
    spoilt = package_of(THEIRS, method=zipfile.ZIP_STORED).replace(b'x="10"', b'x="11"')
    two = package_of(THEIRS, "a.model")
    for data in (bytes(encrypted), spoilt, two.replace(b"a.model", b"a.modem")):
        with pytest.raises(GamutError):
            read_characterisation(data)


def test_what_unpacks_to_too_much_is_refused_before_it_is_all_unpacked(monkeypatch):
    monkeypatch.setattr(triangle_files, "MAX_MODEL_BYTES", 3 * 2**20)
    data = package_of(THEIRS + " " * 2**24)
    assert len(data) < 2**17
    with pytest.raises(SampleLimitError, match="unpacked"):
        read_characterisation(data)


@pytest.mark.parametrize(
    ("limit", "most"), [("MAX_ELEMENTS", 9), ("MAX_SHARED_VERTICES", 3), ("MAX_TRIANGLES", 3)]
)
def test_numbers_of_elements_are_limited(monkeypatch, limit, most):
    monkeypatch.setattr(triangle_files, limit, most)
    with pytest.raises(SampleLimitError):
        read_characterisation(OURS)


def test_a_directory_of_many_files_is_refused_before_it_is_read(monkeypatch):
    monkeypatch.setattr(triangle_files, "MAX_DIRECTORY", 100)
    with pytest.raises(MalformedFileError, match="directory"):
        read_characterisation(OURS)


def test_another_archive_is_not_taken_for_a_mesh():
    with pytest.raises(GamutError) as caught:
        read_characterisation(package_of("text", "word/document.xml"))
    assert caught.value.code == "unrecognised-format"
