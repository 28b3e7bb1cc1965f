"""The commands of the service: serve, worker, store, key and openapi.

`service.__main__` has the command line. Each function returns the exit status.
"""

import difflib
import json
import logging
import os
import resource
import sys
import tempfile
from collections.abc import Callable
from typing import Any

from pydantic import ValidationError

from service.access.api_keys import KeyFileError, new_key
from service.access.middleware import OpenToAllError
from service.application import create_app
from service.building.process import hide_memory
from service.container import MISSING_BROKER_EXTRA, EngineMissingError
from service.server import AddressUnavailableError, Server, bind_sockets, server_config
from service.settings import ENVIRONMENT_PREFIX, Settings, settings_text
from service.storage import StoreLocationError, store_at
from service.storage.blobs import StoreUnavailableError
from service.storage.gamut_store import GamutStore
from service.storage.local import LocalBlobs, StoreInUseError
from service.storage.maintenance import list_gamuts, prune
from service.telemetry.logs import complain, configure_logging

__all__ = [
    "check_worker",
    "list_store",
    "make_key",
    "openapi_document",
    "print_settings",
    "prune_store",
    "raise_file_limit",
    "serve",
    "work",
]

logger = logging.getLogger(__name__)


def openapi_document() -> str:
    """Return the text of ``openapi/openapi.json``, independent of the environment.

    One member a line shows every change; indentation would be half of the file.
    """
    document = create_app(Settings.model_construct()).openapi()
    return json.dumps(document, indent=0, ensure_ascii=False, separators=(",", ":")) + "\n"


def raise_file_limit() -> None:
    """Raise the limit of open files to the hard limit.

    The usual soft limit of 1024 exists for programs that use ``select``. This program does not.
    """
    _, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    try:
        resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))
    except (OSError, ValueError) as error:
        # Some systems do not grant their own hard limit.
        logger.warning("limit of open files was not raised: %s", error)


def make_key(name: str, scopes: frozenset[str], expiry: str = "") -> int:
    """Print a new API key and its entry for the settings."""
    try:
        key, known = new_key(name, scopes, expiry)
    except ValueError as error:
        sys.stderr.write(f"gamut: {error}\n")
        return 2
    # The entry is not secret. The key is shown only once.
    sys.stdout.write(
        f"key, for the client:       {key}\nentry for GAMUT_API_KEYS:  {known.entry}\n"
    )
    return 0


def list_store(location: str | None, *, outdated: bool) -> int:
    """Print the gamuts of a store, by default that of the settings."""

    def show(store: GamutStore) -> None:
        # A directory is read without its lock, which a running service has.
        if not isinstance(store.blobs, LocalBlobs):
            store.open()
        elif not store.blobs.directory.is_dir():
            message = f"{store.blobs.directory} is not a directory."
            raise StoreLocationError(message)
        list_gamuts(store, sys.stdout, outdated=outdated)

    return _maintain(location, show)


def prune_store(location: str | None, *, older_than: float, confirmed: bool) -> int:
    """Remove outdated gamuts from a store, by default that of the settings, and print them."""

    def remove(store: GamutStore) -> None:
        store.open()
        prune(store, sys.stdout, older_than=older_than, confirmed=confirmed)

    return _maintain(location, remove)


def _maintain(location: str | None, act: Callable[[GamutStore], None]) -> int:
    """Call a function with a store, close the store, and return the exit status."""
    try:
        store = store_at(location or Settings().store)
    except ValueError as error:
        sys.stderr.write(f"gamut: {error}\n")
        return 2
    try:
        act(store)
    except StoreLocationError as error:
        sys.stderr.write(f"gamut: {error}\n")
        return 2
    except (StoreInUseError, StoreUnavailableError, OSError) as error:
        sys.stderr.write(f"gamut: {error}\n")
        return 1
    finally:
        store.close()
    return 0


