"""What all questions share: the level that answers, the conversion of colours, device values."""

from __future__ import annotations

import threading
from collections import OrderedDict
from dataclasses import dataclass, replace
from functools import lru_cache
from math import inf
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias, TypeVar, cast

import numpy as np

from gamutcore.colour_rows import colour_rows
from gamutcore.colours import SPACE_PARAMETERS, xyz_to_lab
from gamutcore.colours.spaces import ColourConversion
from gamutcore.content import gamut_source, is_saved_gamut
from gamutcore.errors import OptionError
from gamutcore.levels import LevelRequest
from gamutcore.options import Options
from gamutcore.search import LevelIndex, build_index
from gamutcore.tables import frame_colours

if TYPE_CHECKING:
    import os

    from gamutcore.arrays import FloatArray, IndexArray
    from gamutcore.colour_rows import ColourRows, Colours
    from gamutcore.colours import DeviceModel
    from gamutcore.colours.spaces import ColourSpace
    from gamutcore.geometry import DeviceValues
    from gamutcore.history import History
    from gamutcore.levels import BoundedLevel, LevelSearch
    from gamutcore.recipes import InverseModel
    from gamutcore.references import Reference
    from gamutcore.results import Conditions

__all__ = [
    "DEFAULT_EDGE_WIDTH",
    "DEFAULT_ERROR",
    "INDEX_BYTES",
    "GamutLike",
    "IndexedLevel",
    "IndexedLevels",
    "OtherGamut",
    "answering_level",
    "check_space",
    "colours_in",
    "device_values",
    "is_as_measured",
    "lab_of",
    "level_with_hue",
    "other_gamut",
    "surface_facts",
    "tolerance_of",
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


class GamutLike(Protocol):
    """What a question needs of a gamut; `gamutcore.Gamut` has all of it."""

    description: dict[str, Any]
    history: History
    search: LevelSearch
    levels: IndexedLevels
    name: str

    @property
    def colour_space(self) -> ColourSpace:
        """The colour space of the coordinates."""

    @property
    def conditions(self) -> Conditions:
        """What the colours are relative to."""

    @property
    def default_error(self) -> float:
        """Error limit of the level that answers unless another one is asked for."""

    @property
    def default_edge_width(self) -> float:
        """Largest distance from the surface of a colour at the edge, unless another is given."""

    @property
    def device_model(self) -> DeviceModel:
        """Device values to colours."""

    @property
    def inverse_model(self) -> InverseModel:
        """Colours to device values."""

    @property
    def profile(self) -> bytes | None:
        """The ICC profile that the gamut was built from, if it is known."""


G = TypeVar("G", bound=GamutLike)

OtherGamut: TypeAlias = "GamutLike | str | os.PathLike[str]"
"""Another gamut, the name of a reference, or a file."""


class SurfacePlaces(Protocol):
    """Places on the surface: the face of each, and its barycentric coordinates there."""

    @property
    def faces(self) -> IndexArray:
        """One face for each place; −1 for a place inside."""

    @property
    def weights(self) -> FloatArray:
        """Three weights for each place."""


def _find(gamut: GamutLike, triangles: int | None, max_error: float | None) -> BoundedLevel:
    request = LevelRequest(triangles, max_error).or_default(max_error=gamut.default_error)
    return gamut.search.find(gamut.history, request)


def answering_level(
    gamut: GamutLike, triangles: int | None, max_error: float | None
) -> IndexedLevel:
    """Return the level that answers."""
    count, bounds = _find(gamut, triangles, max_error)
    known = None if bounds.distance == inf else bounds.distance
    return replace(gamut.levels.level(count), max_error=known)


def level_with_hue(
    gamut: GamutLike, triangles: int | None, max_error: float | None
) -> IndexedLevel:
    """Return the level that answers a question about hue."""
    if gamut.colour_space.definition.lightness != 0:
        raise OptionError.not_applicable(
            "space",
            gamut.colour_space.name,
            "the space has no hue",
            "Build the gamut in a space of lightness and hue, such as CIELAB.",
        )
    return answering_level(gamut, triangles, max_error)


def tolerance_of(
    gamut: GamutLike, triangles: int | None = None, max_error: float | None = None
) -> float:
    """Return the distance up to which a colour outside of a level counts as in gamut."""
    count, (bound, _) = _find(gamut, triangles, max_error)
    if bound == inf:
        bound = gamut.search.error_bound(gamut.history, count)
    missed: float = gamut.description.get("boundary_error", 0.0)
    return bound + missed + GRID_CORNER * gamut.history.step


def colours_in(
    gamut: GamutLike, colours: Colours, space: str | None, name: str = "colours"
) -> tuple[ColourRows, ColourConversion]:
    """Return colours in the space of the gamut, and the way back."""
    gamut_space = gamut.colour_space
    frame = frame_colours(colours, space, gamut_space.name)
    if frame is not None:
        colours, space = frame
    conversion = ColourConversion(space, gamut_space, as_measured=is_as_measured(gamut))
    rows = colour_rows(colours, name)
    return rows._replace(points=conversion.to_gamut(rows.points)), conversion


def is_as_measured(gamut: GamutLike) -> bool:
    """Whether the coordinates are a device's own colours, which were not adapted."""
    stated = gamut.description["provenance"].get("colour_space", {}).get("adaptation", "")
    return str(stated).startswith("none: ") and not gamut.colour_space.is_icc_cielab


def lab_of(gamut: GamutLike, points: FloatArray) -> FloatArray:
    """Return L*, a*, b* relative to D50 of points in the space of the gamut."""
    if gamut.colour_space.is_icc_cielab:
        return points
    return xyz_to_lab(gamut.colour_space.tristimulus(points, as_measured=is_as_measured(gamut)))


class InSpace(Protocol):
    """Something with coordinates in a colour space."""

    @property
    def colour_space(self) -> ColourSpace:
        """The colour space of the coordinates."""


def check_space(gamut: InSpace, other: InSpace) -> None:
    """Refuse a gamut in another space."""
    # coordinates of absolute spaces are comparable whatever the luminances of the whites
    one, two = (replace(side.colour_space, luminance=None) for side in (gamut, other))
    if one != two:
        differ = f"{one.name} with different parameters"
        if one.name != two.name:
            differ = f"{one.name} and {two.name}"
        raise OptionError(
            f"The gamuts are in {differ}.",
            where={"field": "space"},
            remedy="Build both with the same space and the same parameters of it.",
        )


def other_gamut(gamut: G, other: G | str | os.PathLike[str]) -> G:
    """Return another gamut, or that of a name or a file, in the space of a gamut.

    `OptionError` is raised if it is in another space.
    """
    if not isinstance(other, type(gamut)):
        other = _opened(gamut, cast("str | os.PathLike[str]", other))
    check_space(gamut, other)
    return other


def _opened(gamut: G, name: str | os.PathLike[str]) -> G:
    """Return the gamut of a name or a file; unless it is saved, built in the space of a gamut."""
    source, kind = gamut_source(name), cast("Any", type(gamut))
    if isinstance(source, bytes) and is_saved_gamut(source):
        return cast("G", kind.load(name))
    options = gamut.description["options"]
    names = {"space", *SPACE_PARAMETERS} & options.keys()
    if not isinstance(source, bytes) and source.peak is not None:
        names -= {"luminance"}  # its luminances are known
    chosen = Options.from_mapping({name: options[name] for name in names})
    if isinstance(source, bytes):
        return cast("G", kind(name, chosen))
    return cast("G", _reference(kind, source, chosen))


@lru_cache(maxsize=8)  # many gamuts are compared with a few references, of 2 MB each
def _reference(kind: Any, reference: Reference, options: Options) -> Any:  # noqa: ANN401
    return kind(reference.data, options)


def device_values(
    level: IndexedLevel, faces: IndexArray, weights: FloatArray
) -> tuple[FloatArray | None, tuple[str, ...]]:
    """Return the device values of places in faces, and the channels. Face −1 gives NaN."""
    if level.device is None:
        return None, ()
    corners = level.device.values[level.index.faces[faces]].astype(np.float64)
    values: FloatArray = np.einsum("ni,nik->nk", weights, corners)
    values[faces < 0] = np.nan
    return np.clip(values, 0.0, 1.0), level.device.channels


def surface_facts(
    gamut: GamutLike,
    level: IndexedLevel,
    places: SurfacePlaces,
    rows: ColourRows | None = None,
) -> dict[str, Any]:
    """Return what a `SurfaceAnswer` states besides its points; device values as the rows."""
    device, channels = device_values(level, places.faces, places.weights)
    return {
        "device": device if device is None or rows is None else rows.in_shape(device),
        "channels": channels,
        "triangles": level.triangles,
        "max_error": level.max_error,
        "gamut": gamut.conditions,
    }
