"""Which of several gamuts print colours, over HTTP: boxes, whose distances are known."""

import csv
import io
import itertools
import json

import numpy as np
import pytest

JSON, CSV, NPY = "application/json", "text/csv", "application/x-npy"
COLOURS = [[50, 0, 0], [50, 7, 0], [50, 30, 0]]
WIDE, SMALL = "match box, wide", "match box, small"
EDGES = {WIDE: 20.0, SMALL: 10.0}


@pytest.fixture(scope="module")
def boxes(server):
    """Ids by name of two cubes about L* = 50, a* = b* = 0."""
    ids = {}
    for name, edge in EDGES.items():
        corners = itertools.product((-edge / 2, edge / 2), repeat=3)
        samples = [[50 + x, y, z] for x, y, z in corners]
        # The centre makes these gamuts others than those of other tests, which have no names.
        body = {"samples": samples, "name": name, "options": {"gamma": 1, "centre": [50, 0.5, 0]}}
        answer = server.client.post("/v1/gamuts", json=body)
        assert answer.status_code in {200, 201}, answer.text
        ids[name] = answer.json()["id"]
    return ids


def match(server, body=None, accept=JSON, **request):
    headers = {"Accept": accept} | request.pop("headers", {})
    if body is not None:
        request["json"] = body
    return server.client.post("/v1/matches", headers=headers, **request)


def test_positions_shares_and_groups(server, boxes):
    names = ["centre", "beside", "far"]
    answer = match(server, {"gamuts": list(boxes), "colours": COLOURS, "names": names})
    assert answer.status_code == 200, answer.text
    assert answer.headers["cache-control"] == "no-store"
    found = answer.json()
    wide, small = found["gamuts"]
    assert [each["id"] for each in found["gamuts"]] == list(boxes.values())
    assert [each["name"] for each in found["gamuts"]] == list(EDGES)
    # distances from the faces of the cubes, at half of their edges
    assert wide["distance"] == pytest.approx([-10, -3, 20], abs=1e-3)
    assert small["distance"] == pytest.approx([-5, 2, 25], abs=1e-3)
    assert wide["position"] == ["inside", "inside", "outside"]
    assert small["position"] == ["inside", "outside", "outside"]
    assert (wide["share"], small["share"]) == pytest.approx((2 / 3, 1 / 3))
    assert small["worst"] == ["far", "beside"]
    assert wide["delta_e_2000"][:2] == [0, 0]
    assert wide["mean_delta_e_2000"] == pytest.approx(wide["delta_e_2000"][2] / 3)
    assert found["colours"]["name"] == names
    assert found["colours"]["printed_by"] == [2, 1, 0]
    assert found["colours"]["best"] == [WIDE] * 3
    (pair,) = found["together"]
    assert pair == {"gamuts": list(EDGES), "printed": 2, "exact": True}
    assert wide["conditions"]["space"] == "CIELAB"


def test_tolerance_and_no_colour_differences(server, boxes):
    gamuts = list(boxes.values())
    found = match(server, {"gamuts": gamuts, "colours": COLOURS, "pass": 3.0}).json()
    assert found["tolerance"]["delta_e_2000"] == 3.0
    assert found["gamuts"][1]["prints"] == [True, True, False]
    found = match(server, {"gamuts": gamuts, "colours": COLOURS, "edge_width": 4}).json()
    assert found["gamuts"][1]["position"] == ["inside", "edge", "outside"]
    found = match(server, {"gamuts": gamuts, "colours": COLOURS, "delta_e": False}).json()
    assert "delta_e_2000" not in found["gamuts"][0]
    assert found["gamuts"][0]["mean_delta_e_2000"] is None


def test_forms_of_colours(server, boxes):
    params = {"gamuts": ",".join(boxes.values())}
    expected = match(server, {"gamuts": list(boxes.values()), "colours": COLOURS}).json()
    file = io.BytesIO()
    np.save(file, np.array(COLOURS, float))
    array = match(server, params=params, content=file.getvalue(), headers={"Content-Type": NPY})
    assert array.json() == expected
    lines = [f"colour {row},{row[0]},{row[1]},{row[2]}".replace(", ", " ") for row in COLOURS]
    table = "\n".join(["name,L,a,b", *lines]).encode()
    answer = match(server, params=params, content=table, headers={"Content-Type": CSV})
    found = answer.json()
    assert found["gamuts"] == [
        {**each, "worst": gamut["worst"]}
        for each, gamut in zip(expected["gamuts"], found["gamuts"], strict=True)
    ]
    assert found["colours"]["name"][0] == "colour [50 0 0]"
    assert "CIELAB" in found["reading"]
    assert "CIELAB" in answer.headers["gamut-reading"]