def _settings(overrides: dict[str, Any]) -> Settings | None:
    """Return the settings and configure the log; return None after printing faults."""
    values = {name: value for name, value in overrides.items() if value is not None}
    try:
        settings = Settings(**values)
    except ValidationError as error:
        # The settings are not known, so the format of the log is taken from its variable.
        if _log_format_in_environment() == "json":
            configure_logging("json", "info")
        for fault in error.errors():
            variable = ENVIRONMENT_PREFIX + "_".join(map(str, fault["loc"])).upper()
            complain(f"{variable}: {fault['msg']}")
        return None
    configure_logging(settings.log_format, settings.log_level)
    known = {f"{ENVIRONMENT_PREFIX}{name}".upper() for name in Settings.model_fields}
    given_names = sorted(name for name in os.environ if name.startswith(ENVIRONMENT_PREFIX))
    for name in given_names:
        if name.upper() not in known:
            # A misspelt limit or key would otherwise stay unnoticed.
            near = difflib.get_close_matches(name.upper(), known, 1)
            remedy = f" Did you mean {near[0]}?" if near else ""
            logger.warning("%s is not a setting and is ignored.%s", name, remedy)
    return settings


def _log_format_in_environment() -> str:
    """Return the value of GAMUT_LOG_FORMAT; names are not case-sensitive."""
    names = {name.upper(): value for name, value in os.environ.items()}
    return names.get(f"{ENVIRONMENT_PREFIX}LOG_FORMAT", "")


def check_worker() -> int:
    """Check that a worker on this host is connected to its broker."""
    return _with_broker(_check_worker)


def work() -> int:
    """Build the jobs of a broker until the process is told to end."""
    return _with_broker(_work)


def _with_broker(act: Callable[[Settings], int]) -> int:
    """Call a function with the settings of a worker, and return the exit status."""
    settings = _settings({})
    if settings is None:
        return 2
    if not settings.broker:
        complain("GAMUT_BROKER: must be set for a worker")
        return 2
    hide_memory()
    try:
        return act(settings)
    except ModuleNotFoundError:
        complain(MISSING_BROKER_EXTRA)
    return 1


def _check_worker(settings: Settings) -> int:
    from service.broker.celery_worker import check_worker  # noqa: PLC0415 - slow to import

    fault = check_worker(settings)
    if fault is not None:
        sys.stdout.write(f"{fault}\n")
    return 0 if fault is None else 1


def _work(settings: Settings) -> int:
    from service.broker.celery_worker import run_worker  # noqa: PLC0415 - slow to import

    return run_worker(settings)


def print_settings(overrides: dict[str, Any]) -> int:
    """Print the settings in force with their sources."""
    settings = _settings(overrides)
    if settings is None:
        return 2
    arguments = {name for name, value in overrides.items() if value is not None}
    sys.stdout.write(settings_text(settings, arguments))
    return 0


def serve(overrides: dict[str, Any]) -> int:
    """Serve over HTTP until the process is told to end.

    `overrides` are settings from the command line; None where not given.
    """
    settings = _settings(overrides)
    if settings is None:
        return 2
    raise_file_limit()
    hide_memory()
    try:
        app = create_app(settings)
        store: GamutStore = app.state.service.store
        # Errors in the lifespan would give a traceback; here they give a sentence.
        store.open()
        if not store.blobs.remote:
            # Bodies are on the file system of the store, which has room for their gamuts.
            tempfile.tempdir = str(app.state.service.scratch_directory)
        store.close()
        sockets = bind_sockets(settings.host, settings.port)
    except (KeyFileError, OpenToAllError) as error:
        complain(str(error))
        return 2
    except (
        AddressUnavailableError,
        EngineMissingError,
        StoreInUseError,
        StoreLocationError,
        StoreUnavailableError,
        OSError,
    ) as error:
        complain(str(error))
        return 1
    server = Server(server_config(app, settings), app.state.service)
    try:
        server.run(sockets)
    except AddressUnavailableError as error:
        complain(str(error))
        return 1
    return 0 if server.started else 1
