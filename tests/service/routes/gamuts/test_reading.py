"""What was built is described, downloaded in parts, listed and deleted."""

import hashlib

import pytest

UNKNOWN = "0" * 64


@pytest.mark.parametrize("below", ["", "/levels", "/history", "/mesh", "/mesh.ply"])
def test_unknown_gamuts_are_not_found(server, assert_problem, below):
    answer = server.client.get(f"/v1/gamuts/{UNKNOWN}{below}")
    assert UNKNOWN in assert_problem(answer, 404, "gamut-not-found")["detail"]


@pytest.mark.parametrize("name", ["x", "A" * 64, "0" * 63, "0" * 65, "..%2f..", "%00", "é"])
@pytest.mark.parametrize("below", ["", "/levels", "/history", "/mesh", "/mesh.ply"])
def test_names_that_are_no_ids_are_refused(server, assert_problem, name, below):
    answer = server.client.get(f"/v1/gamuts/{name}{below}")
    if answer.status_code == 404:
        assert_problem(answer, 404, "not-found")
    else:
        assert_problem(answer, 422, "invalid-parameter")


@pytest.mark.parametrize("link", ["self", "levels", "history"])
def test_what_the_client_has_is_not_sent_again(server, gamut, link):
    first = server.client.get(gamut["links"][link])
    assert first.headers["etag"] == f'"{hashlib.sha256(first.content).hexdigest()}"'
    same = server.client.get(gamut["links"][link], headers={"If-None-Match": first.headers["etag"]})
    assert (same.status_code, same.content) == (304, b"")
    assert same.headers["etag"] == first.headers["etag"]
    other = server.client.get(gamut["links"][link], headers={"If-None-Match": '"other"'})
    assert other.content == first.content
    head = server.client.head(gamut["links"][link])
    assert (head.status_code, head.content) == (200, b"")
    assert head.headers["etag"] == first.headers["etag"]
    assert head.headers["content-length"] == str(len(first.content))


@pytest.mark.parametrize("link", ["self", "levels", "history", "mesh"])
def test_only_the_content_that_is_named_is_sent(server, gamut, assert_problem, link):
    address = gamut["links"][link]
    first = server.client.get(address)
    for ask in (server.client.get, server.client.head):
        for named in (first.headers["etag"], f'"x", {first.headers["etag"]}', "*"):
            assert ask(address, headers={"If-Match": named}).status_code == 200
    for named in ('"x"', f"W/{first.headers['etag']}"):
        answer = server.client.get(address, headers={"If-Match": named})
        assert_problem(answer, 412, "precondition-failed")
        assert server.client.head(address, headers={"If-Match": named}).status_code == 412


def test_levels_and_history_never_change(server, gamut):
    for link in ("levels", "history"):
        cache = server.client.get(gamut["links"][link]).headers["cache-control"]
        assert cache == "public, max-age=31536000, immutable"


def test_the_levels_are_those_of_the_description(server, gamut):
    answer = server.client.get(gamut["links"]["levels"]).json()
    assert answer == {"id": gamut["id"], "levels": gamut["levels"]}


def test_parts_of_a_history_make_up_the_whole(server, gamut):
    address = gamut["links"]["history"]
    whole = server.client.get(address)
    assert len(whole.content) == gamut["history_bytes"]
    assert whole.headers["accept-ranges"] == "bytes"
    parts = []
    for start in range(0, len(whole.content), 5000):
        part = server.client.get(address, headers={"Range": f"bytes={start}-{start + 4999}"})
        assert part.status_code == 206
        end = start + len(part.content) - 1
        assert part.headers["content-range"] == f"bytes {start}-{end}/{len(whole.content)}"
        parts.append(part.content)
    assert b"".join(parts) == whole.content


@pytest.mark.parametrize("part", ["bytes=0-9", "bytes=99999999-"])
def test_head_is_of_the_whole_history_whatever_part_is_asked_for(server, gamut, part):
    # RFC 9110, 14.2: only GET has ranges.
    answer = server.client.head(gamut["links"]["history"], headers={"Range": part})
    assert answer.status_code == 200
    assert int(answer.headers["content-length"]) == gamut["history_bytes"]
    assert "content-range" not in answer.headers


def test_several_ranges_are_answered_with_the_whole_in_one_field_or_in_two(server, gamut):
    whole = server.client.get(gamut["links"]["history"])
    for fields in ([("Range", "bytes=0-1,4-5")], [("Range", "bytes=0-1"), ("Range", "bytes=4-5")]):
        answer = server.client.get(gamut["links"]["history"], headers=fields)
        assert (answer.status_code, answer.content) == (200, whole.content)


def test_a_range_behind_the_end_is_a_problem(server, assert_problem, gamut):
    answer = server.client.get(gamut["links"]["history"], headers={"Range": "bytes=99999999-"})
    assert_problem(answer, 416, "range-not-satisfiable")
    assert answer.headers["content-range"] == f"bytes */{gamut['history_bytes']}"


def test_pages_lead_through_all_gamuts(start_server, sphere):
    server = start_server(max_page_size=2)
    server.wait_ready()
    assert server.client.get("/v1/gamuts").json() == {"gamuts": [], "next": None}
    ids = {
        server.client.post("/v1/gamuts", json={"samples": sphere(seed)}).json()["id"]
        for seed in range(5)
    }
    found, address = [], "/v1/gamuts?limit=100"
    while address:
        answer = server.client.get(address)
        page = answer.json()
        assert 1 <= len(page["gamuts"]) <= 2
        found += [gamut["id"] for gamut in page["gamuts"]]
        address = page["next"]
        assert answer.links.get("next", {}).get("url") == address
    assert found == sorted(ids)
    server.stop()


@pytest.mark.parametrize("query", ["limit=0", "limit=many", "after=x", "after=%00"])
def test_wrong_pages_are_refused(server, assert_problem, query):
    document = assert_problem(server.client.get(f"/v1/gamuts?{query}"), 422, "invalid-parameter")
    assert document["where"] == {"in": "query", "field": query.partition("=")[0]}


def test_nothing_of_a_deleted_gamut_is_left(server, assert_problem, sphere):
    body = {"samples": sphere(seed=20)}
    gamut = server.client.post("/v1/gamuts", json=body).json()
    for link in gamut["links"].values():
        assert server.client.get(link).status_code == 200
    for named in ('"x"', server.client.get(gamut["links"]["history"]).headers["etag"]):
        kept = server.client.delete(gamut["links"]["self"], headers={"If-Match": named})
        assert_problem(kept, 412, "precondition-failed")
    etag = server.client.get(gamut["links"]["self"], headers={"Accept-Encoding": "gzip"}).headers[
        "etag"
    ]
    answer = server.client.delete(gamut["links"]["self"], headers={"If-Match": etag})
    assert (answer.status_code, answer.content) == (204, b"")
    for link in gamut["links"].values():
        assert_problem(server.client.get(link), 404, "gamut-not-found")
    assert_problem(server.client.get(f"/v1/jobs/{gamut['id']}"), 404, "job-not-found")
    assert_problem(server.client.delete(gamut["links"]["self"]), 404, "gamut-not-found")
    again = server.client.post("/v1/gamuts", json=body)
    assert again.status_code == 201
    assert again.json()["id"] == gamut["id"]
