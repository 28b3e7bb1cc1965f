import hashlib
import io
import json
import zipfile

import pytest

BATCH = "/v1/meshes"


@pytest.fixture(scope="module")
def other(server, sphere):
    return server.client.post("/v1/gamuts", json={"samples": sphere(seed=41)}).json()


def archive_of(answer):
    assert answer.status_code == 200, answer.text
    assert answer.headers["content-type"] == "application/zip"
    archive = zipfile.ZipFile(io.BytesIO(answer.content))
    assert archive.testzip() is None
    return archive


def test_several_levels_of_several_gamuts_are_what_they_are_alone(server, gamut, other):
    query = f"gamuts={gamut['id']},{other['id']}&triangles=10,100&max_error=1&format=ply"
    answer = server.client.get(f"{BATCH}?{query}")
    archive = archive_of(answer)
    index = json.loads(archive.read("index.json"))["meshes"]
    assert len(index) == 6
    for entry in index:
        name = "max_error" if "max_error" in entry else "triangles"
        address = f"/v1/gamuts/{entry['gamut']}/mesh.ply?{name}={entry[name]}"
        alone = server.client.get(address)
        assert archive.read(entry["file"]) == alone.content
        assert f'"{entry["sha256"]}"' == alone.headers["etag"]
    assert answer.headers["gamut-failures"] == "0"


@pytest.mark.parametrize("side", ["inside", "outside"])
def test_a_side_applies_to_all_levels(server, assert_problem, gamut, other, side):
    query = f"gamuts={gamut['id']},{other['id']}&triangles=10,100&max_error=1&format=ply"
    answer = server.client.get(f"{BATCH}?{query}&side={side}")
    archive = archive_of(answer)
    index = json.loads(archive.read("index.json"))["meshes"]
    assert len(index) == 6
    for entry in index:
        assert entry["side"] == side
        name = "max_error" if "max_error" in entry else "triangles"
        address = f"/v1/gamuts/{entry['gamut']}/mesh.ply?{name}={entry[name]}&side={side}"
        assert archive.read(entry["file"]) == server.client.get(address).content
    both = server.client.get(f"{BATCH}?{query}&side=both")
    assert both.content == server.client.get(f"{BATCH}?{query}").content
    assert both.headers["etag"] != answer.headers["etag"]
    accept = {"Accept": "multipart/mixed"}
    message = server.client.get(f"{BATCH}?{query}&side={side}", headers=accept).content
    assert message.count(f"&side={side}".encode()) == 6
    refused = server.client.get(f"{BATCH}?{query}&side=left")
    document = assert_problem(refused, 422, "invalid-parameter")
    assert document["where"] == {"in": "query", "field": "side"}


def test_what_is_promised_of_limits_is_in_the_index_and_the_parts(server, gamut):
    query = f"gamuts={gamut['id']}&max_error=0.9,9&max_mismatch=0.03"
    answers = [server.client.get(f"{BATCH}?{query}") for _ in range(2)]
    assert answers[0].headers["etag"] == answers[1].headers["etag"]
    index = json.loads(archive_of(answers[0]).read("index.json"))["meshes"]
    message = server.client.get(f"{BATCH}?{query}", headers={"Accept": "multipart/mixed"}).content
    for entry in index:
        name = "max_error" if "max_error" in entry else "max_mismatch"
        assert entry["promises"][name] <= entry[name]
        alone = server.client.get(f"{gamut['links']['mesh']}?{name}={entry[name]}")
        field = f"Gamut-Max-{name.removeprefix('max_').title()}"
        assert float(alone.headers[field]) == entry["promises"][name]
        assert f"{field}: {alone.headers[field]}\r\n".encode() in message


def test_an_answer_never_changes_and_has_its_digest(server, gamut):
    address = f"{BATCH}?gamuts={gamut['id']}&triangles=10,100"
    first, second = server.client.get(address), server.client.get(address)
    assert first.content == second.content
    etag = first.headers["etag"]
    assert etag == f'"{hashlib.sha256(first.content).hexdigest()}"'
    assert first.headers["cache-control"] == "public, max-age=31536000, immutable"
    assert first.headers["vary"] == "Accept"
    same = server.client.get(address, headers={"If-None-Match": etag})
    assert (same.status_code, same.content, same.headers["etag"]) == (304, b"", etag)
    head = server.client.head(address)
    assert head.headers["etag"] == etag


def test_only_the_answer_that_is_named_is_sent(server, gamut, assert_problem):
    address = f"/v1/meshes?gamuts={gamut['id']}&triangles=20"
    etag = server.client.get(address).headers["etag"]
    assert server.client.get(address, headers={"If-Match": etag}).status_code == 200
    answer = server.client.get(address, headers={"If-Match": f"W/{etag}"})
    assert_problem(answer, 412, "precondition-failed")


def test_a_multipart_message_is_an_answer_as_well(server, gamut):
    answer = server.client.get(
        f"{BATCH}?gamuts={gamut['id']}&triangles=10,2", headers={"Accept": "multipart/mixed"}
    )
    assert answer.headers["content-type"].startswith("multipart/mixed; boundary=")
    boundary = answer.headers["content-type"].partition("boundary=")[2].encode()
    first, second = answer.content.split(b"--" + boundary)[1:-1]
    alone = server.client.get(f"{gamut['links']['mesh']}?triangles=10")
    assert first.partition(b"\r\n\r\n")[2] == alone.content + b"\r\n"
    assert json.loads(second.partition(b"\r\n\r\n")[2])["code"] == "triangle-count"


