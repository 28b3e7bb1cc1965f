"""The comparison of two gamuts: volumes, coverage, chromaticities."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import numpy as np

from gamutcore import queries
from gamutcore.arguments import WholeNumber
from gamutcore.queries import MOST_SECTORS
from gamutcore.questions.conditions import comparison_warnings
from gamutcore.questions.declarations import (
    NULLABLE_NUMBER,
    NUMBER,
    Answer,
    Parameter,
    Question,
    described,
    list_of,
)
from gamutcore.questions.levels import answering_level
from gamutcore.results import ChromaticityGamut, GamutComparison

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray
    from gamutcore.questions.levels import AskedGamut, IndexedLevel
    from gamutcore.results import Conditions

__all__ = ["COMPARISON", "SECTORS", "chromaticity", "compare", "compared_conditions"]

SECTORS = 36
"""Sectors of hue of a comparison: 10° each."""

MEDIA_RELATIVE = (
    "Both gamuts are media-relative: each paper counts as white. Build both with the intent "
    "absolute to compare the papers as well."
)

FIGURES = (
    *("volume_a", "volume_b", "intersection", "union", "a_covers_b", "b_covers_a", "jaccard"),
    "symmetric_difference",
)
"""Figures of a comparison, in total and by sector."""

ENDS = ("white_a", "white_b", "black_a", "black_b")
"""Lightest and darkest colours."""


def compare(
    gamut: AskedGamut,
    other: AskedGamut,
    *,
    sectors: int = SECTORS,
    triangles: int | None = None,
    max_error: float | None = None,
) -> GamutComparison:
    """Compare a gamut, A, with another one, B."""
    both = gamut, other
    levels = [answering_level(each, triangles, max_error) for each in both]
    found = queries.compare(levels[0].index, levels[1].index, sectors)
    (white_a, black_a), (white_b, black_b) = (_extremes(gamut, level) for level in levels)
    one, two = map(chromaticity, both)
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
        gamuts=(gamut.conditions, other.conditions),
        warnings=compared_conditions(gamut.conditions, other.conditions),
        chromaticity=None if one is None or two is None else one.compare(two),
    )


def _extremes(gamut: AskedGamut, level: IndexedLevel) -> tuple[FloatArray, FloatArray]:
    """Return the lightest and the darkest vertex."""
    vertices = level.index.vertices
    lightness = vertices[:, gamut.colour_space.definition.lightness]
    return vertices[np.argmax(lightness)], vertices[np.argmin(lightness)]


def chromaticity(gamut: AskedGamut) -> ChromaticityGamut | None:
    """Return the chromaticities of a gamut, if its description has any."""
    stored = gamut.description.get("chromaticity")
    return None if stored is None else ChromaticityGamut.from_mapping(stored)


def compared_conditions(one: Conditions, two: Conditions) -> tuple[str, ...]:
    """Return reasons why a comparison may mislead; two media-relative gamuts are one."""
    relative = all(each.is_print and each.intent == "relative" for each in (one, two))
    return (*comparison_warnings(one, two), *((MEDIA_RELATIVE,) if relative else ()))


def _answer(found: GamutComparison) -> Answer:
    sectors = {name: np.asarray(getattr(found.sectors, name)) for name in FIGURES}
    table = {"hue_from": found.hues[:-1], "hue_to": found.hues[1:], **sectors}
    document: dict[str, Any] = {
        **{name: getattr(found, name) for name in (*FIGURES, *ENDS)},
        "chromaticity": None if found.chromaticity is None else found.chromaticity.to_mapping(),
        "sectors": table,
    }
    return Answer(table, document=document)


def _areas(diagram: str) -> dict[str, Any]:
    return {
        "type": "object",
        "description": f"Areas in the {diagram} diagram. `area_ratio` is A ÷ B; coverage is the "
        "intersection ÷ the area of the covered gamut.",
        "additionalProperties": NUMBER,
    }


_NUMBERS = list_of(NULLABLE_NUMBER)

COMPARISON = Question(
    "comparisons",
    "compareGamuts",
    "Compare two gamuts",
    "Volumes of two gamuts in the same space, of their intersection and union, coverage both ways, "
    "Jaccard index and symmetric difference, in total and by sector of hue; the lightest and "
    "darkest colours; areas and coverage of the chromaticities in CIE 1931 xy and CIE 1976 u′v′. "
    "Warnings name different intents, whites and conditions of measurement, and print gamuts "
    "relative to their papers.",
    (
        Parameter(
            "sectors",
            Annotated[int, WholeNumber(1, MOST_SECTORS)],
            "Number of equal sectors of hue.",
            default=SECTORS,
            example=12,
        ),
    ),
    compare,
    members={
        "volume_a": described(NUMBER, "Volume of A in cubic units of the space."),
        "volume_b": described(NUMBER, "Volume of B."),
        "intersection": described(NUMBER, "Volume of the part that both have."),
        "union": described(NUMBER, "Volume of the part that at least one has."),
        "a_covers_b": described(NUMBER, "Intersection ÷ volume of B."),
        "b_covers_a": described(NUMBER, "Intersection ÷ volume of A."),
        "jaccard": described(NUMBER, "Intersection ÷ union."),
        "symmetric_difference": described(NUMBER, "Volume of the part that exactly one has."),
        "white_a": described(_NUMBERS, "Lightest colour of A."),
        "white_b": described(_NUMBERS, "Lightest colour of B."),
        "black_a": described(_NUMBERS, "Darkest colour of A."),
        "black_b": described(_NUMBERS, "Darkest colour of B."),
        "chromaticity": {
            "type": ["object", "null"],
            "description": "Figures without lightness, of the chromaticities before any "
            "adaptation; null if a gamut has none. `basis_a` and `basis_b` are `primaries` or "
            "`colours`, as in the description of the gamut.",
            "properties": {
                "basis_a": {"type": "string"},
                "basis_b": {"type": "string"},
                "xy": _areas("CIE 1931 xy"),
                "uv": _areas("CIE 1976 u′v′"),
            },
        },
        "sectors": {
            "type": "object",
            "description": "The figures by sector: arrays by name, with `hue_from` and `hue_to`.",
            "additionalProperties": _NUMBERS,
        },
    },
    shape=_answer,
    answered={
        "volume_a": 402000.0,
        "volume_b": 832000.0,
        "intersection": 389000.0,
        "union": 845000.0,
        "a_covers_b": 0.468,
        "b_covers_a": 0.968,
        "jaccard": 0.46,
        "symmetric_difference": 456000.0,
        "white_a": [100.0, 0.0, 0.0],
        "white_b": [100.0, 0.0, 0.0],
        "black_a": [8.9, 0.3, 0.4],
        "black_b": [0.0, 0.0, 0.0],
        "chromaticity": {
            "basis_a": "colours",
            "basis_b": "primaries",
            "xy": {
                "area_a": 0.1085,
                "area_b": 0.112,
                "intersection": 0.0933,
                "area_ratio": 0.968,
                "a_covers_b": 0.832,
                "b_covers_a": 0.86,
            },
        },
        "sectors": {"hue_from": [0], "hue_to": [360], "a_covers_b": [0.468]},
    },
    other="other",
    compared=compared_conditions,
)
