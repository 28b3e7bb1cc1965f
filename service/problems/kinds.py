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

__all__ = ["BUILD_PROBLEMS", "KINDS", "Kind"]

_DEFECT = "This is a defect of the service; please report it with the gamut's id."


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


_READ = (
    "CGATS and IT8 text, CxF3, CSV, JSON, NumPy arrays (.npy), ICC profiles and pictures (PNG, "
    "TIFF, JPEG) are read."
)

_CORE_ROWS = (
    _core(
        errors.OptionError,
        "An option is not accepted",
        "Use an option and a value from the documentation of POST /v1/gamuts.",
        "gamma is 1.5, which is not accepted.",
        field="gamma",
    ),
    _core(
        errors.UnrecognisedFormatError,
        "The file's format is not recognised",
        _READ,
        "The content is of none of the formats that are read.",
    ),
    _core(
        errors.MalformedFileError,
        "The file breaks its format",
        "Correct the place that is named.",
        "BEGIN_DATA is not followed by END_DATA.",
        line=18,
    ),
    _core(
        errors.MissingColumnError,
        "The columns do not hold a colour",
        "Name columns LAB_L, LAB_A, LAB_B or XYZ_X, XYZ_Y, XYZ_Z, or the bands of a spectrum.",
        "There is no column LAB_B.",
        field="LAB_B",
    ),
    _core(
        errors.ConditionError,
        "Several measurement conditions, or another one",
        "Choose one of them by the option `condition`.",
        "The data was measured under several conditions: M0, M1, M2.",
        field="condition",
    ),
    _core(
        errors.SampleLimitError,
        "Too many samples, columns or channels",
        "Send fewer, for instance only those on the surface of the gamut.",
        "The file has more samples than are accepted.",
    ),
    _core(
        errors.MalformedProfileError,
        "The ICC profile is malformed",
        "Send a profile that keeps to ICC.1 (ISO 15076-1).",
        "The tag A2B1 ends outside the profile.",
        tag="A2B1",
    ),
    _core(
        errors.UnsupportedProfileError,
        "The ICC profile is of an unsupported kind",
        "Send an input, display, output or colour space profile with a device to PCS side.",
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
        "The picture is of an unsupported kind",
        "Send PNG, baseline or progressive JPEG, or TIFF without compression, with LZW, deflate, "
        "PackBits or JPEG; CMYK with its profile embedded.",
        "The picture is CMYK and has no embedded profile, so its colours are not known.",
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
        "Send at least four colours that are not in one plane.",
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
        "Give a centre that is surrounded by the colours, or leave it out.",
        "The centre (50, 200, 0) is outside the convex hull of the colours.",
        field="centre",
    ),
    _core(
        errors.InvalidPointsError,
        "The colours cannot be used",
        "Send three finite numbers for every colour.",
        "Row 7 holds a value that is not a finite number.",
        row=7,
    ),
    _core(
        errors.TriangleCountError,
        "The gamut has no level of this triangle count",
        "Ask for a count from 4 up to the gamut's largest, which its description tells.",
        "3 triangles were asked for; a closed surface has at least 4.",
        field="triangles",
    ),
    _core(
        errors.BoundaryError,
        "No closed surface could be wrapped around the colours",
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
        "The build took too long",
        "Ask for fewer surface_samples, or send fewer samples.",
        "The build was ended after 120 s.",
        {"field": "surface_samples"},
    ),
    Kind(
        "build-out-of-memory",
        422,
        "The build took too much memory",
        "Ask for fewer surface_samples, or send fewer samples or a smaller picture.",
        "The build was ended because it took more than 2147483648 bytes of memory.",
        {"field": "surface_samples"},
    ),
    Kind(
        "build-crashed",
        422,
        "The build process died",
        "Ask for fewer surface_samples; if that does not help, report the input as a defect.",
        "The process that built this gamut died, 3 times in a row.",
    ),
    Kind(
        "build-failed",
        422,
        "The build ended unexpectedly",
        _DEFECT,
        "The build ended with an unexpected error.",
    ),
    Kind(
        "build-cancelled",
        409,
        "The build was cancelled",
        "Post the data again if the gamut is wanted after all.",
        "The build was cancelled before it was finished.",
    ),
    Kind(
        "gamut-deleted",
        409,
        "The gamut was deleted meanwhile",
        "Post the data again if the gamut is wanted after all.",
        "The gamut was built, and deleted before it could be answered with.",
    ),
    Kind(
        "build-input-lost",
        409,
        "The data of the build is gone",
        "Post the data again.",
        "The data that this gamut was to be built from is not stored any more.",
    ),
    Kind(
        "queue-full",
        429,
        "Too many builds are waiting",
        "Try again after the time in Retry-After.",
        "16 builds are waiting already.",
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
        "Send the parts `file` and, if you like, `options`; or JSON with `samples` and `options`.",
        "There is no part named file.",
        {"field": "file"},
    ),
    Kind(
        "invalid-parameter",
        422,
        "A parameter is not accepted",
        "Use a value from the documentation of the operation.",
        "'2d119c9b' is not an id, which is 64 hexadecimal digits in lower case.",
        {"in": "path", "field": "gamut_id"},
    ),
    Kind(
        "api-key-required",
        401,
        "An API key is required",
        "Send `Authorization: Bearer KEY` or `X-Api-Key: KEY` with a key of this service.",
        "This needs an API key with the scope write.",
        {"scope": "write"},
    ),
    Kind(
        "scope-missing",
        403,
        "The API key does not allow this",
        "Use a key that has the scope.",
        "The API key does not have the scope write.",
        {"scope": "write"},
    ),
    Kind(
        "rate-limited",
        429,
        "Too many requests",
        "Try again after the time in Retry-After.",
        "There were more than 100 requests at once, and 10 a second.",
        {"limit": "requests"},
    ),
    Kind(
        "not-found",
        404,
        "There is nothing at this address",
        "The addresses of the service are listed under /docs.",
        "There is nothing at /v2/gamuts.",
    ),
    Kind(
        "gamut-not-found",
        404,
        "There is no gamut of this id",
        "Post its characterisation data to /v1/gamuts; the same data and options give the same id.",
        "There is no gamut 4f1d9c07….",
        {"field": "gamut_id"},
    ),
    Kind(
        "job-not-found",
        404,
        "There is no job of this id",
        "Post the characterisation data to /v1/gamuts again.",
        "There is no job 4f1d9c07….",
        {"field": "job_id"},
    ),
    Kind(
        "job-finished",
        409,
        "The job is over",
        "Only a queued or running job can be cancelled; a gamut is removed by its own address.",
        "The job has succeeded.",
        {"state": "succeeded"},
    ),
    Kind(
        "too-many-streams",
        429,
        "Too many clients follow jobs by events",
        "Poll the job's own address instead, or try again after the time in Retry-After.",
        "256 streams of events are open.",
    ),
    Kind(
        "method-not-allowed",
        405,
        "The method is not allowed here",
        "Use one of the methods in the header Allow.",
        "PUT is not allowed for /v1/gamuts.",
        {"allowed": ["GET", "HEAD", "POST"]},
    ),
    Kind(
        "not-acceptable",
        406,
        "No accepted media type is available",
        "Accept one of the media types that are listed, or name a format with format=.",
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
        "The request came too slowly",
        "Send it again, faster or in a smaller form.",
        "4096 bytes of the body came within 21 s.",
    ),
    Kind(
        "head-too-large",
        431,
        "The address and header fields are too large",
        "Send a shorter address and fewer or shorter header fields.",
        "The address and the header fields are larger than 32768 bytes.",
        {"limit": 32768},
    ),
    Kind(
        "unsupported-media-type",
        415,
        "The body's media type is not accepted",
        "Send multipart/form-data with a part `file`, or application/json with `samples`.",
        "The body is text/plain.",
        {"header": "Content-Type"},
    ),
    Kind(
        "precondition-failed",
        412,
        "The content is not the one that was named",
        "Ask without If-Match, or name the ETag that the resource has now.",
        "No entity tag in If-Match is the one of the content.",
        {"header": "If-Match"},
    ),
    Kind(
        "range-not-satisfiable",
        416,
        "The range is outside the file",
        "Ask for a range that begins inside the file; Content-Range tells its size.",
        "The file has 3603856 bytes.",
        {"header": "Range"},
    ),
    Kind(
        "bad-request",
        400,
        "The request is malformed",
        "Send a request as RFC 9110 defines it.",
        "The request is malformed.",
    ),
    # Problems of the service.
    Kind(
        "internal-error",
        500,
        "The service has a defect",
        "Report it with the time of the request; the log has the rest.",
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
        "The gamut was damaged and is being built again",
        "Try again after the time in Retry-After; the job's address tells how far it is.",
        "The stored gamut does not match its digest, and is being built again.",
        {"job": "/v1/jobs/4f1d9c07…"},
    ),
    Kind(
        "shutting-down",
        503,
        "The service is stopping",
        "Send the request again; another instance, or the restarted one, will take it.",
        "The service is stopping and accepts no new builds.",
    ),
    Kind(
        "broker-unavailable",
        503,
        "New builds cannot be queued",
        "Try again after the time in Retry-After; gamuts that exist are answered meanwhile.",
        "The queue of builds cannot be reached.",
    ),
    Kind(
        "overloaded",
        503,
        "The service is overloaded",
        "Try again after the time in Retry-After, with fewer connections at the same time.",
        "Too many files and connections are open.",
    ),
    Kind(
        "store-unavailable",
        503,
        "The store cannot be reached",
        "Try again after the time in Retry-After; the operator finds the reason in the log.",
        "The store did not answer, or refused.",
    ),
    Kind(
        "storage-full",
        507,
        "The store is full",
        "The operator has to free or add space; existing gamuts are still served.",
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
