"""A deployment as it is meant to be: two API replicas, two workers, Redis and a bucket, and kills.

The tests share the processes. From the loss of the broker on, one worker is left. A build that
something happens to waits at a gate, so that it is under way when that happens.
"""

import concurrent.futures
import dataclasses
import json
import re
import signal
import subprocess
import sys
from itertools import count

import httpx
import pytest
from cluster import GATED, PATIENCE, until
from prometheus_client.parser import text_string_to_metric_families

from service.jobs.book import JobDocument
from service.storage import blobs_at

SEEDS = count(1000)


class Deployment:
    """The processes, and what the tests do with them."""

    def __init__(self, cluster, blobs, sphere):
        self.cluster = cluster
        self.blobs = blobs
        self.sphere = sphere
        self.replicas = [cluster.api(), cluster.api()]
        self.workers = [cluster.worker(GATED), cluster.worker(GATED)]
        until(lambda: sum("is warm" in worker.log() for worker in self.workers) == 2)

    def quick(self):
        """What to post for a build of half a second that nobody has asked for yet."""
        return {"json": {"samples": self.sphere(seed=next(SEEDS))}}

    def post(self, replica, arguments, wait=0):
        prefer = f"wait={wait}" if wait else "respond-async"
        return replica.client.post("/v1/gamuts", **arguments, headers={"Prefer": prefer})

    def accepted(self, replica, arguments):
        """The id of a job that was just accepted."""
        answer = self.post(replica, arguments)
        assert answer.status_code == 202, answer.text
        return answer.json()["id"]

    def job(self, job_id, replica=None):
        answer = (replica or self.replicas[1]).client.get(f"/v1/jobs/{job_id}")
        assert answer.status_code == 200, answer.text
        return answer.json()

    def begun(self, job_id):
        """The worker that is building a job."""

        def builders():
            return [
                worker
                for worker in self.workers
                if worker.running and f"build of {job_id} started" in worker.log()
            ]

        (builder,) = until(builders)
        assert self.job(job_id)["state"] == "running"
        return builder

    def finished(self, job_id):
        return until(lambda: (job := self.job(job_id))["finished"] and job)

    def replace(self, worker):
        """Start a worker in the place of one that has ended."""
        place = self.workers.index(worker)
        self.workers[place] = self.cluster.worker(GATED)

    def stop_workers(self, but=None):
        """Stop all workers, or all but one."""
        for worker in self.workers:
            if worker is not but and worker.running:
                assert worker.stop() == 0, worker.log()

    def change(self, job_id, **fields):
        """Have time gone by for a job: its lease over, or its last sign of life long ago."""
        key = f"jobs/{job_id[:2]}/{job_id}.job"
        blob = self.blobs.read(key)
        changed = dataclasses.replace(JobDocument.from_bytes(blob.data), **fields)
        assert self.blobs.replace(key, changed.to_bytes(), blob.version)


@pytest.fixture(scope="module")
def deployment(cluster, s3, sphere):
    cluster.flush()
    cluster.environment["GAMUT_LOG_FORMAT"] = "json"
    with pytest.MonkeyPatch.context() as environment:
        for name, value in s3.items():
            environment.setenv(name, value)
        blobs = blobs_at(cluster.environment["GAMUT_STORE"])
        blobs.open()
    made = Deployment(cluster, blobs, sphere)
    yield made
    blobs.close()
    for process in [*made.replicas, *made.workers]:
        process.kill()
    cluster.flush()


def starts(deployment, job_id):
    return sum(worker.log().count(f"build of {job_id} started") for worker in deployment.workers)


def test_identical_requests_at_both_replicas_are_one_build_and_the_same_bytes(deployment):
    arguments = deployment.quick()
    with concurrent.futures.ThreadPoolExecutor(8) as pool:
        answers = list(
            pool.map(
                lambda number: deployment.post(deployment.replicas[number % 2], arguments, 300),
                range(8),
            )
        )
    assert {answer.status_code for answer in answers} <= {200, 201}, [a.text for a in answers]
    (gamut_id,) = {answer.json()["id"] for answer in answers}
    assert starts(deployment, gamut_id) == 1
    for path in ("history", "mesh?triangles=100"):
        one, other = (
            replica.client.get(f"/v1/gamuts/{gamut_id}/{path}") for replica in deployment.replicas
        )
        assert one.status_code == 200
        assert (one.content, one.headers["etag"]) == (other.content, other.headers["etag"])


