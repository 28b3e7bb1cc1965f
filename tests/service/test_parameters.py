import pytest

ID = "0" * 64

MESH = ["triangles", "max_error", "max_mismatch", "format"]


@pytest.mark.parametrize(
    ("method", "path", "query", "field", "known"),
    [
        ("GET", f"/v1/gamuts/{ID}/mesh", "triangle=10", "triangle", MESH),
        ("GET", f"/v1/gamuts/{ID}/mesh", "Triangles=10", "Triangles", MESH),
        ("GET", f"/v1/gamuts/{ID}/mesh.ply", "triangles=4&x", "x", MESH),
        ("GET", f"/v1/gamuts/{ID}/mesh", "triangles=4&triangles=8", "triangles", None),
        ("GET", f"/v1/gamuts/{ID}/mesh", "triangles=4&triangles=4", "triangles", None),
        ("GET", f"/v1/gamuts/{ID}/mesh", "max_error=1&max_error=2", "max_error", None),
        ("GET", f"/v1/gamuts/{ID}/mesh.obj", "format=ply&format=stl", "format", None),
        ("GET", "/v1/gamuts", "page=2", "page", ["limit", "after"]),
        ("GET", "/v1/gamuts", "limit=1&limit=2", "limit", None),
        ("POST", "/v1/gamuts", "gamma=1", "gamma", []),
        ("GET", f"/v1/gamuts/{ID}", "full=1", "full", []),
        ("DELETE", f"/v1/gamuts/{ID}", "force=1", "force", []),
        ("GET", f"/v1/gamuts/{ID}/levels", "limit=1", "limit", []),
        ("GET", f"/v1/gamuts/{ID}/history", "x=", "x", []),
        ("GET", f"/v1/jobs/{ID}", "wait=1", "wait", []),
    ],
)
def test_unknown_and_repeated_parameters_are_refused_and_named(
    server, assert_problem, method, path, query, field, known
):
    answer = server.client.request(method, f"{path}?{query}")
    where = assert_problem(answer, 422, "invalid-parameter")["where"]
    assert (where["in"], where["field"]) == ("query", field)
    if known is not None:
        assert where["known"] == known


@pytest.mark.parametrize("query", ["triangle=10", "triangles=4&triangles=8", "triangles=4&x=1"])
def test_a_mesh_at_hand_is_refused_no_less(server, gamut, assert_problem, query):
    address = gamut["links"]["mesh"]
    assert server.client.get(f"{address}?triangles=4").status_code == 200
    assert_problem(server.client.get(f"{address}?{query}"), 422, "invalid-parameter")


@pytest.mark.parametrize(
    "value",
    [
        "",
        " 10",
        "10 ",
        "+10",
        "-10",
        "1_0",
        "10.0",
        "1e1",
        "0x10",
        "\u0661\u0660",
        "9" * 13,
        "9" * 5000,
    ],
)
def test_numbers_are_plain_digits(server, gamut, assert_problem, value):
    for path, name in ((gamut["links"]["mesh"], "triangles"), ("/v1/gamuts", "limit")):
        answer = server.client.get(path, params={name: value})
        document = assert_problem(answer, 422, "invalid-parameter")
        assert document["where"] == {"in": "query", "field": name}


@pytest.mark.parametrize(
    "value",
    [
        "",
        " 1",
        "+1",
        "-1",
        "-0",
        "1_0",
        ".5",
        "5.",
        "1e",
        "1e+2",
        "1e999",
        "nan",
        "inf",
        "0x1",
        "1,5",
        "\u0661",
        "9" * 13,
        "0." + "9" * 21,
        "9" * 5000,
    ],
)
def test_limits_are_plain_decimals(server, gamut, assert_problem, value):
    for name in ("max_error", "max_mismatch"):
        answer = server.client.get(gamut["links"]["mesh"], params={name: value})
        document = assert_problem(answer, 422, "invalid-parameter")
        assert document["where"] == {"in": "query", "field": name}


@pytest.mark.parametrize("value", ["0", "0.0", "1", "00.5", "1e-4", "1E2", repr(1 / 3), "9" * 12])
def test_decimals_of_the_usual_forms_are_taken(server, gamut, value):
    for name in ("max_error", "max_mismatch"):
        answer = server.client.get(gamut["links"]["mesh"], params={name: value})
        assert answer.status_code == 200


def test_known_parameters_in_any_order_are_taken(server, gamut):
    address = gamut["links"]["mesh"]
    first = server.client.get(f"{address}?format=ply&triangles=0010")
    second = server.client.get(f"{address}?triangles=10&format=ply")
    assert first.content == second.content
    assert first.headers["gamut-triangles"] == "10"
