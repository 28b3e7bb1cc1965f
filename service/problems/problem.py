"""Every error of the service: one table from stable codes to HTTP status, title and remedy.

The errors of `gamutcore` and those of HTTP itself are rows of the same table; problem documents
(RFC 9457), the OpenAPI document's examples and the pages under ``/problems/`` are all made from it.
A code, once released, never changes its meaning.
"""

from __future__ import annotations

import errno
from dataclasses import dataclass, field, fields, replace
from typing import TYPE_CHECKING, Any

from gamutcore import errors
from gamutcore.options import Options
from service.problems.core_problems import CORE_KINDS, Kind
from service.problems.responses import JsonResponse

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = [
    "BUILD_PROBLEMS",
    "KINDS",
    "MEDIA_TYPE",
    "Kind",
    "Problem",
    "ProblemError",
    "problem_response",
    "sentence",
]

MEDIA_TYPE = "application/problem+json"


_DEFECT = "This is a defect of the service; please report it with the gamut's id."

_STORE_ERRNOS = frozenset(
    {
        errno.EIO,
        errno.EROFS,
        errno.ESTALE,
        # A volume that is not mounted any more, or whose permissions have changed.
        errno.ENOENT,
        errno.ENOTDIR,
        errno.EACCES,
        errno.ENXIO,
    }
)
"""Error numbers of a file system that cannot be used; routes open no other files than a store's."""

_ROWS = (
    *CORE_KINDS,
    # What can become of a build.
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
    # What can be wrong with a request.
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
    # What is the service's own matter.
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
"""Codes of what can be wrong with the content that a build is asked for."""

_OPTIONS = frozenset(each.name for each in fields(Options))

KINDS: dict[str, Kind] = {kind.code: kind for kind in _ROWS}
"""All kinds of problems by their code."""


def sentence(text: str) -> str:
    """Return what an exception says as a sentence: they may say it without capital and full stop.

    A text that begins with the name of an option keeps it as it is written.
    """
    if text.partition(" ")[0] not in _OPTIONS:
        text = text[:1].upper() + text[1:]
    return text + "." if text and text[-1] not in ".:!?" else text


@dataclass(frozen=True)
class Problem:
    """One thing that went wrong.

    Attributes
    ----------
    code : str
        A key of `KINDS`; an unknown one is reported as ``gamut-error``.
    detail : str
        What was wrong this time, with the values at fault.
    where : mapping
        Where: keys such as ``field``, ``line``, ``column``, ``tag``, ``row``, ``header``.
    remedy : str
        What would be right; the kind's, if empty.
    headers : mapping
        Header fields that the response needs besides.
    """

    code: str
    detail: str
    where: Mapping[str, Any] = field(default_factory=dict)
    remedy: str = ""
    headers: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def from_error(cls, error: errors.GamutError) -> Problem:
        """Return the problem that an error of `gamutcore` is for a client, told in sentences."""
        return cls(error.code, sentence(error.message), error.where, sentence(error.remedy))

    @classmethod
    def from_errno(cls, number: int | None) -> Problem | None:
        """Return the problem that an error number of the system is; None for a defect."""
        if number in {errno.ENOSPC, errno.EDQUOT}:
            return cls("storage-full", KINDS["storage-full"].detail)
        if number in _STORE_ERRNOS:
            return cls.store_unavailable()
        if number in {errno.EMFILE, errno.ENFILE}:
            detail = "Too many files and connections are open."
            return cls("overloaded", detail, headers={"Retry-After": "5"})
        return None

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> Problem:
        """Return the problem that `to_mapping` made a mapping of."""
        problem = cls(mapping["code"], mapping["detail"], mapping["where"], mapping["remedy"])
        if problem.kind.status == 503:
            return replace(problem, headers={"Retry-After": "5"})
        return problem

    def to_mapping(self) -> dict[str, Any]:
        """Return what is particular to this problem, for JSON; header fields are left out."""
        return {
            "code": self.code,
            "detail": self.detail,
            "where": dict(self.where),
            "remedy": self.remedy,
        }

    @classmethod
    def store_unavailable(cls) -> Problem:
        """Return the problem of a store that does not answer; the log has the reason."""
        code = "store-unavailable"
        return cls(code, KINDS[code].detail, headers={"Retry-After": "5"})

    @property
    def kind(self) -> Kind:
        """The row of the table."""
        return KINDS.get(self.code, KINDS[errors.GamutError.code])

    def document(self) -> dict[str, Any]:
        """Return the problem document: RFC 9457 clause 3, and the members code, where, remedy."""
        kind = self.kind
        return {
            "type": f"/problems/{kind.code}",
            "title": kind.title,
            "status": kind.status,
            "detail": self.detail,
            "code": kind.code,
            "where": dict(self.where),
            "remedy": self.remedy or kind.remedy,
        }


class ProblemError(Exception):
    """Ends the handling of a request with a problem document."""

    def __init__(self, problem: Problem) -> None:
        super().__init__(problem.detail)
        self.problem = problem


def problem_response(problem: Problem) -> JsonResponse:
    """Return the HTTP response of a problem; no cache keeps it."""
    return JsonResponse(
        problem.document(),
        status_code=problem.kind.status,
        media_type=MEDIA_TYPE,
        headers={"Cache-Control": "no-store", **problem.headers},
    )
