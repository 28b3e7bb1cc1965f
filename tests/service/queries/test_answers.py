import io
import json

import numpy as np

from service.queries.answers import WRITERS
from service.queries.bodies import CSV, JSON, NPY, Body
from service.queries.tables import Table

ROWS = np.array([[2.0, 0.5, 0.25], [0.0, 1.0, 2.0], [3.0, -1.0, 0.1]])


def written(media_type, operation, level, body, cut=2):
    """The bytes of an answer that is written in two pieces."""
    writer = WRITERS[media_type](operation, level, body)
    pieces = [[points[:cut] for points in body.inputs], [points[cut:] for points in body.inputs]]
    if media_type == JSON:
        pieces = [body.inputs]
    results = [operation.answer(level, piece, {"factor": 2.0}) for piece in pieces]
    entries = sum(len(next(iter(result.columns.values()))) for result in results)
    starts = [0, cut]
    parts = [writer.piece(start, each) for start, each in zip(starts, results, strict=False)]
    return writer.head(results[0], entries) + b"".join(parts)


def test_json_has_the_level_and_one_array_per_column(sums, cube):
    document = json.loads(written(JSON, sums, cube, Body([ROWS, ROWS], {})))
    assert document["level"] == {"triangles": 12, "max_error": 0.5}
    assert document["sum"] == (4 * ROWS.sum(axis=1)).tolist()
    assert document["first"] == ROWS.tolist()


def test_json_has_one_array_per_row_if_rows_have_several_entries(repeats, cube):
    document = json.loads(written(JSON, repeats, cube, Body([ROWS], {})))
    assert document["t"] == [[0, 1], [], [0, 1, 2]]
    assert document["entering"] == [[True, False], [], [True, False, True]]


def test_npy_is_a_structured_array(sums, repeats, cube):
    array = np.load(io.BytesIO(written(NPY, sums, cube, Body([ROWS, ROWS], {}))))
    assert array.dtype.names == ("sum", "first")
    assert array["first"].tolist() == ROWS.tolist()
    assert array["sum"].tolist() == (4 * ROWS.sum(axis=1)).tolist()
    array = np.load(io.BytesIO(written(NPY, repeats, cube, Body([ROWS], {}))))
    assert array["row"].tolist() == [0, 0, 2, 2, 2]
    assert array["t"].tolist() == [0, 1, 0, 1, 2]


def test_csv_appends_to_the_columns_of_the_client(sums, repeats, cube):
    table = Table(bytearray(b'name,L\n"a,b",1\nc,2\nd,3\n'), ["name", "L"])
    text = written(CSV, sums, cube, Body([ROWS, ROWS], {}, table)).decode()
    assert text.splitlines() == [
        "name,L,sum,first_L*,first_a*,first_b*",
        '"a,b",1,11.0,2.0,0.5,0.25',
        "c,2,12.0,0.0,1.0,2.0",
        "d,3,8.4,3.0,-1.0,0.1",
    ]
    text = written(CSV, repeats, cube, Body([ROWS], {}, table)).decode()
    assert text.splitlines() == [
        "name,L,t,entering",
        '"a,b",1,0.0,true',
        '"a,b",1,1.0,false',
        "c,2,,",
        "d,3,0.0,true",
        "d,3,1.0,false",
        "d,3,2.0,true",
    ]


def test_csv_without_columns_of_the_client_has_the_colours(sums, cube):
    text = written(CSV, sums, cube, Body([ROWS[:1], ROWS[:1]], {}), cut=1).decode()
    first = "from_L*,from_a*,from_b*,to_L*,to_a*,to_b*,sum,first_L*,first_a*,first_b*"
    assert text.splitlines() == [first, "2.0,0.5,0.25,2.0,0.5,0.25,11.0,2.0,0.5,0.25"]


def test_nothing_has_columns_as_well(repeats, cube):
    nothing = Body([np.empty((0, 3))], {})
    document = json.loads(written(JSON, repeats, cube, nothing))
    assert document["t"] == []
    assert len(np.load(io.BytesIO(written(NPY, repeats, cube, nothing)))) == 0
