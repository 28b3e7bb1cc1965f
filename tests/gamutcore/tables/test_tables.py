"""Tables of colours: what is read, what is refused, and what comes back unchanged."""

import csv
import io
import struct

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gamutcore.errors import (
    GamutError,
    InvalidPointsError,
    MalformedFileError,
    MissingColumnError,
    SampleLimitError,
    UnrecognisedFormatError,
)
from gamutcore.tables import frame_colours, read_table, write_workbook

RED = [228 / 255, 0.0, 43 / 255]


def read(text, **options):
    return read_table(text if isinstance(text, bytes) else text.encode(), **options)


@pytest.mark.parametrize(
    ("text", "space", "points"),
    [
        ("name;L*;a*;b*\nx;50,5;1;2\n", "CIELAB", [50.5, 1, 2]),
        ("b* (D50)\tname\tL* (D50)\ta* (D50)\n2\tx\t50\t1\n", "CIELAB", [50, 1, 2]),
        ("CIE-L|CIE-a|CIE-b\n50|1|2\n", "CIELAB", [50, 1, 2]),
        ("sep=:\nL:a:b\n50:1:2\n", "CIELAB", [50, 1, 2]),
        ("L a b\n50 1 2\n", "CIELAB", [50, 1, 2]),
        ("h,C,L\n90,20,50\n", "LCHab", [50, 20, 90]),
        ("X,Y,Z\n40,30,10\n", "CIEXYZ", [0.4, 0.3, 0.1]),
        ("X,Y,Z\n0.4,0.3,0.1\n", "CIEXYZ", [0.4, 0.3, 0.1]),
        ("x,y,Y\n0.25,0.5,100\n", "CIEXYZ", [0.5, 1, 0.5]),
        ("R,G,B\n228,0,43\n", "sRGB", RED),
        ("Red,Green,Blue\n0.5,0,0.25\n", "sRGB", [0.5, 0, 0.25]),
        ("name,hex\nx,#E4002B\n", "sRGB", RED),
        ("hex\ne4002b\n", "sRGB", RED),
        ("#e4002b\n", "sRGB", RED),
        ('name,colour\nx,"rgb(228, 0, 43)"\n', "sRGB", RED),
        ("colour\nrgb(228 0 43 / 50%)\n", "sRGB", RED),
        ("colour\nhsl(120 100% 50%)\n", "sRGB", [0, 1, 0]),
        ("colour\nlab(50% 40 -20)\n", "CIELAB", [50, 40, -20]),
        ("colour\nlch(50 40 90deg)\n", "LCHab", [50, 40, 90]),
        ("colour\noklch(0.5 50% 90)\n", "Oklab", [0.5, 0, 0.2]),
        ("name,L,a,b,L\nx,50,1,2,y\n", "CIELAB", [50, 1, 2]),
    ],
)
def test_columns_space_and_scale_are_recognised_and_stated(text, space, points):
    table = read(text)
    assert table.space == space
    np.testing.assert_allclose(table.points, [points], atol=1e-12)
    assert space in table.reading


@pytest.mark.parametrize(
    "encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "cp1252"]
)
def test_encodings_come_back(encoding):
    data = "name;L;a;b\nGrün – ©;50;1;2\n".encode(encoding)
    table = read(data)
    assert table.label(0) == "Grün – ©"
    assert table.answer_text({}).encode(table.encoding) == data


