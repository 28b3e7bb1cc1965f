"""What all questions to a gamut share: the level, the conversion of colours, the device values."""

from __future__ import annotations

import os
import threading
from abc import ABC, abstractmethod
from collections import OrderedDict
from dataclasses import dataclass, replace
from functools import cached_property
from math import inf
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from gamutcore.answers.conditions import conditions_of
from gamutcore.colour_rows import colour_rows
from gamutcore.colours import xyz_to_lab
from gamutcore.colours.spaces import ColourConversion
from gamutcore.errors import OptionError
from gamutcore.levels import BoundedLevel, LevelRequest, LevelSearch
from gamutcore.queries import LevelIndex, build_index
from gamutcore.results import Conditions
from gamutcore.tables import frame_colours

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray, IndexArray
    from gamutcore.colour_rows import ColourRows, Colours
    from gamutcore.colours.spaces import ColourSpace
    from gamutcore.geometry import DeviceValues
    from gamutcore.history import History

__all__ = [
    "DEFAULT_EDGE_WIDTH",
    "DEFAULT_ERROR",
    "INDEX_BYTES",
    "Answering",
    "IndexedLevel",
    "IndexedLevels",
]

INDEX_BYTES = 128 * 1024 * 1024
"""Default size of a gamut's cache of indexed levels in bytes. The full boundary of 133,000
triangles needs about 30 MB, and 1,000 triangles need 0.2 MB."""

DEFAULT_ERROR = 0.1
"""Error of the level that answers, where the white of the space has a lightness of 100."""

DEFAULT_EDGE_WIDTH = 1.0
"""Distance from the surface of a colour at the edge, where the white has a lightness of 100."""

GRID_CORNER = 3.0**0.5 / 2.0
"""Largest distance of a point from the nearest grid point ÷ grid step."""


@dataclass(frozen=True)
class IndexedLevel:
    """A level that is ready for queries.

    `device` is None if the gamut was built from bare colours. `max_error` is an upper bound of the
    distance from the full boundary, in both directions, in units of the space; None if not known.
    """

    index: LevelIndex
    device: DeviceValues | None
    max_error: float | None = None

    @property
    def triangles(self) -> int:
        """Triangle count of the level."""
        return len(self.index.faces)

    @property
    def nbytes(self) -> int:
        """Memory in bytes."""
        return self.index.nbytes + (0 if self.device is None else self.device.values.nbytes)


class IndexedLevels:
    """The levels of a history that queries have used; threads may share it.

    `capacity` is the size of the cache in bytes, of which `nbytes` are used. A larger level is
    indexed again for each query.
    """

    def __init__(self, history: History, capacity: int = INDEX_BYTES) -> None:
        self.capacity = capacity
        self.nbytes = 0
        self._history = history
        self._kept: OrderedDict[int, IndexedLevel] = OrderedDict()
        self._lock = threading.Lock()

    def has(self, triangles: int) -> bool:
        """Whether a level of an existing count is in the cache."""
        return triangles in self._kept

    def level(self, triangles: int) -> IndexedLevel:
        """Return the level of an existing count, without the bound of its error."""
        with self._lock:
            level = self._kept.get(triangles)
            if level is not None:
                self._kept.move_to_end(triangles)
                return level
        mesh = self._history.level(triangles)
        index = build_index(mesh.vertices, mesh.faces, self._history.centre)
        level = IndexedLevel(index, self._history.device_values(triangles))
        with self._lock:
            if level.nbytes <= self.capacity and triangles not in self._kept:
                self._kept[triangles] = level
                self.nbytes += level.nbytes
                while self.nbytes > self.capacity:
                    _, evicted = self._kept.popitem(last=False)
                    self.nbytes -= evicted.nbytes
        return level


