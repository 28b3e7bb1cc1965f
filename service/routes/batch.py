"""Route of batches: several levels of several gamuts in one request."""

import asyncio
import hashlib
import re
from collections.abc import AsyncIterator, Callable
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Query, Request
from fastapi.responses import Response, StreamingResponse

from gamutcore.errors import OptionError, TriangleCountError
from gamutcore.export import FORMATS
from gamutcore.levels import LevelRequest
from service.container import ServiceContainer, service_of
from service.http.representations import (
    IMMUTABLE,
    OCTET_STREAM,
    check_if_match,
    matches,
    preferred_media_type,
)
from service.http.requests import DECIMAL_PATTERN, GAMUT_IDS, GAMUT_PATTERN, SideName
from service.library import Charge, ChargedResponse, Cost
from service.openapi.documentation import BATCH_RESPONSE, EXAMPLE_ID, problems
from service.problems.problem import Problem, ProblemError
from service.routes.containers import CONTAINERS, Asked, Container, Item, ZipContainer
from service.routes.dependencies import GamutRoute, NamedGamuts, check_gamut_query
from service.storage.gamuts import GamutDamagedError, GamutNotStoredError

__all__ = ["router"]

router = APIRouter(
    prefix="/v1/meshes",
    tags=["meshes"],
    route_class=GamutRoute,
    dependencies=[Depends(check_gamut_query)],
)

_BUFFERED = 8 * 1024 * 1024
"""Largest answer in bytes that is complete before it is sent, with a length and an entity tag."""

_SHARE = 0.25
"""Share of the memory for what batches hold while they wait for meshes."""

_COUNT = re.compile(r"[0-9]{1,9}\Z")
_LIMIT = re.compile(DECIMAL_PATTERN + r"\Z")

_READ: dict[str, Callable[[str], Any]] = {
    "triangles": int,
    "max_error": float,
    "max_mismatch": float,
}
"""Parser of each parameter's values."""


def _numbers(what: str, example: str) -> Any:  # noqa: ANN401 - FastAPI's own
    return Query(description=what, max_length=1000, examples=[example])


@router.get(
    "",
    operation_id="downloadMeshes",
    summary="Download several meshes",
    description="All requested levels of all named gamuts in one file: a zip archive, or "
    "multipart/mixed if `Accept` prefers it. Missing meshes are reported in `index.json` of the "
    "archive or as a part of the message. If all meshes are missing, the answer is the first "
    "problem. Answers of up to 8 MB have an entity tag; larger ones are streamed.",
    response_class=Response,
    responses={
        200: BATCH_RESPONSE,
        304: {"description": "The client has the current content (If-None-Match)."},
        **problems(
            "gamut-not-found",
            "gamut-rebuilding",
            "triangle-count",
            "precondition-failed",
            "invalid-option",
            "invalid-parameter",
            "not-acceptable",
            "memory-busy",
            "memory-exceeded",
            "store-unavailable",
        ),
    },
)
async def download_meshes(
    request: Request,
    gamuts: Annotated[
        str,
        Query(
            description="Ids of gamuts, or slugs of reference gamuts, separated by commas.",
            pattern=f"^{GAMUT_PATTERN}(,{GAMUT_PATTERN})*$",
            max_length=65 * 400,
            examples=[EXAMPLE_ID],
        ),
        GAMUT_IDS,
    ],
    triangles: Annotated[
        str | None, _numbers("Triangle counts, separated by commas.", "100,1000")
    ] = None,
    max_error: Annotated[
        str | None, _numbers("Largest distances, separated by commas.", "0.5,1")
    ] = None,
    max_mismatch: Annotated[
        str | None, _numbers("Largest mismatches, separated by commas.", "0.001")
    ] = None,
    side: SideName = "both",
    format_name: Annotated[
        str,
        Query(
            alias="format",
            description="Format of the meshes.",
            json_schema_extra={"enum": list(FORMATS)},
            examples=["glb"],
        ),
    ] = "glb",
) -> Response:
    """Download several meshes."""
    service = service_of(request)
    if format_name not in FORMATS:
        _refuse(
            f"There is no format {format_name[:40]!r}.",
            "format",
            f"Use one of {', '.join(FORMATS)}.",
        )
    levels = [
        *_list("triangles", triangles, _COUNT, "whole numbers such as 100,1000"),
        *_list("max_error", max_error, _LIMIT, "decimal numbers such as 0.5,1e-1"),
        *_list("max_mismatch", max_mismatch, _LIMIT, "decimal numbers such as 0.01,1e-3"),
    ]
    if not levels:
        _refuse("No level is requested.", "triangles", "Give triangles, max_error or max_mismatch.")
    named = NamedGamuts.of(request)
    ids = list(dict.fromkeys([await named.id_of(name) for name in gamuts.split(",")]))
    most = service.settings.max_batch_meshes
    if len(ids) * len(levels) > most:
        detail = f"{len(ids)} gamuts in {len(levels)} levels are requested."
        _refuse(detail, "gamuts", f"Request at most {most} meshes at once.")
    asked = [Asked(one, name, value, format_name, side) for one in ids for name, value in levels]
    accept = ",".join(request.headers.getlist("accept"))
    media_type = preferred_media_type(accept, list(CONTAINERS))
    if media_type is None:
        detail = f"Several meshes are not available as {accept[:200]}."
        available = [name for name in CONTAINERS if name != OCTET_STREAM]
        where = {"header": "Accept", "available": available}
        remedy = "Accept application/zip or multipart/mixed."
        raise ProblemError(Problem("not-acceptable", detail, where, remedy))
    return await _Batch(service, asked, CONTAINERS[media_type](asked)).response(
        request.headers.getlist("if-match"), request.headers.getlist("if-none-match")
    )


