"""The table of queries: name, parameters and result columns of every operation.

Routes, the OpenAPI document and the forms of the answers follow from it. An entry calls methods of
`gamutcore.Gamut`; nothing is computed here.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gamutcore.arguments import Boolean, Choice, Coordinates, Number, Text, WholeNumber
from gamutcore.arrays import FloatArray
from gamutcore.colours import GIVEN_SPACE
from gamutcore.questions.conditions import colour_warnings
from gamutcore.questions.mapping import MAP, METHOD
from gamutcore.questions.points import METRIC, TOLERANCE
from gamutcore.results import SurfaceAnswer
from service.http.parameters import LARGEST_WHOLE
from service.queries.levels import QueryLevel
from service.queries.parameters import Parameter

__all__ = [
    "LEVEL_PARAMETERS",
    "OPERATIONS",
    "SOURCE_GAMUT",
    "SPACE",
    "TABLE_PARAMETERS",
    "Column",
    "Operation",
    "Result",
    "stated_header",
]

_FOCUS = Annotated[str, Choice(("cusp",))] | Coordinates

LEVEL_PARAMETERS = (
    Parameter(
        "triangles",
        Annotated[int, WholeNumber(4, LARGEST_WHOLE)],
        "Largest triangle count of the level that answers.",
        example=1000,
    ),
    Parameter(
        "max_error",
        Annotated[float, Number(0.0, 1e12)],
        "Largest distance between the level that answers and the full boundary, in units of the "
        "space. 0: the full boundary. Default without `triangles`: 0.1 in CIELAB, and the same "
        "share of the lightness of white in other spaces.",
        example=0.1,
    ),
)
"""Parameters of all queries: the level."""

SOURCE_GAMUT = "source gamut"
"""Key of the gamut that the parameter `source` names, among the values of the parameters."""

SPACE = Parameter(
    "space",
    GIVEN_SPACE,
    "Space of the colours; that of the gamut by default. `LCHab` has the hue in degrees, `sRGB` is "
    "from 0 to 1. The names of the columns of a table decide without it. In the query string of a "
    "slug, `space` is the option of the build instead.",
    example="CIELAB",
)
"""The space of colours in requests and answers."""


TABLE_PARAMETERS = (
    Parameter(
        "columns",
        Annotated[str, Text(200, "names or numbers of columns, separated by commas")],
        "For tables: names or numbers of the three columns of the colours, or of the one with "
        "texts such as `#e4002b`. By default, the names of the columns decide.",
        example="L,a,b",
    ),
    Parameter(
        "table_scale",
        Annotated[float, Number(0.0, 1e6, above_least=True, below_most=True)],
        "For tables: the value of white, such as 1, 100 or 255. By default, the values decide, and "
        "with `space` it is 1 for `sRGB` and `CIEXYZ`.",
        example=255,
    ),
)
"""Parameters of queries whose body is a table."""


class Result(NamedTuple):
    """The answer to some rows.

    Attributes
    ----------
    columns : dict of array
        Arrays (n,) or (n, k) by the name of the column; for several entries per row, (m,) or
        (m, k).
    offsets : (n + 1,) int or None
        First entry of each row, if rows have several entries.
    channels : tuple of str
        Names of the channels of device values.
    stated : mapping of str to float
        Values of parameters that the answer states.
    """

    columns: dict[str, NDArray[Any]]
    offsets: NDArray[np.integer[Any]] | None = None
    channels: tuple[str, ...] = ()
    stated: Mapping[str, float] = {}


@dataclass(frozen=True)
class Column:
    """A column of the result.

    Attributes
    ----------
    name : str
    description : str
    schema : mapping
        JSON schema of one value.
    parts : str
        "axes" for a colour, "channels" for device values, empty for one value.
    """

    name: str
    description: str
    schema: Mapping[str, Any]
    parts: str = ""


_NUMBER = {"type": "number"}
_BOOLEAN = {"type": "boolean"}


_COLOUR = {"type": "array", "items": _NUMBER, "minItems": 3, "maxItems": 3}

_DEVICE = (
    "Device values from 0 to 1, interpolated between the vertices of the level. Only for gamuts "
    "with device values."
)


def stated_header(name: str) -> str:
    """Return the header field that states the value of a parameter.

    Examples
    --------
    >>> stated_header("edge_width")
    'Gamut-Edge-Width'
    """
    return f"Gamut-{name.replace('_', '-').title()}"


def _list(schema: Mapping[str, Any]) -> dict[str, Any]:
    return {"type": "array", "items": schema}


@dataclass(frozen=True)
class Operation:
    """A query that clients POST.

    Attributes
    ----------
    name : str
        Last part of the path.
    operation_id, summary, description : str
        For OpenAPI.
    inputs : tuple of str
        Names of the colours of a row.
    parameters : tuple of Parameter
        Besides the level and the space.
    columns : tuple of Column
        All that an answer may have; parameters and gamut decide which it has.
    answer : callable
        From the level, one array (n, 3) per input, and the values of the parameters to the result.
    example : mapping
        Members of an exemplary JSON body.
    answered : mapping
        The columns of the answer to the example.
    stated : callable
        From the level and the values of the parameters to the values that the answer states, in
        members and in header fields.
    """

    name: str
    operation_id: str
    summary: str
    description: str
    parameters: tuple[Parameter, ...]
    columns: tuple[Column, ...]
    answer: Callable[[QueryLevel, list[FloatArray], Mapping[str, Any]], Result]
    example: Mapping[str, Any]
    answered: Mapping[str, Any]
    inputs: tuple[str, ...] = ("colours",)
    stated: Callable[[QueryLevel, Mapping[str, Any]], dict[str, float]] = lambda _level, _values: {}

    @property
    def all_parameters(self) -> tuple[Parameter, ...]:
        """The parameters, those of the level first."""
        return (*LEVEL_PARAMETERS, SPACE, *self.parameters)

    @property
    def query_parameters(self) -> tuple[Parameter, ...]:
        """The parameters of the query string."""
        return (*self.all_parameters, *TABLE_PARAMETERS)

    def warnings(self, level: QueryLevel, values: Mapping[str, Any]) -> tuple[str, ...]:
        """Return reasons why the answer may mislead, by the conditions of the gamuts."""
        conditions, source = level.gamut.conditions, values.get(SOURCE_GAMUT)
        found: tuple[str, ...] = ()
        if self.inputs == ("colours",):
            found = colour_warnings(conditions, values["space"] or "")
        if source is not None:
            found += MAP.compared(conditions, source.conditions)
        return found


def _contains(level: QueryLevel, colours: list[FloatArray], values: Mapping[str, Any]) -> Result:
    gamut, asked = level.gamut, {"space": values["space"], "triangles": level.triangles}
    stated = _limits(level, values)
    tolerance, width = stated["tolerance"], stated["edge_width"]
    inside = gamut.contains(colours[0], tolerance=tolerance, **asked)
    columns: dict[str, NDArray[Any]] = {"inside": np.asarray(inside)}
    if values["distance"]:
        columns["distance"] = gamut.distance(colours[0], **asked)
    given = [values[name] is not None for name in ("tolerance", "edge_width")]
    if values["position"] or any(given):
        columns["position"] = gamut.classify(
            colours[0], tolerance=tolerance, edge_width=width, **asked
        )
    return Result(columns, stated=stated)


def _limits(level: QueryLevel, values: Mapping[str, Any]) -> dict[str, float]:
    """Return the tolerance and the edge width, with their defaults as of `Gamut.classify`."""
    gamut, tolerance, width = level.gamut, values["tolerance"], values["edge_width"]
    if width is None:
        width = gamut.default_edge_width if tolerance is None else tolerance
    if tolerance is None:
        tolerance = gamut.tolerance(triangles=level.triangles)
    return {"tolerance": tolerance, "edge_width": width}


def _nearest(level: QueryLevel, colours: list[FloatArray], values: Mapping[str, Any]) -> Result:
    found = level.gamut.nearest(
        colours[0], metric=values["metric"], space=values["space"], triangles=level.triangles
    )
    columns = {
        "point": found.points,
        "distance": found.distance,
        "delta_e_2000": found.delta_e,
    }
    return _on_surface(columns, found)


def _map(level: QueryLevel, colours: list[FloatArray], values: Mapping[str, Any]) -> Result:
    found = level.gamut.map(
        colours[0],
        values["method"],
        focus=values["focus"],
        source=values.get(SOURCE_GAMUT),
        black_point_compensation=values["black_point_compensation"],
        space=values["space"],
        # the level of the source is chosen by the same values
        triangles=values["triangles"],
        max_error=values["max_error"],
    )
    columns = {"mapped": found.points, "moved": found.moved, "delta_e_2000": found.delta_e}
    return _on_surface(columns, found)


def _crossings(level: QueryLevel, colours: list[FloatArray], values: Mapping[str, Any]) -> Result:
    found = level.gamut.crossings(
        *colours, kind=values["kind"], space=values["space"], triangles=level.triangles
    )
    columns = {"t": found.t, "entering": found.entering, "point": found.points}
    return _on_surface(columns, found, found.offsets)


def _on_surface(
    columns: dict[str, NDArray[Any]],
    found: SurfaceAnswer,
    offsets: NDArray[np.integer[Any]] | None = None,
) -> Result:
    """Return a result with the device values, if there are any."""
    if found.device is not None:
        columns["device"] = found.device
    return Result(columns, offsets, found.channels)


OPERATIONS: Mapping[str, Operation] = {
    each.name: each
    for each in (
        Operation(
            "contains",
            "containsColours",
            "Whether colours are in gamut",
            "Whether each colour is inside the gamut, on its surface, or outside by the tolerance "
            "at most; optionally the distance from the surface, or whether the colour is at the "
            "edge. The answer states `tolerance` and `edge_width` in units of the space.",
            (
                Parameter(
                    "distance",
                    Annotated[bool, Boolean()],
                    "Whether to answer with the distances from the surface as well.",
                    default=False,
                ),
                Parameter(
                    "position",
                    Annotated[bool, Boolean()],
                    "Whether to answer with the positions as well: inside, edge or outside. "
                    "`tolerance` and `edge_width` imply it.",
                    default=False,
                ),
                Parameter(
                    "tolerance",
                    TOLERANCE,
                    "Largest distance outside of a colour that is in gamut. 0: exactly inside or "
                    "on the surface. Default: the error of the level and of the full boundary, so "
                    "that no colour of the device itself is outside. Adds `position`.",
                    example=0.5,
                ),
                Parameter(
                    "edge_width",
                    TOLERANCE,
                    "Largest distance from the surface of a colour at the edge. Default: "
                    "`tolerance` if that is given, else 1 in CIELAB, and the same share of the "
                    "lightness of white in other spaces. Adds `position`.",
                    example=1.0,
                ),
            ),
            (
                Column("inside", "Whether the colour is in gamut.", _BOOLEAN),
                Column(
                    "distance",
                    "Distance from the surface in units of the space, negative inside. With "
                    "`distance=true`.",
                    _NUMBER,
                ),
                Column(
                    "position",
                    "Where the colour is. With `position=true`, `tolerance` or `edge_width`.",
                    {"type": "string", "enum": ["inside", "edge", "outside"]},
                ),
            ),
            _contains,
            {"colours": [[50, 0, 0], [50, 90, 0]], "distance": True, "tolerance": 0.5},
            {
                "inside": [True, False],
                "distance": [-38.5, 18.5],
                "position": ["inside", "outside"],
                "tolerance": 0.5,
                "edge_width": 0.5,
            },
            stated=_limits,
        ),
        Operation(
            "nearest",
            "findNearest",
            "Find the nearest colours of the surface",
            "For each colour inside or outside, the nearest colour of the gamut's surface.",
            (
                Parameter(
                    "metric",
                    METRIC,
                    "What nearest means. `CIE 1976` or `euclidean`: the smallest Euclidean "
                    "distance in the space of the gamut.",
                    default="CIE 1976",
                ),
            ),
            (
                Column("point", "Nearest colour, in the space of the colours.", _COLOUR, "axes"),
                Column("distance", "Euclidean distance in the space of the gamut.", _NUMBER),
                Column("delta_e_2000", "Colour difference CIEDE2000.", _NUMBER),
                Column("device", _DEVICE, _list(_NUMBER), "channels"),
            ),
            _nearest,
            {"colours": [[50, 90, 0]], "metric": "CIE 1976"},
            {
                "point": [[50.9, 76.9, 1.2]],
                "distance": [13.2],
                "delta_e_2000": [3.1],
                "device": [[0.0, 1.0, 0.05, 0.0]],
            },
        ),
        Operation(
            "map",
            "mapColours",
            "Map colours into the gamut",
            "Each colour, moved into the gamut by a usual method. Colours inside stay as they are, "
            "except by `sgck` and with `black_point_compensation`.",
            (
                Parameter(
                    "method",
                    METHOD,
                    "`clip-nearest`: to the nearest colour. `clip-hue`: to the nearest of the same "
                    "hue (HPMINDE, CIE 156:2004). `clip-lightness`: the chroma stays. "
                    "`clip-chroma`: the lightness stays. `clip-focal`: towards `focus`. `sgck`: "
                    "compression from the gamut `source` (CIE 156:2004).",
                    default="clip-hue",
                ),
                Parameter(
                    "focus",
                    _FOCUS,
                    "Focal point of `clip-focal`, in the space of the colours. `cusp`: the "
                    "lightness of the cusp on the neutral axis.",
                ),
                Parameter(
                    "source",
                    Annotated[str, Text(64, "the id of a gamut or the slug of a reference gamut")],
                    "Gamut that `sgck` maps from, in the same space: an id, or the slug of a "
                    "reference gamut.",
                    example="srgb",
                ),
                Parameter(
                    "black_point_compensation",
                    Annotated[bool, Boolean()],
                    "Whether colours are first scaled in CIEXYZ, so that L* = 0 becomes the "
                    "darkest neutral colour of the gamut, and white stays (ISO 18619). Not for "
                    "`sgck`.",
                    default=False,
                ),
            ),
            (
                Column("mapped", "The mapped colour.", _COLOUR, "axes"),
                Column("moved", "Whether the colour has another place.", _BOOLEAN),
                Column("delta_e_2000", "Colour difference CIEDE2000.", _NUMBER),
                Column(
                    "device",
                    f"{_DEVICE} Null inside.",
                    _list({"type": ["number", "null"]}),
                    "channels",
                ),
            ),
            _map,
            {"colours": [[50, 90, 0]], "method": "clip-chroma"},
            {
                "mapped": [[50, 75.9, 0]],
                "moved": [True],
                "delta_e_2000": [3.3],
                "device": [[0.0, 1.0, 0.05, 0.02]],
            },
        ),
        Operation(
            "crossings",
            "findCrossings",
            "Find the crossings of lines with the surface",
            "All crossings of each line with the surface of the gamut, in order. A line is "
            "straight in the space of the gamut. Columns have one list per row.",
            (
                Parameter(
                    "kind",
                    Annotated[str, Choice(("segment", "ray", "line"))],
                    "`segment`: from `from` to `to`. `ray`: on beyond `to`. `line`: beyond both.",
                    default="segment",
                ),
            ),
            (
                Column("t", "Places on the line: 0 at `from`, 1 at `to`.", _list(_NUMBER)),
                Column("entering", "Whether the line enters the gamut.", _list(_BOOLEAN)),
                Column("point", "Colours, in the space of the rows.", _list(_COLOUR), "axes"),
                Column("device", _DEVICE, _list(_list(_NUMBER)), "channels"),
            ),
            _crossings,
            {"from": [[50, 0, 0]], "to": [[50, 100, 0]]},
            {
                "t": [[0.75]],
                "entering": [[False]],
                "point": [[[50, 75, 0]]],
                "device": [[[0.0, 1.0, 0.1, 0.0]]],
            },
            ("from", "to"),
        ),
    )
}
"""The queries by name."""
