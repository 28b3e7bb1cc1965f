"""What the routes of one app share: settings, store, opened gamuts, encoded meshes, builds."""

import asyncio
import contextlib
import logging
from collections.abc import AsyncIterator
from dataclasses import dataclass, field
from typing import NamedTuple

from fastapi import Request

from gamutcore.warm import compile_reading_kernels
from service.builds import Builds
from service.library import Library
from service.meshes import Meshes
from service.metrics import Metrics
from service.readiness import Readiness, service_readiness
from service.settings import Settings
from service.storage.gamuts import GamutStore
from service.storage.location import gamut_store
from service.traces import Traces, traces_of

__all__ = ["Service", "service_of"]

logger = logging.getLogger(__name__)


class BuildFacts(NamedTuple):
    """What the builds of a service are about.

    Attributes
    ----------
    queued, running : int
        Builds that wait for a worker, and that a worker is busy with.
    workers, warm_workers : int
        Worker processes that there should be, and that are ready to build at once.
    completed : int
        Gamuts that were built since the start.
    capacity : int
        Builds that may wait.
    """

    queued: int
    running: int
    workers: int
    warm_workers: int
    completed: int
    capacity: int


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
    warm: bool = False

    def __post_init__(self) -> None:
        self.traces = traces_of(self.settings.traces)
        self.store = gamut_store(self.settings)
        self.library = Library(self.store, self.settings.history_cache_bytes)
        self.meshes = Meshes(self.library, self.settings.mesh_cache_bytes)
        self.builds = Builds(self.settings, self.store)
        self.readiness = service_readiness(self)

    def build_facts(self) -> BuildFacts:
        """Return what the builds are about."""
        builds = self.builds
        return BuildFacts(
            queued=builds.queued,
            running=builds.running,
            workers=self.settings.build_workers,
            warm_workers=builds.warm_workers,
            completed=builds.completed,
            capacity=self.settings.build_queue,
        )

    @contextlib.asynccontextmanager
    async def running(self) -> AsyncIterator[None]:
        """Open the store and start the workers; drain and close on leaving."""
        await asyncio.to_thread(self.store.open)
        self.builds.start()
        warming = asyncio.create_task(self._warm())
        try:
            yield
        finally:
            warming.cancel()
            await self.builds.stop()
            self.library.close()
            self.store.close()
            if self.traces is not None:
                await asyncio.to_thread(self.traces.close)

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


def service_of(request: Request) -> Service:
    """Return the service that a request was sent to."""
    service: Service = request.app.state.service
    return service
