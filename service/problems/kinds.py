"""Kinds of problems: one table from stable codes to HTTP status, title and remedy.

The table holds the errors of `gamutcore`, whose codes are those of `gamutcore.errors`, and of the
service. Problem documents (RFC 9457), the examples of the OpenAPI document and the pages under
``/problems/`` are made from it. A released code never changes its meaning.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from gamutcore.characterisation.recognition import format_summary

__all__ = ["BUILD_PROBLEMS", "KINDS", "Kind"]


@dataclass(frozen=True)
class Kind:
    """A row of the table: the common part of all problems with one code, which is public.

    A single problem may have a more specific remedy. `detail` and `where` are an example, for the
    documentation. The status 422 stands for content that cannot be processed.
    """

    title: str
    remedy: str
    detail: str
    where: Mapping[str, Any] = field(default_factory=dict)
    status: int = 422
    code: str = ""


_SUPPORTED = f"Send {format_summary()}."
_DEFECT = "This is a defect of the service. Report it with the id of the gamut."

_TABLE = {
    # Errors of the core: content that cannot be processed.
    "invalid-option": Kind(
        "An option is not valid",
        "Use an option and a value from the documentation of POST /v1/gamuts.",
        "gamma is 1.5, which is not accepted.",
        {"field": "gamma"},
    ),
    "unrecognised-format": Kind(
        "The file's format is not recognised",
        _SUPPORTED,
        "The content has none of the supported formats.",
    ),
    "malformed-file": Kind(
        "The file is malformed",
        "Correct the file at the given place.",
        "BEGIN_DATA is not followed by END_DATA.",
        {"line": 18},
    ),
    "missing-column": Kind(
        "There are no columns with a colour",
        "Name columns LAB_L, LAB_A, LAB_B or XYZ_X, XYZ_Y, XYZ_Z, or the bands of a spectrum.",
        "There is no column LAB_B.",
        {"field": "LAB_B"},
    ),
    "measurement-condition": Kind(
        "The measurement condition is ambiguous or missing",
        "Select one with the option `condition`.",
        "The data has several measurement conditions: M0, M1, M2.",
        {"field": "condition"},
    ),
    "too-many-samples": Kind(
        "Too many samples, columns or channels",
        "Send fewer, for example only samples on the surface of the gamut.",
        "The file has more samples than the limit.",
    ),
    "malformed-profile": Kind(
        "The ICC profile is malformed",
        "Send a profile that conforms to ICC.1 (ISO 15076-1).",
        "The tag A2B1 ends outside the profile.",
        {"tag": "A2B1"},
    ),
    "unsupported-profile": Kind(
        "The ICC profile is not supported",
        "Send an input, display, output or colour space profile with a device-to-PCS transform.",
        "Profiles of the class named colour have no gamut.",
    ),
    "picture-too-large": Kind(
        "The picture is too large",
        "Send a smaller copy of the picture.",
        "The picture has 60000 × 60000 pixels, 10800 MB unpacked.",
        {"field": "size"},
    ),
    "picture-too-complex": Kind(
        "Decoding the picture takes too long",
        "Save the picture again, as PNG, TIFF or baseline JPEG.",
        "The JPEG has 20000 scans.",
        {"field": "scans"},
    ),
    "unsupported-picture": Kind(
        "The picture is not supported",
        "Send gray, RGB, CMYK or CIELAB pixels of 8 or 16 bits, or floats; CMYK with its profile "
        "embedded.",
        "The picture is CMYK without an embedded profile, so its colours are unknown.",
        {"field": "profile"},
    ),
    "unknown-reference": Kind(
        "There is no such reference gamut",
        "Give a slug from GET /v1/references.",
        "There is no reference gamut 'srbg'.",
        {"field": "reference"},
    ),
    "invalid-characterisation": Kind(
        "The characterisation data cannot be used",
        _SUPPORTED,
        "The characterisation data cannot be used.",
    ),
    "too-few-points": Kind(
        "Too few distinct colours",
        "Send at least four colours that do not lie in one plane.",
        "There are 3 distinct colours.",
    ),
    "flat-points": Kind(
        "The colours lie in one plane",
        "Send colours that span a volume.",
        "All colours lie in one plane.",
    ),
    "centre-outside": Kind(
        "The centre is not inside the gamut",
        "Give a centre inside the colours, or omit the option.",
        "The centre (50, 200, 0) is outside the convex hull of the colours.",
        {"field": "centre"},
    ),
    "invalid-points": Kind(
        "The colours cannot be used",
        "Send three finite numbers for every colour.",
        "Row 7 contains a value that is not finite.",
        {"row": 7},
    ),
    "triangle-count": Kind(
        "The gamut has no level with this triangle count",
        "Request a count from 4 to the largest count in the gamut's description.",
        "3 triangles were requested; a closed surface has at least 4.",
        {"field": "triangles"},
    ),
    "boundary-failed": Kind(
        "No closed surface around the colours was found",
        "Try a larger gamma, other segments, or another centre.",
        "No surface that is star-shaped about the centre was found.",
    ),
    "invalid-mesh": Kind(
        "The surface is not closed, oriented and star-shaped",
        "Try a larger gamma, or another centre.",
        "An edge belongs to three triangles.",
    ),
    "decimation-stalled": Kind(
        "The surface could not be decimated to four triangles",
        "Try a larger gamma, or another centre.",
        "No edge can be collapsed although 12 triangles are left.",
    ),
    "too-many-neighbours": Kind(
        "Vertices have too many neighbours",
        "Divide the surface so that fewer triangles meet at a vertex.",
        "Up to 131072 triangles meet at a vertex, and levels would take too long to read.",
        {"neighbours": 131072},
    ),
    "malformed-history": Kind(
        "A history file is damaged",
        "Post the characterisation data again.",
        "The history file is damaged.",
    ),
    "no-device-model": Kind(
        "The gamut has no device model",
        "Ask a gamut of measured samples with device values, an ICC profile or an RGB space.",
        "The gamut has no device model: its data, of the format npy, is colours only.",
        {"field": "gamut"},
    ),
    "gamut-error": Kind(
        "The gamut cannot be built",
        "Compare the request with the documentation.",
        "The gamut cannot be built.",
    ),
    # Outcomes of builds.
    "build-timeout": Kind(
        "The build exceeded its time limit",
        "Request fewer surface_samples, or send fewer samples.",
        "The build was ended after 120 s.",
        {"field": "surface_samples"},
    ),
    "build-out-of-memory": Kind(
        "The build exceeded its memory limit",
        "Request fewer surface_samples, or send fewer samples or a smaller picture.",
        "The build was ended because it used more than 2147483648 bytes of memory.",
        {"field": "surface_samples"},
    ),
    "build-crashed": Kind(
        "The build process died",
        "Request fewer surface_samples. If that does not help, report a defect with the input.",
        "The process that built this gamut died, 3 times in a row.",
    ),
    "build-failed": Kind(
        "The build failed unexpectedly", _DEFECT, "The build ended with an unexpected error."
    ),
    "build-cancelled": Kind(
        "The build was cancelled",
        "Post the data again to build the gamut.",
        "The build was cancelled before it was finished.",
        status=409,
    ),
    "gamut-deleted": Kind(
        "The gamut was deleted",
        "Post the data again to build the gamut.",
        "The gamut was built, and deleted before the answer.",
        status=409,
    ),
    "build-input-lost": Kind(
        "The data of the build is lost",
        "Post the data again.",
        "The data for this gamut is not stored any more.",
        status=409,
    ),
    "queue-full": Kind(
        "Too many builds are waiting",
        "Try again after the time in Retry-After.",
        "16 builds are waiting.",
        status=429,
    ),
    # Problems with a request.
    "malformed-body": Kind(
        "The body cannot be parsed",
        "Send JSON as RFC 8259 defines it, or multipart/form-data as RFC 7578 defines it.",
        "The JSON ends early.",
        {"line": 1, "column": 20},
        status=400,
    ),
    "invalid-body": Kind(
        "The body has the wrong parts",
        "Send the part `file` and optionally `options`, or JSON with `samples` and `options`.",
        "There is no part named file.",
        {"field": "file"},
    ),
    "too-many-rows": Kind(
        "There are too many rows",
        "Send the rows in several requests. JSON has up to 10,000 rows, .npy and CSV a million.",
        "There are 10001 rows.",
        {"limit": 10000},
    ),
    "queries-busy": Kind(
        "The client has too many requests waiting",
        "Wait for answers before sending more, or try again after the time in Retry-After.",
        "The client has 64 requests waiting.",
        status=429,
    ),
    "memory-busy": Kind(
        "The request has waited too long",
        "Try again after the time in Retry-After.",
        "The request waited for 300 s.",
        status=503,
    ),
    "memory-exceeded": Kind(
        "The request needs more memory than there is",
        "Ask for fewer triangles, pixels or rows. The operator can raise GAMUT_MEMORY_BYTES.",
        "The request needs 700000000 bytes of memory; the service has 500000000.",
    ),
    "invalid-name": Kind(
        "The name is not valid",
        "Give 1 to 200 characters, without control characters and invisible characters.",
        "The name has 0 characters; it needs 1 to 200.",
        {"field": "name"},
    ),
    "invalid-parameter": Kind(
        "A parameter is not valid",
        "Use a value from the documentation of the operation.",
        "'2d119c9b' is not an id, which is 64 hexadecimal digits in lower case.",
        {"in": "path", "field": "gamut_id"},
    ),
    "api-key-required": Kind(
        "An API key is required",
        "Send `Authorization: Bearer KEY` or `X-Api-Key: KEY` with a key of this service.",
        "This operation needs an API key with the scope write.",
        {"scope": "write"},
        status=401,
    ),
    "scope-missing": Kind(
        "The API key lacks a scope",
        "Use a key with the scope.",
        "The API key does not have the scope write.",
        {"scope": "write"},
        status=403,
    ),
    "built-by-another": Kind(
        "Another client built the gamut",
        "Use the key that built it, or a key with the scope write.",
        "The key has the scope build, and another client built the gamut.",
        {"scope": "write"},
        status=403,
    ),
    "host-not-allowed": Kind(
        "The service has another name",
        "Use the address that the service prints, or list the name in GAMUT_HOSTS.",
        "The service is not called 'rebound.example'.",
        {"header": "Host"},
        status=403,
    ),
    "origin-not-allowed": Kind(
        "Pages of this origin may not use the service",
        "List the origin in GAMUT_CORS_ORIGINS, or list the name of the service in GAMUT_HOSTS.",
        "A page of https://example.org may not use this service.",
        {"header": "Origin"},
        status=403,
    ),
    "rate-limited": Kind(
        "Too many requests",
        "Try again after the time in Retry-After.",
        "The limit is 100 requests at once and 10 per second.",
        {"limit": "requests"},
        status=429,
    ),
    "not-found": Kind(
        "There is nothing at this address",
        "/docs lists the addresses of the service.",
        "There is nothing at /v2/gamuts.",
        status=404,
    ),
    "gamut-not-found": Kind(
        "There is no gamut with this id",
        "Post its characterisation data to /v1/gamuts. The same data and options give the same id.",
        "There is no gamut 4f1d9c07….",
        {"field": "gamut_id"},
        status=404,
    ),
    "reference-read-only": Kind(
        "Reference gamuts cannot be changed",
        "Leave it. Reference gamuts and their names belong to the service.",
        "srgb is a reference gamut.",
        {"in": "path", "field": "gamut_id"},
        status=409,
    ),
    "job-not-found": Kind(
        "There is no job with this id",
        "Post the characterisation data to /v1/gamuts again.",
        "There is no job 4f1d9c07….",
        {"field": "job_id"},
        status=404,
    ),
    "job-finished": Kind(
        "The job has ended",
        "Only queued and running jobs can be cancelled. Delete a gamut by its own address.",
        "The job has succeeded.",
        {"state": "succeeded"},
        status=409,
    ),
    "too-many-streams": Kind(
        "Too many event streams are open",
        "Poll the address of the job, or try again after the time in Retry-After.",
        "256 event streams are open.",
        status=429,
    ),
    "method-not-allowed": Kind(
        "The method is not allowed",
        "Use a method in the header field Allow.",
        "PUT is not allowed for /v1/gamuts.",
        {"allowed": ["GET", "HEAD", "POST"]},
        status=405,
    ),
    "not-acceptable": Kind(
        "No accepted media type is available",
        "Accept one of the listed media types, or select a format with format=.",
        "A mesh is not available as text/csv.",
        {"header": "Accept"},
        status=406,
    ),
    "body-too-large": Kind(
        "The body is too large",
        "Send a body within the limit.",
        "The body is larger than 167772160 bytes.",
        {"limit": 167772160},
        status=413,
    ),
    "request-timeout": Kind(
        "The request arrived too slowly",
        "Send the request faster, or send less data.",
        "4096 bytes of the body arrived within 120 s.",
        status=408,
    ),
    "unsupported-media-type": Kind(
        "The body's media type is not accepted",
        "Send multipart/form-data with a part `file`, or application/json with `samples`.",
        "The media type of the body is text/plain.",
        {"header": "Content-Type"},
        status=415,
    ),
    "precondition-failed": Kind(
        "The content has another entity tag",
        "Omit If-Match, or use the current ETag of the resource.",
        "No entity tag in If-Match matches the content.",
        {"header": "If-Match"},
        status=412,
    ),
    "range-not-satisfiable": Kind(
        "The range is outside the file",
        "Request a range that starts inside the file. Content-Range has its size.",
        "The file has 3603856 bytes.",
        {"header": "Range"},
        status=416,
    ),
    "bad-request": Kind(
        "The request is malformed",
        "Send a request that conforms to RFC 9110.",
        "The request is malformed.",
        status=400,
    ),
    # Problems of the service.
    "internal-error": Kind(
        "The service has a defect",
        "Report the defect with the id of the request; the log has the details.",
        "The request could not be answered.",
        status=500,
    ),
    "not-ready": Kind(
        "The service is not ready",
        "Try again after the time in Retry-After.",
        "The build workers are warming up.",
        {"workers_warm": 0, "workers": 1},
        status=503,
    ),
    "gamut-rebuilding": Kind(
        "The gamut was damaged and is being rebuilt",
        "Try again after the time in Retry-After. The job has the progress.",
        "The stored gamut does not match its digest and is being rebuilt.",
        {"job": "/v1/jobs/4f1d9c07…"},
        status=503,
    ),
    "shutting-down": Kind(
        "The service is stopping",
        "Send the request again to another or the restarted instance.",
        "The service is stopping and accepts no new builds.",
        status=503,
    ),
    "broker-unavailable": Kind(
        "New builds cannot be queued",
        "Try again after the time in Retry-After. Existing gamuts are available.",
        "The queue of builds cannot be reached.",
        status=503,
    ),
    "overloaded": Kind(
        "The service is overloaded",
        "Try again after the time in Retry-After, with fewer simultaneous requests.",
        "Too many files and connections are open.",
        status=503,
    ),
    # Answers of the proxy in front of several replicas (deploy/haproxy.cfg).
    "bad-gateway": Kind(
        "A replica did not answer the proxy properly",
        "Send the request again. A query or a read has had no effect.",
        "A replica ended the connection before it answered.",
        status=502,
    ),
    "no-replica": Kind(
        "No replica of the service is available",
        "Try again after the time in Retry-After.",
        "The proxy knows no replica that is ready.",
        status=503,
    ),
    "gateway-timeout": Kind(
        "A replica did not answer the proxy in time",
        "Send the request again. A build continues, and its job can be read.",
        "A replica did not answer within 330 s.",
        status=504,
    ),
    "store-unavailable": Kind(
        "The store is unavailable",
        "Try again after the time in Retry-After. The log has the cause.",
        "The store did not answer, or it refused the request.",
        status=503,
    ),
    "scratch-full": Kind(
        "The scratch space is full",
        "The operator must free or add space for scratch files. Smaller bodies are accepted.",
        "There is no space left for scratch files.",
        status=507,
    ),
    "storage-full": Kind(
        "The store is full",
        "The operator must free or add space. Existing gamuts are available.",
        "There is no space left in the store.",
        status=507,
    ),
}

KINDS: Mapping[str, Kind] = {code: replace(kind, code=code) for code, kind in _TABLE.items()}
"""All kinds of problems by code."""

_NOT_OF_BUILDS = frozenset(
    {
        *("invalid-body", "invalid-name", "invalid-parameter", "memory-exceeded"),
        *("too-many-rows", "triangle-count"),
    }
)

BUILD_PROBLEMS = tuple(
    code for code, kind in KINDS.items() if kind.status == 422 and code not in _NOT_OF_BUILDS
)
"""Codes of problems with the content of a build."""
