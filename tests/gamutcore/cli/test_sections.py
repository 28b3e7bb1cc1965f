"""Commands that cut a gamut, on a cube whose sections are known."""

import csv
import io

import numpy as np
import pytest

from gamutcore import Gamut


@pytest.fixture(scope="module")
def cube(tmp_path_factory):
    path = tmp_path_factory.mktemp("cube") / "cube.gamut"
    corners = 20 * (2.0 * np.array(list(np.ndindex(2, 2, 2))) - 1) + (50, 0, 0)
    Gamut(corners, gamma=1).save(path)
    return path


def rows(text):
    return list(csv.DictReader(io.StringIO(text)))


def test_slice(command, as_json, cube, tmp_path):
    corners = rows(command("slice", cube, "--lightness", 50, "--csv")[0])
    assert {row["L*"] for row in corners} == {"50"}
    assert max(float(row["a*"]) for row in corners) == pytest.approx(20, abs=1e-3)
    assert set(as_json("slice", cube, "--hue", 40)["polygon"]) == {1}
    assert as_json("slice", cube, "--plane", "1,0,0,90")["polygon"] == []
    command("slice", cube, status=2)
    command("slice", cube, "--plane", "1,0,x,90", status=2)
    command("slice", cube, "--plane", "0,1,1,5", "-o", tmp_path / "slice.svg")
    picture = (tmp_path / "slice.svg").read_bytes()
    assert picture == Gamut.load(cube).slice_svg(plane=(0, 1, 1, 5))


def test_rings(command, as_json, cube, tmp_path):
    found = as_json("rings", cube, "--sectors", 4)
    outer = np.array(found["radius"])[-4:]
    assert (np.pi * outer**2).mean() == pytest.approx(40**3, rel=1e-4)
    both = as_json("rings", cube, "--reference", cube, "--sectors", 4)
    assert both["reference_radius"] == pytest.approx(both["radius"])
    command("rings", cube, "--sectors", 4, "-o", tmp_path / "rings.svg")
    assert (tmp_path / "rings.svg").read_bytes() == Gamut.load(cube).rings_svg(sectors=4)
    command("rings", cube, "-o", tmp_path / "rings.png")
    assert (tmp_path / "rings.png").read_bytes().startswith(b"\x89PNG")


def test_a_picture_is_that_of_python(command, saved, small_gamut, tmp_path):
    path = tmp_path / "gamut.png"
    command("picture", saved, "-o", path, "--size", 50, "--view", "10,20", "--no-axes")
    assert path.read_bytes() == small_gamut.picture(50, (10, 20), axes=False)
    command("export", saved, "-o", path, "--triangles", 40)
    assert path.read_bytes() == small_gamut.picture(triangles=40)
    command("picture", saved, "-o", tmp_path / "gamut.jpg", status=2)
    command("picture", saved, "-o", path, "--view", "10,north", status=2)
    _, err = command("picture", saved, "-o", path, "--view", "side", status=2)
    assert "standard" in err
