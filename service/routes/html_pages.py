"""HTML pages: one layout, in light and dark, without external resources.

A page contains its style and no script. The content security policy allows exactly this style, by
its digest, so text on a page can never run or load anything.
"""

from __future__ import annotations

import base64
import hashlib
from html import escape
from typing import TYPE_CHECKING

from starlette.responses import HTMLResponse

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

__all__ = ["SECURITY_HEADERS", "definitions", "link", "page", "table"]

_STYLE = """\
:root{color-scheme:light dark;--text:#1b1f24;--soft:#57606a;--line:#d0d7de;--back:#fff;\
--box:#f3f5f7;--link:#0550ae;--good:#116329;--fair:#7d4e00;--bad:#a40e26}
@media(prefers-color-scheme:dark){:root{--text:#e6edf3;--soft:#9aa5b1;--line:#3d444d;--back:#0d1117;\
--box:#1a2029;--link:#79b8ff;--good:#56d364;--fair:#e3b341;--bad:#ff8182}}
*{box-sizing:border-box}
body{margin:0;background:var(--back);color:var(--text);font:16px/1.55 system-ui,sans-serif}
main,header,footer{max-width:52rem;margin:0 auto;padding:0 1.25rem}
header{padding-top:1.5rem}
footer{padding-bottom:2.5rem;margin-top:2.5rem;color:var(--soft);font-size:.9rem}
h1{font-size:1.75rem;line-height:1.25;margin:.6rem 0 1rem}
h2{font-size:1.2rem;margin:2rem 0 .6rem}
a{color:var(--link)}
a:focus-visible,pre:focus-visible,div:focus-visible{\
outline:3px solid var(--link);outline-offset:2px}
code,pre{font:.92em/1.5 ui-monospace,monospace}
code{background:var(--box);padding:.1em .35em;border-radius:4px}
pre{background:var(--box);padding:1rem;border-radius:6px;overflow-x:auto}
pre code{padding:0;background:none}
.wide{overflow-x:auto;margin-top:1.25rem}
table{border-collapse:collapse;width:100%}
caption{text-align:left;color:var(--soft);padding-bottom:.4rem}
th,td{text-align:left;vertical-align:top;padding:.45rem 1rem .45rem 0;\
border-bottom:1px solid var(--line)}
th{font-weight:600}
dl{display:grid;grid-template-columns:max-content 1fr;gap:.35rem 1.25rem;margin:0}
dt{color:var(--soft)}
dd{margin:0;font-variant-numeric:tabular-nums}
ul{padding-left:1.2rem}
.ok{color:var(--good);font-weight:600}
.degraded{color:var(--fair);font-weight:600}
.failed{color:var(--bad);font-weight:600}
"""

_STYLE_DIGEST = base64.b64encode(hashlib.sha256(_STYLE.encode()).digest()).decode()

SECURITY_HEADERS = {
    "Content-Security-Policy": f"default-src 'none'; style-src 'sha256-{_STYLE_DIGEST}'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
}
"""Header fields of every page."""


def page(
    title: str, content: str, *, home: bool = True, headers: Mapping[str, str] | None = None
) -> HTMLResponse:
    """Return the response of a page.

    Parameters
    ----------
    title : str
        Plain text: document title and first heading.
    content : str
        HTML.
    home : bool
        Whether to link to the landing page.
    headers : mapping, optional
        Additional header fields.
    """
    name = "Gamut boundary service"
    whole_title = title if title == name else f"{title} – {name}"
    way = f"<nav>{link('/', name)}</nav>" if home else ""
    return HTMLResponse(
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width,initial-scale=1">\n'
        f"<title>{escape(whole_title)}</title>\n<style>{_STYLE}</style>\n</head>\n<body>\n"
        f"<header>{way}<h1>{escape(title)}</h1></header>\n<main>\n{content}\n</main>\n"
        f"<footer>{link('/docs', 'API')} · {link('/problems', 'Problems')} · "
        f"{link('/metrics', 'Figures')}</footer>\n</body>\n</html>\n",
        headers={**SECURITY_HEADERS, "Vary": "Accept", **(headers or {})},
    )


def link(address: str, text: str) -> str:
    """Return a link. The text is plain."""
    return f'<a href="{escape(address)}">{escape(text)}</a>'


def table(caption: str, heads: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """Return a table of HTML cells with row heads first; caption and heads are plain text."""
    head = "".join(f'<th scope="col">{escape(text)}</th>' for text in heads)
    body = ""
    for first, *others in rows:
        cells = "".join(f"<td>{cell}</td>" for cell in others)
        body += f'<tr><th scope="row">{first}</th>{cells}</tr>\n'
    # Wide tables scroll horizontally, also by keyboard.
    return (
        f'<div class="wide" tabindex="0" role="region" aria-label="{escape(caption)}"><table>'
        f"<caption>{escape(caption)}</caption>\n<thead><tr>{head}</tr></thead>\n"
        f"<tbody>\n{body}</tbody></table></div>"
    )


def definitions(pairs: Iterable[tuple[str, str]]) -> str:
    """Return a description list of plain terms and HTML meanings."""
    items = "".join(f"<dt>{escape(term)}</dt><dd>{meaning}</dd>\n" for term, meaning in pairs)
    return f"<dl>\n{items}</dl>"
