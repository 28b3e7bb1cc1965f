"""Routes of gamuts: create, list, describe, delete, levels and history."""

import asyncio
import contextlib
from collections.abc import AsyncIterator
from typing import IO, Annotated, Any, Literal

from fastapi import APIRouter, Depends, Query, Request
from fastapi.responses import Response, StreamingResponse

from service.access.middleware import check_owner, claim, may_change
from service.access.rate_limits import client_of
from service.container import ServiceContainer, service_of
from service.http.representations import (
    CODINGS,
    IMMUTABLE,
    OCTET_STREAM,
    byte_range,
    check_if_match,
    compress,
    compress_response,
    conditional,
    content_disposition,
    entity_tag,
    matches,
)
from service.http.requests import SideName
from service.openapi.documentation import (
    EXAMPLE_GAMUT,
    EXAMPLE_ID,
    EXAMPLE_JOB,
    EXAMPLE_LEVELS,
    EXAMPLE_LIST,
    SUBMISSION_BODY,
    gamut_links,
    header,
    job_links,
    json_response,
    problems,
)
from service.openapi.models import (
    ErrorCurve,
    GamutDescription,
    GamutList,
    JobDescription,
)
from service.problems.kinds import BUILD_PROBLEMS, KINDS
from service.problems.problem import JsonResponse, Problem, ProblemError
from service.routes.dependencies import GamutId, GamutRoute, check_gamut_query
from service.routes.jobs import wait_for_build
from service.routes.names import (
    NamedRecord,
    gamut_document,
    gamut_summary,
    named,
    named_page,
    ranked_page,
    refuse_reference,
)
from service.routes.paging import After, Limit, next_page
from service.routes.submission import Submission, submission
from service.routes.viewer import prefers_page, viewer_page
from service.storage.blobs import StoreUnavailableError
from service.storage.gamut_names import LONGEST_NAME
from service.storage.gamut_store import GamutDamagedError, GamutNotStoredError
from service.storage.published import PublishedGamut

__all__ = ["HISTORY_MEDIA_TYPE", "router"]

HISTORY_MEDIA_TYPE = OCTET_STREAM

_CHUNK = 256 * 1024
"""Bytes of a history that are read and sent at once."""

_READ_ANYWAY = 1 << 20
"""Largest body that is read even if the queue is full."""

_ENTITY_HEADERS = {
    "ETag": header("Strong entity tag: the SHA-256 of the content.", f'"{EXAMPLE_ID}"'),
    "Cache-Control": header("The content is immutable.", IMMUTABLE),
}

_HISTORY_NAME = header(
    "File name: the name of the gamut.",
    'attachment; filename="Coated offset.gamut"',
)

_NOT_MODIFIED: dict[int | str, dict[str, Any]] = {
    304: {"description": "The client has the current content (If-None-Match)."}
}

router = APIRouter(
    prefix="/v1/gamuts",
    tags=["gamuts"],
    route_class=GamutRoute,
    dependencies=[Depends(check_gamut_query)],
)


