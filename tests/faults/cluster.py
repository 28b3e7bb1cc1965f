"""Kill the parts of a deployment repeatedly and check its promises.

The deployment has API replicas, workers, Redis and an S3 server on this machine.

- ``--posts``: identical requests at the same time, spread over the replicas, must give one build
  and the same bytes.
- ``--kills``: workers are killed during builds, and every tenth time also the replica that accepted
  the build. Every accepted build must succeed, and its bytes must match their entity tag.
- ``--builds``: builds in a row, as fast as the workers go.

The program exits with 1 at the first broken promise.
"""

import argparse
import concurrent.futures
import hashlib
import itertools
import json
import random
import sys
import tempfile
import time
from pathlib import Path
from statistics import mean

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tests" / "service"))

from cluster import Cluster, until  # noqa: E402
from emulators import s3_server  # noqa: E402

PRESS = ROOT / "examples" / "FOGRA39L.ti3"

LEASE, RESEND = 5, 3
SETTINGS = {"build_queue": 1000, "drain_seconds": 5}


class BrokenPromiseError(Exception):
    """The service broke a promise."""


def require(condition, promise):
    """Raise if a promise is broken."""
    if not condition:
        raise BrokenPromiseError(promise)


class Run:
    """A run over one deployment."""

    def __init__(self, cluster, replicas, workers, seed):
        self.cluster = cluster
        self.chance = random.Random(seed)  # noqa: S311 - reproducible
        self.count = 0
        self.replicas = [cluster.api() for _ in range(replicas)]
        self.workers = [cluster.worker() for _ in range(workers)]
        until(lambda: all("is warm" in worker.log() for worker in self.workers))

    def arguments(self, samples=30_000):
        """Return the arguments of a POST for a new gamut."""
        self.count += 1
        options = {"gamma": 0.2 + 1e-6 * self.count, "surface_samples": samples}
        return {
            "files": {"file": (PRESS.name, PRESS.read_bytes())},
            "data": {"options": json.dumps(options)},
        }

    def post(self, replica, arguments, prefer):
        answer = replica.client.post("/v1/gamuts", **arguments, headers={"Prefer": prefer})
        require(answer.status_code in {200, 201, 202}, f"POST: {answer.status_code} {answer.text}")
        return answer

    def submit(self, replica, samples=30_000):
        """Return the job of a new build."""
        return self.post(replica, self.arguments(samples), "respond-async").json()["id"]

    def job(self, job_id):
        answer = self.chance.choice(self.replicas).client.get(f"/v1/jobs/{job_id}")
        require(answer.status_code == 200, f"an accepted job is unknown: {answer.text}")
        return answer.json()

    def wait_for_success(self, job_id):
        job = until(lambda: (j := self.job(job_id))["finished"] and j)
        require(job["state"] == "succeeded", f"an accepted build failed: {job}")
        return job

    def builder(self, job_id):
        """Return the worker that started the job last."""
        until(lambda: self.job(job_id)["state"] == "running")
        return max(self.workers, key=lambda each: each.log().rfind(f"build of {job_id} started"))

    def check_history(self, gamut_id):
        """Return the history, after checking the entity tag and that all replicas agree."""
        contents = set()
        for replica in self.replicas:
            answer = replica.client.get(f"/v1/gamuts/{gamut_id}/history")
            require(answer.status_code == 200, f"a finished gamut is missing: {answer.text}")
            digest = hashlib.sha256(answer.content).hexdigest()
            require(digest in answer.headers["etag"], "a body does not match its tag")
            contents.add(answer.content)
        require(len(contents) == 1, "replicas answer with different bytes")
        return contents.pop()

    def post_identical(self, posts):
        """Post identical requests at the same time and return the number of builds."""
        arguments = self.arguments()
        with concurrent.futures.ThreadPoolExecutor(min(posts, 64)) as pool:
            replicas = itertools.islice(itertools.cycle(self.replicas), posts)
            answers = list(pool.map(lambda each: self.post(each, arguments, "wait=120"), replicas))
        (gamut_id,) = {answer.json()["id"] for answer in answers}
        self.check_history(gamut_id)
        built = sum(each.log().count(f"build of {gamut_id} started") for each in self.workers)
        require(built == 1, f"{posts} identical requests were built {built} times")
        return built

    def kill_worker(self):
        """Kill the worker of a build; return the seconds until another worker resumes it."""
        replica = self.chance.randrange(len(self.replicas))
        job_id = self.submit(self.replicas[replica], 100_000)
        victim = self.builder(job_id)
        fraction = self.chance.uniform(0, 0.8)
        until(lambda: (j := self.job(job_id))["finished"] or j["fraction"] >= fraction)
        before = self.job(job_id)
        victim.kill()
        clock = time.monotonic()
        self.workers[self.workers.index(victim)] = self.cluster.worker()
        if self.count % 10 == 0:
            self.replicas[replica].kill()
            self.replicas[replica] = self.cluster.api()
        if before["finished"]:
            waited = 0.0
        else:
            until(lambda: (j := self.job(job_id))["finished"] or j["attempts"] > 1)
            waited = time.monotonic() - clock
        self.wait_for_success(job_id)
        self.check_history(job_id)
        return waited

    def build_rate(self, builds):
        """Return the builds per second of all workers together."""
        clock = time.monotonic()
        replicas = itertools.islice(itertools.cycle(self.replicas), builds)
        for job_id in [self.submit(each) for each in replicas]:
            self.wait_for_success(job_id)
        return builds / (time.monotonic() - clock)


def main():
    """Run all checks and return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__)
    numbers = {"replicas": 3, "workers": 2, "posts": 200, "kills": 100, "builds": 20, "seed": 0}
    for name, number in numbers.items():
        parser.add_argument(f"--{name}", type=int, default=number)
    given = parser.parse_args()
    if reason := Cluster.missing():
        print(reason)
        return 1
    with tempfile.TemporaryDirectory(prefix="gamut-cluster-") as folder:
        folders = [Path(folder) / name for name in ("s3", "cluster")]
        for each in folders:
            each.mkdir()
        with s3_server(folders[0]) as environment:
            cluster = Cluster(folders[1], environment, lease=LEASE, resend=RESEND, **SETTINGS)
            try:
                check(Run(cluster, given.replicas, given.workers, given.seed), given)
            except BrokenPromiseError as error:
                print(f"BROKEN: {error}", flush=True)
                return 1
            finally:
                cluster.close()
    return 0


def check(run, given):
    """Run the checks that are asked for and print their figures."""
    if given.posts:
        built = run.post_identical(given.posts)
        what = f"identical requests at the same time, {given.replicas} replicas"
        print(f"{what}: {built} build ({given.posts} requests)", flush=True)
    if given.builds:
        what = "builds of 30,000 surface samples, all workers together"
        rate = run.build_rate(given.builds)
        print(f"{what}: {rate:.2f} per second ({given.builds} builds)", flush=True)
    if not given.kills:
        return
    waits = []
    for number in range(given.kills):
        waits.append(run.kill_worker())
        print(f"kill {number + 1} of {given.kills}: {waits[-1]:.1f} s", flush=True)
    print(f"builds lost or damaged by killing their workers: 0 ({given.kills} kills)")
    what = f"a killed build resumes on another worker (lease {LEASE} s) after"
    waited = f"{mean(waits):.1f} s, at most {max(waits):.1f} s"
    print(f"{what}: {waited} ({given.kills} kills)", flush=True)


if __name__ == "__main__":
    sys.exit(main())
