import pytest

UNKNOWN = "0" * 64


def test_unknown_jobs_are_not_found(server, assert_problem):
    assert_problem(server.client.get(f"/v1/jobs/{UNKNOWN}"), 404, "job-not-found")


@pytest.mark.parametrize("name", ["x", "A" * 64])
def test_names_that_are_no_ids_are_refused(server, assert_problem, name):
    document = assert_problem(server.client.get(f"/v1/jobs/{name}"), 422, "invalid-parameter")
    assert document["where"] == {"in": "path", "field": "job_id"}


def test_a_job_leads_to_its_gamut(server, gamut):
    job = server.client.get(f"/v1/jobs/{gamut['id']}")
    assert job.headers["cache-control"] == "no-store"
    assert job.json()["state"] == "succeeded"
    assert job.json()["links"]["gamut"] == gamut["links"]["self"]


def test_a_failed_job_says_why_and_can_be_tried_again(server, assert_problem):
    body = {"samples": [[0, 0, 0], [1, 1, 1]]}
    for _ in range(2):
        posted = server.client.post("/v1/gamuts", json=body, headers={"Prefer": "respond-async"})
        assert posted.status_code == 202
        address = posted.headers["location"]
        job = server.finished_job(address)
        assert job["state"] == "failed"
        assert job["links"]["gamut"] is None
        assert job["problem"]["code"] == "too-few-points"
        assert job["problem"]["type"] == "/problems/too-few-points"
        assert "retry-after" not in server.client.get(address).headers
    assert_problem(server.client.get(f"/v1/gamuts/{job['id']}"), 404, "gamut-not-found")


def test_a_running_job_tells_its_stage(server, slow_build):
    posted = server.client.post("/v1/gamuts", **slow_build(), headers={"Prefer": "respond-async"})
    address = posted.headers["location"]
    stages = set()

    def finished():
        answer = server.client.get(address)
        job = answer.json()
        assert 0 <= job["fraction"] <= 1
        if job["state"] == "running":
            stages.add(job["stage"])
        assert ("retry-after" in answer.headers) == (job["finished"] is None)
        return job["state"] == "succeeded"

    server.wait_for(finished)
    assert {"colours", "boundary"} <= stages
