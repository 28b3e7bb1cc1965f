"""Celery as the transport of jobs: one queue and one task, with the id of a job in every message.

The state of a job is in the store (`service.jobs.book`), so a lost, repeated or late message costs
only time. See ``docs/decisions/celery.md``.
"""

from __future__ import annotations

import contextlib
import math
import time
from collections.abc import Callable, Collection, Iterator
from concurrent.futures import ThreadPoolExecutor
from datetime import datetime

from celery import Celery
from celery.exceptions import OperationalError
from redis import Redis
from redis.exceptions import RedisError

from service.jobs.book import JobBook, JobDocument
from service.settings import Settings
from service.storage.blobs import Blobs

__all__ = [
    "QUEUE",
    "RESEND_SECONDS",
    "TASK",
    "Broker",
    "BrokerUnavailableError",
    "Outbox",
    "celery_app",
]

QUEUE = "gamut-builds"
"""Name of the queue, and of the list in Redis that autoscalers read."""

TASK = "gamut.build"

RESEND_SECONDS = 30.0
"""Age at which an unstarted job is sent again, if the queue is empty. A restarted worker is warm
within this time, and a superfluous message costs one read of the job."""

_VISIBILITY_MARGIN = 60.0
"""Seconds besides a build's deadline: start of a process, download, upload."""

_CONNECT_SECONDS = 2.0
_ANSWER_SECONDS = 3.0

_READERS = 8
"""Number of jobs' documents that are read at the same time."""


class BrokerUnavailableError(Exception):
    """The broker cannot be reached or does not answer. It may recover."""


def celery_app(settings: Settings) -> Celery:
    """Return a configured Celery app. Nothing is connected yet."""
    app = Celery("gamut", broker=settings.broker, set_as_current=False)
    app.conf.update(
        task_default_queue=QUEUE,
        task_acks_late=True,
        task_reject_on_worker_lost=True,
        task_ignore_result=True,
        task_publish_retry_policy={"max_retries": 1, "interval_start": 0},
        worker_prefetch_multiplier=1,
        worker_hijack_root_logger=False,
        worker_redirect_stdouts=False,
        # Retry for ever; the health check reports the fault.
        broker_connection_max_retries=None,
        # A whole number, after which Redis delivers the message of a dead worker again.
        broker_transport_options={
            "visibility_timeout": math.ceil(settings.build_timeout + _VISIBILITY_MARGIN)
        },
    )
    return app


class Broker:
    """Sends jobs and reads the queue length; each call takes at most seconds. Thread-safe."""

    def __init__(self, settings: Settings) -> None:
        limits = {"socket_connect_timeout": _CONNECT_SECONDS, "socket_timeout": _ANSWER_SECONDS}
        self._app = celery_app(settings)
        # Not for workers: one that gave up a stalled acknowledgement would take no more messages.
        self._app.conf.broker_transport_options |= limits
        self._redis = Redis.from_url(settings.broker, **limits)

    def send(self, job_id: str) -> None:
        """Send a job to the workers.

        Raise `BrokerUnavailableError` if the broker did not confirm the message, which it may have
        received.
        """
        # A connection of its own costs a millisecond, and cannot have died since the last job.
        with _translate_errors(), self._app.connection_for_write() as connection:
            self._app.send_task(TASK, args=(job_id,), connection=connection)

    def waiting(self) -> int:
        """Return the number of messages in the queue.

        Raise `BrokerUnavailableError` if the broker did not answer.
        """
        with _translate_errors():
            return int(self._redis.llen(QUEUE))

    def ping(self, node: str) -> bool:
        """Return whether the worker of this name answers.

        Raise `BrokerUnavailableError` if the broker did not answer.
        """
        with _translate_errors(), self._app.connection_for_write() as connection:
            inspect = self._app.control.inspect([node], _ANSWER_SECONDS, connection=connection)
            return bool(inspect.ping())

    def close(self) -> None:
        """Close the connections."""
        self._redis.close()
        self._app.close()


@contextlib.contextmanager
def _translate_errors() -> Iterator[None]:
    """Turn exceptions of Celery and the Redis client into `BrokerUnavailableError`."""
    try:
        yield
    except (OperationalError, RedisError, OSError) as error:
        # The text may contain the address. The chain of causes goes to the log only.
        raise BrokerUnavailableError(type(error).__name__) from error


class Outbox:
    """Jobs that were sent and have not ended, as empty blobs under ``pending/``.

    Messages can be lost: a broker is flushed, a process dies before it sends an accepted job, or a
    worker is killed. The mark is created before the message and removed after the job. So the marks
    lead to every job that may need another message, without reading all jobs. `clock` gives
    seconds of the Unix epoch, as in the book.
    """

    def __init__(self, blobs: Blobs, book: JobBook, clock: Callable[[], float] = time.time) -> None:
        self._blobs = blobs
        self._book = book
        self._clock = clock
        self._due: dict[str, float] = {}

    def mark(self, job_id: str) -> bool:
        """Mark a job that is about to be sent; return whether the mark is new."""
        return self._blobs.create(_mark_key(job_id), b"\n") is not None

    def remove(self, job_id: str) -> None:
        """Remove the mark of an ended job, unless a new job has the same id."""
        self._blobs.delete(_mark_key(job_id))
        document = self._book.read(job_id)
        if document is not None and not document.final:
            self.mark(job_id)

    def ids(self) -> Iterator[str]:
        """Iterate over the ids of the marked jobs."""
        for key in self._blobs.keys("pending/"):
            yield key.rpartition("/")[2]

    def waiting(self, known: Collection[str]) -> tuple[set[str], list[JobDocument]]:
        """Return the ids of all marked jobs, and the waiting jobs not yet `known`, oldest first."""
        marked = set(self.ids())
        with ThreadPoolExecutor(_READERS) as threads:
            jobs = threads.map(self._book.read, marked.difference(known))
            documents = [job for job in jobs if job is not None and self._waits(job)]
        return marked, sorted(documents, key=lambda document: document.created)

    def waits(self, job_id: str) -> bool:
        """Return whether a job can be claimed."""
        document = self._book.read(job_id)
        return document is not None and self._waits(document)

    def _waits(self, document: JobDocument) -> bool:
        if document.state == "running":
            return (document.lease_until or 0.0) < self._clock()
        return not document.final

    def count(self) -> int:
        """Return the number of marked jobs."""
        return sum(1 for _ in self.ids())

    def overdue(self, silence: float) -> Iterator[str]:
        """Iterate over the jobs that this caller, and no other, must send again.

        An unstarted job counts as lost after `silence` seconds, a running job when its lease has
        ended. A job is read only once it can be overdue, so frequent calls are cheap.
        """
        due, self._due = self._due, {}
        for job_id in self.ids():
            if due.get(job_id, 0.0) > self._clock():
                self._due[job_id] = due[job_id]
                continue
            document = self._book.read(job_id)
            if document is None or document.final:
                self.remove(job_id)
                continue
            self._due[job_id] = _overdue_at(document, silence)
            if self._due[job_id] <= self._clock() and self._book.revive(job_id, silence):
                self._due[job_id] = self._clock() + silence
                yield job_id


def _overdue_at(document: JobDocument, silence: float) -> float:
    if document.state == "running":
        return document.lease_until or 0.0
    return datetime.fromisoformat(document.updated).timestamp() + silence


def _mark_key(job_id: str) -> str:
    return f"pending/{job_id[:2]}/{job_id}"
