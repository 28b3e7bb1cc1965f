"""The options of a gamut: one declaration of each, and the checked, immutable set of values.

Each field of `Options` is declared once, by `option`: its type and bounds, default, description,
the data it applies to, and the boundaries or colour spaces that have it. `OPTIONS` gives these
declarations as plain data. Request models, the OpenAPI document and the tables of the documents are
generated from it. The canonical form of the options is part of a gamut's id.
"""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, TypeAlias

from gamutcore.boundary import BASIS, BOUNDARIES, GAMMA, SEGMENT_COUNTS, SUBDIVISIONS
from gamutcore.characterisation.conditions import condition_label
from gamutcore.colours import (
    DEVICE_MODELS,
    ILLUMINANTS,
    INTENTS,
    MEASURED,
    OBSERVERS,
    SPACE,
    SPACE_PARAMETERS,
    SURFACE_SAMPLES,
    measured_luminance,
    parameter_defaults,
    space_parameters,
)
from gamutcore.colours.spaces import SPACES, ColourSpace
from gamutcore.decimation import COSTS
from gamutcore.errors import OptionError
from gamutcore.option_types import (
    DATA_KINDS,
    Choice,
    Number,
    Option,
    OptionType,
    Text,
    Vector,
    check_option,
    near_match,
)

__all__ = [
    "DATA_KINDS",
    "OPTIONS",
    "Centre",
    "Option",
    "Options",
    "option_name",
    "option_value",
]

Centre: TypeAlias = "tuple[float, float, float] | str"

_WRAPPED_DATA = ("profile", "measurements", "colours", "picture", "reference")
_SPECTRAL_DATA = ("measurements", "colours")


def option(
    *types: OptionType,
    description: str,
    default: object = None,
    **declaration: Any,  # noqa: ANN401  # the attributes of Option
) -> Any:  # noqa: ANN401  # a dataclass field stands for its value
    """Declare a field of `Options`; the arguments are the attributes of `Option`."""
    metadata = {"types": types, "description": description, **declaration}
    return field(default=default, metadata=metadata)


def _boundary_option(
    name: str,
    *types: OptionType,
    description: str,
) -> Any:  # noqa: ANN401
    defaults = {
        method: entry.defaults[name]
        for method, entry in BOUNDARIES.items()
        if name in entry.defaults
    }
    return option(
        *types,
        description=description,
        data=_WRAPPED_DATA,
        selector="boundary",
        defaults=defaults,
        is_universal=False,
    )


def _space_option(name: str, *, description: str) -> Any:  # noqa: ANN401
    defaults = {
        space: parameter_defaults(space)[name]
        for space in SPACES
        if name in parameter_defaults(space)
    }
    return option(
        *SPACE_PARAMETERS[name],
        description=description,
        selector="space",
        defaults=defaults,
        is_universal=len(defaults) == len(SPACES),
    )


def _condition(text: str) -> str:
    """Canonical name of a measurement condition: ``m1`` becomes ``M1``, other names stay."""
    words = " ".join(text.split())
    label = condition_label(words)
    return label if label.lower() == words.lower() else words