def test_builds_are_seen_from_outside_at_whichever_worker_did_them(deployment):
    def succeeded():
        total = 0
        for worker in deployment.workers:
            answer = httpx.get(worker.figures, timeout=PATIENCE)
            for family in text_string_to_metric_families(answer.text):
                for sample in family.samples:
                    if sample.name == "gamut_builds_total":
                        assert sample.labels == {"outcome": "succeeded"}
                        total += sample.value
        return total

    before = succeeded()
    answer = deployment.replicas[0].client.post(
        "/v1/gamuts", **deployment.quick(), headers={"prefer": "wait=300"}
    )
    assert answer.status_code == 201
    until(lambda: succeeded() == before + 1)
    figures = httpx.get(deployment.workers[0].figures, timeout=PATIENCE).text
    memory = float(
        re.search(r"^gamut_worker_resident_memory_bytes (\S+)", figures, re.MULTILINE).group(1)
    )
    # of the process that builds, a child of the one that is told of
    assert memory > 150e6


def test_the_workers_of_this_host_answer_a_check(deployment):
    command = [sys.executable, "-m", "service", "worker", "--check"]
    environment = deployment.cluster.environment
    until(lambda: subprocess.run(command, env=environment, check=False).returncode == 0)


def test_a_build_that_one_replica_accepted_is_followed_and_cancelled_at_the_other(deployment):
    with deployment.cluster.closed_gate():
        job_id = deployment.accepted(deployment.replicas[0], deployment.quick())
        builder = deployment.begun(job_id)
        assert deployment.replicas[1].client.delete(f"/v1/jobs/{job_id}").status_code < 300
        assert deployment.job(job_id, deployment.replicas[0])["state"] == "cancelled"
        until(lambda: f"build of {job_id} cancelled" in builder.log())
    assert deployment.replicas[0].client.get(f"/v1/gamuts/{job_id}").status_code == 404


def test_the_queue_has_one_length_for_all_replicas(deployment, assert_problem):
    for worker in deployment.workers:
        worker.signal(signal.SIGSTOP)
    try:
        accepted = [
            deployment.accepted(deployment.replicas[number % 2], deployment.quick())
            for number in range(3)
        ]
        # What a suspended worker's connection has fetched already is waiting for nobody else.
        refused = []
        while len(refused) < 2 and len(accepted) < 8:
            replica = deployment.replicas[len(accepted + refused) % 2]
            answer = deployment.post(replica, deployment.quick())
            (accepted if answer.status_code == 202 else refused).append(answer)
        for answer in refused:
            assert_problem(answer, 429, "queue-full")
            assert int(answer.headers["retry-after"]) > 0
        assert len(refused) == 2
    finally:
        for worker in deployment.workers:
            worker.signal(signal.SIGCONT)
    ids = [each if isinstance(each, str) else each.json()["id"] for each in accepted]
    assert {deployment.finished(job_id)["state"] for job_id in ids} == {"succeeded"}


def test_a_flushed_broker_loses_no_job(deployment):
    for worker in deployment.workers:
        worker.signal(signal.SIGSTOP)
    try:
        # Each suspended worker has one in its connection already; of three, one at least is lost.
        ids = [deployment.accepted(deployment.replicas[0], deployment.quick()) for _ in range(3)]
        deployment.cluster.flush()
        for job_id in ids:
            deployment.change(job_id, updated="2020-01-01T00:00:00.000Z")
    finally:
        for worker in deployment.workers:
            worker.signal(signal.SIGCONT)
    assert {deployment.finished(job_id)["state"] for job_id in ids} == {"succeeded"}
    assert any("was lost and is sent again" in worker.log() for worker in deployment.workers)


def test_a_worker_that_is_killed_in_mid_build_costs_an_attempt_and_nothing_else(deployment):
    with deployment.cluster.closed_gate():
        job_id = deployment.accepted(deployment.replicas[0], deployment.quick())
        victim = deployment.begun(job_id)
        victim.kill()
    deployment.change(job_id, lease_until=0.0)
    deployment.replace(victim)
    job = deployment.finished(job_id)
    assert (job["state"], job["attempts"]) == ("succeeded", 2)


def test_a_worker_that_is_told_to_stop_gives_its_build_back(deployment):
    with deployment.cluster.closed_gate():
        job_id = deployment.accepted(deployment.replicas[0], deployment.quick())
        leaver = deployment.begun(job_id)
        assert leaver.stop() == 0, leaver.log()
        assert "is given back" in leaver.log()
    job = deployment.finished(job_id)
    assert (job["state"], job["attempts"]) == ("succeeded", 1)


