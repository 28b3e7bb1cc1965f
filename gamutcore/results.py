"""The results of questions to a gamut, and how they are shown: in one line, and as a table.

`gamutcore` and `gamutclient` have this file in common, since neither may import the other: in
`gamutclient` it is a link, and a file in its wheel. It needs NumPy and the shared `number_text`.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import Field, dataclass, field, fields
from html import escape
from pathlib import Path
from typing import Any, ClassVar, Generic, Self, TypeAlias, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from .number_text import number_text

__all__ = [
    "AS_GIVEN",
    "DIAGRAMS",
    "INTERPOLATED",
    "PAGE_STATE",
    "AreaOverlap",
    "ChromaTable",
    "ChromaticityComparison",
    "ChromaticityGamut",
    "ColourCrossings",
    "ColourCusps",
    "ColourLoss",
    "ColourMatch",
    "ColourRecipes",
    "ColourSection",
    "Comparison",
    "ComparisonUncertainty",
    "Conditions",
    "CoverageMatrix",
    "GamutComparison",
    "GamutGroup",
    "GamutRings",
    "HueSectors",
    "Intersection",
    "Interval",
    "MappedColours",
    "NearestColours",
    "Overlap",
    "SurfaceAnswer",
    "TabularRepr",
    "ViewerPage",
    "VolumeUncertainty",
]

FloatArray: TypeAlias = NDArray[np.float64]
BooleanArray: TypeAlias = NDArray[np.bool_]
Offsets: TypeAlias = NDArray[np.integer[Any]]

Value = TypeVar("Value", float, FloatArray)

MOST_ROWS = 12
"""Rows of a table in a notebook."""

LEFT = "text-align:left"

SMALL = 3
"""Arrays of so many numbers are shown whole: a colour."""

LONGEST = 60
"""Longest text of a field, in characters."""

VIEWER_HEIGHT = 520
"""Height of the viewer in a notebook, in pixels of CSS: a cell on a laptop's screen."""

PAGE_STATE = b'<script type="application/json" id="page-state">'
"""What stands before the state in a page with the viewer."""

AS_GIVEN = "as given"
"""Intent of colours whose white is not known: bare colours and meshes."""

DIAGRAMS = ("xy", "uv")
"""CIE 1931 x, y and CIE 1976 u′, v′."""

INTERPOLATED = "interpolated"
"""How device values are found: linearly between the vertices of the face."""


class TabularRepr:
    """A base of data classes with ``repr=False``: arrays are shown by their shape or range."""

    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]

    def __repr__(self) -> str:
        facts = ", ".join(f"{name} {text}" for name, text in self._facts())
        return f"<{type(self).__name__}: {facts}>"

    def _repr_html_(self) -> str:
        """Return the fields as a table, for notebooks; colours have swatches.

        Arrays with a row for each colour are a second table, unless there are many.
        """
        facts = dict(self._facts())
        columns = self._columns()
        for name in columns:
            facts.pop(name, None)
        swatches = self._swatches()
        head = facts_table(facts, type(self).__name__, "" if columns else "".join(swatches))
        if not columns:
            return head
        names = [*([""] if swatches else []), *columns]
        cells = [[_cell(row) for row in column] for column in columns.values()]
        rows = [list(map(escape, row)) for row in zip(*cells, strict=True)]
        if swatches:
            rows = [[swatch, *row] for swatch, row in zip(swatches, rows, strict=True)]
        titles = "".join(f"<th style='{LEFT}'>{escape(name)}</th>" for name in names)
        body = "".join(f"<tr>{''.join(f'<td>{cell}</td>' for cell in row)}</tr>" for row in rows)
        return f"{head}<table><thead><tr>{titles}</tr></thead><tbody>{body}</tbody></table>"

    def _columns(self) -> dict[str, np.ndarray[Any, Any]]:
        """Return the arrays with a row for each colour, if these are few enough for a table."""
        points = getattr(self, "points", None)
        if points is None or points.ndim != 2 or not 0 < len(points) <= MOST_ROWS:
            return {}
        arrays = {part.name: getattr(self, part.name) for part in fields(self) if part.repr}
        return {
            name: array
            for name, array in arrays.items()
            if isinstance(array, np.ndarray) and len(array) == len(points) and name != "offsets"
        }

    def _swatches(self) -> list[str]:
        """Return a swatch for each of `points`, if they are in a space with a known appearance.

        Colours of CSS are relative to D50.
        """
        points, conditions = getattr(self, "points", None), getattr(self, "gamut", None)
        if points is None or points.size > 3 * MOST_ROWS:
            return []
        space = getattr(self, "space", conditions.space if conditions else "")
        plain = conditions is not None and conditions.white == "D50"
        colour = _SWATCHES.get(space) if plain or space == "sRGB" else None
        return [swatch(colour.format(*row)) for row in points.reshape(-1, 3)] if colour else []

    def _facts(self) -> Iterator[tuple[str, str]]:
        """Yield names and texts of the fields that have a short text."""
        for part in fields(self):
            text = _text(getattr(self, part.name)) if part.repr else ""
            if text:
                yield part.name, text


def facts_table(facts: Mapping[str, str], caption: str = "", mark: str = "") -> str:
    """Return names and texts as a table for notebooks; `mark` is HTML beside the caption."""
    rows = "".join(
        f"<tr><th style='{LEFT}'>{escape(name)}</th><td style='{LEFT}'>{escape(text)}</td></tr>"
        for name, text in list(facts.items())[:MOST_ROWS]
    )
    title = f"<caption style='{LEFT}'>{escape(caption)} {mark}</caption>" if caption else ""
    return f"<table>{title}{rows}</table>"


