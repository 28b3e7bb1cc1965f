"""Jobs: how far a build is. A job has the id of the gamut that it builds."""

from typing import Annotated, Any

from fastapi import APIRouter, Depends, Path, Request
from fastapi.responses import Response

from service.builds import Job
from service.documentation import EXAMPLE_ID, EXAMPLE_JOB, header, json_response, problems
from service.models import JobDescription
from service.parameters import check_query
from service.problems import Problem, ProblemError
from service.responses import JsonResponse
from service.state import service_of
from service.storage.gamuts import GamutNotStoredError

__all__ = ["job_document", "router"]

router = APIRouter(prefix="/v1/jobs", tags=["jobs"], dependencies=[Depends(check_query)])


@router.get(
    "/{job_id}",
    operation_id="describeJob",
    summary="Look how far a build is",
    description="Poll this until the state is `succeeded` or `failed`. A job that is forgotten "
    "because the service was restarted has succeeded if its gamut is there.",
    responses={
        200: json_response(
            "The job.",
            JobDescription,
            EXAMPLE_JOB,
            {"Retry-After": header("Seconds after which to look again, until it is done.", 1)},
        ),
        **problems("job-not-found", "invalid-parameter"),
    },
)
async def describe_job(
    request: Request,
    job_id: Annotated[
        str,
        Path(
            pattern="^[0-9a-f]{64}$",
            description="The job's id, which is the id of its gamut.",
            examples=[EXAMPLE_ID],
        ),
    ],
) -> Response:
    """Look how far a build is."""
    service = service_of(request)
    job = service.builds.job(job_id)
    headers = {"Cache-Control": "no-store"}
    if job is not None and not job.done.is_set():
        headers["Retry-After"] = "1"
    if job is not None and job.state != "succeeded":
        return JsonResponse(job_document(job), headers=headers)
    # Whether a build has succeeded is for the store to say: the gamut may be deleted by now.
    try:
        record = await service.library.record(job_id)
    except GamutNotStoredError:
        problem = Problem("job-not-found", f"There is no job {job_id}.", {"field": "job_id"})
        raise ProblemError(problem) from None
    document = job_document(job) if job is not None else _succeeded(job_id, record.created)
    return JsonResponse(document, headers=headers)


def job_document(job: Job) -> dict[str, Any]:
    """Return the JSON of a job."""
    succeeded = job.state == "succeeded"
    return {
        "id": job.id,
        "state": job.state,
        "stage": "" if succeeded else job.stage,
        "fraction": 1.0 if succeeded else job.fraction,
        "attempts": job.attempts,
        "created": job.created,
        "started": job.started,
        "finished": job.finished,
        "problem": None if job.problem is None else job.problem.document(),
        "links": _links(job.id, built=succeeded),
    }


def _succeeded(job_id: str, finished: str) -> dict[str, Any]:
    return {
        "id": job_id,
        "state": "succeeded",
        "stage": "",
        "fraction": 1.0,
        "attempts": 1,
        "created": None,
        "started": None,
        "finished": finished,
        "problem": None,
        "links": _links(job_id, built=True),
    }


def _links(job_id: str, *, built: bool) -> dict[str, str | None]:
    return {"self": f"/v1/jobs/{job_id}", "gamut": f"/v1/gamuts/{job_id}" if built else None}
