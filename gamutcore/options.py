"""The options that a gamut is built with: one immutable value, checked when it is made.

Together with the digest of the input and the version of the algorithm they are a gamut's
identity, so defaults are always made explicit and equal options have one canonical form.
"""

from __future__ import annotations

import dataclasses
import json
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

from gamutcore.boundary import BOUNDARIES
from gamutcore.characterisation.conditions import condition_label
from gamutcore.colours.device.cube_surface import MAX_SURFACE_SAMPLES
from gamutcore.colours.device.model import DEVICE_MODELS
from gamutcore.colours.spaces import SPACES, ColourSpace
from gamutcore.colours.spaces.parameters import (
    MEASURED,
    SPACE_PARAMETERS,
    measured_luminance,
    space_parameters,
)
from gamutcore.colours.spectral import ILLUMINANTS, OBSERVERS
from gamutcore.colours.surface import INTENTS
from gamutcore.decimation.costs import COSTS
from gamutcore.errors import OptionError
from gamutcore.numbers import finite_number

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = ["SPACES", "Centre", "Options"]

Centre: TypeAlias = "tuple[float, float, float] | str"

METHOD_OPTIONS = ("gamma", "segments", "basis", "subdivisions")
"""Options that not every boundary method has; `BOUNDARIES` says which has which."""

SOURCES = ("transforms", "measurements", "boundary")
"""What of an ICC profile is used: its transforms, or the measurements or the gamut boundary that it
carries."""

MOST_INK = {"ink_limit": 1500.0, "black_limit": 100.0}
"""Per cent of ink that limits can allow at most: fifteen inks in full, and one."""

MAX_CONDITION_LENGTH = 80

FEWEST_SURFACE_SAMPLES = 8
"""The corners of the cube of three inks."""


