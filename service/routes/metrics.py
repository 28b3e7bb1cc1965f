"""The figures of this process, for Prometheus and whoever reads its formats."""

import asyncio
from concurrent.futures import ThreadPoolExecutor

from fastapi import APIRouter, Request
from fastapi.responses import Response

from service.container import service_of
from service.openapi.documentation import header, problems
from service.telemetry.metrics_endpoint import exposition

__all__ = ["router"]

router = APIRouter(tags=["state"])

_THREAD = ThreadPoolExecutor(1, thread_name_prefix="metrics")
"""The shared threads may all be waiting for a store that does not answer, which is when somebody
looks at the figures."""

_EXAMPLE = """\
# HELP gamut_builds_total Builds that ended: succeeded, cancelled, crashed (an attempt), or a \
problem's code.
# TYPE gamut_builds_total counter
gamut_builds_total{outcome="succeeded"} 12.0
"""


def _content(example: str) -> dict[str, object]:
    return {"schema": {"type": "string"}, "examples": {"counter": {"value": example}}}


@router.get(
    "/metrics",
    operation_id="readMetrics",
    summary="Read the figures of this process",
    description="In Prometheus' text format, or in OpenMetrics for who asks for it with `Accept`. "
    "Each replica tells of itself.",
    response_class=Response,
    responses={
        200: {
            "description": "The figures.",
            "content": {
                "text/plain": _content(_EXAMPLE),
                "application/openmetrics-text": _content(
                    _EXAMPLE.replace("gamut_builds_total B", "gamut_builds B").replace(
                        "gamut_builds_total counter", "gamut_builds counter"
                    )
                    + "# EOF\n"
                ),
            },
            "headers": {"Cache-Control": header("It is about now.", "no-store")},
        },
        **problems(),
    },
)
async def read_metrics(request: Request) -> Response:
    """Read the figures of this process."""
    accept = ",".join(request.headers.getlist("accept"))
    loop = asyncio.get_running_loop()
    body, media_type = await loop.run_in_executor(_THREAD, exposition, service_of(request), accept)
    headers = {"Cache-Control": "no-store", "Vary": "Accept", "Content-Type": media_type}
    return Response(body, headers=headers)
