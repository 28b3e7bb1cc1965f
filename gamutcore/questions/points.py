"""Questions about single colours: in gamut, distance, nearest, crossings."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Literal, NamedTuple, cast

import numpy as np

from gamutcore import search
from gamutcore.arguments import Boolean, Choice, Number, check_option
from gamutcore.errors import OptionError
from gamutcore.questions.conditions import build_warnings, colour_warnings
from gamutcore.questions.declarations import (
    BOOLEAN,
    COLOUR,
    DEVICE,
    NUMBER,
    Column,
    Parameter,
    Question,
    list_of,
)
from gamutcore.questions.levels import (
    answering_level,
    colours_in,
    lab_of,
    surface_facts,
    tolerance_of,
)
from gamutcore.results import ColourCrossings, NearestColours
from gamutcore.search import delta_e_2000

if TYPE_CHECKING:
    from collections.abc import Mapping
    from typing import Any

    from numpy.typing import NDArray

    from gamutcore.arrays import BooleanArray, FloatArray
    from gamutcore.colour_rows import Colours
    from gamutcore.questions.levels import GamutLike, IndexedLevel

__all__ = [
    "CONTAINS",
    "CROSSINGS",
    "NEAREST",
    "classify",
    "contains",
    "crossings",
    "distance",
    "nearest",
    "positions",
]

METRIC = Annotated[
    str,
    Choice(
        ("CIE 1976", "CIE 2000"),
        {"euclidean": "CIE 1976", "ciede2000": "CIE 2000", "deltae2000": "CIE 2000"},
    ),
]
"""Measures of nearness, named as in colour-science. CIE 1976 is the Euclidean distance."""

_METRIC = Parameter(
    "metric",
    METRIC,
    "Measure of `distance`. `CIE 1976` or `euclidean`: Euclidean, in units of the space. "
    "`CIE 2000`: the colour difference CIEDE2000, for gamuts in CIELAB. The answer states it.",
    default="CIE 1976",
)

DISTANCE = "Least distance from the surface by `metric`"
"""What `distance` means in all answers."""

TOLERANCE = Annotated[float, Number(0.0, 1e6)]
"""A largest distance from the surface, in units of the space."""


class Positions(NamedTuple):
    """Where colours are; the distance and the position if they were asked for."""

    inside: BooleanArray
    distance: FloatArray | None
    position: NDArray[Any] | None


def positions(
    gamut: GamutLike,
    colours: Colours,
    *,
    distance: bool = False,
    metric: str = "CIE 1976",
    position: bool = False,
    tolerance: float | None = None,
    edge_width: float | None = None,
    space: str | None = None,
    triangles: int | None = None,
    max_error: float | None = None,
) -> Positions:
    """Return where colours are. A tolerance or an edge width implies the position.

    The position is by Euclidean distance, and `distance` by the metric.
    """
    name = check_option("metric", metric, METRIC)
    rows, _ = colours_in(gamut, colours, space)
    level = answering_level(gamut, triangles, max_error)
    widths = {
        name: None if value is None else check_option(name, value, TOLERANCE)
        for name, value in (("tolerance", tolerance), ("edge_width", edge_width))
    }
    limits = _limits(gamut, {**widths, "triangles": level.triangles})
    position = position or tolerance is not None or edge_width is not None
    inside = search.contains(rows.points, level.index, limits["tolerance"])
    away, shown = None, None
    if distance:
        away = _signed_distance(gamut, rows.points, level, name)
        shown = rows.in_shape(away)
    if not position:
        return Positions(rows.in_shape(inside), shown, None)
    if away is None or name != "CIE 1976":
        away = search.signed_distance(rows.points, level.index)
    far = np.where(away < 0.0, "inside", "outside")
    places = np.where(np.abs(away) <= max(limits.values()), "edge", far)
    return Positions(rows.in_shape(inside), shown, rows.in_shape(places))


def contains(
    gamut: GamutLike,
    colours: Colours,
    *,
    tolerance: float | None = None,
    space: str | None = None,
    triangles: int | None = None,
    max_error: float | None = None,
) -> BooleanArray:
    """Whether colours are in gamut: inside the level, or within a tolerance of it.

    Parameters
    ----------
    tolerance : float, optional
        Largest distance of a colour outside, in units of the gamut's space; by default that of
        `tolerance`, which covers the measured patches, and the colours of the device model
        that a search found. 0 asks for colours inside or on the surface of the level, without
        rounding errors.

    Returns
    -------
    (...) bool

    Examples
    --------
    >>> from gamutcore import Gamut
    >>> colours = [(20, 0, 0), (90, 0, 0), (50, 60, 0), (50, -40, 50), (50, -40, -50)]
    >>> Gamut(colours).contains((50, 0, 300), space="LCHab").item()
    True
    """
    return positions(
        gamut,
        colours,
        tolerance=tolerance,
        space=space,
        triangles=triangles,
        max_error=max_error,
    ).inside


def classify(
    gamut: GamutLike,
    colours: Colours,
    *,
    edge_width: float | None = None,
    tolerance: float | None = None,
    space: str | None = None,
    triangles: int | None = None,
    max_error: float | None = None,
) -> NDArray[Any]:
    """Say where colours are: inside, at the edge or outside.

    Parameters
    ----------
    edge_width : float, optional
        Largest distance from the surface of a colour at the edge, in units of the gamut's
        space. By default `tolerance` if that is given, else `default_edge_width`: 1 in CIELAB.
    tolerance : float, optional
        As for `contains`. Colours within it are at the edge as well.

    Returns
    -------
    (...) str
        ``"inside"``, ``"edge"`` or ``"outside"``. `contains` is true for colours inside, false
        for colours outside, and decides by `tolerance` at the edge.

    Examples
    --------
    >>> from gamutcore import Gamut
    >>> cube = [(l, a, b) for l in (40, 60) for a in (-10, 10) for b in (-10, 10)]
    >>> Gamut(cube).classify([(50, 0, 0), (50, 0, 11), (50, 0, 25)], edge_width=2).tolist()
    ['inside', 'edge', 'outside']
    """
    classes = positions(
        gamut,
        colours,
        position=True,
        tolerance=tolerance,
        edge_width=edge_width,
        space=space,
        triangles=triangles,
        max_error=max_error,
    ).position
    return cast("NDArray[Any]", classes)


def _signed_distance(
    gamut: GamutLike, points: FloatArray, level: IndexedLevel, metric: str
) -> FloatArray:
    """Return the least distances (n,) of points from the surface, negative inside."""
    if metric == "CIE 1976":
        return search.signed_distance(points, level.index)
    away = _nearest(gamut, points, level, metric).distance
    return np.where(search.contains(points, level.index), -away, away)


def _nearest(
    gamut: GamutLike, points: FloatArray, level: IndexedLevel, metric: str
) -> search.SurfacePoints:
    """Return the nearest points of the surface, and their distances, by a metric."""
    if metric == "CIE 1976":
        return search.nearest(points, level.index)
    if gamut.colour_space.is_icc_cielab:
        return search.nearest_ciede2000(points, level.index)
    raise OptionError.not_applicable(
        "metric",
        metric,
        f"the gamut is in {gamut.colour_space.name}, and CIE 2000 is defined in CIELAB",
        "Build the gamut in CIELAB, or give the metric CIE 1976.",
    )


def _metric(_gamut: GamutLike, values: Mapping[str, Any]) -> dict[str, str]:
    """Return the metric of `distance`, as answers state it."""
    return {"metric": str(check_option("metric", values["metric"], METRIC))}


def _stated(gamut: GamutLike, values: Mapping[str, Any]) -> dict[str, float | str]:
    """Return the tolerance, the edge width and the metric, with their defaults."""
    return {**_limits(gamut, values), **_metric(gamut, values)}


def _limits(gamut: GamutLike, values: Mapping[str, Any]) -> dict[str, float]:
    """Return the tolerance and the edge width, with their defaults."""
    tolerance, width = values["tolerance"], values["edge_width"]
    if width is None:
        width = gamut.default_edge_width if tolerance is None else tolerance
    if tolerance is None:
        tolerance = tolerance_of(gamut, values["triangles"])
    return {"tolerance": tolerance, "edge_width": width}


CONTAINS = Question(
    "contains",
    "containsColours",
    "Whether colours are in gamut",
    "Whether each colour is inside the gamut, on its surface, or outside by the tolerance at most; "
    "optionally the distance from the surface, or whether the colour is at the edge. The answer "
    "states `tolerance` and `edge_width` in units of the space.",
    (
        Parameter(
            "distance",
            Annotated[bool, Boolean()],
            "Whether to answer with the distances from the surface as well.",
            default=False,
        ),
        _METRIC,
        Parameter(
            "position",
            Annotated[bool, Boolean()],
            "Whether to answer with the positions as well: inside, edge or outside. `tolerance` "
            "and `edge_width` imply it.",
            default=False,
        ),
        Parameter(
            "tolerance",
            TOLERANCE,
            "Largest distance outside of a colour that is in gamut. 0: exactly inside or on the "
            "surface. Default: the error of the level and of the full boundary, which covers "
            "measured patches and the colours of the device model. Adds `position`.",
            example=0.5,
        ),
        Parameter(
            "edge_width",
            TOLERANCE,
            "Largest distance from the surface of a colour at the edge. Default: `tolerance` if "
            "that is given, else 1 in CIELAB, and the same share of the lightness of white in "
            "other spaces. Adds `position`.",
            example=1.0,
        ),
    ),
    positions,
    inputs=("colours",),
    columns=(
        Column("inside", "Whether the colour is in gamut.", BOOLEAN),
        Column(
            "distance",
            f"{DISTANCE}, negative inside. With `distance=true`.",
            NUMBER,
        ),
        Column(
            "position",
            "Where the colour is. With `position=true`, `tolerance` or `edge_width`.",
            {"type": "string", "enum": ["inside", "edge", "outside"]},
        ),
    ),
    example={"colours": [[50, 0, 0], [50, 90, 0]], "distance": True, "tolerance": 0.5},
    example_answer={
        "inside": [True, False],
        "distance": [-38.5, 18.5],
        "position": ["inside", "outside"],
        "tolerance": 0.5,
        "edge_width": 0.5,
        "metric": "CIE 1976",
    },
    echoed=_stated,
)


def distance(
    gamut: GamutLike,
    colours: Colours,
    *,
    metric: str = "CIE 1976",
    space: str | None = None,
    triangles: int | None = None,
    max_error: float | None = None,
) -> FloatArray:
    """Return the least distances of colours from the surface, negative inside.

    Parameters
    ----------
    metric : str, optional
        ``"CIE 1976"``: Euclidean, in units of the gamut's space. ``"CIE 2000"``: the colour
        difference CIE 2000, for gamuts in CIELAB.

    Returns
    -------
    (...) float64
        By the metric. Their magnitudes are those of `nearest`.

    Examples
    --------
    >>> from gamutcore import Gamut
    >>> cube = [(l, a, b) for l in (40, 60) for a in (-10, 10) for b in (-10, 10)]
    >>> Gamut(cube).distance([(50, 0, 0), (50, 0, 25)]).round(3).tolist()
    [-10.0, 15.0]
    """
    name = check_option("metric", metric, METRIC)
    rows, _ = colours_in(gamut, colours, space)
    level = answering_level(gamut, triangles, max_error)
    return rows.in_shape(_signed_distance(gamut, rows.points, level, name))


def nearest(
    gamut: GamutLike,
    colours: Colours,
    *,
    metric: str = "CIE 1976",
    space: str | None = None,
    triangles: int | None = None,
    max_error: float | None = None,
) -> NearestColours:
    """Find the nearest points of the surface, for colours inside and outside.

    Parameters
    ----------
    metric : str, optional
        ``"CIE 1976"``: the smallest Euclidean distance. ``"CIE 2000"``: the smallest colour
        difference CIE 2000, for gamuts in CIELAB.

    Returns
    -------
    NearestColours
        With `points`, `distance`, `delta_e` and `device`.

    Examples
    --------
    >>> from gamutcore import Gamut
    >>> cube = [(l, a, b) for l in (40, 60) for a in (-10, 10) for b in (-10, 10)]
    >>> near = Gamut(cube).nearest((50, 0, 25))
    >>> near.points.round(3).tolist(), round(near.distance.item(), 3)
    ([50.0, 0.0, 10.0], 15.0)
    """
    name = check_option("metric", metric, METRIC)
    rows, conversion = colours_in(gamut, colours, space)
    level = answering_level(gamut, triangles, max_error)
    places = _nearest(gamut, rows.points, level, name)
    difference = delta_e_2000(lab_of(gamut, rows.points), lab_of(gamut, places.points))
    return NearestColours(
        points=rows.in_shape(conversion.from_gamut(places.points)),
        space=conversion.name,
        warnings=(
            *build_warnings(gamut.conditions),
            *colour_warnings(gamut.conditions, conversion.name),
        ),
        distance=rows.in_shape(places.distance),
        delta_e=rows.in_shape(difference),
        **surface_facts(gamut, level, places, rows),
    )


NEAREST = Question(
    "nearest",
    "findNearest",
    "Find the nearest colours of the surface",
    "For each colour inside or outside, the nearest colour of the gamut's surface.",
    (
        replace(
            _METRIC,
            description="What nearest means, and the measure of `distance`. `CIE 1976` or "
            "`euclidean`: the smallest Euclidean distance in the space of the gamut. `CIE 2000`: "
            "the smallest colour difference CIEDE2000, for gamuts in CIELAB. The answer states it.",
        ),
    ),
    nearest,
    inputs=("colours",),
    columns=(
        Column("point", "Nearest colour, in the space of the colours.", COLOUR, "axes", "points"),
        Column("distance", f"{DISTANCE}: that of `point`.", NUMBER),
        Column("delta_e_2000", "Colour difference CIEDE2000 from `point`.", NUMBER, "", "delta_e"),
        DEVICE,
    ),
    example={"colours": [[50, 90, 0]], "metric": "CIE 1976"},
    example_answer={
        "point": [[50.9, 76.9, 1.2]],
        "distance": [13.2],
        "delta_e_2000": [3.1],
        "device": [[0.0, 1.0, 0.05, 0.0]],
        "metric": "CIE 1976",
    },
    echoed=_metric,
)


def crossings(
    gamut: GamutLike,
    starts: Colours,
    ends: Colours,
    *,
    kind: Literal["segment", "ray", "line"] = "segment",
    space: str | None = None,
    triangles: int | None = None,
    max_error: float | None = None,
) -> ColourCrossings:
    """Find all crossings of lines with the surface, in order.

    Parameters
    ----------
    starts, ends : (..., 3) array_like
        Two colours of each line, which is straight in the space of the gamut. They are
        broadcast against each other.
    kind : {'segment', 'ray', 'line'}, optional
        A ray begins at the start and goes beyond the end; a line goes beyond both.

    Returns
    -------
    ColourCrossings
        Flat, with `offsets` for the rows, `t`, `entering`, `points` and `device`.

    Raises
    ------
    InvalidPointsError
        Also for a ray or line with two equal points.

    Examples
    --------
    >>> from gamutcore import Gamut
    >>> cube = [(l, a, b) for l in (40, 60) for a in (-10, 10) for b in (-10, 10)]
    >>> found = Gamut(cube).crossings((50, 0, 0), (50, 0, 40))
    >>> found.t.round(3).tolist(), found.entering.tolist()
    ([0.25], [False])
    """
    (first, conversion), (second, _) = (
        colours_in(gamut, starts, space, "starts"),
        colours_in(gamut, ends, space, "ends"),
    )
    lines = np.broadcast_arrays(first.in_shape(first.points), second.in_shape(second.points))
    level = answering_level(gamut, triangles, max_error)
    # Copies, because kernels take arrays that may be written to.
    one, two = (np.array(points, order="C").reshape(-1, 3) for points in lines)
    hits = search.crossings(one, two, level.index, kind)
    return ColourCrossings(
        points=conversion.from_gamut(hits.points),
        space=conversion.name,
        offsets=hits.offsets,
        t=hits.t,
        entering=hits.entering,
        **surface_facts(gamut, level, hits),
    )


CROSSINGS = Question(
    "crossings",
    "findCrossings",
    "Find the crossings of lines with the surface",
    "All crossings of each line with the surface of the gamut, in order. A line is straight in the "
    "space of the gamut. Columns have one list per row.",
    (
        Parameter(
            "kind",
            Annotated[str, Choice(("segment", "ray", "line"))],
            "`segment`: from `from` to `to`. `ray`: on beyond `to`. `line`: beyond both.",
            default="segment",
        ),
    ),
    crossings,
    inputs=("from", "to"),
    columns=(
        Column("t", "Places on the line: 0 at `from`, 1 at `to`.", list_of(NUMBER)),
        Column("entering", "Whether the line enters the gamut.", list_of(BOOLEAN)),
        Column("point", "Colours, in the space of the rows.", list_of(COLOUR), "axes", "points"),
        replace(DEVICE, schema=list_of(DEVICE.schema)),
    ),
    example={"from": [[50, 0, 0]], "to": [[50, 100, 0]]},
    example_answer={
        "t": [[0.75]],
        "entering": [[False]],
        "point": [[[50, 75, 0]]],
        "device": [[[0.0, 1.0, 0.1, 0.0]]],
    },
)