class _Batch:
    """An answer under construction."""

    def __init__(self, service: ServiceContainer, asked: list[Asked], container: Container) -> None:
        self._service = service
        self._asked = asked
        self._container = container

    async def response(self, named: list[str], known: list[str]) -> Response:
        """Return the answer, complete if it is small, else streamed."""
        failed, triangles, largest = await self._check_all()
        if len(failed) == len(self._asked):
            raise ProblemError(failed[self._asked[0]])
        most = self._service.settings.max_batch_triangles
        if triangles > most:
            _refuse(
                f"The meshes may have up to {triangles} triangles together.",
                "gamuts",
                f"Request at most {most} triangles at once.",
            )
        media_type = self._container.media_type
        # What is complete before it is sent, joined, or one mesh and its copy in the container. The
        # meshes have charges of their own, which wait while this one is held.
        need = 2 * min(_BUFFERED + Cost.CODING * largest, Cost.CODING * triangles)
        memory = self._service.library.memory
        charge = await memory.charge("batches", lambda: need, share=_SHARE)
        parts: list[bytes] = []
        pieces = self._pieces(failed)
        size = 0
        async for piece in pieces:
            parts.append(piece)
            size += len(piece)
            if size > _BUFFERED:
                check_if_match(named)
                headers = self._headers(failed)
                return StreamingResponse(_chain(parts, pieces, charge), 200, headers, media_type)
        content, digest = await asyncio.to_thread(_join, parts)
        headers = self._headers(failed)
        headers["ETag"] = f'"{digest}"'
        check_if_match(named, headers["ETag"])
        if known and not failed and matches(",".join(known), headers["ETag"]):
            headers.pop("Content-Disposition", None)
            return Response(status_code=304, headers=headers)
        return ChargedResponse(Response(content, 200, headers, media_type), charge)

    def _headers(self, failed: dict[Asked, Problem]) -> dict[str, str]:
        """Return the header fields of the answer, besides those of its content."""
        headers = {
            "Cache-Control": "no-store" if failed else IMMUTABLE,
            "Vary": "Accept",
            "Gamut-Failures": str(len(failed)),
        }
        if self._container.media_type == ZipContainer.media_type:
            ids = {one.gamut_id for one in self._asked}
            name = f"{ids.pop()[:12]}-meshes.zip" if len(ids) == 1 else "meshes.zip"
            headers["Content-Disposition"] = f'attachment; filename="{name}"'
        return headers

    async def _check_all(self) -> tuple[dict[Asked, Problem], int, int]:
        """Return the missing meshes, and upper bounds of the triangles of the others: sum, largest.

        Computed from the records before any search or encoding, because a stream that has started
        cannot report an error.
        """
        failed: dict[Asked, Problem] = {}
        triangles = most = 0
        for gamut_id in dict.fromkeys(one.gamut_id for one in self._asked):
            wanted = [one for one in self._asked if one.gamut_id == gamut_id]
            try:
                record = await self._service.library.record(gamut_id)
            except GamutNotStoredError as error:
                if await self._can_be_rebuilt(gamut_id, error):
                    raise  # it will be rebuilt, and then the whole answer is available
                problem = _not_found(gamut_id)
                failed |= dict.fromkeys(wanted, problem)
                continue
            largest = record.description["counts"]["triangles"]
            for one in wanted:
                count = self._service.library.largest_count(record, _level_request(one))
                if not 4 <= count <= largest:
                    failed[one] = Problem(
                        "triangle-count",
                        f"{count} triangles are requested; the gamut has from 4 to {largest}.",
                        {"field": "triangles"},
                        f"Request a count from 4 to {largest}.",
                    )
                else:
                    triangles += count
                    most = max(most, count)
        return failed, triangles, most

    async def _can_be_rebuilt(self, gamut_id: str, error: GamutNotStoredError) -> bool:
        """Return whether a missing gamut was damaged and can be rebuilt."""
        if isinstance(error, GamutDamagedError):
            return error.input_kept
        return await asyncio.to_thread(self._service.store.to_be_rebuilt, gamut_id)

    async def _pieces(self, failed: dict[Asked, Problem]) -> AsyncIterator[bytes]:
        for one in self._asked:
            item = Item(one, None, failed[one]) if one in failed else await self._item(one)
            if item.problem is not None:
                failed[one] = item.problem
            for piece in await asyncio.to_thread(list, self._container.parts(item)):
                yield piece
        for piece in self._container.end():
            yield piece

    async def _item(self, one: Asked) -> Item:
        library = self._service.library
        try:
            return Item(one, await library.mesh(one.gamut_id, _level_request(one), one.format_name))
        except (TriangleCountError, OptionError) as error:
            # a body that is too thin for a level on one side, or a format of other gamuts
            return Item(one, None, Problem.from_error(error))


