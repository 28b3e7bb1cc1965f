"""Names over HTTP: defaults, PUT, lists, replicas."""

import concurrent.futures
import contextlib
import json
import sys
from pathlib import Path

import pytest

from service.application import create_app
from service.settings import Settings
from service.storage import store_at

CSV = b"LAB_L,LAB_A,LAB_B\n0,0,0\n100,0,0\n50,60,0\n50,-30,52\n50,-30,-%d"


def csv(number):
    return CSV % number


def put(server, gamut, name):
    return server.client.put(f"/v1/gamuts/{gamut['id']}/name", json={"name": name})


def listed(server, **query):
    """All gamuts of a list, by following its pages."""
    found, answer = [], server.client.get("/v1/gamuts", params=query).json()
    while True:
        found += answer["gamuts"]
        if answer["next"] is None:
            return found
        answer = server.client.get(answer["next"]).json()


def test_a_form_part_names_the_gamut_and_is_no_part_of_its_id(server):
    file = {"file": ("press.csv", csv(40))}
    named = server.client.post("/v1/gamuts", files=file, data={"name": "  Press A "}).json()
    assert named["name"] == "Press A"
    again = server.client.post("/v1/gamuts", files=file).json()
    assert (again["id"], again["name"]) == (named["id"], "Press A")
    renamed = server.client.post("/v1/gamuts", files=file, data={"name": "Press B"}).json()
    assert (renamed["id"], renamed["name"]) == (named["id"], "Press B")


def test_a_json_member_names_the_gamut_and_is_no_part_of_its_id(server, sphere):
    body = {"samples": sphere(seed=91)}
    plain = server.client.post("/v1/gamuts", json=body).json()
    named = server.client.post("/v1/gamuts", json=body | {"name": "Ball"}).json()
    assert (named["id"], named["name"]) == (plain["id"], "Ball")
    assert plain["name"].startswith("Gamut ")


CGATS = b"""CGATS.17
DESCRIPTOR "Offset\ton blue"
NUMBER_OF_FIELDS 3
BEGIN_DATA_FORMAT
LAB_L LAB_A LAB_B
END_DATA_FORMAT
NUMBER_OF_SETS 5
BEGIN_DATA
%s
END_DATA
"""


@pytest.mark.parametrize(
    ("file", "content", "name"),
    [
        ("Paper 7.csv", csv(41), "Paper 7.csv"),
        # what the data says comes before the name of the file
        ("x.ti3", CGATS % csv(42).split(b"\n", 1)[1].replace(b",", b" "), "Offset on blue"),
    ],
)
def test_the_default_is_what_the_data_or_the_file_is_called(server, file, content, name):
    assert server.client.post("/v1/gamuts", files={"file": (file, content)}).json()["name"] == name


def test_the_description_of_a_profile_is_the_default(server):
    profile = Path(__file__).parents[2] / "data" / "sRGB-v4.icc"
    answer = server.client.post(
        "/v1/gamuts",
        files={"file": ("x.icc", profile.read_bytes())},
        data={"options": json.dumps({"surface_samples": 300})},
    )
    assert answer.json()["name"] == answer.json()["provenance"]["description"] != ""


def test_a_name_is_put_and_changes_nothing_immutable(server):
    gamut = server.client.post("/v1/gamuts", files={"file": csv(43)}).json()
    paths = [gamut["links"][part] for part in ("mesh", "levels", "history")]
    before = [server.client.get(path) for path in paths]
    description = server.client.get(gamut["links"]["self"])
    answer = put(server, gamut, "Renamed")
    assert (answer.status_code, answer.json()) == (200, {"id": gamut["id"], "name": "Renamed"})
    after = [server.client.get(path) for path in paths]
    for one, other in zip(before, after, strict=True):
        assert (one.content, one.headers["etag"]) == (other.content, other.headers["etag"])
    known = {"If-None-Match": description.headers["etag"]}
    now = server.client.get(gamut["links"]["self"], headers=known)
    assert (now.status_code, now.json()["name"]) == (200, "Renamed")


def test_lists_show_name_channels_volume_and_time_and_are_filtered(server):
    names = [f"{'Filter' if n % 3 else 'Other'} {n} Ä" for n in range(9)]
    for number, name in enumerate(names):
        file = {"file": csv(44 + number)}
        assert server.client.post("/v1/gamuts", files=file, data={"name": name}).is_success
    for limit in (1, 2, 5, 100):
        found = listed(server, name="filter", limit=limit)
        assert sorted(each["name"] for each in found) == [n for n in names if "Filter" in n]
        assert all({"channels", "volume", "created"} <= set(each) for each in found)
    assert [each["name"] for each in listed(server, name="TER 2 ä")] == ["Filter 2 Ä"]
    assert listed(server, name="no gamut has this name") == []


def test_similar_names_are_ranked_and_names_of_print_conditions_are_the_same(server):
    names = ["Linear Zeta RGB", "Zeta RGB", "GRACoL2006_Coated1v2", "SWOP2006_Coated3v2"]
    for number, name in enumerate(names):
        file = {"file": csv(80 + number)}
        assert server.client.post("/v1/gamuts", files=file, data={"name": name}).is_success

    def similar(name, **query):
        return [each["name"] for each in listed(server, name=name, match="similar", **query)]

    assert similar("zeta rgb") == ["Zeta RGB", "Linear Zeta RGB"]
    assert similar("zetargb", limit=1) == ["Zeta RGB"]
    assert similar("zeat RGB")[0] == "Zeta RGB"
    assert similar("CGATS TR 006") == ["GRACoL2006_Coated1v2"]
    assert similar("TR003") == ["SWOP2006_Coated3v2"]
    assert listed(server, match="similar") == listed(server)


