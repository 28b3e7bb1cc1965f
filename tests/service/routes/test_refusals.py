"""Posts that are refused, each with its problem."""

import json

import httpx
import pytest


@pytest.mark.parametrize(
    ("content", "code", "where"),
    [
        (b"LAB_L,LAB_A,LAB_X\n1,2,3\n", "missing-column", "field"),
        (b"\x00\x01\x02 no format at all", "unrecognised-format", None),
        (b"", "unrecognised-format", None),
        (
            b"CTI1\nBEGIN_DATA_FORMAT\nXYZ_X XYZ_Y XYZ_Z\nEND_DATA_FORMAT\n",
            "unrecognised-format",
            "line",
        ),
        (b"LAB_L,LAB_A,LAB_B\n1,2,three\n", "malformed-file", "line"),
        (b"LAB_L,LAB_A,LAB_B\n1,2,3\n4,5,6\n", "too-few-points", None),
    ],
)
def test_files_that_cannot_be_used_are_explained(server, assert_problem, content, code, where):
    answer = server.client.post("/v1/gamuts", files={"file": content})
    document = assert_problem(answer, 422, code)
    assert where is None or where in document["where"]


@pytest.mark.parametrize(
    ("options", "field"),
    [
        ({"gama": 0.2}, "gama"),
        ({"gamma": 2}, "gamma"),
        ({"space": "CMYK"}, "space"),
        ({"centre": [1, 2]}, "centre"),
        ({"surface_samples": 10**9}, "surface_samples"),
        ({"segments": [16, 16]}, "segments"),
        ({"boundary": "segment-maxima", "gamma": 0.2}, "gamma"),
        ({"boundary": "usv", "basis": "cube"}, "basis"),
        ([], "options"),
        ("gamma", "options"),
        (None, "options"),
    ],
)
def test_options_that_are_not_accepted_are_named(server, assert_problem, options, field):
    inline = server.client.post("/v1/gamuts", json={"samples": [[0, 0, 0]], "options": options})
    assert assert_problem(inline, 422, "invalid-option")["where"]["field"] == field
    part = server.client.post(
        "/v1/gamuts", files={"file": b"x"}, data={"options": json.dumps(options)}
    )
    assert assert_problem(part, 422, "invalid-option")["where"]["field"] == field


PLANE = [[i, i, i, i / 3, i % 7, i % 5] for i in range(256)]
BARE = ("L a b", [row[3:] for row in PLANE])


@pytest.mark.parametrize(
    ("data", "options", "said"),
    [
        (BARE, {"device_model": "fit"}, "without device values"),
        (BARE, {"popularity": 0.1}, ""),
        (BARE, {"observer": 10}, "the data has no spectra"),
        (BARE, {"ink_limit": 300}, None),
        (BARE, {"source": "measurements"}, None),
        (BARE, {"luminance": "measured", "space": "ICtCp"}, None),
        (BARE, {"luminance": 1e5, "space": "ICtCp"}, None),
        (BARE, {"background": 20, "space": "Oklab"}, None),
        (BARE, {"reference_white": [0, 1, 1], "space": "CIEXYZ"}, None),
    ],
)
def test_options_that_the_data_or_the_space_has_no_place_for_say_why(
    server, assert_problem, data, options, said
):
    columns, rows = data
    body = {"columns": columns.split(), "samples": rows, "options": options}
    document = assert_problem(server.client.post("/v1/gamuts", json=body), 422, "invalid-option")
    name = next(iter(options))
    assert document["where"] == {"field": name}
    if said is not None:
        assert document["detail"].startswith(f"{name} {options[name]!r} does not apply: ")
        assert said in document["detail"]
        assert document["remedy"].startswith("Leave it out")


@pytest.mark.parametrize(
    ("body", "status", "code"),
    [
        (b"", 400, "malformed-body"),
        (b"{", 400, "malformed-body"),
        (b"\xff\xfe", 400, "malformed-body"),
        (b'{"samples": [[NaN, 0, 0]]}', 400, "malformed-body"),
        (b'{"samples": [[1e999, 0, 0]]}', 400, "malformed-body"),
        (b"[" * 100_000, 400, "malformed-body"),
        (b'{"samples": [[' + b"9" * 10_000 + b", 0, 0]]}", 400, "malformed-body"),
        (b"[[0, 0, 0]]", 422, "invalid-body"),
        (b"7", 422, "invalid-body"),
        (b"{}", 422, "invalid-body"),
        (b'{"samples": []}', 422, "too-few-points"),
        (b'{"samples": 7}', 422, "malformed-file"),
        (b'{"samples": [[0, 0, "a"]]}', 422, "malformed-file"),
        (b'{"samples": [[0, 0, 0]], "gamma": 1}', 422, "invalid-body"),
        (b'{"samples": [[0, 0, 0]], "columns": ["R", "G", "B"]}', 422, "missing-column"),
        (b'{"samples": [[0, 0, 0]], "\\ud800": 1}', 422, None),
    ],
)
def test_json_that_cannot_be_used_is_explained(server, assert_problem, body, status, code):
    answer = server.client.post(
        "/v1/gamuts", content=body, headers={"Content-Type": "application/json"}
    )
    assert_problem(answer, status, code or answer.json()["code"])


