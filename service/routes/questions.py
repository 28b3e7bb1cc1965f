"""Routes of queries that are posted, one for each question about colours.

FastAPI documents these routes, and the endpoint reads the request itself: FastAPI's own reading of
parameters would take longer than the answer to a single colour.
"""

from __future__ import annotations

import contextlib
import re
from collections.abc import AsyncGenerator, Callable, Coroutine, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from fastapi import APIRouter, Depends, Request
from fastapi.responses import Response
from fastapi.routing import APIRoute

from gamutcore.colours.spaces import ColourConversion
from gamutcore.questions import QUESTIONS, Question
from service.access.rate_limits import client_of
from service.admission import FREE_BYTES, ROW_BYTES
from service.container import ServiceContainer, service_of
from service.http.representations import OCTET_STREAM, preferred_media_type
from service.http.request_context import timed
from service.http.requests import invalid_parameter
from service.openapi.documentation import problems
from service.problems.problem import Problem, ProblemError
from service.questions.answers import condition_headers, reading_header
from service.questions.colour_bodies import CSV, FORMS, JSON, NPY, TABLE_PARAMETERS, TABLES
from service.questions.parameter_models import parameter_model, query_of
from service.questions.question_schemas import query_response, request_body, stated_header
from service.questions.runner import Query, answer_bytes, is_inline, level_values, work_of
from service.routes.dependencies import (
    GamutId,
    NamedGamuts,
    as_alias,
    check_request,
    checked_gamut,
    level_request,
)
from service.routes.mapped_pictures import (
    answer_picture,
    document_pictures,
    is_picture,
    with_picture_parameters,
)

if TYPE_CHECKING:
    from starlette.types import Receive, Scope, Send

    from gamutcore.colours.spaces import ColourSpace
    from gamutcore.levels import LevelRequest
    from service.admission import Holding
    from service.http.bodies import Body
    from service.questions.colour_bodies import QuestionBody
    from service.questions.parameter_models import Parameters
    from service.storage.published import PublishedGamut

__all__ = [
    "POST_PROBLEMS",
    "READING_POSTS",
    "QueryRoute",
    "check_table_parameters",
    "router",
    "sent_form",
    "wait_for_kernels",
    "wanted_levels",
]

MAP = QUESTIONS["map"]
_POSTED = {question.name: question for question in QUESTIONS.values() if question.inputs}

READING_POSTS = re.compile(rf"/v1/(?:matches|gamuts/[^/]+/(?:{'|'.join(_POSTED)}))\Z")
"""Paths of questions that are POST, because they have a body, and change nothing."""

POST_PROBLEMS = (
    "malformed-body",
    "request-timeout",
    "body-too-large",
    "unsupported-media-type",
    "not-acceptable",
    "invalid-body",
    "invalid-points",
    "too-many-rows",
    "triangle-count",
    "invalid-parameter",
    "gamut-not-found",
    "gamut-rebuilding",
    "queries-busy",
    "overloaded",
    "scratch-full",
    "memory-busy",
    "memory-exceeded",
    "not-ready",
    "store-unavailable",
)


_PICTURE_PROBLEMS = (
    "shutting-down",
    "malformed-file",
    "malformed-profile",
    "unsupported-profile",
    "picture-too-large",
    "picture-too-complex",
    "unsupported-picture",
)


class QueryRoute(APIRoute):
    """A route whose endpoint validates the parameters itself; its dependencies document them.

    FastAPI's dependencies take 0.2 ms, which is a quarter of the answer to one colour.
    """

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        """Return the endpoint with the id of the path."""

        async def handle(request: Request) -> Response:
            await check_request(request)
            name = request.path_params["gamut_id"]
            gamut_id = await checked_gamut(request, name, "path", "gamut_id")
            return as_alias(request, await self.endpoint(request, gamut_id))

        return handle


router = APIRouter(prefix="/v1/gamuts", tags=["queries"], route_class=QueryRoute)


def _add_route(question: Question) -> None:
    async def endpoint(request: Request, gamut_id: GamutId) -> Response:
        if question is MAP and is_picture(request):
            await wait_for_kernels(service_of(request))
            return await answer_picture(request, gamut_id)
        return await _answer(request, gamut_id, question, model)

    body, answer = request_body(question), query_response(question)
    table = () if question.of_device else TABLE_PARAMETERS
    parameters = (*question.all_parameters, *table)
    model = parameter_model(f"{question.name}_query", parameters)
    if question is MAP:
        document_pictures(body, answer)
        parameters = with_picture_parameters(parameters)
    endpoint.__doc__ = question.description
    router.add_api_route(
        f"/{{gamut_id}}/{question.name}",
        endpoint,
        methods=["POST"],
        operation_id=question.operation_id,
        summary=question.summary,
        description=question.description,
        response_class=Response,
        responses={
            200: answer,
            **problems(
                *POST_PROBLEMS,
                *(("no-device-model",) if question.needs_model or question is MAP else ()),
                *(_PICTURE_PROBLEMS if question is MAP else ()),
            ),
        },
        dependencies=[Depends(query_of(parameter_model(f"{question.name}_query", parameters)))],
        openapi_extra={"requestBody": body},
    )


