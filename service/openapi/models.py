"""Models of requests and answers, which document and serialise.

Routes return models of answers. The description of a gamut is validated once, when the gamut is
published, and served as stored. `gamutcore` checks requests. The options are its own model, so
the document states the same names, types, bounds, defaults and descriptions.
"""

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, create_model
from pydantic.json_schema import SkipJsonSchema
from typing_extensions import TypeAliasType

from gamutcore.arguments import Array, Coordinates, marks
from gamutcore.characterisation.recognition import format_summary
from gamutcore.options import OPTIONS, Option, Options

__all__ = [
    "Counts",
    "Distances",
    "ErrorCurve",
    "GamutDescription",
    "GamutLinks",
    "GamutList",
    "GamutName",
    "GamutOptions",
    "GamutSummary",
    "InlineSamples",
    "JobDescription",
    "JobLinks",
    "JobList",
    "Level",
    "Match",
    "MultipartSubmission",
    "NewName",
    "ProblemDocument",
    "Readiness",
    "ReferenceList",
    "ReferenceSubmission",
    "StoredDescription",
]


def _tidy(schema: dict[str, Any]) -> None:
    """Put each description on one line. Leave out defaults that are null or an object.

    Such a default depends on other members, or means that the member is absent.
    """
    for member in schema["properties"].values():
        if "description" in member:
            member["description"] = " ".join(member["description"].split())
        if isinstance(member.get("default", ""), dict | None):
            del member["default"]


class Model(BaseModel):
    """A model whose attribute docstrings describe its members."""

    model_config = ConfigDict(use_attribute_docstrings=True, json_schema_extra=_tidy)


def _documented(schema: dict[str, Any]) -> None:
    """Describe each option with its default and the data that it applies to."""
    for name, member in schema["properties"].items():
        member["description"] = OPTIONS[name].documentation
    _tidy(schema)


class GamutOptions(Options):
    """Options of a gamut. Every option has a default. Answers state all that apply."""

    model_config = ConfigDict(json_schema_extra=_documented)


class InlineSamples(Model):
    """Characterisation data as JSON. Members without an option's name are conditions."""

    model_config = ConfigDict(extra="allow")

    samples: list[list[float | str | None] | dict[str, float | str | None]]
    """One array of numbers, or one object by column name, per sample. Columns other than colours
    and device values, such as names, may contain text."""
    columns: list[str] | SkipJsonSchema[None] = None
    """Names of the columns; L*, a*, b* by default. Device values (RGB_R, CMYK_C, ...) beside the
    colour (LAB_L, XYZ_X, LCH_L, XYY_X, SPEC_380, ...) give a device model."""
    white: Coordinates | SkipJsonSchema[None] = None
    """XYZ of the white, in the scale of the samples' XYZ."""
    conditions: dict[str, str | float] | SkipJsonSchema[None] = None
    """Measurement conditions by keyword, stored in the provenance."""
    name: Annotated[str | SkipJsonSchema[None], Field(min_length=1, max_length=200)] = None
    """Name of the gamut. No part of its id."""
    options: GamutOptions = GamutOptions()
    """How the gamut is built."""


class ReferenceSubmission(Model):
    """A reference gamut, by its slug or name."""

    model_config = ConfigDict(extra="forbid")

    reference: Annotated[str, Field(examples=["display-p3"])]
    """A slug of `/v1/references`."""
    options: GamutOptions = GamutOptions()
    """How the gamut is built."""


class NewName(Model):
    """A name for a gamut."""

    model_config = ConfigDict(extra="forbid")

    name: Annotated[str, Field(min_length=1, max_length=200)]
    """Without control characters. White space at the ends is removed."""


def _form_field(option: Option) -> tuple[Any, Any]:
    """Return the annotation and the default of an option's form field.

    The field has no default, because a client that sent the defaults would contradict `options`.
    """
    kind: Any = option.kind
    described = option.documentation
    if any(isinstance(mark, Array) for mark in marks(kind)):
        # Clients send an array as one part for each item. A form has it as JSON in one part.
        kind = str
        described += f" Accepts {option.accepted}, numbers as a JSON array."
    optional = kind | SkipJsonSchema[None]  # type: ignore[misc]
    return Annotated[optional, Field(description=described)], None


