"""Builds as the routes see them: submit, look, wait, follow and cancel, whatever the engine.

The state of a job is in the job book (`service.jobs.book`), and any replica can answer from it.
What the engine of this process knows besides is fresher, and comes without a look into the
store; so identical requests meet here first, and in the book otherwise. See
``docs/decisions/jobs.md``.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import time
import weakref
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from service.building.engine import EngineFacts, shutting_down
from service.caching.single_flight import SingleFlight
from service.jobs.documents import UNHEARD
from service.problems.problem import Problem
from service.storage.blobs import StoreUnavailableError

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterator, Mapping

    from service.building.engine import Engine
    from service.jobs.book import JobBook, JobDocument
    from service.settings import Settings
    from service.storage.gamuts import GamutStore

__all__ = ["Builds"]

logger = logging.getLogger(__name__)

_FIRST_POLL, _LAST_POLL = 0.1, 2.0
"""Seconds between two looks into the book for a job of another process; they double."""

_FORGET_INTERVAL = 3600.0
"""Seconds between two rounds of forgetting finished jobs."""


class _Subscription:
    """Somebody who waits for changes of one job."""

    def __init__(self) -> None:
        self.changed = asyncio.Event()
        self.document: JobDocument | None = None


class Builds:
    """The builds of a deployment, seen from one of its processes.

    Everything here belongs to the event loop's thread.

    Parameters
    ----------
    settings : Settings
        How long finished jobs are kept.
    store : GamutStore
        Where inputs and gamuts are.
    book : JobBook
        The jobs.
    engine : Engine
        Does them.
    """

    def __init__(
        self, settings: Settings, store: GamutStore, book: JobBook, engine: Engine
    ) -> None:
        self._settings = settings
        self._store = store
        self._book = book
        self._engine = engine
        self._submissions: SingleFlight[str, JobDocument | None] = SingleFlight()
        self._inputs: weakref.WeakValueDictionary[str, asyncio.Lock] = weakref.WeakValueDictionary()
        self._arriving = 0
        self._subscriptions: dict[str, set[_Subscription]] = {}
        self._forgetting: asyncio.Task[None] | None = None
        self.draining = False
        engine.listen(self._tell)

    async def start(self) -> None:
        """Start the engine."""
        await self._engine.start()
        self._forgetting = asyncio.create_task(self._forget(), name="forgetting of jobs")

    def drain(self) -> None:
        """Refuse new builds, begin none, and let those who wait for a queued one go."""
        self.draining = True
        self._engine.drain()
        for subscriptions in self._subscriptions.values():
            for subscription in subscriptions:
                subscription.changed.set()

    async def stop(self) -> None:
        """Drain and end the engine."""
        self.drain()
        if self._forgetting is not None:
            self._forgetting.cancel()
        await self._engine.stop()

    def facts(self) -> EngineFacts:
        """Return what the engine is doing."""
        return self._engine.facts()

    def retry_after(self, document: JobDocument) -> int:
        """Return in how many seconds a client should look at a job again."""
        if document.state == "running":
            return 1
        return min(self._engine.retry_after(), 30)

    async def check_admission(self) -> None:
        """Raise the problem that a new build would be refused with: stopping, or a full queue."""
        await self._admit(self._arriving)

    async def submit(
        self,
        gamut_id: str,
        options: Mapping[str, Any],
        data: bytes,
        trace: Mapping[str, str] | None = None,
    ) -> JobDocument | None:
        """Return the job that builds a gamut; None if the gamut is there.

        When this returns, the build is the deployment's duty, whatever happens to this process.

        Parameters
        ----------
        gamut_id : str
            Id of the gamut; identical requests have the same.
        options : mapping
            The gamut's options, all of them.
        data : bytes
            What it is built from.
        trace : mapping, optional
            Header fields that carry the trace of the request.

        Raises
        ------
        ProblemError
            ``queue-full`` or ``shutting-down``.
        OSError, StoreUnavailableError
            The store cannot take it.
        """
        return await self._submissions.value(
            gamut_id, lambda: self._submitted(gamut_id, options, data, trace)
        )

    async def rebuild(self, gamut_id: str) -> JobDocument | None:
        """Return the job that builds a damaged gamut again from its input; None if none is kept.

        Raises
        ------
        ProblemError
            ``queue-full`` or ``shutting-down``.
        """
        return await self._submissions.value(
            gamut_id, lambda: self._submitted(gamut_id, None, None, None)
        )

    async def job(self, job_id: str) -> JobDocument | None:
        """Return a job; None if there is none."""
        document = self._engine.document(job_id)
        return document or await self._taken_up(await asyncio.to_thread(self._book.read, job_id))

    async def page(self, after: str, limit: int) -> list[JobDocument]:
        """Return up to `limit` jobs in the order of their ids, from the first after `after`."""
        documents = await asyncio.to_thread(self._book.page, after, limit)
        for document in documents:
            await self._taken_up(document)
        return [self._engine.document(document.id) or document for document in documents]

    async def wait(self, job_id: str, seconds: float) -> JobDocument | None:
        """Return a job when it is over, or as it is after some seconds; None if it is unknown.

        A queued job of a service that is stopping is returned at once.
        """
        deadline = time.monotonic() + seconds
        with self._subscribed(job_id) as subscription:
            poll = _FIRST_POLL
            while True:
                document = await self._seen(job_id, subscription)
                remaining = deadline - time.monotonic()
                if document is None or document.final or remaining <= 0:
                    return document
                if self.draining and document.state == "queued":
                    return document
                await self._change(job_id, subscription, min(poll, remaining), remaining)
                poll = min(2 * poll, _LAST_POLL)

    async def changes(self, job_id: str, heartbeat: float) -> AsyncIterator[JobDocument | None]:
        """Iterate over what a job is, now and after every change, until it is over.

        Parameters
        ----------
        job_id : str
            Which job. The iteration ends if it becomes unknown, and when the service stops.
        heartbeat : float
            Seconds without a change after which None is yielded.
        """
        last: JobDocument | None = None
        with self._subscribed(job_id) as subscription:
            poll = _FIRST_POLL
            beat = time.monotonic() + heartbeat
            while True:
                document = await self._seen(job_id, subscription)
                if document is None:
                    return
                if last is None or _progress(document) != _progress(last):
                    last, poll = document, _FIRST_POLL
                    beat = time.monotonic() + heartbeat
                    yield document
                    if document.final:
                        return
                elif time.monotonic() >= beat:
                    beat = time.monotonic() + heartbeat
                    yield None
                if self.draining:
                    return
                remaining = max(beat - time.monotonic(), 0.0)
                await self._change(job_id, subscription, min(poll, remaining), remaining)
                poll = min(2 * poll, _LAST_POLL)

    async def cancel(self, job_id: str) -> JobDocument | None:
        """Return a job, cancelled unless it was over; None if there is none."""
        document = await asyncio.to_thread(self._book.request_cancel, job_id)
        if document is None or document.state != "cancelled":
            return document
        await self._engine.cancel(job_id)
        self._tell(document)
        async with self._input_lock(job_id):
            # Not if somebody has asked for the gamut again meanwhile.
            current = await asyncio.to_thread(self._book.read, job_id)
            if current is None or current.state == "cancelled":
                with contextlib.suppress(OSError, StoreUnavailableError):
                    await asyncio.to_thread(self._store.drop_input, job_id)
        return document

    async def _submitted(
        self,
        gamut_id: str,
        options: Mapping[str, Any] | None,
        data: bytes | None,
        trace: Mapping[str, str] | None,
    ) -> JobDocument | None:
        """Return the job that builds a gamut, from the kept input if there are no data."""
        # In this order: a build that ends between the two looks is found in the store.
        document = self._engine.document(gamut_id)
        if document is not None:
            return document
        if await asyncio.to_thread(self._store.stored, gamut_id):
            return None
        if options is None:
            try:
                options = await asyncio.to_thread(self._store.input_options, gamut_id)
            except LookupError:
                return None
        present = await asyncio.to_thread(self._book.read, gamut_id)
        # Counted before the engine is asked, so that those who come at the same moment see it.
        self._arriving += 1
        try:
            if present is None or present.final:
                await self._admit(self._arriving - 1)
            async with self._input_lock(gamut_id):
                accepted, new = await asyncio.to_thread(self._book.accept, gamut_id, options, trace)
                if data is not None:
                    await self._keep_input(accepted, data, new=new)
            if new or accepted.state == "queued":
                await self._engine.enqueue(accepted, joined=not new)
        finally:
            self._arriving -= 1
        return accepted

    async def _admit(self, arriving: int) -> None:
        if self.draining:
            raise shutting_down()
        await self._engine.check_admission(arriving)

    async def _keep_input(self, document: JobDocument, data: bytes, *, new: bool) -> None:
        """Store the input of an accepted job, before anybody is told that it is accepted."""

        def keep() -> None:
            # Whoever accepted the job may have died before this.
            if new or not self._store.input_kept(document.id):
                self._store.keep_input(document.id, data, document.options)

        try:
            await asyncio.to_thread(keep)
        except (OSError, StoreUnavailableError) as error:
            if new:
                problem = Problem.from_errno(getattr(error, "errno", None)) or Problem(
                    "build-input-lost", "The data could not be stored."
                )
                with contextlib.suppress(OSError, StoreUnavailableError):
                    await asyncio.to_thread(self._book.withdraw, document.id, problem)
            raise

    async def _taken_up(self, document: JobDocument | None) -> JobDocument | None:
        """Return a job; one that was begun anew for its damaged document is given to the engine."""
        if document is None or document.state != "queued" or document.updated != UNHEARD:
            return document
        # By one of all who see it; the queue's limit is for requests, and this one was accepted.
        revived = await asyncio.to_thread(self._book.revived, document.id, 0.0)
        if revived is None:
            return document
        await self._engine.enqueue(revived)
        return revived

    def _input_lock(self, gamut_id: str) -> asyncio.Lock:
        """Return what keeps a new job's input from being dropped with that of the one before."""
        lock = self._inputs.get(gamut_id)
        if lock is None:
            lock = self._inputs[gamut_id] = asyncio.Lock()
        return lock

    @contextlib.contextmanager
    def _subscribed(self, job_id: str) -> Iterator[_Subscription]:
        subscription = _Subscription()
        subscriptions = self._subscriptions.setdefault(job_id, set())
        subscriptions.add(subscription)
        try:
            yield subscription
        finally:
            subscriptions.discard(subscription)
            if not subscriptions and self._subscriptions.get(job_id) is subscriptions:
                del self._subscriptions[job_id]

    def _tell(self, document: JobDocument) -> None:
        """Tell those who wait for a job what it is now."""
        for subscription in self._subscriptions.get(document.id, ()):
            subscription.document = document
            subscription.changed.set()

    async def _seen(self, job_id: str, subscription: _Subscription) -> JobDocument | None:
        """Return a job as it was told, or else as it is found."""
        subscription.changed.clear()
        told = subscription.document
        if told is not None and (told.final or self._engine.document(job_id) is not None):
            return told
        return await self.job(job_id)

    async def _change(
        self, job_id: str, subscription: _Subscription, poll: float, remaining: float
    ) -> None:
        """Wait for a change: as long as may be for one that is told, else until the next look."""
        seconds = poll if self._engine.document(job_id) is None else remaining
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(subscription.changed.wait(), seconds)

    async def _forget(self) -> None:
        while True:
            try:
                count = await self._forget_finished()
            except (OSError, StoreUnavailableError):
                logger.exception("finished jobs could not be forgotten")
            else:
                if count:
                    logger.info("%d finished jobs forgotten", count)
            await asyncio.sleep(_FORGET_INTERVAL)

    async def _forget_finished(self) -> int:
        """Forget the jobs that were over long ago, and return their number."""
        forgotten = await asyncio.to_thread(
            self._book.forget_finished, self._settings.job_retention_seconds
        )
        for job_id in forgotten:
            async with self._input_lock(job_id):
                await asyncio.to_thread(self._drop_unwanted_input, job_id)
        return len(forgotten)

    def _drop_unwanted_input(self, job_id: str) -> None:
        """Remove the input of a forgotten job, unless somebody asks for its gamut again by now.

        That of a stored gamut stays: it is what a damaged one is built from.
        """
        if self._book.read(job_id) is not None or self._store.stored(job_id):
            return
        if not self._store.to_be_rebuilt(job_id):
            self._store.drop_input(job_id)


def _progress(document: JobDocument) -> JobDocument:
    """Return what of a job is worth telling: thousandths, and not when its lease ends."""
    return replace(
        document, updated="", lease_until=None, fraction=round(1000 * document.fraction) / 1000
    )