def _level_request(one: Asked) -> LevelRequest:
    return LevelRequest(**{one.name: _READ[one.name](one.value)}, side=one.side)


async def _chain(
    parts: list[bytes], rest: AsyncIterator[bytes], charge: Charge
) -> AsyncIterator[bytes]:
    with charge:
        for piece in parts:
            yield piece
        parts.clear()
        async for piece in rest:
            yield piece


def _join(parts: list[bytes]) -> tuple[bytes, str]:
    content = b"".join(parts)
    return content, hashlib.sha256(content).hexdigest()


def _list(
    name: str, text: str | None, pattern: re.Pattern[str], example: str
) -> list[tuple[str, str]]:
    """Return the name with each distinct value of a parameter, as first written."""
    if text is None:
        return []
    written: dict[Any, str] = {}
    for value in text.split(","):
        if not pattern.match(value):
            _refuse(f"{value[:40]!r} is not a valid number.", name, f"Give {example}.")
        written.setdefault(_READ[name](value), value)
    return [(name, value) for value in written.values()]


def _not_found(gamut_id: str) -> Problem:
    return Problem("gamut-not-found", f"There is no gamut {gamut_id}.", {"field": "gamuts"})


def _refuse(detail: str, field: str, remedy: str) -> None:
    where = {"in": "query", "field": field}
    raise ProblemError(Problem("invalid-parameter", detail, where, remedy))
