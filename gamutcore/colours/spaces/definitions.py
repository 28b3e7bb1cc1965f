"""The colour spaces of boundaries: their whites, scales, luminances and viewing conditions.

One table names them all. A `ColourSpace` has a value for everything that its coordinates depend on.
It converts the colours of devices, which are CIELAB relative to ICC's D50, to its coordinates and
back. CIELAB with D50 is the identity. ``docs/colour-spaces.md`` helps to choose a space, and
``docs/decisions/colour-spaces.md`` has the reasons for these spaces and defaults.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from gamutcore.characterisation.samples import JSON
from gamutcore.colours.spaces.appearance_model import AppearanceModel
from gamutcore.colours.spaces.formulas import (
    Cielab,
    Cieluv,
    Ciexyz,
    Din99,
    Formula,
    Jzazbz,
    UniformAppearance,
    ictcp,
    ipt,
    oklab,
)
from gamutcore.colours.spaces.white_points import adaptation_matrix, white_point
from gamutcore.errors import InvalidPointsError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from gamutcore.arrays import FloatArray, PositionArray

__all__ = [
    "CIELAB",
    "DEFAULT_LUMINANCE",
    "SPACES",
    "ColourSpace",
    "SpaceDefinition",
]

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


@dataclass(frozen=True, eq=False)
class SpaceDefinition:
    """A colour space before its parameters have values.

    `white` is the white of its definition, or D50 if the definition allows any. `parameters` has
    the defaults of parameters that not every space has. `source` is the publication of the
    definition, and `lightness` the axis of lightness or luminance.
    """

    axes: tuple[str, str, str]
    white: str
    parameters: Mapping[str, object]
    formula: Callable[[ColourSpace], Formula]
    source: str
    lightness: int = 0


_VIEWING: Mapping[str, object] = MappingProxyType(
    {
        "adapting_luminance": DEFAULT_ADAPTING_LUMINANCE,
        "background": DEFAULT_BACKGROUND,
        "surround": "average",
    }
)
_ABSOLUTE: Mapping[str, object] = MappingProxyType({"luminance": DEFAULT_LUMINANCE})
_NO_OTHERS: Mapping[str, object] = MappingProxyType({})


def _appearance(name: str) -> Callable[[ColourSpace], Formula]:
    return lambda space: UniformAppearance(
        AppearanceModel(
            name,
            space.white * 100.0,
            space.adapting_luminance or DEFAULT_ADAPTING_LUMINANCE,
            space.background or DEFAULT_BACKGROUND,
            space.surround or "average",
        )
    )


def _luminance(space: ColourSpace) -> float:
    return space.luminance or DEFAULT_LUMINANCE


SPACES: Mapping[str, SpaceDefinition] = MappingProxyType(
    {
        "CIELAB": SpaceDefinition(
            ("L*", "a*", "b*"),
            "D50",
            _NO_OTHERS,
            lambda space: Cielab(space.white),
            "CIE 15:2018, 8.2.1",
        ),
        "CIELUV": SpaceDefinition(
            ("L*", "u*", "v*"),
            "D50",
            _NO_OTHERS,
            lambda space: Cieluv(space.white),
            "CIE 15:2018, 8.2.2",
        ),
        "CIEXYZ": SpaceDefinition(
            ("X", "Y", "Z"),
            "D50",
            _NO_OTHERS,
            lambda _: Ciexyz(),
            "CIE 15:2018, 7",
            lightness=1,
        ),
        "CAM16-UCS": SpaceDefinition(
            ("J'", "a'", "b'"),
            "D50",
            _VIEWING,
            _appearance("CAM16"),
            "Li et al., Color Research and Application 42 (2017)",
        ),
        "CAM02-UCS": SpaceDefinition(
            ("J'", "a'", "b'"),
            "D50",
            _VIEWING,
            _appearance("CIECAM02"),
            "CIE 159:2004; Luo, Cui and Li, Color Research and Application 31 (2006)",
        ),
        "DIN99o": SpaceDefinition(
            ("L99o", "a99o", "b99o"),
            "D65",
            _NO_OTHERS,
            lambda space: Din99(space.white),
            "DIN 6176:2018",
        ),
        "Oklab": SpaceDefinition(
            ("L", "a", "b"), "D65", _NO_OTHERS, lambda _: oklab(), "Ottosson 2020"
        ),
        "IPT": SpaceDefinition(
            ("I", "P", "T"),
            "D65",
            _NO_OTHERS,
            lambda _: ipt(),
            "Ebner and Fairchild, 6th Color Imaging Conference (1998)",
        ),
        "ICtCp": SpaceDefinition(
            ("I", "Ct", "Cp"),
            "D65",
            _ABSOLUTE,
            lambda space: ictcp(_luminance(space)),
            "ITU-R BT.2100-2, table 7, PQ",
        ),
        "ITP": SpaceDefinition(
            ("I", "T", "P"),
            "D65",
            _ABSOLUTE,
            lambda space: ictcp(_luminance(space), itp=True),
            "ITU-R BT.2124-0, annex 1, times 720: distances are ΔE_ITP",
        ),
        "Jzazbz": SpaceDefinition(
            ("Jz", "az", "bz"),
            "D65",
            _ABSOLUTE,
            lambda space: Jzazbz(_luminance(space)),
            "Safdar et al., Optics Express 25 (2017)",
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
    scale : float, optional
        Factor of all coordinates; None for 1.
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
    scale: float | None = None
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
        """Whether it is unscaled CIELAB relative to ICC's D50, the space of device colours."""
        white = white_point("D50")
        return (
            self.name == "CIELAB"
            and np.array_equal(self.white, white)
            and self.scale in {None, 1.0}
        )

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
            xyz = Cielab(white_point("D50")).xyz(np.asarray(lab, np.float64))
        return self.from_tristimulus(xyz, as_measured=as_measured)

    def from_tristimulus(
        self, xyz: FloatArray, *, as_measured: bool = False
    ) -> tuple[FloatArray, int]:
        """Return the coordinates of tristimulus values.

        Parameters
        ----------
        xyz : (n, 3) float
            X, Y, Z relative to ICC's D50, Y = 1 for the white.
        as_measured : bool
            Whether the values are a device's own and must not be adapted.

        Returns
        -------
        coordinates : (n, 3) float
        moved : int
            As for `coordinates`.

        Raises
        ------
        InvalidPointsError
            As for `coordinates`.
        """
        with np.errstate(all="ignore"):  # the result is checked below
            own = xyz if as_measured else xyz @ self._from_d50(self.adaptation or "Bradford").T
            coordinates, moved = self._formula.coordinates(own)
            coordinates = coordinates * (self.scale or 1.0)
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
        """Return the tristimulus values of coordinates; the inverse of `from_tristimulus`.

        Parameters
        ----------
        coordinates : (n, 3) float
        as_measured : bool
            As for `from_tristimulus`.

        Returns
        -------
        (n, 3) float
            X, Y, Z relative to ICC's D50. Not finite for coordinates that no colour has.
        """
        given = np.asarray(coordinates, np.float64) / (self.scale or 1.0)
        with np.errstate(all="ignore"):
            xyz = self._formula.xyz(given)
        if as_measured:
            return xyz
        adapted: FloatArray = xyz @ np.linalg.inv(self._from_d50(self.adaptation or "Bradford")).T
        return adapted

    def appearance_lab(self, coordinates: PositionArray) -> PositionArray:
        """Return L*, a*, b* relative to ICC's D50 for the display of coordinates.

        Parameters
        ----------
        coordinates : (n, 3) float

        Returns
        -------
        (n, 3) float
            As seen by an eye adapted to the reference white; finite for all finite coordinates. The
            coordinates themselves in ICC's CIELAB, else float32.
        """
        if self.is_icc_cielab:
            return coordinates
        given = np.asarray(coordinates, np.float64) / (self.scale or 1.0)
        shown = "Bradford" if self.adaptation in {None, "none"} else str(self.adaptation)
        with np.errstate(all="ignore"):
            xyz = np.nan_to_num(self._formula.xyz(given), nan=0.0, posinf=1e6, neginf=-1e6)
        xyz = np.clip(xyz, -1e6, 1e6) @ np.linalg.inv(self._from_d50(shown)).T
        lab, _ = Cielab(white_point("D50")).coordinates(xyz)
        return np.ascontiguousarray(lab, np.float32)

    def description(self) -> dict[str, JSON]:
        """Return everything that the coordinates depend on, JSON-able."""
        white, _ = self._formula.coordinates(self.white[np.newaxis])
        named = self.reference_white or self.definition.white
        parameters: dict[str, JSON] = {}
        for name, default in self.definition.parameters.items():
            given = getattr(self, name)
            value = default if given is None else given
            parameters[name] = value if isinstance(value, str) else round(float(str(value)), 6)
        return {
            "name": self.name,
            "axes": list[JSON](self.axes),
            "reference_white": named if isinstance(named, str) else "as given",
            "reference_white_xyz": [round(float(value), 6) for value in self.white],
            "adaptation": self.adaptation or "Bradford",
            "scale": self.scale or 1.0,
            "white_coordinates": [
                round(float(value) * (self.scale or 1.0), 6) + 0.0 for value in white[0]
            ],
            **parameters,
            "source": self.definition.source,
        }

    def _from_d50(self, adaptation: str) -> FloatArray:
        return adaptation_matrix(white_point("D50"), self.white, adaptation)

    @cached_property
    def _formula(self) -> Formula:
        return self.definition.formula(self)


CIELAB = ColourSpace()
"""CIELAB relative to ICC's D50."""
