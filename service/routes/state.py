"""Routes of liveness and readiness."""

from fastapi import APIRouter, Request
from fastapi.responses import PlainTextResponse, Response

from service.container import ServiceContainer, service_of
from service.openapi.documentation import EXAMPLE_READINESS, header, json_response, problems
from service.openapi.models import BuildCounts, ProbeResult, Readiness
from service.problems.problem import JsonResponse, Problem, ProblemError
from service.readiness import Report

__all__ = ["readiness", "router"]

router = APIRouter(tags=["state"])

_NO_STORE = {"Cache-Control": "no-store"}


@router.get(
    "/livez",
    operation_id="live",
    summary="Check that the process is alive",
    description="Answers at once, without access to the disk or the workers.",
    response_class=PlainTextResponse,
    responses={
        200: {
            "description": "The process is alive.",
            "content": {"text/plain": {"examples": {"example": {"value": "live\n"}}}},
            "headers": {"Cache-Control": header("The state changes.", "no-store")},
        },
        **problems(guarded=False),
    },
)
async def live() -> Response:
    """Check that the process is alive."""
    return PlainTextResponse("live\n", headers=_NO_STORE)


@router.get(
    "/readyz",
    operation_id="ready",
    summary="Check that the service is ready",
    description="Ready once every build worker is warm and the kernels are loaded, and as long as "
    "a store directory can be written. Each probe has a status: `failed` makes the service not "
    "ready; `degraded` reports a fault that other replicas share, such as a full "
    "queue or a bucket that does not answer, or a worker that restarts.",
    responses={
        200: json_response(
            "The service is ready.",
            Readiness,
            EXAMPLE_READINESS,
            {"Cache-Control": header("The state changes.", "no-store")},
        ),
        **problems("not-ready", guarded=False),
    },
)
async def ready(request: Request) -> Response:
    """Check that the service is ready."""
    service = service_of(request)
    report = await service.readiness.report()
    state = readiness(service, report)
    if not report.ready:
        headers = {"Retry-After": "1"}
        detail = f"The service is not ready: {report.wrong}."
        raise ProblemError(Problem("not-ready", detail, where=state.model_dump(), headers=headers))
    return JsonResponse(state, headers=_NO_STORE)


def readiness(service: ServiceContainer, report: Report) -> Readiness:
    """Return the service's state."""
    facts = service.builds.facts()
    return Readiness(
        ready=report.ready,
        probes={
            probe.name: ProbeResult(
                status=probe.status,
                detail=probe.detail,
                milliseconds=round(1000 * probe.seconds, 3),
            )
            for probe in report.probes
        },
        workers=facts.workers,
        workers_warm=facts.warm_workers,
        builds=BuildCounts(queued=facts.queued, running=facts.running, completed=facts.completed),
    )
