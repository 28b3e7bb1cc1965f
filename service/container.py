"""The service container: one object per app that holds its settings, store, caches and builds.

`create_app` makes one container, and the app's lifespan opens and closes it. Routes reach it with
`service_of`. The choice of the build engine is made here, once, from the settings.
"""

import asyncio
import contextlib
from collections.abc import AsyncIterator, Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from fastapi import Request

from service.admission import Admission
from service.building.builds import Builds
from service.building.engine import BuildReport, Engine
from service.building.kernels import Kernels
from service.building.local_engine import LocalEngine
from service.http.bodies import Bodies
from service.jobs.book import JobBook
from service.jobs.events import EventStreams
from service.library import (
    PROCESS_BYTES,
    Library,
    keep_heap_small,
    memory_budget,
    return_free_pages,
)
from service.questions.pictures import Pictures
from service.questions.runner import QuestionRunner
from service.readiness import service_readiness
from service.settings import Settings
from service.storage import store_at
from service.storage.gamut_store import GamutStore
from service.telemetry.metrics import Metrics

__all__ = ["MISSING_BROKER_EXTRA", "EngineMissingError", "ServiceContainer", "service_of"]

_TRIM_SECONDS, _TRIM_BYTES = 1.0, 32 * 2**20
"""Interval of giving free pages of the heap back to the system, if so many bytes were released."""

_REMOTE_CALLS = 32
"""Number of simultaneous calls to a bucket. The calls wait for the network and do not compute, so
asyncio's default (cores + 4) would be too low."""


MISSING_BROKER_EXTRA = (
    "GAMUT_BROKER needs the extras `celery` and `cloud`: "
    'pip install "gamut-boundary-service[celery,cloud]"'
)


class EngineMissingError(Exception):
    """The settings ask for a broker, and the packages for brokers are not installed."""


class ServiceContainer:
    """The parts of a running service."""

    def __init__(self, settings: Settings) -> None:
        self.settings = settings
        self.stopping = False
        self.metrics = Metrics()
        self.kernels = Kernels()
        self._loop: asyncio.AbstractEventLoop | None = None
        self.store = store_at(
            settings.store,
            settings.store_bytes,
            settings.store_reserve_bytes,
            keep_inputs=settings.keep_inputs,
        )
        self.admission = Admission(
            memory_budget(settings) - PROCESS_BYTES,
            most_waiting=settings.client_requests,
            process=PROCESS_BYTES,
        )
        self.library = Library(
            self.store,
            self.admission,
            settings.history_cache_bytes,
            settings.mesh_cache_bytes,
        )
        self.questions = QuestionRunner(self.metrics.queries, self.library)
        self.pictures = Pictures(settings)
        self.bodies = Bodies(
            most_body=settings.max_body_bytes,
            most_large=settings.large_bodies,
            # A client can send the next body while one is computed, and cannot take all places.
            most_of_client=max(2, settings.large_bodies // 4),
            seconds=settings.body_timeout,
        )
        book = JobBook.of_store(self.store)
        engine = _build_engine(settings, self.store, book, self.metrics.builds.count_build)
        self.builds = Builds(self.store, book, engine)
        self.events = EventStreams()
        self.readiness = service_readiness(
            self.builds,
            self.store.blobs,
            self.kernels,
            stopping=lambda: self.stopping,
            needed_bytes=settings.store_reserve_bytes + settings.max_body_bytes,
        )

    @property
    def scratch_directory(self) -> Path:
        """Directory for temporary files, on the file system of a store directory."""
        return self.store.scratch("").parent

    @contextlib.asynccontextmanager
    async def running(self) -> AsyncIterator[None]:
        """Open the store and start the workers; drain the builds and close on leaving."""
        keep_heap_small()
        loop = self._loop = asyncio.get_running_loop()
        if self.store.blobs.remote:
            loop.set_default_executor(ThreadPoolExecutor(_REMOTE_CALLS, "store"))
        self.store.on_evicted = lambda gamut_id: _call_soon(loop, self.library.discard, gamut_id)
        await asyncio.to_thread(self.store.open)
        await self.builds.start()
        background = [
            asyncio.create_task(self.kernels.prepare()),
            asyncio.create_task(self._trim()),
        ]
        try:
            yield
        finally:
            for task in background:
                task.cancel()
            await asyncio.gather(*background, return_exceptions=True)
            await self.builds.stop()
            await self.pictures.close()
            self.library.close()
            # Closing joins threads, so it must not block the event loop.
            await asyncio.to_thread(self.store.close)

    def drain(self) -> None:
        """Stop starting builds. Called at the signal to stop, from any thread."""
        self.stopping = True
        if self._loop is not None:
            with contextlib.suppress(RuntimeError):
                self._loop.call_soon_threadsafe(self.builds.drain)

    async def _trim(self) -> None:
        """Give free pages back to the system. Never returns."""
        while True:
            await asyncio.sleep(_TRIM_SECONDS)
            if self.admission.freed >= _TRIM_BYTES:
                self.admission.freed = 0
                await asyncio.to_thread(return_free_pages)


def _build_engine(
    settings: Settings, store: GamutStore, book: JobBook, on_build: BuildReport
) -> Engine:
    """Return the engine that the settings select, not yet started.

    Without a broker, worker processes of this process build. With a broker, other machines build,
    and `EngineMissingError` means that the extra for brokers is not installed.
    """
    if not settings.broker:
        sole_owner = not store.blobs.remote
        return LocalEngine(settings, store, book, sole_owner=sole_owner, on_build=on_build)
    try:
        # Slow to import, and not installed by default.
        from service.broker.celery_engine import CeleryEngine  # noqa: PLC0415
    except ModuleNotFoundError as error:
        raise EngineMissingError(MISSING_BROKER_EXTRA) from error
    return CeleryEngine(settings, store, book)


def _call_soon(
    loop: asyncio.AbstractEventLoop, function: Callable[[str], None], argument: str
) -> None:
    """Call a function in the loop's thread, unless the loop is closed."""
    with contextlib.suppress(RuntimeError):
        loop.call_soon_threadsafe(function, argument)


def service_of(request: Request) -> ServiceContainer:
    """Return the service container of the app that serves a request."""
    service: ServiceContainer = request.app.state.service
    return service
