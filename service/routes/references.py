"""Route of the list of reference gamuts."""

from functools import cache
from typing import Annotated

from fastapi import APIRouter, Depends, Query, Request
from fastapi.responses import Response

from gamutcore.names import ranked
from gamutcore.references import NOT_OFFERED, REFERENCES, Reference, search_references
from service.http.representations import compress_response, conditional
from service.http.requests import check_query
from service.openapi.documentation import EXAMPLE_REFERENCES, header, json_response, problems
from service.openapi.models import (
    MissingReference,
    ReferenceGamut,
    ReferenceLinks,
    ReferenceList,
)
from service.problems.problem import JsonResponse
from service.storage.gamut_names import LONGEST_NAME

__all__ = ["router"]

router = APIRouter(prefix="/v1/references", tags=["gamuts"], dependencies=[Depends(check_query)])


@router.get(
    "",
    operation_id="listReferences",
    summary="List the reference gamuts",
    description="RGB colour spaces, Pointer's gamut and the optimal colours. A slug is accepted "
    "wherever the id of a gamut is, with the options of the build as query parameters. The gamut "
    "is built on first use. With `name`, only what this name may mean, the most likely first.",
    responses={
        200: json_response(
            "The reference gamuts.",
            ReferenceList,
            EXAMPLE_REFERENCES,
            {"ETag": header("Strong entity tag: the SHA-256 of the content.", '"4f1d9c07"')},
        ),
        304: {"description": "The client has the current content (If-None-Match)."},
        **problems("precondition-failed", "invalid-parameter"),
    },
)
async def list_references(
    request: Request,
    name: Annotated[
        str,
        Query(
            description="A name in any spelling, such as `Rec. 2020`, or a part of one.",
            max_length=LONGEST_NAME,
            examples=["Rec. 2020"],
        ),
    ] = "",
) -> Response:
    """List the reference gamuts."""
    document = _searched(name) if name.strip() else _all()
    answer: Response = JsonResponse(document, headers={"Cache-Control": "no-cache"})
    answer = compress_response(answer, request.headers.getlist("accept-encoding"))
    return conditional(answer, request.headers)


@cache
def _entries() -> dict[str, ReferenceGamut]:
    return {slug: _entry(each) for slug, each in REFERENCES.items()}


_NOT_OFFERED = [MissingReference(name=name, reason=reason) for name, reason in NOT_OFFERED.items()]


def _all() -> ReferenceList:
    return ReferenceList(references=list(_entries().values()), not_offered=_NOT_OFFERED)


def _searched(name: str) -> ReferenceList:
    return ReferenceList(
        references=[_entries()[each.slug] for each in search_references(name)],
        not_offered=ranked(name, ((each, (each.name,)) for each in _NOT_OFFERED)),
    )


def _entry(reference: Reference) -> ReferenceGamut:
    return ReferenceGamut(
        slug=reference.slug,
        name=reference.name,
        aliases=list(reference.aliases),
        kind=reference.kind,
        white=list(reference.white),
        illuminant=reference.illuminant,
        observer=reference.observer,
        primaries=[list(each) for each in reference.primaries] or None,
        peak_luminance=reference.peak,
        source=reference.source,
        links=ReferenceLinks(gamut=f"/v1/gamuts/{reference.slug}"),
    )