_SWATCHES = {
    "CIELAB": "lab({:.4g}% {:.4g} {:.4g})",
    "LCHab": "lch({:.4g}% {:.4g} {:.4g})",
    "sRGB": "color(srgb {:.4g} {:.4g} {:.4g})",
}
"""Colours of CSS Color 4, whose lab() is relative to D50 as well; the browser converts them."""


def swatch(colour: str) -> str:
    """Return a small square in a colour of CSS."""
    return (
        "<span style='display:inline-block;width:1em;height:1em;outline:1px solid currentColor;"
        f"background:{colour}'></span>"
    )


def _text(value: object) -> str:
    """Return a value in a few words; empty for what has no short text, such as a mapping."""
    if isinstance(value, np.ndarray):
        return _array_text(value)
    if isinstance(value, float | np.floating):
        return number_text(value)
    if isinstance(value, tuple):
        text = " ".join("-" if part is None else _text(part) for part in value)
        return text if len(text) <= LONGEST else f"{text[: LONGEST - 1]}…"
    return " ".join(str(value).split())[:LONGEST] if isinstance(value, str | int) else ""


def _cell(values: np.ndarray[Any, Any]) -> str:
    """Return the values of one colour, all of them."""
    parts = np.ravel(values)
    if parts.dtype == np.bool_:
        return " ".join("yes" if part else "no" for part in parts)
    return " ".join(number_text(part, 4) for part in parts)


def _array_text(values: np.ndarray[Any, Any]) -> str:
    if values.dtype == np.bool_:
        return f"{np.count_nonzero(values)} of {values.size}"
    if values.size <= SMALL and values.ndim <= 1:
        return " ".join(number_text(value, 4) for value in values.ravel())
    finite = values[np.isfinite(values)]
    if values.ndim == 1 and finite.size:
        return f"{number_text(finite.min(), 4)} to {number_text(finite.max(), 4)} ({values.size})"
    return " × ".join(map(str, values.shape))


@dataclass(frozen=True, repr=False)
class Conditions(TabularRepr):
    """What the colours of a gamut are relative to.

    Attributes
    ----------
    intent : str
        ``"relative"``, ``"absolute"``, ``"perceptual"`` or ``"saturation"``; ``"as given"`` for
        colours whose white is not known.
    ink_limit, black_limit : float or None
        In per cent; None without a limit.
    white : str
        Reference white of the space: a name such as ``"D50"``, or ``"as given"``.
    space : str
    white_xyz : tuple of float
        X, Y, Z of the white; empty if not stated.
    viewing_conditions : mapping
        Of spaces that have any: luminances in cd/m², background, surround.
    medium_white : tuple of float or None
        L*, a*, b* of the medium's white, as measured; None if it is not known.
    illuminant, observer, measurement_condition : str
        Of measurements; empty if not stated.
    is_print, inks : bool
        False if the gamut does not state it.
    build_warnings : tuple of str
        Warnings of the gamut's build. Answers have them among their warnings.
    size_warnings : tuple of str
        Warnings about its volume, which comparisons have among their warnings.
    """

    intent: str
    ink_limit: float | None
    black_limit: float | None
    white: str
    space: str
    white_xyz: tuple[float, ...] = ()
    viewing_conditions: Mapping[str, float | str] = field(default_factory=dict, hash=False)
    medium_white: tuple[float, ...] | None = None
    illuminant: str = ""
    observer: str = ""
    measurement_condition: str = ""
    is_print: bool = field(default=False, repr=False)
    inks: bool = field(default=False, repr=False)
    build_warnings: tuple[str, ...] = field(default=(), repr=False, compare=False)
    size_warnings: tuple[str, ...] = field(default=(), repr=False, compare=False)

    @classmethod
    def from_dict(cls, document: Mapping[str, Any]) -> Conditions:
        """Return the conditions of a JSON document; the inverse of `to_dict`."""
        white, medium = document["white"], document.get("medium_white")
        return cls(
            intent=document["intent"],
            ink_limit=document["ink_limit"],
            black_limit=document["black_limit"],
            white=white["name"],
            space=document["space"],
            white_xyz=tuple(white.get("xyz", ())),
            viewing_conditions=document.get("viewing_conditions", {}),
            medium_white=None if medium is None else tuple(medium),
        )

    @classmethod
    def from_header(cls, text: str) -> Conditions:
        """Return the conditions in a header field such as ``intent=relative; white=D50``."""
        stated = dict(part.strip().split("=", 1) for part in text.split(";"))
        inks, black = stated.get("ink-limit"), stated.get("black-limit")
        return cls(
            intent=stated["intent"].replace("-", " "),
            ink_limit=None if inks is None else float(inks),
            black_limit=None if black is None else float(black),
            white=stated["white"].replace("as-given", AS_GIVEN),
            space=stated["space"],
        )

    def to_dict(self) -> dict[str, Any]:
        """Return the conditions as a JSON-able mapping."""
        mapping: dict[str, Any] = {
            "intent": self.intent,
            "ink_limit": self.ink_limit,
            "black_limit": self.black_limit,
            "white": {"name": self.white, "xyz": list(self.white_xyz)},
            "medium_white": None if self.medium_white is None else list(self.medium_white),
            "space": self.space,
        }
        if self.viewing_conditions:
            mapping["viewing_conditions"] = dict(self.viewing_conditions)
        return mapping

    @property
    def header(self) -> str:
        """The conditions as the value of a header field."""
        parts = [f"intent={self.intent.replace(' ', '-')}"]
        for name, limit in (("ink-limit", self.ink_limit), ("black-limit", self.black_limit)):
            if limit is not None:
                parts.append(f"{name}={limit:g}")
        parts += [f"white={self.white.replace(' ', '-')}", f"space={self.space}"]
        parts += [
            f"{name.replace('_', '-')}={_short(value)}"
            for name, value in self.viewing_conditions.items()
        ]
        return "; ".join(parts)

    def __str__(self) -> str:
        intent = "colours as given" if self.intent == AS_GIVEN else f"{self.intent} intent"
        parts = [intent]
        if self.ink_limit is not None:
            parts.append(f"ink limit {self.ink_limit:g} %")
        elif self.inks:
            parts.append("no ink limit")
        if self.black_limit is not None:
            parts.append(f"black limit {self.black_limit:g} %")
        white = self.white
        if white == AS_GIVEN:
            white = f"X Y Z {' '.join(f'{value:g}' for value in self.white_xyz)}".strip()
        viewing = ", ".join(
            f"{name.replace('_', ' ')} {_short(value)}"
            for name, value in self.viewing_conditions.items()
        )
        parts += [f"white {white}", f"{self.space} ({viewing})" if viewing else self.space]
        return ", ".join(parts)


