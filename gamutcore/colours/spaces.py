"""Colour spaces: their definitions, parameters, conversion, and appearance on an sRGB display.

One table names the spaces. A `ColourSpace` has a value for everything that its coordinates depend
on. It converts the colours of devices, which are CIELAB relative to ICC's D50, to its coordinates
and back. CIELAB with D50 is the identity. ``docs/colour-spaces.md`` helps to choose a space, and
``docs/decisions/colour-spaces.md`` has the reasons for these spaces and defaults.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated

import numpy as np
from pydantic import AfterValidator

from gamutcore.arguments import (
    Array,
    Choice,
    Coordinates,
    Number,
    accepted_values,
    canonical,
    check_option,
    finite_number,
)
from gamutcore.arrays import FloatArray, PositionArray
from gamutcore.characterisation.samples import JSON
from gamutcore.colours.colorimetry import (
    ADAPTATIONS,
    ICC_D50,
    WHITES,
    adaptation_matrix,
    decode_srgb,
    encode_srgb,
    lab_to_xyz,
    rgb_to_xyz,
    white_point,
    xyz_to_lab,
)
from gamutcore.colours.formulas import (
    IPT,
    OKLAB,
    SURROUNDS,
    AppearanceModel,
    Cielab,
    Cieluv,
    Ciexyz,
    Din99,
    Formula,
    Jzazbz,
    ictcp,
)
from gamutcore.errors import InvalidPointsError, MeshError, OptionError
from gamutcore.kernels import kernel, leaf_kernel
from gamutcore.number_text import number_text

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

__all__ = ["CIELAB", "SPACES", "ColourConversion", "ColourSpace", "linear_srgb", "srgb"]

DEFAULT_LUMINANCE = 203.0
"""Luminance in cd/m² of a reference white in high dynamic range (ITU-R BT.2408-7, 2.2; also CSS
Color HDR)."""

DEFAULT_ADAPTING_LUMINANCE = 64.0 / math.pi / 5.0
"""L_A in cd/m²: a fifth of a white under 64 lx, the encoding ambient of sRGB (IEC 61966-2-1,
table 4). It is also the default of other software."""

DEFAULT_BACKGROUND = 20.0
"""Y_b in per cent of the white: gray (CIE 159:2004, 7)."""

LIGHTNESS_UPWARDS = (0.7071067811865476, 0.7071067811865476, 0.0, 0.0)
"""Quaternion (x, y, z, w) of the half turn from (L*, a*, b*) to glTF's (a*, L*, −b*): L*
upwards, a* to the right, b* away from the viewer."""


_VIEWING: Mapping[str, object] = MappingProxyType(
    {
        "adapting_luminance": DEFAULT_ADAPTING_LUMINANCE,
        "background": DEFAULT_BACKGROUND,
        "surround": "average",
    }
)
_ABSOLUTE: Mapping[str, object] = MappingProxyType({"luminance": DEFAULT_LUMINANCE})


@dataclass(frozen=True, eq=False)
class SpaceDefinition:
    """A colour space before its parameters have values.

    `white` is the white of its definition, or D50 if the definition allows any. `parameters` has
    the defaults of parameters that not every space has. `source` is the publication of the
    definition, and `lightness` the axis of lightness or luminance. `is_uniform` says whether
    distances are colour differences by the definition.
    """

    axes: tuple[str, str, str]
    white: str
    formula: Callable[[ColourSpace], Formula]
    source: str
    parameters: Mapping[str, object] = field(default_factory=dict)
    lightness: int = 0
    is_uniform: bool = False


def _appearance(space: ColourSpace, adaptation: str) -> Formula:
    return AppearanceModel(
        adaptation,
        space.white,
        space.adapting_luminance or DEFAULT_ADAPTING_LUMINANCE,
        space.background or DEFAULT_BACKGROUND,
        space.surround or "average",
    )


def _luminance(space: ColourSpace) -> float:
    return space.luminance or DEFAULT_LUMINANCE


SPACES: Mapping[str, SpaceDefinition] = MappingProxyType(
    {
        "CIELAB": SpaceDefinition(
            ("L*", "a*", "b*"),
            "D50",
            lambda space: Cielab(space.white),
            "CIE 15:2018, 8.2.1",
            is_uniform=True,
        ),
        "CIELUV": SpaceDefinition(
            ("L*", "u*", "v*"),
            "D50",
            lambda space: Cieluv(space.white),
            "CIE 15:2018, 8.2.2",
            is_uniform=True,
        ),
        "CIEXYZ": SpaceDefinition(
            ("X", "Y", "Z"), "D50", lambda _: Ciexyz(), "CIE 15:2018, 7", lightness=1
        ),
        "CAM16-UCS": SpaceDefinition(
            ("J'", "a'", "b'"),
            "D50",
            lambda space: _appearance(space, "CAT16"),
            "Li et al., Color Research and Application 42 (2017)",
            _VIEWING,
            is_uniform=True,
        ),
        "CAM02-UCS": SpaceDefinition(
            ("J'", "a'", "b'"),
            "D50",
            lambda space: _appearance(space, "CAT02"),
            "CIE 159:2004; Luo, Cui and Li, Color Research and Application 31 (2006)",
            _VIEWING,
            is_uniform=True,
        ),
        "DIN99o": SpaceDefinition(
            ("L99o", "a99o", "b99o"),
            "D65",
            lambda space: Din99(space.white),
            "DIN 6176:2018",
            is_uniform=True,
        ),
        "Oklab": SpaceDefinition(("L", "a", "b"), "D65", lambda _: OKLAB, "Ottosson 2020"),
        "IPT": SpaceDefinition(
            ("I", "P", "T"),
            "D65",
            lambda _: IPT,
            "Ebner and Fairchild, 6th Color Imaging Conference (1998)",
        ),
        "ICtCp": SpaceDefinition(
            ("I", "Ct", "Cp"),
            "D65",
            lambda space: ictcp(_luminance(space)),
            "ITU-R BT.2100-2, table 7, PQ",
            _ABSOLUTE,
        ),
        "ITP": SpaceDefinition(
            ("I", "T", "P"),
            "D65",
            lambda space: ictcp(_luminance(space), itp=True),
            "ITU-R BT.2124-0, annex 1, times 720: distances are ΔE_ITP",
            _ABSOLUTE,
            is_uniform=True,
        ),
        "Jzazbz": SpaceDefinition(
            ("Jz", "az", "bz"),
            "D65",
            lambda space: Jzazbz(_luminance(space)),
            "Safdar et al., Optics Express 25 (2017)",
            _ABSOLUTE,
        ),
    }
)
"""All colour spaces by name, CIELAB first."""


@dataclass(frozen=True)
class ColourSpace:
    """A colour space with values of all its parameters.

    Attributes
    ----------
    name : str
        A key of `SPACES`.
    reference_white : str or three floats, optional
        The white that colours are adapted to, and of formulas with a white: a key of `WHITES`, or
        X, Y, Z with Y = 1. None for the space's own.
    adaptation : str, optional
        Adaptation from D50, a key of `ADAPTATIONS`; None for Bradford.
    luminance : float, optional
        Of the white in cd/m², for absolute spaces.
    adapting_luminance, background : float, optional
        L_A in cd/m² and Y_b in per cent of the white, for appearance models.
    surround : str, optional
        A key of `SURROUNDS`, for appearance models.

    Examples
    --------
    >>> space = ColourSpace("Oklab")
    >>> space.coordinates(np.array([[100.0, 0.0, 0.0]]))[0].round(3)[0, 0].item()
    1.0
    """

    name: str = "CIELAB"
    reference_white: str | tuple[float, float, float] | None = None
    adaptation: str | None = None
    luminance: float | None = None
    adapting_luminance: float | None = None
    background: float | None = None
    surround: str | None = None

    @property
    def definition(self) -> SpaceDefinition:
        """The row of `SPACES`."""
        return SPACES[self.name]

    @property
    def axes(self) -> tuple[str, str, str]:
        """Names of the coordinates."""
        return self.definition.axes

    @property
    def white(self) -> FloatArray:
        """X, Y, Z of the reference white, Y = 1."""
        if self.reference_white is None:
            return white_point(self.definition.white)
        if isinstance(self.reference_white, str):
            return white_point(self.reference_white)
        return np.array(self.reference_white)

    @property
    def rotation(self) -> tuple[float, float, float, float]:
        """Quaternion (x, y, z, w) that turns lightness to the y axis of glTF, upwards."""
        return LIGHTNESS_UPWARDS if self.definition.lightness == 0 else (0.0, 0.0, 0.0, 1.0)

    @cached_property
    def is_icc_cielab(self) -> bool:
        """Whether it is CIELAB relative to ICC's D50, the space of device colours."""
        return self.name == "CIELAB" and np.array_equal(self.white, ICC_D50)

    @cached_property
    def white_lightness(self) -> float:
        """Lightness of the white, as a measure of the size of gamuts in the space."""
        white, _ = self.coordinates(np.array([[100.0, 0.0, 0.0]]))
        return abs(float(white[0, self.definition.lightness]))

    def coordinates(self, lab: FloatArray, *, as_measured: bool = False) -> tuple[FloatArray, int]:
        """Return the coordinates of device colours.

        Parameters
        ----------
        lab : (n, 3) float
            L*, a*, b* relative to ICC's D50.
        as_measured : bool
            Whether the tristimulus values are a device's own and must not be adapted.

        Returns
        -------
        coordinates : (n, 3) float
        moved : int
            Number of colours outside the domain of the formula, which were moved to the nearest in
            it.

        Raises
        ------
        InvalidPointsError
            Coordinates are not finite, because the colours are far from all real ones.
        """
        if self.is_icc_cielab:
            return lab, 0
        with np.errstate(all="ignore"):  # the result is checked
            xyz = lab_to_xyz(lab)
        return self.from_tristimulus(xyz, as_measured=as_measured)

    def from_tristimulus(
        self, xyz: FloatArray, *, as_measured: bool = False
    ) -> tuple[FloatArray, int]:
        """Return the coordinates of tristimulus values, as `coordinates` does of CIELAB.

        `xyz` (n, 3) is relative to ICC's D50, with Y = 1 for the white.
        """
        with np.errstate(all="ignore"):  # the result is checked below
            own = xyz if as_measured else xyz @ self._from_d50(self.adaptation or "Bradford").T
            coordinates, moved = self._formula.coordinates(own)
        faulty = np.flatnonzero(~np.isfinite(coordinates).all(axis=1))
        if faulty.size:
            row = int(faulty[0])
            raise InvalidPointsError(
                f"{faulty.size} of {len(xyz)} colours have no coordinates in {self.name}. The first"
                f" is colour {row}: X, Y, Z {xyz[row].tolist()}.",
                where={"row": row},
                remedy="Send colours that exist, or give the space CIELAB.",
            )
        return np.ascontiguousarray(coordinates), int(moved.sum())

    def tristimulus(self, coordinates: PositionArray, *, as_measured: bool = False) -> FloatArray:
        """Return the tristimulus values (n, 3) of coordinates; the inverse of `from_tristimulus`.

        Values are not finite for coordinates that no colour has.
        """
        values = np.asarray(coordinates, np.float64)
        with np.errstate(all="ignore"):
            xyz = self._formula.xyz(values)
        if not as_measured:
            xyz = xyz @ np.linalg.inv(self._from_d50(self.adaptation or "Bradford")).T
        return xyz

    def appearance_lab(self, coordinates: PositionArray) -> PositionArray:
        """Return L*, a*, b* (n, 3) relative to ICC's D50 for the display of coordinates.

        They are as seen by an eye adapted to the reference white, and finite for all finite
        coordinates: the coordinates themselves in ICC's CIELAB, else float32.
        """
        if self.is_icc_cielab:
            return coordinates
        values = np.asarray(coordinates, np.float64)
        shown = "Bradford" if self.adaptation in {None, "none"} else str(self.adaptation)
        with np.errstate(all="ignore"):
            xyz = np.nan_to_num(self._formula.xyz(values), nan=0.0, posinf=1e6, neginf=-1e6)
        xyz = np.clip(xyz, -1e6, 1e6) @ np.linalg.inv(self._from_d50(shown)).T
        return np.ascontiguousarray(xyz_to_lab(xyz), np.float32)

    def description(self) -> dict[str, JSON]:
        """Return everything that the coordinates depend on, JSON-able."""
        white, _ = self._formula.coordinates(self.white[np.newaxis])
        named = self.reference_white or self.definition.white
        parameters: dict[str, JSON] = {}
        for name, default in self.definition.parameters.items():
            setting = getattr(self, name)
            value = default if setting is None else setting
            parameters[name] = value if isinstance(value, str) else round(float(str(value)), 6)
        return {
            "name": self.name,
            "axes": list[JSON](self.axes),
            "reference_white": named if isinstance(named, str) else "as given",
            "reference_white_xyz": [round(float(value), 6) for value in self.white],
            "adaptation": self.adaptation or "Bradford",
            "white_coordinates": [round(float(value), 6) + 0.0 for value in white[0]],
            **parameters,
            "source": self.definition.source,
        }

    def _from_d50(self, adaptation: str) -> FloatArray:
        return adaptation_matrix(ICC_D50, self.white, adaptation)

    @cached_property
    def _formula(self) -> Formula:
        return self.definition.formula(self)