@router.post(
    "",
    operation_id="createGamut",
    summary="Build a gamut, or return the existing one",
    description="Accepts characterisation data as a file or inline. The answer is the gamut with "
    "200 if it exists, the gamut with 201 if it was built while the client waited, or a job with "
    "202. The same data and options always give the same id, so the request is idempotent. "
    "`Prefer: wait=N` sets the waiting time in seconds, and `Prefer: respond-async` "
    "asks for a job at once (RFC 7240).",
    responses={
        200: json_response(
            "The gamut exists.",
            GamutDescription,
            EXAMPLE_GAMUT,
            {"Content-Location": header("The gamut.", f"/v1/gamuts/{EXAMPLE_ID}")},
            gamut_links("$response.body#/id"),
        ),
        201: json_response(
            "The gamut was built.",
            GamutDescription,
            EXAMPLE_GAMUT,
            {
                "Location": header("The gamut.", f"/v1/gamuts/{EXAMPLE_ID}"),
                "Preference-Applied": header("Preferences that were applied.", "wait=10"),
            },
            gamut_links("$response.body#/id"),
        ),
        202: json_response(
            "The gamut is being built.",
            JobDescription,
            EXAMPLE_JOB,
            {
                "Location": header("The job.", f"/v1/jobs/{EXAMPLE_ID}"),
                "Retry-After": header("Seconds after which to ask again.", 1),
                "Preference-Applied": header("Preferences that were applied.", "respond-async"),
            },
            job_links("$response.body#/id"),
        ),
        **problems(
            "malformed-body",
            "request-timeout",
            "body-too-large",
            "unsupported-media-type",
            "invalid-body",
            "invalid-name",
            "invalid-parameter",
            *BUILD_PROBLEMS,
            "build-cancelled",
            "build-input-lost",
            "gamut-deleted",
            "gamut-rebuilding",
            "queue-full",
            "shutting-down",
            "broker-unavailable",
            "overloaded",
            "queries-busy",
            "memory-busy",
            "scratch-full",
            "store-unavailable",
            "storage-full",
        ),
    },
    openapi_extra={
        "requestBody": SUBMISSION_BODY,
        "parameters": [
            {
                "name": "Prefer",
                "in": "header",
                "required": False,
                "description": "Time to wait for the build (RFC 7240).",
                "schema": {"type": "string"},
                "examples": {
                    "wait": {"value": "wait=10"},
                    "asynchronous": {"value": "respond-async"},
                },
            }
        ],
    },
)
async def create_gamut(request: Request) -> Response:
    """Build a gamut, or return the existing one."""
    service = service_of(request)
    await _check_admission_of_large(request, service)
    async with submission(request, service) as posted:
        gamut_id = posted.gamut_id
        gamut_or_job = await service.builds.submit(
            gamut_id,
            posted.options.to_mapping(),
            posted.data,
            posted.sha256,
            client_of(request.scope),
        )
        if isinstance(gamut_or_job, PublishedGamut):
            await _keep_name(request, posted, is_new=False)
            return _existing(await _named(service, gamut_or_job))
        job = gamut_or_job
        await claim(request, service.store, gamut_id)
        await _keep_name(request, posted, is_new=True)
    # The data leaves the memory before the wait for the build.
    del posted
    headers = await wait_for_build(service, job, request.headers.getlist("prefer"))
    record = await _record_of_built(service, gamut_id)
    location = {"Location": f"/v1/gamuts/{gamut_id}"}
    return _description_response(await _named(service, record), 201, {**headers, **location})


async def _named(service: ServiceContainer, record: PublishedGamut) -> NamedRecord:
    """Return a record with the gamut's name.

    While the store does not answer, the name is that of the open gamut.
    """
    try:
        return (await asyncio.to_thread(named, service.store, [record]))[0]
    except StoreUnavailableError:
        opened = service.library.find_open(record.id)
        if opened is None:
            raise
        return NamedRecord(record, opened.name)


async def _keep_name(request: Request, posted: Submission, *, is_new: bool) -> None:
    """Store the name in a request, or the name of a new gamut's file.

    A gamut of another client keeps its name, because the request is to build, not to rename.
    """
    service = service_of(request)
    names = service.store.names
    if posted.name is not None:
        if not await may_change(request, service.store, posted.gamut_id):
            return
        await asyncio.to_thread(names.give, posted.gamut_id, posted.name)
    elif is_new and posted.file:
        await asyncio.to_thread(names.keep_file, posted.gamut_id, posted.file)
    else:
        return
    await service.library.rename(posted.gamut_id)


async def _record_of_built(service: ServiceContainer, gamut_id: str) -> PublishedGamut:
    """Return the record of a gamut that has just been built."""
    try:
        return await service.library.record(gamut_id)
    except GamutDamagedError:
        raise
    except GamutNotStoredError:
        # Deleted by a client, or evicted from a small store.
        raise ProblemError(Problem("gamut-deleted", KINDS["gamut-deleted"].detail)) from None


async def _check_admission_of_large(request: Request, service: ServiceContainer) -> None:
    """Refuse a large body before it is read, if its build would be refused.

    Small bodies are read first, because their gamut may exist or be under way, which a full queue
    does not affect.
    """
    length = request.headers.get("content-length", "")
    if not length.isdigit() or int(length) > _READ_ANYWAY:
        await service.builds.check_admission()


