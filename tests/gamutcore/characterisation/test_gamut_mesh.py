"""What every mesh is checked for, whatever format it was read from."""

import numpy as np
import pytest

from gamutcore.characterisation.gamut_mesh import (
    MAX_TRIANGLES,
    MAX_VERTICES,
    gamut_mesh,
    refuse_too_many,
    statements,
)
from gamutcore.errors import InvalidPointsError, MalformedFileError, SampleLimitError

VERTICES = np.array([(10.0, 0, 0), (90, 0, 0), (50, 40, 0), (50, 0, 40)])
FACES = np.array([(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)])


def test_arrays_become_a_mesh_with_its_provenance():
    mesh = gamut_mesh(
        "ply", VERTICES, FACES, stated=statements({"centre": "1 2 3e0", "title": "x"})
    )
    assert mesh.centre.tolist() == [1, 2, 3]
    assert mesh.provenance["format"] == "ply"
    assert (mesh.provenance["vertices_read"], mesh.provenance["triangles_read"]) == (4, 4)
    assert mesh.provenance["stated"]["title"] == "x"


def test_clockwise_corners_are_put_in_the_other_order():
    mesh = gamut_mesh("ply", VERTICES, FACES, clockwise=True)
    np.testing.assert_array_equal(mesh.faces, FACES[:, ::-1])


@pytest.mark.parametrize("centre", ["", "1 2", "1 2 nan", "1 2 1e11", "1 2 x", "1 2 1_0"])
def test_a_centre_that_is_none_is_passed_over(centre):
    assert statements({"centre": centre}).centre is None


def test_names_have_a_meaning_in_capitals_too():
    told = statements({"Centre": "1 2 3", "Illuminant": "D65"})
    assert told.centre.tolist() == [1, 2, 3]
    mesh = gamut_mesh("ply", VERTICES, FACES, stated=told)
    assert mesh.provenance["illuminant"] == "D65"
    assert mesh.provenance["stated"]["Illuminant"] == "D65"
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
    assert statements({"generator": "gamutcore 1", "note": written}).said["note"] == meant
    assert statements({"note": written}).said["note"] == written


def test_statements_are_bounded():
    told = statements({f"name {number}" * 50: "x" * 10_000 for number in range(1000)})
    assert len(told.said) <= 200
    assert all(len(name) <= 80 and len(text) <= 500 for name, text in told.said.items())


@pytest.mark.parametrize(
    ("vertices", "faces", "kind"),
    [
        (VERTICES, FACES[:3], MalformedFileError),
        (VERTICES[:3], FACES, MalformedFileError),
        (VERTICES, FACES + 1, MalformedFileError),
        (VERTICES, FACES - 1, MalformedFileError),
        (np.where(VERTICES == 90, np.nan, VERTICES), FACES, InvalidPointsError),
        (np.where(VERTICES == 90, 1e11, VERTICES), FACES, InvalidPointsError),
    ],
)
def test_what_is_no_mesh_is_refused(vertices, faces, kind):
    with pytest.raises(kind) as caught:
        gamut_mesh("ply", vertices, faces)
    assert caught.value.remedy
    assert caught.value.where["field"] in {"vertices", "faces"}


def test_limits():
    refuse_too_many(MAX_VERTICES, MAX_TRIANGLES)
    for sizes in ((MAX_VERTICES + 1, 0), (0, MAX_TRIANGLES + 1)):
        with pytest.raises(SampleLimitError):
            refuse_too_many(*sizes)


def test_device_values_that_are_none_are_not_taken():
    """A note says so; the mesh is still the boundary."""
    fine = np.array([0, 0.5, 1, 0.25])
    mesh = gamut_mesh("ply", VERTICES, FACES, device={"C": fine, "M": 1 - fine})
    assert mesh.device.channels == ("C", "M")
    assert mesh.provenance["channels"] == ["C", "M"]
    assert not mesh.warnings
    for device in ({"C": fine * 1.01}, {"C": fine * np.nan}, {str(n): fine for n in range(16)}):
        mesh = gamut_mesh("ply", VERTICES, FACES, device=device)
        assert mesh.device is None
        assert len(mesh.warnings) == 1
        assert "channels" not in mesh.provenance
