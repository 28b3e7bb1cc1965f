"""Waiting for builds, by POST and by the slug of a reference gamut."""

import itertools

import pytest

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


@pytest.mark.parametrize("ask", [by_post, by_slug])
def test_a_client_that_waits_gets_the_gamut(server, ask):
    assert ask(server, {"Prefer": "wait=60"}).json()["state"] == "ready"


def test_a_batch_of_new_references_waits_once(server):
    slugs = "apple-rgb,beta-rgb,best-rgb"
    query = {"gamuts": slugs, "triangles": "20", "surface_samples": next(SAMPLES)}
    answer = server.client.get("/v1/meshes", params=query, headers={"Prefer": "wait=0"})
    assert answer.status_code == 202
    assert server.wait_for(lambda: server.client.get("/v1/meshes", params=query).status_code == 200)


def test_a_failed_build_is_the_problem_of_the_request(server, assert_problem):
    query = {"centre": "[500,0,0]", "surface_samples": next(SAMPLES)}
    answer = server.client.get("/v1/gamuts/srgb", params=query)
    assert_problem(answer, 422, "centre-outside")
