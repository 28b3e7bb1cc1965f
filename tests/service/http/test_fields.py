"""Header fields: codings, entity tags, ranges, ids, preferences, names of files; and HEAD."""

import gzip
import hashlib
import itertools
import re
from email.message import Message

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from service.http.representations import zstd

DECODERS = {"gzip": gzip.decompress, "zstd": zstd.decompress, "identity": bytes}
MADE = re.compile(r"[0-9a-f]{32}\Z")


def raw(server, address, **headers):
    """An answer, and its content as it was sent."""
    with server.client.stream("GET", address, headers=headers) as answer:
        return answer, b"".join(answer.iter_raw())


# --- codings --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("field", "expected"),
    [
        ("", "identity"),
        ("gzip", "gzip"),
        ("zstd", "zstd"),
        ("GZIP", "gzip"),
        ("br", "identity"),
        ("gzip, deflate, br, zstd", "zstd"),
        ("gzip;q=1.0, zstd;q=0.9", "gzip"),
        ("gzip;q=0.5, zstd;q=0.5", "zstd"),
        ("*", "zstd"),
        ("*, zstd;q=0", "gzip"),
        ("*;q=0", "identity"),
        ("identity", "identity"),
        ("identity, gzip", "gzip"),
        ("identity, gzip;q=0.5", "identity"),
        ("identity;q=0.5, gzip;q=0.6", "gzip"),
        ("identity;q=0, br", "identity"),
        ("gzip;q=0", "identity"),
        ("gzip;q=nonsense", "gzip"),
    ],
)
def test_codings_are_negotiated_alike_for_meshes_and_documents(server, gamut, field, expected):
    for address in (gamut["links"]["mesh"], gamut["links"]["self"], "/openapi.json"):
        answer, body = raw(server, address, **{"Accept-Encoding": field})
        assert answer.headers.get("content-encoding", "identity") == expected
        assert DECODERS[expected](body)


@pytest.mark.parametrize("what", ["self", "mesh", "levels", "mesh.obj", "large", "viewer.html"])
def test_every_coding_is_a_representation_of_its_own(server, gamut, sphere, what):
    if what == "large":
        body = {"samples": sphere(seed=33, count=3000)}
        made = server.client.post("/v1/gamuts", json=body).json()
        assert made["counts"]["triangles"] > 4000
        address = f"{made['links']['mesh']}?triangles={made['counts']['triangles']}&format=ply"
    else:
        address = gamut["links"].get(what) or f"{gamut['links']['self']}/{what}"
    seen = {}
    for accepted, decode in DECODERS.items():
        answer, body = raw(server, address, **{"Accept-Encoding": accepted})
        assert answer.headers.get("content-encoding", "identity") == accepted
        assert answer.headers["etag"] == f'"{hashlib.sha256(body).hexdigest()}"'
        assert "Accept-Encoding" in answer.headers["vary"]
        assert int(answer.headers["content-length"]) == len(body)
        assert raw(server, address, **{"Accept-Encoding": accepted})[1] == body
        seen[answer.headers["etag"]] = (decode(body), len(body))
        known = {"Accept-Encoding": accepted, "If-None-Match": answer.headers["etag"]}
        again = server.client.get(address, headers=known)
        assert again.status_code == 304
        for name in ("etag", "vary"):
            assert again.headers[name] == answer.headers[name]
    assert len(seen) == 3
    assert len({content for content, _ in seen.values()}) == 1
    *coded, plain = [size for _, size in seen.values()]
    assert plain > max(coded)


def test_histories_and_short_documents_are_not_compressed(server, gamut):
    for address in (gamut["links"]["history"], "/v1/gamuts?name=nobody+has+this+name"):
        answer, _ = raw(server, address, **{"Accept-Encoding": "gzip, zstd"})
        assert "content-encoding" not in answer.headers


# --- conditional requests -------------------------------------------------------------------------


@pytest.mark.parametrize("link", ["self", "levels", "history", "mesh"])
def test_what_the_client_has_is_not_sent_again(server, gamut, link):
    address = gamut["links"][link]
    first = server.client.get(address)
    etag = first.headers["etag"]
    assert etag == f'"{hashlib.sha256(first.content).hexdigest()}"'
    for known in (etag, f"W/{etag}", f'"x", {etag}', "*"):
        same = server.client.get(address, headers={"If-None-Match": known})
        assert (same.status_code, same.content) == (304, b"")
        assert same.headers["etag"] == etag
    two = [("If-None-Match", '"x"'), ("If-None-Match", etag)]
    assert server.client.get(address, headers=two).status_code == 304
    for other in (f'{etag[:-2]}"', etag.strip('"'), '"other"', ""):
        answer = server.client.get(address, headers={"If-None-Match": other})
        assert (answer.status_code, answer.content) == (200, first.content)


