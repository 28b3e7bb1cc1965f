"""The figures over a real connection, as Prometheus asks for them."""

import asyncio
import os
import re
import signal
import threading
from concurrent.futures import ThreadPoolExecutor

import httpx
from prometheus_client.openmetrics.parser import (
    text_string_to_metric_families as openmetrics_families,
)
from prometheus_client.parser import text_string_to_metric_families as text_families

from gamutcore.building import STAGES
from service.application import create_app
from service.settings import Settings

WARM = re.compile(r"build worker (\d+) is warm")


def samples(families):
    return {
        (sample.name, tuple(sorted(sample.labels.items()))): sample.value
        for family in families
        for sample in family.samples
    }


def figures(server):
    return samples(text_families(server.client.get("/metrics").text))


def test_requests_answered_ahead_of_the_routes_are_counted_like_others(server, gamut):
    def counted(route, status):
        labels = (("method", "GET"), ("route", f"/v1/gamuts/{route}"), ("status", str(status)))
        return figures(server).get(("gamut_http_requests_total", labels), 0)

    mesh, file = "{gamut_id}/mesh", "{gamut_id}/mesh.{suffix}"
    before = counted(mesh, 200), counted(file, 200), counted(mesh, 304), counted(mesh, 422)
    address = gamut["links"]["mesh"]
    first = server.client.get(f"{address}?triangles=100")
    for _ in range(4):
        server.client.get(f"{address}?triangles=100")
    server.client.get(f"{address}.ply?triangles=100")
    server.client.get(f"{address}?triangles=100", headers={"if-none-match": first.headers["etag"]})
    server.client.get(f"{address}?triangles=3")
    after = counted(mesh, 200), counted(file, 200), counted(mesh, 304), counted(mesh, 422)
    assert [end - begin for begin, end in zip(before, after, strict=True)] == [5, 1, 1, 1]


def test_hits_of_the_cache_are_counted(server, gamut):
    meshes = (("cache", "meshes"),)
    address = f"{gamut['links']['mesh']}?triangles=102"
    server.client.get(address)
    before = figures(server)
    for _ in range(10):
        server.client.get(address)
    after = figures(server)
    hits = ("gamut_cache_hits_total", meshes)
    misses = ("gamut_cache_misses_total", meshes)
    assert after[hits] - before[hits] == 10
    assert after[misses] == before[misses]


def test_the_worker_process_is_told_beside_the_service(server):
    found = figures(server)
    assert found["gamut_worker_processes", ()] >= 1
    assert found["gamut_worker_resident_memory_bytes", ()] > 50_000_000
    assert found["process_resident_memory_bytes", ()] > 50_000_000
    assert found["gamut_build_workers_warm", ()] == found["gamut_build_workers", ()] == 1


def test_openmetrics_is_sent_to_who_asks_for_it(server):
    accept = "application/openmetrics-text;version=1.0.0,text/plain;q=0.5"
    answer = server.client.get("/metrics", headers={"accept": accept})
    assert answer.headers["content-type"].startswith("application/openmetrics-text; version=1.0.0")
    assert answer.headers["cache-control"] == "no-store"
    assert answer.headers["vary"] == "Accept"
    assert samples(openmetrics_families(answer.text))


def test_what_the_worker_did_arrives(server, sphere, slow_build):
    """Builds are done by another process; the next worker's are added to those of a dead one."""

    def busy(found):
        return found["gamut_builds_running", ()] + found["gamut_builds_queued", ()]

    before = server.wait_for(lambda: (found := figures(server)) and not busy(found) and found)

    def more(name, **labels):
        key = (name, tuple(labels.items()))
        return figures(server)[key] - before.get(key, 0)

    gamuts = [
        server.client.post("/v1/gamuts", json={"samples": sphere(seed=seed)}) for seed in (851, 852)
    ]
    assert [gamut.status_code for gamut in gamuts] == [201, 201]
    flat = {"samples": [[50, a, b] for a in range(4) for b in range(4)]}
    refused = server.client.post("/v1/gamuts", json=flat)
    assert refused.status_code == 422
    assert more("gamut_builds_total", outcome="succeeded") == 2
    assert more("gamut_builds_total", outcome=refused.json()["code"]) == 1
    for stage in STAGES:
        assert more("gamut_build_stage_seconds_count", stage=stage) >= 2
        assert more("gamut_build_stage_seconds_sum", stage=stage) > 0
    stages = sum(more("gamut_build_stage_seconds_sum", stage=stage) for stage in STAGES)
    assert more("gamut_build_seconds_count") == 3
    assert more("gamut_build_seconds_sum") >= stages

    # a worker that dies is seen, and so is the one that takes its place
    accepted = server.client.post(
        "/v1/gamuts", **slow_build(20_000), headers={"prefer": "respond-async"}
    )
    address = accepted.headers["location"]
    server.wait_for(lambda: server.client.get(address).json()["stage"] in STAGES)
    assert figures(server)["gamut_builds_running", ()] == 1
    os.kill(int(WARM.findall(server.log())[-1]), signal.SIGKILL)
    assert server.finished_job(address)["state"] == "succeeded"
    assert more("gamut_builds_total", outcome="crashed") == 1
    assert more("gamut_builds_total", outcome="succeeded") == 3
    assert more("gamut_build_worker_starts_total") == 1
    assert figures(server)["gamut_worker_processes", ()] >= 1


def test_figures_are_told_while_all_shared_threads_wait_for_the_store(tmp_path):
    answers = threading.Event()

    async def scenario():
        loop = asyncio.get_running_loop()
        loop.set_default_executor(ThreadPoolExecutor(1))
        waiting = loop.run_in_executor(None, answers.wait)
        transport = httpx.ASGITransport(create_app(Settings(store=str(tmp_path))))
        try:
            async with httpx.AsyncClient(transport=transport, base_url="http://[::1]") as client:
                answer = await asyncio.wait_for(client.get("/metrics"), 120)
        finally:
            answers.set()
        await waiting
        assert answer.status_code == 200

    asyncio.run(scenario())
