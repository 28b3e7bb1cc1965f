def test_it_lives_and_is_ready(server):
    live = server.client.get("/livez")
    assert (live.status_code, live.text) == (200, "live\n")
    ready = server.client.get("/readyz")
    assert ready.status_code == 200
    assert ready.json()["workers_warm"] == ready.json()["workers"] == 1
    assert {probe["status"] for probe in ready.json()["probes"].values()} == {"ok"}
    for answer in (live, ready):
        assert answer.headers["cache-control"] == "no-store"


def test_what_is_wrong_is_named_until_it_is_mended(start_server, assert_problem, sphere):
    server = start_server()
    answer = server.client.get("/readyz")
    document = assert_problem(answer, 503, "not-ready")
    assert int(answer.headers["retry-after"]) > 0
    assert document["where"]["workers"] == 1
    assert document["where"]["ready"] is False
    assert document["where"]["probes"]["workers"]["status"] == "failed"
    assert "workers: " in document["detail"]
    assert server.client.get("/livez").status_code == 200
    server.wait_ready()

    temporary = server.data / "temporary"
    moved = temporary.rename(server.data / "elsewhere")
    answer = server.wait_for(
        lambda: (answer := server.client.get("/readyz")).status_code == 503 and answer
    )
    document = assert_problem(answer, 503, "not-ready")
    assert document["where"]["probes"]["store"]["status"] == "failed"
    assert str(server.data) not in answer.text
    assert server.client.get("/livez").status_code == 200
    body = {"samples": sphere(seed=70)}
    assert_problem(server.client.post("/v1/gamuts", json=body), 503, "store-unavailable")
    moved.rename(temporary)
    server.wait_ready()
    assert server.client.post("/v1/gamuts", json=body).status_code == 201
    server.stop()
