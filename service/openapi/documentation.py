"""Parts of the OpenAPI document besides parameters and models: examples, headers, problems.

Routes name their problems. The responses are components, made from the table in
`service.problems.kinds`. All examples belong to one gamut.
"""

from collections.abc import Mapping
from http import HTTPStatus
from typing import Any

from service.http.representations import IMMUTABLE, OCTET_STREAM
from service.openapi.models import ProblemDocument
from service.problems.kinds import KINDS
from service.problems.problem import MEDIA_TYPE, Problem

__all__ = [
    "EXAMPLE_GAMUT",
    "EXAMPLE_ID",
    "EXAMPLE_JOB",
    "EXAMPLE_LEVELS",
    "EXAMPLE_LIST",
    "EXAMPLE_READINESS",
    "EXAMPLE_REFERENCES",
    "MESH_HEADERS",
    "NAME_BODY",
    "SUBMISSION_BODY",
    "binary_content",
    "gamut_links",
    "header",
    "job_links",
    "json_response",
    "problem_responses",
    "problems",
]

EXAMPLE_ID = "4f1d9c07b2a85e63" * 4

_LINKS = {
    "self": f"/v1/gamuts/{EXAMPLE_ID}",
    "mesh": f"/v1/gamuts/{EXAMPLE_ID}/mesh",
    "levels": f"/v1/gamuts/{EXAMPLE_ID}/levels",
    "history": f"/v1/gamuts/{EXAMPLE_ID}/history",
}

_OPTIONS = {
    "space": "CIELAB",
    "boundary": "auto",
    "gamma": "auto",
    "centre": "auto",
    "cost": "volume",
    "surface_samples": 100000,
    "intent": "relative",
}

_CURVE = [
    {
        "triangles": 4,
        "volume": 454918.2825,
        "mismatch": 0.556262,
        "mismatch_bound": 0.565395,
        "distance_bound": 68.8089,
        "from_full": {"mean": 6.94433, "maximum": 38.0549},
        "to_full": {"mean": 8.45846, "maximum": 68.8089},
    },
    {
        "triangles": 510,
        "volume": 454918.3687,
        "mismatch": 0.00117308,
        "mismatch_bound": 0.00132536,
        "distance_bound": 0.355713,
        "from_full": {"mean": 0.0140091, "maximum": 0.349785},
        "to_full": {"mean": 0.014024, "maximum": 0.355713},
    },
]

_SUMMARY = {
    "id": EXAMPLE_ID,
    "name": "Coated offset",
    "created": "2026-01-31T12:00:00.000Z",
    "channels": ["C", "M", "Y", "K"],
    "options": _OPTIONS,
    "counts": {"triangles": 89674, "vertices": 44839, "minimum": 4, "constructed": 0},
    "volume": 454918.0,
    "links": _LINKS,
}

_COVERAGE_XY = {"bt709": 0.8324, "display-p3": 0.6913, "bt2020": 0.5122, "adobe-rgb-1998": 0.7171}
_COVERAGE_UV = {"bt709": 0.7866, "display-p3": 0.6947, "bt2020": 0.5157, "adobe-rgb-1998": 0.7583}

EXAMPLE_GAMUT: dict[str, Any] = {
    **_SUMMARY,
    "state": "ready",
    "history_bytes": 346120,
    "provenance": {"format": "cgats", "channels": ["C", "M", "Y", "K"], "warnings": []},
    "volumes": {
        "srgb": 833136.0,
        "relative": {"volume": 454654.0, "times_srgb": 0.545714},
        "absolute": {"volume": 402522.0, "times_srgb": 0.483141},
    },
    "device_surface_volume": 454916.0,
    "volume_preserved": True,
    "volume_error": 2.1e-06,
    "grid_step": 0.00048828125,
    "boundary_error": 0.00439408,
    "area": 38078.0,
    "centre": [55.2, 3.2, 12.0],
    "bounds": [[8.9, -67.9, -50.4], [100.0, 77.3, 98.0]],
    "chromaticity": {
        "basis": "colours",
        "corners": [[0.1665, 0.1945], [0.6224, 0.3303], [0.1968, 0.5291]],
        "xy": {"area": 0.1085, "of_bt709": 0.9684, "coverage": _COVERAGE_XY},
        "uv": {"area": 0.0577, "of_bt709": 0.8892, "coverage": _COVERAGE_UV},
    },
    "levels": _CURVE,
}

EXAMPLE_LIST: dict[str, Any] = {"gamuts": [_SUMMARY], "next": f"/v1/gamuts?after={EXAMPLE_ID}"}

EXAMPLE_LEVELS: dict[str, Any] = {"id": EXAMPLE_ID, "levels": _CURVE}

