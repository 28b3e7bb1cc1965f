"""Chromaticity gamuts: polygons in the CIE 1931 xy and the CIE 1976 u′v′ diagram, and their areas.

A chromaticity gamut has no lightness. Its area and coverage are the figures that display makers
state; they say less than the volume. The map from xy to u′v′ is projective, so it keeps straight
lines: one polygon serves both diagrams.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from gamutcore.arrays import FloatArray
from gamutcore.references import REFERENCES
from gamutcore.shown import Shown

__all__ = [
    "CHROMATICITY_STANDARDS",
    "DIAGRAMS",
    "AreaOverlap",
    "ChromaticityComparison",
    "ChromaticityGamut",
    "chromaticity_gamut",
]

DIAGRAMS = ("xy", "uv")
"""CIE 1931 x, y and CIE 1976 u′, v′."""

LEAST_LUMINANCE = 0.01
"""Smallest luminance of colours in a hull, in parts of the white's: L* 9. The chromaticities of
darker colours are mostly measurement noise and flare."""

DIGITS = 7
"""Decimals of chromaticities and their figures in descriptions."""

Polygon = FloatArray
"""Corners of a convex polygon, (n, 2), counter-clockwise."""


@dataclass(frozen=True, eq=False, repr=False)
class AreaOverlap(Shown):
    """Areas of two chromaticity gamuts and of their intersection, in one diagram.

    Attributes
    ----------
    area_a, area_b, intersection : float
    area_ratio : float
        Area of A ÷ area of B.
    a_covers_b, b_covers_a : float
        Intersection ÷ area of the covered gamut, from 0 to 1.
    """

    area_a: float
    area_b: float
    intersection: float
    area_ratio: float
    a_covers_b: float
    b_covers_a: float


@dataclass(frozen=True, eq=False, repr=False)
class ChromaticityComparison(Shown):
    """Areas and coverage of two chromaticity gamuts.

    Attributes
    ----------
    xy, uv : AreaOverlap
        In the CIE 1931 xy and the CIE 1976 u′v′ diagram.
    basis_a, basis_b : str
        As `ChromaticityGamut.basis`.
    """

    xy: AreaOverlap
    uv: AreaOverlap
    basis_a: str
    basis_b: str

    def to_mapping(self) -> dict[str, Any]:
        """Return the comparison as JSON-able values."""
        return {
            "basis_a": self.basis_a,
            "basis_b": self.basis_b,
            **{diagram: dict(vars(getattr(self, diagram))) for diagram in DIAGRAMS},
        }


@dataclass(frozen=True, eq=False, repr=False)
class ChromaticityGamut(Shown):
    """The chromaticities of a gamut: a convex polygon.

    Attributes
    ----------
    xy : (n, 2) float64
        Corners in the CIE 1931 diagram, counter-clockwise. Chromaticities are those of the device,
        before any adaptation.
    basis : str
        ``"primaries"``: the triangle of red, green and blue of a display or an RGB space.
        ``"colours"``: the convex hull of the gamut's own colours of at least 1 % of the luminance
        of white.

    Examples
    --------
    >>> bt709, bt2020 = CHROMATICITY_STANDARDS["bt709"], CHROMATICITY_STANDARDS["bt2020"]
    >>> round(bt709.compare(bt2020).xy.area_ratio, 3)
    0.529
    """

    xy: Polygon
    basis: str

    @property
    def uv(self) -> Polygon:
        """Corners in the CIE 1976 diagram (CIE 15:2018, 8.2.2)."""
        x, y = self.xy.T
        return np.stack([4.0 * x, 9.0 * y], axis=1) / (-2.0 * x + 12.0 * y + 3.0)[:, np.newaxis]

    def compare(self, other: ChromaticityGamut) -> ChromaticityComparison:
        """Return areas and coverage of this gamut, A, and another one, B."""
        xy, uv = (_overlap(getattr(self, diagram), getattr(other, diagram)) for diagram in DIAGRAMS)
        return ChromaticityComparison(xy, uv, self.basis, other.basis)

    def to_mapping(self) -> dict[str, Any]:
        """Return corners, areas and the coverage of standards as JSON-able values.

        Returns
        -------
        dict
            ``basis``; ``corners`` in xy; and for both diagrams ``area``, ``of_bt709``, the multiple
            of the area of BT.709, and ``coverage``, the covered part of each standard by slug.
        """
        found = {slug: self.compare(each) for slug, each in CHROMATICITY_STANDARDS.items()}
        figures = {}
        for diagram in DIAGRAMS:
            overlaps: dict[str, AreaOverlap] = {
                slug: getattr(each, diagram) for slug, each in found.items()
            }
            figures[diagram] = {
                "area": round(overlaps["bt709"].area_a, DIGITS),
                "of_bt709": round(overlaps["bt709"].area_ratio, DIGITS),
                "coverage": {
                    slug: round(each.a_covers_b, DIGITS) for slug, each in overlaps.items()
                },
            }
        return {"basis": self.basis, "corners": self.xy.round(DIGITS).tolist(), **figures}

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> ChromaticityGamut:
        """Return the chromaticity gamut of a description; the inverse of `to_mapping`."""
        return cls(np.array(mapping["corners"], np.float64), str(mapping["basis"]))


def chromaticity_gamut(
    xyz: FloatArray, luminance: FloatArray, primaries: FloatArray | None = None
) -> ChromaticityGamut | None:
    """Return the chromaticity gamut of colours.

    Parameters
    ----------
    xyz : (n, 3) float
        Tristimulus values of the device, not adapted, in any scale.
    luminance : (n,) float
        Luminances in parts of the white's.
    primaries : (3, 3) float, optional
        Tristimulus values of red, green and blue, whose triangle is the gamut.

    Returns
    -------
    ChromaticityGamut or None
        None if the chromaticities have no area.
    """
    from scipy.spatial import ConvexHull, QhullError  # noqa: PLC0415  # takes 0.1 s

    chosen = xyz[luminance >= LEAST_LUMINANCE] if primaries is None else primaries
    # u′v′ has a denominator of its own; both are positive for all real colours
    total, other = chosen.sum(axis=1), chosen @ (1.0, 15.0, 3.0)
    chosen = chosen[np.isfinite(chosen).all(axis=1) & (total > 0.0) & (other > 0.0)]
    if len(chosen) < 3:
        return None
    xy = chosen[:, :2] / chosen.sum(axis=1)[:, np.newaxis]
    try:
        hull = ConvexHull(xy)
    except QhullError:
        return None
    return ChromaticityGamut(xy[hull.vertices], "colours" if primaries is None else "primaries")


def _overlap(one: Polygon, other: Polygon) -> AreaOverlap:
    area_a, area_b = _area(one), _area(other)
    common = min(_area(_intersection(one, other)), area_a, area_b)
    return AreaOverlap(area_a, area_b, common, area_a / area_b, common / area_b, common / area_a)


def _area(polygon: Polygon) -> float:
    x, y = polygon.T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2.0


def _intersection(one: Polygon, other: Polygon) -> Polygon:
    """Clip a convex polygon by the edges of another one (Sutherland and Hodgman 1974)."""
    for start, end in zip(other, np.roll(other, -1, axis=0), strict=True):
        (ux, uy), away = end - start, one - start
        side = ux * away[:, 1] - uy * away[:, 0]
        corners: list[FloatArray] = []
        for here, at in enumerate(side):
            before = side[here - 1]
            if (before < 0.0) != (at < 0.0):
                share = before / (before - at)
                corners.append(one[here - 1] + share * (one[here] - one[here - 1]))
            if at >= 0.0:
                corners.append(one[here])
        one = np.array(corners).reshape(-1, 2)
    return one


CHROMATICITY_STANDARDS: Mapping[str, ChromaticityGamut] = MappingProxyType(
    {
        slug: ChromaticityGamut(np.array(REFERENCES[slug].primaries), "primaries")
        for slug in ("bt709", "display-p3", "bt2020", "adobe-rgb-1998")
    }
)
"""The standards that displays are measured against, by slug of the reference."""
