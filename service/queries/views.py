"""The table of views: questions about a whole gamut or about two, which are answered to GET.

The same request gives the same bytes, so answers are immutable. Routes, the OpenAPI document and
the forms of the answers follow from the table. Nothing is computed here.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gamutcore.arguments import Array, FiniteNumber, Number, Text, WholeNumber
from gamutcore.queries import MOST_SECTORS
from gamutcore.questions.conditions import comparison_warnings
from gamutcore.questions.shape import MOST_HUES
from service.queries.levels import QueryLevel
from service.queries.operations import LEVEL_PARAMETERS
from service.queries.parameters import Parameter, refuse

__all__ = ["COMPARISON", "VIEWS", "Answered", "View"]


class Answered(NamedTuple):
    """The answer to a view.

    Attributes
    ----------
    document : dict
        Members of the JSON document besides the level. Arrays are allowed.
    table : dict of array
        Columns (n,) or (n, k) of the .npy and CSV files.
    parts : mapping of str to sequence of str
        Names of the k parts of a column.
    """

    document: dict[str, Any]
    table: dict[str, NDArray[Any]]
    parts: Mapping[str, tuple[str, ...]] = {}


@dataclass(frozen=True)
class View:
    """A question about gamuts.

    Attributes
    ----------
    name : str
        Last part of the path.
    operation_id, summary, description : str
        For OpenAPI.
    parameters : tuple of Parameter
        Besides those of the level.
    members : mapping
        JSON schemas of the members of the document.
    answer : callable
        From the levels and the values of the parameters to the answer.
    example : mapping
        Members of an exemplary document.
    picture : callable, optional
        From the levels and the values of the parameters to the picture as SVG.
    """

    name: str
    operation_id: str
    summary: str
    description: str
    parameters: tuple[Parameter, ...]
    members: Mapping[str, Any]
    answer: Callable[[list[QueryLevel], Mapping[str, Any]], Answered]
    example: Mapping[str, Any] = field(default_factory=dict)
    picture: Callable[[list[QueryLevel], Mapping[str, Any]], bytes] | None = None

    @property
    def all_parameters(self) -> tuple[Parameter, ...]:
        """The parameters, those of the level first."""
        return (*LEVEL_PARAMETERS, *self.parameters)

    def warnings(self, levels: Sequence[QueryLevel]) -> tuple[str, ...]:
        """Return reasons why the answer may mislead, by the conditions of two gamuts."""
        if len(levels) < 2:
            return ()
        one, two = (level.gamut for level in levels)
        if self.name == "comparisons":
            return one.warnings_about(two)
        names = "the gamut", "the reference"
        return comparison_warnings(one.conditions, two.conditions, names)

    def cells(self, values: Mapping[str, Any]) -> int:
        """Return the number of cells of the answer by the parameters that multiply them."""
        counts = [values.get(name, 1) for name in ("hues", "lightness", "sectors")]
        return math.prod(count for count in counts if isinstance(count, int))


_NUMBER = {"type": ["number", "null"]}
_NUMBERS = {"type": "array", "items": _NUMBER}
_ROWS = {"type": "array", "items": _NUMBERS}


_FINITE = Annotated[float, Number(-1e6, 1e6)]
_PLANE = Annotated[
    tuple[FiniteNumber, FiniteNumber, FiniteNumber, FiniteNumber], Array("4 numbers", 4)
]


def _numbers(description: str) -> dict[str, Any]:
    return {**_NUMBERS, "description": description}


def _rows(description: str) -> dict[str, Any]:
    return {**_ROWS, "description": description}


def _number(description: str) -> dict[str, Any]:
    return {"type": "number", "description": description}


def _areas(diagram: str) -> dict[str, Any]:
    return {
        "type": "object",
        "description": f"Areas in the {diagram} diagram. `area_ratio` is A ÷ B; coverage is the "
        "intersection ÷ the area of the covered gamut.",
        "additionalProperties": {"type": "number"},
    }


def _cusps(levels: list[QueryLevel], values: Mapping[str, Any]) -> Answered:
    level = levels[0]
    found = level.gamut.cusps(values["hues"], triangles=level.triangles)
    table = {
        "hue": found.hue,
        "lightness": found.lightness,
        "chroma": found.chroma,
        "point": found.points,
    }
    parts = {"point": level.axes, "device": found.channels}
    if found.device is not None:
        table["device"] = found.device
    return Answered({"channels": list(found.channels), **table}, table, parts)


def _comparison(levels: list[QueryLevel], values: Mapping[str, Any]) -> Answered:
    one, two = levels
    found = one.gamut.compare(
        two.gamut,
        sectors=values["sectors"],
        triangles=values["triangles"],
        max_error=values["max_error"],
    )
    figures = (
        *("volume_a", "volume_b", "intersection", "union", "a_covers_b", "b_covers_a"),
        *("jaccard", "symmetric_difference"),
    )
    sectors = {name: np.asarray(getattr(found.sectors, name)) for name in figures}
    table = {"hue_from": found.hues[:-1], "hue_to": found.hues[1:], **sectors}
    ends = {name: getattr(found, name) for name in ("white_a", "white_b", "black_a", "black_b")}
    document = {
        **{name: getattr(found, name) for name in figures},
        **ends,
        "chromaticity": None if found.chromaticity is None else found.chromaticity.to_mapping(),
        "sectors": table,
    }
    return Answered(document, table)


def _check_plane(values: Mapping[str, Any]) -> None:
    """Refuse a section without a plane, or with several."""
    given = [name for name in ("lightness", "hue", "plane") if values[name] is not None]
    if len(given) != 1:
        verb = "are" if len(given) > 1 else "is"
        fault = f"{' and '.join(given) or 'No plane'} {verb} given."
        remedy = "Give one of lightness, hue and plane."
        raise refuse(fault, "query", given[1] if given else "lightness", remedy)


def _slice(levels: list[QueryLevel], values: Mapping[str, Any]) -> Answered:
    _check_plane(values)
    level = levels[0]
    found = level.gamut.slice(
        values["lightness"], hue=values["hue"], plane=values["plane"], triangles=level.triangles
    )
    counts = np.diff(found.offsets)
    table = {"polygon": np.repeat(np.arange(len(counts)), counts), "point": found.points}
    document = {"channels": list(found.channels), "polygons": found.polygons}
    if found.device is not None:
        table["device"] = found.device
        document["device"] = np.split(found.device, found.offsets[1:-1]) if len(counts) else []
    return Answered(document, table, {"point": level.axes, "device": found.channels})


def _slice_picture(levels: list[QueryLevel], values: Mapping[str, Any]) -> bytes:
    _check_plane(values)
    level = levels[0]
    return level.gamut.slice_svg(
        values["lightness"], hue=values["hue"], plane=values["plane"], triangles=level.triangles
    )


def _leaves(levels: list[QueryLevel], values: Mapping[str, Any]) -> Answered:
    level = levels[0]
    found = level.gamut.leaves(values["hues"], values["lightness"], triangles=level.triangles)
    counts = np.diff(found.offsets)
    intervals, ends = found.chroma.tolist(), found.offsets.tolist()
    cells = [intervals[start:end] for start, end in pairwise(ends)]
    across = len(found.lightness)
    document = {
        "hue": found.hue,
        "lightness": found.lightness,
        "intervals": [cells[at : at + across] for at in range(0, len(cells), across)],
    }
    table = {
        "hue": np.repeat(np.repeat(found.hue, across), counts),
        "lightness": np.repeat(np.tile(found.lightness, len(found.hue)), counts),
        "chroma_from": found.chroma[:, 0],
        "chroma_to": found.chroma[:, 1],
    }
    return Answered(document, table)


def _rings(levels: list[QueryLevel], values: Mapping[str, Any]) -> Answered:
    level, *others = levels
    found = level.gamut.rings(
        others[0].gamut if others else None,
        sectors=values["sectors"],
        triangles=values["triangles"],
        max_error=values["max_error"],
    )
    rings = {
        name: radius
        for name in ("radius", "reference_radius", "intersection_radius")
        if (radius := getattr(found, name)) is not None
    }
    document = {
        "volume": found.volume,
        "lightness": found.lightness,
        "hue": found.hues,
        **rings,
    }
    table = {
        "lightness": np.repeat(found.lightness, len(found.hues)),
        "hue": np.tile(found.hues, len(found.lightness)),
        **{name: radius.reshape(-1) for name, radius in rings.items()},
    }
    return Answered(document, table)


def _rings_picture(levels: list[QueryLevel], values: Mapping[str, Any]) -> bytes:
    level, *others = levels
    return level.gamut.rings_svg(
        others[0].gamut if others else None,
        sectors=values["sectors"],
        triangles=values["triangles"],
        max_error=values["max_error"],
    )


VIEWS: Mapping[str, View] = {
    each.name: each
    for each in (
        View(
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
            {
                "channels": {"type": "array", "items": {"type": "string"}},
                "hue": _numbers("Hue in degrees."),
                "lightness": _numbers("Lightness of the cusp; null if the hue has no colour."),
                "chroma": _numbers("Chroma of the cusp."),
                "point": _rows("The cusp in the space of the gamut."),
                "device": _rows("Its device values from 0 to 1, if the gamut has any."),
            },
            _cusps,
            {
                "channels": ["C", "M", "Y", "K"],
                "hue": [0],
                "lightness": [48.1],
                "chroma": [73.9],
                "point": [[48.1, 73.9, 0.0]],
                "device": [[0.0, 1.0, 0.2, 0.0]],
            },
        ),
        View(
            "leaves",
            "listLeaves",
            "List the intervals of chroma",
            "The intervals of chroma that are in gamut, for each of a number of equidistant hues "
            "and lightnesses. A hue and lightness can have several intervals, and none needs to "
            "begin at the neutral axis.",
            (
                Parameter(
                    "hues",
                    Annotated[int, WholeNumber(1, 720)],
                    "Number of hues.",
                    default=360,
                    example=12,
                ),
                Parameter(
                    "lightness",
                    Annotated[int, WholeNumber(2, 501)],
                    "Number of lightnesses, from 0 to that of white.",
                    default=101,
                    example=11,
                ),
            ),
            {
                "hue": _numbers("Hues in degrees."),
                "lightness": _numbers("Lightnesses."),
                "intervals": {
                    "type": "array",
                    "items": {"type": "array", "items": _ROWS},
                    "description": "By hue and lightness: the pairs of smallest and largest "
                    "chroma.",
                },
            },
            _leaves,
            {"hue": [0], "lightness": [0, 50], "intervals": [[[], [[0, 77.1]]]]},
        ),
        View(
            "slice",
            "sliceGamut",
            "Cut the gamut by a plane",
            "The section by a plane of constant lightness, by the half-plane of a hue, "
            "or by any plane, as closed polygons. Polygons inside others are holes.",
            (
                Parameter("lightness", _FINITE, "Lightness of the plane.", example=50),
                Parameter("hue", _FINITE, "Hue of the half-plane in degrees."),
                Parameter("plane", _PLANE, "a,b,c,d: the points with a x + b y + c z = d."),
            ),
            {
                "channels": {"type": "array", "items": {"type": "string"}},
                "polygons": {
                    "type": "array",
                    "items": _ROWS,
                    "description": "Corners of each polygon in the space of the gamut.",
                },
                "device": {
                    "type": "array",
                    "items": _ROWS,
                    "description": "Device values of the corners, if the gamut has any.",
                },
            },
            _slice,
            {
                "channels": ["C", "M", "Y", "K"],
                "polygons": [[[50, 70, 0], [50, 0, 60], [50, -60, 0]]],
                "device": [[[0, 1, 0, 0], [0, 0.4, 1, 0.2], [1, 0, 0.6, 0]]],
            },
            _slice_picture,
        ),
        View(
            "rings",
            "listRings",
            "List the gamut rings",
            "Gamut rings (IDMS 1.1, 5.32): the area within the ring of a lightness is the volume "
            "of the gamut up to this lightness, by sector of hue. With a reference, also its rings "
            "and the outer end of the intersection in each band.",
            (
                Parameter(
                    "reference",
                    Annotated[str, Text(64, "the id of a gamut or the slug of a reference gamut")],
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
            {
                "reference_level": {"type": "object"},
                "reference_gamut": {"type": "object"},
                "volume": _number("Volume up to the last lightness: the area of the outer ring."),
                "lightness": _numbers("Lightnesses of the rings: tenths of that of white."),
                "hue": _numbers("Middles of the sectors in degrees."),
                "radius": _rows("Radius by ring and sector."),
                "reference_radius": _rows("The same of the reference."),
                "intersection_radius": _rows("Outer end of the intersection in each band."),
            },
            _rings,
            {
                "volume": 402000.0,
                "lightness": [50, 100],
                "hue": [90, 270],
                "radius": [[320.1, 300.2], [380.3, 340.4]],
            },
            _rings_picture,
        ),
    )
}
"""Views of one gamut by name."""

COMPARISON = View(
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
            default=36,
            example=12,
        ),
    ),
    {
        "volume_a": _number("Volume of A in cubic units of the space."),
        "volume_b": _number("Volume of B."),
        "intersection": _number("Volume of the part that both have."),
        "union": _number("Volume of the part that at least one has."),
        "a_covers_b": _number("Intersection ÷ volume of B."),
        "b_covers_a": _number("Intersection ÷ volume of A."),
        "jaccard": _number("Intersection ÷ union."),
        "symmetric_difference": _number("Volume of the part that exactly one has."),
        "white_a": _numbers("Lightest colour of A."),
        "white_b": _numbers("Lightest colour of B."),
        "black_a": _numbers("Darkest colour of A."),
        "black_b": _numbers("Darkest colour of B."),
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
    _comparison,
    {
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
)
"""The comparison of two gamuts."""
