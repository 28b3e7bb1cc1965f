"""The HTTP server of one process: uvicorn with connection limits and an early signal to stop.

uvicorn finishes the requests under way before it ends the app. Those requests wait for builds, so
the builds must hear of the signal first: they end or are given back while uvicorn waits.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import uvicorn

from service.http.protocol import ConnectionLimits, limited_protocol
from service.telemetry.request_observer import Refusals

if TYPE_CHECKING:
    from types import FrameType

    from fastapi import FastAPI

    from service.container import ServiceContainer
    from service.settings import Settings

__all__ = ["Server", "connection_limits", "server_config"]

_KEEP_ALIVE_SECONDS = 5
"""How long an idle connection stays open between requests. Each one holds a file descriptor, and
the next request of a page or a script comes sooner."""


class Server(uvicorn.Server):
    """A server that passes the signal to stop on to the service container.

    Parameters
    ----------
    config : uvicorn.Config
        With the app.
    service : ServiceContainer
        Of that app.
    """

    def __init__(self, config: uvicorn.Config, service: ServiceContainer) -> None:
        super().__init__(config)
        self._service = service

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:
        """Begin to stop."""
        super().handle_exit(sig, frame)
        self._service.drain()


def server_config(app: FastAPI, settings: Settings) -> uvicorn.Config:
    """Return uvicorn's configuration for an app of `create_app`."""
    figures = app.state.service.metrics.requests
    refusals = Refusals(figures, access_log=settings.access_log)
    return uvicorn.Config(
        app,
        host=settings.host,
        port=settings.port,
        log_config=None,
        log_level=settings.log_level,
        access_log=False,  # `service.telemetry.request_observer` writes the access log
        http=limited_protocol(connection_limits(settings), refusals),
        ws="none",
        # Off by default: otherwise any local client could choose the address it is counted under.
        proxy_headers=bool(settings.trusted_proxies),
        forwarded_allow_ips=settings.trusted_proxies,
        server_header=False,
        timeout_keep_alive=_KEEP_ALIVE_SECONDS,
        # Builds end or are given back within drain_seconds. Two seconds remain for the answers.
        timeout_graceful_shutdown=int(settings.drain_seconds) + 2,
    )


def connection_limits(settings: Settings) -> ConnectionLimits:
    """Return the limits of a connection that the settings ask for."""
    return ConnectionLimits(
        settings.max_connections,
        settings.max_head_bytes,
        settings.head_timeout,
        settings.body_timeout,
        settings.min_body_rate,
        settings.write_timeout,
    )
