"""Gamut boundaries in iccMAX profiles: by the bytes of ICC.2, by iccDEV, and by our reader."""

import hashlib
import importlib.util
import struct

import numpy as np
import pytest

from gamutcore import Gamut
from gamutcore.characterisation.icc import icc_profile
from gamutcore.errors import UnsupportedProfileError
from gamutcore.export import mesh_file
from gamutcore.geometry import TriangleMesh
from tests.conftest import missing

CORNERS = np.array([(10, 0, 0), (90, 0, 0), (50, 40, 0), (50, 0, 40)], np.float32)
FACES = np.array([(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)])
GAMUT_BOUNDARY_TYPE = 0x67626420
"""gamutBoundaryDescType, ICC.2:2019, table 46."""


def tags(data):
    """Return the tag table, ICC.2:2019, 7.3."""
    (count,) = struct.unpack_from(">I", data, 128)
    entries = [struct.unpack_from(">4sII", data, 132 + 12 * number) for number in range(count)]
    return {name.decode(): data[start : start + size] for name, start, size in entries}


def test_the_bytes_are_those_of_the_standard():
    data = mesh_file(TriangleMesh(CORNERS, FACES), "icc", {"intent": "perceptual"})
    size, _, version = struct.unpack_from(">I4sI", data)
    assert (size, version) == (len(data), 0x05000000)
    assert len(data) % 4 == 0
    assert data[12:24] == b"abstLab Lab "
    assert data[36:40] == b"acsp"
    assert struct.unpack_from(">I", data, 64) == (0,)  # perceptual
    np.testing.assert_allclose(
        np.frombuffer(data[68:80], ">i4") / 65536, (0.9642, 1, 0.8249), atol=1e-5
    )
    blank = bytearray(data)
    blank[44:48], blank[64:68], blank[84:100] = bytes(4), bytes(4), bytes(16)
    assert data[84:100] == hashlib.md5(blank, usedforsecurity=False).digest()
    found = tags(data)
    assert {"desc", "cprt", "wtpt", "A2B0", "gbd0"} == set(found)
    element = found["gbd0"]
    head = struct.unpack_from(">IIHHII", element)
    assert head == (GAMUT_BOUNDARY_TYPE, 0, 3, 0, len(CORNERS), len(FACES))
    faces = np.frombuffer(element, ">u4", 12, 20).reshape(4, 3)
    vertices = np.frombuffer(element, ">f4", 12, 20 + 48).reshape(4, 3)
    assert len(element) == 20 + 48 + 48
    np.testing.assert_array_equal(vertices, CORNERS)
    # clockwise seen from outside (10.2.11), therefore with a negative volume
    volume = TriangleMesh(vertices.astype(float), faces.astype(int)).volume
    assert volume == pytest.approx(-80 * 40 * 40 / 6)


@pytest.mark.parametrize(
    ("intent", "tag", "number"),
    [
        ("perceptual", "gbd0", 0),
        ("relative", "gbd1", 1),
        ("absolute", "gbd3", 3),
        ("none", "gbd1", 1),
    ],
)
def test_the_tag_is_that_of_the_intent(intent, tag, number):
    data = mesh_file(TriangleMesh(CORNERS, FACES), "icc", {"intent": intent})
    assert tag in tags(data)
    assert struct.unpack_from(">I", data, 64) == (number,)


@pytest.fixture(scope="module")
def iccdev():
    if importlib.util.find_spec("iccdev") is None:
        missing("iccDEV is not installed")
    return pytest.importorskip("iccdev")


def test_the_reference_implementation_finds_no_fault(iccdev, level):
    data = mesh_file(level, "icc", {"gamut": "17e9e641749a", "intent": "relative"})
    status, report = iccdev.validate_profile(data)
    assert (status, report) == (iccdev.ValidationStatus(0), "")
    # and it would find one: more channels than the connection space has
    start = data.index(b"gbd \0\0\0\0") + 8
    faulty = data[:start] + b"\0\4" + data[start + 2 :]
    status, report = iccdev.validate_profile(faulty)
    assert "gamutBoundaryDescription1Tag" in report


def test_an_abstract_profile_is_no_device(fogra39_gamut):
    data = fogra39_gamut.mesh(100).to_bytes("icc")
    with pytest.raises(UnsupportedProfileError, match="abstract") as caught:
        Gamut(data)
    assert "source=boundary" in caught.value.remedy
    with pytest.raises(UnsupportedProfileError, match="device class"):
        icc_profile(data.replace(b"gbd1", b"gbdx"))
