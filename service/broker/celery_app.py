"""Celery as the transport of jobs: one queue, one task, and the id of a job in every message.

The state of a job is in the store (`service.jobs.book`). A lost, repeated or late message therefore
costs only time. What is set here is to make that rare: a message is acknowledged when
its build is over, a worker takes no more messages than it has processes, RabbitMQ keeps them in a
quorum queue with a limit of deliveries, and Redis hands one whose worker is gone to another after a
little more than a build may take. There is no result backend, and messages are JSON. See
``docs/decisions/celery.md``.
"""

from __future__ import annotations

import contextlib
import threading
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

from celery import Celery
from celery.exceptions import OperationalError as PublishError
from kombu import Exchange, Queue
from kombu.exceptions import OperationalError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from kombu import Connection

    from service.settings import Settings

__all__ = [
    "QUEUE",
    "TASK",
    "Broker",
    "BrokerUnavailableError",
    "build_limit",
    "celery_app",
]

QUEUE = "gamut-builds"
"""The queue's name: with Redis also the key of its list, whose length autoscalers look at."""

TASK = "gamut.build"

_STARTING_SECONDS = 60.0
"""What a build may take beside its own deadline: a worker process that starts, the input on its way
from the bucket, the history on its way there."""

_VISIBILITY_MARGIN = 30.0

_DELIVERIES = 20
"""How often RabbitMQ delivers a message. The attempts of a build are counted in the store; this is
for what never gets so far, such as a worker whose store is out of reach."""

_CONNECT_SECONDS = 2.0
_ANSWER_SECONDS = 3.0

_SENDERS = 4
"""Connections that jobs are sent over at the same time."""

_PUBLISH_RETRIES: dict[str, Any] = {
    "max_retries": 1,  # a pooled connection may have been closed by the broker meanwhile
    "interval_start": 0,
    "interval_step": 0.2,
    "interval_max": 0.5,
}


class BrokerUnavailableError(Exception):
    """The broker cannot be reached or does not answer; it may again in a while."""


def build_limit(settings: Settings) -> float:
    """Return the seconds after which Celery kills a slot: never before the build's own deadline."""
    return settings.build_timeout + _STARTING_SECONDS


def celery_app(settings: Settings) -> Celery:
    """Return Celery, set up for the broker of these settings; nothing is connected yet.

    Parameters
    ----------
    settings : Settings
        ``broker`` and ``build_timeout``.
    """
    redis = urlsplit(settings.broker).scheme.startswith("redis")
    app = Celery("gamut", broker=settings.broker, set_as_current=False)
    app.conf.update(
        # Whoever reads the queue's name has to find the same one with every broker.
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
        # Past the hard limit the job's lease ends and it is sent again, if it may be: one way only.
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
        # A worker without a broker has nothing better to do; its health check tells meanwhile.
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
    """Sends jobs, and says how many wait; each call takes seconds at most. Safe for threads.

    Parameters
    ----------
    app : Celery
        What `celery_app` returns.
    """

    def __init__(self, app: Celery) -> None:
        self._app = app
        self._queue = app.conf.task_queues[0]
        # Celery's own pool belongs to the whole process, and cannot be closed for one.
        self._pool = app.connection_for_write().Pool(_SENDERS)
        # Asking needs a channel, which only one thread may use at a time.
        self._asking = threading.Lock()
        self._connection: Connection | None = None

    def send(self, job_id: str) -> None:
        """Send a job to the workers.

        Raises
        ------
        BrokerUnavailableError
            The broker did not confirm it. It may have taken it all the same.
        """
        with (
            _translated(),
            self._pool.acquire(block=True, timeout=_ANSWER_SECONDS) as connection,
            self._app.amqp.Producer(connection) as producer,
        ):
            self._app.send_task(
                TASK, args=(job_id,), producer=producer, confirm_timeout=_ANSWER_SECONDS
            )

    def waiting(self) -> int:
        """Return the number of jobs in the queue, which is made if need be, that nobody has taken.

        Raises
        ------
        BrokerUnavailableError
            The broker did not answer.
        """
        with self._asking, _translated():
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
                    # The broker may have been started again since the last question.
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
def _translated() -> Iterator[None]:
    """Raise `BrokerUnavailableError` for what Celery, kombu and the clients below it raise."""
    try:
        yield
    except Exception as error:
        if isinstance(error, (OperationalError, PublishError, OSError)) or _of_a_client(error):
            # The text may hold the address; the chain of causes goes to the log only.
            raise BrokerUnavailableError(type(error).__name__) from error
        raise


def _of_a_client(error: Exception) -> bool:
    return type(error).__module__.partition(".")[0] in {"amqp", "redis", "kombu"}
