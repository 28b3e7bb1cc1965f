"""Questions about single colours: in gamut, distance, nearest, crossings."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, cast

import numpy as np

from gamutcore import queries
from gamutcore.answers.base import Answering
from gamutcore.answers.conditions import colour_warnings
from gamutcore.arguments import Choice, Number, check_option
from gamutcore.errors import OptionError
from gamutcore.queries import delta_e_2000
from gamutcore.results import ColourCrossings, NearestColours

if TYPE_CHECKING:
    from typing import Any, Literal

    from numpy.typing import NDArray

    from gamutcore.answers.base import IndexedLevel
    from gamutcore.arrays import BooleanArray, FloatArray
    from gamutcore.colour_rows import Colours

__all__ = ["METRIC", "TOLERANCE", "PointAnswers"]

METRIC = Annotated[
    str,
    Choice(
        ("CIE 1976", "CIE 2000"),
        {"euclidean": "CIE 1976", "ciede2000": "CIE 2000", "deltae2000": "CIE 2000"},
    ),
]
"""Measures of nearness, named as in colour-science. CIE 1976 is the Euclidean distance."""

TOLERANCE = Annotated[float, Number(0.0, 1e6)]
"""A largest distance from the surface, in units of the space."""


def _distance(name: str, value: object) -> float:
    return cast("float", check_option(name, value, TOLERANCE))


class PointAnswers(Answering):
    """The questions about single colours."""

    def contains(
        self,
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
        colours : (..., 3) array_like
        tolerance : float, optional
            Largest distance of a colour outside, in units of the gamut's space; by default that of
            `tolerance`, so that no colour of the device itself is outside. 0 asks for colours
            inside or on the surface of the level, without rounding errors.
        space : str, optional
            Space of the colours; that of the gamut by default.
        triangles, max_error : optional
            The level.

        Returns
        -------
        (...) bool

        Raises
        ------
        InvalidPointsError
            A row is not three finite numbers; ``where["row"]`` names it.
        OptionError
            There is no such space, or a count and a limit are given.
        TriangleCountError
            There is no such level.

        Examples
        --------
        >>> from gamutcore import Gamut
        >>> colours = [(20, 0, 0), (90, 0, 0), (50, 60, 0), (50, -40, 50), (50, -40, -50)]
        >>> Gamut(colours).contains((50, 0, 300), space="LCHab").item()
        True
        """
        rows, _ = self._asked(colours, space)
        level = self._level(triangles, max_error)
        limit = self._limit(tolerance, level)
        return rows.in_shape(queries.contains(rows.points, level.index, limit))

    def _limit(self, tolerance: float | None, level: IndexedLevel) -> float:
        if tolerance is None:
            return self.tolerance(triangles=level.triangles)
        return _distance("tolerance", tolerance)

    def convert(self, colours: Colours, space: str) -> FloatArray:
        """Return colours of another space in the space of the gamut.

        Parameters
        ----------
        colours : (..., 3) array_like
        space : str
            Space of the colours.

        Returns
        -------
        (..., 3) float64

        Raises
        ------
        InvalidPointsError, OptionError
            As for `contains`.

        Examples
        --------
        >>> from gamutcore import Gamut
        >>> colours = [(20, 0, 0), (90, 0, 0), (50, 60, 0), (50, -40, 50), (50, -40, -50)]
        >>> Gamut(colours).convert((50, 20, 90), "LCHab").round(3).tolist()
        [50.0, 0.0, 20.0]
        """
        rows, _ = self._asked(colours, space)
        return rows.in_shape(rows.points)

    def distance(
        self,
        colours: Colours,
        *,
        space: str | None = None,
        triangles: int | None = None,
        max_error: float | None = None,
    ) -> FloatArray:
        """Return the distances of colours from the surface, negative inside.

        Parameters
        ----------
        colours : (..., 3) array_like
        space, triangles, max_error : optional
            As for `contains`.

        Returns
        -------
        (...) float64
            Euclidean, in units of the gamut's space.

        Raises
        ------
        InvalidPointsError, OptionError, TriangleCountError
            As for `contains`.

        Examples
        --------
        >>> from gamutcore import Gamut
        >>> cube = [(l, a, b) for l in (40, 60) for a in (-10, 10) for b in (-10, 10)]
        >>> Gamut(cube).distance([(50, 0, 0), (50, 0, 25)]).round(3).tolist()
        [-10.0, 15.0]
        """
        rows, _ = self._asked(colours, space)
        level = self._level(triangles, max_error)
        return rows.in_shape(queries.signed_distance(rows.points, level.index))

    def classify(
        self,
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
        colours : (..., 3) array_like
        edge_width : float, optional
            Largest distance from the surface of a colour at the edge, in units of the gamut's
            space. By default `tolerance` if that is given, else `default_edge_width`: 1 in CIELAB.
        tolerance : float, optional
            As for `contains`. Colours within it are at the edge as well.
        space, triangles, max_error : optional
            As for `contains`.

        Returns
        -------
        (...) str
            ``"inside"``, ``"edge"`` or ``"outside"``. `contains` is true for colours inside, false
            for colours outside, and decides by `tolerance` at the edge.

        Raises
        ------
        InvalidPointsError, OptionError, TriangleCountError
            As for `contains`.

        Examples
        --------
        >>> from gamutcore import Gamut
        >>> cube = [(l, a, b) for l in (40, 60) for a in (-10, 10) for b in (-10, 10)]
        >>> Gamut(cube).classify([(50, 0, 0), (50, 0, 11), (50, 0, 25)], edge_width=2).tolist()
        ['inside', 'edge', 'outside']
        """
        level = self._level(triangles, max_error)
        limit = self._limit(tolerance, level)
        if edge_width is None:
            edge_width = self.default_edge_width if tolerance is None else tolerance
        width = max(limit, _distance("edge_width", edge_width))
        distance = self.distance(colours, space=space, triangles=level.triangles)
        far = np.where(distance < 0.0, "inside", "outside")
        return np.where(np.abs(distance) <= width, "edge", far)

    def nearest(
        self,
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
        colours : (..., 3) array_like
        metric : str, optional
            ``"CIE 1976"``: the smallest Euclidean distance. ``"CIE 2000"``: the smallest colour
            difference CIE 2000, for gamuts in CIELAB.
        space, triangles, max_error : optional
            As for `contains`. The points are in the same space.

        Returns
        -------
        NearestColours
            With `points`, `distance`, `delta_e` and `device`.

        Raises
        ------
        InvalidPointsError, OptionError, TriangleCountError
            As for `contains`.

        Examples
        --------
        >>> from gamutcore import Gamut
        >>> cube = [(l, a, b) for l in (40, 60) for a in (-10, 10) for b in (-10, 10)]
        >>> near = Gamut(cube).nearest((50, 0, 25))
        >>> near.points.round(3).tolist(), round(near.distance.item(), 3)
        ([50.0, 0.0, 10.0], 15.0)
        """
        name = check_option("metric", metric, METRIC)
        rows, conversion = self._asked(colours, space)
        level = self._level(triangles, max_error)
        if name == "CIE 1976":
            found = queries.nearest(rows.points, level.index)
        elif self.colour_space.is_icc_cielab:
            found = queries.nearest_ciede2000(rows.points, level.index)
        else:
            raise OptionError.not_applicable(
                "metric",
                metric,
                f"the gamut is in {self.colour_space.name}, and CIE 2000 is defined in CIELAB",
                "Build the gamut in CIELAB, or give the metric CIE 1976.",
            )
        device, channels = self._device(level, found.faces, found.weights)
        difference = delta_e_2000(self._lab(rows.points), self._lab(found.points))
        distance = np.linalg.norm(found.points - rows.points, axis=1)
        return NearestColours(
            points=rows.in_shape(conversion.from_gamut(found.points)),
            device=None if device is None else rows.in_shape(device),
            channels=channels,
            triangles=level.triangles,
            max_error=level.max_error,
            gamut=self.conditions,
            warnings=colour_warnings(self.conditions, conversion.name),
            distance=rows.in_shape(distance),
            delta_e=rows.in_shape(difference),
        )

    def crossings(
        self,
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
        space, triangles, max_error : optional
            As for `contains`. The points are in the same space.

        Returns
        -------
        ColourCrossings
            Flat, with `offsets` for the rows, `t`, `entering`, `points` and `device`.

        Raises
        ------
        InvalidPointsError, OptionError, TriangleCountError
            As for `contains`; also for a ray or line with two equal points.

        Examples
        --------
        >>> from gamutcore import Gamut
        >>> cube = [(l, a, b) for l in (40, 60) for a in (-10, 10) for b in (-10, 10)]
        >>> found = Gamut(cube).crossings((50, 0, 0), (50, 0, 40))
        >>> found.t.round(3).tolist(), found.entering.tolist()
        ([0.25], [False])
        """
        (first, conversion), (second, _) = (
            self._asked(starts, space, "starts"),
            self._asked(ends, space, "ends"),
        )
        lines = np.broadcast_arrays(first.in_shape(first.points), second.in_shape(second.points))
        level = self._level(triangles, max_error)
        # Copies, because kernels take arrays that may be written to.
        one, two = (np.array(each, order="C").reshape(-1, 3) for each in lines)
        found = queries.crossings(one, two, level.index, kind)
        device, channels = self._device(level, found.faces, found.weights)
        return ColourCrossings(
            points=conversion.from_gamut(found.points),
            device=device,
            channels=channels,
            triangles=level.triangles,
            max_error=level.max_error,
            gamut=self.conditions,
            offsets=found.offsets,
            t=found.t,
            entering=found.entering,
        )
