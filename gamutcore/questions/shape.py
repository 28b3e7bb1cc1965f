"""Questions about the shape of a gamut: cusps, slices, hue leaves, tables of chroma, rings."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np

from gamutcore import search
from gamutcore.arguments import Array, FiniteNumber, Number, WholeNumber, check_option
from gamutcore.colour_rows import colour_rows
from gamutcore.errors import OptionError
from gamutcore.questions.conditions import build_warnings, comparison_warnings
from gamutcore.questions.declarations import (
    NULLABLE_NUMBER,
    OTHER_GAMUT,
    Answer,
    Parameter,
    Question,
    described,
    list_of,
)
from gamutcore.questions.levels import answering_level, level_with_hue, other_gamut, surface_facts
from gamutcore.results import ChromaTable, ColourCusps, ColourSection, GamutRings
from gamutcore.search import MOST_SECTORS, RING_LIGHTNESSES

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from gamutcore.arrays import FloatArray
    from gamutcore.questions.levels import GamutLike, OtherGamut

__all__ = [
    "CUSPS",
    "LEAVES",
    "RINGS",
    "SLICE",
    "cusps",
    "hue_angles",
    "leaf",
    "leaves",
    "max_chroma",
    "rings",
    "section",
]

MOST_HUES = 36_000
"""Largest number of equidistant hues: hundredths of a degree."""

_NUMBERS = list_of(NULLABLE_NUMBER)
_ROWS = list_of(_NUMBERS)

_CHANNELS = {"type": "array", "items": {"type": "string"}}


def hue_angles(hues: int | ArrayLike) -> FloatArray:
    """Return hues in degrees: those given, or a number of equidistant ones from 0° on.

    Examples
    --------
    >>> from gamutcore import Gamut
    >>> hue_angles(4).tolist(), hue_angles([40]).tolist()
    ([0.0, 90.0, 180.0, 270.0], [40.0])
    """
    if isinstance(hues, int | np.integer):
        check_option("hues", int(hues), Annotated[int, WholeNumber(1, MOST_HUES)])
        return np.linspace(0.0, 360.0, int(hues), endpoint=False)
    return np.atleast_1d(np.asarray(hues, np.float64))


def cusps(
    gamut: GamutLike,
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

    Returns
    -------
    ColourCusps
        With `hue`, `lightness`, `chroma`, `points` and `device`. NaN where a hue has no colour.

    Examples
    --------
    >>> from gamutcore import Gamut
    >>> cube = [(l, a, b) for l in (40, 60) for a in (-10, 10) for b in (-10, 10)]
    >>> Gamut(cube).cusps([0, 45]).chroma.round(2).tolist()
    [10.0, 14.14]
    """
    angles = hue_angles(hues)
    level = level_with_hue(gamut, triangles, max_error)
    cusp_points = search.cusp_points(angles, level.index)
    return ColourCusps(
        points=cusp_points.points,
        hue=angles,
        lightness=cusp_points.points[:, 0],
        chroma=cusp_points.chroma,
        **surface_facts(gamut, level, cusp_points),
    )


def _cusps_answer(cusp_line: ColourCusps) -> Answer:
    table = {
        "hue": cusp_line.hue,
        "lightness": cusp_line.lightness,
        "chroma": cusp_line.chroma,
        "point": cusp_line.points,
    }
    if cusp_line.device is not None:
        table["device"] = cusp_line.device
    document = {"channels": list(cusp_line.channels), **table}
    return Answer(table, channels=cusp_line.channels, document=document)


CUSPS = Question(
    "cusps",
    "listCusps",
    "List the cusps",
    "The colour of largest chroma at each of a number of equidistant hues, from 0° on.",
    (
        Parameter(
            "hues",
            Annotated[int, WholeNumber(1, MOST_HUES)],
            "Number of hues.",
            default=360,
            example=12,
        ),
    ),
    cusps,
    answer_schema={
        "channels": _CHANNELS,
        "hue": described(_NUMBERS, "Hue in degrees."),
        "lightness": described(_NUMBERS, "Lightness of the cusp; null if the hue has no colour."),
        "chroma": described(_NUMBERS, "Chroma of the cusp."),
        "point": described(_ROWS, "The cusp in the space of the gamut."),
        "device": described(_ROWS, "Its device values from 0 to 1, if the gamut has any."),
    },
    tabulate_result=_cusps_answer,
    example_answer={
        "channels": ["C", "M", "Y", "K"],
        "hue": [0],
        "lightness": [48.1],
        "chroma": [73.9],
        "point": [[48.1, 73.9, 0.0]],
        "device": [[0.0, 1.0, 0.2, 0.0]],
    },
)