CIELAB = ColourSpace()
"""CIELAB relative to ICC's D50."""


SPELLINGS = {
    "lab": "CIELAB",
    "luv": "CIELUV",
    "xyz": "CIEXYZ",
    "cam16": "CAM16-UCS",
    "cam02": "CAM02-UCS",
    "ciecam02": "CAM02-UCS",
    "ciecam02ucs": "CAM02-UCS",
}
"""Usual spellings of the names of colour spaces."""

SPACE = Annotated[str, Choice(tuple(SPACES), SPELLINGS)]
"""Names of colour spaces."""

MEASURED = "measured"
"""Value of ``luminance`` for the luminance of the white that the data declares."""

_WHITE_LUMINANCE = Annotated[float, Number(0.1, 10_000.0, unit="cd/m²")]

_LEAST_WHITE, _MOST_WHITE = 0.1, 5.0
"""Bounds of X and Z of a white with Y = 1. Illuminant A has Z 0.36, a blue sky Z 1.7."""

_LEAST_RESPONSE = 0.05
"""Smallest response of any cone or sensor to a white with Y = 1; illuminant A gives 0.33."""


def _white(xyz: tuple[float, float, float]) -> tuple[float, float, float]:
    """Scale a white to Y = 1; a light that is far from white is refused."""
    x, y, z = xyz
    if not 1e-6 <= y <= 1e6:
        raise ValueError("no white")
    white = (x / y, 1.0, z / y)
    # chromatic adaptation divides by the responses of the cones and sensors
    matrices = [np.array(matrix) for matrix in ADAPTATIONS.values() if matrix is not None]
    responds = all(bool((matrix @ white >= _LEAST_RESPONSE).all()) for matrix in matrices)
    if not responds or not all(_LEAST_WHITE <= part <= _MOST_WHITE for part in white):
        raise ValueError("far from white")
    return white


