"""Waiting for a build: the job in the time that the client gives, or the answer with the job."""

from __future__ import annotations

from typing import TYPE_CHECKING

from service.http.negotiation import preference
from service.http.request_context import timed
from service.problems.problem import JsonResponse, Problem, ProblemError
from service.routes.jobs import job_description

if TYPE_CHECKING:
    from collections.abc import Sequence

    from service.container import ServiceContainer
    from service.jobs.book import JobDocument

__all__ = ["wait_for_build"]


async def wait_for_build(
    service: ServiceContainer, job: JobDocument, prefer: Sequence[str], waited: float = 0.0
) -> tuple[JsonResponse | None, dict[str, str]]:
    """Wait for a job as long as the client wants to.

    Parameters
    ----------
    service : ServiceContainer
    job : JobDocument
        An accepted job.
    prefer : sequence of str
        The values of ``Prefer``.
    waited : float, optional
        Seconds for which the client has waited for other builds.

    Returns
    -------
    response : JsonResponse or None
        The job with 202 if it has not ended; None if the gamut is built.
    headers : dict
        ``Preference-Applied``, if a preference was applied.

    Raises
    ------
    ProblemError
        The build failed or was cancelled.
    """
    settings = service.settings
    wanted = preference(prefer)
    with timed("build"):
        if wanted.wait is None and not wanted.respond_async:
            # On a first start, nothing can be built until the kernels are compiled.
            await service.kernels.wait("default", settings.max_client_wait)
        seconds = wanted.seconds(settings.client_wait, settings.max_client_wait)
        job = await service.builds.wait(job.id, max(0.0, seconds - waited)) or job
    headers = {}
    applied = wanted.applied_field(answered_async=not job.final, longest=settings.max_client_wait)
    if applied:
        headers["Preference-Applied"] = applied
    if not job.final:
        answer = {
            **headers,
            "Location": f"/v1/jobs/{job.id}",
            "Retry-After": str(service.builds.retry_after(job)),
            "Cache-Control": "no-store",
        }
        return JsonResponse(job_description(job), 202, answer), headers
    if job.problem is not None:
        raise ProblemError(Problem.from_mapping(job.problem))
    return None, headers