EXAMPLE_JOB: dict[str, Any] = {
    "id": EXAMPLE_ID,
    "state": "running",
    "stage": "decimation",
    "fraction": 0.4,
    "attempts": 1,
    "created": "2026-01-31T11:59:58.000Z",
    "started": "2026-01-31T11:59:58.100Z",
    "finished": None,
    "problem": None,
    "links": {"self": f"/v1/jobs/{EXAMPLE_ID}", "gamut": None},
}

EXAMPLE_READINESS: dict[str, Any] = {
    "ready": True,
    "probes": {
        "kernels": {
            "status": "ok",
            "detail": "default: compiled, optional: compiled, ciede2000: compiled",
            "milliseconds": 0.0,
        },
        "workers": {"status": "ok", "detail": "1 of 1 workers are warm", "milliseconds": 0.0},
        "queue": {"status": "ok", "detail": "0 of 16 builds are waiting", "milliseconds": 0.0},
        "builds": {"status": "ok", "detail": "accepted", "milliseconds": 0.0},
        "store": {"status": "ok", "detail": "written and read", "milliseconds": 0.412},
        "disk": {"status": "ok", "detail": "52.6 GB are free", "milliseconds": 0.031},
    },
    "workers": 1,
    "workers_warm": 1,
    "builds": {"queued": 0, "running": 1, "completed": 12},
}

EXAMPLE_REFERENCES: dict[str, Any] = {
    "references": [
        {
            "slug": "srgb",
            "name": "sRGB",
            "aliases": [],
            "kind": "rgb",
            "white": [0.3127, 0.329],
            "illuminant": "D65",
            "observer": 2,
            "primaries": [[0.64, 0.33], [0.3, 0.6], [0.15, 0.06]],
            "peak_luminance": None,
            "source": "colour-science 0.4.7, colour.RGB_COLOURSPACES['sRGB']",
            "links": {"gamut": "/v1/gamuts/srgb"},
        }
    ],
    "not_offered": [
        {
            "name": "REDWideGamutRGB",
            "reason": "Its blue primary has a negative luminance, which has no lightness.",
        }
    ],
}

_INLINE_EXAMPLE = {
    "columns": ["LAB_L", "LAB_A", "LAB_B"],
    "samples": [[0, 0, 0], [100, 0, 0], [50, 60, 0], [50, -30, 52], [50, -30, -52]],
    "options": {"gamma": 1},
}

_EXAMPLE_FILE = "LAB_L,LAB_A,LAB_B\n0,0,0\n100,0,0\n50,60,0\n50,-30,52\n50,-30,-52"

SUBMISSION_BODY: dict[str, Any] = {
    "required": True,
    "content": {
        "multipart/form-data": {
            "schema": {"$ref": "#/components/schemas/MultipartSubmission"},
            "encoding": {"options": {"contentType": "application/json"}},
            "examples": {
                "file": {
                    "summary": "A file with options",
                    "value": {"file": _EXAMPLE_FILE, "options": {"gamma": 1}},
                },
                "fields": {
                    "summary": "A file with options as form fields",
                    "value": {"file": _EXAMPLE_FILE, "space": "Oklab", "gamma": 1},
                },
            },
        },
        "application/json": {
            "schema": {
                "anyOf": [
                    {"$ref": "#/components/schemas/InlineSamples"},
                    {"$ref": "#/components/schemas/ReferenceSubmission"},
                ]
            },
            "examples": {
                "colours": {"summary": "Bare colours", "value": _INLINE_EXAMPLE},
                "reference": {
                    "summary": "A reference gamut",
                    "value": {"reference": "srgb", "options": {"surface_samples": 1000}},
                },
            },
        },
    },
}


NAME_BODY: dict[str, Any] = {
    "required": True,
    "content": {
        "application/json": {
            "schema": {"$ref": "#/components/schemas/NewName"},
            "examples": {"name": {"value": {"name": "Coated offset"}}},
        }
    },
}


def gamut_links(expression: str) -> dict[str, Any]:
    """Return links from a response with a gamut to the operations on it.

    `expression` is the runtime expression of OpenAPI for the gamut's id.
    """
    links = {
        operation: {"operationId": operation, "parameters": {"gamut_id": expression}}
        for operation in (
            "describeGamut",
            "downloadMesh",
            "downloadMeshFile",
            "describeLevels",
            "downloadHistory",
            "deleteGamut",
        )
    }
    return links | job_links(expression)


def job_links(expression: str) -> dict[str, Any]:
    """Return links from a response with a gamut to its job; parameters as `gamut_links`."""
    return {
        operation: {"operationId": operation, "parameters": {"job_id": expression}}
        for operation in ("describeJob", "followJob", "cancelJob")
    }


