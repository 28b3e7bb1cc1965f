"""Clients with waiting builds take turns at the workers of a broker as well."""

import pytest

from service.broker.celery_app import BrokerUnavailableError
from service.broker.celery_worker import Worker
from service.jobs.book import JobBook
from service.settings import Settings
from service.storage.gamut_store import GamutStore
from service.storage.local import LocalBlobs


class Messages:
    """A broker whose messages a test looks at."""

    def __init__(self):
        self.left = []
        self.accepts = True

    def waiting(self):
        return len(self.left)

    def send(self, job_id):
        if not self.accepts:
            raise BrokerUnavailableError
        self.left.append(job_id)


class Deployment:
    """Two workers with one thread each, and the jobs of some clients."""

    def __init__(self, store, command):
        self.store = store
        self.book = JobBook(store.blobs)
        self.broker = Messages()
        self.workers = [Worker(Settings(), store, self.broker, command=command) for _ in range(2)]
        self.clients = {}

    def post(self, client):
        job_id = f"{len(self.clients):064x}"
        self.clients[job_id] = client
        self.book.accept(job_id, {"gamma": 1}, client=client)
        self.store.keep_input(job_id, b"build", {"gamma": 1})
        self.workers[0].outbox.mark(job_id)
        self.broker.send(job_id)
        return job_id

    def work(self, worker=0):
        """Take a message, and return the client whose job was run; None if none was."""
        outcome = self.workers[worker].run(self.broker.left.pop(0))
        assert self.waiting() <= set(self.broker.left)
        return self.clients[outcome.document.id] if outcome.built else None

    def work_off(self, workers=1):
        """Take all messages, with the workers in turn, and return the clients as `work` does."""
        turns = []
        while self.broker.left:
            turns.append(self.work(len(turns) % workers))
        assert self.waiting() == set()
        assert self.workers[0].outbox.count() == 0
        return [client for client in turns if client is not None]

    def waiting(self):
        return {job_id for job_id in self.clients if not self.book.read(job_id).final}


@pytest.fixture
def deployment(tmp_path, scripted_worker):
    store = GamutStore(LocalBlobs(tmp_path / "store"))
    store.open()
    made = Deployment(store, scripted_worker)
    yield made
    for worker in made.workers:
        worker.close()
    store.close()


def test_the_queue_of_one_client_delays_others_by_one_build(deployment):
    for _ in range(4):
        deployment.post("busy")
    assert deployment.work() == "busy"
    deployment.post("late")
    deployment.post("later")
    turns = deployment.work_off()
    assert sorted(turns[:3]) == ["busy", "late", "later"]
    assert turns[3:] == ["busy", "busy"]


def test_the_workers_take_what_the_others_have_left(deployment):
    for client in ("busy", "busy", "busy", "late", "busy", "later"):
        deployment.post(client)
    turns = deployment.work_off(workers=2)
    assert sorted(turns) == ["busy"] * 4 + ["late", "later"]
    # Each worker may begin with the client that came first.
    assert {"late", "later"} < set(turns[:5])


def test_a_cancelled_job_costs_nobody_a_turn(deployment):
    deployment.post("busy")
    deployment.post("busy")
    assert deployment.work() == "busy"
    cancelled = deployment.post("late")
    deployment.post("late")
    deployment.book.request_cancel(cancelled)
    assert sorted(deployment.work_off()) == ["busy", "late"]


def test_a_broker_that_accepts_no_message_gets_jobs_run_in_its_own_order(deployment):
    for client in ("busy", "busy", "busy", "late"):
        deployment.post(client)
    deployment.broker.accepts = False
    assert deployment.work_off() == ["busy", "busy", "busy", "late"]
