"""Which engine the settings ask for, and who takes jobs from a broker."""

from __future__ import annotations

from typing import TYPE_CHECKING

from service.building.embedded import EmbeddedEngine

if TYPE_CHECKING:
    from service.building.engine import BuildReport, Engine
    from service.jobs.book import JobBook
    from service.settings import Settings
    from service.storage.gamuts import GamutStore

__all__ = ["EngineMissingError", "engine_for", "run_worker"]

_EXTRA = 'a broker needs the extra `celery`: pip install "gamut-boundary-service[celery,cloud]"'


class EngineMissingError(Exception):
    """What the settings ask for is not installed."""


def engine_for(
    settings: Settings, store: GamutStore, book: JobBook, on_build: BuildReport | None = None
) -> Engine:
    """Return the engine that the settings ask for, not yet started.

    Parameters
    ----------
    settings : Settings
        Without a broker, builds are done in worker processes of this one.
    store : GamutStore
        Where inputs are and gamuts go.
    book : JobBook
        The jobs.
    on_build : callable, optional
        Told of the end of every build that is done here.

    Raises
    ------
    EngineMissingError
        Brokers need an extra that is not installed.
    """
    if not settings.broker:
        return EmbeddedEngine(
            settings, store, book, sole_owner=not store.blobs.remote, on_build=on_build
        )
    try:
        # Slow to import, and not installed by default.
        from service.broker.celery_engine import CeleryEngine  # noqa: PLC0415
    except ModuleNotFoundError as error:
        raise EngineMissingError(_EXTRA) from error
    return CeleryEngine(settings, store, book)


def run_worker(settings: Settings) -> int:
    """Take jobs from the broker until the process is told to end; return the exit status.

    Raises
    ------
    EngineMissingError
        Brokers need an extra that is not installed.
    """
    try:
        from service.broker import celery_worker  # noqa: PLC0415 - as above
    except ModuleNotFoundError as error:
        raise EngineMissingError(_EXTRA) from error
    return celery_worker.run_worker(settings)
