"""The console script ``gamut``: serve, worker, store, key, openapi and warm."""

import argparse
import json
import logging
import os
import resource
import sys
from collections.abc import Sequence
from typing import Any

from pydantic import ValidationError

from gamutcore.version import __version__
from service.access.api_keys import new_key
from service.access.middleware import OpenToAllError
from service.application import create_app
from service.broker import health
from service.container import MISSING_BROKER_EXTRA, EngineMissingError
from service.server import AddressUnavailableError, Server, bind_sockets, server_config
from service.settings import ENVIRONMENT_PREFIX, Settings, settings_text
from service.storage.blobs import StoreUnavailableError
from service.storage.check import report
from service.storage.gamuts import GamutStore
from service.storage.local import StoreInUseError
from service.storage.location import StoreLocationError, blobs_at, is_address
from service.telemetry.logs import configure_logging
from service.telemetry.traces import TracesUnavailableError

__all__ = ["main", "openapi_document", "raise_file_limit"]

logger = logging.getLogger(__name__)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return the exit status.

    Parameters
    ----------
    arguments : sequence of str, optional
        Command line without the program's name; by default that of the process.
    """
    parser = argparse.ArgumentParser(prog="gamut", description="Gamut boundary service.")
    parser.add_argument("--version", action="version", version=__version__)
    commands = parser.add_subparsers(dest="command", required=True)
    serve = commands.add_parser(
        "serve", help="serve over HTTP; further settings come from the environment (GAMUT_...)"
    )
    serve.add_argument("--host", help="address to listen on")
    serve.add_argument("--port", type=int, help="port to listen on; 0 takes a free one")
    serve.add_argument("--store", help="location of the store: a directory, or s3://, gs://, az://")
    serve.add_argument(
        "--print-settings",
        action="store_true",
        help="print the settings in force as GAMUT_NAME=value lines, and exit",
    )
    worker = commands.add_parser(
        "worker", help="build the jobs of a broker (GAMUT_BROKER, GAMUT_STORE)"
    )
    worker.add_argument("--check", action="store_true", help="only check the workers on this host")
    key = commands.add_parser("key", help="make an API key and its entry for GAMUT_API_KEYS")
    key.add_argument("name", help="lower-case letters, digits and hyphens; public")
    key.add_argument("--scopes", default="read+write", help="read, write or read+write (default)")
    commands.add_parser("openapi", help="print the OpenAPI document")
    commands.add_parser("warm", help="compile the kernels in advance")
    store = commands.add_parser("store", help="maintain a store")
    check = store.add_subparsers(dest="store_command", required=True).add_parser(
        "check", help="check that a store keeps the guarantees of the service"
    )
    check.add_argument("location", nargs="?", help="GAMUT_STORE by default")
    parsed = parser.parse_args(arguments)
    if parsed.command == "serve":
        overrides = {name: getattr(parsed, name) for name in ("host", "port", "store")}
        return _print_settings(overrides) if parsed.print_settings else _serve(overrides)
    if parsed.command == "worker":
        return health.main() if parsed.check else _worker()
    if parsed.command == "store":
        return _check_store(parsed.location)
    if parsed.command == "key":
        return _key(parsed.name, frozenset(parsed.scopes.split("+")))
    if parsed.command == "openapi":
        sys.stdout.write(openapi_document())
    else:
        from gamutcore.warm import compile_kernels  # noqa: PLC0415  # a server compiles nothing

        compile_kernels()
    return 0


def openapi_document() -> str:
    """Return the text of ``openapi/openapi.json``, independent of the environment."""
    document = create_app(Settings.model_construct()).openapi()
    return json.dumps(document, indent=2, ensure_ascii=False) + "\n"


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


def _key(name: str, scopes: frozenset[str]) -> int:
    try:
        key, known = new_key(name, scopes)
    except ValueError as error:
        sys.stderr.write(f"gamut: {error}\n")
        return 2
    # The entry is not secret. The key is shown only once.
    sys.stdout.write(
        f"key, for the client:       {key}\nentry for GAMUT_API_KEYS:  {known.entry}\n"
    )
    return 0


def _check_store(location: str | None) -> int:
    try:
        # Two clients of a bucket behave like two machines. A directory has one owner.
        location = location or Settings().store
        blobs = blobs_at(location)
        another = blobs_at(location) if is_address(location) else blobs
    except ValueError as error:
        sys.stderr.write(f"gamut: {error}\n")
        return 2
    return report(blobs, another, sys.stdout)


def _settings(overrides: dict[str, Any]) -> Settings | None:
    """Return the settings and configure the log; return None after printing faults."""
    given = {name: value for name, value in overrides.items() if value is not None}
    try:
        settings = Settings(**given)
    except ValidationError as error:
        for fault in error.errors():
            variable = ENVIRONMENT_PREFIX + "_".join(map(str, fault["loc"])).upper()
            sys.stderr.write(f"gamut: {variable}: {fault['msg']}\n")
        return None
    configure_logging(settings.log_format, settings.log_level)
    known = {f"{ENVIRONMENT_PREFIX}{name}".upper() for name in Settings.model_fields}
    given_names = sorted(name for name in os.environ if name.startswith(ENVIRONMENT_PREFIX))
    if unknown := [name for name in given_names if name.upper() not in known]:
        # A misspelt limit or key would otherwise stay unnoticed.
        logger.warning("unknown settings are ignored: %s", ", ".join(unknown))
    return settings


def _worker() -> int:
    settings = _settings({})
    if settings is None:
        return 2
    if not settings.broker:
        sys.stderr.write("gamut: GAMUT_BROKER: must be set for a worker\n")
        return 2
    try:
        # Slow to import, and not installed by default.
        from service.broker.celery_worker import run_worker  # noqa: PLC0415
    except ModuleNotFoundError:
        sys.stderr.write(f"gamut: {MISSING_BROKER_EXTRA}\n")
        return 1
    try:
        return run_worker(settings)
    except TracesUnavailableError as error:
        sys.stderr.write(f"gamut: {error}\n")
        return 1


def _print_settings(overrides: dict[str, Any]) -> int:
    settings = _settings(overrides)
    if settings is None:
        return 2
    arguments = {name for name, value in overrides.items() if value is not None}
    sys.stdout.write(settings_text(settings, arguments))
    return 0


def _serve(overrides: dict[str, Any]) -> int:
    settings = _settings(overrides)
    if settings is None:
        return 2
    raise_file_limit()
    try:
        app = create_app(settings)
        store: GamutStore = app.state.service.store
        # Errors in the lifespan would give a traceback; here they give a sentence.
        store.open()
        store.close()
        sockets = bind_sockets(settings.host, settings.port)
    except OpenToAllError as error:
        sys.stderr.write(f"gamut: {error}\n")
        return 2
    except (
        AddressUnavailableError,
        EngineMissingError,
        StoreInUseError,
        StoreLocationError,
        StoreUnavailableError,
        TracesUnavailableError,
        OSError,
    ) as error:
        sys.stderr.write(f"gamut: {error}\n")
        return 1
    server = Server(server_config(app, settings), app.state.service)
    try:
        server.run(sockets)
    except AddressUnavailableError as error:
        sys.stderr.write(f"gamut: {error}\n")
        return 1
    return 0 if server.started else 1