@dataclass(frozen=True)
class Options:
    """How a gamut is built.

    Attributes
    ----------
    space : str
        Colour space of the boundary; one of `gamutcore.colours.spaces.SPACES`. It decides which of
        its parameters apply, see there: those that do have their defaults where they are not given
        (None in CIELAB), those that do not are None, and refused where they are given.
    boundary : str
        How the colours are wrapped; one of `gamutcore.boundary.BOUNDARIES`. It decides which of
        the next four apply. Those that do have their defaults where they are not given; those that
        do not are None, and refused where they are given.
    gamma : float or None
        Power that radii are raised to, in (0, 1]: 0.2 for the modified convex hull, 0.05 for USV,
        and always 1 for the convex hull, which is the modified one with that power.
    segments : tuple of two int, or None
        Polar and azimuth segments of segment maxima, (16, 16).
    basis : str or None
        The body whose faces USV splits into segments, "icosahedron".
    subdivisions : int or None
        How often USV splits them, 4.
    centre : "auto" or three floats
        The point that radii are taken from.
    cost : str
        What makes a collapse cheap; one of `gamutcore.decimation.COSTS`.
    surface_samples : int
        How many points a device model is asked for at most.
    intent : str
        Rendering intent; one of `gamutcore.colours.INTENTS`.
    source : str or None
        "measurements" for those that an ICC profile carries, "boundary" for the gamut boundary that
        an iccMAX profile describes; None for its transforms ("transforms" means the same), and for
        all other data.
    device_model : str or None
        What measured samples with device values get: "interpolation", n-linear, of complete grids
        only, or a "fit" of radial basis functions; None for interpolation of complete grids and a
        fit to other samples.
    ink_limit : float or None
        Largest sum of all inks, in per cent, above 0; None without a limit.
    black_limit : float or None
        Most of the black ink, in per cent, 0 to 100; None without a limit.
    observer : int or None
        Standard observer that spectra are integrated with, 2 or 10 degrees; None where the one is
        used that data of spectra alone states, or 2.
    illuminant : str or None
        What reflectance spectra are seen under, one of `gamutcore.colours.spectral.ILLUMINANTS`;
        None where the one is used that data of spectra alone states, or D50.
    condition : str or None
        The measurement condition to be used of data that has several, such as ``"M1"``.
    reference_white : str, three floats, or None
        White of the space that colours are adapted to: a name, or X, Y, Z, kept with Y = 1.
    adaptation : str or None
        How: one of `gamutcore.colours.spaces.white_points.ADAPTATIONS`.
        It is used for the way from the
        measured or a picture's white to D50 as well.
    scale : float or None
        What all coordinates are multiplied by.
    luminance : float, "measured" or None
        Of the white in cd/m², for ICtCp, ITP and Jzazbz; "measured" for what the data states.
    adapting_luminance, background : float or None
        L_A in cd/m² and Y_b in per cent of the white, for CAM16-UCS and CAM02-UCS.
    surround : str or None
        "average", "dim" or "dark", for the same.
    popularity : float or None
        Which part of a picture's pixels is left out: those of its least used colours. Above 0,
        below 1; None for all colours.

    Raises
    ------
    OptionError
        If a value is not accepted; ``where["field"]`` names the option.
    """

    space: str = "CIELAB"
    boundary: str = "modified-convex-hull"
    gamma: float | None = None
    segments: tuple[int, int] | None = None
    basis: str | None = None
    subdivisions: int | None = None
    centre: Centre = "auto"
    cost: str = "volume"
    surface_samples: int = 100_000
    intent: str = "relative"
    source: str | None = None
    device_model: str | None = None
    ink_limit: float | None = None
    black_limit: float | None = None
    observer: int | None = None
    illuminant: str | None = None
    condition: str | None = None
    reference_white: str | tuple[float, float, float] | None = None
    adaptation: str | None = None
    scale: float | None = None
    luminance: float | str | None = None
    adapting_luminance: float | None = None
    background: float | None = None
    surround: str | None = None
    popularity: float | None = None

    def __post_init__(self) -> None:
        for name, accepted in (
            ("space", tuple(SPACES)),
            ("boundary", tuple(BOUNDARIES)),
            ("cost", COSTS),
            ("intent", INTENTS),
        ):
            value = getattr(self, name)
            if not isinstance(value, str) or value not in accepted:
                raise OptionError.refusal(name, value, f"one of {', '.join(accepted)}")
        samples = self.surface_samples
        if (
            isinstance(samples, bool)
            or not isinstance(samples, int)
            or not FEWEST_SURFACE_SAMPLES <= samples <= MAX_SURFACE_SAMPLES
        ):
            raise OptionError.refusal(
                "surface_samples",
                samples,
                f"a whole number from {FEWEST_SURFACE_SAMPLES} to {MAX_SURFACE_SAMPLES}",
            )
        if self.source is not None and (
            not isinstance(self.source, str) or self.source not in SOURCES
        ):
            raise OptionError.refusal("source", self.source, f"one of {', '.join(SOURCES)}")
        # One form for what means the same; None keeps the ids of gamuts without this option.
        object.__setattr__(self, "source", None if self.source == SOURCES[0] else self.source)
        if self.device_model is not None and (
            not isinstance(self.device_model, str) or self.device_model not in DEVICE_MODELS
        ):
            raise OptionError.refusal(
                "device_model", self.device_model, f"one of {', '.join(DEVICE_MODELS)}"
            )
        for name, most in MOST_INK.items():
            object.__setattr__(self, name, _ink_limit(name, getattr(self, name), most))
        # frozen, so set this way: the canonical form of what was given
        object.__setattr__(self, "centre", _canonical_centre(self.centre))
        self._check_measurement()
        given_to_space = {name: getattr(self, name) for name in SPACE_PARAMETERS}
        for name, value in space_parameters(self.space, given_to_space).items():
            object.__setattr__(self, name, value)
        if self.popularity is not None:
            share = finite_number(self.popularity)
            if share is None or not 0 < share < 1:
                raise OptionError.refusal(
                    "popularity", self.popularity, "a number above 0 and below 1"
                )
            object.__setattr__(self, "popularity", share)
        parameters = BOUNDARIES[self.boundary].parameters
        for name in METHOD_OPTIONS:
            value = getattr(self, name)
            if name in parameters:
                given = parameters[name].default if value is None else value
                object.__setattr__(self, name, parameters[name].checked(given))
            elif value is not None:
                raise OptionError.not_applicable(
                    name, value, f"the boundary {self.boundary} has no {name}"
                )

    def _check_measurement(self) -> None:
        """Check and set the options of measured samples, which have no defaults of their own."""
        observer, illuminant, condition = self.observer, self.illuminant, self.condition
        if observer is not None and (isinstance(observer, bool) or observer not in OBSERVERS):
            raise OptionError.refusal("observer", observer, "2 or 10, in degrees")
        if illuminant is not None:
            name = illuminant.strip().upper() if isinstance(illuminant, str) else ""
            name = f"FL{name[1:]}" if name.startswith("F") and name[1:].isdigit() else name
            if name not in ILLUMINANTS:
                raise OptionError.refusal(
                    "illuminant", illuminant, f"one of {', '.join(ILLUMINANTS)}"
                )
            object.__setattr__(self, "illuminant", name)
        if observer is not None:
            object.__setattr__(self, "observer", int(observer))
        if condition is not None:
            if (
                not isinstance(condition, str)
                or not condition.strip()
                or len(condition) > MAX_CONDITION_LENGTH
                or not condition.isprintable()
            ):
                raise OptionError.refusal(
                    "condition", condition, "the name of a measurement condition, such as 'M1'"
                )
            folded = " ".join(condition.split())
            # "m1" and "M1" are one question; "M1, black backing" is another
            label = condition_label(folded)
            same = label.lower() == folded.lower()
            object.__setattr__(self, "condition", label if same else folded)

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, object]) -> Options:
        """Return options from names and values, such as parsed JSON; the rest have their defaults.

        Parameters
        ----------
        mapping : mapping of str

        Returns
        -------
        Options

        Raises
        ------
        OptionError
            If a name is unknown or a value is not accepted.
        """
        names = [field.name for field in dataclasses.fields(cls)]
        for name, value in mapping.items():
            if name not in names:
                raise OptionError(
                    f"There is no option {str(name)[:40]!r}.",
                    where={"field": str(name)[:40]},
                    remedy=f"Options are {', '.join(names)}.",
                )
            if value is None:  # to the constructor it means: not given
                raise OptionError.refusal(name, value, "a value, or leave it out for the default")
        return cls(**mapping)  # type: ignore[arg-type]  # the constructor checks every value

    def to_mapping(self) -> dict[str, object]:
        """Return all options that apply, as JSON-able values; `from_mapping` reads them back."""
        return {
            name: list(value) if isinstance(value, tuple) else value
            for name, value in dataclasses.asdict(self).items()
            if value is not None
        }

    @property
    def boundary_parameters(self) -> dict[str, object]:
        """What the boundary method is called with beside the points and the centre."""
        return {name: getattr(self, name) for name in BOUNDARIES[self.boundary].parameters}

    def colour_space(self, white_luminance: object = None) -> ColourSpace:
        """Return the space that the boundary lives in, with its parameters.

        Parameters
        ----------
        white_luminance : float, optional
            What the data states, in cd/m²; for the luminance "measured".

        Returns
        -------
        ColourSpace

        Raises
        ------
        OptionError
            The luminance is to be the measured one, and there is none.
        """
        parameters = {name: getattr(self, name) for name in SPACE_PARAMETERS}
        if self.luminance == MEASURED:
            parameters["luminance"] = measured_luminance(white_luminance)
        return ColourSpace(self.space, **parameters)

    @property
    def canonical(self) -> str:
        """The options as one text: JSON with sorted names and shortest numbers."""
        return json.dumps(self.to_mapping(), sort_keys=True, separators=(",", ":"))


def _canonical_centre(centre: object) -> Centre:
    if centre == "auto":
        return "auto"
    if isinstance(centre, list | tuple) and len(centre) == 3:
        numbers = [finite_number(value) for value in centre]
        first, second, third = numbers
        if first is not None and second is not None and third is not None:
            return (first, second, third)
    raise OptionError.refusal("centre", centre, "'auto' or three finite numbers")


def _ink_limit(name: str, value: object, most: float) -> float | None:
    if value is None:
        return None
    number = finite_number(value)
    if number is None or not 0 <= number <= most or (number == 0 and name == "ink_limit"):
        above = "above 0, up to" if name == "ink_limit" else "from 0 to"
        raise OptionError.refusal(name, value, f"a number {above} {most:g}, in per cent")
    return number
