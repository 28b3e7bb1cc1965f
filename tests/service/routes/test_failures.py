"""Restarts, a store that is away, damaged files, and builds that take too long."""

import concurrent.futures
import shutil
import signal
import sys
from pathlib import Path

import pytest

# The tests' folders are no packages.
sys.path.insert(0, str(Path(__file__).parents[2] / "faults"))
from job_faults import accepted_jobs_finish

from service.problems.kinds import KINDS


@pytest.mark.long
def test_what_was_accepted_or_built_outlives_kills_and_stops(
    start_server, slow_build, sphere, assert_problem
):
    known = {}

    def describe(server):
        gamut = server.client.post("/v1/gamuts", json={"samples": sphere()}).json()
        mesh = server.client.get(gamut["links"]["mesh"]).content
        job = server.client.get(f"/v1/jobs/{gamut['id']}").json()
        assert job["state"] == "succeeded"
        return {"gamut": gamut, "mesh": mesh, "job": job}

    def start(*arguments, **settings):
        server = start_server(*arguments, **settings)
        if known:
            assert describe(server) == known
            return server
        not_ready = server.client.get("/readyz")
        where = assert_problem(not_ready, 503, "not-ready")["where"]
        assert int(not_ready.headers["retry-after"]) > 0
        assert (where["ready"], where["workers"]) == (False, 1)
        assert where["probes"]["workers"]["status"] == "failed"
        assert "workers: " in not_ready.json()["detail"]
        assert server.client.get("/livez").status_code == 200
        gamut = describe(server)["gamut"]
        name = {"name": "Kept"}
        assert server.client.put(f"{gamut['links']['self']}/name", json=name).status_code == 200
        known.update(describe(server))
        assert known["gamut"]["name"] == "Kept"
        return server

    accepted_jobs_finish(start, lambda samples: slow_build(samples // 2), kills=1, stops=1)


def test_a_store_that_is_away_is_named_until_it_is_back(server, assert_problem, sphere):
    temporary = server.data / "temporary"
    body = {"samples": sphere(seed=70)}
    moved = temporary.rename(server.data / "elsewhere")
    try:
        answer = server.wait_for(
            lambda: (answer := server.client.get("/readyz")).status_code == 503 and answer
        )
        document = assert_problem(answer, 503, "not-ready")
        assert document["where"]["probes"]["store"]["status"] == "failed"
        assert str(server.data) not in answer.text
        assert server.client.get("/livez").status_code == 200
        assert_problem(server.client.post("/v1/gamuts", json=body), 503, "store-unavailable")
    finally:
        moved.rename(temporary)
    server.wait_ready()
    assert server.client.post("/v1/gamuts", json=body).status_code == 201
    live, ready = server.client.get("/livez"), server.client.get("/readyz")
    assert (live.status_code, live.text) == (200, "live\n")
    assert ready.json()["workers_warm"] == ready.json()["workers"] == 1
    assert {probe["status"] for probe in ready.json()["probes"].values()} == {"ok"}
    for answer in (live, ready):
        assert answer.headers["cache-control"] == "no-store"


@pytest.fixture(scope="module")
def damaged(server, start_server, sphere, tmp_path_factory):
    """A server on a store with a fault in a file of each gamut; the gamuts, and their meshes."""
    bodies = [{"samples": sphere(seed)} for seed in range(50, 54)]
    gamuts = [server.client.post("/v1/gamuts", json=body).json() for body in bodies]
    meshes = [server.client.get(gamut["links"]["mesh"]).content for gamut in gamuts]
    # What is acknowledged is on the disk: what the server has written so far is a whole store.
    data = tmp_path_factory.mktemp("damaged") / "data"
    for gamut in gamuts:
        for path in server.data.rglob(f"{gamut['id']}*"):
            copy = data / path.relative_to(server.data)
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(path, copy)
    for gamut, suffix, position in zip(
        gamuts, ("gamut", "gamut", "record", "record"), (0.1, 0.9, 0.1, 0.9), strict=True
    ):
        (path,) = data.rglob(f"{gamut['id']}*.{suffix}")
        content = bytearray(path.read_bytes())
        content[int(position * len(content))] ^= 4
        path.write_bytes(content)
    return start_server(data, stop_delay=3600), gamuts, meshes


def test_damaged_files_are_never_served_and_built_again(damaged, assert_problem):
    second, gamuts, meshes = damaged
    for gamut, mesh in zip(gamuts, meshes, strict=True):
        answer = second.client.get(gamut["links"]["mesh"])
        problem = assert_problem(answer, 503, "gamut-rebuilding")
        assert int(answer.headers["retry-after"]) >= 1
        assert second.finished_job(problem["where"]["job"])["state"] == "succeeded"
        assert second.client.get(gamut["links"]["mesh"]).content == mesh
        assert second.client.get(gamut["links"]["history"]).status_code == 200
    assert len(list((second.data / "quarantine").iterdir())) >= 4


def test_a_service_that_stops_says_so_before_it_ends(damaged, sphere, assert_problem):
    server, *_ = damaged
    server.wait_ready()
    server.process.send_signal(signal.SIGTERM)
    server.wait_for(lambda: "Not ready from now on" in server.log())
    document = assert_problem(server.client.get("/readyz"), 503, "not-ready")
    assert document["where"]["probes"]["builds"]["detail"] == "the service is stopping"
    body = {"samples": sphere(seed=72)}
    assert server.client.post("/v1/gamuts", json=body).status_code == 201
    server.stop()  # a second signal ends the delay


@pytest.mark.long  # test_builds has the same with a worker that follows a script
def test_a_build_beyond_its_deadline_is_a_problem(start_server, slow_build, assert_problem):
    server = start_server(build_timeout=2)
    server.wait_ready()
    answer = server.client.post("/v1/gamuts", **slow_build(400_000))
    assert_problem(answer, 422, "build-timeout")
    # another worker takes its place
    assert server.worker(2) != server.worker(1)
    server.stop()


def test_a_gamut_whose_history_is_gone_is_built_anew_by_posting(server, sphere, assert_problem):
    body = {"samples": sphere(seed=41)}
    first = server.client.post("/v1/gamuts", json=body).json()

    def lose_history():
        (history,) = server.data.rglob(f"published/*/{first['id']}*.gamut")
        history.unlink()

    lose_history()
    assert_problem(server.client.get(first["links"]["self"]), 503, "gamut-rebuilding")
    assert server.client.post("/v1/gamuts", json=body).status_code in {200, 201}
    assert server.client.get(first["links"]["history"]).status_code == 200
    lose_history()
    assert server.client.post("/v1/gamuts", json=body).status_code == 201


def test_a_damaged_gamut_of_several_is_built_again_as_well(server, gamut, sphere, assert_problem):
    damaged = server.client.post("/v1/gamuts", json={"samples": sphere(seed=42)}).json()
    (record,) = server.data.rglob(f"published/*/{damaged['id']}.record")
    record.write_bytes(record.read_bytes()[:-9])
    address = f"/v1/comparisons?a={gamut['id']}&b={damaged['id']}&triangles=100"
    problem = assert_problem(server.client.get(address), 503, "gamut-rebuilding")
    job = problem["where"]["job"]
    # Who asks again before it is there is told the same, of it alone and of several.
    for again in (address, damaged["links"]["mesh"], damaged["links"]["self"]):
        answer = server.client.get(again)
        if answer.status_code != 200:
            assert_problem(answer, 503, "gamut-rebuilding")
    assert server.finished_job(job)["state"] == "succeeded"
    assert server.client.get(address).status_code == 200
    # Nobody is told so of what was deleted.
    assert server.client.delete(damaged["links"]["self"]).status_code == 204
    assert_problem(server.client.get(damaged["links"]["self"]), 404, "gamut-not-found")


def test_what_keeps_a_damaged_gamut_from_being_built_again_is_said_and_documented(
    small_server, sphere, slow_build, assert_problem
):
    server = small_server
    gamut = server.client.post("/v1/gamuts", json={"samples": sphere()}).json()
    (history,) = server.data.rglob(f"published/*/{gamut['id']}*.gamut")
    history.unlink()
    find_ready = {"Prefer": "respond-async"}
    running = server.client.post("/v1/gamuts", **slow_build(100_000), headers=find_ready)
    address = running.headers["location"]
    server.wait_for(lambda: server.client.get(address).json()["state"] == "running")
    waiting = server.client.post("/v1/gamuts", json={"samples": sphere(1)}, headers=find_ready)
    assert waiting.status_code == 202
    answer = server.client.get(gamut["links"]["self"])
    assert_problem(answer, 429, "queue-full")
    assert int(answer.headers["retry-after"]) >= 1
    described = server.client.get("/openapi.json").json()["paths"]["/v1/gamuts/{gamut_id}"]["get"]
    for code in ("queue-full", "storage-full", "shutting-down", "broker-unavailable"):
        assert f"`{code}`" in described["responses"][str(KINDS[code].status)]["description"]
    assert server.client.delete(address).status_code == 200
    assert server.finished_job(waiting.headers["location"])["state"] == "succeeded"
    assert_problem(server.client.get(gamut["links"]["self"]), 503, "gamut-rebuilding")
    assert server.finished_job(f"/v1/jobs/{gamut['id']}")["state"] == "succeeded"
    assert server.client.get(gamut["links"]["history"]).status_code == 200


def test_who_waits_for_a_gamut_that_others_delete_is_told_so(server, sphere, assert_problem):
    def deleted_at_once(seed):
        body = {"samples": sphere(seed, count=5000)}
        job = server.client.post("/v1/gamuts", json=body, headers={"Prefer": "respond-async"})
        waiting = threads.submit(server.client.post, "/v1/gamuts", json=body)
        while not waiting.done():
            server.client.delete(f"/v1/gamuts/{job.json()['id']}")
        return waiting.result()

    # Whether it is gone before or after the one who waits has looked at it is for chance to say.
    with concurrent.futures.ThreadPoolExecutor(1) as threads:
        for seed in range(60, 80):
            answer = deleted_at_once(seed)
            if answer.status_code not in {200, 201}:
                break
    assert_problem(answer, 409, "gamut-deleted")
