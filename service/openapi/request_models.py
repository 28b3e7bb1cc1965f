"""The shapes of what is sent to the service, for the OpenAPI document and its examples.

Requests are checked by `gamutcore`, which knows what an option may be. The models here say the same
for readers and client generators, and the tests hold both together.
"""

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field
from pydantic.json_schema import SkipJsonSchema

from gamutcore.colours.device.model import DEVICE_MODELS
from gamutcore.colours.spaces import SPACES
from gamutcore.colours.spaces.appearance_model import SURROUNDS
from gamutcore.colours.spaces.white_points import ADAPTATIONS, WHITES
from gamutcore.colours.spectral import ILLUMINANTS
from gamutcore.decimation import COSTS

__all__ = ["GamutOptions", "InlineSamples", "MultipartSubmission", "Triple", "without_default"]

Triple = Annotated[list[float], Field(min_length=3, max_length=3)]


def without_default(schema: dict[str, Any]) -> None:
    """Take out the null that stands for a default that depends on the boundary."""
    del schema["default"]


def _without_nulls(schema: dict[str, Any]) -> None:
    """The same in the default of all options."""
    schema["default"] = {k: v for k, v in schema["default"].items() if v is not None}


class GamutOptions(BaseModel):
    """How a gamut is built. Every option has a default; answers state all that apply."""

    model_config = ConfigDict(extra="forbid")

    space: Annotated[
        Literal[tuple(SPACES)],  # type: ignore[valid-type]
        Field(
            description="Colour space that the boundary lives in. An option that only other spaces "
            "have is refused, and not in the answer."
        ),
    ] = "CIELAB"
    boundary: Annotated[
        Literal["modified-convex-hull", "convex-hull", "segment-maxima", "usv"],
        Field(
            description="How the colours are wrapped. An option that only other boundaries have is "
            "refused, and not in the answer."
        ),
    ] = "modified-convex-hull"
    gamma: Annotated[
        Annotated[float, Field(gt=0, le=1)] | SkipJsonSchema[None],
        Field(
            description="Power that radii are raised to before the hull is taken; 1 is the convex "
            "hull, small values follow the colours into concave places. 0.2 unless given for "
            "`modified-convex-hull`, 0.05 for `usv`, always 1 for `convex-hull`.",
            json_schema_extra=without_default,
        ),
    ] = None
    segments: Annotated[
        tuple[Annotated[int, Field(ge=2, le=180)], Annotated[int, Field(ge=3, le=360)]]
        | SkipJsonSchema[None],
        Field(
            description="Polar and azimuth segments of `segment-maxima`; [16, 16] unless given.",
            json_schema_extra=without_default,
        ),
    ] = None
    basis: Annotated[
        Literal["tetrahedron", "octahedron", "icosahedron"] | SkipJsonSchema[None],
        Field(
            description="The body whose faces `usv` splits into segments; `icosahedron` unless "
            "given.",
            json_schema_extra=without_default,
        ),
    ] = None
    subdivisions: Annotated[
        Annotated[int, Field(ge=0, le=7)] | SkipJsonSchema[None],
        Field(
            description="How often `usv` splits each face into four; 4 unless given. A tetrahedron "
            "that is not split has 4 segments, whose farthest colours seldom surround the centre.",
            json_schema_extra=without_default,
        ),
    ] = None
    centre: Annotated[
        Literal["auto"] | Triple,
        Field(description="Point that radii are taken from, in the space; inside the gamut."),
    ] = "auto"
    cost: Annotated[
        str,
        Field(
            description="What decides which edge is collapsed next: `volume` preserves the volume "
            "at every level, `finest` orders by the mismatch and moves vertices as well, which is "
            "more accurate where levels are coarse and takes four to nine times as long to "
            "decimate, `quadric` is the published error metric.",
            json_schema_extra={"enum": list(COSTS)},
        ),
    ] = "volume"
    surface_samples: Annotated[
        int, Field(ge=1, description="How many colours a device model is asked for.")
    ] = 100_000
    intent: Annotated[
        Literal["relative", "absolute", "perceptual", "saturation"],
        Field(description="Rendering intent that an ICC profile is evaluated with."),
    ] = "relative"
    source: Annotated[
        Literal["transforms", "measurements", "boundary"] | SkipJsonSchema[None],
        Field(
            description="What of an ICC profile is used: its transforms unless given, the "
            "measurements that it carries (tags targ, CIED with DevD), or the gamut boundary that "
            "an iccMAX profile describes (tags gbd0 to gbd3).",
            json_schema_extra=without_default,
        ),
    ] = None
    device_model: Annotated[
        Literal[DEVICE_MODELS] | SkipJsonSchema[None],  # type: ignore[valid-type]
        Field(
            description="What measured samples with device values get: `interpolation`, n-linear, "
            "of complete grids only, or a `fit` of radial basis functions. Unless given, complete "
            "grids are interpolated and other samples fitted. Refused for all other data.",
            json_schema_extra=without_default,
        ),
    ] = None
    ink_limit: Annotated[
        Annotated[float, Field(gt=0, le=1500)] | SkipJsonSchema[None],
        Field(
            description="Largest sum of all inks in per cent, such as 300; no limit unless given. "
            "For devices with inks only.",
            json_schema_extra=without_default,
        ),
    ] = None
    black_limit: Annotated[
        Annotated[float, Field(ge=0, le=100)] | SkipJsonSchema[None],
        Field(
            description="Most of the black ink in per cent; no limit unless given. For devices "
            "with a black ink only.",
            json_schema_extra=without_default,
        ),
    ] = None
    observer: Annotated[
        Literal[2, 10] | SkipJsonSchema[None],
        Field(
            description="Standard observer that spectra are integrated with, in degrees; unless "
            "given, what data of spectra alone states, or 2. Refused for data without spectra, "
            "unless it is the data's own.",
            json_schema_extra=without_default,
        ),
    ] = None
    illuminant: Annotated[
        Literal[ILLUMINANTS] | SkipJsonSchema[None],  # type: ignore[valid-type]
        Field(
            description="What reflectance spectra are seen under; unless given, what data of "
            "spectra alone states, or D50. Refused for data without spectra, unless it is the "
            "data's own.",
            json_schema_extra=without_default,
        ),
    ] = None
    condition: Annotated[
        Annotated[str, Field(min_length=1, max_length=80)] | SkipJsonSchema[None],
        Field(
            description="The measurement condition to be used of data that has several, such as "
            "`M0`, `M1` or `M2` of ISO 13655; a problem of the code `measurement-condition` names "
            "those that there are.",
            json_schema_extra=without_default,
        ),
    ] = None
    reference_white: Annotated[
        Literal[tuple(WHITES)] | Triple | SkipJsonSchema[None],  # type: ignore[valid-type]
        Field(
            description="The space's white, which colours are adapted to: a name, or X, Y, Z in "
            "any scale. D50 unless given for `CIELAB`, `CIELUV`, `CIEXYZ`, `CAM16-UCS` and "
            "`CAM02-UCS`, D65 for all other spaces.",
            json_schema_extra=without_default,
        ),
    ] = None
    adaptation: Annotated[
        Literal[tuple(ADAPTATIONS)] | SkipJsonSchema[None],  # type: ignore[valid-type]
        Field(
            description="How colours are adapted from one white to another; `Bradford` unless "
            "given.",
            json_schema_extra=without_default,
        ),
    ] = None
    scale: Annotated[
        Annotated[float, Field(ge=1e-4, le=1e6)] | SkipJsonSchema[None],
        Field(
            description="What all coordinates of the space are multiplied by; 1 unless given.",
            json_schema_extra=without_default,
        ),
    ] = None
    luminance: Annotated[
        Annotated[float, Field(ge=0.1, le=10_000)] | Literal["measured"] | SkipJsonSchema[None],
        Field(
            description="Luminance of the white in cd/m², for `ICtCp`, `ITP` and `Jzazbz`, or "
            "`measured` for what the data of a display states; 203 unless given.",
            json_schema_extra=without_default,
        ),
    ] = None
    adapting_luminance: Annotated[
        Annotated[float, Field(ge=0.01, le=10_000)] | SkipJsonSchema[None],
        Field(
            description="Luminance in cd/m² that the eye is adapted to, L_A, for `CAM16-UCS` and "
            "`CAM02-UCS`: a fifth of the white's. 4.07 unless given, that of sRGB's ambient of "
            "64 lx.",
            json_schema_extra=without_default,
        ),
    ] = None
    background: Annotated[
        Annotated[float, Field(ge=1, le=100)] | SkipJsonSchema[None],
        Field(
            description="Luminance of the background in per cent of the white's, Y_b, for "
            "`CAM16-UCS` and `CAM02-UCS`; 20 unless given.",
            json_schema_extra=without_default,
        ),
    ] = None
    surround: Annotated[
        Literal[tuple(SURROUNDS)] | SkipJsonSchema[None],  # type: ignore[valid-type]
        Field(
            description="What is around the background, for `CAM16-UCS` and `CAM02-UCS`; `average` "
            "unless given.",
            json_schema_extra=without_default,
        ),
    ] = None
    popularity: Annotated[
        Annotated[float, Field(gt=0, lt=1)] | SkipJsonSchema[None],
        Field(
            description="Which part of a picture's pixels is left out, those of its least used "
            "colours, such as 0.01; none unless given. For pictures only.",
            json_schema_extra=without_default,
        ),
    ] = None