@pytest.mark.parametrize("link", ["self", "levels", "history", "mesh"])
def test_only_the_content_that_is_named_is_sent(server, gamut, assert_problem, link):
    address = gamut["links"][link]
    etag = server.client.get(address).headers["etag"]
    for named in ([etag], [f'"x", {etag}'], ["*"], ['"x"', etag]):
        fields = [("If-Match", each) for each in named]
        for method in ("GET", "HEAD"):
            assert server.client.request(method, address, headers=fields).status_code == 200
    for named in ([f"W/{etag}"], ['"x"'], [etag.strip('"')], [""], ['"x"', '"y"']):
        fields = [("If-Match", each) for each in named]
        answer = server.client.get(address, headers=fields)
        assert_problem(answer, 412, "precondition-failed")
        assert server.client.head(address, headers=fields).status_code == 412


# --- ranges ---------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def whole(server, gamut):
    return server.client.get(gamut["links"]["history"])


@pytest.mark.parametrize(
    ("field", "part"),
    [
        ("bytes=0-0", slice(0, 1)),
        ("bytes=10-", slice(10, None)),
        ("bytes=10-19", slice(10, 20)),
        ("BYTES= 10-99999999", slice(10, None)),
        ("bytes=-10", slice(-10, None)),
        ("bytes=-99999999", slice(0, None)),
        ("", None),
        ("bytes=0-1,5-6", None),
        ("bytes=20-10", None),
        ("bytes=-", None),
        ("lines=0-1", None),
        ("bytes=a-b", None),
    ],
)
def test_one_range_is_honoured_and_others_are_ignored(server, gamut, whole, field, part):
    answer = server.client.get(gamut["links"]["history"], headers={"Range": field})
    size = len(whole.content)
    assert size == gamut["history_bytes"]
    if part is None:
        assert (answer.status_code, answer.content) == (200, whole.content)
    else:
        start, end, _ = part.indices(size)
        assert (answer.status_code, answer.content) == (206, whole.content[start:end])
        assert answer.headers["content-range"] == f"bytes {start}-{end - 1}/{size}"
    # RFC 9110, section 14.2: only GET has ranges
    head = server.client.head(gamut["links"]["history"], headers={"Range": field})
    assert (head.status_code, head.headers["content-length"]) == (200, str(size))
    assert "content-range" not in head.headers


def test_parts_of_a_history_make_up_the_whole(server, gamut, whole):
    assert whole.headers["accept-ranges"] == "bytes"
    parts = [
        server.client.get(
            gamut["links"]["history"], headers={"Range": f"bytes={start}-{start + 4999}"}
        ).content
        for start in range(0, len(whole.content), 5000)
    ]
    assert b"".join(parts) == whole.content
    two = [("Range", "bytes=0-1"), ("Range", "bytes=4-5")]
    assert server.client.get(gamut["links"]["history"], headers=two).content == whole.content


def test_a_range_behind_the_end_is_a_problem(server, gamut, whole, assert_problem):
    size = len(whole.content)
    for field in (f"bytes={size}-", f"bytes={size}-{size + 9}", "bytes=-0"):
        answer = server.client.get(gamut["links"]["history"], headers={"Range": field})
        assert_problem(answer, 416, "range-not-satisfiable")
        assert answer.headers["content-range"] == f"bytes */{size}"


def test_if_range_asks_for_the_part_of_the_same_content_only(server, gamut, whole):
    etag = whole.headers["etag"]
    for named, status in ((etag, 206), ('"other"', 200), (f"W/{etag}", 200)):
        fields = {"Range": "bytes=0-9", "If-Range": named}
        answer = server.client.get(gamut["links"]["history"], headers=fields)
        assert answer.status_code == status


# --- request ids ----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["abc", "4f1d:9c07/B2.a~8+e=_@-", "x" * 128])
@pytest.mark.parametrize(
    ("method", "path"),
    [
        ("GET", "/livez"),
        ("HEAD", "/livez"),
        ("GET", "/nowhere"),
        ("PUT", "/livez"),
        ("POST", "/v1/gamuts"),
        ("GET", "/v1/gamuts/%0a"),
    ],
)
def test_every_answer_has_the_id_of_its_client(server, name, method, path):
    answer = server.client.request(method, path, headers={"X-Request-Id": name})
    assert answer.headers.get_list("x-request-id") == [name]


@pytest.mark.parametrize("named", [[], [""], ["x" * 129], ['a"b'], ["a b"], ["a", "b"]])
def test_a_request_without_a_sane_id_gets_one(server, gamut, named):
    fields = [("X-Request-Id", each) for each in named]
    ids = set()
    for address in ("/livez", gamut["links"]["mesh"], gamut["links"]["mesh"]):
        (made,) = server.client.get(address, headers=fields).headers.get_list("x-request-id")
        assert MADE.match(made)
        ids.add(made)
    assert len(ids) == 3


# --- preferences ----------------------------------------------------------------------------------

