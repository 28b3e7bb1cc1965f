"""Routes of HTML pages: the landing page and one page per kind of problem.

All are also available as JSON, by ``Accept``.
"""

import json
from html import escape
from typing import Annotated, Any

from fastapi import APIRouter, Path, Request
from fastapi.responses import Response

from gamutcore.version import ALGORITHM_VERSION, __version__
from service.container import ServiceContainer, service_of
from service.http.conditional import conditional
from service.http.negotiation import preferred_media_type
from service.problems.kinds import KINDS, Kind
from service.problems.problem import JsonResponse, Problem, ProblemError
from service.readiness import Report
from service.routes.html_pages import definitions, link, page, table
from service.routes.state import readiness

__all__ = ["router"]

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
    "/docs": "All operations, interactive",
    "/openapi.json": "OpenAPI document",
    "/v1/gamuts": "Stored gamuts",
    "/v1/references": "Reference gamuts",
    "/problems": "Kinds of problems",
    "/metrics": "Metrics for Prometheus",
    "/readyz": "Readiness",
    "/livez": "Liveness",
}


@router.get("/")
async def landing(request: Request) -> Response:
    """Show the service, its state and its links."""
    service = service_of(request)
    report = await service.readiness.report()
    if _wants_json(request):
        return JsonResponse(_landing_document(service, report), headers=_json_headers(_NO_STORE))
    example = f"curl -F file=@examples/FOGRA39L.ti3 {request.base_url}v1/gamuts"
    links = "".join(f"<li>{link(address, text)}</li>\n" for address, text in _LINKS.items())
    return page(
        "Gamut boundary service",
        f'{_INTRODUCTION}<pre tabindex="0"><code>{escape(example)}</code></pre>\n'
        f"<h2>State</h2>\n{_state(service, report)}\n<h2>Links</h2>\n<ul>\n{links}</ul>",
        home=False,
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


def _landing_document(service: ServiceContainer, report: Report) -> dict[str, Any]:
    return {
        "service": "Gamut boundary service",
        "version": __version__,
        "algorithm_version": ALGORITHM_VERSION,
        "state": readiness(service, report),
        "links": {address.strip("/").rpartition("/")[2]: address for address in _LINKS},
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
