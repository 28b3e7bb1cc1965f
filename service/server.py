"""The HTTP server of one process: uvicorn, which tells the service at once that it is to stop.

uvicorn lets the requests under way finish first and only then ends the app. Those requests wait for
builds, so the builds have to know of the signal before: they end or are given back while uvicorn
waits.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import uvicorn

if TYPE_CHECKING:
    from types import FrameType

    from service.container import Service

__all__ = ["Server"]


class Server(uvicorn.Server):
    """A server that passes the signal to stop on to its service.

    Parameters
    ----------
    config : uvicorn.Config
        With the app.
    service : Service
        Of that app.
    """

    def __init__(self, config: uvicorn.Config, service: Service) -> None:
        super().__init__(config)
        self._service = service

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:
        """Begin to stop."""
        super().handle_exit(sig, frame)
        self._service.drain()