@pytest.mark.parametrize(
    ("text", "kind", "told"),
    [
        ("1,2,3\n", MissingColumnError, "L,a,b"),
        ("a,b,c\n1,2,3\n", MissingColumnError, "--columns"),
        ("C,M,Y,K\n1,2,3,4\n", MissingColumnError, "profile of the press"),
        ("L,a,b,R,G,B\n50,1,2,3,4,5\n", MissingColumnError, "L,a,b; R,G,B"),
        ("L,a,b,L,a,b\n50,1,2,3,4,5\n", MissingColumnError, "--columns 1,2,3"),
        ("L,a,b,LAB_L\n50,1,2,3\n", MissingColumnError, "--columns"),
        ("R,G,B\n1,0,0\n", InvalidPointsError, "1 or 255"),
        ("R,G,B\n1.5,20.5,3\n", InvalidPointsError, r"100 \(per cent\) or 255"),
        ("R,G,B\n300,1,2\n", InvalidPointsError, "1023"),
        ("X,Y,Z\n200,100,50\n", InvalidPointsError, "255"),
        ("L,a,b\n0.5,0.1,-0.1\n", InvalidPointsError, "Oklab"),
        ("L,a,b\n120,0,0\n", InvalidPointsError, "L is 120"),
        ("L;a;b\n50,1;1.5;2\n", InvalidPointsError, "decimal"),
        ("L;a;b\n1.234,5;1;2\n", InvalidPointsError, "not a number"),
        ("L,a,b\n1,2,\n", InvalidPointsError, "leave all three"),
        ("L,a,b\n1,2,3,4\n", MalformedFileError, "4 cells"),
        ('L,a,b\n1,2,"3\n4,5,6\n', MalformedFileError, "quotation mark"),
        ("colour\nreddish\n", InvalidPointsError, "not a colour"),
    ],
)
def test_what_is_ambiguous_or_no_colour_is_refused_with_the_candidates(text, kind, told):
    with pytest.raises(kind, match=told) as caught:
        read(text)
    assert caught.value.where["line"] == (1 if kind is MissingColumnError else 2)


def test_errors_name_the_line_of_the_file_and_the_column():
    text = '# remark\n\nname,L,a,b\n"two\nlines",50,1,2\n\nx,120,0,0\n'
    with pytest.raises(InvalidPointsError) as caught:
        read(text)
    assert caught.value.where == {"line": 7, "row": 1, "field": "L"}


@pytest.mark.parametrize(
    ("options", "point"),
    [
        ({"columns": "4,5,6"}, [30, 4, 5]),
        ({"columns": "n,o,p"}, [30, 4, 5]),
        ({"columns": "p,o,n", "space": "LCHab"}, [5, 4, 30]),
        ({"columns": "L,a,b", "scale": 200}, [25, 0.5, 1]),
    ],
)
def test_columns_and_scale_are_chosen(options, point):
    np.testing.assert_allclose(read("L,a,b,n,o,p\n50,1,2,30,4,5\n", **options).points, [point])


def test_columns_without_names_are_read_if_their_space_is_given():
    table = read("50,1,2\n60,3,4\n", space="CIELAB")
    assert table.points.tolist() == [[50, 1, 2], [60, 3, 4]]
    assert table.answer_text({"x": [1, 2]}).splitlines()[0] == "L*,a*,b*,x"


@pytest.mark.parametrize(
    ("text", "space", "points", "labels"),
    [
        ("Brand red, 48, 68, 48\n", "CIELAB", [[48, 68, 48]], ["Brand red"]),
        (
            "Brand red 48 68 48\n\n50 0 0\n",
            "CIELAB",
            [[48, 68, 48], [50, 0, 0]],
            ["Brand red", "line 3"],
        ),
        ("185 C;60;10,5;\u22122,5;\n", "CIELAB", [[60, 10.5, -2.5]], ["185 C"]),
        ('"Red, dark"\t50\t0\t0\n', "CIELAB", [[50, 0, 0]], ["Red, dark"]),
        ("Red #ff0000\nGreen; #0f0\n", "sRGB", [[1, 0, 0], [0, 1, 0]], ["Red", "Green"]),
        ("Red, rgb(255, 0, 0)\n", "sRGB", [[1, 0, 0]], ["Red"]),
        ("lab(50% 20 -20)\n", "CIELAB", [[50, 20, -20]], ["lab(50% 20 -20)"]),
    ],
)
def test_lists_of_names_and_colours_need_no_header(text, space, points, labels):
    table = read(text, own="CIELAB")
    assert table.space == space
    np.testing.assert_allclose(table.points, points, atol=1e-12)
    assert [table.label(row) for row in range(len(points))] == labels


@pytest.mark.parametrize(
    ("text", "where", "told"),
    [
        ("Red, 255, 0, 0\n", {"line": 1, "row": 0, "field": "L*"}, "R,G,B"),
        ("0 100 100 0\n", {"line": 1, "field": "columns"}, "L,a,b"),
        ("50 0 0\n50 0\n", {"line": 2, "row": 1}, "one cell for each column"),
        ("Red, 1, 0.2, 0\n", {"line": 1, "row": 0, "field": "L*"}, "Oklab"),
        ("Red #f00\nnothing\n", {"line": 2, "row": 1, "field": "hex"}, "rgb()"),
    ],
)
def test_lines_of_a_list_that_are_no_colours_are_refused(text, where, told):
    with pytest.raises(GamutError) as raised:
        read(text, own="CIELAB")
    assert raised.value.where == where
    assert told in raised.value.remedy