SEEDS = itertools.count(5000)


@pytest.mark.parametrize(
    ("fields", "wait", "respond_async"),
    [
        ([], None, False),
        (["respond-async"], None, True),
        (["wait=120"], 120, False),
        (["Wait = 120"], 120, False),
        (['wait="120"'], 120, False),
        (["respond-async, wait=120"], 120, True),
        (["respond-async", "wait=120"], 120, True),
        (["return=minimal; foo=bar, wait=121;x=y"], 121, False),
        (["wait=120, wait=121"], 120, False),
        (['note="a, wait=121, b", wait=122'], 122, False),
        (['note="\\", wait=3"; x="y;z"'], None, False),
        (['note="never closed, wait=3'], None, False),
        (["wait=" + "9" * 5000], None, False),
        (["wait=1e9"], None, False),
        (["wait=-1"], None, False),
        (["wait=soon"], None, False),
        (["wait=1000"], None, False),
        (["wait=99999999999999999999"], None, False),
        (["wait=²"], None, False),
    ],
)
def test_only_preferences_that_are_honoured_are_confirmed(
    server, sphere, fields, wait, respond_async
):
    body = {"samples": sphere(seed=next(SEEDS), count=12)}
    headers = [(b"Prefer", field.encode("latin-1")) for field in fields]
    answer = server.client.post("/v1/gamuts", json=body, headers=headers)
    assert answer.status_code in {201, 202}
    applied = ["respond-async"] if respond_async and answer.status_code == 202 else []
    applied += [] if wait is None else [f"wait={wait}"]
    assert answer.headers.get("preference-applied", "") == ", ".join(applied)
    if answer.status_code == 202:
        assert int(answer.headers["retry-after"]) >= 0
        server.finished_job(answer.headers["location"])


# --- HEAD and paths -------------------------------------------------------------------------------


def test_head_is_get_without_the_content(server, gamut):
    links = gamut["links"].values()
    for address in (*links, "/", "/livez", "/v1/gamuts", "/v1/references", "/problems", "/docs"):
        head, get = server.client.head(address), server.client.get(address)
        assert head.status_code == get.status_code == 200
        assert head.content == b""
        changing = {"x-request-id", "server-timing", "date"}
        same = [
            {name: value for name, value in answer.headers.items() if name not in changing}
            for answer in (head, get)
        ]
        assert same[0] == same[1]
    answer = server.client.head("/v1/gamuts/srgb/contains")
    assert answer.status_code == 405
    assert answer.headers["allow"] == "POST"


@pytest.mark.parametrize("character", ["%0a", "%00", "%0d", "%1f", "%7f"])
def test_there_is_nothing_at_paths_with_control_characters(server, assert_problem, character):
    for path in ("/", "/livez", "/v1/gamuts", f"/v1/gamuts/{'0' * 64}/mesh", "/problems"):
        assert_problem(server.client.get(path + character), 404, "not-found")


# --- names of files -------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def disposition(server, sphere):
    """The name of a file of a gamut with this name."""
    body = {"samples": sphere(seed=793, count=40)}
    own = server.client.post("/v1/gamuts", json=body).json()["links"]["self"]

    def given_name(name):
        put = server.client.put(f"{own}/name", json={"name": name})
        if put.status_code == 422:
            return None
        assert put.status_code == 200
        answer = server.client.get(f"{own}/mesh.ply?triangles=20")
        return answer.headers["content-disposition"]

    return given_name


@pytest.mark.parametrize(
    ("name", "file"),
    [
        ("Coated FOGRA39L", 'inline; filename="Coated FOGRA39L-20.ply"'),
        ("a/b\\c: 300 %", 'inline; filename="a_b_c_ 300 _-20.ply"'),
        ("..hidden", 'inline; filename="hidden-20.ply"'),
        (
            "Größe 1",
            "inline; filename=\"Groe 1-20.ply\"; filename*=UTF-8''Gr%C3%B6%C3%9Fe%201-20.ply",
        ),
        ("印刷", "inline; filename=\"gamut-20.ply\"; filename*=UTF-8''%E5%8D%B0%E5%88%B7-20.ply"),
    ],
)
def test_files_are_called_as_their_gamuts(disposition, name, file):
    assert disposition(name) == file


@given(st.text(st.characters(codec="utf-8"), max_size=200))
@settings(max_examples=40)
def test_any_name_is_one_field_in_ascii_and_one_file(disposition, name):
    value = disposition(name)
    if value is None:
        return
    assert value.isascii()
    assert value.isprintable()
    assert value.count('"') == 2
    message = Message()  # decodes as RFC 2231 says
    message["Content-Disposition"] = value
    assert message.get_content_disposition() == "inline"
    assert message.get_filename().endswith("-20.ply")
    file = value.split('"')[1]
    assert not set("/\\:*?<>|%;") & set(file)
    assert file.endswith("-20.ply")
    assert len(file) < 200
