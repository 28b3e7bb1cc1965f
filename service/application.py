"""Application factory: settings in, a FastAPI app out.

`create_app` connects the service container, the routes and the exception handlers.
`_layers` lists all middleware. The OpenAPI document is in `service.openapi.document`.
"""

import contextlib
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

from fastapi import Depends, FastAPI, Request
from fastapi.responses import Response
from starlette.middleware import Middleware
from starlette.middleware.errors import ServerErrorMiddleware

from service.access.api_keys import ApiKeys
from service.access.hosts import Hosts, host_names, is_loopback
from service.access.middleware import ANONYMOUS_SCOPES, Access, AccessRules, OpenToAllError
from service.access.rate_limits import TokenBuckets
from service.container import ServiceContainer
from service.http.cors import Cors, origins
from service.http.requests import ControlCharacters, HeadAsGet
from service.openapi.document import APP_METADATA, openapi_document
from service.problems.handlers import AnswerStopped, add_exception_handlers, answer_exception
from service.routes import (
    gamuts,
    jobs,
    links,
    matches,
    meshes,
    metrics,
    names,
    pages,
    questions,
    references,
    state,
    viewer,
    views,
)
from service.routes.dependencies import check_request
from service.routes.jobs import PendingBuildError
from service.settings import Settings
from service.telemetry.metrics import StateCollector
from service.telemetry.request_observer import RequestObserver

__all__ = ["access_rules", "create_app"]

_ROUTERS = (
    questions.router,  # first: routes are tried in turn, and single colours are asked most often
    *(gamuts.router, names.router, meshes.router, references.router, jobs.router),
    *views.routers,
    *(links.router, matches.router),
    *(state.router, metrics.router, pages.router, viewer.router),
)


def create_app(settings: Settings) -> FastAPI:
    """Return the app for these settings. Nothing is opened before its lifespan begins.

    Raise `OpenToAllError` and `KeyFileError` as `access_rules` does.
    """
    rules = access_rules(settings)
    service = ServiceContainer(settings)
    service.metrics.registry.register(StateCollector(lambda: metrics.state_families(service)))

    @contextlib.asynccontextmanager
    async def lifespan(_app: FastAPI) -> AsyncIterator[None]:
        async with service.running():
            yield

    app = _Application(
        **APP_METADATA,
        middleware=_layers(service, rules),
        dependencies=[Depends(check_request)],
        openapi_url=None,  # `service.routes.viewer` serves both with an entity tag
        docs_url=None,
        redoc_url=None,
        redirect_slashes=False,
        lifespan=lifespan,
    )
    app.state.service = service
    app.state.access_rules = rules
    app.router.routes += [ControlCharacters(), meshes.PlainMeshRoute(service.library)]
    for router in _ROUTERS:
        app.include_router(router)
    app.state.routes = [route for router in _ROUTERS for route in router.routes]
    add_exception_handlers(app)
    app.add_exception_handler(PendingBuildError, _pending)
    return app


async def _pending(_request: Request, error: Exception) -> Response:
    assert isinstance(error, PendingBuildError)  # noqa: S101 - registered for this class
    return error.response


class _Application(FastAPI):
    """FastAPI with this service's OpenAPI document."""

    def openapi(self) -> dict[str, Any]:
        """Return the OpenAPI document."""
        if self.openapi_schema is None:
            self.openapi_schema = openapi_document(self)
        return self.openapi_schema


def _layers(service: ServiceContainer, rules: AccessRules) -> list[Middleware]:
    """Return all middleware, the outermost first."""
    settings = service.settings
    allowed = origins(settings.cors_origins)
    trusting = is_loopback(settings.host) and not rules.keys
    hosts = Hosts(host_names(settings.hosts), trusting=trusting, origins=allowed)
    return [
        # ids, times, metrics and log of the answers of all layers
        Middleware(RequestObserver, service.metrics.requests, access_log=settings.access_log),
        # requests that the server cancels when it stops
        Middleware(AnswerStopped, lambda: service.stopping),
        # browsers must be able to read every answer, refusals and defects included
        *([Middleware(Cors, allowed)] if allowed else []),
        # Starlette has one outside of all middleware, whose answers would have no id
        Middleware(ServerErrorMiddleware, answer_exception),
        # everything inside sees GET only
        Middleware(HeadAsGet),
        # names of the service, keys and rate limits, before anything is read or computed
        Middleware(Access, hosts=hosts, rules=rules, reading=questions.READING_POSTS),
    ]


def access_rules(settings: Settings) -> AccessRules:
    """Return the rules for keys, anonymous requests and rate limits.

    Raise `OpenToAllError` if the service would be open on a public address without keys or an
    explicit setting. Raise `KeyFileError` if the file of the API keys cannot be read.
    """
    keys = ApiKeys(
        settings.api_keys, Path(settings.api_keys_file) if settings.api_keys_file else None
    )
    anonymous = settings.allow_anonymous
    if anonymous == "auto":
        if not keys and not is_loopback(settings.host):
            message = (
                f"{settings.host} is not a loopback address, and there are no API keys. Set "
                "GAMUT_API_KEYS to the entry that `gamut key NAME` prints, or set "
                "GAMUT_ALLOW_ANONYMOUS=all to let everybody build and delete."
            )
            raise OpenToAllError(message)
        anonymous = "none" if keys else "all"
    requests = builds = None
    if settings.rate_limit:
        requests = TokenBuckets(settings.rate_limit, settings.rate_burst)
    if settings.build_rate_limit:
        builds = TokenBuckets(settings.build_rate_limit / 60.0, settings.build_rate_burst)
    return AccessRules(keys, ANONYMOUS_SCOPES[anonymous], requests, builds)