def test_lists_of_numbers_need_a_space():
    with pytest.raises(MissingColumnError):
        read("Brand red, 48, 68, 48\n")
    assert read("Brand red, 0, 0.5, 1\n", space="sRGB").space == "sRGB"


def test_values_outside_srgb_and_a_stated_scale():
    assert read("R,G,B\n1,0,0\n", scale=1).points.tolist() == [[1, 0, 0]]
    assert read("R,G,B\n-0.2,1.05,0.5\n").points.tolist() == [[-0.2, 1.05, 0.5]]
    table = read("R,G,B\n1,0,51\n")
    np.testing.assert_allclose(table.own_values(table.points), [[1, 0, 51]])


def test_colours_of_several_spaces_become_cielab():
    """lab() of CSS is relative to D50. White and black are so in each space."""
    table = read("colour\n#fff\nlab(50 10 -20)\noklab(0 0 0)\n")
    assert table.space == "CIELAB"
    np.testing.assert_allclose(table.points, [[100, 0, 0], [50, 10, -20], [0, 0, 0]], atol=0.02)


def test_rows_without_a_colour_have_blank_answers_and_are_counted():
    text = "name;L;a;b\r\nx;50,5;1;2\r\n\r\nReds;;;\r\ny;40;1;2\r\n\r\n"
    table = read(text)
    assert (len(table.points), table.without_colour) == (2, 2)
    assert table.answer_text({"d": [1.5, np.nan], "ok": [True, False]}) == (
        "name;L;a;b;d;ok\r\nx;50,5;1;2;1,5;true\r\n\r\nReds;;;;;\r\ny;40;1;2;;false\r\n"
    )


def test_added_columns_never_replace_those_of_the_table():
    table = read("L,a,b,d,gamut_d\n50,1,2,3,4\n")
    text = table.answer_text({"d": [9], "e": [8]})
    assert text == "L,a,b,d,gamut_d,gamut_d_2,e\n50,1,2,3,4,9,8\n"


CELLS = st.text(
    st.characters(codec="utf-8", exclude_characters="\0", exclude_categories=("Cs",)), max_size=8
)


@settings(deadline=None)
@given(
    st.lists(st.lists(CELLS, min_size=2, max_size=2), min_size=1, max_size=5),
    st.sampled_from(",;\t|"),
    st.sampled_from(["\n", "\r\n"]),
    st.sampled_from([csv.QUOTE_MINIMAL, csv.QUOTE_ALL]),
)
def test_whatever_comes_in_comes_out_unchanged(rows, mark, end, quoting):
    """Line breaks, quotation marks, separators and texts that look like numbers in cells."""
    rows = [["note", "L", "a", "b", "L"]] + [[one, "50", "1.50", "-2", two] for one, two in rows]
    file = io.StringIO(newline="")
    # with CRLF, csv quotes both characters of line breaks
    csv.writer(file, delimiter=mark, quoting=quoting, lineterminator="\r\n").writerows(rows)
    data = file.getvalue().encode()
    if end == "\n" and not any("\r" in cell for row in rows for cell in row):
        data = data.replace(b"\r\n", b"\n")
    table = read(data)
    out = table.answer_text({"d": [1.25] * (len(rows) - 1)})
    found = list(csv.reader(io.StringIO(out, newline=""), delimiter=mark, strict=True))
    assert found == [[*rows[0], "d"], *([*row, "1.25"] for row in rows[1:])]
    assert table.answer_text({}) == data.decode()


@given(
    st.lists(st.sampled_from(['"', ",", ";", "\t", "\n", "1", "L", "a", "b", "#", " ", "R,G,B\n"]))
)
def test_any_text_is_a_table_or_a_named_error(pieces):
    try:
        table = read("".join(pieces))
    except GamutError:
        return
    assert np.isfinite(table.points).all()


def ase(*blocks):
    data = b"ASEF" + struct.pack(">HHI", 1, 0, len(blocks))
    for name, model, values in blocks:
        text = (name + "\0").encode("utf-16-be")
        content = struct.pack(">H", len(name) + 1) + text + model
        content += struct.pack(f">{len(values)}fH", *values, 0)
        data += struct.pack(">HI", 1, len(content)) + content
    return data


