import pytest

ID = "0" * 64


@pytest.mark.parametrize(
    ("method", "path", "query", "field", "known"),
    [
        ("GET", f"/v1/gamuts/{ID}/mesh", "triangle=10", "triangle", ["triangles", "format"]),
        ("GET", f"/v1/gamuts/{ID}/mesh", "Triangles=10", "Triangles", ["triangles", "format"]),
        ("GET", f"/v1/gamuts/{ID}/mesh.ply", "triangles=4&x", "x", ["triangles", "format"]),
        ("GET", f"/v1/gamuts/{ID}/mesh", "triangles=4&triangles=8", "triangles", None),
        ("GET", f"/v1/gamuts/{ID}/mesh", "triangles=4&triangles=4", "triangles", None),
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


def test_known_parameters_in_any_order_are_taken(server, gamut):
    address = gamut["links"]["mesh"]
    first = server.client.get(f"{address}?format=ply&triangles=0010")
    second = server.client.get(f"{address}?triangles=10&format=ply")
    assert first.content == second.content
    assert first.headers["gamut-triangles"] == "10"