REFERENCE_WHITE = (
    Annotated[str, Choice(tuple(WHITES))]
    | Annotated[
        Coordinates, AfterValidator(_white), Array("X, Y, Z of a light that is nearly white", 3)
    ]
)
ADAPTATION = Annotated[str, Choice(tuple(ADAPTATIONS))]
LUMINANCE = _WHITE_LUMINANCE | Annotated[str, Choice((MEASURED,))]
ADAPTING_LUMINANCE = Annotated[float, Number(0.01, 10_000.0, unit="cd/m²")]
BACKGROUND = Annotated[float, Number(1.0, 100.0, unit="per cent of the white")]
SURROUND = Annotated[str, Choice(tuple(SURROUNDS))]

SPACE_PARAMETERS: Mapping[str, object] = MappingProxyType(
    {
        "reference_white": REFERENCE_WHITE,
        "adaptation": ADAPTATION,
        "luminance": LUMINANCE,
        "adapting_luminance": ADAPTING_LUMINANCE,
        "background": BACKGROUND,
        "surround": SURROUND,
    }
)
"""Parameters of colour spaces with the types of their values. All spaces have the first two."""


def parameter_defaults(space: str) -> dict[str, object]:
    """Return the parameters of a space with their defaults."""
    definition = SPACES[space]
    return {
        "reference_white": definition.white,
        "adaptation": "Bradford",
        **definition.parameters,
    }