def test_adobe_swatches():
    table = read(ase(("Grün", b"LAB ", (0.5, -40, 20)), ("Blau", b"LAB ", (0.25, 10, -50))))
    assert table.points.tolist() == [[50, -40, 20], [25, 10, -50]]
    assert table.label(0) == "Grün"
    assert read(ase(("x", b"RGB ", (1, 0, 0)))).space == "sRGB"
    assert read(ase(("x", b"Gray", (0.5,)))).points.tolist() == [[0.5, 0.5, 0.5]]
    with pytest.raises(MissingColumnError, match="CMYK"):
        read(ase(("x", b"CMYK", (1, 0, 0, 0))))
    for end in range(4, 48):
        with pytest.raises(MalformedFileError):
            read(ase(("Grün", b"LAB ", (0.5, -40, 20)))[:end])


def test_measurements_are_read_as_measured_and_keep_their_names():
    text = (
        "CGATS.17\nBEGIN_DATA_FORMAT\nSAMPLE_NAME CMYK_C CMYK_M CMYK_Y CMYK_K LAB_L LAB_A LAB_B\n"
        'END_DATA_FORMAT\nBEGIN_DATA\n"Paper white" 0 0 0 0 95 0 -2\nSolid 100 0 0 0 55 -37 -50\n'
        "END_DATA\n"
    )
    table = read(text)
    np.testing.assert_allclose(table.points, [[95, 0, -2], [55, -37, -50]])
    assert table.label(0) == "Paper white"
    bands = [f"{nm}" for nm in range(380, 740, 10)]
    spectra = read("\n".join(",".join(row) for row in (["name", *bands], ["x", *["0.5"] * 36])))
    np.testing.assert_allclose(spectra.points, [[76.07, 0, 0]], atol=0.05)  # L* of Y = 50
    assert spectra.label(0) == "x"


@pytest.mark.parametrize("data", [b"\x89PNG\r\n\x1a\n", b"PK\x03\x04" + bytes(60), bytes(200)])
def test_other_content_is_refused(data):
    with pytest.raises(UnrecognisedFormatError):
        read(data)


class Frame(dict):
    """What is used of pandas and polars: the names of the columns, and a column by its name."""

    @property
    def columns(self):
        return list(self)


def test_names_of_the_columns_of_a_data_frame_count():
    frame = Frame(name=["x"], h=[90.0], C=[20.0], L=[50.0])
    points, space = frame_colours(frame, None, "CIELAB")
    assert (space, points.tolist()) == ("LCHab", [[50, 20, 90]])
    points, space = frame_colours(Frame(R=[228], G=[0], B=[43]), None, "CIELAB")
    assert space == "sRGB"
    np.testing.assert_allclose(points, [RED])
    assert frame_colours(Frame(L=[0.5], a=[0.1], b=[0.2]), None, "Oklab").space == "Oklab"
    assert frame_colours([[1, 2, 3]], None, "CIELAB") is None
    for other in (Frame(L=[120], a=[0], b=[0]), Frame(L=["x"], a=[0], b=[0])):
        with pytest.raises(InvalidPointsError):
            frame_colours(other, None, "CIELAB")
    with pytest.raises(MissingColumnError):
        frame_colours(Frame(C=[1], M=[2], Y=[3], K=[4]), None, "CIELAB")


def test_workbooks_have_numbers_and_texts(tmp_path):
    openpyxl = pytest.importorskip("openpyxl")
    table = read("note;L;a;b\n=1+1;50,5;1;2\n\n007;40;1;2\n")
    write_workbook(table, {"d": [1.5, np.nan], "ok": [True, False]}, tmp_path / "x.xlsx")
    sheet = openpyxl.load_workbook(tmp_path / "x.xlsx").active
    rows = [[cell.value for cell in row] for row in sheet]
    assert rows[0] == ["note", "L", "a", "b", "d", "ok"]
    assert rows[1] == ["=1+1", 50.5, 1, 2, 1.5, True]
    assert sheet["A2"].data_type == "s"
    assert rows[-1] == ["007", 40, 1, 2, None, False]


@pytest.mark.parametrize(
    ("text", "reading"),
    [
        ("name,hex\nx,#E4002B\n", "Column hex is read as sRGB."),
        ("#e4002b\n", "Texts of colours are read as sRGB."),
    ],
)
def test_texts_of_colours_are_stated_without_a_scale(text, reading):
    assert read(text).reading == reading


