"""What the routes of one app share: settings, store, opened gamuts, encoded meshes, builds."""

import asyncio
import contextlib
import logging
from collections.abc import AsyncIterator
from dataclasses import dataclass, field

from fastapi import Request

from gamutcore.warm import compile_reading_kernels
from service.builds import Builds
from service.library import Library
from service.meshes import Meshes
from service.metrics import Metrics
from service.settings import Settings
from service.store import GamutStore
from service.traces import Traces, traces_of

__all__ = ["Service", "service_of"]

logger = logging.getLogger(__name__)


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
    traces: Traces | None = field(init=False)
    warm: bool = False

    def __post_init__(self) -> None:
        self.traces = traces_of(self.settings.traces)
        self.store = GamutStore(self.settings.data)
        self.library = Library(self.store, self.settings.history_cache_bytes)
        self.meshes = Meshes(self.library, self.settings.mesh_cache_bytes)
        self.builds = Builds(self.settings, self.store)

    @property
    def ready(self) -> bool:
        """Whether a request would be answered without waiting for a compiler."""
        return self.warm and self.builds.warm

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
