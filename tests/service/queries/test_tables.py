import numpy as np
import pytest

from gamutcore.errors import InvalidPointsError
from service.problems.problem import ProblemError
from service.queries.tables import read_table

AXES = ("L*", "a*", "b*")


def read(text, names=("colours",), most=100):
    content = text.encode() if isinstance(text, str) else text
    return read_table(bytearray(content), names, AXES, most)


def test_own_columns_are_kept_as_they_are():
    text = 'spot name,L*,a*,b*,note\n"Red, warm",50,60,40,"say ""x"""\n\nBlue,30,10,-50,\n'
    (points,), table = read(text)
    assert points.tolist() == [[50, 60, 40], [30, 10, -50]]
    assert table.header == ["spot name", "L*", "a*", "b*", "note"]
    rows = list(table.rows())
    assert rows == [["Red, warm", "50", "60", "40", 'say "x"'], ["Blue", "30", "10", "-50", ""]]
    assert [table.line_of(row) for row in (0, 1)] == [2, 4]


def test_axes_of_other_spaces_are_found():
    content = bytearray(b"j,a,b,c\n1,2,3,4\n")
    (points,), _ = read_table(content, ("colours",), ("J'", "a'", "b'"), 10)
    assert points.tolist() == [[1, 2, 3]]


def test_thousands_of_rows():
    rows = np.random.default_rng(0).uniform(-100, 100, (3500, 3))
    text = "L,a,b\n" + "".join(f"{a!r},{b!r},{c!r}\n" for a, b, c in rows.tolist())
    (points,), _ = read(text, most=3500)
    assert points.tolist() == rows.tolist()
    with pytest.raises(ProblemError) as caught:
        read(text, most=3499)
    assert caught.value.problem.code == "too-many-rows"


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("", {"line": 1, "field": "L*"}),
        ("L,a\n1,2\n", {"line": 1, "field": "b*"}),
        ("L,a,b,LAB_L\n1,2,3,4\n", {"line": 1, "field": "L*"}),
        ("L,a,b\n1,2,3\n1,2\n", {"row": 1}),
        ('L,a,b\n1,2,"3\n', {"line": 2}),
        (b"L,a,b\n\xff,2,3\n", {"line": 1}),
    ],
)
def test_other_tables_are_problems_with_a_place(text, place):
    with pytest.raises(ProblemError) as caught:
        read(text)
    problem = caught.value.problem
    assert problem.code == "invalid-body"
    assert dict(problem.where) == place
    assert problem.remedy


def test_a_cell_that_is_no_number_is_named():
    with pytest.raises(InvalidPointsError) as caught:
        read("L,a,b\n1,2,3\n1,,3\n")
    assert caught.value.where == {"field": "a", "row": 1}


def test_columns_of_several_colours_have_prefixes():
    with pytest.raises(ProblemError) as caught:
        read("L,a,b\n1,2,3\n", ("from", "to"))
    assert caught.value.problem.where["field"] == "from_L*"