def _short(value: float | str) -> str:
    return value if isinstance(value, str) else f"{value:g}"


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class SurfaceAnswer(TabularRepr):
    """Colours on the surface of a level, and the device values there.

    Attributes
    ----------
    points : (..., 3) float64
        In the space of the colours that were given.
    space : str
        Its name, such as ``"CIELAB"``. Empty for a table that was sent to the service, which finds
        the space by the columns.
    device : (..., k) float64 or None
        Device values from 0 to 1, interpolated in the face; None if the gamut has colours only. NaN
        for points inside the gamut, where a device has more than one value.
    channels : tuple of str
        Names of the k channels.
    device_values : str
        How the device values were found: ``"interpolated"``.
    triangles : int
        Triangle count of the level.
    max_error : float or None
        Upper bound of the distance of the level from the full boundary; None if it is not known.
    gamut : Conditions or None
        What the colours of the gamut are relative to; None from services that do not state it.
    warnings : tuple of str
        Reasons why the answer may mislead.
    """

    points: FloatArray
    device: FloatArray | None
    channels: tuple[str, ...]
    triangles: int
    max_error: float | None
    gamut: Conditions | None = None
    warnings: tuple[str, ...] = ()
    device_values: str = INTERPOLATED
    space: str = ""


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class NearestColours(SurfaceAnswer):
    """The nearest points of the surface.

    Attributes
    ----------
    distance : (...) float64
        Distance by the metric that was asked for, not negative: Euclidean in the space of the gamut
        by ``"CIE 1976"``, and equal to `delta_e` by ``"CIE 2000"``.
    delta_e : (...) float64
        Colour difference CIE 2000 of the colours and their nearest points.
    """

    distance: FloatArray
    delta_e: FloatArray


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class MappedColours(SurfaceAnswer):
    """Colours that were mapped into the gamut.

    Attributes
    ----------
    moved : (...) bool
        Whether a colour was outside, or was compressed, and has moved by more than the tolerance
        of the level (`Gamut.tolerance`), or than `default_error` if that is smaller.
    delta_e : (...) float64
        Colour difference CIE 2000 of the colours and their images.
    """

    moved: BooleanArray
    delta_e: FloatArray


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class ColourRecipes(TabularRepr):
    """Device values of colours, by the device model.

    Attributes
    ----------
    device : (..., k) float64
        From 0 to 1.
    channels : tuple of str
        Names of the k channels.
    points : (..., 3) float64
        Colours of the device values by the model, in the space of the colours that were given.
    space : str
        Its name, such as ``"CIELAB"``. Empty for a table that was sent to the service, which finds
        the space by the columns.
    delta_e : (...) float64
        Colour difference CIE 2000 of these and the colours that were given.
    inside : (...) bool
        Whether the colours that were given are in gamut.
    black_least, black_most : (...) float64 or None
        Range of black with which the colour is possible. None without black ink.
    triangles : int
        Triangle count of the level that decides what is in gamut.
    max_error : float or None
        Upper bound of the distance of the level from the full boundary; None if it is not known.
    gamut : Conditions or None
        What the colours of the gamut are relative to.
    warnings : tuple of str
        Reasons why the answer may mislead.
    """

    device: FloatArray
    channels: tuple[str, ...]
    points: FloatArray
    delta_e: FloatArray
    inside: BooleanArray
    triangles: int
    max_error: float | None
    black_least: FloatArray | None = None
    black_most: FloatArray | None = None
    gamut: Conditions | None = None
    warnings: tuple[str, ...] = ()
    space: str = ""


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class ColourCrossings(SurfaceAnswer):
    """All crossings of lines with the surface, line by line, along each line.

    Attributes
    ----------
    offsets : (n + 1,) int64
        The crossings of line i are those from ``offsets[i]`` to ``offsets[i + 1]``.
    t : (m,) float64
        Place on the line: 0 at its start, 1 at its end.
    entering : (m,) bool
        Whether the line enters the gamut there.
    """

    offsets: Offsets
    t: FloatArray
    entering: BooleanArray


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class ColourCusps(SurfaceAnswer):
    """Cusps: the points of largest chroma at some hues. NaN where a hue has none.

    Attributes
    ----------
    hue : (n,) float64
        In degrees.
    lightness, chroma : (n,) float64
        In the space of the gamut.
    """

    hue: FloatArray
    lightness: FloatArray
    chroma: FloatArray


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class ColourSection(SurfaceAnswer):
    """Closed polygons of a section, one after the other. A section may be empty.

    Attributes
    ----------
    offsets : (k + 1,) int32
        Polygon i has the points from ``offsets[i]`` to ``offsets[i + 1]``.
    """

    offsets: Offsets

    @property
    def polygons(self) -> list[FloatArray]:
        """The corners of each polygon, (m, 3)."""
        return np.split(self.points, self.offsets[1:-1]) if len(self.offsets) > 1 else []


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class ChromaTable(TabularRepr):
    """Intervals of chroma inside the gamut, for every hue and lightness.

    Attributes
    ----------
    hue : (h,) float64
        In degrees.
    lightness : (l,) float64
    offsets : (h · l + 1,) int32
        Hue i and lightness j have the intervals from ``offsets[i * l + j]`` to the next offset.
    chroma : (m, 2) float64
        Both ends of each interval.
    device : (m, 2, k) float64 or None
        Device values at the ends; NaN on the neutral axis.
    channels : tuple of str
    triangles : int
    max_error : float or None
    gamut : Conditions
    """

    hue: FloatArray
    lightness: FloatArray
    offsets: Offsets
    chroma: FloatArray
    triangles: int
    max_error: float | None
    device: FloatArray | None = None
    channels: tuple[str, ...] = ()
    gamut: Conditions | None = None
    warnings: tuple[str, ...] = ()

    @property
    def largest(self) -> FloatArray:
        """Largest chroma for each hue and lightness, (h, l); NaN where no colour is in gamut."""
        return self._last(self.chroma[:, 1]).reshape(len(self.hue), len(self.lightness))

    @property
    def largest_device(self) -> FloatArray | None:
        """Device values of the largest chroma, (h, l, k); None without device values."""
        if self.device is None:
            return None
        shape = len(self.hue), len(self.lightness), len(self.channels)
        return self._last(self.device[:, 1]).reshape(shape)

    def _last(self, ends: FloatArray) -> FloatArray:
        """Return the last entry for each hue and lightness; NaN without one."""
        starts, stops = self.offsets[:-1], self.offsets[1:]
        entries = np.concatenate([ends, np.full((1, *ends.shape[1:]), np.nan)])
        return entries[np.where(stops > starts, stops - 1, -1)]


