"""The results of questions to a gamut: arrays with the level that they are about."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from gamutcore.answers.conditions import Conditions
from gamutcore.arrays import BooleanArray, FloatArray, IndexArray, LongArray
from gamutcore.queries import ChromaticityComparison, Comparison, Rings
from gamutcore.shown import Shown

__all__ = [
    "INTERPOLATED",
    "ChromaTable",
    "ColourCrossings",
    "ColourCusps",
    "ColourSection",
    "GamutComparison",
    "GamutRings",
    "Intersection",
    "NearestColours",
    "SurfaceAnswer",
]

INTERPOLATED = "interpolated"
"""How device values are found: linearly between the vertices of the face."""


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class SurfaceAnswer(Shown):
    """Colours on the surface of a level, and the device values there.

    Attributes
    ----------
    points : (..., 3) float64
        In the space of the colours that were given.
    device : (..., k) float64 or None
        Device values from 0 to 1, interpolated in the face; None if the gamut has colours only. NaN
        for points inside the gamut, where a device has more than one value.
    channels : tuple of str
        Names of the k channels.
    device_values : str
        How the device values were found: ``"interpolated"``.
    triangles : int
        Triangle count of the level.
    max_error : float or None
        Upper bound of the distance of the level from the full boundary; None if it is not known.
    gamut : Conditions
        What the colours of the gamut are relative to.
    warnings : tuple of str
        Reasons why the answer may mislead.
    """

    points: FloatArray
    device: FloatArray | None
    channels: tuple[str, ...]
    triangles: int
    max_error: float | None
    gamut: Conditions
    warnings: tuple[str, ...] = ()
    device_values: str = INTERPOLATED


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class NearestColours(SurfaceAnswer):
    """The nearest points of the surface.

    Attributes
    ----------
    distance : (...) float64
        Euclidean distance in the space of the gamut, not negative.
    delta_e : (...) float64
        Colour difference CIE 2000 of the colours and their nearest points.
    """

    distance: FloatArray
    delta_e: FloatArray


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class MappedColours(SurfaceAnswer):
    """Colours that were mapped into the gamut.

    Attributes
    ----------
    moved : (...) bool
        Whether a colour was outside, or was compressed, and has moved by more than the tolerance
        of the level (`Gamut.tolerance`), or than `default_error` if that is smaller.
    delta_e : (...) float64
        Colour difference CIE 2000 of the colours and their images.
    """

    moved: BooleanArray
    delta_e: FloatArray


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class ColourCrossings(SurfaceAnswer):
    """All crossings of lines with the surface, line by line, along each line.

    Attributes
    ----------
    offsets : (n + 1,) int64
        The crossings of line i are those from ``offsets[i]`` to ``offsets[i + 1]``.
    t : (m,) float64
        Place on the line: 0 at its start, 1 at its end.
    entering : (m,) bool
        Whether the line enters the gamut there.
    """

    offsets: LongArray
    t: FloatArray
    entering: BooleanArray


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class ColourCusps(SurfaceAnswer):
    """Cusps: the points of largest chroma at some hues. NaN where a hue has none.

    Attributes
    ----------
    hue : (n,) float64
        In degrees.
    lightness, chroma : (n,) float64
        In the space of the gamut.
    """

    hue: FloatArray
    lightness: FloatArray
    chroma: FloatArray


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class ColourSection(SurfaceAnswer):
    """Closed polygons of a section, one after the other. A section may be empty.

    Attributes
    ----------
    offsets : (k + 1,) int32
        Polygon i has the points from ``offsets[i]`` to ``offsets[i + 1]``.
    """

    offsets: IndexArray

    @property
    def polygons(self) -> list[FloatArray]:
        """The corners of each polygon, (m, 3)."""
        return np.split(self.points, self.offsets[1:-1]) if len(self.offsets) > 1 else []


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class ChromaTable(Shown):
    """Intervals of chroma inside the gamut, for every hue and lightness.

    Attributes
    ----------
    hue : (h,) float64
        In degrees.
    lightness : (l,) float64
    offsets : (h · l + 1,) int32
        Hue i and lightness j have the intervals from ``offsets[i * l + j]`` to the next offset.
    chroma : (m, 2) float64
        Both ends of each interval.
    device : (m, 2, k) float64 or None
        Device values at the ends; NaN on the neutral axis.
    channels : tuple of str
    triangles : int
    max_error : float or None
    gamut : Conditions
    """

    hue: FloatArray
    lightness: FloatArray
    offsets: IndexArray
    chroma: FloatArray
    device: FloatArray | None
    channels: tuple[str, ...]
    triangles: int
    max_error: float | None
    gamut: Conditions

    @property
    def largest(self) -> FloatArray:
        """Largest chroma for each hue and lightness, (h, l); NaN where no colour is in gamut."""
        starts, ends = self.offsets[:-1], self.offsets[1:]
        last = np.append(self.chroma[:, 1], np.nan)[np.where(ends > starts, ends - 1, -1)]
        return last.reshape(len(self.hue), len(self.lightness))


@dataclass(frozen=True, eq=False, repr=False)
class GamutComparison(Comparison):
    """Comparison of two gamuts, A and B: volumes, coverage both ways, by sector of hue.

    Attributes
    ----------
    white_a, white_b, black_a, black_b : (3,) float64
        The lightest and the darkest colours.
    triangles : tuple of two int
        Triangle counts of the levels.
    max_error : tuple of two (float or None)
        Their error bounds.
    gamuts : tuple of two Conditions
        What the colours of A and B are relative to.
    warnings : tuple of str
        Reasons why the figures may mislead.
    chromaticity : ChromaticityComparison or None
        Area ratio and coverage in the CIE 1931 xy and the CIE 1976 u′v′ diagram. They do not depend
        on the levels. None if a gamut has no chromaticities.
    """

    white_a: FloatArray
    white_b: FloatArray
    black_a: FloatArray
    black_b: FloatArray
    triangles: tuple[int, int]
    max_error: tuple[float | None, float | None]
    gamuts: tuple[Conditions, Conditions] = field(repr=False)
    warnings: tuple[str, ...]
    chromaticity: ChromaticityComparison | None


@dataclass(frozen=True, repr=False)
class Intersection(Shown):
    """The part that two gamuts have in common, as ``press & srgb`` gives it.

    Attributes
    ----------
    volume : float
        In cubic units of the space.
    of_first, of_second : float
        Its share of the volume of each gamut.
    jaccard : float
        Its share of the volume of the union.
    gamuts, warnings : tuple
        As of `GamutComparison`.
    """

    volume: float
    of_first: float
    of_second: float
    jaccard: float
    gamuts: tuple[Conditions, Conditions] = field(repr=False)
    warnings: tuple[str, ...]


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class GamutRings(Rings):
    """Gamut rings, with the conditions of the gamut and of the reference.

    Attributes
    ----------
    gamut : Conditions
    reference_gamut : Conditions or None
    warnings : tuple of str
        Reasons why a comparison with the reference may mislead.
    """

    gamut: Conditions
    reference_gamut: Conditions | None = None
    warnings: tuple[str, ...] = ()
