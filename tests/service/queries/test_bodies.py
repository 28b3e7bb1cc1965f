import io
import json

import numpy as np
import pytest

from gamutcore.errors import InvalidPointsError
from service.problems.problem import ProblemError
from service.queries.bodies import CSV, FORMS, JSON, NPY, parse_body
from service.queries.operations import OPERATIONS

AXES = ("L*", "a*", "b*")
CONTAINS = OPERATIONS["contains"]
ROWS = np.array([[50.0, 1.5, -2.25], [0.1, 0.0, 100.0]])


def npy(array, version=None):
    file = io.BytesIO()
    np.lib.format.write_array(file, array, version, allow_pickle=True)
    return file.getvalue()


def parse(content, media_type=JSON, operation=CONTAINS):
    if isinstance(content, dict):
        content = json.dumps(content)
    if isinstance(content, str):
        content = content.encode()
    return parse_body(bytearray(content), media_type, operation, AXES)


@pytest.mark.parametrize(
    ("content", "media_type"),
    [
        ({"colours": ROWS.tolist()}, JSON),
        (npy(ROWS), NPY),
        (npy(ROWS, (2, 0)), NPY),
        (npy(np.asfortranarray(ROWS)), NPY),
        (npy(ROWS.astype(">f8")), NPY),
        ("L*,a*,b*\n50,1.5,-2.25\n0.1,0,1e2\n", CSV),
        ("\ufeffname,LAB_B,lab_a,L\r\nx,-2.25,1.5,50\r\n\r\n'y',100,0,.1", CSV),
    ],
)
def test_all_forms_give_the_same_points(content, media_type):
    body = parse(content, media_type)
    (points,) = body.inputs
    assert points.dtype == np.float64
    assert points.tolist() == ROWS.tolist()
    assert body.rows == 2
    # others would be compiled for
    assert points.flags.c_contiguous
    assert points.flags.writeable


def test_single_precision_is_widened_exactly():
    (points,) = parse(npy(ROWS.astype(np.float32)), NPY).inputs
    assert points.tolist() == ROWS.astype(np.float32).tolist()


def test_rows_of_two_colours(sums):
    expected = [[[1, 2, 3], [7, 8, 9]], [[4, 5, 6], [10, 11, 12]]]
    table = "to_L,to_a,to_b,from L*,from a*,from b*\n4,5,6,1,2,3\n10,11,12,7,8,9\n"
    for content, media_type in (
        ({"from": expected[0], "to": expected[1], "factor": 2}, JSON),
        (npy(np.hstack([np.array(each, float) for each in expected])), NPY),
        (table, CSV),
    ):
        body = parse(content, media_type, sums)
        assert [points.tolist() for points in body.inputs] == expected
        assert all(points.flags.c_contiguous for points in body.inputs)


def test_parameters_are_kept_beside_the_colours():
    assert parse({"colours": [], "triangles": 4}).members == {"triangles": 4}
    assert parse({"colours": []}).rows == 0
    assert parse("L,a,b", CSV).rows == 0
    assert parse(npy(np.zeros((0, 3))), NPY).rows == 0


@pytest.mark.parametrize(
    ("rows", "faulty"),
    [
        ([[1, 2, 3], [1, 2]], 1),
        ([[1, 2, 3], [1, 2, 3, 4]], 1),
        ([[1, 2, 3], [1, None, 3]], 1),
        ([[1, 2, "3"]], 0),
        ([[1, 2, True]], 0),
        ([[1, 2, 3], "abc"], 1),
        ([1, 2, 3], 0),
        ([[[1], [2], [3]]], 0),
        ([[1, 2, 3], [10**400, 0, 0]], 1),
        ([[1, 2, 3], [1e61, 0, 0]], 1),
        ([{"L": 1}], 0),
    ],
)
def test_a_row_that_is_no_colour_is_named(rows, faulty):
    with pytest.raises(InvalidPointsError) as caught:
        parse({"colours": rows})
    assert caught.value.where == {"field": "colours", "row": faulty}


