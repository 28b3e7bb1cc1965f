"""Celery as the transport of jobs: one queue and one task, with the id of a job in every message.

The state of a job is in the store (`service.jobs.book`), so a lost, repeated or late message costs
only time. The configuration keeps that rare. Messages are acknowledged after the build, and a
worker takes one message per process. RabbitMQ uses a quorum queue with a delivery limit. Redis
delivers the message of a dead worker again shortly after the build deadline. There is no result
backend, and messages are JSON. See ``docs/decisions/celery.md``.
"""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Callable, Collection, Iterator
from concurrent.futures import ThreadPoolExecutor
from datetime import datetime
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

from celery import Celery
from celery.exceptions import OperationalError as PublishError
from kombu import Exchange, Queue
from kombu.exceptions import OperationalError

from service.jobs.book import JobBook, JobDocument
from service.settings import Settings
from service.storage.blobs import Blobs

if TYPE_CHECKING:
    from kombu import Connection

__all__ = [
    "QUEUE",
    "TASK",
    "Broker",
    "BrokerUnavailableError",
    "Outbox",
    "build_limit",
    "celery_app",
]

QUEUE = "gamut-builds"
"""Name of the queue. In Redis it is also the key of the list that autoscalers read."""

TASK = "gamut.build"

_STARTING_SECONDS = 60.0
"""Time allowed besides a build's deadline: start of a process, download, upload."""

_VISIBILITY_MARGIN = 30.0

_DELIVERIES = 20
"""Delivery limit in RabbitMQ. Attempts of builds are counted in the store; this limit is for
workers that never get so far."""

_CONNECT_SECONDS = 2.0
_ANSWER_SECONDS = 3.0

_SENDERS = 4
"""Number of connections for sending."""

_READERS = 8
"""Number of jobs' documents that are read at the same time."""

_PUBLISH_RETRIES: dict[str, Any] = {
    "max_retries": 1,  # a pooled connection may have been closed by the broker meanwhile
    "interval_start": 0,
    "interval_step": 0.2,
    "interval_max": 0.5,
}


class BrokerUnavailableError(Exception):
    """The broker cannot be reached or does not answer. It may recover."""


def build_limit(settings: Settings) -> float:
    """Return the seconds after which Celery kills a slot, always after the build's own deadline."""
    return settings.build_timeout + _STARTING_SECONDS


def celery_app(settings: Settings) -> Celery:
    """Return a configured Celery app. Nothing is connected yet."""
    redis = urlsplit(settings.broker).scheme.startswith("redis")
    app = Celery("gamut", broker=settings.broker, set_as_current=False)
    app.conf.update(
        # Autoscalers expect the same queue name with every broker.
        task_queues=[
            Queue(
                QUEUE,
                Exchange(QUEUE, type="direct"),
                routing_key=QUEUE,
                durable=True,
                queue_arguments=None
                if redis
                else {"x-queue-type": "quorum", "x-delivery-limit": _DELIVERIES},
            )
        ],
        task_default_queue=QUEUE,
        task_create_missing_queues=False,
        task_acks_late=True,
        task_reject_on_worker_lost=True,
        # After the hard limit the job's lease ends, and the job is sent again. This is the only
        # way.
        task_acks_on_timeout=True,
        task_acks_on_failure=True,
        task_time_limit=build_limit(settings),
        task_ignore_result=True,
        result_backend=None,
        task_serializer="json",
        accept_content=["json"],
        task_publish_retry=True,
        task_publish_retry_policy=_PUBLISH_RETRIES,
        worker_prefetch_multiplier=1,
        worker_send_task_events=False,
        worker_enable_remote_control=False,
        worker_hijack_root_logger=False,
        worker_redirect_stdouts=False,
        worker_cancel_long_running_tasks_on_connection_loss=False,
        broker_connection_timeout=_CONNECT_SECONDS,
        broker_connection_retry=True,
        broker_connection_retry_on_startup=True,
        # Retry for ever; the health check reports the fault.
        broker_connection_max_retries=None,
        broker_heartbeat=0 if redis else 10,
        broker_transport_options=_redis_options(settings) if redis else {"confirm_publish": True},
    )
    return app


def _redis_options(settings: Settings) -> dict[str, Any]:
    return {
        "visibility_timeout": build_limit(settings) + _VISIBILITY_MARGIN,
        "socket_connect_timeout": _CONNECT_SECONDS,
        "socket_timeout": _ANSWER_SECONDS,
        "socket_keepalive": True,
        "health_check_interval": 10,
    }


class Broker:
    """Sends jobs and reads the queue length; each call takes at most seconds. Thread-safe."""

    def __init__(self, app: Celery) -> None:
        self._app = app
        self._queue = app.conf.task_queues[0]
        # Celery's own pool is shared by the process and cannot be closed.
        self._pool = app.connection_for_write().Pool(_SENDERS)
        # Reading needs a channel, which is not thread-safe.
        self._asking = threading.Lock()
        self._connection: Connection | None = None

    def send(self, job_id: str) -> None:
        """Send a job to the workers.

        Raise `BrokerUnavailableError` if the broker did not confirm the message, which it may have
        received.
        """
        with (
            _translate_errors(),
            self._pool.acquire(block=True, timeout=_ANSWER_SECONDS) as connection,
            self._app.amqp.Producer(connection) as producer,
        ):
            self._app.send_task(
                TASK, args=(job_id,), producer=producer, confirm_timeout=_ANSWER_SECONDS
            )

    def waiting(self) -> int:
        """Return the number of jobs in the queue, which is created if needed.

        Raise `BrokerUnavailableError` if the broker did not answer.
        """
        with self._asking, _translate_errors():
            for last in (False, True):
                try:
                    if self._connection is None:
                        self._connection = self._app.connection_for_write()
                    self._connection.ensure_connection(
                        max_retries=1, interval_start=0, interval_step=0
                    )
                    with self._connection.channel() as channel:
                        return int(self._queue.bind(channel).queue_declare().message_count)
                except self._errors():
                    # The broker may have restarted since the last call.
                    self._drop()
                    if last:
                        raise
        message = "unreachable"
        raise AssertionError(message)

    def close(self) -> None:
        """Close the connections."""
        with self._asking:
            self._drop()
        with contextlib.suppress(Exception):
            self._pool.force_close_all()

    def _errors(self) -> tuple[type[BaseException], ...]:
        if self._connection is None:
            return (OSError,)
        found: tuple[type[BaseException], ...] = (
            *self._connection.connection_errors,
            *self._connection.channel_errors,
            OSError,
        )
        return found

    def _drop(self) -> None:
        if self._connection is not None:
            with contextlib.suppress(Exception):
                self._connection.release()
            self._connection = None


@contextlib.contextmanager
def _translate_errors() -> Iterator[None]:
    """Turn exceptions of Celery, kombu and their clients into `BrokerUnavailableError`."""
    try:
        yield
    except Exception as error:
        if isinstance(error, (OperationalError, PublishError, OSError)) or _is_client_error(error):
            # The text may contain the address. The chain of causes goes to the log only.
            raise BrokerUnavailableError(type(error).__name__) from error
        raise


def _is_client_error(error: Exception) -> bool:
    return type(error).__module__.partition(".")[0] in {"amqp", "redis", "kombu"}


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
            found = threads.map(self._book.read, marked.difference(known))
            documents = [each for each in found if each is not None and self._waits(each)]
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
