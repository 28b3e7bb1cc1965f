"""Chromaticity gamuts: polygons in the CIE 1931 xy and the CIE 1976 u′v′ diagram, and their areas.

A chromaticity gamut has no lightness. Its area and coverage are the figures that display makers
state; they say less than the volume. The map from xy to u′v′ is projective, so it keeps straight
lines: one polygon serves both diagrams.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from gamutcore.arrays import FloatArray
from gamutcore.references import REFERENCES
from gamutcore.results import DIAGRAMS, AreaOverlap, ChromaticityGamut

__all__ = ["CHROMATICITY_STANDARDS", "chromaticity_description", "chromaticity_gamut"]

LEAST_LUMINANCE = 0.01
"""Smallest luminance of colours in a hull, in parts of the white's: L* 9. The chromaticities of
darker colours are mostly measurement noise and flare."""

DIGITS = 7
"""Decimals of chromaticities and their figures in descriptions."""


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


CHROMATICITY_STANDARDS: Mapping[str, ChromaticityGamut] = MappingProxyType(
    {
        slug: ChromaticityGamut(np.array(REFERENCES[slug].primaries), "primaries")
        for slug in ("bt709", "display-p3", "bt2020", "adobe-rgb-1998")
    }
)
"""The standards that displays are measured against, by slug of the reference."""


def chromaticity_description(gamut: ChromaticityGamut) -> dict[str, Any]:
    """Return corners, areas and the coverage of standards as JSON-able values.

    Returns
    -------
    dict
        ``basis``; ``corners`` in xy; and for both diagrams ``area``, ``of_bt709``, the multiple
        of the area of BT.709, and ``coverage``, the covered part of each standard by slug.
    """
    comparisons = {
        slug: gamut.compare(standard) for slug, standard in CHROMATICITY_STANDARDS.items()
    }
    figures = {}
    for diagram in DIAGRAMS:
        overlaps: dict[str, AreaOverlap] = {
            slug: getattr(comparison, diagram) for slug, comparison in comparisons.items()
        }
        figures[diagram] = {
            "area": round(overlaps["bt709"].area_a, DIGITS),
            "of_bt709": round(overlaps["bt709"].area_ratio, DIGITS),
            "coverage": {
                slug: round(overlap.a_covers_b, DIGITS) for slug, overlap in overlaps.items()
            },
        }
    return {"basis": gamut.basis, "corners": gamut.xy.round(DIGITS).tolist(), **figures}
