"""Kinds of problems: one table from stable codes to HTTP status, title and remedy.

The table holds the errors of `gamutcore` and those of the service. Problem documents (RFC 9457),
the examples of the OpenAPI document and the pages under ``/problems/`` are made from it. A released
code never changes its meaning.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from gamutcore import errors
from gamutcore.characterisation.formats import format_summary

__all__ = ["BUILD_PROBLEMS", "KINDS", "Kind"]

_DEFECT = "This is a defect of the service. Report it with the id of the gamut."


@dataclass(frozen=True)
class Kind:
    """A row of the table: the common part of all problems with one code.

    Attributes
    ----------
    code : str
        Stable, part of the public interface.
    status : int
        HTTP status code.
    title : str
        Summary of the kind of problem.
    remedy : str
        General remedy. A single problem may have a more specific one.
    detail, where
        An example, for the documentation.
    """

    code: str
    status: int
    title: str
    remedy: str
    detail: str
    where: Mapping[str, Any] = field(default_factory=dict)


def _core(
    error: type[errors.GamutError], title: str, remedy: str, detail: str, **where: str | int
) -> Kind:
    """Return the row of an error of `gamutcore`: the client's content cannot be processed."""
    return Kind(error.code, 422, title, remedy, detail, where)


_READ = f"Send {format_summary()}."

_CORE_ROWS = (
    _core(
        errors.OptionError,
        "An option is not valid",
        "Use an option and a value from the documentation of POST /v1/gamuts.",
        "gamma is 1.5, which is not accepted.",
        field="gamma",
    ),
    _core(
        errors.UnrecognisedFormatError,
        "The file's format is not recognised",
        _READ,
        "The content has none of the supported formats.",
    ),
    _core(
        errors.MalformedFileError,
        "The file is malformed",
        "Correct the file at the given place.",
        "BEGIN_DATA is not followed by END_DATA.",
        line=18,
    ),
    _core(
        errors.MissingColumnError,
        "There are no columns with a colour",
        "Name columns LAB_L, LAB_A, LAB_B or XYZ_X, XYZ_Y, XYZ_Z, or the bands of a spectrum.",
        "There is no column LAB_B.",
        field="LAB_B",
    ),
    _core(
        errors.ConditionError,
        "The measurement condition is ambiguous or missing",
        "Select one with the option `condition`.",
        "The data has several measurement conditions: M0, M1, M2.",
        field="condition",
    ),
    _core(
        errors.SampleLimitError,
        "Too many samples, columns or channels",
        "Send fewer, for example only samples on the surface of the gamut.",
        "The file has more samples than the limit.",
    ),
    _core(
        errors.MalformedProfileError,
        "The ICC profile is malformed",
        "Send a profile that conforms to ICC.1 (ISO 15076-1).",
        "The tag A2B1 ends outside the profile.",
        tag="A2B1",
    ),
    _core(
        errors.UnsupportedProfileError,
        "The ICC profile is not supported",
        "Send an input, display, output or colour space profile with a device-to-PCS transform.",
        "Profiles of the class named colour have no gamut.",
    ),
    _core(
        errors.PictureSizeError,
        "The picture is too large",
        "Send a smaller copy of the picture.",
        "The picture has 60000 × 60000 pixels, 10800 MB unpacked.",
        field="size",
    ),
    _core(
        errors.UnsupportedPictureError,
        "The picture is not supported",
        "Send gray, RGB, CMYK or CIELAB pixels of 8 or 16 bits, or floats; CMYK with its profile "
        "embedded.",
        "The picture is CMYK without an embedded profile, so its colours are unknown.",
        field="profile",
    ),
    _core(
        errors.CharacterisationError,
        "The characterisation data cannot be used",
        _READ,
        "The characterisation data cannot be used.",
    ),
    _core(
        errors.TooFewPointsError,
        "Too few distinct colours",
        "Send at least four colours that do not lie in one plane.",
        "There are 3 distinct colours.",
    ),
    _core(
        errors.FlatPointsError,
        "The colours lie in one plane",
        "Send colours that span a volume.",
        "All colours lie in one plane.",
    ),
    _core(
        errors.CentreError,
        "The centre is not inside the gamut",
        "Give a centre inside the colours, or omit the option.",
        "The centre (50, 200, 0) is outside the convex hull of the colours.",
        field="centre",
    ),
    _core(
        errors.InvalidPointsError,
        "The colours cannot be used",
        "Send three finite numbers for every colour.",
        "Row 7 contains a value that is not finite.",
        row=7,
    ),
    _core(
        errors.TriangleCountError,
        "The gamut has no level with this triangle count",
        "Request a count from 4 to the largest count in the gamut's description.",
        "3 triangles were requested; a closed surface has at least 4.",
        field="triangles",
    ),
    _core(
        errors.BoundaryError,
        "No closed surface around the colours was found",
        "Try a larger gamma, other segments, or another centre.",
        "No surface that is star-shaped about the centre was found.",
    ),
    _core(
        errors.MeshError,
        "The surface is not closed, oriented and star-shaped",
        "Try a larger gamma, or another centre.",
        "An edge belongs to three triangles.",
    ),
    _core(
        errors.DecimationError,
        "The surface could not be decimated to four triangles",
        "Try a larger gamma, or another centre.",
        "No edge can be collapsed although 12 triangles are left.",
    ),
    _core(
        errors.NeighbourLimitError,
        "Vertices have too many neighbours",
        "Divide the surface so that fewer triangles meet at a vertex.",
        "Up to 131072 triangles meet at a vertex, and levels would take too long to read.",
        neighbours=131072,
    ),
    _core(
        errors.HistoryFileError,
        "A history file is damaged",
        "Post the characterisation data again.",
        "The history file is damaged.",
    ),
    _core(
        errors.GamutError,
        "The gamut cannot be built",
        "Compare the request with the documentation.",
        "The gamut cannot be built.",
    ),
)

_ROWS = (
    *_CORE_ROWS,
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
    Kind(
        "store-unavailable",
        503,
        "The store is unavailable",
        "Try again after the time in Retry-After. The log has the cause.",
        "The store did not answer, or it refused the request.",
    ),
    Kind(
        "storage-full",
        507,
        "The store is full",
        "The operator must free or add space. Existing gamuts are available.",
        "There is no space left in the store.",
    ),
)

BUILD_PROBLEMS = tuple(
    kind.code
    for kind in _ROWS
    if kind.status == 422
    and kind.code not in {"invalid-body", "invalid-parameter", "triangle-count"}
)
"""Codes of problems with the content of a build."""

KINDS: dict[str, Kind] = {kind.code: kind for kind in _ROWS}
"""All kinds of problems by code."""
