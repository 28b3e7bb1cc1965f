"""Models of the answers, for the OpenAPI document.

Answers are sent as `gamutcore` described them. The models document the same members, and tests
compare both.
"""

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field
from pydantic.json_schema import SkipJsonSchema

from service.openapi.request_models import Coordinates, GamutOptions, without_default

__all__ = [
    "Counts",
    "Distances",
    "ErrorCurve",
    "GamutDescription",
    "GamutLinks",
    "GamutList",
    "GamutSummary",
    "JobDescription",
    "JobLinks",
    "JobList",
    "Level",
    "ProblemDocument",
    "Readiness",
]


class Counts(BaseModel):
    """Sizes of a gamut."""

    model_config = ConfigDict(extra="allow")

    triangles: Annotated[int, Field(description="Triangles of the full boundary.")]
    vertices: Annotated[int, Field(description="Vertices of the full boundary.")]
    minimum: Annotated[int, Field(description="Triangles of the coarsest level.")] = 4
    constructed: Annotated[
        int,
        Field(
            description="Vertices of the full boundary that are not input colours: empty segments, "
            "poles and moved maxima of `segment-maxima`."
        ),
    ] = 0


class Distances(BaseModel):
    """Distances from the points of one surface to another, in the space's unit."""

    model_config = ConfigDict(extra="allow")

    mean: Annotated[float, Field(description="Mean over the surface's area; an estimate.")]
    maximum: Annotated[float, Field(description="Upper bound for all points.")]


class Level(BaseModel):
    """Errors of one level against the full boundary."""

    model_config = ConfigDict(extra="allow")

    triangles: int
    volume: float
    mismatch: Annotated[
        float,
        Field(
            description="Volume of the symmetric difference ÷ volume of the full boundary: an "
            "estimate, within 1 to 3 % for devices. It is at least the relative difference of "
            "the volumes, and at most `mismatch_bound`."
        ),
    ]
    mismatch_bound: Annotated[
        float,
        Field(description="Upper bound of the mismatch of this level and all finer ones."),
    ]
    distance_bound: Annotated[
        float,
        Field(
            description="Upper bound of the distance between this level, or a finer one, and the "
            "full boundary, in both directions, in the space's unit."
        ),
    ]
    from_full: Annotated[Distances, Field(description="From the full boundary to the level.")]
    to_full: Annotated[Distances, Field(description="From the level to the full boundary.")]


class GamutLinks(BaseModel):
    """Addresses of the parts of a gamut."""

    self: str
    mesh: str
    levels: str
    history: str


class GamutSummary(BaseModel):
    """A gamut in the list."""

    id: Annotated[str, Field(pattern="^[0-9a-f]{64}$")]
    created: Annotated[str, Field(description="Time of publication, RFC 3339.")]
    options: GamutOptions
    counts: Counts
    volume: float
    links: GamutLinks


class GamutDescription(GamutSummary):
    """A gamut."""

    model_config = ConfigDict(extra="allow")

    state: Annotated[
        Literal["ready"], Field(description="A gamut is visible only when it is complete.")
    ]
    history_bytes: Annotated[int, Field(description="Size of the history file.")]
    provenance: Annotated[
        dict[str, Any],
        Field(description="Format, channels, white, conditions, device model with its error, ..."),
    ]
    volume_preserved: Annotated[
        bool,
        Field(
            description="Whether all levels have this volume to a relative error of 0.00001. "
            "True for the cost `volume`, unless the gamut is extremely thin or far from the "
            "origin."
        ),
    ]
    volume_error: Annotated[
        Annotated[float, Field(ge=0)] | SkipJsonSchema[None],
        Field(
            description="Largest relative difference between this volume and that of any level. "
            "Only for costs that preserve the volume; for others, `levels` has the volumes.",
            json_schema_extra=without_default,
        ),
    ] = None
    grid_step: Annotated[
        float, Field(description="All coordinates are integer multiples of this power of two.")
    ]
    area: float
    centre: Coordinates
    bounds: Annotated[list[Coordinates], Field(description="Smallest and largest coordinates.")]
    levels: Annotated[list[Level], Field(description="Error curve of the levels.")]


class GamutList(BaseModel):
    """A page of the list of gamuts, in the order of their ids."""

    gamuts: list[GamutSummary]
    next: Annotated[
        str | None, Field(description="Address of the next page; null on the last page.")
    ]


class ErrorCurve(BaseModel):
    """The error curve of a gamut."""

    id: str
    levels: list[Level]


class JobLinks(BaseModel):
    """Addresses of a job and its gamut."""

    self: str
    gamut: Annotated[str | None, Field(description="Address of the gamut; null until it is built.")]


class ProblemDocument(BaseModel):
    """A problem (RFC 9457)."""

    type: Annotated[str, Field(description="Page about the kind of problem.")]
    title: str
    status: int
    detail: Annotated[str, Field(description="Description of this occurrence.")]
    code: Annotated[str, Field(description="Stable code of the kind of problem.")]
    where: Annotated[
        dict[str, Any],
        Field(description="Place of the fault: field, line, column, tag, row, header, ..."),
    ]
    remedy: Annotated[str, Field(description="How to correct it.")]


class JobDescription(BaseModel):
    """A build."""

    id: Annotated[str, Field(description="Id of the gamut.")]
    state: Literal["queued", "running", "succeeded", "failed", "cancelled"]
    stage: Annotated[str, Field(description="Stage of a running build.")]
    fraction: Annotated[float, Field(ge=0, le=1, description="Finished part of the stage.")]
    attempts: Annotated[int, Field(description="Number of attempts.")]
    created: str | None
    started: str | None
    finished: str | None
    problem: Annotated[
        ProblemDocument | None, Field(description="Why the build failed or was cancelled.")
    ]
    links: JobLinks


class JobList(BaseModel):
    """A page of the list of jobs, in the order of their ids."""

    jobs: list[JobDescription]
    next: Annotated[
        str | None, Field(description="Address of the next page; null on the last page.")
    ]


class BuildCounts(BaseModel):
    """Numbers of builds."""

    queued: int
    running: int
    completed: Annotated[int, Field(description="Since the start of the service.")]


class ProbeResult(BaseModel):
    """Result of one probe."""

    status: Annotated[
        Literal["ok", "degraded", "failed"],
        Field(description="Only `failed` makes the service not ready."),
    ]
    detail: str
    milliseconds: Annotated[float, Field(description="Duration of the check.")]


class Readiness(BaseModel):
    """Readiness of the service."""

    ready: bool
    probes: Annotated[
        dict[str, ProbeResult], Field(description="Kernels, workers, queue, store, disk, ...")
    ]
    workers: int
    workers_warm: int
    builds: BuildCounts