@router.get(
    "",
    operation_id="listGamuts",
    summary="List the gamuts",
    description="Pages of all gamuts in the order of their ids. `next` is the next page. With "
    "`name`, a page may have fewer gamuts than `limit` although there is a next page. With "
    "`match=similar`, a page has the best of the next 1,000 gamuts, the most likely first.",
    responses={
        200: json_response("A page of gamuts.", GamutList, EXAMPLE_LIST),
        **problems("invalid-parameter", "store-unavailable"),
    },
)
async def list_gamuts(
    request: Request,
    limit: Limit = 50,
    after: After = "",
    name: Annotated[
        str,
        Query(
            description="Only gamuts whose names contain this text, without regard to case.",
            max_length=LONGEST_NAME,
            examples=["FOGRA39"],
        ),
    ] = "",
    match: Annotated[
        Literal["contains", "similar"],
        Query(
            description="`similar`: gamuts that `name` may mean, in any spelling, the most likely "
            "first. The names of a print condition count as the same: `TR 006` finds `GRACoL2006`."
        ),
    ] = "contains",
) -> Response:
    """List the gamuts."""
    service = service_of(request)
    similar = match == "similar" and name != ""
    page = ranked_page if similar else named_page
    shown, last = await asyncio.to_thread(page, service.store, after, limit, name)
    kind = match if similar else ""
    following, link = next_page(last, limit, "/v1/gamuts", name=name, match=kind)
    document = {"gamuts": [gamut_summary(each) for each in shown], "next": following}
    answer = JsonResponse(document, headers={"Cache-Control": "no-cache"} | link)
    return compress_response(answer, request.headers.getlist("accept-encoding"))


@router.get(
    "/{gamut_id}",
    operation_id="describeGamut",
    summary="Describe a gamut",
    description="Options with defaults, provenance, counts, volume, area, centre, bounds, error "
    "curve and links. A client that prefers `text/html`, such as a browser, gets the viewer.",
    responses={
        200: json_response(
            "The gamut.", GamutDescription, EXAMPLE_GAMUT, {"ETag": _ENTITY_HEADERS["ETag"]}
        ),
        **_NOT_MODIFIED,
        **problems(
            "gamut-not-found",
            "gamut-rebuilding",
            "precondition-failed",
            "invalid-parameter",
            "store-unavailable",
        ),
    },
)
async def describe_gamut(request: Request, gamut_id: GamutId) -> Response:
    """Describe a gamut."""
    service = service_of(request)
    record = await service.library.record(gamut_id)
    gamut = await _named(service, record)
    if prefers_page(request):
        return viewer_page(request, gamut)
    # Later versions of the service may add members, and the name may change.
    answer = JsonResponse(
        gamut_document(gamut),
        headers={"Cache-Control": "no-cache", "Vary": "Accept"},
    )
    return _conditional(request, answer)


@router.delete(
    "/{gamut_id}",
    operation_id="deleteGamut",
    summary="Delete a gamut",
    description="Removes the gamut and its history. Posting the same data builds it again under "
    "the same id. With `If-Match`, the gamut is deleted only if the field names the `ETag` of its "
    "description, in any content coding. Caches outside of the service may keep copies.",
    status_code=204,
    responses={
        204: {"description": "The gamut was deleted."},
        **problems(
            "gamut-not-found",
            "reference-read-only",
            "built-by-another",
            "gamut-rebuilding",
            "precondition-failed",
            "invalid-parameter",
            "store-unavailable",
        ),
    },
)
async def delete_gamut(request: Request, gamut_id: GamutId) -> Response:
    """Delete a gamut."""
    service = service_of(request)
    record = await service.library.record(gamut_id)
    refuse_reference(record)
    await check_owner(request, service.store, gamut_id)
    if_match = request.headers.getlist("if-match")
    if if_match:
        check_if_match(if_match, *_description_tags(await _named(service, record)))
    deleted = await asyncio.to_thread(service.store.delete, gamut_id)
    service.library.discard(gamut_id)
    if not deleted:
        raise GamutNotStoredError(gamut_id)
    return Response(status_code=204)


@router.get(
    "/{gamut_id}/levels",
    operation_id="describeLevels",
    summary="Read the error curve",
    description="Volume, mismatch and distances in both directions by triangle count. The bounds "
    "hold for a level and all finer levels of the curve. `max_error` and `max_mismatch` select "
    "from more levels. For one side, they "
    "select from the levels of the curve. The first curve of a side takes a second or two.",
    responses={
        200: json_response("The error curve.", ErrorCurve, EXAMPLE_LEVELS, _ENTITY_HEADERS),
        **_NOT_MODIFIED,
        **problems(
            "gamut-not-found",
            "gamut-rebuilding",
            "precondition-failed",
            "invalid-parameter",
            "queries-busy",
            "memory-busy",
            "memory-exceeded",
            "store-unavailable",
        ),
    },
)
async def describe_levels(request: Request, gamut_id: GamutId, side: SideName = "both") -> Response:
    """Read the error curve."""
    service = service_of(request)
    if side == "both":
        record = await service.library.record(gamut_id)
        levels = record.description["levels"]
    else:
        curve = await service.library.curve(gamut_id, side, client_of(request.scope))
        levels = [level.to_mapping() for level in curve]
    document = {"id": gamut_id, "levels": levels}
    return _conditional(request, JsonResponse(document, headers={"Cache-Control": IMMUTABLE}))


