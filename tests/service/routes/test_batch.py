"""Several meshes in one answer: what it contains, its containers, its limits."""

import email.policy
import hashlib
import io
import json
import zipfile
from email.parser import BytesParser

import pytest


@pytest.fixture(scope="module")
def other(server, sphere):
    return server.client.post("/v1/gamuts", json={"samples": sphere(seed=41)}).json()


@pytest.fixture(scope="module")
def large(server, slow_build):
    """A gamut of which the shared server sends eleven full boundaries at once, not thirty."""
    made = server.client.post("/v1/gamuts", **slow_build(60_000)).json()
    assert 1_000_000 / 30 < made["counts"]["triangles"] < 1_000_000 / 11
    return made


@pytest.fixture(scope="module")
def batch(server):
    """Ask for several meshes."""

    def ask(query, accept="application/zip", **headers):
        return server.client.get(f"/v1/meshes?{query}", headers={"Accept": accept, **headers})

    return ask


def unpacked(answer):
    """The archive of an answer, and the entries of its index."""
    assert answer.status_code == 200, answer.text
    assert answer.headers["content-type"] == "application/zip"
    archive = zipfile.ZipFile(io.BytesIO(answer.content))
    assert archive.testzip() is None
    return archive, json.loads(archive.read("index.json"))["meshes"]


def parts_of(answer):
    """The parts of a multipart message, as a mail program reads them."""
    head = f"Content-Type: {answer.headers['content-type']}\r\nMIME-Version: 1.0\r\n\r\n"
    message = BytesParser(policy=email.policy.HTTP).parsebytes(head.encode() + answer.content)
    assert not message.defects
    return list(message.iter_parts())


@pytest.mark.parametrize("side", ["both", "inside", "outside"])
def test_several_levels_of_several_gamuts_are_what_they_are_alone(
    server, batch, gamut, other, side
):
    query = f"gamuts={gamut['id']},{other['id']}&triangles=10,100&max_error=1&format=ply"
    query += "" if side == "both" else f"&side={side}"
    answer = batch(query)
    assert answer.headers["gamut-failures"] == "0"
    archive, index = unpacked(answer)
    parts = parts_of(batch(query, "multipart/mixed"))
    assert len(index) == len(parts) == 6
    for entry, part in zip(index, parts, strict=True):
        assert entry.get("side", "both") == side
        name = "max_error" if "max_error" in entry else "triangles"
        address = f"/v1/gamuts/{entry['gamut']}/mesh.ply?{name}={entry[name]}&side={side}"
        alone = server.client.get(address)
        assert archive.read(entry["file"]) == part.get_payload(decode=True) == alone.content
        assert f'"{entry["sha256"]}"' == part["ETag"] == alone.headers["etag"]
        assert part["Gamut-Triangles"] == str(entry["counts"]["triangles"])
        assert (f"&side={side}" in part["Content-Location"]) == (side != "both")
        assert server.client.get(part["Content-Location"]).content == alone.content
    for info in archive.infolist():
        assert info.compress_type == zipfile.ZIP_STORED
        assert info.date_time == (1980, 1, 1, 0, 0, 0)
        assert info.external_attr >> 16 == 0o100644
        assert info.flag_bits == 0  # sizes in front, which all readers of streams need
    if side == "both":
        assert batch(f"{query}&side=both").content == answer.content


def test_what_is_promised_of_limits_is_in_the_index_and_the_parts(server, batch, gamut):
    query = f"gamuts={gamut['id']}&max_error=0.9,9&max_mismatch=0.03"
    _, index = unpacked(batch(query))
    parts = parts_of(batch(query, "multipart/mixed"))
    for entry, part in zip(index, parts, strict=True):
        name = "max_error" if "max_error" in entry else "max_mismatch"
        assert entry["promises"][name] <= entry[name]
        alone = server.client.get(f"{gamut['links']['mesh']}?{name}={entry[name]}")
        field = f"Gamut-Max-{name.removeprefix('max_').title()}"
        assert float(alone.headers[field]) == entry["promises"][name]
        assert part[field] == alone.headers[field]


