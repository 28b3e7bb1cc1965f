"""Conversion of colours between the space of a gamut and other spaces.

A space is that of a gamut with the same options: its own white unless the gamut's option names
another one, and the adaptation that the gamut states. The L*, a*, b* in a measurement file are
therefore the CIELAB of every gamut that is built from the file, whatever the gamut's space.
"""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Annotated

import numpy as np

from gamutcore.arguments import Choice, check_option
from gamutcore.colours.spaces.definitions import SPACES, ColourSpace
from gamutcore.colours.spaces.parameters import SPELLINGS
from gamutcore.colours.spaces.white_points import adaptation_matrix, rgb_to_xyz, white_point
from gamutcore.errors import InvalidPointsError

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray

__all__ = ["GIVEN_SPACE", "OTHER_AXES", "ColourConversion"]

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

    @property
    def unscaled(self) -> bool:
        """Whether the coordinates are those of the space's definition, without a factor."""
        return self.name != self._space.name or self._space.scale in {None, 1.0}

    def to_gamut(self, colours: FloatArray) -> FloatArray:
        """Return colours in the space of the gamut.

        Parameters
        ----------
        colours : (n, 3) float
            Finite.

        Returns
        -------
        (n, 3) float64
            Colours outside the domain of a formula are moved to the nearest in it, as in a build.

        Raises
        ------
        InvalidPointsError
            A colour has no coordinates; ``where["row"]`` is its row.
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
        found, _ = self._space.from_tristimulus(xyz, as_measured=self._as_measured)
        return found

    def from_gamut(self, points: FloatArray) -> FloatArray:
        """Return points of the gamut's space in the other space; the inverse of `to_gamut`.

        Parameters
        ----------
        points : (n, 3) float

        Returns
        -------
        (n, 3) float64
        """
        if self.name == self._space.name:
            return points
        if self._given is None:
            return self._srgb_of_xyz(self._xyz(self._space, points))
        if self.name == "LCHab" and self._space.name == "CIELAB":
            found = points
        else:
            xyz = self._xyz(self._space, points)
            found, _ = self._given.from_tristimulus(xyz, as_measured=self._as_measured)
        if self.name == "LCHab":
            hue = np.degrees(np.arctan2(found[:, 2], found[:, 1])) % 360.0
            return np.stack([found[:, 0], np.hypot(found[:, 1], found[:, 2]), hue], axis=1)
        return found

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
        size = np.abs(colours)
        with np.errstate(over="ignore"):
            light = np.where(size <= 0.04045, size / 12.92, ((size + 0.055) / 1.055) ** 2.4)
        xyz: FloatArray = np.copysign(light, colours) @ self._srgb_matrix.T
        return xyz

    def _srgb_of_xyz(self, xyz: FloatArray) -> FloatArray:
        light = xyz @ np.linalg.inv(self._srgb_matrix).T
        size = np.abs(light)
        encoded = np.where(size <= 0.0031308, 12.92 * size, 1.055 * size ** (1 / 2.4) - 0.055)
        return np.copysign(encoded, light)

    @property
    def _srgb_matrix(self) -> FloatArray:
        """From linear sRGB to tristimulus values that are adapted to D50."""
        d65 = white_point("D65")
        matrix = rgb_to_xyz(_SRGB_PRIMARIES, d65)
        if self._as_measured:
            return matrix
        adapted: FloatArray = (
            adaptation_matrix(d65, white_point("D50"), self._space.adaptation or "Bradford")
            @ matrix
        )
        return adapted
