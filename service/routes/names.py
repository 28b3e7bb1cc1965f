"""Route of the names of gamuts."""

import asyncio

from fastapi import APIRouter, Depends, Request
from fastapi.responses import Response

from service.access.ownership import check_owner
from service.container import service_of
from service.openapi.documentation import EXAMPLE_ID, NAME_BODY, json_response, problems
from service.openapi.models import GamutName
from service.problems.problem import JsonResponse
from service.routes.dependencies import GamutId, GamutRoute, check_gamut_query
from service.routes.naming import refuse_reference
from service.routes.submission import submitted_name

__all__ = ["router"]

router = APIRouter(
    prefix="/v1/gamuts",
    tags=["gamuts"],
    route_class=GamutRoute,
    dependencies=[Depends(check_gamut_query)],
)


@router.put(
    "/{gamut_id}/name",
    operation_id="nameGamut",
    summary="Name a gamut",
    description="Replaces the name of the gamut. The last writer's name counts, on all replicas. "
    "The name is no part of the id, the history or any mesh. Until a name is given, it is the "
    "data's descriptor, the description of the profile, or the name of the file.",
    responses={
        200: json_response(
            "The name was stored.", GamutName, {"id": EXAMPLE_ID, "name": "Coated offset"}
        ),
        **problems(
            "malformed-body",
            "request-timeout",
            "body-too-large",
            "unsupported-media-type",
            "invalid-body",
            "invalid-name",
            "gamut-not-found",
            "gamut-rebuilding",
            "reference-read-only",
            "built-by-another",
            "invalid-parameter",
            "share-exceeded",
            "spool-full",
            "scratch-full",
            "store-unavailable",
            "storage-full",
        ),
    },
    openapi_extra={"requestBody": NAME_BODY},
)
async def name_gamut(request: Request, gamut_id: GamutId) -> Response:
    """Name a gamut."""
    service = service_of(request)
    name = await submitted_name(request, service.spool)
    refuse_reference(await service.library.record(gamut_id))
    await check_owner(request, service.store, gamut_id)
    await asyncio.to_thread(service.store.names.give, gamut_id, name)
    await service.meshes.rename(gamut_id)
    return JsonResponse({"id": gamut_id, "name": name}, headers={"Cache-Control": "no-store"})
