"""The HTTP server of one process: uvicorn with an early signal to stop.

`bind_sockets` takes the port before the app starts, so a busy port is reported before any work. At
SIGTERM, ``/readyz`` answers 503 first, and the server goes on for ``GAMUT_STOP_DELAY``, until load
balancers know. Then uvicorn finishes the requests under way before it ends the app. Those requests
wait for builds, so the builds must learn of the signal first. They end or are given back while
uvicorn waits.
"""

from __future__ import annotations

import asyncio
import errno
import logging
import os
import signal
import socket
from typing import TYPE_CHECKING

import uvicorn

from service.access.api_keys import KeyFileError
from service.access.hosts import is_loopback

if TYPE_CHECKING:
    from types import FrameType

    from fastapi import FastAPI

    from service.access.api_keys import ApiKeys
    from service.container import ServiceContainer
    from service.settings import Settings

__all__ = [
    "AddressUnavailableError",
    "Server",
    "bind_sockets",
    "server_config",
]

logger = logging.getLogger(__name__)

_HEAD_BYTES = 32 * 1024
"""Bytes of the longest request target and header fields, as for nginx. httptools has no limit."""

_KEEP_ALIVE_SECONDS = 75
"""How long an idle connection stays open between requests, as for nginx. Clients and proxies that
reuse connections give them up earlier: httpx after 5, load balancers after 60 seconds. If both
sides waited equally long, a request could meet the end of its connection."""

_REMEDIES = {
    errno.EADDRINUSE: "Stop the program that uses the port, or choose another port with --port or "
    "GAMUT_PORT; 0 takes a free one.",
    errno.EACCES: "Choose a port from 1024 on with --port or GAMUT_PORT.",
}
_OTHER_REMEDY = "Choose an address of this machine with --host or GAMUT_HOST."


class AddressUnavailableError(Exception):
    """The service cannot listen on its address. The message states port, cause and remedy."""

    def __init__(self, host: str, port: int, error: OSError) -> None:
        cause = error.strerror or str(error)
        if not isinstance(error, socket.gaierror) and error.errno:
            cause = os.strerror(error.errno)  # asyncio's text repeats the address
        remedy = _REMEDIES.get(error.errno or 0, _OTHER_REMEDY)
        super().__init__(f"cannot listen on {host} port {port}: {cause}. {remedy}")


class Server(uvicorn.Server):
    """A server that passes the signal to stop on to the service container of its app."""

    def __init__(self, config: uvicorn.Config, service: ServiceContainer) -> None:
        super().__init__(config)
        self._service = service
        self._loop: asyncio.AbstractEventLoop | None = None

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Start the app, then accept connections, and log the addresses.

        Raise `AddressUnavailableError` if another process listens on the port since `bind_sockets`.
        """
        self._loop = asyncio.get_running_loop()
        if self._service.settings.api_keys_file:
            self._loop.add_signal_handler(signal.SIGHUP, self._read_keys)
        try:
            await super().startup(sockets)
        except OSError as error:
            await self.lifespan.shutdown()
            raise AddressUnavailableError(self.config.host, self.config.port, error) from error
        for bound in sockets or ():  # uvicorn is silent about sockets that it did not bind
            host, port = bound.getsockname()[:2]
            address = f"[{host}]:{port}" if ":" in host else f"{host}:{port}"
            logger.info("Uvicorn running on http://%s (Press CTRL+C to quit)", address)
            logger.info("Viewer at http://%s/view", address)

    def _read_keys(self) -> None:
        """Read the file of the API keys again."""
        keys: ApiKeys = self.config.app.state.access_rules.keys  # type: ignore[union-attr]
        try:
            keys.read_file()
        except KeyFileError as error:
            logger.error("the API keys stay as they are: %s", error)  # noqa: TRY400 - the text has all
        else:
            logger.info("%d API keys read", len(keys))

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:
        """Begin to stop. A second signal ends the delay."""
        delay = self._service.settings.stop_delay
        if sig == signal.SIGTERM and delay and self._loop and not self._service.stopping:
            self._service.stopping = True
            logger.info("Not ready from now on; listening ends in %g s", delay)
            # The handler may have interrupted the event loop anywhere.
            self._loop.call_soon_threadsafe(self._loop.call_later, delay, self._stop, sig, None)
        else:
            self._stop(sig, frame)

    def _stop(self, sig: int, frame: FrameType | None) -> None:
        super().handle_exit(sig, frame)
        self._service.drain()


def bind_sockets(host: str, port: int) -> list[socket.socket]:
    """Return sockets that are bound to every address of a host, and do not listen yet.

    Port 0 takes a free port. Raise `AddressUnavailableError` if the port is in use, or if the host
    is not an address of this machine.
    """
    try:
        return asyncio.run(_bind(host, port))
    except OSError as error:
        raise AddressUnavailableError(host, port, error) from error


async def _bind(host: str, port: int) -> list[socket.socket]:
    # asyncio resolves the name and skips address families that are switched off.
    loop = asyncio.get_running_loop()
    server = await loop.create_server(asyncio.Protocol, host or None, port, start_serving=False)
    sockets = [bound.dup() for bound in server.sockets]
    server.close()
    return sockets


def server_config(app: FastAPI, settings: Settings) -> uvicorn.Config:
    """Return uvicorn's configuration for an app of `create_app`."""
    return uvicorn.Config(
        app,
        host=settings.host,
        port=settings.port,
        log_config=None,
        log_level=settings.log_level,
        access_log=False,  # `service.telemetry.request_observer` writes the access log
        # httptools is twice as fast, and has no limit for a head. A proxy has one.
        http="httptools" if settings.trusted_proxies or is_loopback(settings.host) else "h11",
        h11_max_incomplete_event_size=_HEAD_BYTES,
        limit_concurrency=settings.max_connections + 1,  # counts the new one
        ws="none",
        # Off by default: otherwise any local client could choose the address it is counted under.
        proxy_headers=bool(settings.trusted_proxies),
        forwarded_allow_ips=settings.trusted_proxies,
        server_header=False,
        timeout_keep_alive=_KEEP_ALIVE_SECONDS,
        # Builds end or are given back within drain_seconds. Two seconds remain for the answers.
        timeout_graceful_shutdown=int(settings.drain_seconds) + 2,
    )
