"""Questions about two gamuts: coverage, intersection, comparison."""

from __future__ import annotations

import os
import warnings
from typing import TYPE_CHECKING, Self

import numpy as np

from gamutcore import queries
from gamutcore.answers.base import Answering
from gamutcore.answers.conditions import comparison_warnings
from gamutcore.results import ChromaticityGamut, GamutComparison, Intersection

if TYPE_CHECKING:
    from gamutcore.answers.base import IndexedLevel
    from gamutcore.arrays import FloatArray
    from gamutcore.results import ChromaticityComparison

__all__ = ["ComparisonAnswers"]

SECTORS = 36
"""Sectors of hue of a comparison: 10° each."""


MEDIA_RELATIVE = (
    "Both gamuts are media-relative: each paper counts as white. Build both with the intent "
    "absolute to compare the papers as well."
)


class ComparisonAnswers(Answering):
    """The questions about two gamuts."""

    def compare(
        self,
        other: Self | str | os.PathLike[str],
        *,
        sectors: int = SECTORS,
        triangles: int | None = None,
        max_error: float | None = None,
    ) -> GamutComparison:
        """Compare this gamut, A, with another one, B.

        Parameters
        ----------
        other : Gamut, str or path
            In the same colour space. The name of a reference or a file is built in it, with the
            default options otherwise, unless the file is a saved gamut.
        sectors : int, optional
            Number of equal sectors of hue.
        triangles, max_error : optional
            The levels of both gamuts.

        Returns
        -------
        GamutComparison
            With `volume_a`, `volume_b`, `intersection`, `union`, `a_covers_b`, `b_covers_a`,
            `jaccard`, `symmetric_difference`, the same by sector of hue, the lightest and darkest
            colours, areas and coverage of the chromaticities, and warnings.

        Raises
        ------
        OptionError
            The gamuts are in different spaces, or the number of sectors is not accepted.
        TriangleCountError
            There is no such level.

        Examples
        --------
        >>> from gamutcore import Gamut
        >>> cube = np.array([(l, a, b) for l in (-1, 1) for a in (-1, 1) for b in (-1, 1)])
        >>> whole, part = Gamut(20 * cube + (50, 0, 0)), Gamut(10 * cube + (50, 0, 0))
        >>> round(whole.compare(part).b_covers_a, 3)
        0.125
        """
        other = self._same_space(other)
        levels = self._level(triangles, max_error), other._level(triangles, max_error)  # noqa: SLF001  # its own class
        found = queries.compare(levels[0].index, levels[1].index, sectors)
        (white_a, black_a), (white_b, black_b) = map(self._extremes, levels)
        return GamutComparison(
            found.volume_a,
            found.volume_b,
            found.intersection,
            found.hues,
            found.sectors,
            white_a=white_a,
            white_b=white_b,
            black_a=black_a,
            black_b=black_b,
            triangles=(levels[0].triangles, levels[1].triangles),
            max_error=(levels[0].max_error, levels[1].max_error),
            gamuts=(self.conditions, other.conditions),
            warnings=self.warnings_about(other),
            chromaticity=self._chromaticities(other),
        )

    def chromaticity(self) -> ChromaticityGamut | None:
        """Return the chromaticities of the gamut: a polygon in CIE 1931 xy and CIE 1976 u′v′.

        Returns
        -------
        ChromaticityGamut or None
            The triangle of the primaries of a display or an RGB space, else the convex hull of the
            gamut's own colours. None if they have no area, or the gamut is from an earlier version.

        Examples
        --------
        >>> from gamutcore import reference
        >>> found = reference("sRGB", surface_samples=1000).chromaticity()
        >>> found.basis, len(found.xy)
        ('primaries', 3)
        """
        stored = self.description.get("chromaticity")
        return None if stored is None else ChromaticityGamut.from_mapping(stored)

    def _chromaticities(self, other: ComparisonAnswers) -> ChromaticityComparison | None:
        one, two = self.chromaticity(), other.chromaticity()
        return None if one is None or two is None else one.compare(two)

    def coverage_of(self, other: Self | str | os.PathLike[str]) -> float:
        """Return the share of another gamut's volume that this gamut covers.

        Parameters
        ----------
        other : Gamut, str or path
            As for `compare`.

        Returns
        -------
        float
            Volume of the intersection ÷ volume of the other gamut, from 0 to 1.

        Warns
        -----
        UserWarning
            The gamuts have different intents, whites or conditions of measurement.

        Raises
        ------
        OptionError
            The gamuts are in different spaces.

        Examples
        --------
        >>> from gamutcore import Gamut
        >>> cube = np.array([(l, a, b) for l in (-1, 1) for a in (-1, 1) for b in (-1, 1)])
        >>> Gamut(20 * cube + (50, 0, 0)).coverage_of(Gamut(10 * cube + (50, 0, 0)))
        1.0
        """
        other = self._same_space(other)
        for warning in comparison_warnings(self.conditions, other.conditions):
            warnings.warn(warning, stacklevel=2)
        return self.compare(other, sectors=1).a_covers_b

    def warnings_about(self, other: ComparisonAnswers) -> tuple[str, ...]:
        """Return reasons why a comparison with another gamut may mislead, as `compare` does."""
        both = self.conditions, other.conditions
        relative = all(each.is_print and each.intent == "relative" for each in both)
        return (*comparison_warnings(*both), *((MEDIA_RELATIVE,) if relative else ()))

    def __and__(self, other: object) -> Intersection:
        """Return the intersection with another gamut: its volume, and its shares of both.

        Examples
        --------
        >>> from gamutcore import Gamut
        >>> cube = np.array([(l, a, b) for l in (-1, 1) for a in (-1, 1) for b in (-1, 1)])
        >>> common = Gamut(20 * cube + (50, 0, 0)) & Gamut(10 * cube + (50, 0, 0))
        >>> round(common.volume), round(common.of_first, 3)
        (8000, 0.125)
        """
        if not isinstance(other, type(self) | str | os.PathLike):
            return NotImplemented
        found = self.compare(other, sectors=1)
        return Intersection(
            found.intersection,
            found.b_covers_a,
            found.a_covers_b,
            found.jaccard,
            found.gamuts,
            found.warnings,
        )

    def _extremes(self, level: IndexedLevel) -> tuple[FloatArray, FloatArray]:
        """Return the lightest and the darkest vertex."""
        vertices = level.index.vertices
        lightness = vertices[:, self.colour_space.definition.lightness]
        return vertices[np.argmax(lightness)], vertices[np.argmin(lightness)]
