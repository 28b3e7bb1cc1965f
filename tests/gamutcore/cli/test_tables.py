"""Tables of colours: their columns, delimiters and numbers."""

import io

import pytest

from gamutcore.cli.tables import read_colours
from gamutcore.errors import MalformedFileError, MissingColumnError


def read(tmp_path, text, **arguments):
    (tmp_path / "table").write_text(text)
    return read_colours(str(tmp_path / "table"), **arguments)


@pytest.mark.parametrize(
    ("text", "arguments", "space"),
    [
        ("L,a,b\n50,1,2\n", {}, "CIELAB"),
        ("LAB_L\tLAB_A\tLAB_B\n50\t1\t2\n", {}, "CIELAB"),
        ("name;L*;a*;b*\nx;50,0;1,0;2,0\n", {}, "CIELAB"),
        ("L,C,H\n50,1,2\n", {}, "LCHab"),
        ("R,G,B\n50,1,2\n", {"space": "sRGB"}, "sRGB"),
        ("one,two,three\n50,1,2\n", {"names": "one,two,three"}, "CIELAB"),
        ("J,a,b\n50,1,2\n", {"names": "J,a,b", "space": "CAM16-UCS"}, "CAM16-UCS"),
    ],
)
def test_colours_are_found(tmp_path, text, arguments, space):
    found = read(tmp_path, text, **arguments)
    assert found.colours.tolist() == [[50, 1, 2]]
    assert found.space == space


def test_cells_stay_as_they_are(tmp_path):
    found = read(tmp_path, '# a comment\nname,L,a,b\n"Blue, dark",50.0,1,+2\n\n')
    assert found.columns == {"name": ["Blue, dark"], "L": ["50.0"], "a": ["1"], "b": ["+2"]}
    assert found.label(0) == "Blue, dark"


def test_a_row_without_a_name_has_its_number(tmp_path):
    assert read(tmp_path, "L,a,b\n50,1,2\n50,1,2\n").label(1) == "row 2"


def test_standard_input(monkeypatch):
    monkeypatch.setattr("sys.stdin", io.StringIO("L,a,b\n50,1,2\n"))
    assert read_colours("-").colours.tolist() == [[50, 1, 2]]


def test_what_is_no_table(tmp_path):
    for text in ("L,a,b\n1,2\n", "L,a,b\n1,2,x\n", "L,a,b\n1,2,3,4\n"):
        with pytest.raises(MalformedFileError) as caught:
            read(tmp_path, text)
        assert caught.value.where == {"row": 1}
    for names in (None, "L,a", "L,a,c"):
        with pytest.raises(MissingColumnError):
            read(tmp_path, "L,a,x\n1,2,3\n", names=names)
