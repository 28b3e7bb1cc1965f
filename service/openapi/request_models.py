"""Models of request bodies, for the OpenAPI document and its examples.

`gamutcore` checks the requests. The model of the options is generated from its declarations, so the
document states the same names, types, bounds, defaults and descriptions.
"""

from functools import reduce
from operator import or_
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, create_model
from pydantic.json_schema import SkipJsonSchema

from gamutcore.characterisation.formats import format_summary
from gamutcore.option_types import (
    Choice,
    Number,
    Option,
    OptionType,
    Text,
    Vector,
    WholeNumber,
    WholeNumbers,
)
from gamutcore.options import OPTIONS

__all__ = ["GamutOptions", "InlineSamples", "MultipartSubmission", "Triple", "without_default"]

Triple = Annotated[list[float], Field(min_length=3, max_length=3)]


def without_default(schema: dict[str, Any]) -> None:
    """Remove the null that stands for a default which depends on other options."""
    del schema["default"]


def _without_nulls(schema: dict[str, Any]) -> None:
    """Remove these nulls from the default of all options."""
    schema["default"] = {k: v for k, v in schema["default"].items() if v is not None}


def _annotation(kind: OptionType) -> Any:  # noqa: ANN401  # a type that only pydantic reads
    """Return the annotation of a type of option values."""
    match kind:
        case Choice():
            return Literal[kind.values]
        case Number():
            bounds = Field(
                gt=kind.least if kind.above_least else None,
                ge=None if kind.above_least else kind.least,
                lt=kind.most if kind.below_most else None,
                le=None if kind.below_most else kind.most,
            )
            return Annotated[float, bounds]
        case WholeNumber():
            return Annotated[int, Field(ge=kind.least, le=kind.most)]
        case WholeNumbers():
            return tuple[*(_annotation(part) for part in kind.parts)]  # type: ignore[misc]
        case Vector():
            return Triple
        case Text():
            return Annotated[str, Field(min_length=1, max_length=kind.longest)]


def _field(option: Option) -> tuple[Any, Any]:
    """Return the annotation and the default of an option's field."""
    annotation: Any = reduce(or_, map(_annotation, option.types))
    if option.default is not None:
        return Annotated[annotation, Field(description=option.documentation)], option.default
    described = Field(description=option.documentation, json_schema_extra=without_default)
    optional: Any = annotation | SkipJsonSchema[None]  # type: ignore[misc]
    return Annotated[optional, described], None


_fields: dict[str, Any] = {name: _field(option) for name, option in OPTIONS.items()}
_Options = create_model("_Options", __config__=ConfigDict(extra="forbid"), **_fields)


class GamutOptions(_Options):  # type: ignore[misc, valid-type]  # made from the declarations
    """Options of a gamut. Every option has a default. Answers state all that apply."""


class InlineSamples(BaseModel):
    """Characterisation data as JSON. Members without an option's name are conditions."""

    model_config = ConfigDict(extra="allow")

    samples: Annotated[
        list[list[float | str | None] | dict[str, float | str | None]],
        Field(
            description="One array of numbers, or one object by column name, per sample. Columns "
            "other than colours and device values, such as names, may contain text."
        ),
    ]
    columns: Annotated[
        list[str] | None,
        Field(
            description="Names of the columns; L*, a*, b* by default. Device values (RGB_R, "
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
        Field(description="Measurement conditions by keyword, stored in the provenance."),
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
            description=f"A file, recognised by its content: {format_summary()}.",
            json_schema_extra={"format": "binary"},
        ),
    ]
    options: Annotated[
        GamutOptions,
        Field(
            description="How the gamut is built. Options can also be form fields of their own "
            "names, such as `ink_limit=300`, with numbers and lists as in JSON.",
            json_schema_extra=_without_nulls,
        ),
    ] = GamutOptions()
