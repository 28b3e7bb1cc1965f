"""Commands that answer questions, against the methods of the class and independent figures."""

import csv
import io
import json
import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import gamutcore
from gamutcore import Gamut

ROOT = Path(__file__).parents[3]
INKS = ["C", "M", "Y", "K"]
FEW = ("--surface-samples", "20000")


def table_of(shown):
    """Return the rows of the table behind the sentences: label and cells, which are aligned."""
    lines = shown.split("\n\n")[1].splitlines()
    assert len(set(map(len, lines))) == 1
    rows = [re.split(r" {2,}", line) for line in lines]
    return {label: cells for label, *cells in rows}


def rows(text, mark=","):
    return list(csv.DictReader(io.StringIO(text), delimiter=mark))


@pytest.mark.slow
def test_the_example_of_the_readme(command, tmp_path, monkeypatch):
    """The columns of the file stay, and each added figure is consistent with the others."""
    monkeypatch.chdir(ROOT)
    report = tmp_path / "report.csv"
    out, err = command(
        *("query", "examples/spots.csv", "--gamut", "examples/FOGRA39L.ti3"),
        *("--intent", "absolute", "--ink-limit", "300", "-o", report, *FEW),
    )
    before, after = rows(Path("examples/spots.csv").read_text()), rows(report.read_text())
    assert [{name: row[name] for name in before[0]} for row in after] == before
    added = ["in_gamut", "position", "distance", "distance_euclidean"]
    added += ["nearest_L", "nearest_a", "nearest_b", "delta_e_2000"]
    assert list(after[0])[len(before[0]) :] == [*added, *INKS]
    inside = [row["in_gamut"] == "true" for row in after]
    assert sum(inside) == 16
    assert f"16 of {len(after)} colours are in gamut." in out
    read, gamut = err.splitlines()
    assert read == "Columns L, a, b are read as CIELAB."
    assert gamut == "Gamut: absolute intent, ink limit 300 %, white D50, CIELAB"
    worst = max(after, key=lambda row: float(row["delta_e_2000"]))
    assert worst["name"] in out
    for row, within in zip(after, inside, strict=True):
        assert (float(row["distance"]) <= 0) == within
        assert (float(row["distance_euclidean"]) <= 0) == within
        near = [float(row[f"nearest_{axis}"]) for axis in "Lab"]
        given = [float(row[axis]) for axis in "Lab"]
        inks = [float(row[ink]) for ink in INKS]  # of the colour, or of the nearest one
        assert min(inks) >= 0
        assert sum(inks) <= 301  # interpolated between vertices within 300
        if within:
            assert near == pytest.approx(given)
        else:
            assert np.linalg.norm(np.subtract(near, given)) >= (
                float(row["distance_euclidean"]) - 1e-3
            )
            assert float(row["distance"]) == float(row["delta_e_2000"]) > 0


@pytest.mark.slow
def test_colours_as_measured_and_a_relative_gamut(command, as_json, monkeypatch, tmp_path):
    monkeypatch.chdir(ROOT)
    press = tmp_path / "press.gamut"
    command("build", "examples/FOGRA39L.ti3", "--ink-limit", 300, "-o", press, *FEW)
    out, err = command("query", "examples/spots.csv", "--gamut", press, "-o", tmp_path / "r.csv")
    assert "19 of 40 colours are in gamut." in out
    assert "Gamut: relative intent, ink limit 300 %, white D50, CIELAB\n" in err
    assert "--intent absolute" in err
    answer = as_json("map", "examples/spots.csv", "--gamut", press)
    assert answer["gamut"]["intent"] == "relative"
    assert "--intent absolute" in answer["warnings"][0]
    _, err = command("compare", press, "examples/FOGRA39L.ti3", "--intent", "absolute", *FEW)
    assert "Gamut B: absolute intent" in err
    assert "Warning: The intents differ" in err
    out, _ = command("info", press)
    volume, absolute = (line.split() for line in out.splitlines()[:2])
    assert (volume[0], absolute[0]) == ("volume", "absolute")
    # the paper reflects 0.876 of the light, so its solid is smaller
    assert float(absolute[1].replace(",", "")) < float(volume[1].replace(",", ""))
    assert float(absolute[-3]) < float(volume[-3])