def test_numbers_that_are_not_finite_are_named():
    damaged = ROWS.copy()
    for value in (np.nan, np.inf, -np.inf):
        damaged[1, 2] = value
        with pytest.raises(InvalidPointsError) as caught:
            parse(npy(damaged), NPY)
        assert caught.value.where == {"field": "colours", "row": 1}
        with pytest.raises(InvalidPointsError) as caught:
            parse(f"L,a,b\n\n1,2,3\n4,5,{value}\n", CSV)
        assert caught.value.where == {"field": "colours", "row": 1, "line": 4}
    with pytest.raises(InvalidPointsError) as caught:
        parse('{"colours": [[1, 2, 1e999]]}')
    assert caught.value.where["row"] == 0


@pytest.mark.parametrize(
    ("content", "code", "field"),
    [
        ("[]", "invalid-body", "colours"),
        ("{}", "invalid-body", "colours"),
        ('{"colours": 3}', "invalid-body", "colours"),
        ('{"colours": [], "color": 1}', "invalid-body", "color"),
        ('{"colours": [], "colours": [[1, 2, 3]]}', "invalid-body", "colours"),
        ('{"colours": [], "\\u0063olours": []}', "invalid-body", "colours"),
        ('{"colours": [[1, 2, NaN]]}', "malformed-body", None),
        ('{"colours": [[1, 2,', "malformed-body", None),
        ("", "malformed-body", None),
        (b'{"colours": "\xff"}', "malformed-body", None),
    ],
)
def test_other_json_is_a_problem(content, code, field):
    with pytest.raises(ProblemError) as caught:
        parse(content)
    assert caught.value.problem.code == code
    assert caught.value.problem.where.get("field") == field


def test_inputs_have_equal_numbers_of_rows(sums):
    with pytest.raises(ProblemError) as caught:
        parse({"from": [[1, 2, 3]], "to": []}, JSON, sums)
    assert "from 1, to 0" in caught.value.problem.detail


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"\x93NUMPY",
        b"PK\x03\x04" + bytes(100),
        npy(ROWS)[:-1],
        npy(ROWS) + b"\0",
        npy(ROWS).replace(b"(2, 3)", b"(9, 3)"),
        npy(ROWS).replace(b"(2, 3)", b"(-2, 3)"),
        npy(ROWS).replace(b"'<f8'", b"'<z8'"),
        npy(ROWS[0]),
        npy(np.hstack([ROWS, ROWS])),
        npy(ROWS.astype(np.int32)),
        npy(ROWS.astype(np.float16)),
        npy(ROWS.astype(complex)),
        npy(np.array([[{}, [], ()]], object)),
        npy(np.zeros(2, [("L", "f8"), ("a", "f8"), ("b", "f8")])),
        b"\x93NUMPY\x01\x00\xff\xff" + b"(" * 70_000,
        b"\x93NUMPY\x02\x00\xff\xff\xff\xff" + bytes(200),
        b"\x93NUMPY\x01\x00\x40\x00" + b"{'descr': __import__('os'), 'shape': (1,3)}".ljust(64),
    ],
)
def test_other_files_are_refused(content):
    with pytest.raises(ProblemError) as caught:
        parse(content, NPY)
    assert caught.value.problem.code == "invalid-body"


@pytest.mark.slow
def test_too_many_rows_are_refused_before_they_are_decoded():
    most = FORMS[JSON].most_rows
    assert parse({"colours": [[1, 2, 3]] * most}).rows == most
    huge = npy(ROWS).replace(b"(2, 3), }" + b" " * 20, b"(2000000000000000000, 3), }  ")
    for content, media_type in (
        ({"colours": [[1, 2, 3]] * (most + 1)}, JSON),
        ('{"colours": [' + "[" * 50_000, JSON),
        (huge, NPY),
    ):
        with pytest.raises(ProblemError) as caught:
            parse(content, media_type)
        assert caught.value.problem.code == "too-many-rows"
