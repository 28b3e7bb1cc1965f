"""Puts the service together: settings in, a FastAPI app out.

Everything that lives as long as the app (store, workers, caches) is in `service.container.Service`,
opened and closed by the app's lifespan. The ASGI layers are, from the outside: the request's id and
times, other origins (CORS); then, within Starlette's, which answers defects: HEAD answered as GET,
keys and rate limits, plain requests for meshes, the limit for bodies, the refusal of control
characters in paths.
"""

import contextlib
from collections.abc import AsyncIterator
from typing import Any

from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi
from starlette.types import ASGIApp

from gamutcore.version import __version__
from service.access.middleware import Access, AccessRules
from service.container import Service
from service.http.cors import Cors, origins
from service.http.middleware import BodyLimit, HeadAsGet, PlainPaths
from service.http.request_id import RequestIds
from service.meshes.fast_path import MeshFront
from service.openapi import models, request_models
from service.openapi.documentation import SECURITY, SECURITY_SCHEMES
from service.problems.handlers import add_exception_handlers
from service.routes import batch, gamuts, jobs, meshes, metrics, pages, state, swagger_ui
from service.settings import Settings
from service.telemetry.request_observer import Observed
from service.telemetry.server_timing import ServerTiming

__all__ = ["create_app"]

_DESCRIPTION = """\
Send the measurements or the ICC profile of a device, and get the surface of its gamut with as many
triangles as you ask for.

Post the data to `/v1/gamuts`, then download any level from `/v1/gamuts/{id}/mesh`. A gamut's id is
a digest of what it was made from, so its levels and history are immutable. Every error is a problem
document (RFC 9457); its codes are explained under [/problems](/problems). Every answer has the id
of its request in `X-Request-Id`, and where its time went in `Server-Timing`.
"""

_TAGS = [
    {"name": "gamuts", "description": "Built once, kept under the digest of what made them."},
    {"name": "meshes", "description": "Any level of a gamut, in glTF, PLY, STL or OBJ."},
    {"name": "jobs", "description": "Builds that take longer than the client waits."},
    {"name": "state", "description": "Whether the service lives and is ready."},
]

_BODY_MODELS = (
    request_models.MultipartSubmission,
    request_models.InlineSamples,
    models.ProblemDocument,
)
"""Models that the document refers to without a parameter or response of FastAPI's own."""


def create_app(settings: Settings) -> FastAPI:
    """Return the app for these settings; nothing is opened before its lifespan begins.

    Raises
    ------
    OpenToAllError
        The settings let everybody in, and do not say that this is meant.
    """
    rules = AccessRules.of(settings)
    service = Service(settings)

    @contextlib.asynccontextmanager
    async def lifespan(_app: FastAPI) -> AsyncIterator[None]:
        async with service.running():
            yield

    app = _Application(
        title="Gamut boundary service",
        summary="Gamut boundaries at any triangle count.",
        description=_DESCRIPTION,
        version=__version__,
        license_info={"name": "Apache-2.0", "identifier": "Apache-2.0"},
        openapi_tags=_TAGS,
        openapi_url=None,  # as is the page, with an entity tag
        docs_url=None,  # `service.routes.swagger_ui` has it, with a content security policy
        redoc_url=None,
        redirect_slashes=False,
        # Its own spans would repeat queries, and know nothing of the layers ahead of the routes.
        telemetry={"tracing": False, "metrics": False, "logs": False, "auto_configure": False},
        lifespan=lifespan,
    )
    app.state.service = service
    app.state.cors_origins = origins(settings.cors_origins)
    routers = (
        *(gamuts.router, meshes.router, batch.router, jobs.router),
        *(state.router, metrics.router, pages.router, swagger_ui.router),
    )
    for router in routers:
        app.include_router(router)
    app.state.routes = [route for router in routers for route in router.routes]
    add_exception_handlers(app)
    # The layer that is added last is the outermost.
    app.add_middleware(PlainPaths)
    app.add_middleware(BodyLimit, limit=settings.max_body_bytes)
    app.add_middleware(MeshFront, meshes=service.meshes)
    if rules.limiting:
        app.add_middleware(Access, rules=rules)
    app.add_middleware(HeadAsGet)
    return app


class _Application(FastAPI):
    """FastAPI whose document holds the models that only examples and bodies refer to."""

    def build_middleware_stack(self) -> ASGIApp:
        """Return the layers: ours are around Starlette's, whose outermost answers defects."""
        stack = super().build_middleware_stack()
        if self.state.cors_origins:
            stack = Cors(stack, self.state.cors_origins)
        service: Service = self.state.service
        observed = Observed(
            ServerTiming(stack),
            service.metrics.requests,
            access_log=service.settings.access_log,
            traces=service.traces,
        )
        return RequestIds(observed)

    def openapi(self) -> dict[str, Any]:
        """Return the OpenAPI document."""
        if self.openapi_schema is None:
            document = get_openapi(
                title=self.title,
                summary=self.summary,
                description=self.description,
                version=self.version,
                license_info=self.license_info,
                tags=self.openapi_tags,
                routes=self.routes,
            )
            schemas = document["components"]["schemas"]
            for model in _BODY_MODELS:
                schema = model.model_json_schema(ref_template="#/components/schemas/{model}")
                schemas |= schema.pop("$defs", {})
                schemas[model.__name__] = schema
            document["components"]["schemas"] = dict(sorted(schemas.items()))
            document["components"]["securitySchemes"] = SECURITY_SCHEMES
            for path, operations in document["paths"].items():
                if path.startswith("/v1/"):
                    for operation in operations.values():
                        operation["security"] = SECURITY
            self.openapi_schema = document
        return self.openapi_schema
