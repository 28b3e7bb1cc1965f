"""Routes of jobs: progress and cancellation. A job has the id of the gamut that it builds."""

import json
from collections.abc import AsyncIterator, Sequence
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Header, Path, Request
from fastapi.responses import Response, StreamingResponse

from service.access.middleware import check_owner
from service.container import ServiceContainer, service_of
from service.http.representations import preference
from service.http.request_context import timed
from service.http.requests import ID, ID_PATTERN, check_query
from service.jobs.book import JobDocument
from service.jobs.events import HEARTBEAT_SECONDS, MEDIA_TYPE, event_id, stream_of_events
from service.openapi.documentation import EXAMPLE_ID, EXAMPLE_JOB, header, json_response, problems
from service.openapi.models import JobDescription, JobList
from service.problems.problem import JsonResponse, Problem, ProblemError
from service.routes.paging import After, Limit, page_of
from service.storage.gamut_store import GamutDamagedError, GamutNotStoredError

__all__ = ["LONGEST_WAIT", "PendingBuildError", "job_description", "router", "wait_for_build"]

router = APIRouter(prefix="/v1/jobs", tags=["jobs"], dependencies=[Depends(check_query)])

LONGEST_WAIT = 300.0
"""Longest `Prefer: wait=N` in seconds. A build has two minutes, and proxies close later."""

_NO_STORE = {"Cache-Control": "no-store"}

JobId = Annotated[
    str,
    Path(
        pattern=f"^{ID_PATTERN}$",
        description="Id of the job, which is the id of its gamut.",
        examples=[EXAMPLE_ID],
    ),
    ID,
]

_CANCELLED_JOB = {
    **EXAMPLE_JOB,
    "state": "cancelled",
    "finished": "2026-01-31T12:00:01.000Z",
    "problem": Problem(
        "build-cancelled", "The build was cancelled before it was finished."
    ).document(),
}

_EXAMPLE_EVENT = (
    f"id: 1.1.running.decimation.400\nevent: progress\ndata: {json.dumps(EXAMPLE_JOB)}\n\n"
)

# No type: client generators read a stream as text, test programs as one object per event.
_EVENT_SCHEMA = {
    "description": "Events in the event stream format of HTML, with the fields `id`, `event` "
    "(`progress` or `finished`) and `data` (the job as JSON).",
}


@router.get(
    "",
    operation_id="listJobs",
    summary="List the jobs",
    description="Pages of all stored jobs in the order of their ids. `next` is the next page. "
    "Finished jobs are removed after some time; their gamuts stay. Until then, a succeeded job is "
    "listed even if its gamut was deleted.",
    responses={
        200: json_response("A page of jobs.", JobList, {"jobs": [EXAMPLE_JOB], "next": None}),
        **problems("invalid-parameter", "store-unavailable"),
    },
)
async def list_jobs(
    request: Request,
    limit: Limit = 50,
    after: After = "",
) -> Response:
    """List the jobs."""
    service = service_of(request)
    documents = await service.builds.page(after, limit + 1)
    shown, following, link = page_of(documents, limit, "/v1/jobs")
    page = JobList(jobs=[job_description(each) for each in shown], next=following)
    return JsonResponse(page, headers=_NO_STORE | link)


@router.get(
    "/{job_id}",
    operation_id="describeJob",
    summary="Describe a build",
    description="State and progress of a build. Poll until the state is `succeeded`, `failed` or "
    "`cancelled`, at the interval of Retry-After. Every replica gives the same answer. A removed "
    "job counts as succeeded if its gamut exists.",
    responses={
        200: json_response(
            "The job.",
            JobDescription,
            EXAMPLE_JOB,
            {"Retry-After": header("Seconds after which to ask again, until the job ends.", 1)},
        ),
        **problems("job-not-found", "gamut-rebuilding", "invalid-parameter", "store-unavailable"),
    },
)
async def describe_job(request: Request, job_id: JobId) -> Response:
    """Describe a build."""
    service = service_of(request)
    document = await _read_job(service, job_id)
    headers = dict(_NO_STORE)
    if not document.final:
        headers["Retry-After"] = str(service.builds.retry_after(document))
    return JsonResponse(job_description(document), headers=headers)


@router.get(
    "/{job_id}/events",
    operation_id="followJob",
    summary="Follow a build by server-sent events",
    description="Events `progress` with the job, now and after every change, then the event "
    "`finished`, which ends the stream. A client that reconnects with the `Last-Event-ID` of "
    "`finished` gets 204, so that browsers stop reconnecting. A service that stops ends its "
    "streams; clients continue at another replica.",
    response_class=StreamingResponse,
    responses={
        200: {
            "description": "The events.",
            "content": {
                MEDIA_TYPE: {
                    "schema": _EVENT_SCHEMA,
                    "examples": {"event": {"value": _EXAMPLE_EVENT}},
                }
            },
            "headers": {"Cache-Control": header("The state changes.", "no-store")},
        },
        204: {"description": "There is no event after the client's last one."},
        **problems(
            "job-not-found",
            "gamut-rebuilding",
            "too-many-streams",
            "invalid-parameter",
            "store-unavailable",
        ),
    },
)
async def follow_job(
    request: Request,
    job_id: JobId,
    last_event_id: Annotated[
        str | None, Header(description="Id of the last event that the client received.")
    ] = None,
) -> Response:
    """Follow a build by server-sent events."""
    service = service_of(request)
    document = await _read_job(service, job_id)
    if document.final and last_event_id == event_id(document):
        return Response(status_code=204, headers=_NO_STORE)
    if service.events.full:
        detail = f"{service.events.count} event streams are open."
        raise ProblemError(Problem("too-many-streams", detail, headers={"Retry-After": "5"}))
    # Keeps proxies from buffering the stream.
    headers = {**_NO_STORE, "X-Accel-Buffering": "no"}
    return StreamingResponse(
        _events(service, document, last_event_id), headers=headers, media_type=MEDIA_TYPE
    )


