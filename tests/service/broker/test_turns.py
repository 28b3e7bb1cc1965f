"""Clients with waiting builds take turns at the workers of a broker as well."""

import pytest

from service.broker.celery_worker import Slot
from service.building.job_runner import JobRunner
from service.jobs.book import JobBook
from service.settings import Settings
from service.storage.gamuts import GamutStore
from service.storage.local import LocalBlobs


class Messages:
    """A broker with some messages."""

    def __init__(self):
        self.left = []

    def waiting(self):
        return len(self.left)

    def send(self, job_id):
        self.left.append(job_id)


@pytest.fixture
def slot(tmp_path, scripted_worker):
    store = GamutStore(LocalBlobs(tmp_path / "store"))
    store.open()
    made = Slot(Settings(), store, Messages())
    book = JobBook(store.blobs)
    made.runner = JobRunner(Settings(), store, book, command=scripted_worker)
    yield made, store, book
    made.runner.close()
    store.close()


def test_messages_are_permits_and_the_clients_of_waiting_jobs_take_turns(slot):
    made, store, book = slot
    names = {}

    def post(client):
        job_id = f"{len(names):064x}"
        names[job_id] = client
        book.accept(job_id, {"gamma": 1}, client=client)
        store.keep_input(job_id, b"build", {"gamma": 1})
        made.outbox.mark(job_id)
        made._broker.send(job_id)

    def work():
        outcome = made.run(made._broker.left.pop(0))
        return names[outcome.document.id]

    for _ in range(3):
        post("busy")
    turns = [work()]
    post("late")
    turns.append(work())
    book.request_cancel(next(job_id for job_id in names if book.read(job_id).state == "queued"))
    post("later")
    turns += [work() for _ in range(2)]
    assert sorted(turns[2:]) == ["busy", "later"]
    assert turns[:2] == ["busy", "late"]
    assert made.run(made._broker.left.pop(0)).state == "elsewhere"
    assert made.outbox.count() == 0