@router.get(
    "/{gamut_id}/history",
    operation_id="downloadHistory",
    summary="Download the history",
    description="The file of the gamut, which contains every level. Its format is documented and "
    "readable without Python. A single `Range` is supported.",
    response_class=StreamingResponse,
    responses={
        200: {
            "description": "The history file.",
            "content": {
                HISTORY_MEDIA_TYPE: {
                    "schema": {"type": "string", "format": "binary"},
                    "examples": {"history": {"summary": "The bytes of a history file"}},
                }
            },
            "headers": {
                **_ENTITY_HEADERS,
                "Accept-Ranges": header("Ranges are supported.", "bytes"),
                "Content-Disposition": _HISTORY_NAME,
            },
        },
        206: {
            "description": "The requested part of the history file.",
            "content": {
                HISTORY_MEDIA_TYPE: {
                    "schema": {"type": "string", "format": "binary"},
                    "examples": {"part": {"summary": "Some bytes of a history file"}},
                }
            },
            "headers": {
                **_ENTITY_HEADERS,
                "Content-Range": header("Range of the part.", "bytes 0-1023/3603856"),
                "Content-Disposition": _HISTORY_NAME,
            },
        },
        **_NOT_MODIFIED,
        **problems(
            "gamut-not-found",
            "gamut-rebuilding",
            "precondition-failed",
            "range-not-satisfiable",
            "invalid-parameter",
            "store-unavailable",
        ),
    },
)
async def download_history(request: Request, gamut_id: GamutId) -> Response:
    """Download the history."""
    service = service_of(request)
    record, file = await asyncio.to_thread(service.store.verified_file, gamut_id)
    with contextlib.ExitStack() as closing:
        closing.enter_context(file)
        etag = f'"{record.sha256}"'
        headers = {"ETag": etag, "Cache-Control": IMMUTABLE, "Accept-Ranges": "bytes"}
        check_if_match(request.headers.getlist("if-match"), etag)
        known = request.headers.getlist("if-none-match")
        if known and matches(",".join(known), etag):
            return Response(status_code=304, headers=headers)
        part = byte_range(
            ",".join(request.headers.getlist("range")),
            request.headers.get("if-range"),
            etag,
            record.nbytes,
        )
        start, end = part or (0, record.nbytes)
        headers["Content-Length"] = str(end - start)
        name = (await _named(service, record)).name
        headers["Content-Disposition"] = content_disposition("attachment", name, ".gamut")
        if part:
            headers["Content-Range"] = f"bytes {start}-{end - 1}/{record.nbytes}"
        closing.pop_all()
    return StreamingResponse(
        _chunks(file, start, end), 206 if part else 200, headers, HISTORY_MEDIA_TYPE
    )


async def _chunks(file: IO[bytes], start: int, end: int) -> AsyncIterator[bytes]:
    with file:
        file.seek(start)
        while start < end:
            chunk = await asyncio.to_thread(file.read, min(_CHUNK, end - start))
            start += len(chunk)
            yield chunk


def _conditional(request: Request, answer: Response) -> Response:
    answer = compress_response(answer, request.headers.getlist("accept-encoding"))
    return conditional(answer, request.headers)


def _description_tags(gamut: NamedRecord) -> list[str]:
    """Return the entity tags of a gamut's description in all content codings."""
    content = bytes(JsonResponse(gamut_document(gamut)).body)
    return [entity_tag(content), *(entity_tag(compress(content, coding)) for coding in CODINGS)]


def _existing(gamut: NamedRecord) -> Response:
    return _description_response(gamut, 200, {"Content-Location": f"/v1/gamuts/{gamut.id}"})


def _description_response(gamut: NamedRecord, status: int, headers: dict[str, str]) -> Response:
    return JsonResponse(gamut_document(gamut), status, {"Cache-Control": "no-cache", **headers})
