"""The handler of exceptions: every exception that ends a request becomes a problem document.

Exceptions come from `gamutcore` (content), the routes (`ProblemError`), FastAPI (parameters),
Starlette (unknown paths and methods), and defects. The text of an unexpected exception never
reaches a client.
"""

from __future__ import annotations

import asyncio
import json
import logging
from typing import TYPE_CHECKING, Any

from fastapi.exceptions import RequestValidationError
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect
from starlette.responses import Response
from starlette.routing import Match

from gamutcore.errors import GamutError
from service.problems.kinds import KINDS
from service.problems.problem import Problem, ProblemError, problem_response
from service.storage.blobs import StoreUnavailableError
from service.storage.gamut_store import GamutDamagedError, GamutNotStoredError

if TYPE_CHECKING:
    from collections.abc import Callable

    from fastapi import FastAPI
    from starlette.requests import Request
    from starlette.types import ASGIApp, Message, Receive, Scope, Send

__all__ = ["AnswerStopped", "add_exception_handlers", "answer_exception"]

logger = logging.getLogger(__name__)

_EXPECTED = (
    *(ProblemError, GamutError, GamutNotStoredError, StoreUnavailableError, OSError),
    *(RequestValidationError, HTTPException, ClientDisconnect),
)
"""Exceptions that are answered next to the router. Others are defects, and leave a traceback."""

_LONGEST_PATH = 200
"""Number of characters of a path that a problem repeats."""


def add_exception_handlers(app: FastAPI) -> None:
    """Answer every exception of the app with a problem document.

    ``app.state.routes`` must hold all routes, for the header field ``Allow``.
    """
    for kind in _EXPECTED:
        app.add_exception_handler(kind, answer_exception)


class AnswerStopped:
    """ASGI middleware that answers requests which the server cancels when it stops.

    The server cancels what is unfinished `GAMUT_DRAIN_SECONDS` after the signal to stop, and would
    log the cancellation as a defect. An answer that has begun is cut off. `is_stopping` tells
    cancellations of the server from others.
    """

    def __init__(self, app: ASGIApp, is_stopping: Callable[[], bool]) -> None:
        self.app = app
        self._is_stopping = is_stopping

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass the request on, or answer with the problem ``shutting-down``."""
        began = False

        async def observing_send(message: Message) -> None:
            nonlocal began
            began = True
            await send(message)

        try:
            await self.app(scope, receive, observing_send)
        except asyncio.CancelledError:
            if scope["type"] != "http" or not self._is_stopping():
                raise
            if not began:
                detail = "The service is stopping, and the request was not finished in time."
                headers = {"Retry-After": "5", "Connection": "close"}
                problem = Problem("shutting-down", detail, headers=headers)
                await problem_response(problem)(scope, receive, send)


async def answer_exception(request: Request, error: Exception) -> Response:
    """Return the answer to an exception."""
    if isinstance(error, ClientDisconnect):
        return Response(status_code=400)  # nobody reads it
    if isinstance(error, GamutNotStoredError):
        try:
            return problem_response(await _no_gamut(request, error))
        except (ProblemError, StoreUnavailableError, OSError) as refusal:
            error = refusal
    return problem_response(_problem(request, error))


def _problem(request: Request, error: Exception) -> Problem:
    """Return the problem of an exception."""
    problem: Problem | None = None
    match error:
        case ProblemError():
            problem = error.problem
        case GamutError():
            problem = Problem.from_error(error)
        case RequestValidationError():
            problem = _invalid_parameter(error)
        case HTTPException():
            problem = _http_error(request, error)
        case StoreUnavailableError():
            problem = Problem.store_unavailable()
            logger.error("%s %s: %s", request.method, request.url.path, error)
        case OSError():
            remote = request.app.state.service.store.blobs.remote
            problem = Problem.from_errno(error.errno, remote=remote)
            if problem is None:
                logger.error("%s %s", request.method, request.url.path, exc_info=error)
            else:  # a full disk is not a defect, so no traceback is logged
                logger.error("%s %s: %s", request.method, request.url.path, error)
    # The server closes the connection after a defect. A client that is not told would send its
    # next request there, and get no answer.
    headers = {"Connection": "close"}
    return problem or Problem("internal-error", KINDS["internal-error"].detail, headers=headers)


async def _no_gamut(request: Request, error: GamutNotStoredError) -> Problem:
    """Rebuild a damaged gamut whose input is stored. Other gamuts count as never built."""
    gamut_id = str(error.args[0])
    service = request.app.state.service
    if isinstance(error, GamutDamagedError):
        can_rebuild = error.input_kept
    else:
        can_rebuild = await asyncio.to_thread(service.store.to_be_rebuilt, gamut_id)
    if not can_rebuild:
        return Problem("gamut-not-found", f"There is no gamut {gamut_id}.", {"field": "gamut_id"})
    job = await service.builds.rebuild(gamut_id)
    seconds = 1 if job is None else service.builds.retry_after(job)
    return Problem(
        "gamut-rebuilding",
        KINDS["gamut-rebuilding"].detail,
        {"job": f"/v1/jobs/{gamut_id}"},
        headers={"Retry-After": str(seconds)},
    )


def _invalid_parameter(error: RequestValidationError) -> Problem:
    first: dict[str, Any] = error.errors()[0]
    place, *names = first["loc"]
    field = ".".join(str(name) for name in names)
    detail, remedy = f"{first['msg']}.", first.get("ctx", {}).get("remedy", "")
    if first["type"] == "missing":
        detail, remedy = f"The parameter {field!r} is missing.", f"Give {field!r} once."
    return Problem("invalid-parameter", detail, {"in": place, "field": field}, remedy)


def _http_error(request: Request, error: HTTPException) -> Problem:
    """Return the problem of an error of Starlette, which has a status only."""
    path = json.dumps(request.url.path[:_LONGEST_PATH], ensure_ascii=False)[1:-1]
    if error.status_code == 404:
        return Problem("not-found", f"There is nothing at {path}.")
    if error.status_code == 405:
        allowed = _allowed_methods(request)
        detail = f"{request.method} is not allowed for {path}."
        headers = {"Allow": ", ".join(allowed)}
        return Problem("method-not-allowed", detail, {"allowed": allowed}, headers=headers)
    return Problem("bad-request", KINDS["bad-request"].detail)


def _allowed_methods(request: Request) -> list[str]:
    """Return the methods of all routes of a path, with HEAD wherever there is GET."""
    methods: set[str] = set()
    for route in request.app.state.routes:
        if route.matches(request.scope)[0] is not Match.NONE:
            methods |= set(getattr(route, "methods", None) or ())
    return sorted(methods | ({"HEAD"} if "GET" in methods else set()))