def max_chroma(
    gamut: GamutLike,
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

    Returns
    -------
    (...) float64
        NaN where no colour is in gamut.

    Examples
    --------
    >>> from gamutcore import Gamut
    >>> cube = [(l, a, b) for l in (40, 60) for a in (-10, 10) for b in (-10, 10)]
    >>> Gamut(cube).max_chroma(50, [0, 45]).round(2).tolist()
    [10.0, 14.14]
    """
    level = level_with_hue(gamut, triangles, max_error)
    light, angle = np.broadcast_arrays(*(np.asarray(values, float) for values in (lightness, hue)))
    turn = np.radians(angle)
    ends = np.stack([light, np.cos(turn), np.sin(turn)], axis=-1)
    rows = colour_rows(ends, "lightness and hue")
    starts = rows.points * (1.0, 0.0, 0.0)
    hits = search.crossings(starts, rows.points, level.index, "ray")
    chroma = np.full(len(starts), np.nan)
    crossed = hits.offsets[1:] > hits.offsets[:-1]
    chroma[crossed] = hits.t[hits.offsets[1:][crossed] - 1]
    return rows.in_shape(chroma)


def section(
    gamut: GamutLike,
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

    Examples
    --------
    >>> from gamutcore import Gamut
    >>> cube = [(l, a, b) for l in (40, 60) for a in (-10, 10) for b in (-10, 10)]
    >>> (square,) = Gamut(cube).slice(L=50).polygons
    >>> abs(square[:, 1:]).max().round(3).item()
    10.0
    """
    values = {"L": L, "hue": hue, "plane": plane}
    arguments = [name for name, value in values.items() if value is not None]
    if len(arguments) != 1:
        raise OptionError(
            f"{' and '.join(arguments) or 'Nothing'} is given.",
            where={"field": arguments[1] if arguments else "L"},
            remedy="Give one of L, hue and plane.",
        )
    if hue is not None:
        return leaf(gamut, hue, triangles=triangles, max_error=max_error)
    level = answering_level(gamut, triangles, max_error)
    numbers = np.asarray(plane, np.float64)
    if L is not None:
        numbers = np.append(np.eye(3)[gamut.colour_space.definition.lightness], L)
    elif numbers.shape != (4,):
        raise OptionError.refusal("plane", plane, "four numbers a, b, c, d")
    polygons = search.slice_polygons(level.index, numbers[:3], numbers[3])
    facts = surface_facts(gamut, level, polygons)
    return ColourSection(points=polygons.points, offsets=polygons.offsets, **facts)


def leaf(
    gamut: GamutLike,
    hue: float,
    *,
    triangles: int | None = None,
    max_error: float | None = None,
) -> ColourSection:
    """Return the hue leaf: the section by the half-plane of a hue.

    Parameters
    ----------
    hue : float
        In degrees.

    Returns
    -------
    ColourSection
        A leaf may have several polygons, and need not contain the neutral axis. Device values
        of corners on the axis, which are inside, are those of the surface above or below.

    Examples
    --------
    >>> from gamutcore import Gamut
    >>> cube = [(l, a, b) for l in (40, 60) for a in (-10, 10) for b in (-10, 10)]
    >>> len(Gamut(cube).leaf(hue=0).polygons)
    1
    """
    level = level_with_hue(gamut, triangles, max_error)
    polygons = search.hue_leaf(level.index, hue)
    facts = surface_facts(gamut, level, polygons)
    return ColourSection(points=polygons.points, offsets=polygons.offsets, **facts)


def _section(
    gamut: GamutLike,
    *,
    lightness: float | None = None,
    hue: float | None = None,
    plane: ArrayLike | None = None,
    triangles: int | None = None,
    max_error: float | None = None,
) -> ColourSection:
    """Return a section by the names of the parameters of the question."""
    return section(gamut, lightness, hue=hue, plane=plane, triangles=triangles, max_error=max_error)


def _section_answer(colours: ColourSection) -> Answer:
    counts = np.diff(colours.offsets)
    table = {"polygon": np.repeat(np.arange(len(counts)), counts), "point": colours.points}
    document: dict[str, Any] = {"channels": list(colours.channels), "polygons": colours.polygons}
    if colours.device is not None:
        table["device"] = colours.device
        document["device"] = np.split(colours.device, colours.offsets[1:-1]) if len(counts) else []
    return Answer(table, channels=colours.channels, document=document)


_FINITE = Annotated[float, Number(-1e6, 1e6)]

SLICE = Question(
    "slice",
    "sliceGamut",
    "Cut the gamut by a plane",
    "The section by a plane of constant lightness, by the half-plane of a hue, or by any plane, as "
    "closed polygons. Polygons inside others are holes.",
    (
        Parameter("lightness", _FINITE, "Lightness of the plane.", example=50),
        Parameter("hue", _FINITE, "Hue of the half-plane in degrees."),
        Parameter(
            "plane",
            Annotated[
                tuple[FiniteNumber, FiniteNumber, FiniteNumber, FiniteNumber],
                Array("4 numbers", 4),
            ],
            "a,b,c,d: the points with a x + b y + c z = d.",
        ),
    ),
    _section,
    answer_schema={
        "channels": _CHANNELS,
        "polygons": described(list_of(_ROWS), "Corners of each polygon in the space of the gamut."),
        "device": described(list_of(_ROWS), "Device values of the corners, if the gamut has any."),
    },
    tabulate_result=_section_answer,
    example_answer={
        "channels": ["C", "M", "Y", "K"],
        "polygons": [[[50, 70, 0], [50, 0, 60], [50, -60, 0]]],
        "device": [[[0, 1, 0, 0], [0, 0.4, 1, 0.2], [1, 0, 0.6, 0]]],
    },
    alternatives=("lightness", "hue", "plane"),
)


def leaves(
    gamut: GamutLike,
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

    Returns
    -------
    ChromaTable
        With `largest`, the largest chroma as an array, beside all intervals.

    Examples
    --------
    >>> from gamutcore import Gamut
    >>> cube = [(l, a, b) for l in (40, 60) for a in (-10, 10) for b in (-10, 10)]
    >>> Gamut(cube).leaves([0, 45], [50, 70]).largest.round(2).tolist()
    [[10.0, nan], [14.14, nan]]
    """
    if isinstance(lightness, int | np.integer):
        check_option("lightness", int(lightness), Annotated[int, WholeNumber(2, MOST_HUES)])
        heights = np.linspace(0.0, gamut.colour_space.white_lightness, int(lightness))
    else:
        heights = np.atleast_1d(np.asarray(lightness, np.float64))
    level = level_with_hue(gamut, triangles, max_error)
    intervals = search.leaves(level.index, hue_angles(hues), heights)
    ends = intervals._replace(
        faces=intervals.faces.reshape(-1), weights=intervals.weights.reshape(-1, 3)
    )
    facts = surface_facts(gamut, level, ends)
    if facts["device"] is not None:
        facts["device"] = facts["device"].reshape(len(intervals.chroma), 2, len(facts["channels"]))
    return ChromaTable(
        hue=intervals.hues,
        lightness=intervals.lightness,
        offsets=intervals.offsets,
        chroma=intervals.chroma,
        **facts,
    )


def _leaves_answer(chroma_table: ChromaTable) -> Answer:
    counts = np.diff(chroma_table.offsets)
    across = len(chroma_table.lightness)

    def by_hue(ends: FloatArray) -> list[list[Any]]:
        entries = ends.tolist()
        cells = [entries[start:end] for start, end in pairwise(chroma_table.offsets.tolist())]
        return [cells[at : at + across] for at in range(0, len(cells), across)]

    document: dict[str, Any] = {
        "channels": list(chroma_table.channels),
        "hue": chroma_table.hue,
        "lightness": chroma_table.lightness,
        "intervals": by_hue(chroma_table.chroma),
    }
    table = {
        "hue": np.repeat(np.repeat(chroma_table.hue, across), counts),
        "lightness": np.repeat(np.tile(chroma_table.lightness, len(chroma_table.hue)), counts),
        "chroma_from": chroma_table.chroma[:, 0],
        "chroma_to": chroma_table.chroma[:, 1],
    }
    if chroma_table.device is not None:
        table["device"] = chroma_table.device[:, 1]
        document["device"] = by_hue(chroma_table.device)
    return Answer(table, channels=chroma_table.channels, document=document)


LEAVES = Question(
    "leaves",
    "listLeaves",
    "List the intervals of chroma",
    "The intervals of chroma that are in gamut, for each of a number of equidistant hues and "
    "lightnesses. A hue and lightness can have several intervals, and none needs to begin at the "
    "neutral axis.",
    (
        Parameter(
            "hues", Annotated[int, WholeNumber(1, 720)], "Number of hues.", default=360, example=12
        ),
        Parameter(
            "lightness",
            Annotated[int, WholeNumber(2, 501)],
            "Number of lightnesses, from 0 to that of white.",
            default=101,
            example=11,
        ),
    ),
    leaves,
    answer_schema={
        "channels": _CHANNELS,
        "hue": described(_NUMBERS, "Hues in degrees."),
        "lightness": described(_NUMBERS, "Lightnesses."),
        "intervals": described(
            list_of(list_of(_ROWS)),
            "By hue and lightness: the pairs of smallest and largest chroma.",
        ),
        "device": described(
            list_of(list_of(list_of(_ROWS))),
            "The device values at both ends of each interval, from 0 to 1, if the gamut has any; "
            "null on the neutral axis. Tables have those of the largest chroma.",
        ),
    },
    tabulate_result=_leaves_answer,
    example_answer={
        "channels": ["R", "G", "B"],
        "hue": [0],
        "lightness": [0, 50],
        "intervals": [[[], [[0, 77.1]]]],
        "device": [[[], [[[None, None, None], [0.9, 0.1, 0.4]]]]],
    },
)


_NAMES = "the gamut", "the reference"

_warnings = partial(comparison_warnings, names=_NAMES)


def rings(
    gamut: GamutLike,
    reference: OtherGamut | None = None,
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
    lightness : (n,) array_like, optional
        Of the rings, in increasing order; tenths of the lightness of white by default, which
        are those of the standard, 10 to 100, in CIELAB.
    sectors : int, optional
        Number of equal sectors of hue.

    Returns
    -------
    GamutRings
        The area within a ring is the volume of the gamut up to its lightness. Warnings name
        differences of intent or white from the reference.

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
    reference = None if reference is None else other_gamut(gamut, reference)
    level = level_with_hue(gamut, triangles, max_error)
    if lightness is None:
        # the white of Oklab has the lightness 0.999999 by the published matrices
        white = float(f"{gamut.colour_space.white_lightness:.5g}")
        lightness = np.asarray(RING_LIGHTNESSES) / 100.0 * white
    if reference is None:
        gamut_rings = search.gamut_rings(level.index, None, lightness, sectors)
        conditions = gamut.conditions
        return replace(gamut_rings, gamut=conditions, warnings=build_warnings(conditions))
    other = answering_level(reference, triangles, max_error)
    gamut_rings = search.gamut_rings(level.index, other.index, lightness, sectors)
    one, two = gamut.conditions, reference.conditions
    warnings = (*build_warnings(one, two, names=_NAMES), *_warnings(one, two))
    return replace(gamut_rings, gamut=one, reference_gamut=two, warnings=warnings)


def _rings_answer(gamut_rings: GamutRings) -> Answer:
    radii = {
        name: radius
        for name in ("radius", "reference_radius", "intersection_radius")
        if (radius := getattr(gamut_rings, name)) is not None
    }
    document = {
        "volume": gamut_rings.volume,
        "lightness": gamut_rings.lightness,
        "hue": gamut_rings.hues,
        **radii,
    }
    table = {
        "lightness": np.repeat(gamut_rings.lightness, len(gamut_rings.hues)),
        "hue": np.tile(gamut_rings.hues, len(gamut_rings.lightness)),
        **{name: radius.reshape(-1) for name, radius in radii.items()},
    }
    return Answer(table, document=document)


RINGS = Question(
    "rings",
    "listRings",
    "List the gamut rings",
    "Gamut rings (IDMS 1.1, 5.32): the area within the ring of a lightness is the volume of the "
    "gamut up to this lightness, by sector of hue. With a reference, also its rings and the outer "
    "end of the intersection in each band.",
    (
        Parameter(
            "reference",
            OTHER_GAMUT,
            "Id of a gamut in the same space, or slug of a reference gamut.",
            example="srgb",
        ),
        Parameter(
            "sectors",
            Annotated[int, WholeNumber(1, MOST_SECTORS)],
            "Number of equal sectors of hue.",
            default=360,
            example=12,
        ),
    ),
    rings,
    answer_schema={
        "reference_level": {"type": "object"},
        "reference_gamut": {"type": "object"},
        "volume": {
            "type": "number",
            "description": "Volume up to the last lightness: the area of the outer ring.",
        },
        "lightness": described(_NUMBERS, "Lightnesses of the rings: tenths of that of white."),
        "hue": described(_NUMBERS, "Middles of the sectors in degrees."),
        "radius": described(_ROWS, "Radius by ring and sector."),
        "reference_radius": described(_ROWS, "The same of the reference."),
        "intersection_radius": described(_ROWS, "Outer end of the intersection in each band."),
    },
    tabulate_result=_rings_answer,
    example_answer={
        "volume": 402000.0,
        "lightness": [50, 100],
        "hue": [90, 270],
        "radius": [[320.1, 300.2], [380.3, 340.4]],
    },
    other="reference",
    pair_warnings=_warnings,
)
