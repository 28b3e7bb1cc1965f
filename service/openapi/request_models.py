"""Models of request bodies, for the OpenAPI document and its examples.

`gamutcore` checks the requests. The options are its own model, so the document states the same
names, types, bounds, defaults and descriptions.
"""

from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, create_model
from pydantic.json_schema import SkipJsonSchema

from gamutcore.arguments import (
    Array,
    Coordinates,
    marks,
)
from gamutcore.characterisation.recognition import format_summary
from gamutcore.options import OPTIONS, Option, Options

__all__ = [
    "Coordinates",
    "GamutOptions",
    "InlineSamples",
    "Model",
    "MultipartSubmission",
    "NewName",
    "ReferenceSubmission",
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
