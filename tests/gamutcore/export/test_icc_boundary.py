"""Gamut boundaries in iccMAX profiles: by the bytes of ICC.2, by iccDEV, and by our reader."""

import hashlib
import importlib.util
import struct
from pathlib import Path

import numpy as np
import pytest

import gamutcore
from gamutcore import Gamut, profile
from gamutcore.characterisation.icc import icc_profile
from gamutcore.cli.app import app, run
from gamutcore.errors import GamutError, OptionError, UnsupportedProfileError
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


def digest(data):
    """Return the profile id, ICC.2:2019, 7.2.18."""
    blank = bytearray(data)
    blank[44:48], blank[64:68], blank[84:100] = bytes(4), bytes(4), bytes(16)
    return hashlib.md5(blank, usedforsecurity=False).digest()


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
    assert data[84:100] == digest(data)
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


@pytest.mark.slow
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


PRESS = Path(__file__).parents[3] / "examples" / "FOGRA39L.ti3"


@pytest.fixture(scope="module")
def host(srgb_gamut):
    """A profile of version 5 with tables and without a boundary."""
    source = {"size": 9, "source_gamut": srgb_gamut}
    return profile(PRESS, version=5, surface_samples=1000, ink_limit=300, **source).to_bytes()


@pytest.fixture(scope="module")
def srgb_gamut():
    return gamutcore.reference("srgb", space="CAM16-UCS", surface_samples=1000)


@pytest.mark.parametrize(("intent", "tag"), [("relative", "gbd1"), ("absolute", "gbd3")])
@pytest.mark.slow
def test_a_boundary_is_embedded_and_all_else_is_kept(host, iccdev, intent, tag):
    level = Gamut(PRESS, surface_samples=1000, intent=intent).mesh(300)
    data = level.to_bytes("icc", into=host)
    before, after = tags(host), tags(data)
    element = after.pop(tag)
    assert after == before
    assert data[4:84] == host[4:84]
    assert data[100:128] == host[100:128]
    assert data[84:100] == digest(data)
    assert struct.unpack_from(">H", element, 10) == (4,)
    vertices, faces = len(level.vertices), len(level.faces)
    values = np.frombuffer(element, ">f4", 4 * vertices, 20 + 12 * faces + 12 * vertices)
    np.testing.assert_allclose(values.reshape(-1, 4), level.device.values, atol=1e-6)
    assert iccdev.validate_profile(data) == (iccdev.ValidationStatus(0), "")
    read = Gamut(data, source="boundary", intent=intent)
    # as posted again in another format: coordinates are float32 in both
    assert read.volume == pytest.approx(level.volume, rel=1e-6)
    assert level.to_bytes("icc", into=data) == data  # replaced


def test_a_profile_with_xyz_and_an_abstract_one_get_a_boundary(screen, made_profile):
    level = screen("srgb").mesh(100)
    rgb = made_profile({"A2B0": b"mft2" + bytes(60)}, pcs="XYZ ", kind="mntr", version=5)
    abstract = level.to_bytes("icc")
    for data, inks in ((rgb, 3), (abstract, 0)):
        embedded = level.to_bytes("icc", into=data)
        assert struct.unpack_from(">H", tags(embedded)["gbd1"], 10) == (inks,)
        read = Gamut(embedded, source="boundary")
        assert read.volume == pytest.approx(level.volume, rel=1e-4)  # float32 of XYZ


@pytest.mark.slow
def test_profiles_that_cannot_have_the_boundary_are_refused(host, made_profile, tmp_path, capsys):
    level = gamutcore.reference("srgb", surface_samples=1000).mesh(100)
    table = {"A2B0": b"mft2" + bytes(60)}
    fifth = made_profile(table, version=5)
    for data, reason in (
        (made_profile(table, version=4), "version 4"),
        (made_profile(table, version=2), "version 2"),
        (host, "C M Y K"),
        (host[:-400], "another size"),
        (host[:4000] + bytes(4) + host[4004:], "changed"),
        (fifth[:132] + b"A2B0\0\0\1\0" + fifth[140:], "A2B0"),
        (b"no profile", "not an ICC profile"),
    ):
        with pytest.raises(GamutError, match=reason) as refused:
            level.to_bytes("icc", into=data)
        assert refused.value.where["field"] == "into"
        assert refused.value.remedy
    with pytest.raises(OptionError, match="no profile"):
        level.to_bytes("ply", into=fifth)
    path, out = tmp_path / "old.icc", tmp_path / "out.icc"
    path.write_bytes(made_profile(table, version=4))
    asked = ["export", "srgb", "-o", str(out), "--into", str(path), "--surface-samples", "1000"]
    assert run(app, asked) == 2
    assert "--version 5" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == [path]
    path.write_bytes(fifth)
    assert run(app, asked) == 0
    assert "gbd1" in tags(out.read_bytes())
    asked[3] = str(tmp_path / "out.ply")
    assert run(app, asked) == 2
