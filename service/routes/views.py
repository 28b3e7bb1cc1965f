"""Routes of what there is to see of gamuts: questions about their shape, pictures, pages.

The answers are immutable, except the page, which has the name of the gamut.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any

from fastapi import APIRouter, Depends, Query, Request
from fastapi.responses import Response

from gamutcore.export.viewer_page import MEDIA_TYPE, MOST_GAMUTS, PageGamut, viewer_page
from gamutcore.questions import (
    COMPARISON,
    MOST_DRAWN_TRIANGLES,
    PICTURE,
    QUESTIONS,
    Question,
    check_space,
)
from service.access.rate_limits import client_of
from service.admission import Work, needed_bytes
from service.container import service_of
from service.http.representations import (
    IMMUTABLE,
    OCTET_STREAM,
    check_if_match,
    compress_response,
    conditional,
    content_disposition,
    preferred_media_type,
)
from service.http.requests import GAMUT_ID, GAMUT_IDS, GAMUT_PATTERN, invalid_parameter
from service.library import EncodedResponse, PictureOptions
from service.openapi.documentation import (
    EXAMPLE_ID,
    MESH_HEADERS,
    binary_content,
    header,
    problems,
)
from service.problems.problem import Problem, ProblemError
from service.questions.answers import condition_headers
from service.questions.colour_bodies import FORMS, JSON, NPY
from service.questions.parameter_models import Parameters, parameter_model, query_of
from service.questions.question_schemas import view_response
from service.questions.runner import answer_bytes
from service.routes.dependencies import (
    GamutId,
    GamutRoute,
    NamedGamuts,
    check_gamut_query,
    checked_gamut,
    level_request,
)
from service.routes.names import named
from service.routes.questions import wait_for_kernels, wanted_levels

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from service.library import OpenGamut

__all__ = ["NOT_MODIFIED", "named_gamut", "routers"]

_PROBLEMS = (
    "not-acceptable",
    "invalid-option",
    "triangle-count",
    "invalid-parameter",
    "precondition-failed",
    "gamut-not-found",
    "gamut-rebuilding",
    "queries-busy",
    "memory-busy",
    "memory-exceeded",
    "not-ready",
    "store-unavailable",
)

NOT_MODIFIED = {"description": "The client has the current content (If-None-Match)."}

_COMPARED = 0.1
"""Comparing gamuts, per triangle of both levels, also with colours lost, in indexes of them."""

_PAGE, _PAGE_SHARE = 0.4, 0.1
"""Encoding the history of a page, per triangle of the largest full boundary, because one follows
the other. And writing the page, per triangle of all, with copies in Base64. In indexes."""

_CHECKS = [Depends(check_gamut_query)]

router = APIRouter(
    prefix="/v1/gamuts", tags=["queries"], route_class=GamutRoute, dependencies=_CHECKS
)

comparisons = APIRouter(
    prefix="/v1/comparisons", tags=["queries"], route_class=GamutRoute, dependencies=_CHECKS
)

pictures = APIRouter(
    prefix="/v1/gamuts", tags=["meshes"], route_class=GamutRoute, dependencies=_CHECKS
)

pages = APIRouter(
    prefix="/v1/gamuts", tags=["gamuts"], route_class=GamutRoute, dependencies=_CHECKS
)

routers = (router, comparisons, pictures, pages)


def _add_route(question: Question) -> None:
    query = Depends(query_of(parameter_model(f"{question.name}_query", question.all_parameters)))

    async def endpoint(
        request: Request, gamut_id: GamutId, parameters: Parameters = query
    ) -> Response:
        values, media_type = dict(parameters), _accepted_form(request)
        return await _answer(request, question, [gamut_id], values, media_type)

    router.add_api_route(
        f"/{{gamut_id}}/{question.name}",
        endpoint,
        methods=["GET"],
        operation_id=question.operation_id,
        summary=question.summary,
        description=question.description,
        response_class=Response,
        responses={
            200: view_response(question),
            304: NOT_MODIFIED,
            **problems(
                *_PROBLEMS, *(("no-device-model", "invalid-points") if question.needs_model else ())
            ),
        },
    )


for _question in QUESTIONS.values():
    if _question.answer_schema and _question is not COMPARISON:
        _add_route(_question)


def named_gamut(which: str) -> Any:  # noqa: ANN401 - as of FastAPI
    """Return the query parameter that names one of two gamuts."""
    return Query(
        description=f"Id of the gamut {which}, or slug of a reference gamut.",
        pattern=f"^{GAMUT_PATTERN}$",
        examples=[EXAMPLE_ID],
    )


_comparison_query = query_of(parameter_model("comparison_query", COMPARISON.all_parameters))
_picture_query = query_of(parameter_model("picture_query", PICTURE.parameters))


@comparisons.get(
    "",
    operation_id=COMPARISON.operation_id,
    summary=COMPARISON.summary,
    description=COMPARISON.description,
    response_class=Response,
    responses={200: view_response(COMPARISON), 304: NOT_MODIFIED, **problems(*_PROBLEMS)},
)
async def compare_gamuts(
    request: Request,
    a: Annotated[str, named_gamut("A"), GAMUT_ID],
    b: Annotated[str, named_gamut("B"), GAMUT_ID],
    parameters: Annotated[Parameters, Depends(_comparison_query)],
) -> Response:
    """Compare two gamuts."""
    ids = [await NamedGamuts.of(request).id_of(name) for name in (a, b)]
    values, media_type = dict(parameters), _accepted_form(request)
    return await _answer(request, COMPARISON, ids, values, media_type)


@pictures.get(
    "/{gamut_id}/picture.png",
    operation_id=PICTURE.operation_id,
    summary=PICTURE.summary,
    description=PICTURE.description,
    response_class=Response,
    responses={
        200: {
            "description": "The picture.",
            "headers": {
                name: MESH_HEADERS[name]
                for name in MESH_HEADERS
                if not name.startswith("Gamut-Max")
            },
            "content": binary_content({"image/png": "A picture as PNG"}),
        },
        304: NOT_MODIFIED,
        **problems(
            "invalid-option",
            "triangle-count",
            "invalid-parameter",
            "precondition-failed",
            "gamut-not-found",
            "gamut-rebuilding",
            "queries-busy",
            "not-ready",
            "memory-busy",
            "memory-exceeded",
            "store-unavailable",
        ),
    },
)
async def draw_gamut(
    request: Request,
    gamut_id: GamutId,
    parameters: Annotated[Parameters, Depends(_picture_query)],
) -> Response:
    """Draw a level."""
    values = dict(parameters)
    level = level_request(values.pop("triangles"), values.pop("max_error"))
    options = PictureOptions(**values)
    service = service_of(request)
    await wait_for_kernels(service)
    picture = await service.library.picture(
        gamut_id, level, options, MOST_DRAWN_TRIANGLES, client_of(request.scope)
    )
    check_if_match(request.headers.getlist("if-match"), picture.etag)
    known = request.headers.getlist("if-none-match")
    return EncodedResponse(picture, ",".join(known) or None)


@pages.get(
    "/{gamut_id}/viewer.html",
    operation_id="downloadPage",
    summary="Download a page that shows the gamut",
    description="One HTML file with the viewer and the history, and those of other gamuts `with` "
    "it. It opens from disk in any current browser, without a network, and shows every level. The "
    "file has the names of the gamuts.",
    response_class=Response,
    responses={
        200: {
            "description": "The page.",
            "content": {
                MEDIA_TYPE: {
                    "schema": {"type": "string"},
                    "examples": {"page": {"summary": "A page", "value": "<!doctype html>..."}},
                }
            },
            "headers": {
                "Content-Disposition": header(
                    "File name: the name of the gamut.",
                    'attachment; filename="FOGRA39L.html"',
                )
            },
        },
        304: NOT_MODIFIED,
        **problems(
            "gamut-not-found",
            "gamut-rebuilding",
            "precondition-failed",
            "invalid-option",
            "invalid-parameter",
            "queries-busy",
            "memory-busy",
            "memory-exceeded",
            "store-unavailable",
        ),
    },
)
async def download_page(
    request: Request,
    gamut_id: GamutId,
    others: Annotated[
        str | None,
        Query(
            alias="with",
            description="Ids of gamuts, or slugs of reference gamuts, separated by commas: "
            f"{MOST_GAMUTS - 1} at most, in the same space. The page has them as well.",
            pattern=f"^{GAMUT_PATTERN}(,{GAMUT_PATTERN})*$",
            max_length=65 * MOST_GAMUTS,
            examples=["srgb"],
        ),
        GAMUT_IDS,
    ] = None,
) -> Response:
    """Download a page that shows the gamut."""
    service = service_of(request)
    library = service.library
    names = [] if others is None else others.split(",")
    if len(names) >= MOST_GAMUTS:
        fault = f"There are {len(names)} gamuts beside the first."
        raise invalid_parameter(fault, "query", "with", f"Give at most {MOST_GAMUTS - 1}.")
    other_ids = [await NamedGamuts.of(request).id_of(name) for name in names]
    records = [await library.record(each) for each in dict.fromkeys([gamut_id, *other_ids])]
    full = {record.id: record.description["counts"]["triangles"] for record in records}
    page_triangles = _PAGE * max(full.values()) + _PAGE_SHARE * sum(full.values())

    def need() -> int:
        unpacked = sum(library.unpacked(each, full[each.id]) for each in records)
        return needed_bytes(unpacked=unpacked, prepared=page_triangles)

    accepted = request.headers.getlist("accept-encoding")

    def answer() -> Response:
        shown = [
            PageGamut(each.name, gamut.gamut.description, gamut.gamut.to_bytes())
            for each, gamut in zip(named(service.store, records), opened, strict=True)
        ]
        # The name may change, so the answer is not immutable. A browser never shows it as a page of
        # the service.
        file_name = " and ".join(each.name for each in shown)
        headers = {
            "Cache-Control": "no-cache",
            "Content-Disposition": content_disposition("attachment", file_name, ".html"),
            "X-Content-Type-Options": "nosniff",
        }
        return compress_response(Response(viewer_page(shown), 200, headers, MEDIA_TYPE), accepted)

    opened: list[OpenGamut] = []
    client = client_of(request.scope)
    with await service.admission.place(Work.VIEW, client, need, need()):
        for record in records:
            gamut = await library.open(record.id)
            opened.append(gamut)
            check_space(opened[0].gamut, gamut.gamut)
            await library.unpack(gamut, full[record.id])
            library.keep(gamut)
        page = conditional(await library.in_thread(answer), request.headers)
        opened.clear()
        return service.admission.hold_response(page, client)


async def _answer(
    request: Request,
    question: Question,
    ids: Sequence[str],
    values: dict[str, Any],
    media_type: str,
) -> Response:
    service = service_of(request)
    if values.get("reference") is not None:
        ids = [*ids, await checked_gamut(request, values["reference"], "query", "reference")]
    await wait_for_kernels(service)
    library, client = service.library, client_of(request.scope)
    wanted = await wanted_levels(service, ids, values, client)
    compared = _COMPARED * library.largest_counts(wanted)
    answer_need = needed_bytes(prepared=compared) + answer_bytes(_cells(values), JSON)

    def need() -> int:
        models = library.model_need(wanted[0][0]) if question.needs_model else 0
        return models + library.need(wanted) + answer_need

    work = Work.HEAVY if question.needs_model else Work.VIEW
    in_use = []  # until the level keeps it
    with await service.admission.place(work, client, need, need()):
        if question.needs_model:
            in_use.append(await library.load_device_model(ids[0]))
        levels = await library.levels(wanted)
        body = await service.questions.shape(question, levels, values, media_type)
        headers = {
            "Cache-Control": IMMUTABLE,
            "Vary": "Accept",
            "X-Content-Type-Options": "nosniff",
            "Gamut-Triangles": ", ".join(str(level.triangles) for level in levels),
            "Gamut-Max-Error": ", ".join(f"{level.max_error:g}" for level in levels),
            **condition_headers(levels, question.warnings([level.gamut for level in levels], None)),
        }
        answer = Response(body, 200, headers, media_type)
        accepted = request.headers.getlist("accept-encoding")
        answer = await library.in_thread(compress_response, answer, accepted)
        return service.admission.hold_response(conditional(answer, request.headers), client)


def _cells(values: Mapping[str, Any]) -> int:
    """Return the number of cells of an answer by the parameters that multiply them."""
    counts = [values.get(name, 1) for name in ("hues", "lightness", "sectors")]
    return math.prod(count for count in counts if isinstance(count, int))


def _accepted_form(request: Request) -> str:
    accept = ",".join(request.headers.getlist("accept"))
    media_type = preferred_media_type(accept, [*FORMS, OCTET_STREAM])
    if media_type is None:
        detail = f"The answer is not available as {accept[:200]}."
        where = {"header": "Accept", "available": list(FORMS)}
        raise ProblemError(Problem("not-acceptable", detail, where))
    return NPY if media_type == OCTET_STREAM else media_type
