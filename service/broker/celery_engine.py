"""The engine of an API replica whose builds are done elsewhere: it sends jobs to a broker.

It keeps nothing: any replica can be lost, and any other answers for its jobs from the book. While
the broker cannot be reached new builds are refused with 503, before anything of them is stored;
one that was let in just before is durable, and the workers find it (`service.broker.outbox`).
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import time
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, ParamSpec, TypeVar

from service.broker.celery_app import Broker, BrokerUnavailableError, celery_app
from service.broker.outbox import Outbox
from service.building.engine import EngineFacts, queue_full, shutting_down
from service.problems.problem import Problem, ProblemError
from service.storage.blobs import StoreUnavailableError

if TYPE_CHECKING:
    from collections.abc import Callable

    from service.jobs.book import JobBook, JobDocument
    from service.settings import Settings
    from service.storage.gamuts import GamutStore

__all__ = ["CeleryEngine"]

logger = logging.getLogger(__name__)

P = ParamSpec("P")
T = TypeVar("T")

_THREADS = 4
"""Calls of the broker under way at a time; each takes a millisecond, or ends after some seconds."""

_OBSERVE_SECONDS = 5.0
"""Between two looks at the queue for those who ask for facts."""

_REFUSE_SECONDS = 2.0
"""For how long a broker that did not answer is not asked again: POST is refused at once then."""

_BUILD_SECONDS = 2.0
"""What a build takes, to say when to come back: benchmarks/results.json, ``inputs``."""

_LONGEST_RETRY = 60


class CeleryEngine:
    """Has jobs done by the workers of the deployment.

    Parameters
    ----------
    settings : Settings
        The broker, and the length of its queue.
    store : GamutStore
        The store that all replicas and workers share.
    book : JobBook
        Its jobs.
    """

    def __init__(self, settings: Settings, store: GamutStore, book: JobBook) -> None:
        self._settings = settings
        self._broker = Broker(celery_app(settings))
        self._outbox = Outbox(store.blobs, book)
        self._threads = ThreadPoolExecutor(_THREADS, thread_name_prefix="broker")
        self._observing: asyncio.Task[None] | None = None
        self._draining = False
        self._refused_until = 0.0
        self._waiting = self._unfinished = 0

    def listen(self, listener: Callable[[JobDocument], None]) -> None:
        """Tell nothing: all that is known of a job is in the book."""

    async def start(self) -> None:
        """Begin to look at the queue."""
        self._observing = asyncio.create_task(self._observe(), name="look at the queue")

    def drain(self) -> None:
        """Refuse new builds. Those that run do so elsewhere."""
        self._draining = True

    async def stop(self) -> None:
        """Let go of the broker."""
        self.drain()
        if self._observing is not None:
            self._observing.cancel()
            await asyncio.gather(self._observing, return_exceptions=True)
        await self._in_thread(self._broker.close)
        self._threads.shutdown(wait=False, cancel_futures=True)

    async def check_admission(self, arriving: int = 0) -> None:
        """Raise the problem that a new build would be refused with, if there is one.

        The length of the queue is the broker's at this moment. Builds that are admitted by several
        replicas in the same moment may exceed it by as many.
        """
        if self._draining:
            raise shutting_down()
        if time.monotonic() < self._refused_until:
            raise self._unavailable()
        try:
            self._waiting = await self._in_thread(self._broker.waiting)
        except BrokerUnavailableError as error:
            self._refused_until = time.monotonic() + _REFUSE_SECONDS
            logger.warning("the broker does not answer: %s", error)
            raise self._unavailable() from error
        if self._waiting + arriving >= self._settings.build_queue:
            raise queue_full(self._waiting + arriving, self.retry_after())

    async def enqueue(self, document: JobDocument, *, joined: bool = False) -> None:
        """Send a job to the workers; harmless if it was sent already.

        If that fails the job stands all the same: it is marked, and a worker that has the broker
        again finds it. One that was accepted elsewhere is sent only if it is not marked: whoever
        accepted it has died in between, or is about to do the same.
        """
        marked = await asyncio.to_thread(self._outbox.mark, document.id)
        if joined and not marked:
            return
        try:
            await self._in_thread(self._broker.send, document.id)
        except BrokerUnavailableError as error:
            self._refused_until = time.monotonic() + _REFUSE_SECONDS
            logger.warning("job %s waits for the broker: %s", document.id, error)

    async def cancel(self, job_id: str) -> None:
        """Do nothing: the worker learns of it with its next heartbeat, or when it takes the job."""

    def document(self, job_id: str) -> JobDocument | None:  # noqa: ARG002 - the interface's
        """Return None: every job is in the book only."""
        return None

    def facts(self) -> EngineFacts:
        """Return what the deployment is doing, as of a few seconds ago.

        The workers belong to others, who start and count them.
        """
        return EngineFacts(
            queued=self._waiting,
            running=max(0, self._unfinished - self._waiting),
            workers=0,
            warm_workers=0,
            completed=0,
            capacity=self._settings.build_queue,
            fault="the broker does not answer" if time.monotonic() < self._refused_until else None,
        )

    def retry_after(self, queued: int = 0) -> int:
        """Return in how many seconds `queued` builds and one may be done, by a single worker."""
        return min(_LONGEST_RETRY, max(1, round(_BUILD_SECONDS * (queued + 1))))

    def _unavailable(self) -> ProblemError:
        return ProblemError(
            Problem(
                "broker-unavailable",
                "The queue of builds cannot be reached.",
                headers={"Retry-After": "5"},
            )
        )

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

    async def _in_thread(self, function: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        loop = asyncio.get_running_loop()
        return await loop.run_in_executor(self._threads, lambda: function(*args, **kwargs))