def test_query_of_a_body_whose_answers_are_known(command, cubes, tmp_path):
    table = tmp_path / "colours.csv"
    table.write_text("id;L;C;h\nmiddle;50;0;0\nfar;50;35;90\n", encoding="utf-8")
    arguments = ("query", table, "--gamut", cubes / "large.gamut", "--metric", "cie 1976")
    out, err = command(*arguments)
    middle, far = rows(out, ";")
    assert (middle["in_gamut"], middle["distance"]) == ("true", "-20")
    assert (far["in_gamut"], far["distance"]) == ("false", "15")
    assert [each["distance_euclidean"] for each in (middle, far)] == ["-20", "15"]
    assert [float(far[f"nearest_{axis}"]) for axis in "Lab"] == pytest.approx([50, 0, 20], abs=1e-3)
    assert "1 of 2" in err
    assert "far" in err
    found = json.loads(command(*arguments, "--json")[0])
    assert found["in_gamut"] == [True, False]
    np.save(tmp_path / "colours.npy", np.array([[50.0, 0, 0]]))
    out, err = command("query", tmp_path / "colours.npy", *arguments[2:])
    assert rows(out)[0]["in_gamut"] == "true"
    assert "1 of 1" in err


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "arguments", "space"),
    [
        ("LAB_L\tLAB_A\tLAB_B\n50\t1\t2\n", (), "CIELAB"),
        ("name;L*;a*;b*\nx;50,0;1,0;2,0\n", (), "CIELAB"),
        ("L,C,H\n50,1,2\n", (), "LCHab"),
        ("R,G,B\n50,1,2\n", ("--colours-in", "sRGB", "--scale", "1000"), "sRGB"),
        ("one,two,three\n50,1,2\n", ("--columns", "one,two,three"), "CIELAB"),
        ("J,a,b\n50,1,2\n", ("--columns", "J,a,b", "--colours-in", "CAM16-UCS"), "CAM16-UCS"),
    ],
)
def test_columns_and_spaces_of_tables(as_json, cubes, monkeypatch, text, arguments, space):
    """Read from standard input."""
    gamut = cubes / "large.gamut"
    typed = io.TextIOWrapper(io.BytesIO(f"# a comment\n{text}\n".encode()))
    monkeypatch.setattr("sys.stdin", typed)
    found = as_json("query", "-", "--gamut", gamut, *arguments)
    colour = (0.05, 0.001, 0.002) if space == "sRGB" else (50, 1, 2)
    expected = Gamut.load(gamut).distance([colour], space=space)
    assert found["distance_euclidean"] == pytest.approx(expected)
    near = Gamut.load(gamut).nearest([colour], space=space, metric="CIE 2000")
    assert np.abs(found["distance"]) == pytest.approx(near.distance)


@pytest.mark.slow
@pytest.mark.parametrize("encoding", ["cp1252", "utf-16", "utf-16-le", "utf-16-be", "utf-8-sig"])
def test_tables_in_other_encodings(command, cubes, tmp_path, encoding):
    """As Excel and editors of Windows save them; UTF-16 also without a byte order mark.

    A file comes back in its encoding. Standard output is UTF-8.
    """
    table = tmp_path / "colours.csv"
    table.write_bytes("name;L;a;b\nGrün – ©;50;0;0\n".encode(encoding))
    for name in ("query", "map"):
        arguments = (name, table, "--gamut", cubes / "large.gamut")
        command(*arguments, "-o", tmp_path / "out.csv")
        written = (tmp_path / "out.csv").read_bytes().decode(encoding)
        for text in (command(*arguments)[0], written):
            (row,) = rows(text, ";")
            assert row["name"] == "Grün – ©"
            assert float(row["delta_e_2000"]) == 0


