import concurrent.futures
import contextlib
import hashlib
import json
import re
import socket
import sys
from pathlib import Path

from gamutcore import Options
from gamutcore.building import STAGES, gamut_id
from service.application import create_app
from service.settings import Settings

# The tests' folders are no packages.
sys.path.insert(0, str(Path(__file__).parents[2] / "faults"))
from job_faults import identical_requests_are_one_build

UNKNOWN = "0" * 64


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
    # a number of samples of its own: what others built on the same server would be there already
    address = posted(server, slow_build(8000))
    stages = []

    def finished():
        answer = server.client.get(address)
        job = answer.json()
        assert 0 <= job["fraction"] <= 1
        if job["state"] == "running" and job["stage"]:
            stages.append(job["stage"])
        assert ("retry-after" in answer.headers) == (job["finished"] is None)
        return job["state"] == "succeeded"

    server.wait_for(finished)
    assert stages
    assert sorted(stages, key=[*STAGES, "encoding"].index) == stages


# --- events ---------------------------------------------------------------------------------------


def parsed(text):
    """The events of a stream."""
    found = []
    for block in text.split("\n\n"):
        fields = dict(line.split(": ", 1) for line in block.splitlines() if line[0] != ":")
        if "data" in fields:
            found.append(fields)
    return found


def events(server, address, **headers):
    """All events of a stream, which has to end by itself."""
    with server.client.stream("GET", f"{address}/events", headers=headers) as answer:
        assert answer.headers["content-type"].startswith("text/event-stream")
        assert answer.headers["cache-control"] == "no-store"
        return parsed("".join(answer.iter_text()))


def posted(server, arguments):
    answer = server.client.post("/v1/gamuts", **arguments, headers={"Prefer": "respond-async"})
    assert answer.status_code == 202
    assert answer.headers["preference-applied"] == "respond-async"
    assert int(answer.headers["retry-after"]) >= 1
    return answer.headers["location"]


def test_a_build_is_followed_to_its_end_by_several(server, slow_build):
    address = posted(server, slow_build(16_000))
    with concurrent.futures.ThreadPoolExecutor(5) as threads:
        streams = list(threads.map(lambda _: events(server, address), range(5)))
    for stream in streams:
        *progress, last = stream
        assert {event["event"] for event in progress} == {"progress"}
        assert last["event"] == "finished"
        assert json.loads(last["data"]) == server.client.get(address).json()
        assert json.loads(last["data"])["state"] == "succeeded"
        stages = {json.loads(event["data"])["stage"] for event in progress}
        assert stages & {"colours", "boundary", "decimation", "metric"}
        assert len({event["id"] for event in stream}) == len(stream)
    known = {"Last-Event-ID": streams[0][-1]["id"]}
    assert server.client.get(f"{address}/events", headers=known).status_code == 204
    known = {"Last-Event-ID": streams[0][0]["id"]}
    assert [event["event"] for event in events(server, address, **known)] == ["finished"]


def test_a_finished_job_has_one_event(server, gamut, assert_problem):
    (event,) = events(server, f"/v1/jobs/{gamut['id']}")
    assert event["event"] == "finished"
    assert server.client.head(f"/v1/jobs/{gamut['id']}/events").status_code == 200
    assert_problem(server.client.get(f"/v1/jobs/{UNKNOWN}/events"), 404, "job-not-found")


def test_streams_are_bounded(filled_store, request_app, assert_problem):
    app = create_app(Settings(store=str(filled_store.blobs.directory)))
    address = f"/v1/jobs/{next(filled_store.ids())}"
    service = app.state.service
    with contextlib.ExitStack() as streams:
        for _ in range(256):
            assert not service.events.full
            streams.enter_context(service.events.one())
        refused = request_app(app, "GET", f"{address}/events")
        assert_problem(refused, 429, "too-many-streams")
        assert int(refused.headers["retry-after"]) >= 1
        # polling is the contract, and goes on
        assert request_app(app, "GET", address).status_code == 200
    assert request_app(app, "GET", f"{address}/events").status_code == 200