@dataclass(frozen=True, eq=False, repr=False)
class Overlap(TabularRepr, Generic[Value]):
    """Volumes of two gamuts and of their intersection, as numbers or as arrays.

    Attributes
    ----------
    volume_a, volume_b, intersection : float or (n,) float64
        In cubic units of the colour space.
    """

    volume_a: Value
    volume_b: Value
    intersection: Value

    @property
    def union(self) -> Value:
        """Volume inside at least one gamut."""
        return self.volume_a + self.volume_b - self.intersection

    @property
    def symmetric_difference(self) -> Value:
        """Volume inside exactly one gamut."""
        return self.volume_a + self.volume_b - 2.0 * self.intersection

    @property
    def a_covers_b(self) -> Value:
        """Coverage of B by A: intersection ÷ volume of B. NaN where B has no volume."""
        return _ratio(self.intersection, self.volume_b)

    @property
    def b_covers_a(self) -> Value:
        """Coverage of A by B: intersection ÷ volume of A. NaN where A has no volume."""
        return _ratio(self.intersection, self.volume_a)

    @property
    def jaccard(self) -> Value:
        """Jaccard index: intersection ÷ union. NaN where both have no volume."""
        return _ratio(self.intersection, self.union)


def _ratio(part: Value, whole: Value) -> Value:
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio = np.where(whole > 0.0, np.divide(part, whole), np.nan)
    return cast("Value", ratio if ratio.ndim else float(ratio))


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(Overlap[float]):
    """Comparison of two gamuts, A and B.

    Attributes
    ----------
    volume_a, volume_b, intersection : float
    hues : (n + 1,) float64
        Hues between the sectors, from 0 to 360 degrees.
    sectors : Overlap
        The same figures by sector of hue, as arrays of n.
    """

    hues: FloatArray
    sectors: Overlap[FloatArray]


@dataclass(frozen=True, eq=False, repr=False)
class AreaOverlap(TabularRepr):
    """Areas of two chromaticity gamuts and of their intersection, in one diagram.

    Attributes
    ----------
    area_a, area_b, intersection : float
    area_ratio : float
        Area of A ÷ area of B.
    a_covers_b, b_covers_a : float
        Intersection ÷ area of the covered gamut, from 0 to 1.
    """

    area_a: float
    area_b: float
    intersection: float
    area_ratio: float
    a_covers_b: float
    b_covers_a: float


@dataclass(frozen=True, eq=False, repr=False)
class ChromaticityComparison(TabularRepr):
    """Areas and coverage of two chromaticity gamuts.

    Attributes
    ----------
    xy, uv : AreaOverlap
        In the CIE 1931 xy and the CIE 1976 u′v′ diagram.
    basis_a, basis_b : str
        As `ChromaticityGamut.basis`.
    """

    xy: AreaOverlap
    uv: AreaOverlap
    basis_a: str
    basis_b: str

    def to_mapping(self) -> dict[str, Any]:
        """Return the comparison as JSON-able values."""
        return {
            "basis_a": self.basis_a,
            "basis_b": self.basis_b,
            **{diagram: dict(vars(getattr(self, diagram))) for diagram in DIAGRAMS},
        }

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> ChromaticityComparison:
        """Return the comparison of JSON values; the inverse of `to_mapping`."""
        areas = {diagram: AreaOverlap(**mapping[diagram]) for diagram in DIAGRAMS}
        return cls(**areas, basis_a=mapping["basis_a"], basis_b=mapping["basis_b"])


