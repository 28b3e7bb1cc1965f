"""Reference gamuts: their list, slugs in the place of ids, and waiting for their builds."""

import itertools
import json

import pytest

from gamutcore import Options
from gamutcore.building import gamut_id
from gamutcore.references import NOT_OFFERED, REFERENCES
from service.application import create_app
from service.routes.dependencies import CACHE_SECONDS
from service.settings import Settings
from service.storage import store_at

FEW = {"surface_samples": 400}


def id_of(slug, **options):
    return gamut_id(Options(**options), REFERENCES[slug].sha256)


def test_a_slug_is_built_on_first_use_and_answers_as_its_id(server):
    expected = id_of("apple-rgb", **FEW)
    assert server.client.get(f"/v1/gamuts/{expected}").status_code == 404
    answer = server.client.get("/v1/gamuts/apple-rgb", params=FEW)
    assert answer.status_code == 200
    assert answer.json()["id"] == expected
    assert answer.headers["content-location"] == f"/v1/gamuts/{expected}"
    assert answer.json() == server.client.get(f"/v1/gamuts/{expected}").json()
    assert server.client.get("/v1/gamuts/apple-rgb", params=FEW).status_code == 200
    assert server.builds_started(expected) == 1


@pytest.mark.parametrize(
    ("path", "query"),
    [
        ("/mesh", {"triangles": 50}),
        ("/mesh.ply", {"max_error": 2}),
        ("/levels", {}),
        ("/history", {}),
    ],
)
def test_every_operation_gives_the_bytes_of_the_id_with_a_short_life(server, path, query):
    by_slug = server.client.get(f"/v1/gamuts/srgb{path}", params=FEW | query)
    assert by_slug.status_code == 200
    location = by_slug.headers["content-location"]
    assert location.startswith(f"/v1/gamuts/{id_of('srgb', **FEW)}{path}")
    by_id = server.client.get(location)
    assert by_id.content == by_slug.content
    assert by_id.headers["etag"] == by_slug.headers["etag"]
    assert "immutable" in by_id.headers["cache-control"]
    assert by_slug.headers["cache-control"] == f"public, max-age={CACHE_SECONDS}"
    known = {"If-None-Match": by_slug.headers["etag"]}
    again = server.client.get(f"/v1/gamuts/srgb{path}", params=FEW | query, headers=known)
    assert again.status_code == 304
    assert again.headers["content-location"] == location


def test_options_of_space_and_conditions_apply(server):
    options = {"space": "cam16ucs", "surround": "dim", **FEW}
    gamut = server.client.get("/v1/gamuts/srgb", params=options).json()
    assert gamut["options"]["space"] == "CAM16-UCS"
    assert gamut["options"]["surround"] == "dim"
    posted = server.client.post("/v1/gamuts", json={"reference": "sRGB", "options": options})
    assert (posted.status_code, posted.json()["id"]) == (200, gamut["id"])


def test_a_comparison_takes_slugs_and_ids(server, gamut):
    query = {"a": "srgb", "b": gamut["id"], "triangles": "20", **FEW}
    answer = server.client.get("/v1/comparisons", params=query)
    assert answer.status_code == 200
    assert answer.headers["cache-control"] == f"public, max-age={CACHE_SECONDS}"
    assert id_of("srgb", **FEW) in answer.headers["content-location"]


def test_references_cannot_be_deleted(server, assert_problem):
    gamut = server.client.get("/v1/gamuts/srgb", params=FEW).json()
    for name in ("srgb", gamut["id"], id_of("srgb")):
        answer = server.client.delete(f"/v1/gamuts/{name}")
        assert_problem(answer, 409, "reference-read-only")
    assert server.client.get(gamut["links"]["self"]).status_code == 200


@pytest.mark.parametrize(
    ("method", "path"),
    [
        ("PUT", "/history?space=Oklab"),
        ("PUT", "/levels?side=both&space=Oklab"),
        ("PATCH", ""),
        ("DELETE", "/mesh?gamma=7"),
        ("POST", "/mesh?gamma=7"),
    ],
)
def test_methods_without_an_operation_are_not_allowed(server, assert_problem, method, path):
    """Schemathesis found 409 for the first two."""
    for name in ("srgb", id_of("srgb")):
        answer = server.client.request(method, f"/v1/gamuts/{name}{path}")
        assert_problem(answer, 405, "method-not-allowed")
        assert answer.headers["allow"]


@pytest.mark.parametrize(
    ("query", "code"),
    [
        ("gamma=7", "invalid-option"),
        ("ink_limit=300", "invalid-option"),
        ("space=Oklab&space=Oklab", "invalid-parameter"),
        ("spaces=Oklab", "invalid-parameter"),
        ("surface_samples=999999999", "invalid-option"),
        ("centre=%FF", "invalid-option"),
    ],
)
def test_bad_options_are_refused(server, assert_problem, query, code):
    assert_problem(server.client.get(f"/v1/gamuts/srgb?{query}"), 422, code)