@pytest.mark.parametrize("accept", ["application/zip", "multipart/mixed"])
def test_an_answer_never_changes_and_has_its_digest(server, batch, gamut, assert_problem, accept):
    query = f"gamuts={gamut['id']}&triangles=10,100"
    first, second = batch(query, accept), batch(query, accept)
    assert first.content == second.content
    etag = first.headers["etag"]
    assert etag == f'"{hashlib.sha256(first.content).hexdigest()}"'
    assert first.headers["cache-control"] == "public, max-age=31536000, immutable"
    assert first.headers["vary"] == "Accept"
    assert first.headers["content-type"] == second.headers["content-type"]
    assert first.headers["content-type"] != batch(f"{query},4", "multipart/mixed").headers.get(
        "content-type"
    )
    same = batch(query, accept, **{"If-None-Match": etag})
    assert (same.status_code, same.content, same.headers["etag"]) == (304, b"", etag)
    head = server.client.head(f"/v1/meshes?{query}", headers={"Accept": accept})
    assert head.headers["etag"] == etag
    assert batch(query, accept, **{"If-Match": etag}).status_code == 200
    assert_problem(batch(query, accept, **{"If-Match": f"W/{etag}"}), 412, "precondition-failed")


def test_what_cannot_be_had_is_reported_in_its_place(batch, gamut, assert_problem):
    query = f"gamuts={'0' * 64},{gamut['id']}&triangles=3,10"
    answer = batch(query)
    _, index = unpacked(answer)
    codes = ["gamut-not-found", "gamut-not-found", "triangle-count", None]
    assert [entry.get("problem", {}).get("code") for entry in index] == codes
    assert answer.headers["gamut-failures"] == "3"
    assert answer.headers["cache-control"] == "no-store"
    parts = parts_of(batch(query, "multipart/mixed"))
    assert parts[0].get_content_type() == "application/problem+json"
    problems = [json.loads(part.get_payload(decode=True)) for part in parts[:3]]
    assert [problem["code"] for problem in problems] == codes[:3]
    # nothing at all is a problem
    assert_problem(batch(f"gamuts={'0' * 64}&triangles=10"), 404, "gamut-not-found")
    answer = batch(f"gamuts={gamut['id']}&triangles=2,{10**9 - 1}")
    assert_problem(answer, 422, "triangle-count")
    assert_problem(batch(query, "text/html"), 406, "not-acceptable")


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
        ("gamuts={id}&triangles=10&side=left", "side"),
        ("gamuts={id}&triangles=10&other=1", "other"),
        ("gamuts={id}&triangles=" + ",".join(map(str, range(4, 105))), "gamuts"),
    ],
)
def test_what_is_no_question_is_refused(batch, gamut, assert_problem, query, field):
    answer = batch(query.replace("{id}", gamut["id"]))
    document = assert_problem(answer, 422, "invalid-parameter")
    assert document["where"]["field"] == field


def test_equal_values_are_one_mesh(batch, gamut):
    query = f"gamuts={gamut['id']}&triangles=10,010,11&max_error=0.5,0.50,5e-1,1&max_mismatch=1"
    archive, index = unpacked(batch(query))
    assert [entry.get("triangles") for entry in index] == [10, 11, None, None, None]
    assert [entry.get("max_error") for entry in index] == [None, None, 0.5, 1.0, None]
    # an odd count names the level below it, whose file is there once
    assert index[0]["file"] == index[1]["file"] == f"{gamut['id']}/10.glb"
    assert len(archive.namelist()) == len(set(archive.namelist()))


def test_limits_count_as_the_levels_that_keep_them(batch, large):
    limits = ",".join(f"{0.5 + 0.01 * place:.2f}" for place in range(30))
    _, index = unpacked(batch(f"gamuts={large['id']}&max_error={limits}&format=stl"))
    assert len(index) == 30
    assert sum(entry["counts"]["triangles"] for entry in index) < 30_000


@pytest.mark.parametrize("name", ["triangles", "max_mismatch"])
def test_more_triangles_than_are_sent_at_once_are_refused(batch, large, assert_problem, name):
    largest = large["counts"]["triangles"]
    values = {
        "triangles": [str(largest - 2 * place) for place in range(30)],
        "max_mismatch": [f"1e-{10 + place}" for place in range(30)],
    }
    answer = batch(f"gamuts={large['id']}&{name}={','.join(values[name])}")
    document = assert_problem(answer, 422, "invalid-parameter")
    total = 30 * largest - (870 if name == "triangles" else 0)
    assert document["detail"] == f"The meshes may have up to {total} triangles together."
    assert "1000000" in document["remedy"]


def test_large_answers_are_streamed(batch, large):
    counts = ",".join(str(large["counts"]["triangles"] - 2 * number) for number in range(5))
    answer = batch(f"gamuts={large['id']}&triangles={counts}")
    assert "etag" not in answer.headers
    assert answer.headers["transfer-encoding"] == "chunked"
    archive, _ = unpacked(answer)
    assert len(answer.content) > 8 << 20
    assert len(archive.namelist()) == 6
