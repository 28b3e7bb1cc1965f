"""One HTML file that shows gamuts with the viewer: without the service, and without a network.

The file holds the viewer's script, style and worker, the descriptions and the histories. Every
level is therefore in it. Its content security policy forbids every connection. The viewer is built
from ``web/viewer``; see ``docs/decisions/viewer.md``.
"""

from __future__ import annotations

import base64
import functools
import hashlib
import json
import re
from collections.abc import Mapping, Sequence
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import Any, NamedTuple

from gamutcore.errors import OptionError
from gamutcore.results import PAGE_STATE

__all__ = [
    "EXAMPLE_FILES",
    "HTML_SUFFIXES",
    "MEDIA_TYPE",
    "MOST_GAMUTS",
    "VIEWER_FILES",
    "PageGamut",
    "viewer_page",
]

HTML_SUFFIXES = (".html", ".htm")

MEDIA_TYPE = "text/html"

MOST_GAMUTS = 6
"""The viewer has so many places (`SLOTS` of its page)."""

VIEWER_FILES = Path(str(files("gamutcore.export"))) / "viewer"
"""The viewer as it was built."""

EXAMPLE_FILES = Path(str(files("gamutcore.export"))) / "examples"
"""Gamuts that the viewer shows without a build, made by ``docs/pictures/examples.py``."""

_LINKS = re.compile(r"<link rel=\"(?:icon|stylesheet)\".*\n|<script .*\n|<!--.*-->\n")
"""What the page loads from the service, and the place of its still picture."""


class PageGamut(NamedTuple):
    """A gamut of a page: its display name, its description as of `gamutcore.Gamut`, its history."""

    name: str
    description: Mapping[str, Any]
    history: bytes

    @property
    def document(self) -> dict[str, Any]:
        """The description as the service gives it, as far as the viewer uses it."""
        channels = self.description["provenance"].get("channels", [])
        return {**self.description, "name": self.name, "channels": channels}


def viewer_page(gamuts: Sequence[PageGamut], coverage: Mapping[str, object] | None = None) -> bytes:
    """Return gamuts as an HTML file in UTF-8: about 4/3 of the histories' size, and 0.6 MB.

    `coverage` has ``a_covers_b``, ``b_covers_a`` and ``summary`` of the first two gamuts. Raise
    `OptionError` if there are more gamuts than places.
    """
    if len(gamuts) > MOST_GAMUTS:
        raise OptionError.refusal("gamuts", len(gamuts), f"at most {MOST_GAMUTS}")
    content = {
        "gamuts": [
            {"gamut": each.document, "history": base64.b64encode(each.history).decode()}
            for each in gamuts
        ],
        "coverage": coverage,
    }
    before, after = _template()
    title = f"<title>{escape(' and '.join(each.name for each in gamuts))} – gamut</title>"
    before = before.replace("<title>Gamut viewer</title>", title)
    return "".join((before, _json(content), after)).encode()


def _json(content: object) -> str:
    # JSON may have this character in strings only, and a script must not have it before "/script".
    return json.dumps(content, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")


@functools.cache
def _template() -> tuple[str, str]:
    """Return the page before and after the gamuts."""
    text, style, script, worker = (
        (VIEWER_FILES / name).read_text("utf-8")
        for name in ("index.html", "viewer.css", "viewer.js", "worker.js")
    )
    policy = (
        f"default-src 'none'; script-src {_digest(script)} blob:; worker-src blob:; "
        f"style-src {_digest(style)}; img-src data: blob:; base-uri 'none'; form-action 'none'"
    )
    head = (
        f'<meta http-equiv="Content-Security-Policy" content="{policy}">\n'
        f'<link rel="icon" href="data:,">\n<style>{style}</style>\n'
        f'<script type="module">{script}</script>\n'
    )
    text = _LINKS.sub("", text).replace("{root}", "").replace("<html ", "<html data-offline ", 1)
    before, after = text.split("</body>")
    before = before.replace("</head>", f"{head}</head>", 1)
    sources = f'<script type="text/plain" id="worker-source">{worker}</script>\n'
    opening = '<script type="application/json" id="gamut-file">'
    # The script of the page, and `ViewerPage.restoring`, replace the state.
    state = f"{PAGE_STATE.decode()}null</script>\n"
    return f"{before}{sources}{opening}", f"</script>\n{state}</body>{after}"


def _digest(text: str) -> str:
    """Return the source expression of an inline script or style (CSP level 3, 2.3.1)."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"