for _question in _POSTED.values():
    _add_route(_question)


class _Answer(Response):
    """An answer in several pieces, which are computed while it is sent.

    `holding` counts the bytes of the pieces and of the table until then.
    """

    def __init__(
        self,
        first: bytes,
        others: AsyncGenerator[bytes, None],
        request: Request,
        holding: Holding,
        headers: dict[str, str],
        media_type: str,
    ) -> None:
        super().__init__(None, 200, headers, media_type)
        del self.headers["content-length"]
        self._first, self._others = first, others
        self._request, self._holding = request, holding

    async def __call__(self, _scope: Scope, _receive: Receive, send: Send) -> None:
        try:
            start = {"type": "http.response.start", "status": 200, "headers": self.raw_headers}
            await send(start)
            await send({"type": "http.response.body", "body": self._first, "more_body": True})
            async with contextlib.aclosing(self._others) as others:
                async for piece in others:
                    if await self._request.is_disconnected():
                        return
                    await send({"type": "http.response.body", "body": piece, "more_body": True})
            await send({"type": "http.response.body", "body": b""})
        finally:
            self._holding.resize(0)


async def _answer(
    request: Request, gamut_id: str, question: Question, model: type[Parameters]
) -> Response:
    service = service_of(request)
    gamuts = NamedGamuts.of(request)
    query = model.of_query(gamuts.items, gamuts.options)
    sent = sent_form(request, (JSON, NPY) if question.of_device else (*FORMS, *TABLES))
    check_table_parameters(query, sent)
    accepted = _accepted_form(request, sent)
    form, client = FORMS[sent], client_of(request.scope)
    with service.bodies.body(request, client) as arriving:
        with timed("body"):
            await arriving.receive(form.most_bytes)
        await wait_for_kernels(service)
        opened = await service.library.gamut(gamut_id, client)
        if question.needs_model and not opened.gamut.is_of_device:
            raise opened.gamut.no_device_model()
        width = len(opened.gamut.channels) if question.of_device else 3
        posted = _QuestionRequest(
            request, question, arriving, sent, accepted, opened.space, width, dict(query)
        )
        # JSON names the level, so it is parsed before the memory for the level is known.
        body = await posted.parse() if sent == JSON else None
        values = query.with_members({} if body is None else body.members)
        if values.get("metric") == "CIE 2000":
            await wait_for_kernels(service, "ciede2000")
        ids = [gamut_id]
        if values.get("source") is not None:
            place = "body" if body is not None and "source" in body.members else "query"
            ids.append(await checked_gamut(request, values["source"], place, "source"))
        wanted = await wanted_levels(service, ids, values, client)
        record = opened.record
        del opened  # it may go while the question waits for memory
        rows = posted.most_rows if body is None else body.rows
        answer = posted.text_bytes + answer_bytes(rows, accepted, ahead=service.questions.ahead)

        def need() -> int:
            model = service.library.model_need(record) if question.needs_model else 0
            return model + service.library.need(wanted) + answer

        if body is not None and is_inline(rows, None) and need() <= FREE_BYTES:
            return await _answer_rows(posted, wanted, body, values)
        effort = need() + ROW_BYTES * rows
        in_use = []  # until the level keeps it
        with await service.admission.place(work_of(rows), client, need, effort):
            if question.needs_model:
                in_use.append(await service.library.load_device_model(gamut_id))
            if body is None:
                body = await posted.parse()
            return await _answer_rows(posted, wanted, body, values)


