"""Problem documents (RFC 9457), the form of every error of the service.

JSON is sent as ASCII. Problems repeat text of clients, which may contain lone surrogates. UTF-8
cannot encode these, but escapes can.
"""

from __future__ import annotations

import errno
import json
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel
from starlette.responses import Response

from gamutcore import errors
from gamutcore.options import OPTIONS
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
        # An unmounted volume, or changed permissions.
        errno.ENOENT,
        errno.ENOTDIR,
        errno.EACCES,
        errno.EPERM,
        errno.ENXIO,
    }
)
"""Error numbers of an unusable file system. Routes open files of the store only."""


def sentence(text: str) -> str:
    """Return the text of an exception as a sentence, with a capital letter and a full stop.

    A text that begins with the name of an option keeps the name's spelling.
    """
    if text.partition(" ")[0] not in OPTIONS:
        text = text[:1].upper() + text[1:]
    return text + "." if text and text[-1] not in ".:!?" else text


class JsonResponse(Response):
    """A response with a JSON document: a model of the API without the members that are not set."""

    media_type = "application/json"

    def render(self, content: Any) -> bytes:  # noqa: ANN401 - whatever JSON can express
        """Return the body: RFC 8259, ended by a newline."""
        if isinstance(content, BaseModel):
            content = content.model_dump(by_alias=True, exclude_unset=True)
        text = json.dumps(content, ensure_ascii=True, allow_nan=False, separators=(",", ":"))
        return text.encode("ascii") + b"\n"


@dataclass(frozen=True)
class Problem:
    """One occurrence of a problem; an unknown `code` is reported as ``gamut-error``.

    `where` is the place, with keys such as ``field``, ``line``, ``column``, ``tag``, ``row`` and
    ``header``. An empty `remedy` stands for the remedy of the kind.
    """

    code: str
    detail: str
    where: Mapping[str, Any] = field(default_factory=dict)
    remedy: str = ""
    headers: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def from_error(cls, error: errors.GamutError) -> Problem:
        """Return the problem for an error of `gamutcore`."""
        return cls(error.code, sentence(error.message), error.where, error.remedy)

    @classmethod
    def from_errno(cls, number: int | None, *, remote: bool = False) -> Problem | None:
        """Return the problem for a system error number; None for a defect.

        If the store is remote, only the scratch space is on a disk.
        """
        if number in {errno.ENOSPC, errno.EDQUOT}:
            code = "scratch-full" if remote else "storage-full"
            return cls(code, KINDS[code].detail)
        if number in _STORE_ERRNOS:
            return cls.store_unavailable()
        if number in {errno.EMFILE, errno.ENFILE}:
            return cls("overloaded", KINDS["overloaded"].detail, headers={"Retry-After": "5"})
        return None

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> Problem:
        """Return the problem that `to_mapping` converted."""
        problem = cls(mapping["code"], mapping["detail"], mapping["where"], mapping["remedy"])
        if problem.kind.status == 503:
            return replace(problem, headers={"Retry-After": "5"})
        return problem

    def to_mapping(self) -> dict[str, Any]:
        """Return the problem as JSON-able mapping, without header fields."""
        return {
            "code": self.code,
            "detail": self.detail,
            "where": dict(self.where),
            "remedy": self.remedy,
        }

    @classmethod
    def store_unavailable(cls) -> Problem:
        """Return the problem of an unavailable store. The log has the cause."""
        code = "store-unavailable"
        return cls(code, KINDS[code].detail, headers={"Retry-After": "5"})

    @property
    def kind(self) -> Kind:
        """The row of the table."""
        return KINDS.get(self.code, KINDS[errors.GamutError.code])

    def document(self) -> dict[str, Any]:
        """Return the problem document: RFC 9457, with the members code, where and remedy."""
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
    """Ends a request with a problem document."""

    def __init__(self, problem: Problem) -> None:
        super().__init__(problem.detail)
        self.problem = problem


def problem_response(problem: Problem) -> JsonResponse:
    """Return the response of a problem, which is never cached."""
    return JsonResponse(
        problem.document(),
        status_code=problem.kind.status,
        media_type=MEDIA_TYPE,
        headers={"Cache-Control": "no-store", **problem.headers},
    )