def space_parameters(space: str, settings: Mapping[str, object]) -> dict[str, object]:
    """Return the parameters of a space in their canonical form, with defaults filled in.

    Parameters that the space does not have are None. So are the defaults of CIELAB, which keeps the
    ids of older gamuts.
    """
    defaults = parameter_defaults(space)
    result: dict[str, object] = {}
    for name, kind in SPACE_PARAMETERS.items():
        value = settings.get(name)
        if name not in defaults:
            if value is not None:
                raise OptionError.not_applicable(name, value, f"the space {space} has no {name}")
            result[name] = None
            continue
        settled = defaults[name] if value is None else check_option(name, value, kind)
        result[name] = None if space == "CIELAB" and settled == defaults[name] else settled
    return result


def measured_luminance(stated: object) -> float:
    """Return the luminance of a device's white, in cd/m², that its data declares.

    A missing luminance, or one out of the option's range, raises `OptionError`.
    """
    number = finite_number(stated)
    if number is None or canonical(number, _WHITE_LUMINANCE) is None:
        raise OptionError(
            "The data does not declare the luminance of its white."
            if number is None
            else f"The data declares a white of {number_text(number)} cd/m².",
            where={"field": "luminance"},
            remedy=f"Give {accepted_values(_WHITE_LUMINANCE)}.",
        )
    return number


