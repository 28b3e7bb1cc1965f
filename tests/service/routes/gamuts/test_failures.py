"""Restarts, damaged files, and builds that take too long."""

import shutil


def test_what_was_built_outlives_a_power_cut(start_server, sphere):
    first = start_server()
    gamut = first.client.post("/v1/gamuts", json={"samples": sphere()}).json()
    mesh = first.client.get(gamut["links"]["mesh"]).content
    first.kill()
    second = start_server(data=first.data)
    assert second.client.get(gamut["links"]["self"]).json() == gamut
    assert second.client.get(gamut["links"]["mesh"]).content == mesh
    assert second.client.get(f"/v1/jobs/{gamut['id']}").json()["state"] == "succeeded"
    second.wait_ready()
    assert second.client.post("/v1/gamuts", json={"samples": sphere()}).status_code == 200
    second.stop()


def test_damaged_files_are_never_served_and_built_again(
    server, start_server, sphere, assert_problem, tmp_path
):
    bodies = [{"samples": sphere(seed)} for seed in range(50, 54)]
    gamuts = [server.client.post("/v1/gamuts", json=body).json() for body in bodies]
    meshes = [server.client.get(gamut["links"]["mesh"]).content for gamut in gamuts]
    # What is acknowledged is on the disk: what the server has written so far is a whole store.
    data = tmp_path / "data"
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
    second = start_server(data)
    for gamut, mesh in zip(gamuts, meshes, strict=True):
        answer = second.client.get(gamut["links"]["mesh"])
        problem = assert_problem(answer, 503, "gamut-rebuilding")
        assert int(answer.headers["retry-after"]) >= 1
        assert second.finished_job(problem["where"]["job"])["state"] == "succeeded"
        assert second.client.get(gamut["links"]["mesh"]).content == mesh
        assert second.client.get(gamut["links"]["history"]).status_code == 200
    assert len(list((data / "quarantine").iterdir())) >= 4
    second.stop()


def test_a_build_beyond_its_deadline_is_a_problem(start_server, slow_build, sphere, assert_problem):
    server = start_server(build_timeout=0.5)
    server.wait_ready()
    answer = server.client.post("/v1/gamuts", **slow_build())
    assert_problem(answer, 422, "build-timeout")
    server.worker(2)
    assert server.client.post("/v1/gamuts", json={"samples": sphere()}).status_code == 201
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