def test_a_syntax_error_has_its_place(server, assert_problem):
    answer = server.client.post(
        "/v1/gamuts",
        content=b'{"samples":\n [[0,,0]]}',
        headers={"Content-Type": "application/json"},
    )
    where = assert_problem(answer, 400, "malformed-body")["where"]
    assert where == {"line": 2, "column": 6}
    part = server.client.post("/v1/gamuts", files={"file": b"x"}, data={"options": "{gamma}"})
    where = assert_problem(part, 400, "malformed-body")["where"]
    assert where == {"field": "options", "line": 1, "column": 2}


@pytest.mark.parametrize(
    ("parts", "field"),
    [
        ([("options", (None, b"{}"))], "file"),
        ([("data", ("a", b"x"))], "data"),
        ([("file", ("a", b"x")), ("file", ("b", b"y"))], "file"),
        ([("file", ("a", b"x")), ("gamma", ("b", b"1"))], "gamma"),
    ],
)
def test_parts_that_are_missing_or_too_many_are_named(server, assert_problem, parts, field):
    answer = server.client.post("/v1/gamuts", files=parts)
    assert assert_problem(answer, 422, "invalid-body")["where"] == {"field": field}


@pytest.mark.parametrize(
    "body",
    [b"", b"no boundary here", b"--x\r\n\r\n", b"--x\r\nContent-Disposition: y\r\n\r\n--x--"],
)
@pytest.mark.parametrize("kind", ["multipart/form-data", "multipart/form-data; boundary=x"])
def test_multipart_that_cannot_be_parsed_is_a_problem(server, assert_problem, body, kind):
    answer = server.client.post("/v1/gamuts", content=body, headers={"Content-Type": kind})
    assert answer.status_code in {400, 422}
    assert_problem(answer, answer.status_code, answer.json()["code"])


@pytest.mark.parametrize(
    "kind", ["text/plain", "application/x-www-form-urlencoded", "", "nonsense"]
)
def test_other_media_types_are_refused_with_the_accepted_ones(server, assert_problem, kind):
    answer = server.client.post("/v1/gamuts", content=b"x", headers={"Content-Type": kind})
    document = assert_problem(answer, 415, "unsupported-media-type")
    assert "multipart/form-data" in document["remedy"]
    assert "application/json" in document["remedy"]


@pytest.mark.parametrize("form", ["declared", "chunked", "multipart", "chunked multipart"])
def test_bodies_over_the_limit_are_refused(server, assert_problem, form):
    size = 2_000_001
    head = b'--x\r\nContent-Disposition: form-data; name="file"; filename="a"\r\n\r\n'

    def chunks():
        yield head if "multipart" in form else b""
        for _ in range(size // 1000 + 1):
            yield bytes(1000)

    kind = "multipart/form-data; boundary=x" if "multipart" in form else "application/json"
    content = chunks() if "chunked" in form else b"".join(chunks())
    with httpx.Client(base_url=server.url, timeout=600) as client:
        answer = client.post("/v1/gamuts", content=content, headers={"Content-Type": kind})
    # A stated length is compared with the limit of all bodies first.
    limit = 2**20 if form == "chunked" else 2_000_000
    assert assert_problem(answer, 413, "body-too-large")["where"] == {"limit": limit}


def test_methods_that_are_not_allowed_come_with_those_that_are(server, assert_problem, gamut):
    answer = server.client.put("/v1/gamuts")
    assert_problem(answer, 405, "method-not-allowed")
    assert answer.headers["allow"] == "GET, HEAD, POST"
    answer = server.client.post(gamut["links"]["self"])
    assert answer.headers["allow"] == "DELETE, GET, HEAD"


@pytest.mark.parametrize(
    ("wrong", "code", "field"),
    [
        ({"white": "D50"}, "malformed-file", "white"),
        ({"white": [96.4, 100]}, "malformed-file", "white"),
        ({"columns": ["L", "a"]}, "missing-column", "columns"),
        ({"conditions": []}, "malformed-file", "conditions"),
        ({"samples": [[1, 2, "x"]]}, "malformed-file", None),
        ({"samples": 5}, "malformed-file", "samples"),
    ],
)
def test_who_does_not_wait_is_told_of_wrong_samples_as_well(
    server, assert_problem, sphere, wrong, code, field
):
    body = {"samples": sphere(count=20), **wrong}
    answers = [
        server.client.post("/v1/gamuts", json=body, headers={"Prefer": prefer})
        for prefer in ("respond-async", "wait=60")
    ]
    for answer in answers:
        problem = assert_problem(answer, 422, code)
        assert field is None or problem["where"]["field"] == field
    assert answers[0].json() == answers[1].json()
