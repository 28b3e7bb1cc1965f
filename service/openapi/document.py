"""Assembly of the OpenAPI document from the routes and models.

FastAPI generates the operations. This module adds the security schemes, and the models that only
bodies and examples use.
"""

from typing import Any

from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi
from fastapi.routing import APIRoute, iter_route_contexts

from gamutcore.version import __version__
from service.openapi import models
from service.openapi.documentation import EXAMPLE_ID, EXAMPLE_JOB, header, problem_responses

__all__ = ["APP_METADATA", "openapi_document"]

APP_METADATA: dict[str, Any] = {
    "title": "Gamut boundary service",
    "summary": "Gamut boundaries at any triangle count.",
    "description": """\
Send the measurements or the ICC profile of a device, and get the surface of its gamut with any
number of triangles.

Post the data to `/v1/gamuts`, then download any level from `/v1/gamuts/{id}/mesh`. The id of a
gamut is a digest of its data and options, so its levels and its history are immutable. Every error
is a problem document (RFC 9457). The descriptions of an operation's responses list its codes, and
[/problems](/problems) explains them. Every answer carries the id of its request in `X-Request-Id`
and its timing in `Server-Timing`.
""",
    "version": __version__,
    "license_info": {"name": "Apache-2.0", "identifier": "Apache-2.0"},
    "openapi_tags": [
        {"name": "gamuts", "description": "Built once, stored under a digest of data and options."},
        {"name": "meshes", "description": "Any level of a gamut, in glTF, PLY, .gam and others."},
        {"name": "queries", "description": "Answers about colours: in gamut, nearest, mapped."},
        {"name": "jobs", "description": "Builds that take longer than the client waits."},
        {"name": "state", "description": "Liveness, readiness and metrics."},
    ],
}

_SECURITY_SCHEMES: dict[str, Any] = {
    "bearer": {
        "type": "http",
        "scheme": "bearer",
        "description": "An API key of this service, if it has keys.",
    },
    "apiKey": {
        "type": "apiKey",
        "in": "header",
        "name": "X-Api-Key",
        "description": "The same key in a header field of its own.",
    },
}

_SECURITY: list[dict[str, Any]] = [{}, {"bearer": []}, {"apiKey": []}]
"""With or without a key. The settings decide which one a service requires."""

_REFERENCE_OPTIONS: dict[str, Any] = {
    "name": "options",
    "in": "query",
    "required": False,
    "style": "form",
    "explode": True,
    "description": "Options of a reference gamut's build, as parameters of their own names: "
    "`?space=CAM16-UCS&surround=dim`. Only with slugs. The answer has the address by id in "
    "Content-Location, and may be cached for five minutes.",
    "schema": {"$ref": "#/components/schemas/GamutOptions"},
    "examples": {"space": {"value": {"space": "Oklab"}}},
}

_REFERENCE_JOB = {
    "description": "The reference gamut is being built.",
    "content": {
        "application/json": {
            "schema": {"$ref": "#/components/schemas/JobDescription"},
            "examples": {"example": {"value": EXAMPLE_JOB}},
        }
    },
    "headers": {
        "Location": header("The job.", f"/v1/jobs/{EXAMPLE_ID}"),
        "Retry-After": header("Seconds after which to ask again.", 1),
        "Cache-Control": header("The state changes.", "no-store"),
    },
}

_BODY_MODELS = (
    models.MultipartSubmission,
    models.InlineSamples,
    models.NewName,
    models.ReferenceSubmission,
    models.ProblemDocument,
)
"""Models that no parameter or response of FastAPI refers to."""