@dataclass(frozen=True)
class Options:
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

    space: str = option(
        SPACE,
        default="CIELAB",
        description="Colour space of the boundary.",
        common=True,
    )
    boundary: str = option(
        Choice(tuple(BOUNDARIES)),
        default="auto",
        description="Method that wraps the colours in a closed surface. `device-surface` takes the "
        "outermost faces of the device's own cube, and needs a profile or samples with a device "
        "model. `auto` is `device-surface` where it is possible and no `gamma` is given, else "
        "`modified-convex-hull`.",
        data=_WRAPPED_DATA,
    )
    gamma: float | str | None = _boundary_option(
        "gamma",
        *GAMMA,
        description="Power that radii are raised to before the convex hull is taken. 1 gives the "
        "convex hull; small values follow the colours into concave regions. `auto` chooses by the "
        "data: 0.2 for scattered colours, a small value for the sampled surface of a device.",
    )
    segments: tuple[int, int] | None = _boundary_option(
        "segments", SEGMENT_COUNTS, description="Numbers of polar and azimuth segments."
    )
    basis: str | None = _boundary_option(
        "basis", BASIS, description="Regular polyhedron whose faces are subdivided into segments."
    )
    subdivisions: int | None = _boundary_option(
        "subdivisions",
        SUBDIVISIONS,
        description="Number of times that each face of the polyhedron is split into four. With a "
        "coarse subdivision, the outermost colours of the segments may not surround the centre.",
    )
    centre: Centre = option(  # noqa: RUF009  # a field, as the others
        Choice(("auto",)),
        Vector(),
        default="auto",
        description="Point that radii are taken from, in coordinates of the colour space. It must "
        "be inside the gamut. `auto` takes the deepest point that sees the whole surface of a "
        "device with three channels, and the middle of other colours.",
    )
    cost: str = option(
        Choice(COSTS),
        default="volume",
        description="Order of the edge collapses. `volume` preserves the volume at every level. "
        "`finest` orders by the mismatch and also moves vertices: coarse levels are more accurate, "
        "and the decimation takes several times as long. `quadric` is the published quadric error "
        "metric.",
        common=True,
    )
    surface_samples: int = option(
        SURFACE_SAMPLES,
        default=100_000,
        description="Largest number of points on the device's surface that the device model is "
        "evaluated at.",
        data=("profile", "measurements", "reference"),
        common=True,
    )
    intent: str = option(
        Choice(INTENTS),
        default="relative",
        description="Rendering intent. `relative` maps the medium's white to the white of the "
        "space, `absolute` keeps its colour. `perceptual` and `saturation` exist in ICC profiles "
        "only.",
        data=_WRAPPED_DATA,
        common=True,
    )
    source: str | None = option(
        Choice(("transforms", "measurements", "boundary")),
        description="Content of an ICC profile that is used: its transforms, the measurements it "
        "carries (tags targ, or CIED with DevD), or the gamut boundary of an iccMAX profile (tags "
        "gbd0 to gbd3).",
        data=("profile",),
        unless_given="Unless given: the transforms.",
    )
    device_model: str | None = option(
        Choice(DEVICE_MODELS),
        description="Device model of measured samples with device values. `interpolation` is "
        "n-linear and needs a complete grid. `fit` uses radial basis functions.",
        data=("measurements",),
        unless_given="Unless given: interpolation of complete grids, a fit to other samples.",
    )
    ink_limit: float | None = option(
        Number(0, 1500, above_least=True, unit="per cent"),
        description="Largest sum of all inks in per cent, such as 300. For devices with inks only.",
        data=("profile", "measurements"),
        unless_given="Unless given: no limit.",
        common=True,
    )
    black_limit: float | None = option(
        Number(0, 100, unit="per cent"),
        description="Largest amount of the black ink in per cent. For devices with a black ink "
        "only.",
        data=("profile", "measurements"),
        unless_given="Unless given: no limit.",
    )
    observer: int | None = option(
        Choice(OBSERVERS),
        description="Standard observer that spectra are integrated with, in degrees. Data without "
        "spectra accepts only its own observer.",
        data=_SPECTRAL_DATA,
        unless_given="Unless given: the observer that data of spectra alone declares, else 2.",
    )
    illuminant: str | None = option(
        Choice(ILLUMINANTS, {f"f{n}": f"FL{n}" for n in range(1, 13)}),
        description="Illuminant of reflectance spectra. Data without spectra accepts only its own "
        "illuminant.",
        data=_SPECTRAL_DATA,
        unless_given="Unless given: the illuminant that data of spectra alone declares, else D50.",
    )
    condition: str | None = option(
        Text(80, "the name of a measurement condition, such as 'M1'", _condition),
        description="Measurement condition to use from data that has several, such as `M0`, `M1` "
        "or `M2` of ISO 13655. Without it, such data is refused with the code "
        "`measurement-condition`, and the error names the conditions.",
        data=_SPECTRAL_DATA,
    )
    reference_white: str | tuple[float, float, float] | None = _space_option(
        "reference_white",
        description="White that colours are adapted to: a name, or X, Y, Z in any scale.",
    )
    adaptation: str | None = _space_option(
        "adaptation", description="Chromatic adaptation transform from one white to another."
    )
    scale: float | None = _space_option(
        "scale", description="Factor of all coordinates of the space."
    )
    luminance: float | str | None = _space_option(
        "luminance",
        description="Luminance of the white in cd/m², or `measured` for the luminance that the "
        "data of a display declares.",
    )
    adapting_luminance: float | None = _space_option(
        "adapting_luminance",
        description="Luminance in cd/m² that the eye is adapted to, L_A: a fifth of the white's. "
        "The default corresponds to sRGB's ambient illumination of 64 lx.",
    )
    background: float | None = _space_option(
        "background",
        description="Luminance of the background in per cent of the white's, Y_b.",
    )
    surround: str | None = _space_option(
        "surround", description="Surround of the background in the appearance model."
    )
    popularity: float | None = option(
        Number(0, 1, above_least=True, below_most=True),
        description="Share of a picture's pixels that is left out, those of its least frequent "
        "colours, such as 0.01.",
        data=("picture",),
        unless_given="Unless given: all pixels count.",
    )

    def __post_init__(self) -> None:
        for name, declared in OPTIONS.items():
            if name not in SPACE_PARAMETERS:
                self._set(name, self._canonical_value(declared))
        given = {name: getattr(self, name) for name in SPACE_PARAMETERS}
        for name, value in space_parameters(self.space, given).items():
            self._set(name, value)
        if self.boundary == "convex-hull" and self.gamma != 1.0:
            raise OptionError.not_applicable(
                "gamma", self.gamma, "the convex hull is the modified one with a gamma of 1"
            )
        if self.source == "transforms":  # the default; None keeps the ids of gamuts without it
            self._set("source", None)

    def _set(self, name: str, value: object) -> None:
        object.__setattr__(self, name, value)  # frozen: only the constructor may do this

    def _canonical_value(self, declared: Option) -> object:
        name, value = declared.name, getattr(self, declared.name)
        if declared.selector:
            selected = getattr(self, declared.selector)
            if selected not in declared.defaults:
                if value is None:
                    return None
                raise OptionError.not_applicable(
                    name, value, f"the {declared.selector} {selected} has no {name}"
                )
            value = declared.defaults[selected] if value is None else value
        elif value is None and declared.default is None:
            return None
        return check_option(name, value, *declared.types)

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, object]) -> Options:
        """Return options from names and values, such as parsed JSON.

        Parameters
        ----------
        mapping : mapping of str to object
            Names in any letter case, with ``-`` or ``_``.

        Returns
        -------
        Options
            Options that are not in the mapping have their defaults.

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
        for given, value in mapping.items():
            name = option_name(given)
            if name in values:
                raise OptionError(
                    f"The option {name} is given twice.",
                    where={"field": name},
                    remedy="Give each option once.",
                )
            if value is None:  # to the constructor, None means that there is no value
                raise OptionError.refusal(name, value, "a value, or leave it out for the default")
            values[name] = value
        return cls(**values)

    def to_mapping(self) -> dict[str, object]:
        """Return all options that apply, as JSON-able values; `from_mapping` reads them back."""
        return {
            name: list(value) if isinstance(value, tuple) else value
            for name, value in dataclasses.asdict(self).items()
            if value is not None
        }

    def check_data(self, kind: str) -> None:
        """Refuse options that do not apply to some kind of data and differ from their default.

        Parameters
        ----------
        kind : str
            A key of `DATA_KINDS`.

        Raises
        ------
        OptionError
            The first such option.
        """
        defaults = Options()
        for name in OPTIONS:
            value = getattr(self, name)
            if not self.applies(name, kind) and value != getattr(defaults, name):
                raise OptionError.not_applicable(name, value, DATA_KINDS[kind])

    def applies(self, name: str, kind: str) -> bool:
        """Whether an option applies to some kind of data.

        Parameters
        ----------
        name : str
            A key of `OPTIONS`.
        kind : str
            A key of `DATA_KINDS`.

        Returns
        -------
        bool
        """
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

        Parameters
        ----------
        white_luminance : float, optional
            Luminance of the white that the data declares, in cd/m², for the luminance "measured".

        Returns
        -------
        ColourSpace

        Raises
        ------
        OptionError
            The luminance is to be the measured one, and the data declares none.
        """
        parameters = {name: getattr(self, name) for name in SPACE_PARAMETERS}
        if self.luminance == MEASURED:
            parameters["luminance"] = measured_luminance(white_luminance)
        return ColourSpace(self.space, **parameters)

    @property
    def canonical(self) -> str:
        """The options as one text: JSON with sorted names and shortest numbers."""
        return json.dumps(self.to_mapping(), sort_keys=True, separators=(",", ":"))


