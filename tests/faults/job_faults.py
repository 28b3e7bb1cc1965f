"""Kill workers and services during builds, any number of times.

The functions raise AssertionError at the first broken promise. The servers are those of
``tests/service/servers.py``. The test suite calls the functions with small numbers. As a program::

    python tests/faults/job_faults.py --worker-kills 100 --service-kills 5 --damaged 25
"""

import argparse
import concurrent.futures
import contextlib
import json
import math
import os
import random
import re
import signal
import sys
import tempfile
import time
from pathlib import Path

import httpx
from stored_damage import every_damage_is_noticed

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


def kill_worker(server):
    """Kill the build worker that the log names last, if there is one."""
    with contextlib.suppress(ProcessLookupError):
        for worker in _WARM.findall(server.log())[-1:]:
            os.kill(int(worker), signal.SIGKILL)


def kill_both(server):
    """Kill the build worker and the service at the same time."""
    kill_worker(server)
    server.kill()


def accepted_jobs_finish(start_server, slow_build, *, kills, stops, both=0, jobs=2, seed=0):
    """Kill and stop services while builds run and wait; the last service must finish all builds.

    Kills and stops alternate, then services and their workers are killed at once. `jobs` builds
    wait or run at any time. A build has three attempts, so it may end after two kills.
    """
    chance = random.Random(seed)  # noqa: S311  # reproducible
    server = start_server(drain_seconds=1)
    ends = [how for pair in zip(["kill"] * kills, ["stop"] * stops, strict=False) for how in pair]
    ends += ["kill"] * (kills - stops) + ["stop"] * (stops - kills) + ["both"] * both
    waiting, addresses, attempts = [], [], 0
    for how in ends:
        while len(waiting) < jobs:
            waiting.append(accepted(server, slow_build(40_000 + 100 * len(addresses))))
            addresses.append(waiting[-1])
        job = come_to(server, waiting[0], random_moment(chance), attempts)
        attempts = job["attempts"]
        kill_both(server) if how == "both" else getattr(server, how)()
        server = start_server(server.data, drain_seconds=1)
        if job["finished"] or attempts >= 2:
            server.finished_job(waiting.pop(0))
            attempts = 0
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
            kill_worker(server)
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
            while True:
                answer = client.post("/v1/gamuts", **arguments, headers={"Prefer": "wait=300"})
                if answer.status_code != 429:
                    return answer
                # all clients have one address, of which few large bodies may arrive at once
                time.sleep(int(answer.headers["retry-after"]))

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


def sphere(seed):
    """Return a small body of a POST: colours of a sphere, which differ by seed."""
    chance = random.Random(seed)  # noqa: S311  # reproducible
    rays = [[chance.gauss() for _ in range(3)] for _ in range(300)]
    return {
        "samples": [
            [
                middle + 40 * part / math.hypot(*ray)
                for middle, part in zip((50, 0, 0), ray, strict=True)
            ]
            for ray in rays
        ]
    }


def main():
    """Run all checks and print the results."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--worker-kills", type=int, default=100)
    parser.add_argument("--service-kills", type=int, default=5)
    parser.add_argument("--both-kills", type=int, default=30)
    parser.add_argument("--clients", type=int, default=200)
    parser.add_argument("--damaged", type=int, default=25, help="gamuts; 4 files of each")
    parser.add_argument("--seed", type=int, default=0)
    wanted = parser.parse_args()
    sys.path.insert(0, str(Path(__file__).parents[1] / "service"))
    from servers import Server

    example = Path(__file__).parents[2] / "examples" / "FOGRA39L.ti3"

    def slow_build(surface_samples):
        options = {"surface_samples": surface_samples, "cost": "finest"}
        return {
            "files": {"file": (example.name, example.read_bytes())},
            "data": {"options": json.dumps(options)},
        }

    with tempfile.TemporaryDirectory() as folder, contextlib.ExitStack() as stack:

        def start(data=None, **settings):
            log = Path(tempfile.mkdtemp(dir=folder))
            server = Server(data or log / "data", log / "log", **settings)
            stack.callback(lambda: server.process.poll() is None and server.kill())
            return server

        kills = killed_workers_cost_time_only(
            start, slow_build, kills=wanted.worker_kills, seed=wanted.seed
        )
        print(f"{kills} kills of a worker during builds: all jobs completed")
        ends = accepted_jobs_finish(
            start,
            slow_build,
            kills=wanted.service_kills,
            stops=wanted.service_kills // 2,
            both=wanted.both_kills,
            seed=wanted.seed,
        )
        print(
            f"{ends} kills and stops of the service, {wanted.both_kills} of them with its worker: "
            "all accepted jobs completed"
        )
        server = start()
        identical_requests_are_one_build(server, slow_build(50_000), clients=wanted.clients)
        server.stop()
        print(f"{wanted.clients} identical requests at the same time: one build, identical bytes")
        bodies = [sphere(seed) for seed in range(wanted.damaged)]
        files = every_damage_is_noticed(start, bodies, seed=wanted.seed)
        print(f"{files} damaged files: all detected, counted and built again to the same bytes")


if __name__ == "__main__":
    main()
