"""One HTML file that shows a gamut with the viewer: without the service, and without a network.

The file holds the viewer's script, style and worker, the description and the history. Every level
is therefore in it. Its content security policy forbids every connection. The viewer is built from
``web/viewer``; see ``docs/decisions/viewer.md``.
"""

from __future__ import annotations

import base64
import functools
import hashlib
import json
import re
from collections.abc import Mapping
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import Any

__all__ = ["HTML_SUFFIXES", "MEDIA_TYPE", "VIEWER_FILES", "viewer_page"]

HTML_SUFFIXES = (".html", ".htm")

MEDIA_TYPE = "text/html"

VIEWER_FILES = Path(str(files("gamutcore.export"))) / "viewer"
"""The viewer as it was built."""

_LINKS = re.compile(r"<link rel=\"(?:icon|stylesheet)\".*\n|<script .*\n|<!--.*-->\n")
"""What the page loads from the service, and the place of its still picture."""


def viewer_page(description: Mapping[str, Any], history: bytes, name: str) -> bytes:
    """Return a gamut as an HTML file in UTF-8: about 4/3 of the history's size, and 0.6 MB.

    The description is that of `gamutcore.Gamut`. `name` is the gamut's display name.
    """
    provenance = description["provenance"]
    gamut = {**description, "name": name, "channels": provenance.get("channels", [])}
    content = {
        "gamut": gamut,
        "history": base64.b64encode(history).decode(),
    }
    before, after = _template()
    # JSON may have this character in strings only, and a script must not have it before "/script".
    data = json.dumps(content, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    title = f"<title>{escape(name)} – gamut</title>"
    return "".join((before.replace("<title>Gamut viewer</title>", title), data, after)).encode()


@functools.cache
def _template() -> tuple[str, str]:
    """Return the page before and after the data."""
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
    return f"{before}{sources}{opening}", f"</script>\n</body>{after}"


def _digest(text: str) -> str:
    """Return the source expression of an inline script or style (CSP level 3, 2.3.1)."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"