_form_fields: dict[str, Any] = {name: _form_field(option) for name, option in OPTIONS.items()}
_OptionFields = create_model(
    "_OptionFields", __config__=ConfigDict(extra="forbid", json_schema_extra=_tidy), **_form_fields
)


class MultipartSubmission(_OptionFields):  # type: ignore[misc, valid-type]  # from the declarations
    """Characterisation data as a file. Options are form fields, members of `options`, or both."""

    model_config = ConfigDict(use_attribute_docstrings=True)

    file: Annotated[
        bytes,
        Field(
            description=f"A file, recognised by its content: {format_summary()}.",
            json_schema_extra={"format": "binary"},
        ),
    ]
    name: Annotated[str | SkipJsonSchema[None], Field(min_length=1, max_length=200)] = None
    """Name of the gamut. No part of its id."""
    options: GamutOptions = GamutOptions()
    """How the gamut is built. Options can also be form fields of their own names, such as
    `ink_limit=300`, with numbers and lists as in JSON."""


class Counts(Model):
    """Sizes of a gamut."""

    model_config = ConfigDict(extra="allow")

    triangles: int
    """Triangles of the full boundary."""
    vertices: int
    """Vertices of the full boundary."""
    minimum: int = 4
    """Triangles of the coarsest level."""
    constructed: int = 0
    """Vertices of the full boundary that are not input colours: empty segments, poles and moved
    maxima of `segment-maxima`."""


class Distances(Model):
    """Distances from the points of one surface to another, in the space's unit."""

    model_config = ConfigDict(extra="allow")

    mean: float
    """Mean over the surface's area; an estimate."""
    maximum: float
    """Upper bound for all points."""


class Level(Model):
    """Errors of one level against the full boundary."""

    model_config = ConfigDict(extra="allow")

    triangles: int
    volume: float
    mismatch: float
    """Volume of the symmetric difference ÷ volume of the full boundary: an estimate, within 1 to 3
    % for devices. It is at least the relative difference of the volumes, and at most
    `mismatch_bound`."""
    mismatch_bound: float
    """Upper bound of the mismatch of this level and all finer ones."""
    distance_bound: float
    """Upper bound of the distance between this level, or a finer one, and the full boundary, in
    both directions, in the space's unit."""
    from_full: Distances
    """From the full boundary to the level."""
    to_full: Distances
    """From the level to the full boundary."""


class GamutLinks(Model):
    """Addresses of the parts of a gamut."""

    self: str
    mesh: str
    levels: str
    history: str


GamutId = Annotated[str, Field(pattern="^[0-9a-f]{64}$")]


class GamutSummary(Model):
    """A gamut in the list."""

    id: GamutId
    name: str
    """Given by a client, else by the data. It may change."""
    created: str
    """Time of publication, RFC 3339."""
    channels: list[str]
    """Device channels; empty for bare colours."""
    options: GamutOptions
    counts: Counts
    volume: float
    links: GamutLinks


Chromaticity = TypeAliasType(
    "Chromaticity",
    Annotated[list[float], Field(min_length=2, max_length=2, description="Chromaticity x, y.")],
)


class ChromaticityCoverage(Model):
    """Covered part of the chromaticities of a standard, from 0 to 1."""

    bt709: float
    display_p3: Annotated[float, Field(alias="display-p3")]
    bt2020: float
    adobe_rgb_1998: Annotated[float, Field(alias="adobe-rgb-1998")]


class ChromaticityFigures(Model):
    """Figures in one chromaticity diagram."""

    area: float
    of_bt709: float
    """Area ÷ area of BT.709."""
    coverage: ChromaticityCoverage


class ChromaticityDescription(Model):
    """Chromaticities of a gamut, as the device shows them, before any adaptation."""

    basis: Literal["primaries", "colours"]
    """The triangle of the primaries, or the hull of the gamut's own colours of at least 1 % of the
    luminance of white."""
    corners: list[Chromaticity]
    """Corners of the polygon in CIE 1931 x, y."""
    xy: ChromaticityFigures
    """In the CIE 1931 xy diagram."""
    uv: ChromaticityFigures
    """In the CIE 1976 u′v′ diagram."""


class _PublishedGamut(GamutSummary):
    """What the service adds to the description of a gamut."""

    state: Literal["ready"]
    """A gamut is visible only when it is complete."""
    history_bytes: int
    """Size of the history file."""