class _QuestionRequest(NamedTuple):
    """A question whose body has arrived."""

    request: Request
    question: Question
    arriving: Body
    sent: str
    accepted: str
    space: ColourSpace
    width: int
    query: Mapping[str, Any]

    @property
    def most_rows(self) -> int:
        """Upper bound of the number of rows."""
        form = FORMS[self.sent]
        return min(self.arriving.size // form.row_bytes + 1, form.most_rows)

    @property
    def text_bytes(self) -> int:
        """Memory of a table's text, which stays for the answer."""
        return 0 if self.sent == JSON else 2 * self.arriving.size

    async def parse(self) -> QuestionBody:
        """Return the content of the body."""
        runner = service_of(self.request).questions
        body = await runner.parse(
            self.arriving, self.sent, self.question, self.space, self.width, self.query
        )
        self.arriving.close()
        return body

    def hold_pieces(self, body: QuestionBody) -> Holding:
        """Count the memory of an answer in pieces until it is sent."""
        service = service_of(self.request)
        ahead = 1 if body.table is not None else service.questions.ahead
        nbytes = self.text_bytes + answer_bytes(body.rows, self.accepted, ahead=ahead)
        return service.admission.hold("answers", nbytes, client_of(self.request.scope))


async def _answer_rows(
    posted: _QuestionRequest,
    wanted: Sequence[tuple[PublishedGamut, LevelRequest]],
    body: QuestionBody,
    values: dict[str, Any],
) -> Response:
    """Return the answer for the rows of a body."""
    service, question = service_of(posted.request), posted.question
    client = client_of(posted.request.scope)
    if body.table is not None and (values["space"] or posted.space.name) != body.table.space:
        values["space"] = body.table.space
    body = body._replace(axes=ColourConversion(values["space"], posted.space).axes)
    levels = await service.library.levels(wanted)
    values = level_values(levels, values)
    level, gamuts = levels[0], [each.gamut for each in levels]
    warnings = question.warnings(gamuts, values["space"])
    echoed = question.echoed(level.gamut, values)
    query = Query(question, levels, body, values, posted.accepted, warnings)
    first, others = await service.questions.answer(query, client)
    headers = {
        "Cache-Control": "no-store",
        "Vary": "Accept",
        "Gamut-Triangles": str(level.triangles),
        "Gamut-Max-Error": f"{level.max_error:g}",
        **{
            stated_header(name): value if isinstance(value, str) else f"{value:g}"
            for name, value in echoed.items()
        },
        **condition_headers([level], warnings),
        **reading_header(body.table),
    }
    if others is None:
        response = Response(first, 200, headers, posted.accepted)
        return service.admission.hold_response(response, client)
    holding = posted.hold_pieces(body)
    return _Answer(first, others, posted.request, holding, headers, posted.accepted)


async def wanted_levels(
    service: ServiceContainer, ids: Sequence[str], values: Mapping[str, Any], client: str
) -> list[tuple[PublishedGamut, LevelRequest]]:
    """Return the levels that the parameters of a query ask for, as `Library.levels` takes them."""
    request, wanted = level_request(values.get("triangles"), values.get("max_error")), []
    for gamut_id in ids:
        opened = await service.library.gamut(gamut_id, client)
        level = request.or_default(max_error=opened.gamut.default_error)
        wanted.append((opened.record, level))
    return wanted


async def wait_for_kernels(service: ServiceContainer, group: str = "optional") -> None:
    """Wait for the kernels of queries, which compile in the background or when they are wanted."""
    if not await service.kernels.wait(group, service.settings.client_wait):
        detail = "The kernels of the queries are being compiled."
        raise ProblemError(Problem("not-ready", detail, headers={"Retry-After": "10"}))


def sent_form(request: Request, accepted: Iterable[str]) -> str:
    """Return the form of a body, of `FORMS`; refuse media types that are not `accepted`."""
    coding = request.headers.get("content-encoding", "").strip().lower()
    if coding not in {"", "identity"}:
        detail = f"The body has the content coding {coding[:40]!r}."
        where = {"header": "Content-Encoding"}
        remedy = "Send the body without a content coding."
        headers = {"Accept-Encoding": "identity"}  # RFC 9110, 12.5.3
        raise ProblemError(Problem("unsupported-media-type", detail, where, remedy, headers))
    media_type = request.headers.get("content-type", "").partition(";")[0].strip().lower()
    if media_type not in accepted:
        detail = f"The media type of the body is {media_type[:100] or 'not given'}."
        available = sorted(set(accepted))
        named = {"header": "Content-Type", "available": available}
        remedy = f"Send {', '.join(available)}."
        raise ProblemError(Problem("unsupported-media-type", detail, named, remedy))
    return CSV if media_type in TABLES else media_type


def check_table_parameters(query: Parameters, sent: str) -> None:
    """Refuse the parameters of tables for a body of another form."""
    for name in (parameter.name for parameter in TABLE_PARAMETERS):
        if name in query.model_fields_set and sent != CSV:
            fault = f"{name} is given for a body that is {sent}."
            raise invalid_parameter(fault, "query", name, f"Give {name} for tables only.")


def _accepted_form(request: Request, sent: str) -> str:
    """Return the form of the answer, which is that of the body unless `Accept` prefers another."""
    accept = ",".join(request.headers.getlist("accept"))
    if accept in {"", "*/*", sent}:
        return sent
    offered = [sent, *(each for each in (*FORMS, OCTET_STREAM) if each != sent)]
    media_type = preferred_media_type(accept, offered)
    if media_type is None:
        detail = f"The answer is not available as {accept[:200]}."
        where = {"header": "Accept", "available": list(FORMS)}
        raise ProblemError(Problem("not-acceptable", detail, where))
    return NPY if media_type == OCTET_STREAM else media_type
