"""The list of reference gamuts."""

from gamutcore.references import NOT_OFFERED, REFERENCES


def test_all_references_are_listed_with_white_primaries_and_source(server):
    answer = server.client.get("/v1/references")
    assert answer.status_code == 200
    listed = {each["slug"]: each for each in answer.json()["references"]}
    assert set(listed) == set(REFERENCES)
    srgb = listed["srgb"]
    assert srgb["name"] == "sRGB"
    assert srgb["white"] == [0.3127, 0.329]
    assert srgb["primaries"] == [[0.64, 0.33], [0.3, 0.6], [0.15, 0.06]]
    assert all(each["source"] for each in listed.values())
    assert listed["pointer"]["primaries"] is None
    missing = {each["name"]: each["reason"] for each in answer.json()["not_offered"]}
    assert missing == dict(NOT_OFFERED)


def test_the_list_is_revalidated_by_its_entity_tag(server):
    answer = server.client.get("/v1/references")
    known = {"If-None-Match": answer.headers["etag"]}
    assert answer.headers["cache-control"] == "no-cache"
    assert server.client.get("/v1/references", headers=known).status_code == 304
