"""Parameters of queries and paths: names, numbers, ids."""

import pytest

from service.application import create_app
from service.settings import Settings

ID = "0" * 64
MESH = ["triangles", "max_error", "max_mismatch", "side", "format"]


@pytest.mark.parametrize(
    ("method", "path", "query", "field", "known"),
    [
        ("GET", f"/v1/gamuts/{ID}/mesh", "triangle=10", "triangle", MESH),
        ("GET", f"/v1/gamuts/{ID}/mesh", "Triangles=10", "Triangles", MESH),
        ("GET", f"/v1/gamuts/{ID}/mesh.ply", "triangles=4&x", "x", MESH),
        ("GET", f"/v1/gamuts/{ID}/mesh", "triangles=4&triangles=4", "triangles", None),
        ("GET", f"/v1/gamuts/{ID}/mesh", "max_error=1&max_error=2", "max_error", None),
        ("GET", f"/v1/gamuts/{ID}/mesh.obj", "format=ply&format=stl", "format", None),
        ("GET", "/v1/gamuts", "page=2", "page", ["limit", "after", "name", "match"]),
        ("GET", "/v1/gamuts", "limit=1&limit=2", "limit", None),
        ("POST", "/v1/gamuts", "gamma=1", "gamma", []),
        ("GET", f"/v1/gamuts/{ID}", "full=1", "full", []),
        ("DELETE", f"/v1/gamuts/{ID}", "force=1", "force", []),
        ("GET", f"/v1/gamuts/{ID}/levels", "limit=1", "limit", ["side"]),
        ("GET", f"/v1/gamuts/{ID}/history", "x=", "x", []),
        ("GET", f"/v1/gamuts/{ID}/viewer.html", "triangles=5", "triangles", ["with"]),
        ("GET", f"/v1/jobs/{ID}", "wait=1", "wait", []),
        ("GET", "/v1/jobs", "state=queued", "state", ["limit", "after"]),
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


OF_SLUGS = ["", "/mesh", "/mesh.ply", "/levels", "/history", "/viewer.html", "/cusps", "/leaves"]
OF_SLUGS += ["/slice", "/rings", "/picture.png"]


@pytest.fixture(scope="module")
def refused(tmp_path_factory, request_app, assert_problem):
    """Send a request that is refused before anything is read or built."""
    app = create_app(Settings(store=str(tmp_path_factory.mktemp("store"))))
    return lambda path, method="GET": assert_problem(
        request_app(app, method, path), 422, "invalid-parameter"
    )


@pytest.mark.parametrize(
    "path",
    [
        *(f"/v1/gamuts/srgb{below}?" for below in OF_SLUGS),
        "/v1/gamuts/srgb/mesh?triangles=100&",
        f"/v1/gamuts/{ID}/viewer.html?with=srgb&",
        f"/v1/gamuts/{ID}/rings?reference=srgb&",
        f"/v1/comparisons?a={ID}&b=srgb&",
        f"/v1/links?source=srgb&destination={ID}&",
    ],
)
def test_the_remedy_of_a_query_of_a_slug_names_the_options_of_the_build(refused, path):
    problem = refused(f"{path}scale=2")
    assert (problem["where"]["in"], problem["where"]["field"]) == ("query", "scale")
    known = problem["where"]["known"]
    assert {"space", "gamma", "surface_samples", "reference_white"} <= set(known)
    assert not {"scale", "ink_limit", "observer"} & set(known)  # no options of references
    assert known.count("background") == 1
    assert ", space, " in problem["remedy"] or ": space, " in problem["remedy"]


def test_options_of_a_misspelled_slug_are_not_what_is_refused(refused):
    problem = refused("/v1/gamuts/srbg?gamma=1")
    assert problem["where"] == {"in": "path", "field": "gamut_id"}
    assert "Did you mean srgb?" in problem["remedy"]


@pytest.mark.parametrize("path", [f"/v1/gamuts/{ID}", f"/v1/gamuts/{ID}/mesh", "/v1/gamuts"])
def test_options_need_a_slug(refused, path):
    problem = refused(f"{path}?gamma=1")
    assert problem["where"]["field"] == "gamma"
    assert "space" not in problem["remedy"]


@pytest.mark.parametrize(("path", "name"), [("/v1/comparisons", "b"), ("/v1/links", "source")])
def test_a_missing_parameter_is_named(refused, path, name):
    others = {"a", "b"} if path == "/v1/comparisons" else {"source", "destination"}
    query = "&".join(f"{other}={ID}" for other in sorted(others - {name}))
    problem = refused(f"{path}?{query}")
    assert problem["where"] == {"in": "query", "field": name}
    assert name in problem["detail"]
    assert name in problem["remedy"]


@pytest.mark.parametrize(
    ("path", "name", "text"),
    [
        ("gamuts/{id}/slice", "plane", "0,1,0"),
        ("gamuts/{id}/slice", "plane", "red"),
        ("gamuts/{id}/picture.png", "view", "1,2,3"),
        ("gamuts/{id}/picture.png", "view", "topp"),
        ("links?source={id}&destination={id}", "focus", "1,2"),
    ],
)
def test_arrays_are_refused_as_other_values_are(refused, path, name, text):
    address = f"/v1/{path.format(id=ID)}"
    problem = refused(f"{address}{'&' if '?' in address else '?'}{name}={text}")
    assert problem["where"] == {"in": "query", "field": name}
    assert "Give " in problem["remedy"]
    assert ("Did you mean 'top'?" in problem["remedy"]) == (text == "topp")


FAULTY_BOTH = ["", " 1", "+1", "-1", "1_0", "0x10", "nan", "many", "\x00", "\u0661", "9" * 13]
FAULTY_NUMBERS = [*FAULTY_BOTH, "10 ", "10.0", "1e1", "9" * 5000]
FAULTY_DECIMALS = [*FAULTY_BOTH, "-0", ".5", "5.", "1e", "1e+2", "1e999", "inf", "1,5"]
FAULTY_DECIMALS += ["0." + "9" * 21, "9" * 5000]


def test_numbers_and_limits_are_plain(server, gamut, assert_problem):
    mesh = gamut["links"]["mesh"]
    whole, decimal = "whole number", "plain decimal number"
    cases = [(mesh, "triangles", value, whole, "such as") for value in FAULTY_NUMBERS]
    cases += [("/v1/gamuts", "limit", value, whole, "such as") for value in FAULTY_NUMBERS]
    for name in ("max_error", "max_mismatch"):
        cases += [(mesh, name, value, decimal, "0.5 or 1e-4") for value in FAULTY_DECIMALS]
    for path, name, value, kind, remedy in cases:
        answer = server.client.get(path, params={name: value})
        document = assert_problem(answer, 422, "invalid-parameter")
        assert document["where"] == {"in": "query", "field": name}
        assert document["detail"].startswith(f"{value[:40]!r} is not a {kind}")
        assert remedy in document["remedy"]


def test_decimals_of_the_usual_forms_are_taken(server, gamut):
    for value in ("0", "0.0", "1", "00.5", "1e-4", "1E2", repr(1 / 3), "9" * 12):
        for name in ("max_error", "max_mismatch"):
            answer = server.client.get(gamut["links"]["mesh"], params={name: value})
            assert answer.status_code == 200, (name, value)


@pytest.mark.parametrize(
    ("path", "place", "field", "shown"),
    [
        ("/v1/gamuts/zzz", "path", "gamut_id", "zzz"),
        (f"/v1/gamuts/{ID[1:]}/mesh", "path", "gamut_id", ID[:40]),
        (f"/v1/gamuts/{ID}0/mesh.ply", "path", "gamut_id", ID[:40]),
        (f"/v1/gamuts/{'A' * 64}/levels", "path", "gamut_id", "A" * 40),
        ("/v1/gamuts/é/history", "path", "gamut_id", "é"),
        ("/v1/gamuts/{id}%7D", "path", "gamut_id", "{id}}"),
        ("/v1/jobs/x", "path", "job_id", "x"),
        (f"/v1/jobs/{'A' * 64}", "path", "job_id", "A" * 40),
        ("/v1/gamuts?after=zzz", "query", "after", "zzz"),
        ("/v1/gamuts?after=%00", "query", "after", "\x00"),
        ("/v1/jobs?after=0", "query", "after", "0"),
        ("/v1/gamuts?limit=0", "query", "limit", "0"),
        ("/v1/jobs?limit=000", "query", "limit", "000"),
        ("/v1/jobs?limit=x", "query", "limit", "x"),
        (f"/v1/gamuts/{ID}/viewer.html?with=abc", "query", "with", "abc"),
        (f"/v1/gamuts/{ID}/viewer.html?with={ID},", "query", "with", ID[:40]),
    ],
)
def test_what_is_no_id_or_no_count_is_shown_with_what_would_be_right(
    server, assert_problem, path, place, field, shown
):
    document = assert_problem(server.client.get(path), 422, "invalid-parameter")
    assert document["where"] == {"in": place, "field": field}
    assert document["detail"].startswith(f"{shown!r} is not a")
    assert "Give " in document["remedy"]


def test_a_path_out_of_the_gamuts_leads_nowhere(server, assert_problem):
    for below in ("", "/levels", "/history", "/mesh", "/mesh.ply"):
        answer = server.client.get(f"/v1/gamuts/..%2f..{below}")
        assert_problem(answer, 404, "not-found")
