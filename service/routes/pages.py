"""Routes of HTML pages: the state of the service and one page per kind of problem.

All are also available as JSON, by ``Accept``. Pages have one layout, in light and dark, without
external resources. A page contains its style and no script. The content security policy allows
exactly this style, by its digest, so text on a page can never run or load anything.
"""

import base64
import hashlib
import json
from collections.abc import Iterable, Mapping
from html import escape
from typing import Annotated, Any

from fastapi import APIRouter, Path, Request
from fastapi.responses import HTMLResponse, Response

from gamutcore.version import ALGORITHM_VERSION, __version__
from service.container import ServiceContainer, service_of
from service.http.representations import conditional, preferred_media_type
from service.problems.kinds import KINDS, Kind
from service.problems.problem import JsonResponse, Problem, ProblemError
from service.readiness import Report
from service.routes.state import readiness

__all__ = ["SECURITY_HEADERS", "definitions", "link", "page", "router", "status", "table"]

router = APIRouter(include_in_schema=False)

_NO_CACHE = {"Cache-Control": "no-cache"}
_NO_STORE = {"Cache-Control": "no-store"}

_INTRODUCTION = (
    "<p>Send the measurements or the ICC profile of a display, a press or any other device, a "
    "picture or a gamut mesh, and get the surface of its gamut with any number of triangles."
    "</p>\n"
)

_LINKS = {
    "/view": "Viewer",
    "/status": "State of the service",
    "/docs": "All operations, interactive",
    "/openapi.json": "OpenAPI document",
    "/v1/gamuts": "Stored gamuts",
    "/v1/references": "Reference gamuts",
    "/problems": "Kinds of problems",
    "/metrics": "Metrics for Prometheus",
    "/readyz": "Readiness",
    "/livez": "Liveness",
}


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


@router.get("/status")
async def status(request: Request) -> Response:
    """Show the state of the service and its links."""
    service = service_of(request)
    report = await service.readiness.report()
    if _wants_json(request):
        return JsonResponse(_status_document(service, report), headers=_json_headers(_NO_STORE))
    example = f"curl -F file=@examples/FOGRA39L.ti3 {request.base_url}v1/gamuts"
    links = "".join(f"<li>{link(address, text)}</li>\n" for address, text in _LINKS.items())
    return page(
        "Gamut boundary service",
        f'{_INTRODUCTION}<pre tabindex="0"><code>{escape(example)}</code></pre>\n'
        f"<h2>State</h2>\n{_state(service, report)}\n<h2>Links</h2>\n<ul>\n{links}</ul>",
        headers=_NO_STORE,
    )


@router.get("/problems")
async def problem_list(request: Request) -> Response:
    """List all kinds of problems."""
    kinds = sorted(KINDS.values(), key=lambda kind: (kind.status, kind.code))
    if _wants_json(request):
        document = {"problems": [_kind_document(kind) for kind in kinds]}
        answer = JsonResponse(document, headers=_json_headers(_NO_CACHE))
        return conditional(answer, request.headers)
    rows = [
        (
            link(f"/problems/{kind.code}", kind.code),
            str(kind.status),
            escape(kind.title),
        )
        for kind in kinds
    ]
    shown = page(
        "Problems",
        "<p>Every error is a document of the type <code>application/problem+json</code> "
        "(RFC 9457) with one of these codes. The meaning of a code never changes. "
        "<code>detail</code> describes the fault, <code>where</code> names the place, and "
        "<code>remedy</code> the correction.</p>\n"
        + table("Codes, by HTTP status", ("code", "status", "problem"), rows),
        headers=_NO_CACHE,
    )
    return conditional(shown, request.headers)


@router.get("/problems/{code}")
async def problem_page(request: Request, code: Annotated[str, Path()]) -> Response:
    """Explain a kind of problem."""
    kind = KINDS.get(code)
    if kind is None:
        detail = f"There is no problem named {code[:80]}."
        raise ProblemError(Problem("not-found", detail, remedy="/problems lists all codes."))
    if _wants_json(request):
        answer = JsonResponse(_kind_document(kind), headers=_json_headers(_NO_CACHE))
        return conditional(answer, request.headers)
    example = json.dumps(_example(kind), indent=2, ensure_ascii=False)
    shown = page(
        kind.title,
        definitions(
            (
                ("code", f"<code>{kind.code}</code>"),
                ("HTTP status", str(kind.status)),
                ("remedy", escape(kind.remedy)),
            )
        )
        + f'\n<h2>Example</h2>\n<pre tabindex="0"><code>{escape(example)}</code></pre>\n'
        f"<p>{link('/problems', 'All problems')}</p>",
        headers=_NO_CACHE,
    )
    return conditional(shown, request.headers)


def _wants_json(request: Request) -> bool:
    accept = ",".join(request.headers.getlist("accept"))
    return preferred_media_type(accept, ("text/html", "application/json")) == "application/json"


def _json_headers(headers: dict[str, str]) -> dict[str, str]:
    return {**headers, "Vary": "Accept"}


def _status_document(service: ServiceContainer, report: Report) -> dict[str, Any]:
    return {
        "service": "Gamut boundary service",
        "version": __version__,
        "algorithm_version": ALGORITHM_VERSION,
        "state": readiness(service, report).model_dump(),
        "links": {address.rpartition("/")[2]: address for address in _LINKS},
    }


def _state(service: ServiceContainer, report: Report) -> str:
    facts = service.builds.facts()
    word, kind = ("ready", "ok") if report.ready else ("not ready", "failed")
    overview = definitions(
        (
            ("service", f'<span class="{kind}">{word}</span>, version {__version__}'),
            ("workers", f"{facts.warm_workers} of {facts.workers} warm"),
            (
                "builds",
                f"{facts.running} running, {facts.queued} waiting, {facts.completed} completed",
            ),
        )
    )
    rows = [
        (
            escape(probe.name),
            f'<span class="{probe.status}">{probe.status}</span>',
            escape(probe.detail),
        )
        for probe in report.probes
    ]
    return f"{overview}\n{table('Probes', ('part', 'state', 'detail'), rows)}"


def _example(kind: Kind) -> dict[str, Any]:
    return Problem(kind.code, kind.detail, kind.where).document()


def _kind_document(kind: Kind) -> dict[str, Any]:
    return {
        "type": f"/problems/{kind.code}",
        "code": kind.code,
        "status": kind.status,
        "title": kind.title,
        "remedy": kind.remedy,
        "example": _example(kind),
    }


# --- layout --------------------------------------------------------------------------------------


def page(title: str, content: str, *, headers: Mapping[str, str] | None = None) -> HTMLResponse:
    """Return the response of a page with a plain title and HTML content.

    `headers` are further header fields.
    """
    name = "Gamut boundary service"
    whole_title = title if title == name else f"{title} – {name}"
    return HTMLResponse(
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width,initial-scale=1">\n'
        f"<title>{escape(whole_title)}</title>\n<style>{_STYLE}</style>\n</head>\n<body>\n"
        f"<header><nav>{link('/', 'Gamut viewer')}</nav><h1>{escape(title)}</h1></header>\n"
        f"<main>\n{content}\n</main>\n"
        f"<footer>{link('/status', 'Service')} · {link('/docs', 'API')} · "
        f"{link('/problems', 'Problems')} · {link('/metrics', 'Figures')}</footer>\n"
        "</body>\n</html>\n",
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