def test_colours_that_are_not_used_are_named():
    table = read("name,X,Y,Z,L,a,b\nred,40,30,10,50,1,2\n")
    assert (table.space, table.points.tolist()) == ("CIELAB", [[50, 1, 2]])
    assert table.reading == (
        "Columns L, a, b are read as CIELAB. Other colours are not used: X, Y, Z."
    )
    chosen = read("name,X,Y,Z,L,a,b\nred,40,30,10,50,1,2\n", space="CIEXYZ")
    assert chosen.space == "CIEXYZ"
    assert "not used: L, a, b" in chosen.reading


def test_the_space_of_the_gamut_comes_first():
    """The columns of Oklab and CIELAB have the same names."""
    assert read("L,a,b\n0.5,0.1,0.1\n", own="Oklab").space == "Oklab"
    assert read("50,1,2\n", own="CIELAB").points.tolist() == [[50, 1, 2]]
    assert read("R,G,B\n255,0,0\n", own="CIELAB").space == "sRGB"
    with pytest.raises(MissingColumnError) as caught:
        read("L,a\n50,1\n", own="CIELAB")
    assert caught.value.where["field"] == "b*"
    with pytest.raises(MissingColumnError, match="several spaces"):
        read("p_L,p_a,p_b,q_R,q_G,q_B\n1,2,3,1,0,0\n", names=("p", "q"), own="CIELAB")


def test_files_of_measurements_may_be_limited_in_bytes():
    text = "CGATS.17\nBEGIN_DATA_FORMAT\nLAB_L LAB_A LAB_B\nEND_DATA_FORMAT\nBEGIN_DATA\n"
    text += 100 * "50 0 0\n" + "END_DATA\n"
    assert len(read(text, most_bytes=len(text)).points) == 100
    for limit in ({"most_bytes": 500}, {"most": 99}):
        with pytest.raises(SampleLimitError) as caught:
            read(text, **limit)
        assert caught.value.where["limit"] in limit.values()
    assert len(read("L,a,b\n" + 100 * "50,0,0\n", most_bytes=500).points) == 100


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_rows_of_an_array_are_finite(value):
    file = io.BytesIO()
    np.save(file, [(50.0, 0.0, 0.0), (50.0, value, 0.0)])
    with pytest.raises(InvalidPointsError, match="Row 1") as refused:
        read_table(file.getvalue())
    assert refused.value.where["row"] == 1


def test_arrays_that_promise_more_than_there_is_are_refused():
    file = io.BytesIO()
    np.save(file, np.zeros((4, 3)))
    for shape in (b"(9999999999999, 3)", b"(4, 30000000000)", b"(4, 'x')", b"(4, "):
        with pytest.raises((MalformedFileError, InvalidPointsError)):
            read(file.getvalue().replace(b"(4, 3)", shape))


@pytest.mark.slow
def test_encodings_are_found_without_all_of_the_text():
    """A character beyond the first block decides."""
    text = "n,L,a,b\n" + 30_000 * "a long name of a colour beside it,50,1,2\n"
    for encoding, last in (("utf-8", "Grün"), ("cp1252", "Grün"), ("utf-16-le", "x")):
        table = read((text + f"{last},50,1,2").encode(encoding))
        assert table.encoding == encoding
        assert table.label(30_000) == last


@pytest.mark.parametrize(
    "lines",
    [
        ("Brand green #00a651", "#ff0000", "rgb(0, 0, 255)", "Deep, sea rgb(0, 0, 128)"),
        ("#ff0000", "Brand green #00a651", "Deep, sea rgb(0, 0, 128)", "rgb(0, 0, 255)"),
        ("rgb(0, 0, 255)", "Deep sea rgb(0 0 128)", "#ff0000", "Brand green #00a651"),
        ("Brand green,#00a651", "#ff0000", "Deep sea, rgb(0, 0, 128)", "rgb(0,0,255)"),
    ],
)
def test_a_list_mixes_names_with_a_notation_and_bare_notations(lines):
    wanted = {"green": (0, 166, 81), "#ff": (255, 0, 0), "rgb(": (0, 0, 255), "sea": (0, 0, 128)}
    table = read("\n".join(lines))
    assert table.space == "sRGB"
    points = dict(zip(table.labels(), (table.points * 255).tolist(), strict=True))
    assert len(points) == 4
    for label, point in points.items():
        (known,) = (colour for name, colour in wanted.items() if name in label)
        np.testing.assert_allclose(point, known, atol=1e-9)