def test_another_kind_of_match_is_refused(server, assert_problem):
    answer = server.client.get("/v1/gamuts", params={"name": "x", "match": "regex"})
    assert_problem(answer, 422, "invalid-parameter")


@pytest.mark.parametrize(
    ("body", "code"),
    [
        ({"name": ""}, "invalid-name"),
        ({"name": "x" * 201}, "invalid-name"),
        ({"name": "a\nb"}, "invalid-name"),
        ({"name": "\ud800"}, "invalid-name"),
        ({"name": "\u200b"}, "invalid-name"),
        ({"name": "a\u2028b"}, "invalid-name"),
        ({"name": 5}, "invalid-name"),
        ({"name": "a", "more": 1}, "invalid-body"),
        ({}, "invalid-body"),
        (["a"], "invalid-body"),
    ],
)
def test_what_is_no_name_is_refused(server, gamut, assert_problem, body, code):
    content = json.dumps(body).encode()
    answer = server.client.put(
        f"/v1/gamuts/{gamut['id']}/name",
        content=content,
        headers={"Content-Type": "application/json"},
    )
    assert_problem(answer, 422, code)


def test_bodies_that_are_no_json_or_too_large_are_refused(server, gamut, assert_problem):
    path = f"/v1/gamuts/{gamut['id']}/name"
    as_json = {"Content-Type": "application/json"}
    assert_problem(server.client.put(path, content=b"{", headers=as_json), 400, "malformed-body")
    assert_problem(server.client.put(path, content=b"name"), 415, "unsupported-media-type")
    large = b'{"name": "%s"}' % (b"x" * 20_000)
    assert_problem(server.client.put(path, content=large, headers=as_json), 413, "body-too-large")


def test_bad_names_of_forms_and_json_are_refused_before_a_build(server, assert_problem, sphere):
    file = {"file": csv(70)}
    answer = server.client.post("/v1/gamuts", files=file, data={"name": "\x07"})
    assert_problem(answer, 422, "invalid-name")
    body = {"samples": sphere(seed=92), "name": ["x"]}
    assert_problem(server.client.post("/v1/gamuts", json=body), 422, "invalid-name")


def test_only_gamuts_have_names_and_references_keep_theirs(server, assert_problem):
    assert_problem(put(server, {"id": "0" * 64}, "x"), 404, "gamut-not-found")
    gamut = server.client.get("/v1/gamuts/srgb", params={"surface_samples": 300}).json()
    assert gamut["name"] == "sRGB"
    for name in (gamut["id"], "srgb"):
        answer = server.client.put(f"/v1/gamuts/{name}/name", json={"name": "mine"})
        assert_problem(answer, 409, "reference-read-only")


def test_a_deleted_gamut_leaves_no_name(server):
    file = {"file": ("first.csv", csv(71))}
    gamut = server.client.post("/v1/gamuts", files=file, data={"name": "Gone"}).json()
    server.client.delete(gamut["links"]["self"])
    assert server.client.post("/v1/gamuts", files=file).json()["name"] == "first.csv"


def test_a_name_needs_the_scope_to_write(tmp_path, request_app, assert_problem):
    app = create_app(Settings(store=str(tmp_path), allow_anonymous="read"))
    answer = request_app(app, "PUT", f"/v1/gamuts/{'0' * 64}/name", json={"name": "x"})
    assert_problem(answer, 401, "api-key-required")


def test_of_two_replicas_the_last_writer_wins(s3, monkeypatch, request_app, built, publish_built):
    for name, value in s3.items():
        monkeypatch.setenv(name, value)
    location = f"s3://bucket/names-{sys.version_info[1]}"
    with contextlib.closing(store_at(location)) as store:
        store.open()
        for gamut in built:
            publish_built(store, gamut)
    replicas = [create_app(Settings(store=location)) for _ in range(2)]
    address = f"/v1/gamuts/{built[0].id}"

    def give(replica, name):
        return request_app(replicas[replica], "PUT", f"{address}/name", json={"name": name})

    def names():
        return [request_app(replica, "GET", address).json()["name"] for replica in replicas]

    for replica, name in ((0, "by one"), (1, "by the other"), (0, "by one")):
        assert give(replica, name).is_success
        assert names() == [name, name]
    # Each replica has a thread of its own, so that both write at the same time.
    with concurrent.futures.ThreadPoolExecutor(2) as threads:
        answers = threads.map(lambda n: [give(n, f"name {n}-{turn}") for turn in range(6)], (0, 1))
    assert all(answer.is_success for each in answers for answer in each)
    left, other = names()
    assert left == other
    assert left in {"name 0-5", "name 1-5"}
    found = request_app(replicas[1], "GET", "/v1/gamuts", params={"name": left}).json()["gamuts"]
    assert [gamut["id"] for gamut in found] == [built[0].id]


def test_files_have_the_name_and_a_new_one_at_once(server, sphere):
    gamut = server.client.post("/v1/gamuts", json={"samples": sphere(seed=794, count=40)}).json()
    files = {
        "mesh": (f"{gamut['links']['mesh']}.ply?triangles=20", "-20.ply"),
        "picture": (f"{gamut['links']['self']}/picture.png?size=16", ".png"),
        "history": (gamut["links"]["history"], ".gamut"),
    }
    tags = {}
    for name in (gamut["name"], "Proof A", "Proof B"):
        if name != gamut["name"]:
            server.client.put(f"{gamut['links']['self']}/name", json={"name": name})
        for kind, (address, rest) in files.items():
            answer = server.client.get(address)
            assert f'filename="{name}{rest}"' in answer.headers["content-disposition"]
            # the name is no part of the content
            assert tags.setdefault(kind, answer.headers["etag"]) == answer.headers["etag"]