class InlineSamples(BaseModel):
    """Characterisation data as JSON. Other members, of no option's name, are conditions."""

    model_config = ConfigDict(extra="allow")

    samples: Annotated[
        list[list[float | str | None] | dict[str, float | str | None]],
        Field(
            description="One array of numbers, or one object by column name, per sample. Columns "
            "that are no colours or device values, such as names, may hold texts."
        ),
    ]
    columns: Annotated[
        list[str] | None,
        Field(
            description="Names of the columns; L*, a*, b* when left out. Device values (RGB_R, "
            "CMYK_C, ...) beside the colour (LAB_L, XYZ_X, LCH_L, XYY_X, SPEC_380, ...) give a "
            "device model."
        ),
    ] = None
    white: Annotated[
        Triple | None,
        Field(description="XYZ of the white, in the scale of the samples' XYZ."),
    ] = None
    conditions: Annotated[
        dict[str, str | float] | SkipJsonSchema[None],
        Field(description="Measurement conditions by keyword, kept in the provenance."),
    ] = None
    options: Annotated[
        GamutOptions,
        Field(description="How the gamut is built.", json_schema_extra=_without_nulls),
    ] = GamutOptions()


class MultipartSubmission(BaseModel):
    """Characterisation data as a file."""

    model_config = ConfigDict(extra="forbid")

    file: Annotated[
        bytes,
        Field(
            description="CGATS or IT8 text, CxF3, CSV, JSON, a NumPy array (.npy), an ICC "
            "profile, a picture (PNG, TIFF, JPEG), or a gamut mesh (PLY, glTF, Argyll's .gam, STL, "
            "OBJ); recognised by its content.",
            json_schema_extra={"format": "binary"},
        ),
    ]
    options: Annotated[
        GamutOptions,
        Field(description="How the gamut is built.", json_schema_extra=_without_nulls),
    ] = GamutOptions()