GIVEN_SPACE = Annotated[
    str,
    Choice((*SPACES, "LCHab", "sRGB"), {**SPELLINGS, "cielchab": "LCHab", "lch": "LCHab"}),
]
"""Names of the spaces that colours may be given in, with their usual spellings."""

OTHER_AXES = {"LCHab": ("L*", "C*", "h"), "sRGB": ("R", "G", "B")}

_SRGB_PRIMARIES = ((0.64, 0.33), (0.30, 0.60), (0.15, 0.06))  # IEC 61966-2-1, table 1


class ColourConversion:
    """Conversion between the space of a gamut and another one.

    Parameters
    ----------
    given : str or None
        One of `GIVEN_SPACE`, in any spelling; None for the gamut's own space. ``LCHab`` is L*, C*
        and the hue in degrees. ``sRGB`` is encoded red, green and blue from 0 to 1, and continues
        beyond them by the same formula.
    space : ColourSpace
        The gamut's.
    as_measured : bool, optional
        Whether the colours of the gamut are a device's own, which were not adapted.

    Raises
    ------
    OptionError
        There is no such space.

    Examples
    --------
    >>> conversion = ColourConversion("sRGB", ColourSpace())
    >>> conversion.to_gamut(np.array([[1.0, 1.0, 1.0]])).round(2).tolist()
    [[100.0, 0.0, 0.0]]
    """

    def __init__(self, given: str | None, space: ColourSpace, *, as_measured: bool = False) -> None:
        self.name = space.name if given is None else str(check_option("space", given, GIVEN_SPACE))
        self._space = space
        self._as_measured = as_measured

    @property
    def axes(self) -> tuple[str, str, str]:
        """Names of the coordinates."""
        if self.name in OTHER_AXES:
            return OTHER_AXES[self.name]
        return self._space.axes if self.name == self._space.name else SPACES[self.name].axes

    def to_gamut(self, colours: FloatArray) -> FloatArray:
        """Return finite colours (n, 3) in the space of the gamut.

        Colours outside the domain of a formula are moved to the nearest in it, as in a build.
        Colours without coordinates raise `InvalidPointsError`; ``where["row"]`` is their row.
        """
        if self.name == self._space.name:
            return colours
        if self.name == "LCHab":
            hue = np.radians(colours[:, 2])
            colours = np.stack(
                [colours[:, 0], colours[:, 1] * np.cos(hue), colours[:, 1] * np.sin(hue)], axis=1
            )
            if self._space.name == "CIELAB":
                return colours
        xyz = self._xyz_of_srgb(colours) if self._given is None else self._xyz(self._given, colours)
        points, _ = self._space.from_tristimulus(xyz, as_measured=self._as_measured)
        return points

    def from_gamut(self, points: FloatArray) -> FloatArray:
        """Return points (n, 3) of the gamut's space in the other one; the inverse of `to_gamut`."""
        if self.name == self._space.name:
            return points
        if self._given is None:
            return self._srgb_of_xyz(self._xyz(self._space, points))
        if self.name == "LCHab" and self._space.name == "CIELAB":
            coordinates = points
        else:
            xyz = self._xyz(self._space, points)
            coordinates, _ = self._given.from_tristimulus(xyz, as_measured=self._as_measured)
        if self.name == "LCHab":
            hue = np.degrees(np.arctan2(coordinates[:, 2], coordinates[:, 1])) % 360.0
            return np.stack(
                [coordinates[:, 0], np.hypot(coordinates[:, 1], coordinates[:, 2]), hue], axis=1
            )
        return coordinates

    @cached_property
    def _given(self) -> ColourSpace | None:
        """The other space; None for sRGB."""
        if self.name == "sRGB":
            return None
        space = self._space
        own = space.reference_white in {None, space.definition.white}
        name = "CIELAB" if self.name == "LCHab" else self.name
        luminance = space.luminance if "luminance" in SPACES[name].parameters else None
        return ColourSpace(
            name,
            reference_white=None if own else space.reference_white,
            adaptation=space.adaptation,
            luminance=luminance,
        )

    def _xyz(self, space: ColourSpace, coordinates: FloatArray) -> FloatArray:
        xyz = space.tristimulus(coordinates, as_measured=self._as_measured)
        faulty = ~np.isfinite(xyz).all(axis=1)
        if faulty.any():
            row = int(np.argmax(faulty))
            raise InvalidPointsError(
                f"Row {row} is {coordinates[row].tolist()}, which is no colour of {space.name}.",
                where={"field": "colours", "row": row},
                remedy="Give colours that exist, in the order of the space's coordinates.",
            )
        return xyz

    def _xyz_of_srgb(self, colours: FloatArray) -> FloatArray:
        with np.errstate(over="ignore"):
            light = decode_srgb(np.abs(colours))
        xyz: FloatArray = np.copysign(light, colours) @ self._srgb_matrix.T
        return xyz

    def _srgb_of_xyz(self, xyz: FloatArray) -> FloatArray:
        light = xyz @ np.linalg.inv(self._srgb_matrix).T
        return np.copysign(encode_srgb(np.abs(light)), light)

    @property
    def _srgb_matrix(self) -> FloatArray:
        """From linear sRGB to tristimulus values that are adapted to D50."""
        d65 = white_point("D65")
        matrix = rgb_to_xyz(_SRGB_PRIMARIES, d65)
        if self._as_measured:
            return matrix
        adaptation = self._space.adaptation or "Bradford"
        adapted: FloatArray = adaptation_matrix(d65, ICC_D50, adaptation) @ matrix
        return adapted