@pytest.mark.slow
def test_forms_of_answers_are_chosen_by_the_suffix(command, cubes, tmp_path):
    table = tmp_path / "colours.csv"
    table.write_text("id;L;a;b\nx;50,5;0;0\n\ny;40;0;0\n")
    arguments = ("query", table, "--gamut", cubes / "large.gamut", "-o")
    told, _ = command(*arguments, tmp_path / "out.tsv")
    assert "1 row without a colour" in told
    assert (tmp_path / "out.tsv").read_text().startswith("id\tL\ta\tb\tin_gamut")
    assert "50,5\t" in (tmp_path / "out.tsv").read_text()
    for name in ("out", "out.xls", "out.npy"):
        _, err = command(*arguments, tmp_path / name, status=2)
        assert ".xlsx" in err
        assert not (tmp_path / name).exists()


@pytest.mark.slow
def test_workbooks_without_openpyxl_say_what_to_install(command, cubes, tmp_path, monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda _: None)
    table = tmp_path / "colours.csv"
    table.write_text("L,a,b\n50,0,0\n")
    arguments = ("query", table, "--gamut", cubes / "large.gamut", "-o", tmp_path / "out.xlsx")
    _, err = command(*arguments, status=1)
    assert "gamut-boundary-service[excel]" in err


def test_sgck_and_its_source_belong_together(command, cubes, tmp_path):
    """The option of the command is named."""
    table = tmp_path / "colours.csv"
    table.write_text("L,a,b\n50,0,0\n")
    asked = ("map", table, "--gamut", cubes / "small.gamut")
    source = ("--from", cubes / "large.gamut")
    for arguments in (("--method", "SGCK"), source):
        assert "--from" in command(*asked, *arguments, status=2)[1]
    assert command(*asked, "--method", "SGCK", *source)[0]


def _content(kind, cubes):
    """Return the content of a file that is no table of colours."""
    file = io.BytesIO()
    if kind == "gamut":
        return (cubes / "large.gamut").read_bytes()
    if kind == "npy":
        return b"\x93NUMPY\x01\x00"
    if kind == "csv":
        return b"L,a,b\n" + b"1" * 200_000 + b",0,0\n"
    Image.new("RGB", (4, 4), "red").save(file, kind)
    return file.getvalue()


@pytest.mark.parametrize(
    ("command_name", "kind", "told"),
    [
        ("query", "png", "is a picture"),
        ("query", "gamut", "Give it as --gamut"),
        ("map", "gamut", "Give it as --gamut"),
        ("query", "gif", "is a picture"),
        ("query", "npy", "numpy.save"),
        ("query", "csv", "cells"),
    ],
)
def test_what_is_no_table_is_named_with_the_file_and_a_remedy(
    command, cubes, tmp_path, command_name, kind, told
):
    """The content counts, not the suffix."""
    for suffix in (kind, "csv"):
        path = tmp_path / f"x.{suffix}"
        path.write_bytes(_content(kind, cubes))
        _, err = command(command_name, path, "--gamut", cubes / "large.gamut", status=1)
        assert err.startswith("gamut: ")
        assert err.count("\n") == 1
        assert told in err
        assert kind == "csv" or f"(file {path})" in err


@pytest.mark.parametrize(
    ("text", "arguments", "told"),
    [
        ("L,a,b\n50,0\n", (), "line 2"),
        ("L,a,b\n50,0,x\n", (), "line 2"),
        ("L,a,b\n50,0,1,4\n", (), "4 cells"),
        ("L,a,b\n50,0,nan\n", (), "line 2"),
        ("L,a,b\n50,0,1\n120,0,0\n", (), "line 3"),
        ("C,M,Y,K\n1,2,3,4\n", (), "profile of the press"),
        ("name,use\nA,B\n", (), "--columns"),
        ("", (), "--columns"),
        ("L,a,x\n1,2,3\n", ("--columns", "L,a"), "L,a"),
        ("L,a,x\n1,2,3\n", ("--columns", "L,a,c"), "L,a,c"),
    ],
)
def test_tables_without_colours(command, cubes, tmp_path, text, arguments, told):
    table = tmp_path / "colours.csv"
    table.write_text(text)
    gamut = cubes / "large.gamut"
    _, err = command("query", table, "--gamut", gamut, *arguments, status=1)
    assert told in err.lower() or told in err