@dataclass(frozen=True, eq=False, repr=False)
class ChromaticityGamut(TabularRepr):
    """The chromaticities of a gamut: a convex polygon.

    Attributes
    ----------
    xy : (n, 2) float64
        Corners in the CIE 1931 diagram, counter-clockwise. Chromaticities are those of the device,
        before any adaptation.
    basis : str
        ``"primaries"``: the triangle of red, green and blue of a display or an RGB space.
        ``"colours"``: the convex hull of the gamut's own colours of at least 1 % of the luminance
        of white.

    Examples
    --------
    >>> half = ChromaticityGamut(np.array([(0.1, 0.1), (0.5, 0.1), (0.1, 0.3)]), "primaries")
    >>> whole = ChromaticityGamut(np.array([(0.1, 0.1), (0.5, 0.1), (0.1, 0.5)]), "primaries")
    >>> round(half.compare(whole).xy.area_ratio, 3)
    0.5
    """

    xy: FloatArray
    basis: str

    @property
    def uv(self) -> FloatArray:
        """Corners in the CIE 1976 diagram (CIE 15:2018, 8.2.2)."""
        x, y = self.xy.T
        scale = -2.0 * x + 12.0 * y + 3.0
        coordinates: FloatArray = np.stack([4.0 * x, 9.0 * y], axis=1) / scale[:, np.newaxis]
        return coordinates

    def compare(self, other: ChromaticityGamut) -> ChromaticityComparison:
        """Return areas and coverage of this gamut, A, and another one, B."""
        xy, uv = (_overlap(getattr(self, diagram), getattr(other, diagram)) for diagram in DIAGRAMS)
        return ChromaticityComparison(xy, uv, self.basis, other.basis)

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> ChromaticityGamut:
        """Return the chromaticity gamut in the description of a gamut."""
        return cls(np.array(mapping["corners"], np.float64), str(mapping["basis"]))


def _overlap(one: FloatArray, other: FloatArray) -> AreaOverlap:
    area_a, area_b = _area(one), _area(other)
    common = min(_area(_intersection(one, other)), area_a, area_b)
    return AreaOverlap(area_a, area_b, common, area_a / area_b, common / area_b, common / area_a)


def _area(polygon: FloatArray) -> float:
    x, y = polygon.T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2.0


def _intersection(one: FloatArray, other: FloatArray) -> FloatArray:
    """Clip a convex polygon by the edges of another one (Sutherland and Hodgman 1974)."""
    for start, end in zip(other, np.roll(other, -1, axis=0), strict=True):
        (ux, uy), away = end - start, one - start
        side = ux * away[:, 1] - uy * away[:, 0]
        corners: list[FloatArray] = []
        for here, at in enumerate(side):
            before = side[here - 1]
            if (before < 0.0) != (at < 0.0):
                share = before / (before - at)
                corners.append(one[here - 1] + share * (one[here] - one[here - 1]))
            if at >= 0.0:
                corners.append(one[here])
        one = np.array(corners).reshape(-1, 2)
    return one


@dataclass(frozen=True, repr=False)
class ColourLoss(TabularRepr):
    """What the surface of a gamut loses in another gamut.

    The loss of a colour is its colour difference CIE 2000 to the nearest colour of the other
    gamut, and 0 for a colour that the other gamut has within its tolerance. Nearest is by CIE 2000
    in CIELAB with D50, and by the distance of the space elsewhere.

    Attributes
    ----------
    mean, percentile_95 : float
        Over the area of the surface.
    share_outside : float
        Share of the area outside of the other gamut, from 0 to 1.
    """

    mean: float
    percentile_95: float
    share_outside: float


@dataclass(frozen=True, eq=False, repr=False)
class HueSectors(Overlap[FloatArray]):
    """Figures of a comparison by sector of hue: volumes, largest chroma, colours lost.

    Attributes
    ----------
    max_chroma_a, max_chroma_b : (n,) float64 or None
        Largest chroma of each gamut in the sector, NaN where it has no colour. None if the space
        has no hue.
    lost_mean_a, lost_mean_b, lost_percentile_95_a, lost_percentile_95_b : (n,) float64 or None
        As `ColourLoss`, of the part of the surface in the sector. NaN where no point of the surface
        was taken. None unless they were asked for.
    """

    max_chroma_a: FloatArray | None = None
    max_chroma_b: FloatArray | None = None
    lost_mean_a: FloatArray | None = None
    lost_mean_b: FloatArray | None = None
    lost_percentile_95_a: FloatArray | None = None
    lost_percentile_95_b: FloatArray | None = None


@dataclass(frozen=True, eq=False, repr=False)
class GamutComparison(Comparison):
    """Comparison of two gamuts, A and B: volumes, coverage both ways, by sector of hue.

    Attributes
    ----------
    sectors : HueSectors
    white_a, white_b, black_a, black_b : (3,) float64
        The lightest and the darkest colours.
    triangles : tuple of two int
        Triangle counts of the levels.
    max_error : tuple of two (float or None)
        Their error bounds.
    gamuts : tuple of two Conditions
        What the colours of A and B are relative to.
    warnings : tuple of str
        Reasons why the figures may mislead.
    chromaticity : ChromaticityComparison or None
        Area ratio and coverage in the CIE 1931 xy and the CIE 1976 u′v′ diagram. They do not depend
        on the levels. None if a gamut has no chromaticities.
    lost_a, lost_b : ColourLoss or None
        What A loses in B, and B in A. None unless they were asked for.
    summary : tuple of str
        The comparison in two to six sentences, in which the words A and B stand for the gamuts.
    """

    sectors: HueSectors
    white_a: FloatArray
    white_b: FloatArray
    black_a: FloatArray
    black_b: FloatArray
    triangles: tuple[int, int]
    max_error: tuple[float | None, float | None]
    gamuts: tuple[Conditions | None, Conditions | None] = field(repr=False)
    warnings: tuple[str, ...]
    chromaticity: ChromaticityComparison | None
    lost_a: ColourLoss | None = None
    lost_b: ColourLoss | None = None
    summary: tuple[str, ...] = field(default=(), repr=False)

    def summary_with(self, a: str, b: str) -> tuple[str, ...]:
        """Return the summary with the names of the gamuts."""
        return named_summary(self.summary, a, b)


