"""Commands about one gamut: files that other programs read, and figures that agree with it."""

import csv
import io
import json

import numpy as np
import pytest
import trimesh

from gamutcore import Gamut

CUBE = "L,a,b\n" + "\n".join(f"{50 + 20 * x},{20 * y},{20 * z}" for x, y, z in np.ndindex(2, 2, 2))


@pytest.fixture
def cube(tmp_path):
    path = tmp_path / "cube.csv"
    path.write_text(CUBE)
    return path


def test_build_saves_what_info_shows(command, as_json, cube, tmp_path):
    output = tmp_path / "other.gamut"
    built = as_json("build", cube, "--gamma", "1", "-o", output)
    assert built["file"] == str(output)
    assert built["volume"] == pytest.approx(20**3)
    assert Gamut.load(output).id == built["id"] == Gamut(cube, gamma=1).id
    assert as_json("info", output)["id"] == built["id"]
    shown, _ = command("info", output)
    assert "volume" in shown
    assert "8000" in shown


def test_build_names_the_file_after_the_source(command, cube, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    command("build", cube.name)
    assert Gamut.load(tmp_path / "cube.gamut").volume == pytest.approx(20**3)


def test_mesh(command, saved, tmp_path):
    path = tmp_path / "level.ply"
    _, err = command("mesh", saved, "--triangles", 40, "-o", path)
    assert len(trimesh.load(path).faces) == 40
    assert "40 triangles" in err
    command("mesh", saved, "--triangles", 40, "--max-error", 1, "-o", path, status=2)
    command("mesh", saved, "-o", tmp_path / "level.txt", status=2)


def test_export_writes_meshes_by_the_suffix(command, saved, small_gamut, tmp_path):
    path = tmp_path / "level.gam"
    _, err = command("export", saved, "--triangles", 40, "-o", path)
    assert "40 triangles" in err
    assert path.read_bytes() == small_gamut.mesh(40).to_bytes("gam")
    command("export", saved, "--table", "cusps", "-o", path, status=2)
    for name in ("level.usdz", "level.gamut"):
        _, err = command("export", saved, "-o", tmp_path / name, status=2)
        assert ".3mf" in err
        assert not (tmp_path / name).exists()
    command("export", saved, "--table", "cusps", "-o", tmp_path / "cusps.dat")
    assert (tmp_path / "cusps.dat").read_text().startswith("hue,")
    command("export", saved, "--csv", "-o", path, status=2)
    _, err = command("export", saved, "-o", tmp_path / "level.cge", status=2)
    assert "no device values" in err


@pytest.mark.slow
def test_envelopes_are_of_the_full_boundary(command, tmp_path):
    path = tmp_path / "display.cge"
    source = "examples/Panasonic-TV.icc"
    _, err = command("mesh", source, "--surface-samples", 1000, "-o", path)
    full = Gamut(source, surface_samples=1000).history.triangles
    assert f"{full} triangles" in err
    assert path.read_text().count("\n") == 602 + 14


@pytest.mark.slow
def test_export(command, as_json, saved, small_gamut, tmp_path):
    level = small_gamut.mesh(20)
    rows = list(csv.DictReader(io.StringIO(command("export", saved, "--triangles", 20)[0])))
    np.testing.assert_allclose([float(row["L*"]) for row in rows], level.vertices[:, 0], rtol=1e-5)
    levels = as_json("export", saved, "--table", "levels")
    assert levels["triangles"] == [row["triangles"] for row in small_gamut.description["levels"]]
    path = tmp_path / "vertices.json"
    command("export", saved, "--triangles", 20, "-o", path)
    columns = json.loads(path.read_text())
    np.testing.assert_allclose(np.transpose(list(columns.values())), level.vertices)
    cusps = as_json("export", saved, "--table", "cusps")
    assert cusps["hue"] == list(range(360))
    leaves = as_json("export", saved, "--table", "leaves")
    assert len(leaves["chroma"]) == 360 * 101
    command("export", saved, "--table", "faces", status=2)
    page = tmp_path / "Small.html"
    command("export", saved, "-o", page)
    assert page.read_bytes() == small_gamut.to_html("Small")
    command("export", saved, "--triangles", 20, "-o", page, status=2)


def test_reference(command, as_json, tmp_path):
    listed = as_json("reference")
    assert {"srgb", "display-p3", "pointer"} <= set(listed["slug"])
    assert as_json("reference", "Display P3")["slug"] == "display-p3"
    path = tmp_path / "p3.json"
    command("reference", "display-p3", "-o", path)
    assert json.loads(path.read_text())["reference"] == "display-p3"
    command("reference", "srbg", status=2)