def test_map(command, cubes, tmp_path):
    table = tmp_path / "colours.csv"
    table.write_text("name,L,a,b\nmiddle,50,0,0\nfar,50,35,0\n")
    arguments = ("map", table, "--gamut", cubes / "large.gamut")
    out, err = command(*arguments, "--method", "clip-chroma")
    middle, far = rows(out)
    assert [float(middle[f"mapped_{axis}"]) for axis in "Lab"] == [50, 0, 0]
    assert [float(far[f"mapped_{axis}"]) for axis in "Lab"] == pytest.approx([50, 20, 0], abs=1e-3)
    assert (middle["moved"], far["moved"]) == ("false", "true")
    assert "1 of 2" in err
    out, _ = command(*arguments, "--method", "clip-focal", "--focus", "50,-20,0")
    assert float(rows(out)[1]["mapped_a"]) == pytest.approx(20, abs=1e-3)
    out, _ = command(*arguments, "--method", "sgck", "--from", cubes / "large.gamut")
    assert abs(float(rows(out)[1]["mapped_a"])) <= 20
    command(*arguments, "--method", "sgck", status=2)
    command(*arguments, "--method", "clip", status=2)
    command(*arguments, "--method", "clip-focal", "--focus", "x", status=2)


def test_map_a_picture(command, cubes, tmp_path):
    given, mapped = tmp_path / "given.png", tmp_path / "mapped.png"
    Image.new("RGB", (3, 2), (255, 0, 0)).save(given)
    told, warned = command("map", given, "--gamut", cubes / "small.gamut", "-o", mapped)
    assert told.startswith("6 of 6 pixels moved")
    assert "sRGB is assumed" in warned
    with Image.open(mapped) as found:
        assert found.size == (3, 2)
        assert found.getpixel((1, 1)) != (255, 0, 0)
    Image.new("RGB", (3, 2), (255, 0, 0)).save(tmp_path / "given.gif")
    told, _ = command("map", tmp_path / "given.gif", "--gamut", cubes / "small.gamut", "-o", mapped)
    assert told.startswith("6 of 6 pixels moved")
    command("map", given, "--gamut", cubes / "small.gamut", status=2)
    command("map", given, "--gamut", cubes / "small.gamut", "-o", mapped, "--json", status=2)
    command("map", given, "--gamut", cubes / "small.gamut", "-o", tmp_path / "mapped.gif", status=1)


def test_a_picture_by_a_table_and_its_heat_map(command, cubes, tmp_path):
    given, heat = tmp_path / "given.png", tmp_path / "heat.png"
    Image.new("RGB", (3, 2), (255, 0, 0)).save(given)
    arguments = ("map", given, "--gamut", cubes / "small.gamut", "-o", tmp_path / "mapped.png")
    told, _ = command(*arguments, "--table", "9", "--heat-map", heat)
    assert "100.0% of the pixels and 100.0% of 1 distinct colours" in told
    assert "9 nodes" in told
    assert "6 pixels" in told
    with Image.open(heat) as found:
        assert (found.size, found.mode) == ((3, 2), "L")
    command(*arguments, "--table", "3", status=2)
    command(*arguments, "--heat-map", tmp_path / "heat.jpg", status=2)
    table = tmp_path / "colours.csv"
    table.write_text("L,a,b\n50,0,0\n")
    command("map", table, "--gamut", cubes / "small.gamut", "--table", "9", status=2)


def test_a_picture_is_mapped_spatially(command, cubes, tmp_path):
    given, mapped = tmp_path / "given.png", tmp_path / "mapped.png"
    Image.new("RGB", (3, 2), (255, 0, 0)).save(given)
    arguments = ("map", given, "--gamut", cubes / "small.gamut", "-o", mapped)
    told, _ = command(*arguments, "--method", "spatial", "--iterations", "3")
    assert told.startswith("6 of 6 pixels moved")
    command(*arguments, "--iterations", "3", status=2)
    command(*arguments, "--method", "spatial", "--table", "9", status=2)
    (tmp_path / "table.csv").write_text("L,a,b\n50,0,0\n")
    _, told = command(
        "map", tmp_path / "table.csv", *arguments[2:4], "--method", "spatial", status=2
    )
    assert "neighbours" in told
    assert "Map a picture" in told