class StoredDescription(Model):
    """The description of a gamut as the core makes it. It is validated before it is stored."""

    model_config = ConfigDict(extra="allow")

    id: GamutId
    options: GamutOptions
    counts: Counts
    volume: float
    provenance: dict[str, Any]
    """Format, channels, white, conditions, device model with its error, ..."""
    volumes: dict[str, Any] | SkipJsonSchema[None] = None
    """Volumes with the intents `relative` and `absolute`, or `own` for colours without them: each
    with `volume` and `times_srgb`. `srgb` is the volume of sRGB in the space. The volume of the
    other intent is that of the boundary with its vertices converted."""
    device_surface_volume: Annotated[float, Field(ge=0)] | SkipJsonSchema[None] = None
    """Volume that the sampled surface of the device encloses, for devices with a model or profile.
    A warning names a difference of more than 0.5 % from `volume`."""
    volume_preserved: bool
    """Whether all levels have this volume to a relative error of 0.00001. True for the cost
    `volume`, unless the gamut is extremely thin or far from the origin."""
    volume_error: Annotated[float, Field(ge=0)] | SkipJsonSchema[None] = None
    """Largest relative difference between this volume and that of any level. Only for costs that
    preserve the volume; for others, `levels` has the volumes."""
    grid_step: float
    """All coordinates are integer multiples of this power of two."""
    boundary_error: Annotated[float, Field(ge=0)] | SkipJsonSchema[None] = None
    """Largest distance by which the full boundary misses colours on the surface of the device."""
    area: float
    centre: Coordinates
    bounds: list[Coordinates]
    """Smallest and largest coordinates."""
    distinguishable_colours: Annotated[float, Field(ge=0)] | SkipJsonSchema[None] = None
    """Volume in units of ΔE_ITP (ITU-R BT.2124), of which 1 is a just noticeable difference. For
    the spaces ICtCp and ITP. A million of them is the unit MDC."""
    chromaticity: ChromaticityDescription | SkipJsonSchema[None] = None
    """Area and coverage without lightness; missing if the chromaticities have no area."""
    levels: list[Level]
    """Error curve of the levels."""


class GamutDescription(StoredDescription, _PublishedGamut):
    """A gamut."""


class GamutName(Model):
    """The name of a gamut."""

    id: str
    name: str


class GamutList(Model):
    """A page of the list of gamuts, in the order of their ids."""

    gamuts: list[GamutSummary]
    next: str | None
    """Address of the next page; null on the last page."""


class ErrorCurve(Model):
    """The error curve of a gamut."""

    id: str
    levels: list[Level]


class JobLinks(Model):
    """Addresses of a job and its gamut."""

    self: str
    gamut: str | None
    """Address of the gamut; null until it is built."""


class ProblemDocument(Model):
    """A problem (RFC 9457)."""

    type: str
    """Page about the kind of problem."""
    title: str
    status: int
    detail: str
    """Description of this occurrence."""
    code: str
    """Stable code of the kind of problem."""
    where: dict[str, Any]
    """Place of the fault: field, line, column, tag, row, header, ..."""
    remedy: str
    """How to correct it."""


class JobDescription(Model):
    """A build."""

    id: str
    """Id of the gamut that was asked for. A version of the service with another algorithm gives the
    gamut another id; `links.gamut` is always right."""
    state: Literal["queued", "running", "succeeded", "failed", "cancelled"]
    stage: str
    """Stage of a running build."""
    fraction: Annotated[float, Field(ge=0, le=1)]
    """Finished part of the stage."""
    attempts: int
    """Number of attempts."""
    created: str | None
    started: str | None
    finished: str | None
    problem: ProblemDocument | None
    """Why the build failed or was cancelled."""
    links: JobLinks


class JobList(Model):
    """A page of the list of jobs, in the order of their ids."""

    jobs: list[JobDescription]
    next: str | None
    """Address of the next page; null on the last page."""


class ReferenceLinks(Model):
    """Address of a reference gamut."""

    gamut: str


