"""Builds as the routes see them: submit, look up, wait, follow and cancel, with any engine.

The state of a job is in the job book (`service.jobs.book`), and any replica can answer from it. The
engine of this process is asked first, because it has the newest state of its own jobs in memory.
Identical requests to one process share a submission here. Identical requests to several replicas
share the job in the book. See ``docs/decisions/jobs.md``.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import time
import weakref
from collections.abc import AsyncIterator, Iterator, Mapping
from dataclasses import replace
from typing import Any

from gamutcore.errors import OptionError
from gamutcore.options import Options
from service.building.engine import Engine, EngineFacts
from service.concurrency import SingleFlight
from service.http.request_context import timed
from service.jobs.book import NEVER_QUEUED, JobBook, JobDocument, client_mark
from service.problems.problem import Problem, ProblemError
from service.storage.blobs import StoreUnavailableError
from service.storage.gamut_store import GamutNotStoredError, GamutStore
from service.storage.published import PublishedGamut

__all__ = ["JOB_SECONDS", "Builds"]

logger = logging.getLogger(__name__)

JOB_SECONDS = 86_400.0
"""Seconds for which a finished job can be read, for clients that ask the next day. Gamuts stay."""

_FIRST_POLL, _LAST_POLL = 0.1, 2.0
"""First and last interval between two reads of another process's job; it doubles."""

_FORGET_INTERVAL = 3600.0
"""Seconds between two removals of finished jobs."""


class _Subscription:
    """A waiter for changes of one job, with the interval until the next poll."""

    def __init__(self) -> None:
        self.changed = asyncio.Event()
        self.document: JobDocument | None = None
        self.poll = _FIRST_POLL


