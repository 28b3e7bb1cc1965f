"""Exception handlers: every exception that ends a request becomes a problem document.

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
from service.problems.problem import Problem, ProblemError, problem_response
from service.storage.blobs import StoreUnavailableError
from service.storage.gamuts import GamutDamagedError, GamutNotStoredError

if TYPE_CHECKING:
    from fastapi import FastAPI
    from starlette.requests import Request

__all__ = ["add_exception_handlers"]

logger = logging.getLogger(__name__)

_STATUS_CODES = {400: "bad-request", 404: "not-found", 405: "method-not-allowed"}
"""Problems that Starlette reports by status only."""

_LONGEST_PATH = 200
"""Number of characters of a path that a problem repeats."""


def add_exception_handlers(app: FastAPI) -> None:
    """Answer every exception of the app with a problem document.

    ``app.state.routes`` must hold all routes, for the header field ``Allow``.
    """
    app.add_exception_handler(ProblemError, _problem)
    app.add_exception_handler(GamutError, _core_error)
    app.add_exception_handler(GamutNotStoredError, _not_stored)
    app.add_exception_handler(GamutDamagedError, _damaged)
    app.add_exception_handler(StoreUnavailableError, _store_unavailable)
    app.add_exception_handler(RequestValidationError, _invalid_parameter)
    app.add_exception_handler(HTTPException, _http_error)
    app.add_exception_handler(ClientDisconnect, _disconnected)
    app.add_exception_handler(OSError, _system_error)
    app.add_exception_handler(Exception, _defect)


async def _problem(_request: Request, error: Exception) -> Response:
    assert isinstance(error, ProblemError)  # noqa: S101 - registered for this class
    return problem_response(error.problem)


async def _core_error(_request: Request, error: Exception) -> Response:
    assert isinstance(error, GamutError)  # noqa: S101 - registered for this class
    return problem_response(Problem.from_error(error))


async def _not_stored(request: Request, error: Exception) -> Response:
    """Rebuild a gamut that was found damaged earlier. Other gamuts were never built."""
    gamut_id = str(error.args[0])
    service = request.app.state.service
    try:
        damaged = await asyncio.to_thread(service.store.to_be_rebuilt, gamut_id)
    except StoreUnavailableError as unavailable:
        return await _store_unavailable(request, unavailable)
    except OSError as system_error:
        return await _system_error(request, system_error)
    if damaged:
        return await _rebuilding(request, gamut_id)
    return _no_gamut(gamut_id)


async def _damaged(request: Request, error: Exception) -> Response:
    """Rebuild a damaged gamut if its input is stored; else treat it as never built."""
    assert isinstance(error, GamutDamagedError)  # noqa: S101 - registered for this class
    gamut_id = str(error.args[0])
    return await _rebuilding(request, gamut_id) if error.input_kept else _no_gamut(gamut_id)


def _no_gamut(gamut_id: str) -> Response:
    detail = f"There is no gamut {gamut_id}."
    return problem_response(Problem("gamut-not-found", detail, {"field": "gamut_id"}))


async def _rebuilding(request: Request, gamut_id: str) -> Response:
    builds = request.app.state.service.builds
    try:
        job = await builds.rebuild(gamut_id)
    except ProblemError as refusal:
        return problem_response(refusal.problem)
    except StoreUnavailableError as unavailable:
        return await _store_unavailable(request, unavailable)
    except OSError as system_error:
        return await _system_error(request, system_error)
    seconds = 1 if job is None else builds.retry_after(job)
    return problem_response(
        Problem(
            "gamut-rebuilding",
            "The stored gamut does not match its digest and is being rebuilt.",
            {"job": f"/v1/jobs/{gamut_id}"},
            headers={"Retry-After": str(seconds)},
        )
    )


async def _store_unavailable(request: Request, error: Exception) -> Response:
    logger.error("%s %s: %s", request.method, request.url.path, error)
    return problem_response(Problem.store_unavailable())


async def _invalid_parameter(_request: Request, error: Exception) -> Response:
    assert isinstance(error, RequestValidationError)  # noqa: S101 - registered for this class
    first: dict[str, Any] = error.errors()[0]
    place, *names = first["loc"]
    field = ".".join(str(name) for name in names)
    where = {"in": place, "field": field}
    detail, remedy = f"{first['msg']}.", first.get("ctx", {}).get("remedy", "")
    if first["type"] == "missing":
        detail, remedy = f"The parameter {field!r} is missing.", f"Give {field}."
    return problem_response(Problem("invalid-parameter", detail, where, remedy))


async def _http_error(request: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException)  # noqa: S101 - registered for this class
    path = json.dumps(request.url.path[:_LONGEST_PATH], ensure_ascii=False)[1:-1]
    code = _STATUS_CODES.get(error.status_code, "bad-request")
    if code == "not-found":
        return problem_response(Problem(code, f"There is nothing at {path}."))
    if code == "method-not-allowed":
        allowed = _allowed_methods(request)
        detail = f"{request.method} is not allowed for {path}."
        headers = {"Allow": ", ".join(allowed)}
        return problem_response(Problem(code, detail, {"allowed": allowed}, headers=headers))
    return problem_response(Problem(code, "The request is malformed."))


async def _disconnected(_request: Request, _error: Exception) -> Response:
    # The client is gone and does not read the answer.
    return Response(status_code=400)


async def _system_error(request: Request, error: Exception) -> Response:
    assert isinstance(error, OSError)  # noqa: S101 - registered for this class
    remote: bool = request.app.state.service.store.blobs.remote
    problem = Problem.from_errno(error.errno, remote=remote)
    if problem is None:
        logger.error("%s %s", request.method, request.url.path, exc_info=error)
        return await _defect(request, error)
    # A full disk is not a defect, so no traceback is logged.
    logger.error("%s %s: %s", request.method, request.url.path, error)
    return problem_response(problem)


async def _defect(_request: Request, _error: Exception) -> Response:
    # The server closes the connection after an exception. A client that is not told would send its
    # next request there, and get no answer.
    headers = {"Connection": "close"}
    detail = "The request could not be answered."
    return problem_response(Problem("internal-error", detail, headers=headers))


def _allowed_methods(request: Request) -> list[str]:
    """Return the methods of all routes of a path, with HEAD wherever there is GET."""
    methods: set[str] = set()
    for route in request.app.state.routes:
        if route.matches(request.scope)[0] is not Match.NONE:
            methods |= set(getattr(route, "methods", None) or ())
    return sorted(methods | ({"HEAD"} if "GET" in methods else set()))