def test_streams_of_clients_that_leave_are_closed(small_server, slow_build):
    server = small_server
    address = posted(server, slow_build())

    def count():
        metrics = server.client.get("/metrics").text
        return int(float(re.search(r"^gamut_event_streams (\S+)", metrics, re.MULTILINE).group(1)))

    with server.client.stream("GET", f"{address}/events") as answer:
        chunks = answer.iter_raw()  # without a name it would be closed, and the connection with it
        next(chunks)
        assert count() == 1
    server.wait_for(lambda: count() == 0)
    assert server.client.delete(address).status_code == 200


# --- cancel ---------------------------------------------------------------------------------------


def test_a_cancelled_build_ends_at_once_for_all_and_can_be_asked_for_again(
    server, slow_build, assert_problem
):
    arguments = slow_build(90_000)
    options = Options.from_mapping(json.loads(arguments["data"]["options"]))
    _, content = arguments["files"]["file"]
    address = f"/v1/jobs/{gamut_id(options, hashlib.sha256(content).hexdigest())}"
    with concurrent.futures.ThreadPoolExecutor(1) as threads:
        waiting = threads.submit(server.client.post, "/v1/gamuts", **arguments)
        server.wait_for(lambda: server.client.get(address).json().get("state") == "running")
        with server.client.stream("GET", f"{address}/events") as answer:
            chunks = answer.iter_text()
            text = next(chunks)
            for _ in range(2):
                cancelled = server.client.delete(address)
                assert (cancelled.status_code, cancelled.json()["state"]) == (200, "cancelled")
            text += "".join(chunks)
        assert_problem(waiting.result(), 409, "build-cancelled")
    assert json.loads(parsed(text)[-1]["data"])["state"] == "cancelled"
    assert server.client.get(address).json()["problem"]["code"] == "build-cancelled"
    assert_problem(server.client.get(f"/v1/gamuts/{address[-64:]}"), 404, "gamut-not-found")
    assert posted(server, arguments) == address
    assert server.client.get(address).json()["state"] in {"queued", "running"}
    assert server.client.delete(address).status_code == 200


def test_what_is_over_cannot_be_cancelled(server, gamut, assert_problem):
    problem = assert_problem(server.client.delete(f"/v1/jobs/{gamut['id']}"), 409, "job-finished")
    assert problem["where"] == {"state": "succeeded"}
    assert_problem(server.client.delete(f"/v1/jobs/{UNKNOWN}"), 404, "job-not-found")
    assert server.client.get(gamut["links"]["self"]).status_code == 200


# --- admission ------------------------------------------------------------------------------------


def test_a_full_queue_refuses_before_the_body_and_lets_in_what_needs_no_place(
    small_server, slow_build, sphere, assert_problem
):
    server = small_server
    built = {"samples": sphere(seed=70)}
    assert server.client.post("/v1/gamuts", json=built).status_code == 201
    running, waiting = slow_build(80_000), slow_build(79_000)
    addresses = [posted(server, running)]
    server.wait_for(lambda: server.client.get(addresses[0]).json()["state"] == "running")
    addresses.append(posted(server, waiting))
    refused = server.client.post("/v1/gamuts", json={"samples": sphere(seed=71)})
    assert_problem(refused, 429, "queue-full")
    assert int(refused.headers["retry-after"]) >= 1
    # identical requests and gamuts that are there need no place
    assert posted(server, waiting) == addresses[1]
    assert server.client.post("/v1/gamuts", json=built).status_code == 200

    # of a large body nothing has to arrive
    host, port = server.url.removeprefix("http://").split(":")
    with socket.create_connection((host, int(port)), timeout=600) as connection:
        connection.sendall(
            b"POST /v1/gamuts HTTP/1.1\r\nHost: localhost\r\nContent-Type: multipart/form-data; "
            b"boundary=b\r\nContent-Length: 100000000\r\n\r\n"
        )
        assert connection.recv(1000).startswith(b"HTTP/1.1 429 ")
    for address in addresses:
        server.client.delete(address)


def test_200_identical_requests_are_one_build_and_one_answer(server, slow_build):
    identical_requests_are_one_build(server, slow_build(9000), clients=200)
