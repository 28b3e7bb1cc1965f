"""Kill workers and services during builds, any number of times.

The functions raise AssertionError at the first broken promise. The servers are those of
``tests/service/servers.py``. The test suite calls the functions with small numbers, and
`make faults` with large ones.
"""

import concurrent.futures
import contextlib
import os
import random
import re
import signal

import httpx

from gamutcore.building import STAGES

_WARM = re.compile(r"build worker (\d+) is warm")


def accepted(server, arguments):
    """Post a build and return the address of its job."""
    answer = server.client.post("/v1/gamuts", **arguments, headers={"Prefer": "respond-async"})
    assert answer.status_code == 202, answer.text
    return answer.headers["location"]


def random_moment(chance):
    """Return a stage and a fraction of it, so that no kill depends on how fast a build is."""
    return chance.randrange(len(STAGES)), chance.uniform(0, 0.9)


def come_to(server, address, moment, attempts=0):
    """Wait for a moment of an attempt after so many, or for the end; return the job's document."""

    def found():
        job = server.client.get(address).json()
        stages = [*STAGES, "encoding"]
        place = stages.index(job["stage"]) if job["stage"] in stages else -1
        there = job["attempts"] > attempts and (place, job["fraction"]) >= moment
        return job if there or job["finished"] else None

    return server.wait_for(found)


def accepted_jobs_finish(start_server, slow_build, *, kills, stops, jobs=2, seed=0):
    """Kill and stop services while builds run and wait; the last service must finish all builds.

    Kills and stops alternate. Each kill during a build costs that build one attempt, so the number
    of attempts must exceed the number of kills.
    """
    chance = random.Random(seed)  # noqa: S311  # reproducible
    server = start_server(build_attempts=10, drain_seconds=1)
    addresses = [accepted(server, slow_build(40_000 + 1000 * number)) for number in range(jobs)]
    ends = [how for pair in zip(["kill"] * kills, ["stop"] * stops, strict=False) for how in pair]
    ends += ["kill"] * (kills - stops) + ["stop"] * (stops - kills)
    for how in ends:
        unfinished = [each for each in addresses if not server.client.get(each).json()["finished"]]
        come_to(server, (unfinished or addresses)[0], random_moment(chance))
        getattr(server, how)()
        server = start_server(server.data, build_attempts=10, drain_seconds=1)
    for address in addresses:
        job = server.finished_job(address)
        assert job["state"] == "succeeded", job
        mesh = server.client.get(f"{job['links']['gamut']}/mesh", params={"triangles": 100})
        assert mesh.status_code == 200
    server.stop()
    return len(ends)


def killed_workers_cost_time_only(start_server, slow_build, *, kills, per_job=2, seed=0):
    """Kill the worker during builds; every job must succeed.

    A job has three attempts, so it survives two kills.
    """
    chance = random.Random(seed)  # noqa: S311  # reproducible
    server = start_server()
    server.wait_ready()
    killed = 0
    number = 0
    while killed < kills:
        address = accepted(server, slow_build(40_000 + number))
        number += 1
        attempts = 0
        for _ in range(min(per_job, kills - killed)):
            job = come_to(server, address, random_moment(chance), attempts)
            if job["finished"]:
                break
            with contextlib.suppress(ProcessLookupError):
                os.kill(int(_WARM.findall(server.log())[-1]), signal.SIGKILL)
            killed += 1
            attempts = job["attempts"]
        job = server.finished_job(address)
        assert job["state"] == "succeeded", job
    server.stop()
    return killed


def identical_requests_are_one_build(server, arguments, *, clients):
    """Post identical requests at the same time; there must be one build, one answer, one mesh."""
    limits = httpx.Limits(max_connections=clients)

    with httpx.Client(base_url=server.url, timeout=900, limits=limits) as client:

        def post(_):
            return client.post("/v1/gamuts", **arguments, headers={"Prefer": "wait=300"})

        with concurrent.futures.ThreadPoolExecutor(clients) as threads:
            answers = list(threads.map(post, range(clients)))
            assert {answer.status_code for answer in answers} <= {200, 201}
            assert len({answer.content for answer in answers}) == 1
            gamut = answers[0].json()
            meshes = set(
                threads.map(lambda _: client.get(gamut["links"]["mesh"]).content, range(8))
            )
    assert len(meshes) == 1
    assert server.builds_started(gamut["id"]) == 1