def test_a_misspelled_slug_is_answered_with_a_near_match(server, assert_problem):
    problem = assert_problem(server.client.get("/v1/gamuts/srbg"), 422, "invalid-parameter")
    assert "srgb" in problem["remedy"]
    answer = server.client.post("/v1/gamuts", json={"reference": "dispaly-p3"})
    assert "display-p3" in assert_problem(answer, 422, "unknown-reference")["remedy"]


def test_options_beside_an_id_are_refused(server, gamut, assert_problem):
    answer = server.client.get(gamut["links"]["self"], params={"space": "Oklab"})
    assert_problem(answer, 422, "invalid-parameter")


@pytest.mark.parametrize(
    "body", [{"reference": 3}, {"reference": "srgb", "gamma": 1}, {"reference": "srgb", "white": 1}]
)
def test_bodies_that_say_more_than_a_reference_are_refused(server, assert_problem, body):
    assert_problem(server.client.post("/v1/gamuts", json=body), 422, "invalid-body")


def test_a_definition_can_be_posted_as_a_file(server):
    data = REFERENCES["srgb"].data
    answer = server.client.post(
        "/v1/gamuts", files={"file": data}, data={"options": json.dumps(FEW)}
    )
    assert answer.status_code in {200, 201}
    assert answer.json()["id"] == id_of("srgb", **FEW)


def test_an_evicted_reference_is_built_again(server):
    """By its slug, and by its id if the options are the defaults."""
    default = id_of("h-273-22-unspecified")
    assert server.client.get(f"/v1/gamuts/{default}").status_code == 200
    (record,) = server.data.rglob(f"{default}.record")
    record.unlink()
    assert server.client.get(f"/v1/gamuts/{default}").status_code == 200
    assert server.builds_started(default) == 2


def test_readers_start_builds_with_default_options_only(request_app, tmp_path, assert_problem):
    """A reader could fill the store by combining options. Nothing is built in this process."""
    store = store_at(str(tmp_path))
    store.open()
    store.close()
    readers = Settings(
        store=str(tmp_path), allow_anonymous="read", build_rate_limit=0.0001, build_rate_burst=1
    )
    app = create_app(readers)

    def get(path, **query):
        headers = {"Prefer": "respond-async"}
        return request_app(app, "GET", f"/v1/{path}", params=query, headers=headers)

    assert_problem(get("gamuts/srgb", **FEW), 401, "api-key-required")
    assert get("gamuts/h-273-22-unspecified").status_code == 202
    assert_problem(get("gamuts/h-273-generic-film"), 429, "rate-limited")
    assert get("references").status_code == 200


@pytest.mark.parametrize("suffix", ["", ".ply", "?triangles=20"])
def test_a_mesh_at_the_id_of_a_reference_starts_its_build(request_app, tmp_path, suffix):
    """As every operation does. Nothing is built in this process, so the answer is the job."""
    store = store_at(str(tmp_path))
    store.open()
    store.close()
    app, default = create_app(Settings(store=str(tmp_path))), id_of("srgb")
    headers = {"Prefer": "respond-async"}
    answer = request_app(app, "GET", f"/v1/gamuts/{default}/mesh{suffix}", headers=headers)
    assert answer.status_code == 202
    assert answer.headers["location"] == f"/v1/jobs/{default}"


def test_options_apply_to_slugs_and_not_to_ids_beside_them(request_app, tmp_path, assert_problem):
    """Nothing is built in this process, so the answer is the job of the first gamut."""
    store = store_at(str(tmp_path))
    store.open()
    store.close()
    app = create_app(Settings(store=str(tmp_path)))

    def get(**query):
        headers = {"Prefer": "respond-async"}
        return request_app(app, "GET", "/v1/comparisons", params=query | FEW, headers=headers)

    names = {"a": id_of("srgb"), "b": "display-p3"}
    assert_problem(get(**names, triangle=20), 422, "invalid-parameter")
    assert app.state.service.builds.facts().queued == 0
    answer = get(**names, triangles=20)
    assert answer.status_code == 202
    assert answer.headers["location"] == f"/v1/jobs/{id_of('srgb')}"
    answer = get(a="display-p3", b="display-p3", triangles=20)
    assert answer.headers["location"] == f"/v1/jobs/{id_of('display-p3', **FEW)}"


# --- the list -------------------------------------------------------------------------------------


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


@pytest.mark.parametrize(
    ("name", "slug"), [("srgb", "srgb"), ("Rec2020", "bt2020"), ("BT.2100 HLG", "bt2100-hlg-1000")]
)
def test_the_list_is_searched_by_everyday_names(server, name, slug):
    found = server.client.get("/v1/references", params={"name": name}).json()["references"]
    assert found[0]["slug"] == slug
    assert len(found) < len(REFERENCES)


