"""Argyll's gamut surfaces: read by Argyll's own programs where they are installed, and by ours."""

import re
import shutil
import subprocess
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.booleans import intersection_volume
from gamutcore.characterisation.meshes.mesh import argyll_mesh
from gamutcore.export import mesh_file
from gamutcore.geometry import DeviceValues, TriangleMesh
from tests.conftest import missing

CORNERS = np.array([(10.5, 0, 0), (90, 1e-5, 0), (50, 40, 0), (50, 0, 40)], np.float32)
FACES = np.array([(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)])
PRIMARIES = ["RED", "YELLOW", "GREEN", "CYAN", "BLUE", "MAGENTA"]


@pytest.fixture
def viewgam(tmp_path):
    """Return a function from two .gam files to viewgam's intersection and volumes."""
    if shutil.which("viewgam") is None:
        missing("Argyll CMS (the package argyll) is not installed")

    def volumes(one, two):
        (tmp_path / "one.gam").write_bytes(one)
        (tmp_path / "two.gam").write_bytes(two)
        ended = subprocess.run(
            ["viewgam", "-i", "one.gam", "two.gam", "out"],
            cwd=tmp_path,
            check=True,
            capture_output=True,
            text=True,
        )
        found = re.findall(r"olume = ([0-9.]+)", ended.stdout)
        assert len(found) == 3, ended.stdout + ended.stderr
        return [float(text) for text in found]

    return volumes


def columns(data):
    """Return the tables of a file by an independent, minimal reading of CGATS."""
    blocks = re.findall(r"BEGIN_DATA\n(.*?)END_DATA\n", data.decode("ascii"), re.DOTALL)
    return [[line.split() for line in block.splitlines()] for block in blocks]


def test_two_tables_with_clockwise_faces_and_decimal_points():
    data = mesh_file(TriangleMesh(CORNERS, FACES), "gam", {"centre": "50.0 5.0 5.0"})
    assert data.startswith(b"GAMUT\n")
    vertices, triangles = columns(data)
    assert [row[0] for row in vertices] == ["0", "1", "2", "3"]
    assert all("." in number for row in vertices for number in row[1:])
    np.testing.assert_array_equal(np.array(vertices)[:, 1:].astype(np.float32), CORNERS)
    turned = np.array(triangles, int)[:, [0, 2, 1]]
    np.testing.assert_array_equal(turned, FACES)
    assert b'GAMUT_CENTER "50.000000 5.000000 5.000000"\n' in data
    assert b'GAMUT_WHITE "90.000000' in data
    assert b'GAMUT_BLACK "10.500000' in data
    assert b"CUSP" not in data


@pytest.mark.slow
def test_cusps_are_the_primaries_and_secondaries(fogra39_gamut):
    level = fogra39_gamut.level(1000)
    text = mesh_file(level, "gam").decode()
    found = dict(re.findall(r'CUSP_([A-Z]+) "([^"]+)"', text))
    assert list(found) == PRIMARIES
    # FOGRA39L: solid magenta on yellow, yellow, …, as the characterisation data has them
    solids = {
        "RED": (47.1, 68.1, 48.1),
        "YELLOW": (89.0, -4.0, 93.0),
        "GREEN": (50.1, -66.1, 25.7),
        "CYAN": (55.0, -36.1, -50.0),
        "BLUE": (24.0, 17.0, -46.0),
        "MAGENTA": (48.0, 74.0, -3.0),
    }
    for name, absolute in solids.items():  # relative to paper, which is about 5 % lighter
        cusp = np.array(found[name].split(), float)
        assert np.linalg.norm(cusp - absolute) < 8


def test_levels_without_a_primary_have_no_cusps(press_gamut):
    level = press_gamut.level(1000)
    device = DeviceValues(level.device.channels, np.clip(level.device.values, 0.0, 0.9))
    assert b"CUSP" not in mesh_file(replace(level, device=device), "gam")
    device = DeviceValues(tuple("ABCD"), level.device.values)
    assert b"CUSP" not in mesh_file(replace(level, device=device), "gam")


def test_text_cannot_leave_its_keyword(provenance):
    hostile = {**provenance, "gamut": 'a"\nBEGIN_DATA\n„é'}
    data = mesh_file(TriangleMesh(CORNERS, FACES), "gam", hostile)
    assert argyll_mesh(data.decode()).provenance["stated"]["descriptor"].startswith("a' BEGIN_DATA")


@pytest.mark.slow
def test_viewgam_intersects_levels_as_we_do(viewgam, fogra39_gamut, srgb_gamut):
    one, two = fogra39_gamut.mesh(1500), srgb_gamut.mesh(1500)
    common, first, second = viewgam(one.to_bytes("gam"), two.to_bytes("gam"))
    assert first == pytest.approx(one.volume, rel=1e-5)
    assert second == pytest.approx(two.volume, rel=1e-5)
    assert common == pytest.approx(intersection_volume(one, two), rel=1e-3)


@pytest.mark.slow
def test_viewgam_intersects_our_surfaces_with_those_of_iccgamut(viewgam, fogra39_gamut, tmp_path):
    profile = tmp_path / "display.icm"
    shutil.copy("/usr/share/color/argyll/ref/sRGB.icm", profile)
    subprocess.run(["iccgamut", "-d", "15", "-ir", profile.name], cwd=tmp_path, check=True)
    theirs = (tmp_path / "display.gam").read_bytes()
    read = argyll_mesh(theirs.decode())
    their_mesh, ours = TriangleMesh(read.vertices, read.faces), fogra39_gamut.mesh(1500)
    common, first, second = viewgam(ours.to_bytes("gam"), theirs)
    assert first == pytest.approx(ours.volume, rel=1e-5)
    assert second == pytest.approx(their_mesh.volume, rel=1e-5)
    assert common == pytest.approx(intersection_volume(ours, their_mesh), rel=1e-3)