class Answering(ABC):
    """A gamut that answers questions; a base class of `gamutcore.Gamut`."""

    description: dict[str, Any]
    history: History
    search: LevelSearch
    levels: IndexedLevels

    @property
    @abstractmethod
    def colour_space(self) -> ColourSpace:
        """The colour space of the coordinates."""

    @cached_property
    def conditions(self) -> Conditions:
        """What the colours are relative to: intent, ink limits, white and space."""
        return conditions_of(self.description)

    @abstractmethod
    def _same_space(self, other: Self | str | os.PathLike[str]) -> Self:
        """Return another gamut, or the one of a name or file, in the space of this one."""

    def _asked(
        self, colours: Colours, space: str | None, name: str = "colours"
    ) -> tuple[ColourRows, ColourConversion]:
        """Return colours in the space of the gamut, and the way back."""
        own = self.colour_space
        frame = frame_colours(colours, space, own.name, limits=own.scale in {None, 1.0})
        if frame is not None:
            colours, space = frame
        rows, conversion = colour_rows(colours, name), self._conversion(space)
        return rows._replace(points=conversion.to_gamut(rows.points)), conversion

    def _conversion(self, space: str | None) -> ColourConversion:
        return ColourConversion(space, self.colour_space, as_measured=self._as_measured)

    @cached_property
    def _as_measured(self) -> bool:
        """Whether the coordinates are a device's own colours, which were not adapted."""
        stated = self.description["provenance"].get("colour_space", {}).get("adaptation", "")
        return str(stated).startswith("none: ") and not self.colour_space.is_icc_cielab

    def _found(self, triangles: int | None, max_error: float | None) -> BoundedLevel:
        """Return the count and the bounds of the level that answers."""
        request = LevelRequest(triangles, max_error).or_default(max_error=self.default_error)
        return self.search.find(self.history, request)

    def _level(self, triangles: int | None, max_error: float | None) -> IndexedLevel:
        """Return the level that answers."""
        count, bounds = self._found(triangles, max_error)
        known = None if bounds.distance == inf else bounds.distance
        return replace(self.levels.level(count), max_error=known)

    def _level_with_hue(self, triangles: int | None, max_error: float | None) -> IndexedLevel:
        """Return the level that answers a question about hue."""
        if self.colour_space.definition.lightness != 0:
            raise OptionError.not_applicable(
                "space",
                self.colour_space.name,
                "the space has no hue",
                "Build the gamut in a space of lightness and hue, such as CIELAB.",
            )
        return self._level(triangles, max_error)

    @cached_property
    def default_error(self) -> float:
        """Error limit of the level that answers unless another one is asked for."""
        return DEFAULT_ERROR / 100.0 * self.colour_space.white_lightness

    @cached_property
    def default_edge_width(self) -> float:
        """Largest distance from the surface of a colour at the edge, unless another is given."""
        return DEFAULT_EDGE_WIDTH / 100.0 * self.colour_space.white_lightness

    def tolerance(self, *, triangles: int | None = None, max_error: float | None = None) -> float:
        """Return the distance up to which a colour outside of a level counts as in gamut.

        Parameters
        ----------
        triangles, max_error : optional
            The level, as for `contains`.

        Returns
        -------
        float
            In units of the gamut's space: the error bound of the level, the rounding of
            coordinates to the grid, and the largest distance by which the full boundary misses the
            device's own colours, ``description["boundary_error"]``. A colour that the device can
            make is not farther outside.

        Raises
        ------
        OptionError, TriangleCountError
            As for `contains`.

        Examples
        --------
        >>> from gamutcore import Gamut
        >>> colours = [(20, 0, 0), (90, 0, 0), (50, 60, 0), (50, -40, 50), (50, -40, -50)]
        >>> 0 < Gamut(colours).tolerance() < 0.1
        True
        """
        count, (bound, _) = self._found(triangles, max_error)
        if bound == inf:
            bound = self.search.error_bound(self.history, count)
        missed: float = self.description.get("boundary_error", 0.0)
        return bound + missed + GRID_CORNER * self.history.step

    def _lab(self, points: FloatArray) -> FloatArray:
        """Return L*, a*, b* relative to D50 of points in the space of the gamut."""
        if self.colour_space.is_icc_cielab:
            return points
        return xyz_to_lab(self.colour_space.tristimulus(points, as_measured=self._as_measured))

    def _check_space(self, other: Answering) -> None:
        # coordinates of absolute spaces are comparable whatever the luminances of the whites
        if replace(self.colour_space, luminance=None) != replace(
            other.colour_space, luminance=None
        ):
            one, two = self.colour_space.name, other.colour_space.name
            differ = f"{one} and {two}" if one != two else f"{one} with different parameters"
            raise OptionError(
                f"The gamuts are in {differ}.",
                where={"field": "space"},
                remedy="Build both with the same space and the same parameters of it.",
            )

    @staticmethod
    def _device(
        level: IndexedLevel, faces: IndexArray, weights: FloatArray
    ) -> tuple[FloatArray | None, tuple[str, ...]]:
        """Return the device values of places in faces, and the channels. Face −1 gives NaN."""
        if level.device is None:
            return None, ()
        corners = level.device.values[level.index.faces[faces]].astype(np.float64)
        values: FloatArray = np.einsum("ni,nik->nk", weights, corners)
        values[faces < 0] = np.nan
        return np.clip(values, 0.0, 1.0), level.device.channels
