"""Whatever is sent, the answer is no 5xx, and an error is a problem document."""

import json
import re
from urllib.parse import quote

import httpx
import hypothesis
import pytest
from hypothesis import HealthCheck, given
from hypothesis import strategies as st

from gamutcore.errors import GamutError, MalformedFileError
from gamutcore.export import FORMATS
from service.application import create_app
from service.problems.kinds import KINDS
from service.problems.problem import Problem
from service.settings import Settings
from service.storage.blobs import StoreUnavailableError
from service.storage.gamut_store import GamutStore

MANY = hypothesis.settings(
    max_examples=80, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
FEWER = hypothesis.settings(MANY, max_examples=40)

BYTES = st.text(st.sampled_from([*map(chr, range(32, 127)), "ÿ", "\t"]), max_size=40).map(
    lambda text: text.encode("latin-1").strip()
)
"""Values of header fields, RFC 9110 clause 5.5; others never get past the server's parser."""

NUMBERS = st.integers() | st.floats() | st.sampled_from([0, 1, 50, -1e308, 1e308, 1e-320])

JSON = st.recursive(
    st.none() | st.booleans() | NUMBERS | st.text(max_size=8),
    lambda children: st.lists(children, max_size=5) | st.dictionaries(st.text(), children),
    max_leaves=12,
)

SAMPLES = st.lists(st.lists(NUMBERS, min_size=3, max_size=3), max_size=12)

NAMES = ["space", "boundary", "gamma", "centre", "cost", "surface_samples", "intent"]

OPTIONS = st.dictionaries(st.sampled_from(NAMES) | st.text(max_size=5), JSON, max_size=3)


@pytest.fixture(scope="module")
def send(server, assert_problem):
    """Send a request and check that the answer is one that a client can work with."""
    with httpx.Client(base_url=server.url, timeout=600) as client:

        def request(method, path, **arguments):
            answer = client.request(method, path, **arguments)
            assert answer.status_code < 500, answer.text
            if answer.status_code >= 400 and method != "HEAD":
                document = assert_problem(answer, answer.status_code, answer.json()["code"])
                # what exceptions say is told in sentences
                assert document["detail"][-1] in ".!?:"
                assert document["remedy"][-1] in ".?"
                assert document["remedy"] not in document["detail"]
                assert answer.content.isascii()
                assert answer.content.count(b"\n") == answer.content.endswith(b"}\n") == 1
            return answer

        yield request


@MANY
@given(
    method=st.sampled_from(["GET", "HEAD", "POST", "PUT", "DELETE", "OPTIONS", "PATCH", "TRACE"]),
    path=st.lists(
        st.sampled_from(["v1", "gamuts", "jobs", "mesh", "mesh.glb", "history", "0" * 64, ".."])
        | st.text(min_size=1, max_size=10),
        max_size=5,
    ),
    query=st.text(max_size=20),
)
def test_any_address(send, method, path, query):
    address = "/" + "/".join(quote(part, safe="") for part in path)
    send(method, f"{address}?{quote(query, safe='=&')}")


@MANY
@given(
    query=st.lists(
        st.tuples(
            st.sampled_from(["triangles", "format", "x"]),
            st.sampled_from(["4", "60", "99", "", *FORMATS]) | st.text(max_size=6),
        ),
        max_size=3,
    ),
    suffix=st.sampled_from(["", ".ply", ".obj"]) | st.text("abc.", max_size=3).map(".".__add__),
    fields=st.dictionaries(
        st.sampled_from([b"Accept", b"If-None-Match", b"Range", b"If-Range", b"Prefer"]), BYTES
    ),
)
def test_any_question_for_a_mesh(send, gamut, query, suffix, fields):
    answer = send("GET", gamut["links"]["mesh"] + suffix, params=query, headers=fields)
    assert answer.status_code in {200, 304, 404, 406, 422}


@MANY
@given(
    fields=st.dictionaries(
        st.sampled_from([b"Range", b"If-Range", b"If-None-Match"]),
        BYTES | st.sampled_from([b"bytes=0-5", b"bytes=-5", b"bytes=5-", b"*", b"bytes=0-1,3-4"]),
    )
)
def test_any_part_of_a_history(send, gamut, fields):
    answer = send("GET", gamut["links"]["history"], headers=fields)
    assert answer.status_code in {200, 206, 304, 416}


@FEWER
@given(samples=SAMPLES | JSON, columns=st.none() | JSON, options=OPTIONS | JSON)
def test_any_json(send, samples, columns, options):
    body = json.dumps({"samples": samples, "columns": columns, "options": options}).encode()
    headers = {"Content-Type": "application/json"}
    answer = send("POST", "/v1/gamuts", content=body, headers=headers)
    assert answer.status_code in {200, 201, 202, 400, 422}


@FEWER
@given(
    content=st.binary(max_size=200)
    | st.text("LAB_, 0123.\n\t", max_size=100).map(str.encode)
    | st.sampled_from([b"CGATS.17\n", b"\x93NUMPY\x01\x00", b"\0" * 36 + b"acsp" + b"\0" * 100]),
    options=st.binary(max_size=20) | OPTIONS.map(json.dumps).map(str.encode),
)
def test_any_file(send, content, options):
    files = [("file", ("f", content)), ("options", (None, options))]
    answer = send("POST", "/v1/gamuts", files=files)
    assert answer.status_code in {200, 201, 202, 400, 422}


@FEWER
@given(
    content=st.binary(max_size=100)
    | st.lists(
        st.sampled_from(
            [
                b"--x",
                b"--x--",
                b"\r\n",
                b"\r\n\r\n",
                b'Content-Disposition: form-data; name="file"; filename="f"',
                b'Content-Disposition: form-data; name="options"',
                b"Content-Disposition: form-data",
                b"Content-Type: application/json",
                b"{}",
            ]
        ),
        max_size=12,
    ).map(b"".join),
    kind=st.sampled_from(
        [b"multipart/form-data; boundary=x", b"multipart/form-data", b"application/json"]
    )
    | BYTES,
    prefer=BYTES,
)
def test_any_body(send, content, kind, prefer):
    headers = {b"Content-Type": kind, b"Prefer": prefer}
    send("POST", "/v1/gamuts", content=content, headers=headers)


@pytest.mark.parametrize(
    ("error", "status", "code"),
    [
        (RuntimeError("a secret of the service"), 500, "internal-error"),
        (OSError(22, "a secret of the disk"), 500, "internal-error"),
        (OSError(1, "a secret of the disk"), 503, "store-unavailable"),
        (OSError(5, "a secret of the disk"), 503, "store-unavailable"),
        (FileNotFoundError(2, "a secret of the disk"), 503, "store-unavailable"),
        (PermissionError(13, "a secret of the disk"), 503, "store-unavailable"),
        (StoreUnavailableError("a secret of the bucket"), 503, "store-unavailable"),
        (OSError(28, "No space left on device"), 507, "storage-full"),
        (OSError(24, "Too many open files"), 503, "overloaded"),
        (OSError(23, "Too many open files in system"), 503, "overloaded"),
    ],
)
def test_what_is_not_the_clients_fault_says_no_more_than_that(
    tmp_path, monkeypatch, request_app, assert_problem, error, status, code
):
    def fail(*_arguments):
        raise error

    monkeypatch.setattr(GamutStore, "record", fail)
    app = create_app(Settings(store=str(tmp_path)))
    answer = request_app(app, "GET", f"/v1/gamuts/{'0' * 64}")
    assert_problem(answer, status, code)
    # the server closes the connection after a defect, and the client has to know
    assert answer.headers.get("connection") == ("close" if status == 500 else None)
    assert "secret" not in answer.text
    assert ("retry-after" in answer.headers) == (status == 503)


SURROGATE = r"\ud800"
"""As JSON writes it; what is read from it has no UTF-8."""


@pytest.mark.parametrize(
    "body",
    [
        '{"samples": [[1, 2, 3]], "options": {"%s": 1}}',
        '{"samples": [[1, 2, 3]], "options": {"space": "%s"}}',
        '{"samples": [[1, 2, 3]], "columns": ["%s", "LAB_A", "LAB_B"]}',
        '{"samples": [{"%s": 1, "LAB_A": 2, "LAB_B": 3}]}',
        '{"samples": [["%s", 2, 3]]}',
        '{"samples": "%s"}',
    ],
)
def test_text_that_utf_8_cannot_express_is_refused_like_any_other(send, body):
    content = (body % SURROGATE).encode()
    headers = {"Content-Type": "application/json"}
    for _ in range(2):
        answer = send("POST", "/v1/gamuts", content=content, headers=headers)
        assert 400 <= answer.status_code < 500
    files = [("file", ("f", b"0,0,0")), ("options", (None, f'{{"{SURROGATE}": 1}}'))]
    assert send("POST", "/v1/gamuts", files=files).status_code == 422


def test_conditions_may_hold_what_utf_8_cannot_express(send, sphere):
    condition = json.dumps({"samples": sphere(seed=77), "conditions": {"NOTE": "\ud800"}})
    headers = {"Content-Type": "application/json"}
    first, again = (
        send("POST", "/v1/gamuts", content=condition, headers=headers) for _ in range(2)
    )
    assert (first.status_code, again.status_code) == (201, 200)
    assert "\\ud800" in first.text
    address = first.json()["links"]["self"]
    # the envelope `cge` needs device values, which bare colours do not have
    meshes = [f"{address}/mesh?format={name}" for name in FORMATS if name != "cge"]
    for path in (address, f"{address}/levels", *meshes, "/v1/gamuts"):
        assert send("GET", path).status_code == 200
    assert send("GET", address.replace("gamuts", "jobs")).json()["fraction"] == 1.0


def test_a_problem_of_a_job_is_that_of_the_request_and_outlives_its_worker():
    """Jobs keep problems as JSON; a newer worker may know other codes."""
    for code in ("missing-column", "overloaded"):
        problem = Problem(code, "d", {"line": 3}, "r")
        again = Problem.from_mapping(json.loads(json.dumps(problem.to_mapping())))
        assert again.document() == problem.document()
        assert ("Retry-After" in again.headers) == (again.kind.status == 503)
    unknown = Problem("from-a-newer-worker", "d").document()
    assert (unknown["code"], unknown["status"]) == (GamutError.code, 422)


def test_a_problem_states_the_remedy_once():
    """The text of an error has it as well, but the detail is the message alone."""
    error = MalformedFileError("line 3 is short", where={"line": 3}, remedy="Send all cells.")
    document = Problem.from_error(error).document()
    assert (document["detail"], document["remedy"]) == ("Line 3 is short.", "Send all cells.")


def test_every_kind_has_a_remedy_that_is_a_sentence():
    for kind in KINDS.values():
        assert re.fullmatch(r"(/docs |[A-Z]).*\.", kind.remedy), kind.code
