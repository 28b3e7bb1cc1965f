"""What the routes of one app share: settings, store, opened gamuts, encoded meshes, builds."""

import asyncio
import contextlib
import logging
from collections.abc import AsyncIterator, Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

from fastapi import Request

from gamutcore.warm import compile_reading_kernels
from service.building.builds import Builds
from service.building.choice import engine_for
from service.jobs.book import JobBook
from service.jobs.events import EventStreams
from service.meshes.encoded_meshes import Meshes
from service.meshes.library import Library
from service.settings import Settings
from service.storage.gamuts import GamutStore
from service.storage.location import gamut_store
from service.telemetry.build_observer import BuildObserver
from service.telemetry.metrics import Metrics
from service.telemetry.readiness import Readiness, service_readiness
from service.telemetry.traces import Traces, traces_of

__all__ = ["Service", "service_of"]

logger = logging.getLogger(__name__)

_LARGE_BODIES = 2
"""Complete bodies of more than a megabyte that are in memory at the same time, until their builds
are accepted; the rest waits on the disk."""

_REMOTE_CALLS = 32
"""Calls of a bucket under way at a time. They wait, and compute nothing; asyncio's own number of
threads is that of the cores and four."""


@dataclass
class Service:
    """The parts of a running service.

    Attributes
    ----------
    warm : bool
        Whether this process has loaded the kernels that levels are read with.
    """

    settings: Settings
    store: GamutStore = field(init=False)
    library: Library = field(init=False)
    meshes: Meshes = field(init=False)
    builds: Builds = field(init=False)
    metrics: Metrics = field(init=False, default_factory=Metrics)
    readiness: Readiness = field(init=False)
    traces: Traces | None = field(init=False)
    events: EventStreams = field(init=False)
    warm: bool = False
    large_bodies: asyncio.Semaphore = field(
        default_factory=lambda: asyncio.Semaphore(_LARGE_BODIES)
    )
    _loop: asyncio.AbstractEventLoop | None = field(init=False, default=None)

    def __post_init__(self) -> None:
        self.traces = traces_of(self.settings.traces)
        self.store = gamut_store(self.settings)
        self.library = Library(self.store, self.settings.history_cache_bytes)
        self.meshes = Meshes(self.library, self.settings.mesh_cache_bytes)
        book = JobBook(
            self.store.blobs,
            self.settings.build_attempts,
            lost_options=self.store.options_of_damaged_job,
            on_damaged=self.store.count_damaged_job,
        )
        engine = engine_for(
            self.settings, self.store, book, BuildObserver(self.metrics.builds, self.traces)
        )
        self.builds = Builds(self.settings, self.store, book, engine)
        self.events = EventStreams(self.settings.max_event_streams)
        self.readiness = service_readiness(self)

    @property
    def scratch_directory(self) -> Path:
        """Where files may be that have no name, such as bodies that are arriving."""
        return self.store.scratch("").parent

    @contextlib.asynccontextmanager
    async def running(self) -> AsyncIterator[None]:
        """Open the store and start the workers; drain and close on leaving."""
        loop = self._loop = asyncio.get_running_loop()
        if self.store.blobs.remote:
            loop.set_default_executor(ThreadPoolExecutor(_REMOTE_CALLS, "store"))
        self.store.on_evicted = lambda gamut_id: _soon(loop, self.forget, gamut_id)
        await asyncio.to_thread(self.store.open)
        await self.builds.start()
        warming = asyncio.create_task(self._warm())
        try:
            yield
        finally:
            warming.cancel()
            await self.builds.stop()
            self.library.close()
            # It waits for its threads.
            await asyncio.to_thread(self.store.close)
            if self.traces is not None:
                await asyncio.to_thread(self.traces.close)

    def drain(self) -> None:
        """Let no builds begin any more; to be called at the signal to stop, in any thread."""
        if self._loop is not None:
            with contextlib.suppress(RuntimeError):
                self._loop.call_soon_threadsafe(self.builds.drain)

    def forget(self, gamut_id: str) -> None:
        """Drop from memory what belongs to a deleted gamut."""
        self.library.discard(gamut_id)
        self.meshes.discard_gamut(gamut_id)

    async def _warm(self) -> None:
        # At the same time as the worker, which needs other kernels besides: reading a history
        # and writing a mesh is all that this process does.
        await self.library.in_thread(compile_reading_kernels)
        self.warm = True
        logger.info("ready")


def _soon(loop: asyncio.AbstractEventLoop, function: Callable[[str], None], argument: str) -> None:
    """Call a function in the loop's thread, unless the loop has come to its end."""
    with contextlib.suppress(RuntimeError):
        loop.call_soon_threadsafe(function, argument)


def service_of(request: Request) -> Service:
    """Return the service that a request was sent to."""
    service: Service = request.app.state.service
    return service
