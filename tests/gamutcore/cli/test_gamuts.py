"""Commands about gamuts: files that other programs read, sections, pictures and references."""

import csv
import io
import json
import re
from itertools import product

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
    assert shown.startswith("volume ")
    assert "8,000 cubic ΔE*ab, 0.00" in shown
    assert len(shown.splitlines()) <= 12
    whole, _ = command("info", output, "--all")
    assert set(shown.splitlines()) < set(whole.splitlines())
    assert max(map(len, whole.splitlines())) <= 80


@pytest.mark.slow
def test_info_states_patches_condition_and_model_error(command, tmp_path):
    levels = np.array(list(product([0, 50, 100], repeat=3)), float)
    lab = levels @ np.array([[-0.2, -0.4, -0.5], [-0.3, 0.7, 0], [-0.1, 0, 0.9]]) + [95, 0, 0]
    rows = np.hstack([levels, lab])
    rows = np.vstack([rows, rows[:1] + 0.0, [0, 0, 0, 0, 0, 0]])
    path = tmp_path / "press.csv"
    head = "CMY_C,CMY_M,CMY_Y,M1_LAB_L,M1_LAB_A,M1_LAB_B"
    np.savetxt(path, rows, "%g", ",", header=head, comments="")
    shown, told = command("info", path, "--surface-samples", 500, "--intent", "absolute", "--all")
    lines = [" ".join(line.split()) for line in shown.splitlines()]
    assert "patches 27 of 29 used, 1 averaged, 1 dropped" in lines
    assert "condition M1" in lines
    # linear colours are met exactly
    assert any(line.startswith("model error 0.00 ΔE*ab on average") for line in lines)
    assert "Warning: Line 30 is left out" in told
    text, _ = command("export", path, "--surface-samples", 500, "--table", "leaves", "--csv")
    table = list(csv.DictReader(io.StringIO(text)))
    yellow = next(row for row in table if (row["hue"], row["lightness"]) == ("90", "85"))
    assert float(yellow["Y"]) == pytest.approx(100, abs=5)


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
def test_export(command, as_json, saved, small_gamut, tmp_path):
    level = small_gamut.mesh(20)
    rows = list(csv.DictReader(io.StringIO(command("export", saved, "--triangles", 20)[0])))
    np.testing.assert_allclose([float(row["L*"]) for row in rows], level.vertices[:, 0], rtol=1e-5)
    levels = as_json("export", saved, "--table", "levels")
    assert levels["triangles"] == [row["triangles"] for row in small_gamut.description["levels"]]
    path = tmp_path / "vertices.json"
    command("export", saved, "--triangles", 20, "-o", path)
    columns = json.loads(path.read_text())
    found = [columns[axis] for axis in ("L*", "a*", "b*")]
    np.testing.assert_allclose(np.transpose(found), level.vertices)
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


def test_reference_search(command, as_json):
    assert as_json("reference", "--search", "srgb")["slug"][0] == "srgb"
    assert as_json("reference", "--search", "Rec. 2020")["slug"][0] == "bt2020"
    assert as_json("reference", "--search", "2100")["slug"][0].startswith("bt2100-")
    _, err = command("reference", "--search", "TR006", status=2)
    assert "print condition" in err
    command("reference", "--search", "qwxz", status=2)
    command("reference", "srgb", "--search", "srgb", status=2)
    _, err = command("info", "P3", status=2)
    assert "display-p3" in err


