"""The options of a gamut: one declaration of each, and the checked, immutable set of values.

`Options` is a pydantic model. Each field is declared once: its type and bounds, default and
description, the data it applies to, and whether only some boundaries or colour spaces have it.
`OPTIONS` gives the declarations as plain data. The OpenAPI document and the tables of the documents
follow from them. The canonical form of the options is part of a gamut's id.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Annotated, Any, Self, TypeAlias, get_type_hints

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    ValidationError,
    ValidationInfo,
    ValidatorFunctionWrapHandler,
    field_validator,
    model_validator,
)
from pydantic.json_schema import SkipJsonSchema

from gamutcore.arguments import (
    Choice,
    Coordinates,
    Number,
    Text,
    accepted_values,
    canonical,
    refusal,
)
from gamutcore.boundary import BASIS, BOUNDARIES, GAMMA, SEGMENT_COUNTS, SUBDIVISIONS
from gamutcore.characterisation.columns import condition_label
from gamutcore.colours import DEVICE_MODELS, ILLUMINANTS, INTENTS, OBSERVERS, SURFACE_SAMPLES
from gamutcore.colours import spaces as parameters
from gamutcore.colours.spaces import SPACES, ColourSpace
from gamutcore.decimation import COSTS
from gamutcore.errors import OptionError
from gamutcore.names import folded, near_match

__all__ = ["DATA_KINDS", "OPTIONS", "Option", "Options", "option_name", "option_value"]

DATA_KINDS: Mapping[str, str] = MappingProxyType(
    {
        "profile": "the data is an ICC profile",
        "measurements": "the data is measured device values",
        "colours": "the data is colours without device values",
        "picture": "the data is a picture",
        "mesh": "the data is a boundary already, and nothing is wrapped",
        "reference": "the data is a reference gamut",
    }
)
"""Kinds of characterisation data, each with the reason why an option may not apply."""

_WRAPPED_DATA = ("profile", "measurements", "colours", "picture", "reference")
_SPECTRAL_DATA = ("measurements", "colours")

_SELECTED: dict[str, dict[str, Mapping[str, object]]] = {
    "": {},
    "boundary": {method: entry.defaults for method, entry in BOUNDARIES.items()},
    "space": {space: parameters.parameter_defaults(space) for space in SPACES},
}
"""The options that only some boundaries or spaces have, with their defaults."""


@dataclass(frozen=True)
class Option:
    """What the declaration of an option states beside its type; `OPTIONS` adds the last four.

    `data` has the keys of `DATA_KINDS` that the option applies to. `selector` is ``"boundary"`` or
    ``"space"`` if only some of them have the option. `unless_given` says what happens without a
    value, for an option without a default. `kind` is the annotation, for `gamutcore.arguments`.
    `default` is None if there is none, or if it depends on `selector`.
    """

    data: tuple[str, ...] = tuple(DATA_KINDS)
    selector: str = ""
    unless_given: str = ""
    name: str = ""
    description: str = ""
    kind: Any = None
    default: object = None

    @property
    def defaults(self) -> dict[str, object]:
        """The defaults for the boundaries or spaces that have the option."""
        users = _SELECTED[self.selector].items()
        return {user: own[self.name] for user, own in users if self.name in own}

    @property
    def is_universal(self) -> bool:
        """Whether all boundaries or spaces have the option."""
        return len(self.defaults) == len(_SELECTED[self.selector])

    @property
    def accepted(self) -> str:
        """The accepted values in words."""
        return accepted_values(self.kind)

    @property
    def default_text(self) -> str:
        """The default in words, in Markdown: ``"0.2 for `modified-convex-hull`, 0.05 for `usv`"``.

        For an option without a default, what happens unless it is given.
        """
        if not self.selector:
            return self.unless_given if self.default is None else _text_of(self.default)
        users: dict[str, list[str]] = {}
        for user, default in self.defaults.items():
            users.setdefault(_text_of(default), []).append(f"`{user}`")
        if len(users) == 1 and self.is_universal:
            return next(iter(users))
        return "; ".join(f"{default} for {', '.join(names)}" for default, names in users.items())

    @property
    def documentation(self) -> str:
        """The description with the default and the data that the option applies to."""
        parts = [self.description]
        if self.selector:
            parts.append(f"Default: {self.default_text}.")
        if self.unless_given:
            parts.append(f"Unless given: {self.unless_given}.")
        if len(self.data) < len(DATA_KINDS):
            parts.append(f"Applies to: {', '.join(self.data)}.")
        return " ".join(parts)


def _text_of(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.3g}"
    if isinstance(value, tuple):
        return str(list(value))
    return f"`{value}`" if isinstance(value, str) else str(value)


def _condition(text: str) -> str:
    """Canonical name of a measurement condition: ``m1`` becomes ``M1``, other names stay."""
    words = " ".join(text.split())
    label = condition_label(words)
    return label if label.lower() == words.lower() else words


_CONDITION = Text(80, "the name of a measurement condition, such as 'M1'", _condition)
_LAYER = Text(255, "the name of a layer of an OpenEXR picture, such as 'ViewLayer.Combined'")
_INKS = Text(
    400,
    "the names of the inks in order, separated by commas, such as 'C,M,Y,K,O,G,V'",
    lambda text: ",".join(" ".join(name.split()) for name in text.split(",")),
)
_FLUORESCENT = {f"f{n}": f"FL{n}" for n in range(1, 13)}
_OF_BOUNDARY = Option(data=_WRAPPED_DATA, selector="boundary")
_OF_SPACE = Option(selector="space")

Absent: TypeAlias = SkipJsonSchema[None]

NO_LIMIT = "none"
"""Value of ``ink_limit`` for all inks in full. ``null`` in JSON and None in Python are the same."""


class Options(BaseModel):
    """How a gamut is built. Values are checked and brought to their canonical form.

    Names of choices are matched without regard to case, spaces and punctuation. An option that only
    some boundaries or spaces have is None with the others, and refused if it is given.

    Raises
    ------
    OptionError
        A value is not accepted; ``where["field"]`` names the option.

    Examples
    --------
    >>> Options(space="lab", ink_limit=300).to_mapping()["space"]
    'CIELAB'
    """

    # the validator is built on first use: pydantic then scans all distributions for plugins, 40 ms
    model_config = ConfigDict(frozen=True, extra="forbid", validate_default=True, defer_build=True)

    space: parameters.SPACE = Field(
        default="CIELAB",
        description="Colour space of the boundary.",
    )
    boundary: Annotated[str, Choice(tuple(BOUNDARIES)), Option(data=_WRAPPED_DATA)] = Field(
        default="auto",
        description="Method that wraps the colours in a closed surface. `device-surface` takes "
        "the outermost faces of the device's own cube, and needs a profile or samples with a "
        "device model. `auto` is `device-surface` where it is possible and no `gamma` is given, "
        "else `modified-convex-hull`.",
    )
    gamma: Annotated[GAMMA | Absent, _OF_BOUNDARY] = Field(
        default=None,
        description="Power that radii are raised to before the convex hull is taken. 1 gives the "
        "convex hull; small values follow the colours into concave regions. `auto` chooses by the "
        "data: 0.2 for scattered colours, a small value for the sampled surface of a device.",
    )
    segments: Annotated[SEGMENT_COUNTS | Absent, _OF_BOUNDARY] = Field(
        default=None,
        description="Numbers of polar and azimuth segments.",
    )
    basis: Annotated[BASIS | Absent, _OF_BOUNDARY] = Field(
        default=None,
        description="Regular polyhedron whose faces are subdivided into segments.",
    )
    subdivisions: Annotated[SUBDIVISIONS | Absent, _OF_BOUNDARY] = Field(
        default=None,
        description="Number of times that each face of the polyhedron is split into four. With a "
        "coarse subdivision, the outermost colours of the segments may not surround the centre.",
    )
    centre: Annotated[str, Choice(("auto",))] | Coordinates = Field(
        default="auto",
        description="Point that radii are taken from, in coordinates of the colour space. It must "
        "be inside the gamut. `auto` takes the deepest point that sees the whole surface of a "
        "device with three channels, and the middle of other colours.",
    )
    cost: Annotated[str, Choice(COSTS)] = Field(
        default="volume",
        description="Order of the edge collapses. `volume` preserves the volume at every level. "
        "`finest` orders by the mismatch and also moves vertices: coarse levels are more "
        "accurate, and the decimation takes several times as long. `quadric` is the published "
        "quadric error metric.",
    )
    surface_samples: Annotated[
        SURFACE_SAMPLES, Option(data=("profile", "measurements", "reference"))
    ] = Field(
        default=100_000,
        description="Largest number of points on the device's surface that the device model is "
        "evaluated at.",
    )
    intent: Annotated[str, Choice(INTENTS), Option(data=_WRAPPED_DATA)] = Field(
        default="relative",
        description="Rendering intent. `relative` maps the medium's white to the white of the "
        "space, `absolute` keeps its colour. `perceptual` and `saturation` exist in ICC profiles "
        "only.",
    )
    source: Annotated[
        str | None,
        Choice(("transforms", "usable", "measurements", "boundary")),
        Option(data=("profile",), unless_given="the transforms"),
    ] = Field(
        default=None,
        description="Content of an ICC profile that is used: its transforms, the `usable` colours "
        "that its tables B2A of the intent reach, the measurements it carries (tags targ, or CIED "
        "with DevD), or the gamut boundary of an iccMAX profile (tags gbd0 to gbd3).",
    )
    device_model: Annotated[
        str | None,
        Choice(DEVICE_MODELS),
        Option(
            data=("measurements",),
            unless_given="interpolation of complete grids, a fit to other samples",
        ),
    ] = Field(
        default=None,
        description="Device model of measured samples with device values. `interpolation` is "
        "n-linear and needs a complete grid. `fit` uses radial basis functions.",
    )
    ink_limit: Annotated[
        Annotated[float, Number(0, 1500, above_least=True, unit="per cent")]
        | Annotated[str, Choice((NO_LIMIT,))]
        | None,
        Option(
            data=("profile", "measurements"),
            unless_given="the limit that the data states, if any",
        ),
    ] = Field(
        default=None,
        description="Largest sum of all inks in per cent, such as 300, or `none`. For devices with "
        "inks only. The gamut and all device values keep it.",
    )
    black_limit: Annotated[
        float | None,
        Number(0, 100, unit="per cent"),
        Option(data=("profile", "measurements"), unless_given="no limit"),
    ] = Field(
        default=None,
        description="Largest amount of the black ink in per cent. For devices with a black ink "
        "only.",
    )
    inks: Annotated[
        str | None,
        _INKS,
        Option(data=("profile", "measurements"), unless_given="the names in the data"),
    ] = Field(
        default=None,
        description="Names of the inks in order, such as `C,M,Y,K,O,G,V`, for data that only "
        "numbers them. Rules of black need a black ink, which is named `K` or `Black`.",
    )
    observer: Annotated[
        int | None,
        Choice(OBSERVERS),
        Option(
            data=_SPECTRAL_DATA,
            unless_given="the observer that data of spectra alone declares, else 2",
        ),
    ] = Field(
        default=None,
        description="Standard observer that spectra are integrated with, in degrees. Data without "
        "spectra accepts only its own observer.",
    )
    illuminant: Annotated[
        str | None,
        Choice(ILLUMINANTS, _FLUORESCENT),
        Option(
            data=_SPECTRAL_DATA,
            unless_given="the illuminant that data of spectra alone declares, else D50",
        ),
    ] = Field(
        default=None,
        description="Illuminant of reflectance spectra. Data without spectra accepts only its own "
        "illuminant.",
    )
    condition: Annotated[str | None, _CONDITION, Option(data=_SPECTRAL_DATA)] = Field(
        default=None,
        description="Measurement condition to use from data that has several, such as `M0`, `M1` "
        "or `M2` of ISO 13655. Without it, such data is refused with the code "
        "`measurement-condition`, and the error names the conditions.",
    )
    reference_white: Annotated[parameters.REFERENCE_WHITE | Absent, _OF_SPACE] = Field(
        default=None,
        description="White that colours are adapted to: a name, or X, Y, Z in any scale.",
    )
    adaptation: Annotated[parameters.ADAPTATION | Absent, _OF_SPACE] = Field(
        default=None,
        description="Chromatic adaptation transform from one white to another.",
    )
    luminance: Annotated[parameters.LUMINANCE | Absent, _OF_SPACE] = Field(
        default=None,
        description="Luminance of the white in cd/m², or `measured` for the luminance that the "
        "data of a display declares.",
    )
    adapting_luminance: Annotated[parameters.ADAPTING_LUMINANCE | Absent, _OF_SPACE] = Field(
        default=None,
        description="Luminance in cd/m² that the eye is adapted to, L_A: a fifth of the white's. "
        "The default corresponds to sRGB's ambient illumination of 64 lx.",
    )
    background: Annotated[parameters.BACKGROUND | Absent, _OF_SPACE] = Field(
        default=None,
        description="Luminance of the background in per cent of the white's, Y_b.",
    )
    surround: Annotated[parameters.SURROUND | Absent, _OF_SPACE] = Field(
        default=None,
        description="Surround of the background in the appearance model.",
    )
    popularity: Annotated[
        float | None,
        Number(0, 1, above_least=True, below_most=True),
        Option(data=("picture",), unless_given="all pixels count"),
    ] = Field(
        default=None,
        description="Share of a picture's pixels that is left out, those of its least frequent "
        "colours, such as 0.01.",
    )
    layer: Annotated[
        str | None,
        _LAYER,
        Option(data=("picture",), unless_given="the layer that is the whole picture"),
    ] = Field(
        default=None,
        description="Layer of an OpenEXR picture, such as `ViewLayer.Combined`. A warning names "
        "all layers of a file with several.",
    )

    @model_validator(mode="before")
    @classmethod
    def _named(cls, settings: dict[str, object]) -> dict[str, object]:
        return {option_name(name): value for name, value in settings.items()}

    @field_validator("*", mode="wrap")
    @classmethod
    def _check(
        cls, value: object, canonical: ValidatorFunctionWrapHandler, info: ValidationInfo
    ) -> object:
        """Fill in the default, and translate the error of pydantic."""
        name = str(info.field_name)
        declared = OPTIONS[name]
        if declared.selector == "space":
            return value  # for `_check_together`
        if declared.selector:
            selected = info.data[declared.selector]
            if selected not in declared.defaults:
                if value is None:
                    return None
                raise OptionError.not_applicable(
                    name, value, f"the {declared.selector} {selected} has no {name}"
                )
            value = declared.defaults[selected] if value is None else value
        elif value is None and declared.default is None:
            return None
        try:
            return canonical(value)
        except ValidationError:
            error = refusal(name, value, declared.kind)
            if name == "boundary" and isinstance(value, str) and folded(value) == "convexhull":
                error.remedy = (
                    'Give a gamma of 1 (--gamma 1, or "gamma": 1), which is the convex hull, with'
                    " the boundary modified-convex-hull or without a boundary."
                )
            raise error from None

    @model_validator(mode="after")
    def _check_together(self) -> Self:
        settings = {name: getattr(self, name) for name in parameters.SPACE_PARAMETERS}
        # the model is frozen
        self.__dict__.update(parameters.space_parameters(self.space, settings))
        if self.source == "transforms":  # the default; None keeps the ids of gamuts without it
            self.__dict__["source"] = None
        return self

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, object]) -> Options:
        """Return options from names, in any letter case with ``-`` or ``_``, and JSON values.

        Raises
        ------
        OptionError
            A name is unknown or occurs twice, or a value is not accepted.

        Examples
        --------
        >>> Options.from_mapping({"Ink-Limit": 300}).ink_limit
        300.0
        """
        values: dict[str, Any] = {}
        for text, value in mapping.items():
            name = option_name(text)
            if name in values:
                raise OptionError(
                    f"The option {name} is given twice.",
                    where={"field": name},
                    remedy="Give each option once.",
                )
            values[name] = NO_LIMIT if value is None and name == "ink_limit" else value
            if values[name] is None:  # to the constructor, None means that there is no value
                raise OptionError.refusal(name, value, "a value, or leave it out for the default")
        return cls(**values)

    @classmethod
    def from_stored(cls, mapping: Mapping[str, object]) -> Options:
        """Return options that an earlier version of the service stored with a gamut or a job.

        The boundary ``convex-hull`` was the modified one with a gamma of 1. Spaces had the option
        `scale`, of which only 1 can be built.

        Raises
        ------
        OptionError
            As for `from_mapping`.
        """
        options = dict(mapping)
        if options.get("boundary") == "convex-hull":
            options |= {"boundary": "modified-convex-hull", "gamma": 1.0}
        scale = options.pop("scale", 1.0)
        if scale != 1.0:
            raise OptionError(
                f"The option scale is {scale}, and coordinates have no factor in this version.",
                where={"field": "scale"},
                remedy="Post the data again without scale, and multiply the coordinates of answers"
                " by the factor.",
            )
        return cls.from_mapping(options)

    def to_mapping(self) -> dict[str, object]:
        """Return all options that apply, as JSON-able values; `from_mapping` reads them back."""
        return {
            name: list(value) if isinstance(value, tuple) else value
            for name, value in self
            if value is not None
        }

    def check_data(self, kind: str) -> None:
        """Refuse options that do not apply to some kind of data and differ from their default.

        `kind` is a key of `DATA_KINDS`. `OptionError` names the first such option.
        """
        defaults = Options()
        for name in OPTIONS:
            value = getattr(self, name)
            if not self.applies(name, kind) and value != getattr(defaults, name):
                raise OptionError.not_applicable(name, value, DATA_KINDS[kind])

    def applies(self, name: str, kind: str) -> bool:
        """Whether an option applies to some kind of data, a key of `DATA_KINDS`."""
        # what an ICC profile carries is another kind of data than the profile
        if name == "source" or (name == "intent" and self.source == "boundary"):
            return True
        return kind in OPTIONS[name].data

    @property
    def boundary_parameters(self) -> dict[str, object]:
        """Parameters of the boundary method beside the points and the centre."""
        return {name: getattr(self, name) for name in BOUNDARIES[self.boundary].defaults}

    def colour_space(self, white_luminance: object = None) -> ColourSpace:
        """Return the colour space of the boundary, with its parameters.

        The luminance "measured" becomes `white_luminance`, in cd/m², which the data declares;
        without one, `OptionError` is raised.
        """
        settings = {name: getattr(self, name) for name in parameters.SPACE_PARAMETERS}
        if self.luminance == parameters.MEASURED:
            settings["luminance"] = parameters.measured_luminance(white_luminance)
        return ColourSpace(self.space, **settings)

    @property
    def canonical(self) -> str:
        """The options as one text: JSON with sorted names and shortest numbers."""
        return json.dumps(self.to_mapping(), sort_keys=True, separators=(",", ":"))


def _declarations() -> dict[str, Option]:
    kinds, declarations = get_type_hints(Options, include_extras=True), {}
    for name, field in Options.model_fields.items():
        stated = next((mark for mark in field.metadata if isinstance(mark, Option)), Option())
        declarations[name] = replace(
            stated,
            name=name,
            description=str(field.description),
            kind=kinds[name],
            default=field.default,
        )
    return declarations


OPTIONS: Mapping[str, Option] = MappingProxyType(_declarations())
"""The declarations of all options by name, in the order of the documents."""


def option_value(name: str, text: str) -> object:
    """Return the value that a text stands for, unchecked.

    It is the text if the option accepts it, else its value as JSON, else a list of numbers that
    commas or spaces separate, else the text.

    Examples
    --------
    >>> option_value("gamma", "0.2"), option_value("cost", "finest")
    (0.2, 'finest')
    >>> option_value("centre", "50, 0, 0")
    [50, 0, 0]
    """
    if canonical(text, OPTIONS[name].kind) is not None:
        return text
    parts = text.replace(",", " ").split()
    for written in (text, f"[{','.join(parts)}]" if len(parts) > 1 else text):
        with suppress(ValueError, RecursionError):
            return json.loads(written)
    return text


def option_name(text: object) -> str:
    """Return the key of `OPTIONS` that is meant, in any letter case, with ``-`` or ``_``.

    Without such an option, the remedy of `OptionError` names a near match.
    """
    name = str(text).strip().lower().replace("-", "_")
    if name in OPTIONS:
        return name
    meant = near_match(name, OPTIONS)
    hint = f"Did you mean {meant}? " if meant else ""
    if name == "scale":
        hint = "Leave it out, and multiply the coordinates of answers by the factor. "
    raise OptionError(
        f"There is no option {str(text)[:40]!r}.",
        where={"field": str(text)[:40]},
        remedy=f"{hint}Options are {', '.join(OPTIONS)}.",
    )