@router.delete(
    "/{job_id}",
    operation_id="cancelJob",
    summary="Cancel a build",
    description="Ends the build for all waiting clients and returns the cancelled job. A cancelled "
    "job stays cancelled. Posting the data again starts a new build.",
    responses={
        200: json_response("The job, cancelled.", JobDescription, _CANCELLED_JOB),
        **problems(
            "job-not-found",
            "built-by-another",
            "gamut-rebuilding",
            "job-finished",
            "invalid-parameter",
            "store-unavailable",
        ),
    },
)
async def cancel_job(request: Request, job_id: JobId) -> Response:
    """Cancel a build."""
    service = service_of(request)
    if await service.builds.job(job_id) is not None:
        await check_owner(request, service.store, job_id)
    document = await service.builds.cancel(job_id)
    if document is None or document.state == "succeeded":
        document = await _read_job(service, job_id)
    if document.state != "cancelled":
        detail = f"The job has {document.state}."
        raise ProblemError(Problem("job-finished", detail, {"state": document.state}))
    return JsonResponse(job_description(document), headers=_NO_STORE)


def job_description(document: JobDocument) -> JobDescription:
    """Return a job as clients see it. The model leaves out what is not for them."""
    problem = document.problem
    gamut = f"/v1/gamuts/{document.gamut_id}" if document.state == "succeeded" else None
    return JobDescription.model_validate(
        {
            **vars(document),
            "created": document.created or None,
            "problem": None if problem is None else Problem.from_mapping(problem).document(),
            "links": {"self": f"/v1/jobs/{document.id}", "gamut": gamut},
        }
    )


async def _read_job(service: ServiceContainer, job_id: str) -> JobDocument:
    """Return a stored job, or the implied job of an existing gamut."""
    document = await service.builds.job(job_id)
    if document is not None and document.state != "succeeded":
        return document
    # The store decides whether a build has succeeded: the gamut may be deleted.
    try:
        record = await service.library.record(job_id if document is None else document.gamut_id)
    except GamutDamagedError:
        raise
    except GamutNotStoredError:
        problem = Problem("job-not-found", f"There is no job {job_id}.", {"field": "job_id"})
        raise ProblemError(problem) from None
    return document or JobDocument(
        job_id, {}, "succeeded", fraction=1.0, attempts=1, finished=record.created
    )


async def _events(
    service: ServiceContainer, document: JobDocument, known: str | None
) -> AsyncIterator[bytes]:
    with service.events.one():
        async for event in stream_of_events(_changes(service, document), known):
            yield event


async def _changes(
    service: ServiceContainer, document: JobDocument
) -> AsyncIterator[tuple[JobDocument, dict[str, Any]] | None]:
    if document.final:
        yield document, job_description(document).model_dump()
        return
    async for change in service.builds.changes(document.id, HEARTBEAT_SECONDS):
        yield None if change is None else (change, job_description(change).model_dump())


class PendingBuildError(Exception):
    """Ends a request with the job of a build that takes longer than the client waits."""

    def __init__(self, response: Response) -> None:
        super().__init__()
        self.response = response


async def wait_for_build(
    service: ServiceContainer, job: JobDocument, prefer: Sequence[str], waited: float = 0.0
) -> dict[str, str]:
    """Wait for a job as long as the client wants to, and return ``Preference-Applied``, if any.

    `prefer` has the values of ``Prefer``; `waited` is how long the client has waited for other
    builds. Raise `PendingBuildError` with the job and 202 if it has not ended, and `ProblemError`
    if the build failed or was cancelled.
    """
    wanted = preference(prefer)
    with timed("build"):
        if wanted.wait is None and not wanted.respond_async:
            # On a first start, nothing can be built until the kernels are compiled.
            await service.kernels.wait("default", LONGEST_WAIT)
        seconds = wanted.seconds(service.settings.client_wait, LONGEST_WAIT)
        job = await service.builds.wait(job.id, max(0.0, seconds - waited)) or job
    headers = {}
    applied = wanted.applied_field(answered_async=not job.final, longest=LONGEST_WAIT)
    if applied:
        headers["Preference-Applied"] = applied
    if not job.final:
        location, seconds = f"/v1/jobs/{job.id}", service.builds.retry_after(job)
        headers |= {"Location": location, "Retry-After": str(seconds), **_NO_STORE}
        raise PendingBuildError(JsonResponse(job_description(job), 202, headers))
    if job.problem is not None:
        raise ProblemError(Problem.from_mapping(job.problem))
    return headers
