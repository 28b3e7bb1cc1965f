"""Problem documents (RFC 9457): every error of the service has this form.

All JSON is sent as ASCII. Clients' text comes back in problems and may hold lone surrogates, which
UTF-8 cannot express and escapes can.
"""

from __future__ import annotations

import errno
import json
from dataclasses import dataclass, field, fields, replace
from typing import TYPE_CHECKING, Any

from starlette.responses import Response

from gamutcore import errors
from gamutcore.options import Options
from service.problems.kinds import KINDS, Kind

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = ["MEDIA_TYPE", "JsonResponse", "Problem", "ProblemError", "problem_response", "sentence"]

MEDIA_TYPE = "application/problem+json"

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

_OPTIONS = frozenset(each.name for each in fields(Options))


def sentence(text: str) -> str:
    """Return what an exception says as a sentence: they may say it without capital and full stop.

    A text that begins with the name of an option keeps it as it is written.
    """
    if text.partition(" ")[0] not in _OPTIONS:
        text = text[:1].upper() + text[1:]
    return text + "." if text and text[-1] not in ".:!?" else text


class JsonResponse(Response):
    """A response with a JSON document."""

    media_type = "application/json"

    def render(self, content: Any) -> bytes:  # noqa: ANN401 - whatever JSON can express
        """Return the body: RFC 8259, ended by a newline."""
        text = json.dumps(content, ensure_ascii=True, allow_nan=False, separators=(",", ":"))
        return text.encode("ascii") + b"\n"


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
