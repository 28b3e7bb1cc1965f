"""Pages for people: the landing page, and one page per kind of problem."""

from html import escape
from typing import Annotated

from fastapi import APIRouter, Path, Request
from fastapi.responses import HTMLResponse, Response

from gamutcore.version import __version__
from service.problems import KINDS, Kind, Problem, ProblemError
from service.state import service_of

__all__ = ["router"]

router = APIRouter(include_in_schema=False)

_STYLE = (
    "body{font:16px/1.5 system-ui,sans-serif;max-width:46rem;margin:3rem auto;padding:0 1rem}"
    "code,pre{background:#f2f2f2;padding:.1em .3em}pre{padding:1em;overflow:auto}"
    "th,td{text-align:left;padding:.2em 1em .2em 0;vertical-align:top}"
)


def _page(title: str, content: str) -> Response:
    return HTMLResponse(
        f'<!doctype html><html lang="en"><meta charset="utf-8"><title>{escape(title)}</title>'
        f"<style>{_STYLE}</style><h1>{escape(title)}</h1>{content}</html>",
        headers={"Cache-Control": "no-cache"},
    )


@router.get("/")
async def landing(request: Request) -> Response:
    """Show what the service is, its state, and where to go."""
    service = service_of(request)
    builds = service.builds.facts()
    state = "ready" if service.ready else "warming up"
    return _page(
        "Gamut boundary service",
        "<p>Send the measurements or the ICC profile of a display, a press or any other device; "
        "get the surface of its gamut, with as many triangles as you ask for.</p>"
        "<pre>curl -F file=@examples/FOGRA39L.ti3 "
        f"{escape(str(request.base_url))}v1/gamuts</pre>"
        '<ul><li><a href="/docs">Documentation of all operations</a>, '
        'as <a href="/openapi.json">OpenAPI</a></li>'
        '<li><a href="/v1/gamuts">The gamuts that are here</a></li>'
        '<li><a href="/problems">The problems that can be reported</a></li></ul>'
        f"<p>Version {__version__}, {state}: {builds.running} builds running, "
        f"{builds.queued} waiting, {builds.completed} completed. "
        '<a href="/livez">livez</a>, <a href="/readyz">readyz</a></p>',
    )


@router.get("/problems")
async def problem_list() -> Response:
    """List all kinds of problems."""
    rows = "".join(
        f'<tr><td>{kind.status}</td><td><a href="/problems/{kind.code}">{kind.code}</a></td>'
        f"<td>{escape(kind.title)}</td></tr>"
        for kind in sorted(KINDS.values(), key=lambda kind: (kind.status, kind.code))
    )
    return _page(
        "Problems",
        "<p>Every error is a document of the type <code>application/problem+json</code> (RFC 9457) "
        "with one of these stable codes.</p>"
        f"<table><tr><th>status</th><th>code</th><th>what is wrong</th></tr>{rows}</table>",
    )


@router.get("/problems/{code}")
async def problem_page(code: Annotated[str, Path()]) -> Response:
    """Explain a kind of problem."""
    kind = KINDS.get(code)
    if kind is None:
        detail = f"There is no problem named {code[:80]}."
        raise ProblemError(Problem("not-found", detail, remedy="They are listed at /problems."))
    return _page(kind.title, _explanation(kind))


def _explanation(kind: Kind) -> str:
    where = ", ".join(f"{name}: {value}" for name, value in kind.where.items())
    return (
        f"<p><code>{kind.code}</code>, HTTP status {kind.status}</p>"
        f"<p><b>What to do.</b> {escape(kind.remedy)}</p>"
        f"<p><b>For example.</b> {escape(kind.detail)}"
        f"{f' ({escape(where)})' if where else ''}</p>"
        '<p><a href="/problems">All problems</a></p>'
    )