@pytest.mark.slow
def test_chromaticities_are_labelled_and_stated(command, as_json, tmp_path):
    """The area of Display P3 is 1.3565 times that of BT.709 in xy; see test_chromaticity."""
    few = ("--surface-samples", 2000)
    shown, _ = command("info", "display-p3", *few)
    assert re.search(r"^xy area +1\.35\d+ × BT\.709, of the primaries$", shown, re.MULTILINE)
    assert re.search(r"^u′v′ covers +BT\.709 100\.0, Display P3 100\.0, ", shown, re.MULTILINE)
    assert as_json("info", "display-p3", *few)["chromaticity"]["basis"] == "primaries"
    compared = as_json("compare", "display-p3", "bt709", *few)
    assert compared["chromaticity"]["xy"]["area_ratio"] == pytest.approx(1.3565, abs=1e-3)
    shown, _ = command("compare", "display-p3", "bt709", *few)
    assert re.search(r"^area in xy \(× the other\) +1\.35\d+ +0\.73\d+$", shown, re.MULTILINE)
    assert re.search(r"^other covered in u′v′ \(%\) +100\.0 ", shown, re.MULTILINE)
    built = as_json("build", "bt2100-hlg-1000", "--space", "ITP", *few, "-o", tmp_path / "a.gamut")
    assert 20 < built["million distinguishable colours"] < 30


def test_slice(command, as_json, as_rows, cubes):
    cube = cubes / "large.gamut"
    corners = as_rows("slice", cube, "--lightness", 50, "--csv")
    assert {row["L*"] for row in corners} == {"50"}
    assert max(float(row["a*"]) for row in corners) == pytest.approx(20, abs=1e-3)
    assert set(as_json("slice", cube, "--hue", 40)["polygon"]) == {1}
    assert as_json("slice", cube, "--plane", "1,0,0,90")["polygon"] == []
    command("slice", cube, status=2)
    command("slice", cube, "--plane", "1,0,x,90", status=2)


@pytest.mark.slow
def test_a_slice_is_drawn(command, cubes, tmp_path):
    command("slice", cubes / "large.gamut", "--plane", "0,1,1,5", "-o", tmp_path / "slice.svg")
    assert "<!-- a* + b* = 5 -->" in (tmp_path / "slice.svg").read_text()


@pytest.mark.slow
@pytest.mark.parametrize(("suffix", "date"), [("svg", b"dc:date"), ("pdf", b"CreationDate")])
def test_a_drawing_has_the_same_bytes_at_any_time(command, cubes, tmp_path, suffix, date):
    paths = [tmp_path / f"{name}.{suffix}" for name in ("one", "two")]
    for path in paths:
        command("slice", cubes / "large.gamut", "--lightness", 50, "-o", path)
    one, two = (path.read_bytes() for path in paths)
    assert one == two
    assert date not in one


@pytest.mark.slow
def test_rings(command, as_json, cubes, tmp_path):
    cube = cubes / "large.gamut"
    found = as_json("rings", cube, "--sectors", 4)
    outer = np.array(found["radius"])[-4:]
    assert (np.pi * outer**2).mean() == pytest.approx(40**3, rel=1e-4)
    both = as_json("rings", cube, "--reference", cube, "--sectors", 4)
    assert both["reference_radius"] == pytest.approx(both["radius"])
    for suffix, begin in ((".svg", b"<?xml"), (".PNG", b"\x89PNG"), (".pdf", b"%PDF")):
        path = tmp_path / f"rings{suffix}"
        command("rings", cube, "--sectors", 4, "-o", path)
        assert path.read_bytes().startswith(begin)
    assert "<!-- Gamut rings -->" in (tmp_path / "rings.svg").read_text()


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


def test_a_file_is_built_with_the_options(as_json, tmp_path):
    corners = "".join(f"{50 + x},{y},{z}\n" for x in (0, 9) for y in (0, 9) for z in (0, 9))
    path = tmp_path / "cube.csv"
    path.write_text("L,a,b\n" + corners)
    options = as_json("info", path, "--space", "oklab", "--cost", "quadric", "--gamma", "1")[
        "options"
    ]
    assert (options["space"], options["cost"], options["gamma"]) == ("Oklab", "quadric", 1.0)


@pytest.mark.slow
def test_a_reference_leaves_out_options_of_the_other_gamut(command, saved):
    few = ("--surface-samples", "500")
    out, _ = command("compare", saved, "srgb", *few, "--json")
    assert json.loads(out)["volume_b"] > 700_000
    command("compare", saved, "srgb", *few, "--ink-limit", "300", status=2)
    command("info", "srgb", *few, "--ink-limit", "300", status=2)