class ReferenceGamut(Model):
    """A reference gamut."""

    slug: str
    """Accepted wherever the id of a gamut is."""
    name: str
    aliases: list[str]
    kind: Literal["rgb", "surface", "optimal"]
    """RGB colour space, real surface colours, or optimal colours."""
    white: Chromaticity
    illuminant: str
    """Name of the white."""
    observer: Literal[2, 10]
    """Standard observer, in degrees."""
    primaries: list[Chromaticity] | None
    """Red, green and blue; null for gamuts without primaries."""
    peak_luminance: float | None
    """In cd/m²; null for gamuts relative to their white."""
    source: str
    links: ReferenceLinks


class MatchTolerance(Model):
    """Which colours a gamut prints."""

    delta_e_2000: float | None
    """Largest ΔE00 from the nearest colour; null if colours inside and at the edge count."""
    edge_width: float
    """Largest distance from the surface of a colour at the edge."""


class MatchedColours(Model):
    """The colours: one entry of each array per colour."""

    name: list[str]
    point: list[Annotated[list[float], Field(min_length=3, max_length=3)]]
    """In the space of the gamuts."""
    printed_by: list[int]
    """Number of gamuts that print the colour."""
    best: list[str]
    """Name of the gamut that comes nearest; of several, the one with most room."""


class MatchedGamut(Model):
    """The answer of one gamut: one entry of each array per colour."""

    id: str
    name: str
    """Other than that of all other gamuts of the answer."""
    share: float | None
    """Share of the colours that it prints, 0 to 1; null without colours."""
    mean_delta_e_2000: float | None
    """Over all colours, 0 for those in gamut."""
    percentile_95_delta_e_2000: float | None
    worst: list[str]
    """Names of up to three colours that it misses most."""
    triangles: int
    """Of the level that answers."""
    conditions: dict[str, Any]
    """Intent, ink limits, white and space, as in the answers to queries."""
    prints: list[bool]
    position: list[Literal["inside", "edge", "outside"]]
    distance: list[float]
    """From the surface, negative inside. ΔE76 in CIELAB."""
    delta_e_2000: list[float] | SkipJsonSchema[None] = None
    """From the nearest colour in gamut; 0 in gamut. Missing with `delta_e=false`."""
    channels: list[str] | SkipJsonSchema[None] = None
    """With `recipes=true`, for gamuts with a device model, as the members that follow."""
    device: list[list[float]] | SkipJsonSchema[None] = None
    """Device values from 0 to 1."""
    recipe_delta_e_2000: list[float] | SkipJsonSchema[None] = None
    """ΔE00 between the colour and that of the device values."""
    recipe_point: list[list[float]] | SkipJsonSchema[None] = None
    """Colour of the device values."""
    recipe_inside: list[bool] | SkipJsonSchema[None] = None
    """Whether the colour is in gamut."""


class MatchGroup(Model):
    """Gamuts that together print most."""

    gamuts: list[str]
    """Names of two or three."""
    printed: int
    """Number of colours that at least one of them prints."""
    exact: bool
    """Whether all pairs or triples were compared. Otherwise gamuts were added one by one."""


class Match(Model):
    """Which of several gamuts print colours, and how near the others come."""

    space: str
    tolerance: MatchTolerance
    reading: str | SkipJsonSchema[None] = None
    """For tables: what was understood, in a sentence."""
    colours: MatchedColours
    gamuts: list[MatchedGamut]
    """In the order of the request."""
    together: list[MatchGroup]
    warnings: list[str]
    """Reasons why the answer may mislead, each once for all gamuts."""


class MissingReference(Model):
    """An RGB colour space without a gamut."""

    name: str
    reason: str


class ReferenceList(Model):
    """The reference gamuts."""

    references: list[ReferenceGamut]
    not_offered: list[MissingReference]
    """RGB colour spaces that have no gamut."""


class BuildCounts(Model):
    """Numbers of builds."""

    queued: int
    running: int
    completed: int
    """Since the start of the service."""


class ProbeResult(Model):
    """Result of one probe."""

    status: Literal["ok", "degraded", "failed"]
    """Only `failed` makes the service not ready."""
    detail: str
    milliseconds: float
    """Duration of the check."""


class Readiness(Model):
    """Readiness of the service."""

    ready: bool
    probes: dict[str, ProbeResult]
    """Kernels, workers, queue, store, disk, ..."""
    workers: int
    workers_warm: int
    builds: BuildCounts