LARGEST_COORDINATE = 1e4
"""No colour has a larger coordinate in any space."""

SMALLEST_CIELAB = 5.0
"""A gamut with a smaller extent is hardly in CIELAB, but in a space such as Oklab or XYZ, whose
coordinates are about 1."""


def declared_space(notes: Mapping[str, str]) -> ColourSpace | None:
    """Return the space that the notes of a mesh file declare; None if they name no space.

    Names of notes are in lower case: ``space``, and the parameters of spaces by their names.
    """
    if "space" not in notes:
        return None
    name = " ".join(notes["space"].split())
    space = canonical(name, SPACE)
    if not isinstance(space, str):
        raise MeshError(
            f"The mesh is in the colour space {name[:40]!r}.",
            where={"field": "space"},
            remedy=f"Send a mesh in one of {', '.join(SPACES)}.",
        )
    allowed = {"reference_white", "adaptation", *SPACES[space].parameters}
    factor = _value(notes.get("scale", "1"))  # of files that older versions wrote
    if factor != 1.0:
        raise MeshError(
            f"The mesh declares coordinates with the factor {notes['scale'][:40]!r}.",
            where={"field": "scale"},
            remedy=f"Divide the coordinates by it, and declare {space} without a scale.",
        )
    settings = {
        parameter: _value(notes[parameter])
        for parameter in SPACE_PARAMETERS
        if parameter in allowed and parameter in notes
    }
    if settings.get("adaptation") not in tuple(ADAPTATIONS):
        settings.pop("adaptation", None)  # a sentence on the colours, in exports of this package
    try:
        parameters = space_parameters(space, settings)
        if parameters["luminance"] == MEASURED:
            stated = _value(notes.get("white_luminance", ""))
            parameters["luminance"] = measured_luminance(stated)
    except OptionError as error:
        raise MeshError(
            f"The mesh declares an invalid parameter of the space {space}: {error.message}",
            where=dict(error.where),
            remedy=error.remedy,
        ) from None
    return ColourSpace(space, **parameters)  # type: ignore[arg-type]  # checked above