def test_a_search_without_a_match_is_empty_and_names_what_is_not_offered(server, assert_problem):
    found = server.client.get("/v1/references", params={"name": "qwxz"}).json()
    assert found == {"references": [], "not_offered": []}
    found = server.client.get("/v1/references", params={"name": "REDWideGamutRGB"}).json()
    assert [each["name"] for each in found["not_offered"]][:1] == ["REDWideGamutRGB"]
    answer = server.client.get("/v1/references", params={"name": "x" * 201})
    assert_problem(answer, 422, "invalid-parameter")


def test_an_ambiguous_name_is_answered_with_the_candidates(server, assert_problem):
    answer = server.client.post("/v1/gamuts", json={"reference": "P3"})
    remedy = assert_problem(answer, 422, "unknown-reference")["remedy"]
    assert all(slug in remedy for slug in ("display-p3", "dci-p3", "p3-d65"))
    answer = server.client.get("/v1/gamuts/Rec2020")
    assert "bt2020" in assert_problem(answer, 422, "invalid-parameter")["remedy"]


def test_bt2100_states_its_peak_luminance_and_counts_colours(server):
    listed = server.client.get("/v1/references", params={"name": "bt2100-pq-4000"}).json()
    assert listed["references"][0]["peak_luminance"] == 4000
    query = {"space": "ITP", "surface_samples": 2000}
    described = server.client.get("/v1/gamuts/bt2100-pq-4000", params=query).json()
    assert 30e6 < described["distinguishable_colours"] < 40e6
    query["luminance"] = 1000
    answer = server.client.get("/v1/gamuts/bt2100-pq-4000", params=query)
    assert answer.status_code == 422
    assert "luminance" in answer.json()["detail"]


def test_chromaticities_are_compared_beside_volumes(server):
    """The areas of the primaries: 0.11205 and 0.152 in xy."""
    for slug in ("srgb", "display-p3"):
        described = server.client.get(f"/v1/gamuts/{slug}", params=FEW).json()
        assert described["chromaticity"]["basis"] == "primaries"
    query = {"a": id_of("srgb", **FEW), "b": id_of("display-p3", **FEW)}
    found = server.client.get("/v1/comparisons", params=query).json()["chromaticity"]
    assert found["xy"]["area_ratio"] == pytest.approx(0.11205 / 0.152, abs=1e-5)
    assert found["xy"]["b_covers_a"] == pytest.approx(1, abs=1e-6)
    assert found["basis_a"] == found["basis_b"] == "primaries"


def test_the_list_is_revalidated_by_its_entity_tag(server):
    answer = server.client.get("/v1/references")
    known = {"If-None-Match": answer.headers["etag"]}
    assert answer.headers["cache-control"] == "no-cache"
    assert server.client.get("/v1/references", headers=known).status_code == 304


# --- waiting for builds ---------------------------------------------------------------------------

SAMPLES = itertools.count(900)
"""Numbers of surface samples that no other test asks for: every request is a new gamut."""


def by_post(server, headers):
    options = {"surface_samples": next(SAMPLES)}
    body = {"reference": "srgb", "options": options}
    return server.client.post("/v1/gamuts", json=body, headers=headers)


def by_slug(server, headers):
    query = {"surface_samples": next(SAMPLES)}
    return server.client.get("/v1/gamuts/srgb", params=query, headers=headers)


@pytest.mark.parametrize("ask", [by_post, by_slug])
def test_a_client_that_does_not_wait_gets_the_job_which_ends_in_the_gamut(server, ask):
    answer = ask(server, {"Prefer": "wait=0"})
    assert answer.status_code == 202
    assert answer.headers["preference-applied"] == "wait=0"
    job = answer.headers["location"]
    assert server.wait_for(lambda: server.client.get(job).json()["state"] == "succeeded")
    gamut = server.client.get(server.client.get(job).json()["links"]["gamut"])
    assert gamut.json()["provenance"]["reference"] == "srgb"


def test_several_new_references_are_waited_for_once(server):
    query = {"with": "beta-rgb,best-rgb", "surface_samples": next(SAMPLES)}
    page = "/v1/gamuts/apple-rgb/viewer.html"
    answer = server.client.get(page, params=query, headers={"Prefer": "wait=0"})
    assert answer.status_code == 202
    assert server.wait_for(lambda: server.client.get(page, params=query).status_code == 200)


def test_a_failed_build_is_the_problem_of_the_request(server, assert_problem):
    query = {"centre": "[500,0,0]", "surface_samples": next(SAMPLES)}
    answer = server.client.get("/v1/gamuts/srgb", params=query)
    assert_problem(answer, 422, "centre-outside")