class Builds:
    """The builds of a deployment. Everything here belongs to the event loop's thread."""

    def __init__(self, store: GamutStore, book: JobBook, engine: Engine) -> None:
        self._store = store
        self._book = book
        self._engine = engine
        self._submissions: SingleFlight[str, PublishedGamut | JobDocument] = SingleFlight()
        self._inputs: weakref.WeakValueDictionary[str, asyncio.Lock] = weakref.WeakValueDictionary()
        self._arriving = 0
        self._subscriptions: dict[str, set[_Subscription]] = {}
        self._forgetting: asyncio.Task[None] | None = None
        self.draining = False

    async def start(self) -> None:
        """Start the engine."""
        await self._engine.start(self._notify)
        self._forgetting = asyncio.create_task(self._forget(), name="removal of finished jobs")

    def drain(self) -> None:
        """Refuse new builds, start none, and wake the requests that wait for queued jobs."""
        self.draining = True
        self._engine.drain()
        for subscriptions in self._subscriptions.values():
            for subscription in subscriptions:
                subscription.changed.set()

    async def stop(self) -> None:
        """Drain and stop the engine."""
        self.drain()
        if self._forgetting is not None:
            self._forgetting.cancel()
        await self._engine.stop()

    def facts(self) -> EngineFacts:
        """Return the state of the engine."""
        return self._engine.facts()

    def retry_after(self, document: JobDocument) -> int:
        """Return the seconds after which a client should look at a job again."""
        return 1 if document.state == "running" else min(self.facts().retry_after, 30)

    async def check_admission(self, counted: int = 0) -> None:
        """Raise the problem that would refuse a new build: stopping, or a full queue.

        `counted` builds that arrive are the caller's own.
        """
        if self.draining:
            detail = "The service is stopping and accepts no new builds."
            raise ProblemError(Problem("shutting-down", detail, headers={"Retry-After": "5"}))
        await self._engine.check_admission(self._arriving - counted)

    async def submit(
        self,
        gamut_id: str,
        options: Mapping[str, Any],
        data: bytes | None,
        sha256: str | None = None,
        client: str = "",
    ) -> PublishedGamut | JobDocument:
        """Return the record of a gamut, or the job that builds it, which is durable then.

        Identical requests share one submission. Without `data`, the input is stored already.
        Refusals are ``queue-full`` and ``shutting-down``.
        """
        return await self._submissions.value(
            gamut_id, lambda: self._submit(gamut_id, options, data, sha256, client)
        )

    async def rebuild(self, gamut_id: str) -> JobDocument | None:
        """Return the job that builds a damaged gamut from its stored input.

        The result is None if the gamut exists or no input is stored. Refusals are as for `submit`,
        and ``gamut-not-found`` if this version does not accept the stored options.
        """
        document = self._engine.document(gamut_id)
        if document is not None or await asyncio.to_thread(self._store.is_stored, gamut_id):
            return document
        try:
            options = await asyncio.to_thread(self._store.input_options, gamut_id)
        except LookupError:
            return None
        try:
            Options.from_stored(options)
        except OptionError as error:
            # A build would fail again at every request.
            detail = f"The gamut {gamut_id} cannot be built again. {error.message}"
            where = {"field": "gamut_id", "option": error.where["field"]}
            remedy = error.remedy
            if not remedy.startswith("Post"):
                remedy = f"Post the data again with options of this version. {remedy}"
            raise ProblemError(Problem("gamut-not-found", detail, where, remedy)) from error
        gamut_or_job = await self.submit(gamut_id, options, None)
        return None if isinstance(gamut_or_job, PublishedGamut) else gamut_or_job

    async def job(self, job_id: str) -> JobDocument | None:
        """Return a job; None if there is none."""
        document = self._engine.document(job_id)
        return document or await self._queue_recovered_job(
            await asyncio.to_thread(self._book.read, job_id)
        )

    async def page(self, after: str, limit: int) -> list[JobDocument]:
        """Return up to `limit` jobs after the id `after`, in the order of their ids."""
        documents = await asyncio.to_thread(self._book.page, after, limit)
        for document in documents:
            await self._queue_recovered_job(document)
        return [self._engine.document(document.id) or document for document in documents]

    async def wait(self, job_id: str, seconds: float) -> JobDocument | None:
        """Return a job when it has ended, or its state after some seconds; None if it is unknown.

        While the service stops, a queued job is returned at once.
        """
        deadline = time.monotonic() + seconds
        with self._subscribe(job_id) as subscription:
            while True:
                document = await self._current(job_id, subscription)
                remaining = deadline - time.monotonic()
                if document is None or document.final or remaining <= 0:
                    return document
                if self.draining and document.state == "queued":
                    return document
                await self._wait_for_change(job_id, subscription, remaining)

    async def changes(self, job_id: str, heartbeat: float) -> AsyncIterator[JobDocument | None]:
        """Iterate over the states of a job, now and after every change, until it ends.

        None is yielded after `heartbeat` seconds without a change. The iteration also ends when the
        job becomes unknown or the service stops.
        """
        last: JobDocument | None = None
        with self._subscribe(job_id) as subscription:
            beat = time.monotonic() + heartbeat
            while True:
                document = await self._current(job_id, subscription)
                if document is None:
                    return
                if last is None or _progress(document) != _progress(last):
                    last, subscription.poll = document, _FIRST_POLL
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
                await self._wait_for_change(job_id, subscription, remaining)

    async def cancel(self, job_id: str) -> JobDocument | None:
        """Cancel a job unless it has ended, and return it; None if there is none."""
        document = await asyncio.to_thread(self._book.request_cancel, job_id)
        if document is None or document.state != "cancelled":
            return document
        await self._engine.cancel(job_id)
        self._notify(document)
        async with self._input_lock(job_id):
            # Another request may have asked for the gamut meanwhile.
            current = await asyncio.to_thread(self._book.read, job_id)
            if current is None or current.state == "cancelled":
                with contextlib.suppress(OSError, StoreUnavailableError):
                    await asyncio.to_thread(self._store.drop_input, job_id)
        return document

    async def _submit(
        self,
        gamut_id: str,
        options: Mapping[str, Any],
        data: bytes | None,
        sha256: str | None,
        client: str,
    ) -> PublishedGamut | JobDocument:
        # In this order, because a build that ends in between is then found in the store.
        document = self._engine.document(gamut_id)
        if document is not None:
            return document
        with contextlib.suppress(GamutNotStoredError), timed("store"):
            stored = await asyncio.to_thread(self._store.record, gamut_id)
            if data is not None:
                await asyncio.to_thread(
                    self._restore_evicted_input, gamut_id, options, data, sha256
                )
            return stored
        # Requests for a job under way need no room in the queue.
        present = await asyncio.to_thread(self._book.read, gamut_id)
        # Counted before the engine is asked, so that simultaneous requests see each other.
        self._arriving += 1
        try:
            if present is None or present.final:
                await self.check_admission(counted=1)
            async with self._input_lock(gamut_id):
                accepted, new = await asyncio.to_thread(
                    self._book.accept, gamut_id, options, client_mark(client)
                )
                if data is not None:
                    await self._keep_input(accepted, data, sha256, new=new)
            if new or accepted.state == "queued":
                await self._engine.enqueue(accepted, joined=not new)
        finally:
            self._arriving -= 1
        return accepted

    def _restore_evicted_input(
        self, gamut_id: str, options: Mapping[str, Any], data: bytes, sha256: str | None
    ) -> None:
        """Store the input of an existing gamut that was evicted: device models are made of it."""
        if self._store.keep_inputs and not self._store.input_kept(gamut_id):
            with contextlib.suppress(OSError, StoreUnavailableError):
                self._store.keep_input(gamut_id, data, dict(options), sha256)

    async def _keep_input(
        self, document: JobDocument, data: bytes, sha256: str | None, *, new: bool
    ) -> None:
        """Store the input of an accepted job before the acceptance is reported."""

        def keep() -> None:
            # The process that accepted the job may have died before storing the input.
            if new or not self._store.input_kept(document.id):
                self._store.keep_input(document.id, data, document.options, sha256)

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

    async def _queue_recovered_job(self, document: JobDocument | None) -> JobDocument | None:
        """Return a job. A job that was recovered from a damaged document is queued first."""
        if document is None or document.state != "queued" or document.updated != NEVER_QUEUED:
            return document
        # Exactly one caller revives it. The queue limit does not apply: the request was accepted.
        revived = await asyncio.to_thread(self._book.revive, document.id, 0.0)
        if revived is None:
            return document
        await self._engine.enqueue(revived)
        return revived

    def _input_lock(self, gamut_id: str) -> asyncio.Lock:
        """Return the lock that keeps a new job's input from being dropped with the old job's."""
        return self._inputs.setdefault(gamut_id, asyncio.Lock())

    @contextlib.contextmanager
    def _subscribe(self, job_id: str) -> Iterator[_Subscription]:
        subscription = _Subscription()
        subscriptions = self._subscriptions.setdefault(job_id, set())
        subscriptions.add(subscription)
        try:
            yield subscription
        finally:
            subscriptions.discard(subscription)
            if not subscriptions and self._subscriptions.get(job_id) is subscriptions:
                del self._subscriptions[job_id]

    def _notify(self, document: JobDocument) -> None:
        """Wake the waiters of a job with its new state."""
        for subscription in self._subscriptions.get(document.id, ()):
            subscription.document = document
            subscription.changed.set()

    async def _current(self, job_id: str, subscription: _Subscription) -> JobDocument | None:
        """Return a job as it was reported, or as it is in the book."""
        subscription.changed.clear()
        reported = subscription.document
        if reported is not None and (reported.final or self._engine.document(job_id) is not None):
            return reported
        return await self.job(job_id)

    async def _wait_for_change(
        self, job_id: str, subscription: _Subscription, seconds: float
    ) -> None:
        """Wait for a change, some seconds at most. Jobs of other processes are polled."""
        if self._engine.document(job_id) is None:
            seconds = min(subscription.poll, seconds)
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(subscription.changed.wait(), seconds)
        subscription.poll = min(2 * subscription.poll, _LAST_POLL)

    async def _forget(self) -> None:
        """Forget the jobs that ended long ago, again and again."""
        while True:
            try:
                forgotten = await asyncio.to_thread(self._book.forget_finished, JOB_SECONDS)
                for job_id in forgotten:
                    async with self._input_lock(job_id):
                        await asyncio.to_thread(self._drop_unwanted_input, job_id)
            except (OSError, StoreUnavailableError):
                logger.exception("finished jobs could not be removed")
            else:
                if forgotten:
                    logger.info("%d finished jobs removed", len(forgotten))
            await asyncio.sleep(_FORGET_INTERVAL)

    def _drop_unwanted_input(self, job_id: str) -> None:
        """Remove the input of a forgotten job, unless its gamut is requested again.

        The input of a stored gamut stays for the repair of a damaged gamut.
        """
        if self._book.read(job_id) is not None or self._store.is_stored(job_id):
            return
        if not self._store.to_be_rebuilt(job_id):
            self._store.drop_input(job_id)
            self._store.names.drop(job_id)
            self._store.owners.drop(job_id)


def _progress(document: JobDocument) -> JobDocument:
    """Return the reported part of a job: progress in thousandths, without lease times."""
    return replace(
        document, updated="", lease_until=None, fraction=round(1000 * document.fraction) / 1000
    )