def test_a_picture_is_written_with_another_depth(command, cubes, tmp_path):
    given, mapped = tmp_path / "given.png", tmp_path / "mapped.png"
    Image.new("RGB", (3, 2), (255, 0, 0)).save(given)
    arguments = ("map", given, "--gamut", cubes / "small.gamut", "-o", mapped)
    command(*arguments, "--depth", "16")
    assert mapped.read_bytes()[24] == 16  # the depth in PNG's header
    command(*arguments, "--depth", "12", status=2)
    (tmp_path / "table.csv").write_text("L,a,b\n50,0,0\n")
    command("map", tmp_path / "table.csv", *arguments[2:], "--depth", "8", status=2)


@pytest.mark.slow
def test_gamuts_for_pictures_have_a_space_of_their_own(command, cubes, tmp_path):
    """Blue keeps its hue: in CIELAB, red is left where green should be."""
    given, mapped, mesh = (tmp_path / name for name in ("given.png", "mapped.png", "press.ply"))
    Image.new("RGB", (3, 2), (0, 0, 255)).save(given)
    command("mesh", cubes / "small.gamut", "-o", mesh)
    press = (ROOT / "examples" / "FOGRA39L.ti3", "--surface-samples", "1000")

    def blue(*gamut):
        _, told = command("map", given, "--gamut", *gamut, "-o", mapped)
        with Image.open(mapped) as found:
            return found.getpixel((1, 1)), "built in CAM16-UCS" in told, "purple" in told

    (red, green, _), built, purple = blue(*press)
    assert (red < green, built, purple) == (True, True, False)
    (red, green, _), built, purple = blue(*press, "--space", "CIELAB")
    assert (red < green, built, purple) == (False, False, True)
    assert blue(cubes / "small.gamut")[1:] == (False, True)
    assert blue(mesh)[1:] == (False, True)
    sources = ("--method", "sgck", "--from")
    assert blue(*press, *sources, "sRGB")[1]
    assert not blue(cubes / "small.gamut", *sources, cubes / "large.gamut")[1]
    (tmp_path / "table.csv").write_text("L,a,b\n30,20,-90\n")
    _, told = command("map", tmp_path / "table.csv", "--gamut", *press)
    assert "CAM16-UCS" not in told


@pytest.mark.parametrize("flag", ["--black-point-compensation", "--bpc"])
def test_black_becomes_the_black_of_the_gamut(command, cubes, tmp_path, flag):
    """L* 0, 10 and 20 are clipped to 30, or scaled to 30 and two lighter values."""
    table, given, mapped = (tmp_path / name for name in ("greys.csv", "given.png", "mapped.png"))
    table.write_text("L,a,b\n0,0,0\n10,0,0\n20,0,0\n")
    arguments = ("map", table, "--gamut", cubes / "large.gamut", "--max-error", "0")
    clipped, scaled = (
        [float(row["mapped_L"]) for row in rows(command(*arguments, *more)[0])]
        for more in ((), (flag,))
    )
    assert clipped == pytest.approx([30] * 3, abs=1e-3)
    assert scaled[0] == pytest.approx(30, abs=1e-3)
    assert 30.5 < scaled[1] < scaled[2]
    Image.new("RGB", (3, 2), (30, 30, 30)).save(given)
    values = []
    for more in ((), (flag,)):
        command("map", given, *arguments[2:4], "-o", mapped, *more)
        with Image.open(mapped) as found:
            values.append(found.getpixel((1, 1))[0])
    assert values[0] < values[1]
    command(*arguments, flag, "--method", "sgck", "--from", cubes / "large.gamut", status=2)


