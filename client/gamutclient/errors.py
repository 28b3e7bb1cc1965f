"""Errors of the client: the problems of the service, and lost connections."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

__all__ = ["ConnectionLostError", "GamutClientError", "InvalidPointsError", "ServiceError"]


class GamutClientError(Exception):
    """Base of all errors of the client."""


class ConnectionLostError(GamutClientError):
    """The service could not be reached, in spite of all retries."""


class InvalidPointsError(GamutClientError, ValueError):
    """Colours are no array (..., 3) of numbers, so they were not sent."""

    code = "invalid-points"
    """As of the service and of `gamutcore`."""


class ServiceError(GamutClientError):
    """The service answered with a problem document (RFC 9457).

    Attributes
    ----------
    code : str
        Stable code of the problem, such as ``"invalid-option"``; `gamutcore` has the same codes.
    status : int
        HTTP status; 200 for a build that failed.
    where : dict
        What is at fault: field, row, line, header or limit.
    remedy : str
        What would be right.
    """

    def __init__(
        self, code: str, message: str, status: int, where: Mapping[str, Any], remedy: str
    ) -> None:
        super().__init__(message)
        self.code, self.status = code, status
        self.where, self.remedy = dict(where), remedy

    def __str__(self) -> str:
        text = f"{super().__str__()} {self.remedy}".strip()
        return f"{text} [{self.code}]"

    @classmethod
    def from_document(cls, document: Mapping[str, Any], status: int) -> ServiceError:
        """Return the error of a problem document."""
        return cls(
            str(document.get("code", f"http-{status}")),
            str(document.get("detail") or document.get("title") or f"HTTP status {status}."),
            status,
            document.get("where") or {},
            str(document.get("remedy") or ""),
        )