def _value(text: str) -> object:
    """A number, three numbers, or the text."""
    try:
        numbers = [float(word) for word in text.split()]
    except ValueError:
        return text.strip()
    return numbers[0] if len(numbers) == 1 else numbers


def check_mesh_space(
    vertices: FloatArray, declared: ColourSpace | None, requested: ColourSpace
) -> list[str]:
    """Refuse a mesh that is not in the requested space; return warnings if it declares no space.

    `vertices` are (v, 3). `declared` is the result of `declared_space`.
    """
    if declared is not None:
        _refuse_other_space(declared, requested)
    _refuse_far_vertices(vertices, requested)
    return [] if declared is not None else _assumption_warnings(vertices, requested)


def _refuse_other_space(declared: ColourSpace, requested: ColourSpace) -> None:
    """Refuse a mesh that declares another space than the requested one.

    The error names the first differing option, and all that are needed.
    """
    if declared.is_icc_cielab and requested.is_icc_cielab:
        return  # no adaptation is involved
    of_file, of_request = _all_parameters(declared), _all_parameters(requested)
    names = [name for name in of_file if not _same(of_file[name], of_request.get(name))]
    if not names:
        return
    first = names[0]
    defaults = _all_parameters(ColourSpace(declared.name))
    needed = {
        name: value
        for name, value in of_file.items()
        if name == "space" or not _same(value, defaults[name])
    }
    raise OptionError(
        f"{first} is {_text_of(of_request.get(first))}, "
        f"and {_text_of(of_file[first])} in the file.",
        where={"field": first},
        remedy="A mesh is a boundary in its own space only. Give "
        + ", ".join(f"{name} {_text_of(value)}" for name, value in needed.items())
        + ".",
    )


def _all_parameters(space: ColourSpace) -> dict[str, object]:
    """All that coordinates depend on, by the names of the options, with defaults filled in."""
    parameters: dict[str, object] = {"space": space.name}
    defaults = parameter_defaults(space.name)
    for name in SPACE_PARAMETERS:
        value = getattr(space, name)
        parameters[name] = defaults.get(name) if value is None else value
    return parameters


