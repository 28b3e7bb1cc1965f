"""The route of matches: which of several gamuts print colours, and how near the others come.

One request has one place. Its gamuts are opened and asked one after the other, so that it holds the
memory of one level at a time, and a client that leaves ends the work at the next gamut.
"""

from __future__ import annotations

import asyncio
import contextlib
import re
import time
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

from fastapi import APIRouter, Depends, Request
from fastapi.responses import Response
from fastapi.routing import APIRoute
from pydantic_core import to_json
from starlette.requests import ClientDisconnect

from gamutcore.arguments import Array, Boolean, Number, Text
from gamutcore.colours.spaces import CIELAB
from gamutcore.errors import DeviceModelError, GamutError
from gamutcore.gamut import stored_level
from gamutcore.levels import LevelRequest
from gamutcore.questions import Parameter, Question, check_space
from gamutcore.references import REFERENCES, find_reference
from gamutcore.reports import (
    GamutMatch,
    MatchTerms,
    distinct_name,
    gathered_match,
    match_gamut,
    match_report,
)
from service.access.rate_limits import client_of
from service.admission import ROW_BYTES, Work
from service.container import ServiceContainer, service_of
from service.http.representations import preferred_media_type
from service.http.request_context import timed
from service.http.requests import ID_PATTERN, LONGEST_SHOWN, invalid_parameter
from service.openapi.documentation import EXAMPLE_ID, header, json_response, problems
from service.openapi.models import Match
from service.problems.problem import Problem, ProblemError
from service.questions.answers import LONGEST_LABEL, reading_header, warning_header
from service.questions.colour_bodies import CSV, FORMS, JSON, TABLE_PARAMETERS, TABLES
from service.questions.parameter_models import parameter_model, query_of
from service.questions.question_schemas import request_body
from service.routes.dependencies import NamedGamuts, check_request
from service.routes.names import find_named
from service.routes.questions import (
    POST_PROBLEMS,
    check_table_parameters,
    sent_form,
    wait_for_kernels,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine, Iterable, Mapping, Sequence

    from gamutcore.colours.spaces import ColourSpace
    from gamutcore.results import ColourMatch
    from service.library import QueryLevel
    from service.questions.colour_bodies import QuestionBody
    from service.storage.published import PublishedGamut

__all__ = ["router"]

MOST_GAMUTS = 200
"""Largest number of gamuts of a match."""

MOST_CELLS = 500_000
"""Largest number of colours times gamuts: 2,500 colours and 200 gamuts."""

_CELL_BYTES = 900
"""Memory of a colour and a gamut until the answer is written. CSV takes the most, with labels."""

_CELL_EFFORT = 50 * ROW_BYTES
"""Effort of a cell, most of which is CIE 2000, in bytes of work that takes as long."""

_SMALL_CELLS, _VIEW_CELLS = 1000, 50_000
"""Most cells of small work, and of views: a second or two of one core."""

_SHOWN_CANDIDATES = 20

_ID = re.compile(ID_PATTERN + r"\Z")

_LONGEST_WARNING = 400
"""Characters of a warning in a header field. That of many gamuts names many."""

_LIMIT = Annotated[float, Number(0.0, 1e6)]

_NAMES = Annotated[str, Text(20_000, "ids, slugs or names of gamuts, separated by commas")]

_LIST = Annotated[list[Annotated[str, Text(200, "a name")]], Array("a list of texts", 0)]

_GAMUTS: TypeAlias = _NAMES | _LIST

PARAMETERS = (
    Parameter(
        "gamuts",
        _GAMUTS,
        "Ids, slugs of reference gamuts, or names of gamuts, of which one stored gamut has this "
        "text in its name: a list in JSON, separated by commas in the query string. At most "
        f"{MOST_GAMUTS}, in the same space, and {MOST_CELLS:,} colours times gamuts.",
        example="srgb,display-p3",
    ),
    Parameter(
        "pass",
        _LIMIT,
        "Largest ΔE00 from the nearest colour of a gamut that counts as printed. By default, "
        "colours inside and at the edge count.",
        example=2,
    ),
    Parameter(
        "edge_width",
        _LIMIT,
        "Largest distance from the surface of a colour at the edge. Default: 1 in CIELAB, and the "
        "same share of the lightness of white in other spaces.",
        example=1.0,
    ),
    Parameter(
        "delta_e",
        Annotated[bool, Boolean()],
        "Whether to find ΔE00 of colours outside, which takes most of the time.",
        default=True,
    ),
    Parameter(
        "recipes",
        Annotated[bool, Boolean()],
        "Whether to find device values, which takes about a second for each gamut.",
        default=False,
    ),
    Parameter(
        "names",
        _LIST,
        "In JSON: names of the colours. By default, those of the table, or numbers from 1.",
        example=["Red", "Green"],
    ),
)

_MAX_ERROR = Parameter(
    "max_error",
    Annotated[float, Number(0.0, 1e12)],
    "Largest error of the levels that answer: the smallest level of the error curve within it. "
    "Default: 0.2 in CIELAB, and the same share of the lightness of white in other spaces. 0: the "
    "full boundary.",
    example=0.2,
)

MATCH = Question(
    name="matches",
    operation_id="matchColours",
    summary="Find which gamuts print colours",
    description="For each gamut and colour: position, distance and ΔE00 from the nearest colour. "
    "For each gamut: share, mean and 95th percentile of ΔE00, and the worst colours. For each "
    "colour: how many gamuts print it, and which comes nearest. And the two or three gamuts that "
    "print most together: exact for up to 20 gamuts. This is advice, and no routing of jobs.",
    parameters=PARAMETERS,
    function=match_gamut,
    inputs=("colours",),
    level=(_MAX_ERROR,),
    example={
        "gamuts": ["srgb", "Coated offset"],
        "colours": [[48, 68, 48], [55, 0, 0]],
        "names": ["Red", "Grey"],
        "pass": 2,
    },
)
"""The question of a match, for its body and its parameters."""

_CONDITIONS = {
    "intent": "relative",
    "ink_limit": None,
    "black_limit": None,
    "white": {"name": "D50", "xyz": [0.9642, 1.0, 0.8249]},
    "medium_white": None,
    "space": "CIELAB",
}

_EXAMPLE = {
    "space": "CIELAB",
    "tolerance": {"delta_e_2000": 2, "edge_width": 1.0},
    "colours": {
        "name": ["Red", "Grey"],
        "point": [[48, 68, 48], [55, 0, 0]],
        "printed_by": [0, 1],
        "best": ["Coated offset", "Coated offset"],
    },
    "gamuts": [
        {
            "id": EXAMPLE_ID,
            "name": "Coated offset",
            "share": 0.5,
            "mean_delta_e_2000": 1.45,
            "percentile_95_delta_e_2000": 2.755,
            "worst": ["Red"],
            "triangles": 1000,
            "conditions": _CONDITIONS,
            "prints": [False, True],
            "position": ["outside", "inside"],
            "distance": [6.1, -38.7],
            "delta_e_2000": [2.9, 0],
        }
    ],
    "together": [],
    "warnings": [],
}

_MODEL = parameter_model("matches_query", (*MATCH.all_parameters, *TABLE_PARAMETERS))


def _request_body() -> dict[str, Any]:
    """Return the description of the body, whose JSON names the gamuts."""
    body = request_body(MATCH)
    schema = body["content"][JSON]["schema"]
    schema["required"] = ["gamuts", *schema["required"]]
    return body


def _response() -> dict[str, Any]:
    """Return the description of the answer."""
    response = json_response(
        "The match.",
        Match,
        _EXAMPLE,
        {
            "Cache-Control": header("Answers to POST are not cached.", "no-store"),
            "Vary": header("Request fields that select the content.", "Accept"),
            "Gamut-Reading": header(
                "For tables: what was understood, as a string or display string (RFC 9651).",
                '"Columns L, a, b are read as CIELAB."',
            ),
            "Gamut-Warning": header(
                "Reasons why the answer may mislead, as a list of strings (RFC 9651).",
                '"The intents differ."',
            ),
        },
    )
    response["content"][CSV] = {
        "schema": {"type": "string"},
        "examples": {"table": {"summary": "A row for each colour and gamut"}},
    }
    return response


class _MatchRoute(APIRoute):
    """A route whose endpoint validates the parameters itself; its dependencies document them."""

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        """Return the endpoint."""

        async def handle(request: Request) -> Response:
            await check_request(request)
            answer: Response = await self.endpoint(request)
            return answer

        return handle


router = APIRouter(prefix="/v1/matches", tags=["queries"], route_class=_MatchRoute)


@router.post(
    "",
    operation_id=MATCH.operation_id,
    summary=MATCH.summary,
    description=MATCH.description,
    response_class=Response,
    responses={
        200: _response(),
        202: {"$ref": "#/components/responses/ReferenceJob"},
        **problems(*POST_PROBLEMS, "invalid-option"),
    },
    dependencies=[Depends(query_of(_MODEL))],
    openapi_extra={"requestBody": _request_body()},
)
async def match_colours(request: Request) -> Response:
    """Find which gamuts print colours."""
    service, client = service_of(request), client_of(request.scope)
    query = _MODEL.of_query(request.query_params.multi_items())
    sent, accepted = sent_form(request, (*FORMS, *TABLES)), _accepted_form(request)
    check_table_parameters(query, sent)
    with service.bodies.body(request, client) as arriving:
        with timed("body"):
            await arriving.receive(FORMS[sent].most_bytes)
        await wait_for_kernels(service)

        async def parse(space: ColourSpace = CIELAB) -> QuestionBody:
            body = await service.questions.parse(arriving, sent, MATCH, space, 3, dict(query))
            arriving.close()
            return body

        # JSON names the gamuts. Other forms are parsed when their memory is there.
        body = await parse() if sent == JSON else None
        place = "body" if body is not None and "gamuts" in body.members else "query"
        values = query.with_members({} if body is None else body.members)
        terms = MatchTerms(
            values["pass"], values["edge_width"], values["delta_e"], values["recipes"]
        ).checked()
        if terms.delta_e:
            await wait_for_kernels(service, "ciede2000")
        records = await _records(request, _texts(values["gamuts"]), place)
        wanted = [(record, _level(record, values["max_error"])) for record in records]
        space = (await service.library.gamut(records[0].id, client)).space
        form = FORMS[sent]
        # Of a table, only the size is known, and most of it may be other columns.
        most = min(arriving.size // form.row_bytes + 1, form.most_rows)
        rows = min(most, MOST_CELLS // len(wanted)) if body is None else body.rows
        _check_cells(rows, len(wanted))
        text = 0 if sent == JSON else 2 * arriving.size
        cells = rows * len(wanted)

        def need() -> int:
            library = service.library
            models = [library.model_need(record) for record in records] if terms.recipes else [0]
            levels = max(library.need([each]) for each in wanted)
            return max(models) + levels + text + ROW_BYTES * rows + _CELL_BYTES * cells

        work = Work.HEAVY if terms.recipes or cells > _VIEW_CELLS else Work.VIEW
        work = Work.SMALL if work is Work.VIEW and cells <= _SMALL_CELLS else work
        with await service.admission.place(work, client, need, need() + _CELL_EFFORT * cells):
            if body is None:
                body = await parse(space)
                _check_cells(body.rows, len(wanted))
            labels = _labels(body, values["names"])
            answers = await _matches(request, wanted, body, values["space"], terms)
            content, warnings = await service.library.in_thread(
                _content, answers, labels, terms, records, body, accepted
            )
            headers = {
                "Cache-Control": "no-store",
                "Vary": "Accept",
                **warning_header([warning[:_LONGEST_WARNING] for warning in warnings]),
                **reading_header(body.table),
            }
            answer = Response(content, 200, headers, accepted)
            return service.admission.hold_response(answer, client)


def _level(record: PublishedGamut, max_error: float | None) -> LevelRequest:
    """Return the level of a gamut that answers, as `gamutcore.match` chooses it."""
    return LevelRequest(stored_level(record.description, max_error=max_error))


def _check_cells(rows: int, gamuts: int) -> None:
    if rows * gamuts > MOST_CELLS:
        detail = f"{rows} colours and {gamuts} gamuts are {rows * gamuts} answers."
        where = {"field": "colours", "limit": MOST_CELLS // gamuts}
        remedy = f"Send at most {MOST_CELLS // gamuts} colours for so many gamuts."
        raise ProblemError(Problem("too-many-rows", detail, where, remedy))


def _accepted_form(request: Request) -> str:
    """Return the form of the answer, JSON unless `Accept` prefers CSV."""
    accept = ",".join(request.headers.getlist("accept"))
    media_type = preferred_media_type(accept, [JSON, CSV])
    if media_type is None:
        detail = f"The answer is not available as {accept[:200]}."
        where = {"header": "Accept", "available": [JSON, CSV]}
        raise ProblemError(Problem("not-acceptable", detail, where))
    return media_type


async def _matches(
    request: Request,
    wanted: Sequence[tuple[PublishedGamut, LevelRequest]],
    body: QuestionBody,
    space: str | None,
    terms: MatchTerms,
) -> list[GamutMatch]:
    """Return the answers of the gamuts, which are asked one after the other."""
    service, names = service_of(request), set[str]()
    library, answers = service.library, list[GamutMatch]()
    points = body.inputs[0]
    space = space if body.table is None else body.table.space
    for record, level_request in wanted:
        if await request.is_disconnected():
            raise ClientDisconnect
        opened = await library.open(record.id)
        if answers:
            check_space(answers[0], opened.gamut)
        if terms.recipes and opened.gamut.is_of_device:
            with contextlib.suppress(DeviceModelError):  # its data is gone
                opened = await library.load_device_model(record.id)
        level: QueryLevel = (await library.levels([(record, level_request)]))[0]
        name = distinct_name(opened.name, names)
        clock = time.perf_counter()
        with timed("query"):
            answer = await library.in_thread(
                match_gamut, name, level.gamut, level.triangles, points, space, terms
            )
        service.metrics.queries.count(MATCH.name, len(points), time.perf_counter() - clock)
        answers.append(answer)
        del opened, level
        # What was made of a gamut stays only as long as the next one has room.
        service.admission.shrink_caches()
    return answers


def _content(
    answers: Sequence[GamutMatch],
    labels: Sequence[str] | None,
    terms: MatchTerms,
    records: Sequence[PublishedGamut],
    body: QuestionBody,
    media_type: str,
) -> tuple[bytes, tuple[str, ...]]:
    """Return the answer as a file, and the warnings."""
    match: ColourMatch = gathered_match(answers, labels, terms.passing)
    with timed("encode"):
        if media_type == CSV:
            return match_report(match).to_csv().encode(), match.warnings
        document = match.to_dict()
        for gamut, record in zip(document["gamuts"], records, strict=True):
            gamut["id"] = record.id
        if body.table is not None:
            document["reading"] = body.table.reading
        return to_json(document, inf_nan_mode="null") + b"\n", ()


def _labels(body: QuestionBody, names: Sequence[str] | None) -> Sequence[str] | None:
    """Return the names of the colours; None for numbers."""
    if body.table is not None:
        labels = body.table.labels() if names is None else names
        names = [label[:LONGEST_LABEL] for label in labels]
    if names is not None and len(names) != body.rows:
        detail = f"There are {len(names)} names and {body.rows} colours."
        raise ProblemError(Problem("invalid-body", detail, {"field": "names"}, "Name each colour."))
    return names


# --- gamuts ---------------------------------------------------------------------------------------


def _texts(gamuts: str | Iterable[str] | None) -> list[str]:
    """Return the texts that stand for gamuts, each once."""
    parts = gamuts.split(",") if isinstance(gamuts, str) else gamuts or ()
    return list(dict.fromkeys(part.strip() for part in parts))


async def _records(request: Request, texts: list[str], place: str) -> list[PublishedGamut]:
    """Return the records of gamuts by id, slug or name, each once. References are built.

    Raise ``invalid-parameter`` if there are none or too many, or if a name is ambiguous.
    """
    service = service_of(request)
    if not 1 <= len(texts) <= MOST_GAMUTS or "" in texts:
        detail = f"{len(texts)} gamuts are named."
        if "" in texts or not texts:
            detail = "The list of gamuts is missing, or a name in it is empty."
        remedy = f"Give 1 to {MOST_GAMUTS} ids, slugs or names as gamuts."
        raise invalid_parameter(detail, place, "gamuts", remedy)
    ids = await _ids_of_names(service, texts, place)
    gamuts = NamedGamuts.of(request)
    wanted = dict.fromkeys([await gamuts.id_of(ids.get(text, text)) for text in texts])
    return [await service.library.record(gamut_id) for gamut_id in wanted]


async def _ids_of_names(
    service: ServiceContainer, texts: Iterable[str], place: str
) -> Mapping[str, str]:
    """Return the ids of gamuts by their names, and slugs of references by theirs."""
    names = [text for text in texts if not _ID.match(text) and text not in REFERENCES]
    if not names:
        return {}
    ids = {}
    for name, candidates in (await asyncio.to_thread(find_named, service.store, names)).items():
        if len(candidates) > 1:
            detail = f"{len(candidates)} gamuts have names with {name[:LONGEST_SHOWN]!r}."
            shown = [{"id": each.id, "name": each.name} for each in candidates[:_SHOWN_CANDIDATES]]
            where = {"in": place, "field": "gamuts", "candidates": shown}
            remedy = "Give the id of one of the candidates, or all of a name."
            raise ProblemError(Problem("invalid-parameter", detail, where, remedy))
        if candidates:
            ids[name] = candidates[0].id
            continue
        try:
            ids[name] = find_reference(name).slug
        except GamutError as error:
            detail = f"No gamut has a name with {name[:LONGEST_SHOWN]!r}."
            remedy = "Give an id or a name from GET /v1/gamuts, or a slug from GET /v1/references."
            where = {"in": place, "field": "gamuts"}
            raise ProblemError(Problem("gamut-not-found", detail, where, remedy)) from error
    return ids