def header(description: str, example: str | int) -> dict[str, Any]:
    """Return the description of a response header field."""
    kind = "integer" if isinstance(example, int) else "string"
    return {"description": description, "schema": {"type": kind}, "example": example}


def binary_content(summaries: Mapping[str, str]) -> dict[str, Any]:
    """Return the content of a response that is a file, from descriptions by media type.

    ``application/octet-stream`` comes first. Client generators that know only that type and JSON
    then read the file as bytes.
    """
    unnamed = "The bytes of the preferred format; Content-Type names it"
    every = {OCTET_STREAM: unnamed, **summaries}
    return {
        media_type: {
            "schema": {"type": "string", "format": "binary"},
            "examples": {"file": {"summary": summary}},
        }
        for media_type, summary in every.items()
    }


MESH_HEADERS: dict[str, Any] = {
    "Gamut-Triangles": header("Triangles of the mesh.", 510),
    "Gamut-Vertices": header("Vertices of the mesh.", 257),
    "Gamut-Max-Error": header(
        "Upper bound of the distance from the full boundary, in the space's unit. Sent for error "
        "limits, and for levels of the error curve.",
        "0.355713",
    ),
    "Gamut-Max-Mismatch": header("Upper bound of the mismatch, for the same levels.", "0.00132536"),
    "ETag": header(
        "Strong entity tag: SHA-256 of the body in its content coding.", f'"{EXAMPLE_ID}"'
    ),
    "Cache-Control": header("The content is immutable.", IMMUTABLE),
    "Content-Disposition": header(
        "File name: the name of the gamut, the triangle count and the suffix, in ASCII as "
        "`filename` and in full as `filename*`.",
        'inline; filename="Coated offset-510.glb"',
    ),
    "Vary": header("Request fields that select the content.", "Accept, Accept-Encoding"),
}


def json_response(
    description: str,
    model: type,
    example: object,
    headers: dict[str, Any] | None = None,
    links: dict[str, Any] | None = None,
) -> dict[str, Any]:
    """Return the description of a JSON response."""
    content = {"application/json": {"examples": {"example": {"value": example}}}}
    response = {
        "description": description,
        "model": model,
        "content": content,
        "headers": headers or {},
    }
    if links:
        response["links"] = links
    return response


_EVERYWHERE = (
    "bad-request",
    "api-key-required",
    "scope-missing",
    "host-not-allowed",
    "origin-not-allowed",
    "rate-limited",
)
"""Problems of every operation that may need a key."""

_INSTEAD_OF_REBUILDING = ("queue-full", "shutting-down", "broker-unavailable", "storage-full")
"""Problems of rebuilding a damaged gamut."""


def problems(*codes: str, guarded: bool = True) -> dict[int | str, dict[str, Any]]:
    """Return references to the problem responses of an operation, which list its codes, by status.

    ``internal-error`` is always added, and ``gamut-rebuilding`` adds the refusals of a new build.
    `guarded` tells whether the operation needs a key and counts for rate limits.
    """
    refusals = _INSTEAD_OF_REBUILDING if "gamut-rebuilding" in codes else ()
    codes = (*codes, *refusals, *(_EVERYWHERE if guarded else ()), "internal-error")
    listed: dict[int | str, list[str]] = {}
    for code in dict.fromkeys(codes):
        listed.setdefault(KINDS[code].status, []).append(f"`{code}`")
    return {
        # A description beside a reference takes the place of that of the component.
        status: {
            "$ref": f"#/components/responses/Problem{status}",
            "description": ", ".join(names),
        }
        for status, names in listed.items()
    }


def problem_responses() -> dict[str, dict[str, Any]]:
    """Return the components that `problems` refers to: all kinds of problems, by status."""
    responses: dict[str, dict[str, Any]] = {}
    for code, kind in sorted(KINDS.items(), key=lambda item: item[1].status):
        headers = {"Cache-Control": header("Problems are not cached.", "no-store")}
        if kind.status in {429, 503}:
            headers["Retry-After"] = header("Seconds to wait.", 5)
        if kind.status == 401:
            headers["WWW-Authenticate"] = header("How a key is sent.", 'Bearer realm="gamut"')
        response = responses.setdefault(
            f"Problem{kind.status}",
            {
                "description": HTTPStatus(kind.status).phrase,
                "headers": headers,
                "content": {
                    MEDIA_TYPE: {
                        "schema": {"$ref": f"#/components/schemas/{ProblemDocument.__name__}"},
                        "examples": {},
                    }
                },
            },
        )
        value = Problem(code, kind.detail, kind.where).document()
        response["content"][MEDIA_TYPE]["examples"][code] = {"value": value}
    return responses