def _same(one: object, other: object) -> bool:
    whites = [value for value in (one, other) if isinstance(value, tuple)]
    if not whites or one is None or other is None:
        return one == other
    first, second = (
        ColourSpace(reference_white=value).white  # type: ignore[arg-type]  # checked as an option
        for value in (one, other)
    )
    return bool(np.allclose(first, second, rtol=0, atol=1e-12))


def _text_of(value: object) -> str:
    return repr(list(value) if isinstance(value, tuple) else value)


def _refuse_far_vertices(vertices: FloatArray, space: ColourSpace) -> None:
    """Refuse vertices (v, 3) beyond any colour of a space."""
    beyond = (np.abs(vertices) > LARGEST_COORDINATE).any(axis=1)
    if beyond.any():
        vertex = int(np.argmax(beyond))
        raise InvalidPointsError(
            f"Vertex {vertex} is at {[float(value) for value in vertices[vertex]]}.",
            where={"field": "vertices", "vertex": vertex},
            remedy=f"Send coordinates of colours in {space.name}.",
        )


def _assumption_warnings(vertices: FloatArray, space: ColourSpace) -> list[str]:
    """Return a warning if a mesh without a declared space is hardly in the assumed one."""
    extent = float(np.ptp(vertices, axis=0).max())
    if space.name != "CIELAB" or extent >= SMALLEST_CIELAB:
        return []
    warning = (
        "The file declares no colour space and was taken as CIELAB, but its extent is only "
        f"{number_text(extent, 3)} units. Give its space with the option space."
    )
    return [warning]


D50_TO_LINEAR_SRGB = np.array(
    [
        [3.134186364, -1.617208959, -0.490694064],
        [-0.978748504, 1.916130097, 0.033433399],
        [0.071963928, -0.228993873, 1.405753733],
    ]
)
"""XYZ relative to ICC's D50 → linear sRGB: Bradford (ICC.1:2022, annex E) to D65, then the
inverse of the matrix of the sRGB primaries (IEC 61966-2-1). The tests derive it with
colour-science."""

WHITE_X, WHITE_Z = 0.9642, 0.8249  # ICC.1:2022, 7.2.16


@leaf_kernel
def _inverse_f(value: float) -> float:
    """Inverse of CIELAB's f (CIE 15:2018, 8.2.1.1) with its linear part."""
    return value * value * value if value > 6.0 / 29.0 else (value - 4.0 / 29.0) * 108.0 / 841.0


def linear_srgb(lab: PositionArray) -> FloatArray:
    """Return linear sRGB (n, 3), 0 to 1, of CIELAB colours (n, 3) relative to ICC's D50.

    Colours are adapted to D65 by the Bradford transform and clipped to the gamut of sRGB.

    Examples
    --------
    >>> linear_srgb(np.array([[100.0, 0.0, 0.0]])).round(3).tolist()
    [[1.0, 1.0, 1.0]]
    """
    return _linear_srgb(np.ascontiguousarray(lab, np.float64))


@kernel
def _linear_srgb(lab: FloatArray) -> FloatArray:
    result = np.empty((len(lab), 3), np.float64)
    for row in range(len(lab)):
        middle = (lab[row, 0] + 16.0) / 116.0
        x = WHITE_X * _inverse_f(middle + lab[row, 1] / 500.0)
        y = _inverse_f(middle)
        z = WHITE_Z * _inverse_f(middle - lab[row, 2] / 200.0)
        for channel in range(3):
            value = (
                D50_TO_LINEAR_SRGB[channel, 0] * x
                + D50_TO_LINEAR_SRGB[channel, 1] * y
                + D50_TO_LINEAR_SRGB[channel, 2] * z
            )
            result[row, channel] = min(max(value, 0.0), 1.0)
    return result


def srgb(lab: PositionArray) -> FloatArray:
    """Return `linear_srgb` encoded by the transfer function of sRGB (IEC 61966-2-1)."""
    return encode_srgb(linear_srgb(lab))
