"""The gamut boundary in an iccMAX profile, by the layout in ICC.2:2019, 10.2.11."""

import struct
from pathlib import Path

import numpy as np
import pytest

from gamutcore.boundary import mesh_boundary
from gamutcore.characterisation import Samples, characterisation, described_boundary
from gamutcore.errors import GamutError, MalformedProfileError, OptionError, SampleLimitError

VERTICES = [(10, 0, 0), (90, 0, 0), (50, 40, 0), (50, 0, 40)]
CLOCKWISE = [(0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)]


def element(vertices=VERTICES, faces=CLOCKWISE, inks=0, channels=3, counts=None):
    counted = counts or (len(vertices), len(faces))
    data = b"gbd " + bytes(4) + struct.pack(">HHII", channels, inks, *counted)
    data += b"".join(struct.pack(">3I", *face) for face in faces)
    data += b"".join(struct.pack(">3f", *vertex) for vertex in vertices)
    return data + struct.pack(f">{inks * len(vertices)}f", *[0.5] * inks * len(vertices))


def profile(tags, pcs=b"Lab "):
    table, content, offset = b"", b"", 132 + 12 * len(tags)
    for name, data in tags.items():
        table += struct.pack(">4sII", name.encode(), offset, len(data))
        content, offset = content + data, offset + len(data)
    head = bytearray(128)
    head[0:4] = struct.pack(">I", offset)
    head[8:12], head[12:24] = bytes([5, 0, 0, 0]), b"mntrRGB " + pcs
    head[36:40] = b"acsp"
    return characterisation(bytes(head) + struct.pack(">I", len(tags)) + table + content)


@pytest.mark.parametrize("inks", [0, 3, 4])
def test_vertices_and_clockwise_triangles_are_read(inks):
    mesh = described_boundary(profile({"gbd1": element(inks=inks)}), "relative")
    assert mesh.vertices.tolist() == [list(vertex) for vertex in VERTICES]
    boundary, provenance = mesh_boundary(mesh)
    # a tetrahedron of the edges 80, 40, 40: one sixth of their product
    assert boundary.mesh.volume == pytest.approx(80 * 40 * 40 / 6)
    assert provenance["mesh"]["turned"] == 0
    assert (provenance["tag"], provenance["intent"]) == ("gbd1", "relative")


def test_each_intent_has_its_tag():
    boundaries = {
        f"gbd{number}": element([(10 + number, 0, 0), *VERTICES[1:]]) for number in range(4)
    }
    read = profile(boundaries)
    for number, intent in enumerate(("perceptual", "relative", "saturation", "absolute")):
        assert described_boundary(read, intent).vertices[0, 0] == 10 + number


def test_a_boundary_in_xyz_says_so():
    xyz = [(0.1, 0.1, 0.1), (0.9, 0.1, 0.1), (0.1, 0.9, 0.1), (0.1, 0.1, 0.7)]
    mesh = described_boundary(profile({"gbd1": element(xyz)}, b"XYZ "), "relative")
    assert mesh.space == "CIEXYZ"
    boundary, _ = mesh_boundary(mesh)
    # the colours' lightness by CIE 15: Y 0.9 and three times Y 0.1
    lightness = [116 * 0.9 ** (1 / 3) - 16, 116 * 0.1 ** (1 / 3) - 16]
    np.testing.assert_allclose(sorted(boundary.mesh.vertices[:, 0])[2:], lightness[::-1], atol=1e-3)


def test_vertices_that_are_numbered_from_one_are_understood():
    """As in the ICC's own example of the type in XML."""
    faces = [tuple(corner + 1 for corner in face) for face in CLOCKWISE]
    mesh = described_boundary(profile({"gbd1": element(faces=faces)}), "relative")
    assert mesh.faces.min() == 0
    assert "from 1" in mesh.warnings[-1]


def test_an_intent_without_a_boundary_is_refused_with_those_that_have_one():
    with pytest.raises(OptionError) as caught:
        described_boundary(profile({"gbd0": element()}), "relative")
    assert caught.value.where == {"field": "intent", "tag": "gbd1"}
    assert "perceptual" in caught.value.remedy


def test_data_without_a_boundary_is_refused():
    with pytest.raises(OptionError) as caught:
        described_boundary(profile({"desc": bytes(8)}), "relative")
    assert caught.value.where["field"] == "source"
    samples = characterisation(b"L,a,b\n50,0,0\n")
    assert isinstance(samples, Samples)
    with pytest.raises(OptionError):
        described_boundary(samples, "relative")


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
def test_what_is_broken_names_the_tag(data):
    with pytest.raises(MalformedProfileError) as caught:
        described_boundary(profile({"gbd1": data}), "relative")
    assert caught.value.where["tag"] == "gbd1"


@pytest.mark.parametrize("counts", [(2**32 - 1, 4), (4, 2**32 - 1), (4, 0x55555556)])
def test_sizes_are_refused_before_anything_is_read(counts):
    with pytest.raises(SampleLimitError):
        described_boundary(profile({"gbd1": element(counts=counts)}), "relative")


def test_every_malformed_profile_is_refused(shared_data):
    for path in sorted(Path(shared_data / "malformed").glob("*.icc")):
        for intent in ("relative", "perceptual"):
            with pytest.raises(GamutError):
                described_boundary(characterisation(path.read_bytes()), intent)