def test_csv_has_a_row_for_each_colour_and_gamut(server, boxes):
    answer = match(server, {"gamuts": list(boxes), "colours": COLOURS}, CSV)
    assert answer.headers["content-type"].startswith(CSV)
    rows = list(csv.DictReader(io.StringIO(answer.text)))
    assert [(row["colour"], row["gamut"]) for row in rows[:3]] == [
        ("1", WIDE),
        ("1", SMALL),
        ("2", WIDE),
    ]
    assert float(rows[3]["distance"]) == pytest.approx(2, abs=1e-3)


def test_names_are_parts_of_names(server, boxes):
    found = match(server, {"gamuts": ["BOX, WIDE"], "colours": COLOURS}).json()
    assert found["gamuts"][0]["id"] == boxes[WIDE]
    # one gamut by two names is one
    both = [WIDE, boxes[WIDE]]
    assert len(match(server, {"gamuts": both, "colours": COLOURS}).json()["gamuts"]) == 1


def test_ambiguous_and_unknown_names(server, boxes, assert_problem):
    answer = match(server, {"gamuts": ["match box"], "colours": COLOURS})
    problem = assert_problem(answer, 422, "invalid-parameter")
    assert problem["where"]["field"] == "gamuts"
    assert {each["id"] for each in problem["where"]["candidates"]} == set(boxes.values())
    answer = match(server, {"gamuts": ["no such press"], "colours": COLOURS})
    assert "no such press" in assert_problem(answer, 404, "gamut-not-found")["detail"]
    answer = match(server, {"gamuts": ["0" * 64], "colours": COLOURS})
    assert_problem(answer, 404, "gamut-not-found")


@pytest.mark.parametrize(
    ("members", "code"),
    [
        ({"gamuts": []}, "invalid-parameter"),
        ({"gamuts": ["srgb", ""]}, "invalid-parameter"),
        ({"gamuts": [f"{number:064x}" for number in range(201)]}, "invalid-parameter"),
        ({"gamuts": 3}, "invalid-parameter"),
        ({"pass": -1}, "invalid-parameter"),
        ({"pass": 1, "delta_e": False}, "invalid-option"),
        ({"names": ["one"]}, "invalid-body"),
        ({"triangles": 100}, "invalid-body"),
        ({"colours": [[50, 0]]}, "invalid-points"),
        ({"colours": "red"}, "invalid-body"),
    ],
)
def test_refusals(server, boxes, assert_problem, members, code):
    body = {"gamuts": list(boxes.values()), "colours": COLOURS} | members
    assert_problem(match(server, body), 422, code)


def test_too_many_rows_for_so_many_gamuts(server, boxes, cubes, assert_problem):
    file = io.BytesIO()
    np.save(file, np.full((125_001, 3), 50.0, np.float32))
    gamuts = [*boxes.values(), *(address.rpartition("/")[2] for address in cubes)]
    answer = match(
        server,
        params={"gamuts": ",".join(gamuts)},
        content=file.getvalue(),
        headers={"Content-Type": NPY},
    )
    assert assert_problem(answer, 422, "too-many-rows")["where"]["limit"] == 125_000


def test_a_form_that_is_not_offered(server, boxes, assert_problem):
    body = {"gamuts": list(boxes.values()), "colours": COLOURS}
    assert_problem(match(server, body, NPY), 406, "not-acceptable")


def test_gamuts_in_different_spaces(server, boxes, assert_problem):
    samples = [[50 + x, y, z] for x, y, z in itertools.product((-5, 5), repeat=3)]
    body = {"samples": samples, "options": {"space": "Oklab"}}
    other = server.client.post("/v1/gamuts", json=body).json()["id"]
    body = {"gamuts": [*boxes.values(), other], "colours": COLOURS}
    problem = assert_problem(match(server, body), 422, "invalid-option")
    assert "CIELAB and Oklab" in problem["detail"]


def test_rows_without_colours(server, boxes):
    found = match(server, {"gamuts": list(boxes.values()), "colours": []}).json()
    assert found["gamuts"][0]["share"] is None
    assert json.dumps(found["gamuts"][0]["distance"]) == "[]"
