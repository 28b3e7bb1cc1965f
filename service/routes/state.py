"""Whether the service lives and whether it is ready, for load balancers and people."""

from fastapi import APIRouter, Request
from fastapi.responses import PlainTextResponse, Response

from service.documentation import EXAMPLE_READINESS, header, json_response, problems
from service.models import Readiness
from service.problems import Problem, ProblemError
from service.responses import JsonResponse
from service.state import Service, service_of

__all__ = ["readiness", "router"]

router = APIRouter(tags=["state"])

_NO_STORE = {"Cache-Control": "no-store"}


@router.get(
    "/livez",
    operation_id="live",
    summary="Tell whether the process lives",
    description="Answers at once whatever the service does; touches neither disk nor workers.",
    response_class=PlainTextResponse,
    responses={
        200: {
            "description": "It lives.",
            "content": {"text/plain": {"examples": {"example": {"value": "live\n"}}}},
            "headers": {"Cache-Control": header("It is about now.", "no-store")},
        },
        **problems(guarded=False),
    },
)
async def live() -> Response:
    """Tell whether the process lives."""
    return PlainTextResponse("live\n", headers=_NO_STORE)


@router.get(
    "/readyz",
    operation_id="ready",
    summary="Tell whether the service is ready",
    description="Ready once every build worker is warm and the kernels are loaded. Meshes of "
    "stored gamuts are served before that as well, the first ones slower.",
    responses={
        200: json_response(
            "It is ready.",
            Readiness,
            EXAMPLE_READINESS,
            {"Cache-Control": header("It is about now.", "no-store")},
        ),
        **problems("not-ready", guarded=False),
    },
)
async def ready(request: Request) -> Response:
    """Tell whether the service is ready."""
    service = service_of(request)
    state = readiness(service)
    if not service.ready:
        headers = {"Retry-After": "1"}
        raise ProblemError(
            Problem("not-ready", "The service is warming up.", where=state, headers=headers)
        )
    return JsonResponse(state, headers=_NO_STORE)


def readiness(service: Service) -> dict[str, object]:
    """Return the JSON of the service's state."""
    builds = service.builds.facts()
    return {
        "ready": service.ready,
        "workers": builds.workers,
        "workers_warm": builds.warm_workers,
        "builds": {
            "queued": builds.queued,
            "running": builds.running,
            "completed": builds.completed,
        },
    }
