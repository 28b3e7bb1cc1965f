"""Charsets of request bodies."""

from __future__ import annotations

import codecs
from typing import TYPE_CHECKING

from python_multipart.multipart import parse_options_header

from service.problems.problem import Problem, problem_response

if TYPE_CHECKING:
    from starlette.types import ASGIApp, Receive, Scope, Send

__all__ = ["Charsets"]

_TEXTS = frozenset({"utf-8", "ascii", "iso8859-1", "cp1252"})
"""Python's names of the accepted charsets. Many other codecs of Python are no charsets, or raise
errors of their own."""


class Charsets:
    """ASGI middleware that refuses bodies in other charsets than UTF-8 and the Western ones.

    Parameters
    ----------
    app : ASGI app
    """

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass the request on, or answer with the problem."""
        answer = self.app
        if scope["type"] == "http":
            for name, value in scope["headers"]:
                if name == b"content-type" and b"charset" in value.lower():
                    # Parsed as Starlette's form parser does.
                    _, parameters = parse_options_header(value)
                    charset = parameters.get(b"charset", b"utf-8").decode("latin-1")
                    if not _is_text(charset):
                        answer = problem_response(_problem(charset))
        await answer(scope, receive, send)


def _is_text(charset: str) -> bool:
    try:
        return codecs.lookup(charset).name in _TEXTS
    except (LookupError, ValueError):
        return False


def _problem(charset: str) -> Problem:
    detail = f"The body has the charset {charset[:40]!r}."
    return Problem(
        "unsupported-media-type", detail, {"header": "Content-Type"}, "Send the body in UTF-8."
    )
