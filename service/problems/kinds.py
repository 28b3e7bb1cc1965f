"""Kinds of problems: one table from stable codes to HTTP status, title and remedy.

The table holds the errors of `gamutcore` and of the service. Problem documents (RFC 9457), the
examples of the OpenAPI document and the pages under ``/problems/`` are made from it. A released
code never changes its meaning.
"""

from __future__ import annotations

from service.problems.content_kinds import CONTENT_KINDS, Kind

__all__ = ["BUILD_PROBLEMS", "KINDS", "Kind"]

_DEFECT = "This is a defect of the service. Report it with the id of the gamut."


_ROWS = (
    *CONTENT_KINDS,
    # Outcomes of builds.
    Kind(
        "build-timeout",
        422,
        "The build exceeded its time limit",
        "Request fewer surface_samples, or send fewer samples.",
        "The build was ended after 120 s.",
        {"field": "surface_samples"},
    ),
    Kind(
        "build-out-of-memory",
        422,
        "The build exceeded its memory limit",
        "Request fewer surface_samples, or send fewer samples or a smaller picture.",
        "The build was ended because it used more than 2147483648 bytes of memory.",
        {"field": "surface_samples"},
    ),
    Kind(
        "build-crashed",
        422,
        "The build process died",
        "Request fewer surface_samples. If that does not help, report a defect with the input.",
        "The process that built this gamut died, 3 times in a row.",
    ),
    Kind(
        "build-failed",
        422,
        "The build failed unexpectedly",
        _DEFECT,
        "The build ended with an unexpected error.",
    ),
    Kind(
        "build-cancelled",
        409,
        "The build was cancelled",
        "Post the data again to build the gamut.",
        "The build was cancelled before it was finished.",
    ),
    Kind(
        "gamut-deleted",
        409,
        "The gamut was deleted",
        "Post the data again to build the gamut.",
        "The gamut was built, and deleted before the answer.",
    ),
    Kind(
        "build-input-lost",
        409,
        "The data of the build is lost",
        "Post the data again.",
        "The data for this gamut is not stored any more.",
    ),
    Kind(
        "build-outdated",
        409,
        "Another version of the algorithm accepted the job",
        "Post the data again. The gamut gets the id of the present version.",
        "The job was accepted under another version of the algorithm, whose gamuts this version "
        "cannot build.",
    ),
    Kind(
        "queue-full",
        429,
        "Too many builds are waiting",
        "Try again after the time in Retry-After.",
        "16 builds are waiting.",
    ),
    # Problems with a request.
    Kind(
        "malformed-body",
        400,
        "The body cannot be parsed",
        "Send JSON as RFC 8259 defines it, or multipart/form-data as RFC 7578 defines it.",
        "The JSON ends early.",
        {"line": 1, "column": 20},
    ),
    Kind(
        "invalid-body",
        422,
        "The body has the wrong parts",
        "Send the part `file` and optionally `options`, or JSON with `samples` and `options`.",
        "There is no part named file.",
        {"field": "file"},
    ),
    Kind(
        "too-many-rows",
        422,
        "There are too many rows",
        "Send the rows in several requests. JSON has up to 10,000 rows, .npy and CSV a million.",
        "There are 10001 rows.",
        {"limit": 10000},
    ),
    Kind(
        "queries-busy",
        429,
        "Too many rows are being answered",
        "Try again after the time in Retry-After.",
        "2000000 rows are being answered.",
    ),
    Kind(
        "share-exceeded",
        429,
        "The client uses more than its share",
        "Send fewer requests at once, or try again after the time in Retry-After.",
        "The client has more than its share of the bytes of bodies.",
    ),
    Kind(
        "memory-busy",
        503,
        "The memory is in use",
        "Try again after the time in Retry-After.",
        "500000000 of 500000000 bytes are in use, and 12 requests wait.",
    ),
    Kind(
        "memory-exceeded",
        503,
        "The request needs more memory than there is",
        "Ask for fewer triangles, pixels or rows, or raise GAMUT_MEMORY_BYTES.",
        "The request needs 700000000 bytes of memory; the service has 500000000.",
    ),
    Kind(
        "invalid-name",
        422,
        "The name is not valid",
        "Give 1 to 200 characters without control characters.",
        "The name has 0 characters; it needs 1 to 200.",
        {"field": "name"},
    ),
    Kind(
        "invalid-parameter",
        422,
        "A parameter is not valid",
        "Use a value from the documentation of the operation.",
        "'2d119c9b' is not an id, which is 64 hexadecimal digits in lower case.",
        {"in": "path", "field": "gamut_id"},
    ),
    Kind(
        "api-key-required",
        401,
        "An API key is required",
        "Send `Authorization: Bearer KEY` or `X-Api-Key: KEY` with a key of this service.",
        "This operation needs an API key with the scope write.",
        {"scope": "write"},
    ),
    Kind(
        "scope-missing",
        403,
        "The API key lacks a scope",
        "Use a key with the scope.",
        "The API key does not have the scope write.",
        {"scope": "write"},
    ),
    Kind(
        "built-by-another",
        403,
        "Another client built the gamut",
        "Use the key that built it, or a key with the scope write.",
        "The key has the scope build, and another client built the gamut.",
        {"scope": "write"},
    ),
    Kind(
        "host-not-allowed",
        403,
        "The service has another name",
        "Use the address that the service prints, or list the name in GAMUT_HOSTS.",
        "The service is not called 'rebound.example'.",
        {"header": "Host"},
    ),
    Kind(
        "origin-not-allowed",
        403,
        "Pages of this origin may change nothing",
        "List the origin in GAMUT_CORS_ORIGINS, or list the name of the service in GAMUT_HOSTS.",
        "A page of https://example.org may change nothing here.",
        {"header": "Origin"},
    ),
    Kind(
        "rate-limited",
        429,
        "Too many requests",
        "Try again after the time in Retry-After.",
        "The limit is 100 requests at once and 10 per second.",
        {"limit": "requests"},
    ),
    Kind(
        "not-found",
        404,
        "There is nothing at this address",
        "/docs lists the addresses of the service.",
        "There is nothing at /v2/gamuts.",
    ),
    Kind(
        "gamut-not-found",
        404,
        "There is no gamut with this id",
        "Post its characterisation data to /v1/gamuts. The same data and options give the same id.",
        "There is no gamut 4f1d9c07….",
        {"field": "gamut_id"},
    ),
    Kind(
        "reference-read-only",
        409,
        "Reference gamuts cannot be changed",
        "Leave it. Reference gamuts and their names belong to the service.",
        "srgb is a reference gamut.",
        {"in": "path", "field": "gamut_id"},
    ),
    Kind(
        "job-not-found",
        404,
        "There is no job with this id",
        "Post the characterisation data to /v1/gamuts again.",
        "There is no job 4f1d9c07….",
        {"field": "job_id"},
    ),
    Kind(
        "job-finished",
        409,
        "The job has ended",
        "Only queued and running jobs can be cancelled. Delete a gamut by its own address.",
        "The job has succeeded.",
        {"state": "succeeded"},
    ),
    Kind(
        "too-many-streams",
        429,
        "Too many event streams are open",
        "Poll the address of the job, or try again after the time in Retry-After.",
        "256 event streams are open.",
    ),
    Kind(
        "method-not-allowed",
        405,
        "The method is not allowed",
        "Use a method in the header field Allow.",
        "PUT is not allowed for /v1/gamuts.",
        {"allowed": ["GET", "HEAD", "POST"]},
    ),
    Kind(
        "not-acceptable",
        406,
        "No accepted media type is available",
        "Accept one of the listed media types, or select a format with format=.",
        "A mesh is not available as text/csv.",
        {"header": "Accept"},
    ),
    Kind(
        "body-too-large",
        413,
        "The body is too large",
        "Send a body within the limit.",
        "The body is larger than 167772160 bytes.",
        {"limit": 167772160},
    ),
    Kind(
        "request-timeout",
        408,
        "The request arrived too slowly",
        "Send the request faster, or send less data.",
        "4096 bytes of the body arrived within 21 s.",
    ),
    Kind(
        "head-too-large",
        431,
        "The request target and header fields are too large",
        "Send a shorter request target, and fewer or shorter header fields.",
        "The request target and the header fields are larger than 32768 bytes.",
        {"limit": 32768},
    ),
    Kind(
        "unsupported-media-type",
        415,
        "The body's media type is not accepted",
        "Send multipart/form-data with a part `file`, or application/json with `samples`.",
        "The media type of the body is text/plain.",
        {"header": "Content-Type"},
    ),
    Kind(
        "precondition-failed",
        412,
        "The content has another entity tag",
        "Omit If-Match, or use the current ETag of the resource.",
        "No entity tag in If-Match matches the content.",
        {"header": "If-Match"},
    ),
    Kind(
        "range-not-satisfiable",
        416,
        "The range is outside the file",
        "Request a range that starts inside the file. Content-Range has its size.",
        "The file has 3603856 bytes.",
        {"header": "Range"},
    ),
    Kind(
        "bad-request",
        400,
        "The request is malformed",
        "Send a request that conforms to RFC 9110.",
        "The request is malformed.",
    ),
    # Problems of the service.
    Kind(
        "internal-error",
        500,
        "The service has a defect",
        "Report the defect with the id of the request; the log has the details.",
        "The request could not be answered.",
    ),
    Kind(
        "not-ready",
        503,
        "The service is not ready",
        "Try again after the time in Retry-After.",
        "The build workers are warming up.",
        {"workers_warm": 0, "workers": 1},
    ),
    Kind(
        "gamut-rebuilding",
        503,
        "The gamut was damaged and is being rebuilt",
        "Try again after the time in Retry-After. The job has the progress.",
        "The stored gamut does not match its digest and is being rebuilt.",
        {"job": "/v1/jobs/4f1d9c07…"},
    ),
    Kind(
        "shutting-down",
        503,
        "The service is stopping",
        "Send the request again to another or the restarted instance.",
        "The service is stopping and accepts no new builds.",
    ),
    Kind(
        "broker-unavailable",
        503,
        "New builds cannot be queued",
        "Try again after the time in Retry-After. Existing gamuts are available.",
        "The queue of builds cannot be reached.",
    ),
    Kind(
        "overloaded",
        503,
        "The service is overloaded",
        "Try again after the time in Retry-After, with fewer simultaneous connections.",
        "Too many files and connections are open.",
    ),
    # Answers of the proxy in front of several replicas (deploy/haproxy.cfg).
    Kind(
        "bad-gateway",
        502,
        "A replica did not answer the proxy properly",
        "Send the request again. A query or a read has had no effect.",
        "A replica ended the connection before it answered.",
    ),
    Kind(
        "no-replica",
        503,
        "No replica of the service is available",
        "Try again after the time in Retry-After.",
        "The proxy knows no replica that is ready.",
    ),
    Kind(
        "gateway-timeout",
        504,
        "A replica did not answer the proxy in time",
        "Send the request again. A build continues, and its job can be read.",
        "A replica did not answer within 330 s.",
    ),
    Kind(
        "spool-full",
        503,
        "Too many bytes of bodies are waiting",
        "Try again after the time in Retry-After.",
        "The bodies of other requests take 536870912 bytes.",
    ),
    Kind(
        "store-unavailable",
        503,
        "The store is unavailable",
        "Try again after the time in Retry-After. The log has the cause.",
        "The store did not answer, or it refused the request.",
    ),
    Kind(
        "scratch-full",
        507,
        "The scratch space is full",
        "The operator must free or add space for scratch files. Smaller bodies are accepted.",
        "There is no space left for scratch files.",
    ),
    Kind(
        "storage-full",
        507,
        "The store is full",
        "The operator must free or add space. Existing gamuts are available.",
        "There is no space left in the store.",
    ),
)

_NOT_OF_BUILDS = frozenset(
    {"invalid-body", "invalid-name", "invalid-parameter", "too-many-rows", "triangle-count"}
)

BUILD_PROBLEMS = tuple(
    kind.code for kind in _ROWS if kind.status == 422 and kind.code not in _NOT_OF_BUILDS
)
"""Codes of problems with the content of a build."""

KINDS: dict[str, Kind] = {kind.code: kind for kind in _ROWS}
"""All kinds of problems by code."""