def test_what_cannot_be_had_is_reported_in_its_place(server, gamut):
    missing = "0" * 64
    answer = server.client.get(f"{BATCH}?gamuts={missing},{gamut['id']}&triangles=3,10")
    index = json.loads(archive_of(answer).read("index.json"))["meshes"]
    codes = [entry.get("problem", {}).get("code") for entry in index]
    assert codes == ["gamut-not-found", "gamut-not-found", "triangle-count", None]
    assert answer.headers["gamut-failures"] == "3"
    assert answer.headers["cache-control"] == "no-store"


def test_nothing_at_all_is_a_problem(server, gamut, assert_problem):
    answer = server.client.get(f"{BATCH}?gamuts={'0' * 64}&triangles=10")
    assert_problem(answer, 404, "gamut-not-found")
    answer = server.client.get(f"{BATCH}?gamuts={gamut['id']}&triangles=2,{10**9 - 1}")
    assert_problem(answer, 422, "triangle-count")


@pytest.mark.parametrize(
    ("query", "field"),
    [
        ("triangles=10", "gamuts"),
        ("gamuts=abc&triangles=10", "gamuts"),
        ("gamuts={id},&triangles=10", "gamuts"),
        ("gamuts={id}", "triangles"),
        ("gamuts={id}&triangles=", "triangles"),
        ("gamuts={id}&triangles=10,", "triangles"),
        ("gamuts={id}&triangles=1e3", "triangles"),
        ("gamuts={id}&max_error=nan", "max_error"),
        ("gamuts={id}&max_mismatch=-1", "max_mismatch"),
        ("gamuts={id}&triangles=10&format=vrml", "format"),
        ("gamuts={id}&triangles=10&other=1", "other"),
        ("gamuts={id}&triangles=" + ",".join(map(str, range(4, 105))), "gamuts"),
    ],
)
def test_what_is_no_question_is_refused(server, gamut, assert_problem, query, field):
    answer = server.client.get(f"{BATCH}?{query.replace('{id}', gamut['id'])}")
    document = assert_problem(answer, 422, "invalid-parameter")
    assert document["where"]["field"] == field


def test_nothing_else_is_sent(server, gamut, assert_problem):
    answer = server.client.get(
        f"{BATCH}?gamuts={gamut['id']}&triangles=10", headers={"Accept": "text/html"}
    )
    assert_problem(answer, 406, "not-acceptable")


def test_equal_values_are_one_mesh(server, gamut):
    query = f"gamuts={gamut['id']}&triangles=10,010,11&max_error=0.5,0.50,5e-1,1&max_mismatch=1"
    index = json.loads(archive_of(server.client.get(f"{BATCH}?{query}")).read("index.json"))
    assert [entry.get("triangles") for entry in index["meshes"]] == [10, 11, None, None, None]
    assert [entry.get("max_error") for entry in index["meshes"]] == [None, None, 0.5, 1.0, None]


@pytest.fixture(scope="module")
def large(server, slow_build):
    """A gamut of which the shared server sends eleven full boundaries at once, not thirty."""
    made = server.client.post("/v1/gamuts", **slow_build(60_000)).json()
    assert 1_000_000 / 30 < made["counts"]["triangles"] < 1_000_000 / 11
    return made


def test_limits_count_as_the_levels_that_keep_them(server, large):
    limits = ",".join(f"{0.5 + 0.01 * place:.2f}" for place in range(30))
    answer = server.client.get(f"{BATCH}?gamuts={large['id']}&max_error={limits}&format=stl")
    index = json.loads(archive_of(answer).read("index.json"))["meshes"]
    assert len(index) == 30
    assert sum(entry["counts"]["triangles"] for entry in index) < 30_000


@pytest.mark.parametrize("name", ["triangles", "max_mismatch"])
def test_more_triangles_than_are_sent_at_once_are_refused(server, large, assert_problem, name):
    largest = large["counts"]["triangles"]
    values = {
        "triangles": [str(largest - 2 * place) for place in range(30)],
        "max_mismatch": [f"1e-{10 + place}" for place in range(30)],
    }
    query = f"gamuts={large['id']}&{name}={','.join(values[name])}"
    document = assert_problem(server.client.get(f"{BATCH}?{query}"), 422, "invalid-parameter")
    total = 30 * largest - (870 if name == "triangles" else 0)
    assert document["detail"] == f"The meshes may have up to {total} triangles together."
    assert "1000000" in document["remedy"]


def test_large_answers_are_streamed(server, large):
    counts = ",".join(str(large["counts"]["triangles"] - 2 * number) for number in range(5))
    answer = server.client.get(f"{BATCH}?gamuts={large['id']}&triangles={counts}")
    assert "etag" not in answer.headers
    assert answer.headers["transfer-encoding"] == "chunked"
    archive = archive_of(answer)
    assert len(answer.content) > 8 << 20
    assert len(archive.namelist()) == 6
