"""The build engine of an API replica with a broker: it sends jobs to workers elsewhere.

It has no state. Any replica can be lost, and all others answer from the job book. While the broker
is unavailable, new builds are refused with 503 before anything is stored. A job that was accepted
just before is durable, and workers find it (`service.broker.celery_app.Outbox`).
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

from service.broker.celery_app import Broker, BrokerUnavailableError, Outbox
from service.building.engine import Engine, EngineFacts, queue_full
from service.jobs.book import JobBook, JobDocument
from service.problems.problem import Problem, ProblemError
from service.settings import Settings
from service.storage.blobs import StoreUnavailableError
from service.storage.gamut_store import GamutStore

__all__ = ["CeleryEngine"]

logger = logging.getLogger(__name__)

T = TypeVar("T")

_THREADS = 4
"""Number of simultaneous broker calls; each takes a millisecond or times out after seconds."""

_OBSERVE_SECONDS = 5.0
"""Interval of reading the queue length."""

_REFUSE_SECONDS = 2.0
"""Time for which an unresponsive broker is not asked again; POST is refused at once."""

_BUILD_SECONDS = 2
"""Assumed seconds of a build, for Retry-After (``inputs`` in benchmarks/results.json)."""


class CeleryEngine(Engine):
    """Sends jobs to the workers of the deployment."""

    def __init__(self, settings: Settings, store: GamutStore, book: JobBook) -> None:
        self._settings = settings
        self._broker = Broker(settings)
        self._outbox = Outbox(store.blobs, book)
        self._threads = ThreadPoolExecutor(_THREADS, thread_name_prefix="broker")
        self._observing: asyncio.Task[None] | None = None
        self._refused_until = 0.0
        self._waiting = self._unfinished = 0

    async def start(self, changed: Callable[[JobDocument], None]) -> None:  # noqa: ARG002
        """Start to observe the queue. Changes of jobs are in the book only."""
        self._observing = asyncio.create_task(self._observe(), name="queue observer")

    async def stop(self) -> None:
        """Disconnect from the broker."""
        if self._observing is not None:
            self._observing.cancel()
            await asyncio.gather(self._observing, return_exceptions=True)
        await self._in_thread(self._broker.close)
        self._threads.shutdown(wait=False, cancel_futures=True)

    async def check_admission(self, arriving: int) -> None:
        """Raise ``queue-full`` or ``broker-unavailable`` if a new build would be refused.

        The queue length is the broker's current one, without messages of jobs that have ended.
        Replicas that admit builds at the same moment may exceed the limit by their number.
        """
        if time.monotonic() < self._refused_until:
            raise self._unavailable()
        try:
            self._waiting = await self._in_thread(self._broker.waiting)
        except BrokerUnavailableError as error:
            self._refused_until = time.monotonic() + _REFUSE_SECONDS
            logger.warning("the broker does not answer: %s", error)
            raise self._unavailable() from error
        if self._waiting + arriving >= self._settings.build_queue:
            with contextlib.suppress(StoreUnavailableError):
                self._unfinished = await asyncio.to_thread(self._outbox.count)
            waiting = self._queued() + arriving
            if waiting >= self._settings.build_queue:
                raise queue_full(waiting, _BUILD_SECONDS)

    async def enqueue(self, document: JobDocument, *, joined: bool = False) -> None:
        """Mark a job and send it to the workers; if sending fails, a worker sends it later.

        A job that another process accepted is sent only if it has no mark yet: that process died,
        or is about to send it.
        """
        marked = await asyncio.to_thread(self._outbox.mark, document.id)
        if joined and not marked:
            return
        try:
            await self._in_thread(self._broker.send, document.id)
        except BrokerUnavailableError as error:
            self._refused_until = time.monotonic() + _REFUSE_SECONDS
            logger.warning("job %s could not be sent yet: %s", document.id, error)

    def drain(self) -> None:
        """Do nothing: builds are elsewhere."""

    async def cancel(self, job_id: str) -> None:
        """Do nothing: the worker notices at its next heartbeat or when it takes the job."""

    def facts(self) -> EngineFacts:
        """Return the state of the deployment, a few seconds old.

        Workers are not counted: other processes start them.
        """
        queued = self._queued()
        return EngineFacts(
            queued=queued,
            running=self._unfinished - queued,
            capacity=self._settings.build_queue,
            retry_after=_BUILD_SECONDS,
            fault="the broker does not answer" if time.monotonic() < self._refused_until else None,
        )

    def _queued(self) -> int:
        # A job that was run before its turn in the broker's queue leaves a message there.
        return min(self._waiting, self._unfinished)

    def _unavailable(self) -> ProblemError:
        detail = "The queue of builds cannot be reached."
        return ProblemError(Problem("broker-unavailable", detail, headers={"Retry-After": "5"}))

    async def _observe(self) -> None:
        while True:
            try:
                self._waiting = await self._in_thread(self._broker.waiting)
                self._refused_until = 0.0
            except BrokerUnavailableError as error:
                self._refused_until = time.monotonic() + _OBSERVE_SECONDS + _REFUSE_SECONDS
                logger.warning("the broker does not answer: %s", error)
            with contextlib.suppress(StoreUnavailableError):
                self._unfinished = await asyncio.to_thread(self._outbox.count)
            await asyncio.sleep(_OBSERVE_SECONDS)

    async def _in_thread(self, function: Callable[..., T], *arguments: object) -> T:
        return await asyncio.get_running_loop().run_in_executor(self._threads, function, *arguments)
