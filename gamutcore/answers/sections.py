"""Questions about the shape of a gamut: cusps, slices, hue leaves, tables of chroma, rings."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Self

import numpy as np

from gamutcore import queries
from gamutcore.answers.base import Answering
from gamutcore.answers.conditions import comparison_warnings
from gamutcore.arguments import WholeNumber, check_option
from gamutcore.colour_rows import colour_rows
from gamutcore.errors import OptionError
from gamutcore.queries import RING_LIGHTNESSES
from gamutcore.results import ChromaTable, ColourCusps, ColourSection, GamutRings

if TYPE_CHECKING:
    import os

    from numpy.typing import ArrayLike

    from gamutcore.answers.base import IndexedLevel
    from gamutcore.arrays import FloatArray

__all__ = ["SectionAnswers", "hue_angles"]

MOST_HUES = 36_000
"""Largest number of equidistant hues: hundredths of a degree."""


def hue_angles(hues: int | ArrayLike) -> FloatArray:
    """Return hues in degrees: those given, or a number of equidistant ones from 0° on.

    Examples
    --------
    >>> hue_angles(4).tolist(), hue_angles([40]).tolist()
    ([0.0, 90.0, 180.0, 270.0], [40.0])
    """
    if isinstance(hues, int | np.integer):
        check_option("hues", int(hues), Annotated[int, WholeNumber(1, MOST_HUES)])
        return np.linspace(0.0, 360.0, int(hues), endpoint=False)
    return np.atleast_1d(np.asarray(hues, np.float64))


class SectionAnswers(Answering):
    """The questions about the shape of a gamut."""

    def cusps(
        self,
        hues: int | ArrayLike = 360,
        *,
        triangles: int | None = None,
        max_error: float | None = None,
    ) -> ColourCusps:
        """Return the cusps: the points of largest chroma at some hues.

        Parameters
        ----------
        hues : int or (n,) array_like, optional
            Number of equidistant hues from 0° on, or hues in degrees.
        triangles, max_error : optional
            The level.

        Returns
        -------
        ColourCusps
            With `hue`, `lightness`, `chroma`, `points` and `device`. NaN where a hue has no colour.

        Raises
        ------
        InvalidPointsError
            A hue is not a finite number.
        OptionError
            The space has no hue, as CIEXYZ, or a count and a limit are given.
        TriangleCountError
            There is no such level.

        Examples
        --------
        >>> from gamutcore import Gamut
        >>> cube = [(l, a, b) for l in (40, 60) for a in (-10, 10) for b in (-10, 10)]
        >>> Gamut(cube).cusps([0, 45]).chroma.round(2).tolist()
        [10.0, 14.14]
        """
        angles = hue_angles(hues)
        level = self._level_with_hue(triangles, max_error)
        found = queries.cusp_points(angles, level.index)
        device, channels = self._device(level, found.faces, found.weights)
        return ColourCusps(
            points=found.points,
            device=device,
            channels=channels,
            triangles=level.triangles,
            max_error=level.max_error,
            gamut=self.conditions,
            hue=angles,
            lightness=found.points[:, 0],
            chroma=found.chroma,
        )

    def max_chroma(
        self,
        lightness: ArrayLike,
        hue: ArrayLike,
        *,
        triangles: int | None = None,
        max_error: float | None = None,
    ) -> FloatArray:
        """Return the largest chroma at lightnesses and hues.

        Parameters
        ----------
        lightness, hue : array_like
            Broadcast against each other. The hue is in degrees.
        triangles, max_error : optional
            The level.

        Returns
        -------
        (...) float64
            NaN where no colour is in gamut.

        Raises
        ------
        InvalidPointsError, OptionError, TriangleCountError
            As for `cusps`.

        Examples
        --------
        >>> from gamutcore import Gamut
        >>> cube = [(l, a, b) for l in (40, 60) for a in (-10, 10) for b in (-10, 10)]
        >>> Gamut(cube).max_chroma(50, [0, 45]).round(2).tolist()
        [10.0, 14.14]
        """
        level = self._level_with_hue(triangles, max_error)
        light, angle = np.broadcast_arrays(*(np.asarray(each, float) for each in (lightness, hue)))
        turn = np.radians(angle)
        ends = np.stack([light, np.cos(turn), np.sin(turn)], axis=-1)
        rows = colour_rows(ends, "lightness and hue")
        starts = rows.points * (1.0, 0.0, 0.0)
        found = queries.crossings(starts, rows.points, level.index, "ray")
        chroma = np.full(len(starts), np.nan)
        crossed = found.offsets[1:] > found.offsets[:-1]
        chroma[crossed] = found.t[found.offsets[1:][crossed] - 1]
        return rows.in_shape(chroma)

    def slice(
        self,
        L: float | None = None,
        *,
        hue: float | None = None,
        plane: ArrayLike | None = None,
        triangles: int | None = None,
        max_error: float | None = None,
    ) -> ColourSection:
        """Return the section by a plane of constant lightness, by a hue, or by any plane.

        Parameters
        ----------
        L : float, optional
            Lightness, the first coordinate (the second in CIEXYZ).
        hue : float, optional
            Hue in degrees: the half-plane of `leaf`.
        plane : (4,) array_like, optional
            a, b, c, d: the points with a x + b y + c z = d.
        triangles, max_error : optional
            The level.

        Returns
        -------
        ColourSection
            With `polygons`, `points` and `device`.

        Raises
        ------
        InvalidPointsError
            A number is not finite, or the plane has no direction.
        OptionError
            Not exactly one of `L`, `hue` and `plane` is given, or the space has no hue.
        TriangleCountError
            There is no such level.

        Examples
        --------
        >>> from gamutcore import Gamut
        >>> cube = [(l, a, b) for l in (40, 60) for a in (-10, 10) for b in (-10, 10)]
        >>> (square,) = Gamut(cube).slice(L=50).polygons
        >>> np.abs(square[:, 1:]).max().round(3).item()
        10.0
        """
        values = {"L": L, "hue": hue, "plane": plane}
        given = [name for name, value in values.items() if value is not None]
        if len(given) != 1:
            raise OptionError(
                f"{' and '.join(given) or 'Nothing'} is given.",
                where={"field": given[1] if given else "L"},
                remedy="Give one of L, hue and plane.",
            )
        if hue is not None:
            return self.leaf(hue, triangles=triangles, max_error=max_error)
        level = self._level(triangles, max_error)
        numbers = np.asarray(plane, np.float64)
        if L is not None:
            numbers = np.append(np.eye(3)[self.colour_space.definition.lightness], L)
        elif numbers.shape != (4,):
            raise OptionError.refusal("plane", plane, "four numbers a, b, c, d")
        return self._section(level, queries.slice_polygons(level.index, numbers[:3], numbers[3]))

    def leaf(
        self, hue: float, *, triangles: int | None = None, max_error: float | None = None
    ) -> ColourSection:
        """Return the hue leaf: the section by the half-plane of a hue.

        Parameters
        ----------
        hue : float
            In degrees.
        triangles, max_error : optional
            The level.

        Returns
        -------
        ColourSection
            A leaf may have several polygons, and need not contain the neutral axis. Device values
            of corners on the axis, which are inside, are those of the surface above or below.

        Raises
        ------
        InvalidPointsError, OptionError, TriangleCountError
            As for `slice`.

        Examples
        --------
        >>> from gamutcore import Gamut
        >>> cube = [(l, a, b) for l in (40, 60) for a in (-10, 10) for b in (-10, 10)]
        >>> len(Gamut(cube).leaf(hue=0).polygons)
        1
        """
        level = self._level_with_hue(triangles, max_error)
        return self._section(level, queries.hue_leaf(level.index, hue))

    def leaves(
        self,
        hues: int | ArrayLike = 360,
        lightness: int | ArrayLike = 101,
        *,
        triangles: int | None = None,
        max_error: float | None = None,
    ) -> ChromaTable:
        """Return the table of chroma: the intervals in gamut for every hue and lightness.

        Parameters
        ----------
        hues : int or (h,) array_like, optional
            As for `cusps`.
        lightness : int or (l,) array_like, optional
            Number of equidistant lightnesses from 0 to that of white, or lightnesses.
        triangles, max_error : optional
            The level.

        Returns
        -------
        ChromaTable
            With `largest`, the largest chroma as an array, beside all intervals.

        Raises
        ------
        InvalidPointsError, OptionError, TriangleCountError
            As for `cusps`.

        Examples
        --------
        >>> from gamutcore import Gamut
        >>> cube = [(l, a, b) for l in (40, 60) for a in (-10, 10) for b in (-10, 10)]
        >>> Gamut(cube).leaves([0, 45], [50, 70]).largest.round(2).tolist()
        [[10.0, nan], [14.14, nan]]
        """
        if isinstance(lightness, int | np.integer):
            check_option("lightness", int(lightness), Annotated[int, WholeNumber(2, MOST_HUES)])
            heights = np.linspace(0.0, self.colour_space.white_lightness, int(lightness))
        else:
            heights = np.atleast_1d(np.asarray(lightness, np.float64))
        level = self._level_with_hue(triangles, max_error)
        found = queries.leaves(level.index, hue_angles(hues), heights)
        faces, weights = found.faces.reshape(-1), found.weights.reshape(-1, 3)
        device, channels = self._device(level, faces, weights)
        if device is not None:
            device = device.reshape(len(found.chroma), 2, device.shape[1])
        return ChromaTable(
            hue=found.hues,
            lightness=found.lightness,
            offsets=found.offsets,
            chroma=found.chroma,
            device=device,
            channels=channels,
            triangles=level.triangles,
            max_error=level.max_error,
            gamut=self.conditions,
        )

    def rings(
        self,
        reference: Self | str | os.PathLike[str] | None = None,
        *,
        lightness: ArrayLike | None = None,
        sectors: int = 360,
        triangles: int | None = None,
        max_error: float | None = None,
    ) -> GamutRings:
        """Return the gamut rings, alone or with those of a reference and the intersection.

        Parameters
        ----------
        reference : Gamut, str or path, optional
            In the same colour space; the name of a reference or a file as for `compare`.
        lightness : (n,) array_like, optional
            Of the rings, in increasing order; tenths of the lightness of white by default, which
            are those of the standard, 10 to 100, in CIELAB.
        sectors : int, optional
            Number of equal sectors of hue.
        triangles, max_error : optional
            The levels.

        Returns
        -------
        GamutRings
            The area within a ring is the volume of the gamut up to its lightness. Warnings name
            differences of intent or white from the reference.

        Raises
        ------
        InvalidPointsError, OptionError, TriangleCountError
            As for `cusps`; also for a reference in another space.

        Notes
        -----
        IDMS 1.1, section 5.32; Smith and Masaoka.

        Examples
        --------
        >>> from gamutcore import Gamut
        >>> cube = [(l, a, b) for l in (40, 60) for a in (-10, 10) for b in (-10, 10)]
        >>> round(Gamut(cube).rings().volume)
        8000
        """
        level = self._level_with_hue(triangles, max_error)
        if lightness is None:
            # the white of Oklab has the lightness 0.999999 by the published matrices
            white = float(f"{self.colour_space.white_lightness:.5g}")
            lightness = np.asarray(RING_LIGHTNESSES) / 100.0 * white
        other, against = None, None
        warnings: tuple[str, ...] = ()
        if reference is not None:
            reference = self._same_space(reference)
            other = reference._level(triangles, max_error).index  # noqa: SLF001  # its own class
            against = reference.conditions
            warnings = comparison_warnings(self.conditions, against, ("the gamut", "the reference"))
        found = queries.gamut_rings(level.index, other, lightness, sectors)
        return replace(found, gamut=self.conditions, reference_gamut=against, warnings=warnings)

    def _section(self, level: IndexedLevel, found: queries.Section) -> ColourSection:
        device, channels = self._device(level, found.faces, found.weights)
        return ColourSection(
            points=found.points,
            device=device,
            channels=channels,
            triangles=level.triangles,
            max_error=level.max_error,
            gamut=self.conditions,
            offsets=found.offsets,
        )
