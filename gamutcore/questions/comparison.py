"""The comparison of two gamuts: volumes, coverage, chroma, colours lost, chromaticities, words."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import numpy as np

from gamutcore import search
from gamutcore.arguments import Boolean, WholeNumber
from gamutcore.questions.conditions import build_warnings, comparison_warnings, size_warnings
from gamutcore.questions.declarations import (
    NULLABLE_NUMBER,
    NUMBER,
    Answer,
    Parameter,
    Question,
    described,
    list_of,
)
from gamutcore.questions.levels import answering_level, lab_of, other_gamut
from gamutcore.questions.points import nearest, positions
from gamutcore.results import ChromaticityGamut, ColourLoss, GamutComparison, HueSectors
from gamutcore.search import MOST_SECTORS, delta_e_2000

if TYPE_CHECKING:
    from gamutcore.arrays import BooleanArray, FloatArray, LongArray
    from gamutcore.colours.spaces import ColourSpace
    from gamutcore.questions.levels import GamutLike, IndexedLevel, OtherGamut
    from gamutcore.results import Conditions
    from gamutcore.search import LevelIndex

__all__ = ["COMPARISON", "SECTORS", "chromaticity", "compare", "compared_conditions"]

SECTORS = 36
"""Sectors of hue of a comparison: 10° each. The words are always about so many."""

POINTS = 2048
"""Points of a surface whose loss is found. Of a press and sRGB, the means are within 0.03 of those
of 50,000 points, and the percentiles within 0.1."""

FACES_AT_ONCE = 4096
"""Faces whose corners are in memory at the same time, at 300 bytes each."""

PLASTIC = 1.324717957244746
"""The root of x³ = x + 1: its powers −1 and −2 give a sequence of low discrepancy in two dimensions
(M. Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018)."""

HUE_NAMES = {"red": 38, "yellow": 96, "green": 146, "cyan": 214, "blue": 299, "magenta": 343}
"""Hues in CIELAB with D50, in degrees: the means of the primaries and secondaries of sRGB and of
FOGRA39 coated offset. Displays and presses call these colours so."""

EQUAL_CHROMA = 0.01
"""Largest difference of chromas that count as equal ÷ the largest chroma: about 1 in CIELAB."""

MOST_RANGES = 3
"""Most ranges of hue in a sentence."""

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

SECTOR_FIGURES = (
    *("max_chroma_a", "max_chroma_b", "lost_mean_a", "lost_mean_b"),
    *("lost_percentile_95_a", "lost_percentile_95_b"),
)
"""Figures by sector that not every comparison has."""


def compare(
    gamut: GamutLike,
    other: OtherGamut,
    *,
    sectors: int = SECTORS,
    lost: bool = False,
    triangles: int | None = None,
    max_error: float | None = None,
) -> GamutComparison:
    """Compare this gamut, A, with another one, B.

    Parameters
    ----------
    other : Gamut, str or path
    sectors : int, optional
        Number of equal sectors of hue.
    lost : bool, optional
        Whether to find `lost_a` and `lost_b`: ΔE00 between the surface of each gamut and the
        nearest colours of the other one. It takes some tenths of a second.

    Returns
    -------
    GamutComparison
        With `volume_a`, `volume_b`, `intersection`, `union`, `a_covers_b`, `b_covers_a`,
        `jaccard`, `symmetric_difference`, the same by sector of hue with the largest chroma,
        the lightest and darkest colours, areas and coverage of the chromaticities, warnings,
        and a `summary` in words.

    Notes
    -----
    Colours lost are those of 2,048 points on the surface, each of which stands for the same
    area. A colour that the other gamut has within its tolerance loses 0. Nearest is by ΔE00 in
    CIELAB with D50, and by the distance of the space elsewhere.

    Hues in the summary of CIELAB gamuts have names: red 38°, yellow 96°, green 146°, cyan 214°,
    blue 299° and magenta 343°. These are the means of the primaries and secondaries of sRGB and
    of FOGRA39 coated offset.

    Examples
    --------
    >>> from gamutcore import Gamut
    >>> import numpy as np
    >>> cube = np.array([(l, a, b) for l in (-1, 1) for a in (-1, 1) for b in (-1, 1)])
    >>> whole, part = Gamut(20 * cube + (50, 0, 0)), Gamut(10 * cube + (50, 0, 0))
    >>> round(whole.compare(part).b_covers_a, 3)
    0.125
    """
    other = other_gamut(gamut, other)
    both = gamut, other
    levels = [answering_level(side, triangles, max_error) for side in both]
    volumes = search.compare(levels[0].index, levels[1].index, sectors)
    (white_a, black_a), (white_b, black_b) = (_extremes(gamut, level) for level in levels)
    one, two = map(chromaticity, both)
    by_hue: dict[str, FloatArray] = {}
    losses: dict[str, ColourLoss] = {}
    words: list[str] = []
    if gamut.colour_space.definition.lightness == 0:
        by_hue |= {
            f"max_chroma_{name}": _max_chroma(level.index, sectors)
            for name, level in zip("ab", levels, strict=True)
        }
        chroma_a, chroma_b = (_max_chroma(level.index, SECTORS) for level in levels)
        words += _reach(chroma_a, chroma_b, gamut.colour_space)
    words.append(
        f"A covers {_percent(volumes.a_covers_b)} of the volume of B, and B covers "
        f"{_percent(volumes.b_covers_a)} of the volume of A."
    )
    if lost:
        for name, from_level, (target, target_level) in (
            ("a", levels[0], (other, levels[1])),
            ("b", levels[1], (gamut, levels[0])),
        ):
            points = _surface_points(from_level.index)
            values, outside = _loss(points, target, target_level.triangles)
            loss = ColourLoss(*_figures(values), float(np.mean(outside)))
            losses[f"lost_{name}"] = loss
            parts = _by_sector(points, values, sectors)
            by_hue |= {f"lost_mean_{name}": parts[0], f"lost_percentile_95_{name}": parts[1]}
            words.append(_loss_in_words(loss, *("AB" if name == "a" else "BA")))
    words.append(_ends_in_words(gamut, (white_a, white_b), (black_a, black_b)))
    return GamutComparison(
        volumes.volume_a,
        volumes.volume_b,
        volumes.intersection,
        volumes.hues,
        HueSectors(**vars(volumes.sectors), **by_hue),
        white_a=white_a,
        white_b=white_b,
        black_a=black_a,
        black_b=black_b,
        triangles=(levels[0].triangles, levels[1].triangles),
        max_error=(levels[0].max_error, levels[1].max_error),
        gamuts=(gamut.conditions, other.conditions),
        warnings=(
            *build_warnings(gamut.conditions, other.conditions),
            *compared_conditions(gamut.conditions, other.conditions),
        ),
        chromaticity=None if one is None or two is None else one.compare(two),
        **losses,
        summary=tuple(words),
    )


def _extremes(gamut: GamutLike, level: IndexedLevel) -> tuple[FloatArray, FloatArray]:
    """Return the lightest and the darkest vertex."""
    vertices = level.index.vertices
    lightness = vertices[:, gamut.colour_space.definition.lightness]
    return vertices[np.argmax(lightness)], vertices[np.argmin(lightness)]


def _sectors_of(points: FloatArray, sectors: int) -> LongArray:
    """Return the sector of hue of each point."""
    turns = np.arctan2(points[:, 2], points[:, 1]) / (2.0 * np.pi) % 1.0
    numbers: LongArray = (turns * sectors).astype(np.int64) % sectors
    return numbers


def _max_chroma(index: LevelIndex, sectors: int) -> FloatArray:
    """Return the largest chroma in each sector; NaN without a colour.

    Chroma is a convex function. Its maximum on the part of a face in a sector is therefore in a
    vertex, or on a border of the sector, where it is a cusp.
    """
    borders = search.cusp_points(np.linspace(0.0, 360.0, sectors + 1), index).chroma
    maxima: FloatArray = np.fmax(borders[:-1], borders[1:])
    vertices = index.vertices
    chroma = np.hypot(vertices[:, 1], vertices[:, 2])
    np.fmax.at(maxima, _sectors_of(vertices, sectors), chroma)
    return maxima


def _surface_points(index: LevelIndex) -> FloatArray:
    """Return points of a surface, (POINTS, 3), of which each stands for the same area.

    Faces are in the order of hue and lightness. The points are at equal steps of the area, so that
    every part of the surface has its share of them.
    """
    areas, places = np.empty(len(index.faces)), np.empty(len(index.faces))
    low, high = index.box[:, 0]
    for start in range(0, len(index.faces), FACES_AT_ONCE):
        part = slice(start, start + FACES_AT_ONCE)
        corners = index.vertices[index.faces[part]]
        sides = corners[:, 1:] - corners[:, :1]
        areas[part] = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
        middles = corners.mean(axis=1)
        strips, height = _sectors_of(middles, SECTORS), (middles[:, 0] - low) / (high - low)
        places[part] = strips + np.where(strips % 2, height, 1.0 - height)
    order = np.argsort(places, kind="stable")
    del places
    areas = areas[order]
    np.cumsum(areas, out=areas)
    numbers = np.arange(POINTS)
    faces = order[np.searchsorted(areas, (numbers + 0.5) / POINTS * areas[-1])]
    root, v = np.sqrt(numbers / PLASTIC % 1.0), numbers / PLASTIC**2 % 1.0
    weights = np.stack([1.0 - root, root * (1.0 - v), root * v], axis=1)
    points: FloatArray = np.einsum("nk,nkj->nj", weights, index.vertices[index.faces[faces]])
    return points


def _loss(points: FloatArray, gamut: GamutLike, triangles: int) -> tuple[FloatArray, BooleanArray]:
    """Return ΔE00 between points and the nearest colours of a gamut, and which are outside."""
    outside = ~positions(gamut, points, triangles=triangles).inside
    metric = "CIE 2000" if gamut.colour_space.is_icc_cielab else "CIE 1976"
    values = np.zeros(len(points))
    values[outside] = nearest(gamut, points[outside], metric=metric, triangles=triangles).delta_e
    return values, outside


def _figures(values: FloatArray) -> tuple[float, float]:
    """Return the mean and the 95th percentile; NaN of no values."""
    return (
        (float(values.mean()), float(np.percentile(values, 95))) if len(values) else (np.nan,) * 2
    )


def _by_sector(points: FloatArray, values: FloatArray, sectors: int) -> FloatArray:
    """Return the mean and the 95th percentile of the values in each sector, (2, sectors)."""
    places = _sectors_of(points, sectors)
    ends = np.cumsum(np.bincount(places, minlength=sectors))
    groups = np.split(values[np.argsort(places, kind="stable")], ends[:-1])
    return np.array([_figures(group) for group in groups]).T


def _percent(share: float) -> str:
    return "less than 0.1 %" if 0.0 < share < 0.0005 else f"{100.0 * share:.1f} %"


def _rounded(value: float, space: ColourSpace, digits: int) -> str:
    """Return a coordinate in words: to so many digits of the lightness of white."""
    decimals = max(digits - 1 - round(float(np.log10(space.white_lightness))), 0)
    return f"{round(value, decimals) + 0.0:.{decimals}f}"  # no −0


def _reach(chroma_a: FloatArray, chroma_b: FloatArray, space: ColourSpace) -> list[str]:
    """Return sentences about the gamut that reaches further in chroma, by hue."""
    named = space.name == "CIELAB"
    chromas = np.nan_to_num([chroma_a, chroma_b])
    gain = chromas[0] - chromas[1]
    least = EQUAL_CHROMA * chromas.max()
    sides = {"A": gain, "B": -gain}
    where = {name: side > least for name, side in sides.items()}
    sentences: list[str] = []
    whole = True
    for name in sorted(sides, key=lambda name: int(np.count_nonzero(where[name]))):
        if not where[name].any():
            continue
        if where[name].all():
            place = "at every hue"
        elif sentences and whole and (where["A"] | where["B"]).all():
            place = "everywhere else"
        else:
            place, whole = _ranges_in_words(where[name], sides[name], named=named)
        most = int(np.argmax(sides[name]))
        hue, colour = f"hue {(most + 0.5) * 360 / SECTORS:.0f}°", _hue_name(most)
        at = f"in {colour} ({hue})" if named and f"in {colour} (" not in place else f"at {hue}"
        far = _rounded(float(sides[name][most]), space, 3)
        sentences.append(f"{name} reaches further {place}: by up to {far} in chroma, {at}.")
    return sentences or ["A and B reach equally far at every hue."]


def _hue_name(sector: int) -> str:
    hue = (sector + 0.5) * 360.0 / SECTORS
    return min(HUE_NAMES, key=lambda name: abs((HUE_NAMES[name] - hue + 180.0) % 360.0 - 180.0))


def _ranges_in_words(where: BooleanArray, gain: FloatArray, *, named: bool) -> tuple[str, bool]:
    """Return ranges of hue, those of the largest gains, and whether they are all."""
    ranges = []
    for start in np.flatnonzero(where & ~np.roll(where, 1)):
        sectors = (start + np.arange(int(np.argmin(np.roll(where, -start))))) % SECTORS
        ranges.append((float(gain[sectors].max()), sectors))
    largest = sorted(ranges, key=lambda gains: -gains[0])[:MOST_RANGES]
    texts = []
    for _, sectors in sorted(largest, key=lambda gains: int(gains[1][0])):
        low, high = (sectors[0] * 360 // SECTORS, (sectors[-1] + 1) * 360 // SECTORS)
        names = dict.fromkeys(map(_hue_name, sectors.tolist()))
        hues = f"hue {low}° to {high}°"
        texts.append(f"in {_listed(list(names))} ({hues})" if named else f"at {hues}")
    whole = len(largest) == len(ranges)
    return ("" if whole else "chiefly ") + _listed(texts), whole


def _listed(words: list[str]) -> str:
    return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)


def _loss_in_words(loss: ColourLoss, name: str, other: str) -> str:
    if loss.share_outside == 0.0:
        return f"The whole surface of {name} is inside {other}."
    return (
        f"Of the surface of {name}, {_percent(loss.share_outside)} is outside {other}; with the "
        f"nearest colours of {other} instead, ΔE00 is {loss.mean:.1f} on average over the surface "
        f"(0 where it is inside {other}) and {loss.percentile_95:.1f} at the 95th percentile."
    )


def _ends_in_words(
    gamut: GamutLike, whites: tuple[FloatArray, ...], blacks: tuple[FloatArray, ...]
) -> str:
    """Return a sentence about the white and black points."""
    space = gamut.colour_space
    axis = space.definition.lightness
    texts = []
    for name, ends in (("lightest", whites), ("darkest", blacks)):
        one, two = (_rounded(float(end[axis]), space, 4) for end in ends)
        (difference,) = delta_e_2000(*(lab_of(gamut, end[np.newaxis]) for end in ends))
        texts.append(
            f"the {name} colour of A has {space.axes[axis]} {one} and that of B {two} "
            f"(ΔE00 {difference:.1f})"
        )
    return f"T{'; '.join(texts)[1:]}."


def chromaticity(gamut: GamutLike) -> ChromaticityGamut | None:
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
    stored = gamut.description.get("chromaticity")
    return None if stored is None else ChromaticityGamut.from_mapping(stored)


def compared_conditions(
    one: Conditions, two: Conditions, names: tuple[str, str] = ("A", "B")
) -> tuple[str, ...]:
    """Return reasons why a comparison may mislead; two media-relative gamuts are one."""
    relative = all(side.is_print and side.intent == "relative" for side in (one, two))
    return (
        *comparison_warnings(one, two, names),
        *((MEDIA_RELATIVE,) if relative else ()),
        *size_warnings(one, two, names=names),
    )


def _answer(comparison: GamutComparison) -> Answer:
    sectors = {
        name: np.asarray(values)
        for name in (*FIGURES, *SECTOR_FIGURES)
        if (values := getattr(comparison.sectors, name)) is not None
    }
    table = {"hue_from": comparison.hues[:-1], "hue_to": comparison.hues[1:], **sectors}
    document: dict[str, Any] = {
        "summary": list(comparison.summary),
        **{name: getattr(comparison, name) for name in (*FIGURES, *ENDS)},
        **{
            name: None if loss is None else dict(vars(loss))
            for name, loss in (("lost_a", comparison.lost_a), ("lost_b", comparison.lost_b))
        },
        "chromaticity": None
        if comparison.chromaticity is None
        else comparison.chromaticity.to_mapping(),
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


def _lost(description: str) -> dict[str, Any]:
    return {
        "type": ["object", "null"],
        "description": f"{description} Only with `lost=true`.",
        "properties": {
            "mean": described(NUMBER, "Mean over the area of the surface."),
            "percentile_95": described(NUMBER, "95th percentile."),
            "share_outside": described(NUMBER, "Share of the area outside of the other gamut."),
        },
    }


_NUMBERS = list_of(NULLABLE_NUMBER)

COMPARISON = Question(
    "comparisons",
    "compareGamuts",
    "Compare two gamuts",
    "Volumes of two gamuts in the same space, of their intersection and union, coverage both ways, "
    "Jaccard index and symmetric difference, in total and by sector of hue; the largest chroma by "
    "sector; the lightest and darkest colours; a summary in words; areas and coverage of the "
    "chromaticities in CIE 1931 xy and CIE 1976 u′v′. Warnings name different intents, whites and "
    "conditions of measurement, and print gamuts relative to their papers.",
    (
        Parameter(
            "sectors",
            Annotated[int, WholeNumber(1, MOST_SECTORS)],
            "Number of equal sectors of hue.",
            default=SECTORS,
            example=12,
        ),
        Parameter(
            "lost",
            Annotated[bool, Boolean()],
            "Whether to answer with the colours lost as well: ΔE00 between the surface of each "
            "gamut and the nearest colours of the other one, which takes longer.",
            default=False,
        ),
    ),
    compare,
    answer_schema={
        "summary": described(
            list_of({"type": "string"}),
            "The comparison in two to six sentences. The words A and B stand for the gamuts.",
        ),
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
        "lost_a": _lost(
            "ΔE00 between the surface of A and the nearest colours of B; 0 where B has the colour. "
            "Nearest is by ΔE00 in CIELAB with D50, and by the distance of the space elsewhere."
        ),
        "lost_b": _lost("The same between the surface of B and A."),
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
            "description": "The figures by sector: arrays by name, with `hue_from` and `hue_to`. "
            "In spaces of lightness and hue also the largest chromas, `max_chroma_a` and "
            "`max_chroma_b`. With `lost=true` also `lost_mean_a`, `lost_mean_b`, "
            "`lost_percentile_95_a` and `lost_percentile_95_b`, null without a point of the "
            "surface.",
            "additionalProperties": _NUMBERS,
        },
    },
    tabulate_result=_answer,
    example_answer={
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
        "summary": ["A covers 46.8 % of the volume of B, and B covers 96.8 % of the volume of A."],
        "lost_a": {"mean": 0.7, "percentile_95": 5.7, "share_outside": 0.23},
        "lost_b": {"mean": 5.5, "percentile_95": 14.3, "share_outside": 0.91},
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
        "sectors": {"hue_from": [0], "hue_to": [360], "max_chroma_a": [94.5]},
    },
    other="other",
    pair_warnings=compared_conditions,
)
