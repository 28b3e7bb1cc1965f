"""The shapes of the service's answers in JSON, for the OpenAPI document and its examples.

Answers are passed on as `gamutcore` described them. The models here say the same for readers and
client generators, and the tests hold both together.
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

    triangles: Annotated[int, Field(description="The most triangles that can be asked for.")]
    vertices: Annotated[int, Field(description="Vertices of the full boundary.")]
    minimum: Annotated[int, Field(description="The fewest triangles that can be asked for.")] = 4
    constructed: Annotated[
        int,
        Field(
            description="Vertices of the full boundary that are none of the colours: of empty "
            "segments and poles, and maxima that had to be turned, for `segment-maxima`."
        ),
    ] = 0


class Distances(BaseModel):
    """Distances of the points of one surface from another, in the space's unit."""

    model_config = ConfigDict(extra="allow")

    mean: Annotated[float, Field(description="Over the surface's area; an estimate.")]
    maximum: Annotated[float, Field(description="No point is further away than this.")]


class Level(BaseModel):
    """What is lost at one triangle count, against the full boundary."""

    model_config = ConfigDict(extra="allow")

    triangles: int
    volume: float
    mismatch: Annotated[
        float,
        Field(
            description="Volume of the symmetric difference, as a part of the full volume: an "
            "estimate, within 1 to 3 % on boundaries of devices; never less than the volumes "
            "differ by, nor more than `mismatch_bound`."
        ),
    ]
    mismatch_bound: Annotated[
        float,
        Field(description="What the mismatch of this level and of all finer ones here is at most."),
    ]
    distance_bound: Annotated[
        float,
        Field(
            description="What the distance between this level, or a finer one here, and the full "
            "boundary is at most: of any point of either surface, in the space's unit."
        ),
    ]
    from_full: Annotated[
        Distances, Field(description="Of the full boundary's points from the level.")
    ]
    to_full: Annotated[
        Distances, Field(description="Of the level's points from the full boundary.")
    ]


class GamutLinks(BaseModel):
    """Where the rest of a gamut is."""

    self: str
    mesh: str
    levels: str
    history: str


class GamutSummary(BaseModel):
    """A gamut in the list."""

    id: Annotated[str, Field(pattern="^[0-9a-f]{64}$")]
    created: Annotated[str, Field(description="When it was published, RFC 3339.")]
    options: GamutOptions
    counts: Counts
    volume: float
    links: GamutLinks


class GamutDescription(GamutSummary):
    """A built gamut."""

    model_config = ConfigDict(extra="allow")

    state: Annotated[Literal["ready"], Field(description="A gamut is only visible complete.")]
    history_bytes: Annotated[int, Field(description="Size of the history file.")]
    provenance: Annotated[
        dict[str, Any],
        Field(description="Format, channels, white, conditions, device model and its error, ..."),
    ]
    volume_preserved: Annotated[
        bool,
        Field(
            description="Whether the levels have this volume, to 0.00001 of it: so they do "
            "with the cost `volume`, unless the gamut is extremely thin or "
            "far from the origin. All levels count, not only those of the error curve."
        ),
    ]
    volume_error: Annotated[
        Annotated[float, Field(ge=0)] | SkipJsonSchema[None],
        Field(
            description="How much of this volume any level differs by at most. Only of costs that "
            "are to keep it: of others, `levels` has the volumes.",
            json_schema_extra=without_default,
        ),
    ] = None
    grid_step: Annotated[
        float, Field(description="All coordinates are whole multiples of this power of two.")
    ]
    area: float
    centre: Coordinates
    bounds: Annotated[list[Coordinates], Field(description="Least and largest coordinates.")]
    levels: Annotated[list[Level], Field(description="Error curve of the levels.")]


class GamutList(BaseModel):
    """A page of the list of gamuts, in the order of their ids."""

    gamuts: list[GamutSummary]
    next: Annotated[str | None, Field(description="The next page; null on the last one.")]


class ErrorCurve(BaseModel):
    """The error curve of a gamut."""

    id: str
    levels: list[Level]


class JobLinks(BaseModel):
    """Where a job and its gamut are."""

    self: str
    gamut: Annotated[str | None, Field(description="The gamut; null until it is built.")]


class ProblemDocument(BaseModel):
    """A problem, RFC 9457."""

    type: Annotated[str, Field(description="Page about this kind of problem.")]
    title: str
    status: int
    detail: Annotated[str, Field(description="What was wrong this time.")]
    code: Annotated[str, Field(description="Stable name of the kind of problem.")]
    where: Annotated[
        dict[str, Any],
        Field(description="Field, line, column, tag, row, header, ... at fault."),
    ]
    remedy: Annotated[str, Field(description="What would be right.")]


class JobDescription(BaseModel):
    """A build."""

    id: Annotated[str, Field(description="The id of the gamut that is built.")]
    state: Literal["queued", "running", "succeeded", "failed", "cancelled"]
    stage: Annotated[str, Field(description="What a running build is doing.")]
    fraction: Annotated[float, Field(ge=0, le=1, description="How much of the stage is done.")]
    attempts: Annotated[int, Field(description="How often the build was started.")]
    created: str | None
    started: str | None
    finished: str | None
    problem: Annotated[ProblemDocument | None, Field(description="Why the build failed or ended.")]
    links: JobLinks


class JobList(BaseModel):
    """A page of the list of jobs, in the order of their ids."""

    jobs: list[JobDescription]
    next: Annotated[str | None, Field(description="The next page; null on the last one.")]


class BuildCounts(BaseModel):
    """What the workers are doing."""

    queued: int
    running: int
    completed: Annotated[int, Field(description="Since the service was started.")]


class ProbeResult(BaseModel):
    """What a look at one part of the service found."""

    status: Annotated[
        Literal["ok", "degraded", "failed"],
        Field(description="Only what has failed makes the service not ready."),
    ]
    detail: str
    milliseconds: Annotated[float, Field(description="How long the look took.")]


class Readiness(BaseModel):
    """What the service is able to do right now."""

    ready: bool
    probes: Annotated[
        dict[str, ProbeResult], Field(description="Kernels, workers, queue, store, disk, ...")
    ]
    workers: int
    workers_warm: int
    builds: BuildCounts
