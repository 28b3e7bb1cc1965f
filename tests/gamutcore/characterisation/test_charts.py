"""Charts of Argyll: their colours are estimates, which queries may read and builds may not."""

import csv
import io
from pathlib import Path

import numpy as np
import pytest

from gamutcore import Gamut
from gamutcore.characterisation import read_characterisation
from gamutcore.cli.app import app, run
from gamutcore.errors import MissingColumnError, UnrecognisedFormatError
from gamutcore.tables import read_table

DATA = Path(__file__).parents[2] / "data" / "reports"
PRESS = (DATA / "chart-cmyk.ti1").read_text()
SPREADSHEET = "\n".join(",".join(line.split()) for line in PRESS.splitlines())
D50 = np.array([96.42, 100.0, 82.49])


def lab(xyz, white):
    """CIELAB by the formulas of CIE 15:2018, 8.2.1."""
    ratio = np.asarray(xyz) / white
    f = np.where(ratio > (6 / 29) ** 3, np.cbrt(ratio), ratio * (29 / 6) ** 2 / 3 + 4 / 29)
    return np.stack(
        [116 * f[:, 1] - 16, 500 * (f[:, 0] - f[:, 1]), 200 * (f[:, 1] - f[:, 2])], axis=1
    )


def xyz_of_first_table(text):
    rows = text.split("BEGIN_DATA\n")[1].split("END_DATA")[0].splitlines()
    return np.array([row.split()[-3:] for row in rows], dtype=float)


CHARTS = {
    "ti1": PRESS,
    "ti2": (DATA / "chart-cmyk.ti2").read_text(),
    "display": (DATA / "chart-rgb.ti1").read_text(),
    "lower case": PRESS.replace("CTI1", "cti1"),
    "without the first word": PRESS.removeprefix("CTI1"),
    "another first word": PRESS.replace("CTI1", "CGATS.17", 1),
    "spreadsheet": SPREADSHEET,
}


@pytest.mark.parametrize("text", CHARTS.values(), ids=CHARTS)
def test_charts_are_refused_with_what_to_give(text):
    with pytest.raises(UnrecognisedFormatError) as caught:
        read_characterisation(text.encode())
    assert "estimates, which give the gamut of a device that does not exist" in str(caught.value)
    assert ".ti3" in caught.value.remedy
    assert "gamut query chart.ti" in caught.value.remedy
    assert "line" in caught.value.where


def test_measurements_of_a_chart_are_no_chart():
    measured = PRESS.replace("CTI1", "CTI3").replace("information 1", "information 3")
    assert len(read_characterisation(measured.encode())) == 10


@pytest.mark.parametrize("name", ["ti1", "ti2", "lower case", "another first word", "spreadsheet"])
def test_tables_have_the_patches_of_the_first_table(name):
    table = read_table(CHARTS[name].encode())
    source = CHARTS["ti2"] if name == "ti2" else PRESS
    np.testing.assert_allclose(table.points, lab(xyz_of_first_table(source), D50), atol=0.01)
    assert table.is_chart
    assert "estimates" in table.reading


def test_estimates_are_relative_to_the_white_of_the_chart():
    points = read_table(CHARTS["display"].encode()).points
    white = points[np.argmax(points[:, 0])]
    np.testing.assert_allclose(white, [100, 0, 0], atol=0.01)
    # a chart without a white patch has the stated white
    text = CHARTS["display"]
    rows = [line for line in text.splitlines() if " 100 100 100 " not in f"{line} "]
    dark = "\n".join(rows).split("CTI1")[1]
    others = read_table(f"CTI1{dark}".encode()).points
    np.testing.assert_allclose(others, [p for p in points if p[0] < 99.9], atol=1e-9)


DEVICE_ALONE = """CGATS.17
BEGIN_DATA_FORMAT
CMYK_C CMYK_M CMYK_Y CMYK_K
END_DATA_FORMAT
BEGIN_DATA
0 0 0 0
100 0 0 0
END_DATA
"""
SECOND_TABLE = """CTI1
BEGIN_DATA_FORMAT
INDEX XYZ_X XYZ_Y XYZ_Z
END_DATA_FORMAT
BEGIN_DATA
0 1 2 3
END_DATA
"""


@pytest.mark.parametrize(
    "text", [DEVICE_ALONE, DEVICE_ALONE.replace("CGATS.17", "CTI1") + SECOND_TABLE]
)
def test_charts_of_device_values_alone_have_no_colours(text):
    with pytest.raises(MissingColumnError, match="Device values alone are a chart: measure it"):
        read_table(text.encode())


@pytest.mark.slow
def test_query_counts_the_patches_inside_at_the_edge_and_outside(tmp_path, capsys):
    cube = np.array([50.0, 0, 0]) + 42 * (2.0 * np.array(list(np.ndindex(2, 2, 2))) - 1)
    Gamut(cube, gamma=1).save(tmp_path / "cube.gamut")
    arguments = ["query", str(DATA / "chart-cmyk.ti1"), "--gamut", str(tmp_path / "cube.gamut")]
    assert run(app, arguments) == 0
    out, err = capsys.readouterr()
    colours = lab(xyz_of_first_table(PRESS), D50)
    away = np.abs(colours - [50, 0, 0]).max(axis=1) - 42
    assert not ((np.abs(away) > 0.8) & (np.abs(away) < 1.2)).any()  # none where rounding decides
    inside, outside = int((away < -1).sum()), int((away > 1).sum())
    edge = len(colours) - inside - outside
    assert f"By position: {inside} inside, {edge} at the edge, {outside} outside." in err
    assert f"of {len(colours)} patches are in gamut" in err
    rows = list(csv.DictReader(io.StringIO(out)))
    assert [row["position"] for row in rows].count("outside") == outside
    assert rows[0]["CMYK_C"] == "0.00000"


@pytest.mark.slow  # compiles CIEDE2000, as other slow tests do
def test_charts_meet_relative_gamuts_without_a_warning_about_measured_colours(tmp_path, capsys):
    samples = "C,M,Y,L,a,b\n" + "".join(
        f"{100 * c},{100 * m},{100 * y},{92 - 25 * (c + m + y)},{70 * (m - c) + 1},{70 * (y - m)}\n"
        for c, m, y in np.ndindex(2, 2, 2)
    )
    (tmp_path / "press.csv").write_text(samples)
    for intent, told in (("relative", False), ("absolute", True)):
        arguments = ["query", str(DATA / "chart-cmyk.ti1"), "--gamut", str(tmp_path / "press.csv")]
        assert run(app, [*arguments, "--surface-samples", "200", "--intent", intent]) == 0
        err = capsys.readouterr().err
        assert "for colours as measured" not in err
        assert ("estimates of a chart are relative to its white: build" in err) == told