@pytest.mark.slow
def test_compare(command, as_json, cubes):
    pair = ("compare", cubes / "large.gamut", cubes / "small.gamut")
    found = as_json(*pair)
    assert found["volume_a"] == pytest.approx(40**3)
    assert found["intersection"] == pytest.approx(20**3)
    assert found["a_covers_b"] == pytest.approx(1.0)
    assert found["b_covers_a"] == pytest.approx(1 / 8)
    shown, _ = command(*pair, "--lost")
    assert shown.startswith("large reaches further at every hue: by up to 14 in chroma")
    assert "The whole surface of small is inside large." in shown
    figures = table_of(shown)
    assert figures[""] == ["large", "small"]
    assert figures["volume (cubic ΔE*ab)"] == ["64,000", "8,000"]
    assert figures["share of the other covered (%)"] == ["100.0", "12.5"]
    assert figures["darkest colour (L*)"] == ["30.0", "40.0"]
    assert figures["surface outside the other (%)"] == ["100.0", "0.0"]
    assert "In common: 8,000 cubic ΔE*ab, 12.5 % of both together." in shown
    assert max(map(len, shown.splitlines())) <= 80
    by_hue = rows(command(*pair, "--csv", "--sectors", 4)[0])
    assert [float(row["volume_a"]) for row in by_hue] == pytest.approx([10 * 40**2] * 4)


@pytest.mark.slow
def test_options_of_intervals_are_not_ignored(command, cubes):
    pair = ("compare", cubes / "large.gamut", cubes / "small.gamut")
    for options in (["--noise", "0.3"], ["--same-instrument"], ["--interval", "--csv"]):
        command(*pair, *options, status=2)


@pytest.mark.parametrize("line", [("slice", "--hue", "40"), ("rings",)], ids=" ".join)
@pytest.mark.parametrize("suffix", [".png", ".svg", ".pdf"])
def test_without_matplotlib_drawings_say_what_to_install(
    command, cubes, tmp_path, monkeypatch, line, suffix
):
    monkeypatch.setattr("importlib.util.find_spec", lambda _: None)
    name, *asked = line
    path = tmp_path / f"large{suffix}"
    _, err = command(name, cubes / "large.gamut", *asked, "-o", path, status=1)
    assert "gamut-boundary-service[plot]" in err
    assert not path.exists()


COLOURS = "name,L,a,b\nmiddle,50,0,0\nwing,50,60,0\nfar,50,0,90\n"


@pytest.mark.slow
def test_match_takes_a_folder(command, cubes, tmp_path):
    """The cubes have the edges 40 and 20 about the axis, and 20 about a* 60."""
    colours = tmp_path / "colours.csv"
    colours.write_text(COLOURS)
    out, _ = command("match", colours, cubes)
    assert "beside and large print 2" in out
    assert "1 is printed by none: far" in out
    assert max(map(len, out.splitlines())) <= 80
    command("match", colours, cubes / "*.gamut", "-o", tmp_path / "match.csv")
    rows = list(csv.DictReader((tmp_path / "match.csv").read_text().splitlines()))
    distances = {(row["colour"], row["gamut"]): float(row["distance"]) for row in rows}
    assert len(distances) == 9
    assert distances["middle", "large"] == pytest.approx(-20, abs=0.01)
    assert distances["far", "small"] == pytest.approx(80, abs=0.01)
    _, err = command("match", colours, tmp_path / "none*.gamut", status=2)
    assert "no saved gamuts" in err
    command("match", colours, cubes, "-o", "match.doc", status=2)


def test_compare_three(command, as_json, cubes):
    document = as_json(
        "compare", cubes / "large.gamut", cubes / "small.gamut", cubes / "beside.gamut"
    )
    assert document["coverage"] == pytest.approx(
        np.array([[1, 1, 0], [1 / 8, 1, 0], [0, 0, 1]]), abs=1e-6
    )
    out, _ = command("compare", cubes)
    assert "64,000" in out
    command("compare", cubes, "--lost", status=2)
    command("compare", cubes, "--noise", "0.3", status=2)
    command("compare", cubes, "--same-instrument", status=2)


def write_cube(path):
    """Write the corners of a display's cube, with linear light of sRGB."""
    primaries = np.array([[41.24, 35.76, 18.05], [21.26, 71.52, 7.22], [1.93, 11.92, 95.05]])
    device = np.array(list(np.ndindex(3, 3, 3))) / 2
    lines = ["RGB_R,RGB_G,RGB_B,XYZ_X,XYZ_Y,XYZ_Z"]
    values = ((*(255 * row), *(primaries @ row**2.2)) for row in device)
    lines += [",".join(f"{value:.5g}" for value in row) for row in values]
    path.write_text("\n".join(lines))
    return path