def test_without_a_broker_gamuts_are_served_and_builds_refused(deployment, assert_problem):
    gamut_id = deployment.accepted(deployment.replicas[0], deployment.quick())
    assert deployment.finished(gamut_id)["state"] == "succeeded"
    deployment.cluster.broker.kill()
    replica = deployment.replicas[0]
    refused = deployment.post(replica, deployment.quick())
    assert_problem(refused, 503, "broker-unavailable")
    assert int(refused.headers["retry-after"]) > 0
    assert replica.client.get(f"/v1/gamuts/{gamut_id}/mesh?triangles=10").status_code == 200
    deployment.cluster.start_broker()
    answer = until(lambda: (a := deployment.post(replica, deployment.quick())).is_success and a, 30)
    assert deployment.finished(answer.json()["id"])["state"] == "succeeded"


@pytest.mark.parametrize("loss", ["stalls", "dies"])
def test_a_broker_that_is_lost_while_a_build_ends_costs_no_builder(deployment, loss):
    broker = deployment.cluster.broker
    with deployment.cluster.closed_gate():
        job_id = deployment.accepted(deployment.replicas[0], deployment.quick())
        builder = deployment.begun(job_id)
        deployment.stop_workers(but=builder)
        broker.signal(signal.SIGSTOP) if loss == "stalls" else broker.kill()
    until(lambda: f"build of {job_id} succeeded" in builder.log())
    broker.signal(signal.SIGCONT) if loss == "stalls" else deployment.cluster.start_broker()
    answer = until(
        lambda: (a := deployment.post(deployment.replicas[0], deployment.quick())).is_success and a
    )
    assert deployment.finished(answer.json()["id"])["state"] == "succeeded"
    assert answer.json()["id"] in builder.log()


def test_a_replica_that_accepted_a_build_may_be_lost(deployment):
    """The replica stays dead."""
    victim = deployment.replicas[0]
    with deployment.cluster.closed_gate():
        job_id = deployment.accepted(victim, deployment.quick())
        victim.kill()
    assert deployment.finished(job_id)["state"] == "succeeded"
    mesh = deployment.replicas[1].client.get(f"/v1/gamuts/{job_id}/mesh?triangles=10")
    assert mesh.status_code == 200


def test_every_line_of_the_log_is_json(deployment):
    """From start to stop, with a broker that was away meanwhile."""
    deployment.stop_workers()
    text = "".join(process.log() for process in [*deployment.replicas, *deployment.workers])
    strange = []
    for line in text.splitlines():
        try:
            members = json.loads(line)
        except ValueError:
            strange.append(line)
        else:
            assert {"time", "level", "logger", "message"} <= set(members)
    assert strange == []
    assert "is warm" in text
    assert "draining" in text


def test_a_worker_that_starts_builds_what_was_accepted_and_what_a_lost_broker_had(deployment):
    deployment.stop_workers()
    replica = deployment.replicas[1]
    lost = deployment.accepted(replica, deployment.quick())
    deployment.cluster.broker.kill()
    deployment.cluster.start_broker()
    answer = until(lambda: (a := deployment.post(replica, deployment.quick())).is_success and a)
    deployment.change(lost, updated="2020-01-01T00:00:00.000Z")
    deployment.replace(deployment.workers[0])
    for job_id in (answer.json()["id"], lost):
        assert deployment.finished(job_id)["state"] == "succeeded"
    assert f"message of {lost} was lost and is sent again" in deployment.workers[0].log()


HIDDEN = """
import os, re, sys, urllib.request
import encodings.idna, prometheus_client  # while root may
from service.building.process import hide_memory
from service.telemetry.metrics import serve_metrics
if os.getuid() == 0:
    os.setgid(65534)
    os.setuid(65534)
hide_memory()
_, port, stop = serve_metrics("127.0.0.1", 0)
with urllib.request.urlopen(f"http://127.0.0.1:{port}/metrics") as answer:
    print(*re.findall(r"^process_open_fds (.+)$", answer.read().decode(), re.MULTILINE))
stop()
"""


@pytest.mark.slow
def test_the_open_files_of_a_worker_that_hides_its_memory_are_counted():
    told = subprocess.run(
        [sys.executable, "-c", HIDDEN], check=True, capture_output=True, text=True
    )
    assert float(told.stdout) > 3
