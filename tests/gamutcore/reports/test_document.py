"""The files of a report hold the same cells, and show them to people."""

import csv
import io
import json
import re
from html.parser import HTMLParser

import numpy as np
import pytest

from gamutcore.errors import OptionError
from gamutcore.reports import Chart, Report, ReportColumn, ReportTable


@pytest.fixture
def report():
    columns = [
        ReportColumn("gamut", ["press", "=1+1", "<script>"]),
        ReportColumn("volume", np.array([1234567.891, np.nan, 12.0]), "cubic ΔE", decimals=0),
        ReportColumn("covered", [0.5, 1.0, None], kind="share"),
        ReportColumn("swatch", ["#ff0000", "#00ff00", None], kind="colour"),
        ReportColumn("inside", [True, False, None]),
    ]
    columns += [ReportColumn(f"further {at}", [at, at, at]) for at in range(8)]
    return Report(
        "Three gamuts & their shares",
        ["The press covers a half. " * 6],
        {"intent": "relative", "white": "D50 " * 30},
        [ReportTable("Gamuts: all [3]", columns, ["A note."])],
        warnings=["Two whites differ."],
        data={"count": np.int64(3), "nothing": float("nan")},
    )


def test_text_fits_80_columns_and_names_what_it_leaves_out(report):
    text = report.to_text()
    assert max(map(len, text.splitlines())) <= 80
    assert "1,234,568" in text
    assert re.search(r"\d more columns do not fit", text)
    assert "#ff0000" not in text


def test_csv_and_json_have_the_numbers_in_full(report):
    rows = list(csv.DictReader(io.StringIO(report.to_csv())))
    assert [row["volume"] for row in rows] == ["1234567.891", "", "12"]
    assert [row["inside"] for row in rows] == ["true", "false", ""]
    document = json.loads(report.to_json())
    columns = {column["name"]: column for column in document["tables"][0]["columns"]}
    assert columns["volume"]["values"] == [1234567.891, None, 12.0]
    assert (document["count"], document["nothing"]) == (3, None)
    assert document["warnings"] == ["Two whites differ."]


def test_a_long_name_leaves_room_for_the_figures():
    names = ["A press with coated paper of 135 g per square metre, " * 3, "srgb"]
    columns = [ReportColumn("gamut", names), ReportColumn("volume", [1.25, 2.5])]
    columns.append(ReportColumn("worst", ["Emerald 4.9, Turquoise 3.0, Lagoon 2.4 " * 2, ""]))
    text = Report("Long", ["."], tables=[ReportTable("t", columns)]).to_text()
    assert max(map(len, text.splitlines())) <= 80
    assert "1.25" in text
    assert "…" in text
    assert "Emerald" in text
    assert "not fit" not in text


def test_columns_of_equal_names_stay_apart_in_json():
    """A table of colours has a column for each gamut, whatever the name of the gamut is."""
    columns = [ReportColumn("best", ["best", "b"]), ReportColumn("best", [0.0, 1.5], "ΔE00")]
    document = json.loads(Report("Match", ["."], tables=[ReportTable("t", columns)]).to_json())
    assert document["tables"][0]["columns"] == [
        {"name": "best", "unit": "", "values": ["best", "b"]},
        {"name": "best", "unit": "ΔE00", "values": [0.0, 1.5]},
    ]


def test_a_workbook_has_numbers_as_numbers_and_no_formulas(report, tmp_path):
    openpyxl = pytest.importorskip("openpyxl")
    report.save(tmp_path / "report.xlsx")
    book = openpyxl.load_workbook(tmp_path / "report.xlsx")
    assert book.sheetnames == ["Gamuts  all  3", "About"]
    sheet = book.worksheets[0]
    assert sheet["B2"].value == 1234567.891
    assert (sheet["A3"].value, sheet["A3"].data_type) == ("=1+1", "s")
    assert sheet["B3"].value is None


class Page(HTMLParser):
    """Collects the texts of cells, and addresses that a page loads."""

    def __init__(self):
        super().__init__()
        self.cells, self.addresses, self.elements, self.inside = [], [], [], False

    def handle_starttag(self, tag, attrs):
        self.elements.append(tag)
        self.inside = tag == "td" or (self.inside and tag in {"svg", "rect"})
        if tag == "td":
            self.cells.append("")
        self.addresses += [value for name, value in attrs if name in {"src", "href"}]

    def handle_data(self, data):
        if self.inside:
            self.cells[-1] += data


def test_a_page_loads_nothing_and_shows_all_cells(report):
    text = report.to_html()
    page = Page()
    page.feed(text)
    assert page.elements.count("script") == 1  # the name of a gamut is not one
    assert page.addresses == []
    assert [cell.strip() for cell in page.cells[:3]] == ["press", "1,234,568", "50.0"]
    assert len(page.cells) == 3 * 13
    assert "default-src 'none'" in text


def test_another_suffix_is_refused_with_those_that_are_known(report, tmp_path):
    with pytest.raises(OptionError, match=r"output") as refused:
        report.save(tmp_path / "report.doc")
    assert ".xlsx" in refused.value.remedy
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_charts_stand_in_pages_and_pdf(report, tmp_path):
    pytest.importorskip("matplotlib")

    def draw(figure):
        figure.add_subplot().plot([0, 1], [0, 1])

    drawn = Report(report.title, report.sentences, charts=[Chart("A line", draw)])
    page = Page()
    page.feed(drawn.to_html())
    assert [address[:26] for address in page.addresses] == ["data:image/svg+xml;base64,"]
    drawn.save(tmp_path / "report.pdf")
    assert (tmp_path / "report.pdf").read_bytes().count(b"/Type /Page ") == 2


def test_what_rounds_to_zero_has_no_minus_sign_and_one_column_is_one():
    columns = [
        ReportColumn("patch", ["cyan"]),
        ReportColumn("change", [-0.004]),
        ReportColumn("share", np.array([-1e-9]), kind="share"),
        ReportColumn("x" * 70, [1]),
    ]
    text = Report("Drift", ["Nothing changed."], tables=[ReportTable("Patches", columns)]).to_text()
    assert text.splitlines()[-2].split() == ["cyan", "0.00", "0.0"]
    assert text.endswith("1 more column does not fit; write a file with -o.\n")


def test_tables_with_the_same_beginning_are_sheets_that_excel_opens(tmp_path):
    openpyxl = pytest.importorskip("openpyxl")
    name = "Press 4, second reading of November 2026.txt"
    tables = [
        ReportTable(f"{name}: {part}", [ReportColumn("patch", [part])])
        for part in ("solids", "overprints", "largest changes")
    ]
    Report("Drift", ["Nothing changed."], tables=tables).save(tmp_path / "drift.xlsx")
    sheets = openpyxl.load_workbook(tmp_path / "drift.xlsx").sheetnames
    assert len({sheet.lower() for sheet in sheets}) == 4
    assert max(map(len, sheets)) <= 31  # by Excel's specifications


def test_names_with_dollar_signs_are_no_mathematics(tmp_path):
    pytest.importorskip("matplotlib")
    name = "press $x_$ at $5"
    Report(name, [name], charts=[Chart(name, lambda page: page.add_subplot())]).save(
        tmp_path / "report.pdf"
    )
    assert (tmp_path / "report.pdf").read_bytes().startswith(b"%PDF")