@dataclass(frozen=True, repr=False)
class Intersection(TabularRepr):
    """The part that two gamuts have in common, as ``press & srgb`` gives it.

    Attributes
    ----------
    volume : float
        In cubic units of the space.
    of_first, of_second : float
        Its share of the volume of each gamut.
    jaccard : float
        Its share of the volume of the union.
    gamuts, warnings : tuple
        As of `GamutComparison`.
    """

    volume: float
    of_first: float
    of_second: float
    jaccard: float
    gamuts: tuple[Conditions | None, Conditions | None] = field(repr=False)
    warnings: tuple[str, ...]


@dataclass(frozen=True, eq=False, repr=False)
class GamutRings(TabularRepr):
    """Gamut rings (IDMS 1.1, 5.32).

    Attributes
    ----------
    lightness : (n,) float64
        Of the rings, in increasing order.
    hues : (s,) float64
        Middle of each sector of hue, in degrees.
    radius : (n, s) float64
    volume : float
        Volume up to the last lightness: the area within the outer ring.
    reference_radius : (n, s) float64 or None
        Rings of the reference.
    intersection_radius : (n, s) float64 or None
        Outer end of the intersection's part of the band inside each ring.
    gamut, reference_gamut : Conditions or None
        Of the gamut and of the reference.
    warnings : tuple of str
        Reasons why a comparison with the reference may mislead.
    """

    lightness: FloatArray
    hues: FloatArray
    radius: FloatArray
    volume: float
    reference_radius: FloatArray | None = None
    intersection_radius: FloatArray | None = None
    gamut: Conditions | None = None
    reference_gamut: Conditions | None = None
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True, repr=False)
class Interval(TabularRepr):
    """A figure with its interval of 95 %, and the parts of which the interval is made.

    Attributes
    ----------
    value, low, high : float
        The figure, corrected for its bias, and the ends of the interval.
    noise, patches, instrument : float
        Half-widths by the noise of readings, by the number and choice of patches, and by what all
        readings have in common. The half-width of the whole is the root of their sum of squares.
    bias : float
        The correction of the figure: few patches make a gamut smaller, and noise makes it larger.
    """

    value: float
    low: float
    high: float
    noise: float
    patches: float
    instrument: float
    bias: float

    @property
    def half_width(self) -> float:
        """Half of the interval, before it is cut to possible values."""
        return float(np.sqrt(self.noise**2 + self.patches**2 + self.instrument**2))

    def to_mapping(self) -> dict[str, float]:
        """Return the fields as a JSON-able mapping."""
        return dict(vars(self))


@dataclass(frozen=True, repr=False)
class VolumeUncertainty(TabularRepr):
    """How well the data lets the volume of a measured device be known.

    Attributes
    ----------
    volume : Interval
        In cubic units of the space.
    relative : Interval
        The same as shares of the volume.
    noise : float or None
        Noise of readings: root mean square ΔE*ab of one reading. None if it is not known; it then
        counts as none.
    noise_from : str
        Where it is from: ``"given"``, ``"a second reading"``, ``"repeated patches of the data"`` or
        ``"not known"``.
    patches : int
        Number of patches of the device model.
    patches_needed : int or None
        Number of patches for ± 1 %. None if the other parts alone exceed it.
    summary : tuple of str
        The interval in words.
    gamut : Conditions or None
    warnings : tuple of str
        Reasons why the interval may mislead.
    """

    volume: Interval
    relative: Interval
    noise: float | None
    noise_from: str
    patches: int
    patches_needed: int | None
    summary: tuple[str, ...] = field(repr=False)
    gamut: Conditions | None = field(default=None, repr=False)
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True, repr=False)
class ComparisonUncertainty(TabularRepr):
    """How well two sets of data let a comparison be known.

    Attributes
    ----------
    larger : Interval
        By how much A is larger than B: volume of A ÷ volume of B − 1.
    a_covers_b, b_covers_a : Interval
        Shares of volume, from 0 to 1.
    smallest_difference : float
        The smallest difference of the volumes that is noticed reliably: twice the half-width.
    noise : tuple of two (float or None)
        Noise of readings, as of `VolumeUncertainty`.
    patches : tuple of two (int or None)
        Numbers of patches; None for a gamut without measured patches, which counts as exact.
    patches_needed : int or None
        Number of patches of each for ± 1 %. None if the other parts alone exceed it.
    summary : tuple of str
        The intervals in words, in which the words A and B stand for the gamuts.
    gamuts : tuple of two Conditions
    warnings : tuple of str
        Reasons why the intervals may mislead.
    """

    larger: Interval
    a_covers_b: Interval
    b_covers_a: Interval
    smallest_difference: float
    noise: tuple[float | None, float | None]
    patches: tuple[int | None, int | None]
    patches_needed: int | None
    summary: tuple[str, ...] = field(repr=False)
    gamuts: tuple[Conditions | None, Conditions | None] = field(repr=False)
    warnings: tuple[str, ...] = ()

    def summary_with(self, a: str, b: str) -> tuple[str, ...]:
        """Return the summary with the names of the gamuts."""
        return named_summary(self.summary, a, b)


def named_summary(summary: tuple[str, ...], a: str, b: str) -> tuple[str, ...]:
    """Return sentences about A and B with the names of the gamuts."""
    names = {"A": a, "B": b}
    return tuple(re.sub(r"\b[AB]\b", lambda word: names[word[0]], text) for text in summary)


