def test_it_lives_and_is_ready(server):
    live = server.client.get("/livez")
    assert (live.status_code, live.text) == (200, "live\n")
    ready = server.client.get("/readyz")
    assert ready.status_code == 200
    assert ready.json()["workers_warm"] == ready.json()["workers"] == 1
    for answer in (live, ready):
        assert answer.headers["cache-control"] == "no-store"


def test_it_lives_before_it_is_ready(start_server, assert_problem):
    server = start_server(build_workers=2)
    document = assert_problem(server.client.get("/readyz"), 503, "not-ready")
    assert document["where"]["workers"] == 2
    assert document["where"]["ready"] is False
    assert server.client.get("/livez").status_code == 200
    server.wait_ready()
    server.stop()