OPTIONS: Mapping[str, Option] = MappingProxyType(
    {
        each.name: Option(each.name, default=each.default, **each.metadata)
        for each in dataclasses.fields(Options)
    }
)
"""The declarations of all options by name, in the order of the documents."""


def option_value(name: str, text: str) -> object:
    """Return the value that a text stands for, unchecked.

    Parameters
    ----------
    name : str
        A key of `OPTIONS`.
    text : str

    Returns
    -------
    object
        The text if the option accepts text like it, else what it is as JSON, else a list if it is
        several numbers, separated by commas or spaces, else the text.

    Examples
    --------
    >>> option_value("gamma", "0.2"), option_value("cost", "finest")
    (0.2, 'finest')
    >>> option_value("centre", "50, 0, 0")
    [50, 0, 0]
    """
    if any(each.canonical(text) is not None for each in OPTIONS[name].types):
        return text
    parts = text.replace(",", " ").split()
    for written in (text, f"[{','.join(parts)}]" if len(parts) > 1 else text):
        with suppress(ValueError, RecursionError):
            return json.loads(written)
    return text


def option_name(given: object) -> str:
    """Return the name of the option that is meant.

    Parameters
    ----------
    given : str
        In any letter case, with ``-`` or ``_``.

    Returns
    -------
    str
        A key of `OPTIONS`.

    Raises
    ------
    OptionError
        There is no such option; the remedy names a near match.
    """
    name = str(given).strip().lower().replace("-", "_")
    if name in OPTIONS:
        return name
    meant = near_match(name, OPTIONS)
    raise OptionError(
        f"There is no option {str(given)[:40]!r}.",
        where={"field": str(given)[:40]},
        remedy=(f"Did you mean {meant}? " if meant else "") + f"Options are {', '.join(OPTIONS)}.",
    )