def openapi_document(app: FastAPI) -> dict[str, Any]:
    """Return the OpenAPI document of an app."""
    document = get_openapi(
        title=app.title,
        summary=app.summary,
        description=app.description,
        version=app.version,
        license_info=app.license_info,
        tags=app.openapi_tags,
        routes=app.routes,
    )
    _restore_examples(document["paths"], app)
    schemas = document["components"]["schemas"]
    for model in _BODY_MODELS:
        schema = model.model_json_schema(ref_template="#/components/schemas/{model}")
        schemas |= schema.pop("$defs", {})
        schemas[model.__name__] = schema
    document["paths"] = _with_named_schemas(document["paths"], schemas)
    document["components"] = {
        "schemas": dict(sorted(schemas.items())),
        "responses": {"ReferenceJob": _REFERENCE_JOB, **problem_responses()},
        "securitySchemes": _SECURITY_SCHEMES,
    }
    # At the top, so that generated operations take clients with and without a key.
    document["security"] = _SECURITY
    for path, operations in document["paths"].items():
        if not path.startswith("/v1/"):
            for operation in operations.values():
                operation["security"] = []
    for path, operations in document["paths"].items():
        for method, operation in operations.items():
            if method in {"get", "post"} and _takes_slugs(path):
                operation["parameters"].append(_REFERENCE_OPTIONS)
                job = {"$ref": "#/components/responses/ReferenceJob"}
                operation["responses"].setdefault("202", job)
    _drop_repetitions(document["paths"], schemas)
    document["components"]["parameters"] = _share_parameters(document["paths"])
    return document


def _restore_examples(paths: dict[str, Any], app: FastAPI) -> None:
    """Replace the examples of responses by the examples of the routes.

    FastAPI drops every member that is null, also from examples whose schema requires it.
    """
    for route in iter_route_contexts(app.routes):
        if not isinstance(route.original_route, APIRoute) or not route.include_in_schema:
            continue
        for method in route.methods or ():
            responses = paths[str(route.path_format)][method.lower()]["responses"]
            for status, response in route.responses.items():
                for media_type, content in response.get("content", {}).items():
                    shown = responses[str(status)]["content"][media_type]
                    shown["examples"] = content["examples"]


def _with_named_schemas(node: Any, schemas: dict[str, Any]) -> Any:  # noqa: ANN401 - JSON
    """Return a part of a document with references in place of titled object schemas.

    Generated clients then name the classes by the titles. The schemas are added to `schemas`.
    """
    if isinstance(node, list):
        return [_with_named_schemas(each, schemas) for each in node]
    if not isinstance(node, dict):
        return node
    node = {name: _with_named_schemas(each, schemas) for name, each in node.items()}
    if {"title", "properties"} <= node.keys():
        schemas[node["title"]] = node
        return {"$ref": f"#/components/schemas/{node['title']}"}
    return node


def _drop_repetitions(paths: dict[str, Any], schemas: dict[str, Any]) -> None:
    """Remove titles that pydantic makes of names, and descriptions that stand twice."""
    for schema in schemas.values():
        for member in schema.get("properties", {}).values():
            if isinstance(member.get("title"), str):
                del member["title"]
    for operations in paths.values():
        for operation in operations.values():
            for parameter in operation.get("parameters", ()):
                schema = parameter.get("schema", {})
                schema.pop("title", None)
                if schema.get("description") == parameter.get("description"):
                    schema.pop("description", None)


def _share_parameters(paths: dict[str, Any]) -> dict[str, Any]:
    """Refer to parameters that several operations have, and return these by name.

    Of different parameters with one name, only the most frequent one is shared.
    """
    operations = [each for operations in paths.values() for each in operations.values()]
    every = [parameter for each in operations for parameter in each.get("parameters", ())]
    shared = {
        parameter["name"]: parameter
        for parameter in sorted(every, key=every.count)
        if every.count(parameter) > 1
    }
    for operation in operations:
        if "parameters" in operation:
            operation["parameters"] = [
                {"$ref": f"#/components/parameters/{parameter['name']}"}
                if shared.get(parameter["name"]) == parameter
                else parameter
                for parameter in operation["parameters"]
            ]
    return dict(sorted(shared.items()))


def _takes_slugs(path: str) -> bool:
    """Return whether an operation takes slugs of reference gamuts in place of ids."""
    return path.startswith("/v1/gamuts/{gamut_id}")