@dataclass(frozen=True, repr=False)
class ViewerPage(TabularRepr):
    """A page with the viewer, as `show` of a gamut gives it. Notebooks show it in a frame.

    The frame has the whole page in it, so it stays in a saved notebook and in what ``nbconvert``
    makes of it.

    Attributes
    ----------
    html : bytes
        The page in UTF-8. It needs no network.
    height : int
        Height of the frame in pixels of CSS.
    """

    html: bytes = field(repr=False)
    height: int = VIEWER_HEIGHT

    @classmethod
    def restoring(cls, html: bytes, state: str, height: int) -> Self:
        """Return a page that begins with a state: the text behind the number sign of an address."""
        if state:
            # The page's own script may have the same text. The state is behind everything else.
            before, _, after = html.rpartition(PAGE_STATE)
            _, end, after = after.partition(b"</script>")
            text = json.dumps({"address": state.removeprefix("#")}).replace("<", "\\u003c")
            html = b"".join((before, PAGE_STATE, text.encode(), end, after))
        return cls(html, height)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the page to a file for browsers, usually with the suffix ``.html``.

        Parameters
        ----------
        path : path

        Raises
        ------
        OSError
            The file cannot be written.
        """
        Path(path).write_bytes(self.html)

    def _repr_html_(self) -> str:
        """Return a frame with the page in it, for notebooks."""
        source = escape(self.html.decode())
        return (
            f'<iframe srcdoc="{source}" title="Gamut viewer" width="100%" height="{self.height}" '
            'style="border: 0"></iframe>'
        )


@dataclass(frozen=True, repr=False)
class GamutGroup(TabularRepr):
    """Gamuts that together print most of a list of colours.

    Attributes
    ----------
    gamuts : tuple of str
    printed : int
        Colours that at least one of them prints.
    exact : bool
        Whether all groups of the size were compared. Otherwise gamuts were added one by one, each
        time the one that adds most.
    """

    gamuts: tuple[str, ...]
    printed: int
    exact: bool


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class ColourMatch(TabularRepr):
    """Which of several gamuts print colours, and how near the others come.

    Attributes
    ----------
    colours, gamuts : tuple of str
        Names of the n colours and the g gamuts.
    points : (n, 3) float64
        The colours, in the space of the gamuts.
    space : str
    distance : (n, g) float64
        Euclidean distance from the surface, ΔE76 in CIELAB; negative inside.
    position : (n, g) str
        ``"inside"``, ``"edge"`` or ``"outside"``.
    delta_e : (n, g) float64 or None
        ΔE00 from the nearest colour in gamut: 0 for colours in gamut. None if it was not asked for.
    prints : (n, g) bool
        Whether the colour is within the tolerance.
    passing : float or None
        Largest `delta_e` of a colour that is printed. None: it is inside or at the edge.
    edge_width : float
        Largest distance from the surface of a colour at the edge.
    together : tuple of GamutGroup
        The pair and the triple of gamuts that print most.
    recipes : tuple of ColourRecipes or None
        One for each gamut, None for a gamut without device model; empty if all are None, and if
        they were not asked for.
    triangles : tuple of int
        Of the levels that answered.
    conditions : tuple of Conditions
    warnings : tuple of str
        Each once for all gamuts.
    """

    colours: tuple[str, ...]
    gamuts: tuple[str, ...]
    points: FloatArray
    space: str
    distance: FloatArray
    position: NDArray[Any]
    delta_e: FloatArray | None
    prints: BooleanArray
    passing: float | None
    edge_width: float
    together: tuple[GamutGroup, ...]
    recipes: tuple[ColourRecipes | None, ...] = field(default=(), repr=False)
    triangles: tuple[int, ...]
    conditions: tuple[Conditions, ...] = field(repr=False)
    warnings: tuple[str, ...] = ()

    @property
    def share(self) -> FloatArray:
        """Share (g,) of the colours that a gamut prints."""
        return self.prints.mean(axis=0) if len(self.prints) else np.full(len(self.gamuts), np.nan)

    @property
    def mean_delta_e(self) -> FloatArray | None:
        """Mean (g,) of `delta_e` over all colours."""
        return _over_colours(np.mean, self.delta_e)

    @property
    def percentile_95(self) -> FloatArray | None:
        """95th percentile (g,) of `delta_e` over all colours."""
        return _over_colours(lambda values: np.percentile(values, 95), self.delta_e)

    @property
    def printed_by(self) -> NDArray[np.integer[Any]]:
        """Number (n,) of gamuts that print a colour."""
        counts: NDArray[np.integer[Any]] = np.count_nonzero(self.prints, axis=1)
        return counts

    @property
    def excess(self) -> FloatArray:
        """How far (n, g) a gamut misses a colour: `delta_e`, or else the distance outside."""
        return np.maximum(self.distance, 0.0) if self.delta_e is None else self.delta_e

    @property
    def best(self) -> NDArray[np.integer[Any]]:
        """Number (n,) of the gamut that comes nearest; of several, the one with most room."""
        excess = self.excess
        nearest = excess <= excess.min(axis=1, keepdims=True)
        numbers: NDArray[np.integer[Any]] = np.where(nearest, self.distance, np.inf).argmin(axis=1)
        return numbers

    def worst(self, gamut: int, most: int = 3) -> list[int]:
        """Return the numbers of the colours out of gamut that a gamut misses most."""
        excess = self.excess[:, gamut]
        order = np.argsort(-excess, kind="stable")[:most]
        return [int(at) for at in order if excess[at] > 0.0]

    def to_dict(self) -> dict[str, Any]:
        """Return the match as a JSON-able mapping, with an array for each gamut."""
        document: dict[str, Any] = {
            "space": self.space,
            "tolerance": {"delta_e_2000": self.passing, "edge_width": self.edge_width},
            "colours": {
                "name": list(self.colours),
                "point": self.points.tolist(),
                "printed_by": self.printed_by.tolist(),
                "best": [self.gamuts[at] for at in self.best],
            },
            "gamuts": [],
            "together": [
                {"gamuts": list(each.gamuts), "printed": each.printed, "exact": each.exact}
                for each in self.together
            ],
            "warnings": list(self.warnings),
        }
        mean, percentile = self.mean_delta_e, self.percentile_95
        for at, name in enumerate(self.gamuts):
            gamut: dict[str, Any] = {
                "name": name,
                "share": _number(self.share[at]),
                "mean_delta_e_2000": None if mean is None else _number(mean[at]),
                "percentile_95_delta_e_2000": None
                if percentile is None
                else _number(percentile[at]),
                "worst": [self.colours[row] for row in self.worst(at)],
                "triangles": self.triangles[at],
                "conditions": self.conditions[at].to_dict(),
                "prints": self.prints[:, at].tolist(),
                "position": self.position[:, at].tolist(),
                "distance": self.distance[:, at].tolist(),
            }
            if self.delta_e is not None:
                gamut["delta_e_2000"] = self.delta_e[:, at].tolist()
            recipes = self.recipes[at] if self.recipes else None
            if recipes is not None:
                gamut |= {
                    "channels": list(recipes.channels),
                    "device": recipes.device.tolist(),
                    "recipe_delta_e_2000": recipes.delta_e.tolist(),
                    "recipe_point": recipes.points.tolist(),
                    "recipe_inside": recipes.inside.tolist(),
                }
            document["gamuts"].append(gamut)
        return document

    @classmethod
    def from_dict(cls, document: Mapping[str, Any]) -> ColourMatch:
        """Return the match of a JSON document; the inverse of `to_dict`."""
        colours, gamuts = document["colours"], document["gamuts"]
        count, tolerance = len(colours["name"]), document["tolerance"]

        def columns(name: str, kind: type) -> NDArray[Any]:
            values: NDArray[Any] = np.array([each[name] for each in gamuts], kind)
            return np.ascontiguousarray(values.reshape(len(gamuts), count).T)

        return cls(
            colours=tuple(colours["name"]),
            gamuts=tuple(each["name"] for each in gamuts),
            points=np.array(colours["point"], np.float64).reshape(count, 3),
            space=document["space"],
            distance=columns("distance", float),
            position=columns("position", str),
            delta_e=columns("delta_e_2000", float) if "delta_e_2000" in gamuts[0] else None,
            prints=columns("prints", bool),
            passing=tolerance["delta_e_2000"],
            edge_width=tolerance["edge_width"],
            together=tuple(
                GamutGroup(tuple(each["gamuts"]), each["printed"], each["exact"])
                for each in document["together"]
            ),
            recipes=tuple(_recipes_of(each, document["space"]) for each in gamuts)
            if any("device" in each for each in gamuts)
            else (),
            triangles=tuple(each["triangles"] for each in gamuts),
            conditions=tuple(Conditions.from_dict(each["conditions"]) for each in gamuts),
            warnings=tuple(document["warnings"]),
        )


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class CoverageMatrix(TabularRepr):
    """How much of each of several gamuts each other one covers.

    Attributes
    ----------
    gamuts : tuple of str
    volume : (g,) float64
        In cubic units of the space, of the levels that were compared.
    intersection : (g, g) float64
        Volumes that two gamuts have in common; on the diagonal, their own volumes.
    space : str
    triangles : tuple of int
    conditions : tuple of Conditions
    warnings : tuple of str
        Each once for all gamuts.
    """

    gamuts: tuple[str, ...]
    volume: FloatArray
    intersection: FloatArray
    space: str
    triangles: tuple[int, ...]
    conditions: tuple[Conditions, ...] = field(repr=False)
    warnings: tuple[str, ...] = ()

    @property
    def coverage(self) -> FloatArray:
        """Share (g, g) of the volume of the gamut of a column that the one of a row covers."""
        return self.intersection / self.volume

    def to_dict(self) -> dict[str, Any]:
        """Return the matrix as a JSON-able mapping."""
        return {
            "space": self.space,
            "gamuts": [
                {"name": name, "volume": volume, "triangles": count, "conditions": each.to_dict()}
                for name, volume, count, each in zip(
                    self.gamuts, self.volume.tolist(), self.triangles, self.conditions, strict=True
                )
            ],
            "intersection": self.intersection.tolist(),
            "coverage": self.coverage.tolist(),
            "warnings": list(self.warnings),
        }


def _recipes_of(gamut: Mapping[str, Any], space: str) -> ColourRecipes | None:
    """Return the recipes of a gamut in the document of a match; None if it has none."""
    if "device" not in gamut:
        return None
    channels = tuple(gamut["channels"])
    return ColourRecipes(
        device=np.array(gamut["device"], np.float64).reshape(-1, len(channels)),
        channels=channels,
        points=np.array(gamut["recipe_point"], np.float64).reshape(-1, 3),
        delta_e=np.array(gamut["recipe_delta_e_2000"], np.float64),
        inside=np.array(gamut["recipe_inside"], np.bool_),
        triangles=gamut["triangles"],
        max_error=None,
        space=space,
    )


def _over_colours(
    figure: Callable[[FloatArray], Any], values: FloatArray | None
) -> FloatArray | None:
    """Return a figure of each column; NaN of no rows, None of no values."""
    if values is None:
        return None
    if not len(values):
        return np.full(values.shape[1], np.nan)
    return np.array([figure(column) for column in values.T])


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
