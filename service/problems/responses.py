"""The one form in which the service sends JSON: ASCII, compact, a line.

Text that clients sent comes back in answers, and JSON lets it hold lone surrogates, which UTF-8
cannot express. Escapes can, so everything outside of ASCII is sent as escapes.
"""

from __future__ import annotations

import json
from typing import Any

from starlette.responses import Response

__all__ = ["JsonResponse"]


class JsonResponse(Response):
    """A response with a JSON document."""

    media_type = "application/json"

    def render(self, content: Any) -> bytes:  # noqa: ANN401 - whatever JSON can express
        """Return the body: RFC 8259, ended by a newline."""
        text = json.dumps(content, ensure_ascii=True, allow_nan=False, separators=(",", ":"))
        return text.encode("ascii") + b"\n"