def test_options_are_for_the_gamuts_that_they_apply_to(command, as_json, cubes, tmp_path):
    """As a picture has no surface samples, and a display no share of rare colours."""
    display, picture = write_cube(tmp_path / "display.csv"), tmp_path / "picture.png"
    corners = np.array(list(np.ndindex(2, 2, 2)))
    pixels = np.tile(64 + 128 * corners, (20, 1, 1))
    pixels[0] = 255 * corners  # rare colours
    Image.fromarray(pixels.astype(np.uint8)).save(picture)
    both = "--surface-samples", "600", "--popularity", "0.1"
    whole = as_json("compare", picture, display, "--surface-samples", "600")
    part = as_json("compare", picture, display, *both)
    assert part["volume_a"] < 0.5 * whole["volume_a"]
    assert part["volume_b"] == whole["volume_b"]
    colours = tmp_path / "colours.csv"
    colours.write_text("L,a,b\n50,0,0\n")
    assert "print" in command("match", colours, picture, display, *both)[0]
    matrix = gamutcore.compare_all([picture, display], surface_samples=600, popularity=0.1)
    assert matrix.volume[0] == pytest.approx(part["volume_a"], rel=0.01)  # of a coarser level
    err = command("compare", picture, display, "--layer", "x", status=2)[1]
    assert "layer 'x' does not apply: only OpenEXR files have layers" in err
    boxes = cubes / "small.gamut", cubes / "large.gamut"
    err = command("compare", *boxes, *both, status=2)[1]
    assert "built already" in err
    err = command("match", colours, *boxes, *both, status=2)[1]
    assert "built already" in err


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("build", "DATA", "-o", "x.png"), "x.png does not end in .gamut"),
        (("slice", "DATA", "--lightness", "50", "-o", "x.docx"), ".png, .svg, .pdf, .txt, .json"),
        (("rings", "DATA", "-o", "x.docx"), ".png, .svg, .pdf, .txt, .json"),
        (("export", "DATA", "--table", "edges"), "Give vertices, cusps, leaves or levels."),
        (("map", "PICTURE", "--gamut", "DATA", "-o", "x.docx"), "not written as .docx"),
        (("map", "PICTURE", "--gamut", "DATA", "--to", "device", "-o", "x.png"), "as TIFF"),
        (("compare", "DATA", "srgb", "-o", "x.png"), ".txt, .json or .csv"),
        (("report", "DATA", "--standard", "x"), "cie-246"),
        (("report", "DATA", "--standard", "cie-246"), "there is no reference"),
        (("report", "DATA", "--standard", "idms", "-o", "missing/x.html"), "no such folder"),
        (("info", "DATA", "-o", "FOLDER"), "a folder"),
    ],
)
def test_outputs_are_checked_before_a_gamut_is_built(command, tmp_path, arguments, told):
    """The data is no gamut, and the error is about the output all the same."""
    data, picture = tmp_path / "data.ti3", tmp_path / "picture.png"
    data.write_bytes(b"")
    Image.new("RGB", (2, 2)).save(picture)
    paths = {"DATA": data, "PICTURE": picture, "FOLDER": tmp_path}
    words = [paths.get(word, word) for word in arguments]
    # errors about the file that is written are no errors of usage
    status = 1 if told in {"not written as .docx", "as TIFF", "no such folder", "a folder"} else 2
    assert told in " ".join(command(*words, status=status)[1].split())


def test_a_file_that_is_cut_off_is_said_to_be(command, saved, tmp_path):
    content = Path(saved).read_bytes()
    for size in (len(content) - 1, len(content) // 2, 300):
        cut = tmp_path / "cut.gamut"
        cut.write_bytes(content[:size])
        err = command("info", cut, status=1)[1]
        assert f"cut off after {size} " in err
        assert str(cut) in err
