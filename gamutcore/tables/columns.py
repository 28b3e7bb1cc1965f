"""How colours are written: in columns of a table or data frame, as texts, and in palettes.

Names, the number of columns and the values decide which columns hold the colours, in which space
and on which scale. What two readings fit is refused with both. Data frames of pandas, polars and
others have `columns`, and a column by its name. Neither is imported.

The grammar of texts is that of CSS Color 4 (W3C, 2025), sections 5 to 10: #e4002b, rgb(), hsl(),
lab(), lch(), oklab(), oklch(). Alpha is read and not used. Names such as ``red`` and relative
colours are not read. The format of palettes is Adobe Swatch Exchange (.ase), as the exports of
Adobe's applications have it: big-endian blocks, of which 0x0001 is a colour and 0xC001 and 0xC002
begin and end a group.
"""

from __future__ import annotations

import colorsys
import math
import re
import struct
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from gamutcore.arguments import check_option
from gamutcore.characterisation.columns import COLOUR_NAMES, LAB_LCH, spelt_out
from gamutcore.characterisation.samples import xyz_of_xyy
from gamutcore.colours import GIVEN_SPACE, OTHER_AXES
from gamutcore.colours.spaces import SPACES
from gamutcore.errors import InvalidPointsError, MalformedFileError, MissingColumnError, OptionError
from gamutcore.number_text import number_text

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from gamutcore.arrays import FloatArray
    from gamutcore.errors import Where

__all__ = [
    "PALETTE_MAGIC",
    "ColourColumns",
    "FrameColours",
    "Swatch",
    "axes_of",
    "css_colour",
    "find_columns",
    "frame_colours",
    "on_full_scale",
    "space_named",
    "swatches",
    "unused_columns",
]


class _Kind(NamedTuple):
    """A set of columns: their names as CGATS spells them, and how their values are checked."""

    names: tuple[tuple[str, str, str], ...]
    space: str
    scales: tuple[float, ...]
    lowest: tuple[float, float, float]
    highest: tuple[float, float, float]


_ANY = 500.0
"""Largest |a*|, |b*| and C*. Those of the primaries of ACES AP0 (SMPTE ST 2065-1), the widest
encoding in use, are at most 410."""

_ROUNDING = 0.002
"""What codes may exceed their scale by: half a step of 8 bits."""

_KINDS = {
    "LAB": _Kind(
        (COLOUR_NAMES["lab"],),
        "CIELAB",
        (100.0,),
        (-1.0, -_ANY, -_ANY),
        # 100 is the perfect diffuser (CIE 15:2018). Fluorescence exceeds it under M1; 105 is
        # Y = 113 %.
        (105.0, _ANY, _ANY),
    ),
    "LCH": _Kind(
        (COLOUR_NAMES["lch"], LAB_LCH),
        "LCHab",
        (100.0,),
        (-1.0, -1e-6, -720.0),
        (105.0, _ANY, 720.0),
    ),
    "XYZ": _Kind(
        (COLOUR_NAMES["xyz"],),
        "CIEXYZ",
        (1.0, 100.0),
        (-0.1, -0.1, -0.1),
        # Z of D65 is 1.09, and X of illuminant A 1.10 (CIE 15:2018); fluorescence adds.
        (1.5, 1.5, 1.5),
    ),
    "XYY": _Kind(
        (COLOUR_NAMES["xyy"],),
        "CIEXYZ",
        (1.0, 100.0),
        (0.0, 0.0, 0.0),
        (1.0, 1.0, 1.5),  # x and y of any light are from 0 to 1 (CIE 15:2018); Y as above
    ),
    "RGB": _Kind(
        (("RGB_R", "RGB_G", "RGB_B"),),
        "sRGB",
        (1.0, 255.0),
        # The primaries of BT.2020 and their sums are from -0.84 to 1.25 in sRGB (ITU-R BT.2087).
        (-1.0, -1.0, -1.0),
        (1.5, 1.5, 1.5),
    ),
    "TEXT": _Kind((), "sRGB", (1.0,), (-1.0,) * 3, (1.5,) * 3),
}
"""Sets of columns; the measured ones, in the order of preference, before the others."""

_MEASURED = ("LAB", "LCH", "XYZ", "XYY")
_FURTHER_SCALES = (255.0, 1023.0, 4095.0, 65535.0)
_INKS = re.compile(r"(CMYK|CMY)_[CMYK]|\d{1,2}CLR_\d{1,2}", re.IGNORECASE)
_TEXTS = frozenset({"hex", "html", "css", "color", "colour", "web", "hexcode", "rgbhex", "srgbhex"})
_CANDIDATES = "L,a,b, L,C,h, X,Y,Z, x,y,Y, R,G,B or hex"


@dataclass(frozen=True)
class ColourColumns:
    """The columns of a colour: three, or one of texts such as ``#e4002b``.

    `kind` is a key of the table of sets, or empty for other spaces. `space` is one of
    `GIVEN_SPACE`.
    """

    places: tuple[int, ...]
    kind: str
    space: str


def space_named(space: str) -> str:
    """Return the canonical name of a space that colours may be given in."""
    return str(check_option("space", space, GIVEN_SPACE))


def axes_of(space: str) -> tuple[str, str, str]:
    """Return the names of the coordinates of a space."""
    return OTHER_AXES.get(space) or SPACES[space].axes


def find_columns(
    header: Sequence[str],
    *,
    space: str | None = None,
    columns: str | None = None,
    prefix: str = "",
    own: str | None = None,
    where: Where | None = None,
) -> ColourColumns:
    """Return the columns of a colour; refuse a header without them, or with several sets of them.

    `space` and `own` are canonical names. Without a space, the names of the columns decide, and the
    coordinates of the gamut's own space come first. `columns` are names or numbers of columns,
    separated by commas. `prefix` is the beginning of the names, such as ``from``, if a row has
    several colours.
    """
    place: Where = dict(where or {})
    names = [_without(name.strip(), prefix) for name in header]
    if columns is not None:
        return _chosen(names, columns, space, own, place)
    if space is not None:
        match = _by_axes(names, space) or _of_space(names, space)
        if match is None:
            raise _no_axes(header, names, space, prefix, place)
        return match
    match = None if own is None else _by_axes(names, own) or _of_space(names, own)
    if match is not None:
        return match
    sets = _sets(names)
    measured = [group for group in sets if group.kind in _MEASURED]
    others = [group for group in sets if group.kind not in _MEASURED]
    kinds = {group.kind for group in measured}
    if len(measured) > len(kinds) or (others and len(sets) > 1):
        listed = [
            ",".join(
                header[at] if header.count(header[at]) == 1 else str(at + 1) for at in group.places
            )
            for group in sets
        ]
        raise MissingColumnError(
            f"The table has several colours in each row: {'; '.join(listed)}.",
            where={**place, "field": "columns"},
            remedy=f"Name the columns with --columns, such as --columns {listed[0]}, or over HTTP "
            "with columns. In Python, give one colour, or its space.",
        )
    if sets:
        return sets[0]
    spelt = spelt_out(names)
    inks = [header[at] for at, name in enumerate(spelt) if _INKS.fullmatch(name)]
    if inks:
        raise MissingColumnError(
            f"The columns {', '.join(inks)} are amounts of ink: colours of one press only.",
            where={**place, "field": inks[0]},
            remedy="Convert them by the profile of the press to columns L, a, b.",
        )
    if own is not None:
        raise _no_axes(header, names, own, prefix, place)
    raise MissingColumnError(
        f"No columns of colours are among {', '.join(header)[:200] or 'none'}.",
        where={**place, "field": "columns"},
        remedy=f"Name the columns {_CANDIDATES}, or choose three with --columns.",
    )


def unused_columns(header: Sequence[str], used: Sequence[int]) -> list[str]:
    """Return the names of further sets of columns that hold a colour, such as ``X, Y, Z``."""
    sets = [group.places for group in _sets([name.strip() for name in header])]
    return [
        ", ".join(header[place] for place in places) for places in sets if set(places) != set(used)
    ]


def _without(name: str, prefix: str) -> str:
    if not prefix:
        return name
    match = re.match(rf"{re.escape(prefix)}[\W_]*", name, re.IGNORECASE)
    return name[match.end() :] if match else ""


def _fold(name: str) -> str:
    return re.sub(r"[^a-z0-9]", "", name.lower())


def _by_axes(names: Sequence[str], space: str) -> ColourColumns | None:
    """Return the columns that are named after the coordinates, by letters and digits."""
    folded = [_fold(name) for name in names]
    places = []
    for axis in axes_of(space):
        wanted = {_fold(axis), f"lab{_fold(axis)}"}
        matches = [at for at, name in enumerate(folded) if name in wanted]
        if len(matches) != 1:
            return None
        places.append(matches[0])
    kind = next((key for key, entry in _KINDS.items() if entry.space == space), "")
    return ColourColumns(tuple(places), kind, space)


def _of_space(names: Sequence[str], space: str) -> ColourColumns | None:
    sets = [group for group in _sets(names) if group.space == space]
    return sets[0] if len(sets) == 1 else None


def _sets(names: Sequence[str]) -> list[ColourColumns]:
    """Return the complete sets of columns, those of the first kind first."""
    spelt = [name.upper() for name in spelt_out(names)]
    sets: list[ColourColumns] = []
    for kind, declared in _KINDS.items():
        for wanted in declared.names:
            places = [[at for at, name in enumerate(spelt) if name == one] for one in wanted]
            if kind == "LCH" and any(one.kind == "LAB" for one in sets):
                continue
            if len(set(map(len, places))) > 1:  # incomplete, or one column is doubled
                continue
            sets += [
                ColourColumns(one, kind, declared.space)
                for one in zip(*places, strict=True)  # a set that is twice there counts twice
            ]
    sets += [
        ColourColumns((at,), "TEXT", "sRGB")
        for at, name in enumerate(names)
        if _fold(name) in _TEXTS
    ]
    return sets


def _chosen(
    names: list[str], columns: str, space: str | None, own: str | None, where: Where
) -> ColourColumns:
    wanted = [name.strip() for name in columns.split(",")]
    places = []
    for name in wanted:
        at = [place for place, known in enumerate(names) if known == name]
        if not at and name.isdecimal() and 0 < int(name) <= len(names):
            at = [int(name) - 1]
        if len(at) != 1:
            fault = "is not" if not at else "is more than once"
            raise MissingColumnError(
                f"The column {name} of {columns} {fault} among {', '.join(names)[:200]}.",
                where={**where, "field": "columns"},
                remedy="Give three names or numbers of columns, such as L,a,b or 2,3,4.",
            )
        places.append(at[0])
    if len(places) not in {1, 3}:
        raise MissingColumnError(
            f"{columns} are {len(places)} columns.",
            where={**where, "field": "columns"},
            remedy="Give three names or numbers of columns, such as L,a,b or 2,3,4.",
        )
    if len(places) == 1:
        return ColourColumns(tuple(places), "TEXT", space or "sRGB")
    if space is None:
        sets = _sets([names[place] for place in places])
        if len(sets) == 1:
            order = tuple(places[place] for place in sets[0].places)
            return ColourColumns(order, sets[0].kind, sets[0].space)
    chosen = space or own or "CIELAB"
    kind = next((key for key, entry in _KINDS.items() if entry.space == chosen), "")
    return ColourColumns(tuple(places), kind, chosen)


def _no_axes(
    header: Sequence[str], names: Sequence[str], space: str, prefix: str, where: Where
) -> MissingColumnError:
    """Return the error for a table without the columns of a space."""
    axes = axes_of(space)
    folded = [_fold(name) for name in names]
    counts = [sum(name in {_fold(axis), f"lab{_fold(axis)}"} for name in folded) for axis in axes]
    at = next(index for index, count in enumerate(counts) if count != 1)
    column = f"{prefix}_{axes[at]}" if prefix else axes[at]
    fault = "no column" if not counts[at] else f"{counts[at]} columns"
    other = [group.space for group in _sets(names)]
    further = f": these are {other[0]}" if other else f", or the names {_CANDIDATES}"
    remedy = (
        f"Name the columns of the colours {', '.join(axes)}, with the prefixes of the operation "
        f"if a row has several colours. Columns of another space need `space`{further}."
    )
    return MissingColumnError(
        f"The table has {fault} {column}. Its columns are: {', '.join(header)[:200] or 'none'}.",
        where={**where, "field": column},
        remedy=remedy,
    )


def on_full_scale(
    columns: ColourColumns,
    values: FloatArray,
    scale: float | None,
    names: Sequence[str],
    place: Callable[[int], Where],
    *,
    stated: bool = False,
) -> tuple[FloatArray, float]:
    """Return the coordinates of colours (n, 3) in their space, and the scale of the values.

    `scale` is the value of white; None to find it. `names` and `place`, the location of a row, are
    for errors. `stated` says whether the caller named the space, which the names of the columns may
    be common to. Values that fit several scales, or none, are refused.
    """
    kind = _KINDS.get(columns.kind)
    if scale is not None and not 0 < scale < 1e6:
        raise OptionError.refusal("scale", scale, "the value of white, such as 1, 100 or 255")
    if kind is None or not len(values):
        if scale is not None and kind is None:
            raise OptionError.not_applicable("scale", scale, f"{columns.space} has its own scale")
        return values, 1.0
    full = 100.0 if columns.kind in {"LAB", "LCH"} else 1.0
    if columns.kind == "LAB" and not stated and scale is None and 0 < np.abs(values).max() <= 1:
        raise InvalidPointsError(
            f"The largest value of {', '.join(names)} is {number_text(np.abs(values).max())}; the "
            "colours may be in CIELAB, in CIELAB with L* from 0 to 1, or in Oklab.",
            where={**place(0), "field": names[0]},
            remedy="Give --colours-in CIELAB, --scale 1 or --colours-in Oklab. In Python, give "
            "the space.",
        )
    white = scale or _scale_of(columns.kind, kind, values, names, place)
    points = values
    if white != full:
        factor = np.full(3, full / white)
        if columns.kind == "LCH":
            factor[2] = 1.0
        if columns.kind == "XYY":
            factor[:2] = 1.0
        points = values * factor
    lowest, highest = kind.lowest, kind.highest
    if columns.kind == "RGB" and white != 1.0:  # codes, which end at full scale
        lowest, highest = (-_ROUNDING,) * 3, (1.0 + _ROUNDING,) * 3
    beyond = (points < lowest) | (points > highest)
    if beyond.any():
        row, axis = (int(index) for index in np.argwhere(beyond)[0])
        likely = _likely(columns.kind, values)
        raise InvalidPointsError(
            f"{names[axis]} is {number_text(values[row, axis])}, outside the scale of "
            f"{columns.space}, whose white is {white:g}.",
            where={**place(row), "field": names[axis]},
            remedy=likely or f"Give colours of {columns.space}, or name their space.",
        )
    if columns.kind == "XYY":
        points = xyz_of_xyy(points)
    return points, white


def _scale_of(
    name: str, kind: _Kind, values: FloatArray, names: Sequence[str], place: Callable[[int], Where]
) -> float:
    """Return the scale that values have; refuse values that have several."""
    if len(kind.scales) == 1:
        return kind.scales[0]
    scaled = values[:, 2] if name == "XYY" else values
    highest = float(scaled.max())
    whole = bool((scaled == np.round(scaled)).all())
    if name != "RGB":
        return 1.0 if highest <= kind.highest[2] else 100.0
    if highest > kind.highest[0]:
        if whole or highest > 100.0:
            return 255.0
        candidates = "100 (per cent) or 255"
    elif highest > 0 and whole:
        candidates = "1 or 255"
    else:
        return 1.0
    row = int(np.argmax(values.max(axis=1)))
    raise InvalidPointsError(
        f"The largest value of {', '.join(names)} is {number_text(highest)}; their scale may be "
        f"{candidates}.",
        where={**place(row), "field": names[int(np.argmax(values[row]))]},
        remedy=f"Give the value of white, {candidates}, with --scale, over HTTP table_scale.",
    )


def _likely(name: str, values: FloatArray) -> str:
    """Return a sentence on the scale or space that values likely have."""
    highest = float(values.max())
    if name in {"LAB", "LCH"}:
        if float(values.min()) >= 0.0 and highest <= 255.0:
            return (
                "The values look like 8 bits, 0 to 255, of R,G,B or of an encoded L*a*b*. Name the "
                "columns R,G,B, or decode them to L* 0 to 100."
            )
        return "Give L* from 0 to 100."
    fitting = [scale for scale in (1.0, 100.0, *_FURTHER_SCALES) if highest <= 1.02 * scale]
    if not fitting:
        return ""
    return (
        f"The values look like a scale of 0 to {fitting[0]:g}. Divide them by {fitting[0]:g}, or "
        f"give --scale {fitting[0]:g} on the command line, or table_scale={fitting[0]:g} over HTTP."
    )


class FrameColours(NamedTuple):
    """Colours (n, 3), and their space."""

    points: Any
    space: str


def frame_colours(frame: object, space: str | None, own: str) -> FrameColours | None:
    """Return the colours of a data frame; None if an object is none, or has no names of columns.

    Parameters
    ----------
    frame : object
    space : str or None
        The space that the caller names.
    own : str
        Space of the gamut, whose coordinates come first.

    Raises
    ------
    MissingColumnError
        There are no columns of a colour, or several sets of them.
    InvalidPointsError
        Values are no numbers, are outside the scale, or fit several scales.
    """
    titles = getattr(frame, "columns", None)
    if titles is None or not hasattr(frame, "__getitem__"):
        return None
    names = list(titles)
    if not names or not all(isinstance(name, str) for name in names):
        return None
    stated_space = None if space is None else space_named(space)
    try:
        columns = find_columns(names, space=stated_space, own=own)
    except MissingColumnError:
        if stated_space is not None and len(names) == 3:  # the caller says what three columns are
            return None
        raise
    picked = [np.asarray(frame[names[place]]) for place in columns.places]
    if columns.kind == "TEXT":
        colours = [css_colour(str(text), bare_hex=True) for text in picked[0].tolist()]
        if any(colour is None or colour[0] != "sRGB" for colour in colours):
            row = next(
                at for at, colour in enumerate(colours) if colour is None or colour[0] != "sRGB"
            )
            raise InvalidPointsError(
                f"Row {row} of the column {names[columns.places[0]]} is "
                f"{str(picked[0][row])[:40]!r}, which is no colour of sRGB.",
                where={"field": names[columns.places[0]], "row": row},
                remedy="Give colours such as #e4002b, or columns of numbers.",
            )
        points = np.array([colour[1] for colour in colours if colour]).reshape(-1, 3)
        return FrameColours(points, "sRGB")
    try:
        values = np.stack([np.asarray(column, np.float64) for column in picked], axis=1)
    except (ValueError, TypeError):
        raise InvalidPointsError(
            f"The columns {', '.join(axes_of(columns.space))} of the table are not numbers.",
            where={"field": names[columns.places[0]]},
            remedy="Convert the columns to numbers.",
        ) from None
    finite = np.isfinite(values)
    if not finite.all():
        row = int(np.argmin(finite.all(axis=1)))
        raise InvalidPointsError(
            f"Row {row} of the colours is {values[row].tolist()}.",
            where={"field": "colours", "row": row},
            remedy="Give finite numbers. Leave out rows without a colour.",
        )
    scale = 1.0 if stated_space is not None and columns.space in {"sRGB", "CIEXYZ"} else None
    points, _ = on_full_scale(
        columns,
        values,
        scale,
        [names[place] for place in columns.places],
        lambda row: {"row": row},
        stated=stated_space is not None or columns.space == own,
    )
    return FrameColours(points, columns.space)


_HEX = re.compile(r"#?([0-9a-f]{3,4}|[0-9a-f]{6}|[0-9a-f]{8})", re.IGNORECASE)
_CSS_FUNCTION = re.compile(
    r"(rgb|rgba|hsl|hsla|lab|lch|oklab|oklch|color)\(\s*([^()]{1,200})\)", re.IGNORECASE
)
_VALUE = re.compile(
    r"([+-]?(?:\d{1,20}\.?\d{0,20}|\.\d{1,20})(?:e[+-]?\d{1,2})?)(%|deg|grad|rad|turn)?"
)
_ANGLES = {"deg": 1.0, "grad": 0.9, "rad": 180.0 / math.pi, "turn": 360.0}

_FULL = {
    "rgb": (255.0, 255.0, 255.0),
    "hsl": (None, 1.0, 1.0),
    "lab": (100.0, 125.0, 125.0),
    "lch": (100.0, 150.0, None),
    "oklab": (1.0, 0.4, 0.4),
    "oklch": (1.0, 0.4, None),
    "color": (1.0, 1.0, 1.0),
}
"""What 100 % is (CSS Color 4, 6.1, 9.3 and 9.4); None for a hue."""


def css_colour(  # noqa: C901, PLR0911, PLR0912  # one branch for each function
    text: str, *, bare_hex: bool = False
) -> tuple[str, tuple[float, float, float]] | None:
    """Return the space and the coordinates of a colour; None if the text is none.

    Parameters
    ----------
    text : str
    bare_hex : bool, optional
        Whether ``e4002b`` is a colour as well.

    Examples
    --------
    >>> css_colour("#ff0000")
    ('sRGB', (1.0, 0.0, 0.0))
    >>> css_colour("lab(50% 40 59.5)")
    ('CIELAB', (50.0, 40.0, 59.5))
    """
    text = text.strip()
    match = _HEX.fullmatch(text)
    if match:
        if not (bare_hex or text.startswith("#")):
            return None
        digits = match[1] if len(match[1]) > 4 else "".join(2 * digit for digit in match[1])
        return "sRGB", _three(int(digits[at : at + 2], 16) / 255.0 for at in (0, 2, 4))
    called = _CSS_FUNCTION.fullmatch(text)
    if not called:
        return None
    name = called[1].lower().removesuffix("a") if called[1].lower() != "color" else "color"
    words = called[2].partition("/")[0].replace(",", " ").lower().split()
    if name == "color":
        if not words or words.pop(0) != "srgb":
            return None
    elif len(words) == 4 and name in {"rgb", "hsl"}:
        words.pop()  # alpha after a comma
    if len(words) != 3:
        return None
    values = [_value(word, full) for word, full in zip(words, _FULL[name], strict=True)]
    if any(value is None for value in values):
        return None
    one, two, three = _three(value or 0.0 for value in values)
    if name == "rgb":
        return "sRGB", (one / 255.0, two / 255.0, three / 255.0)
    if name == "color":
        return "sRGB", (one, two, three)
    if name == "hsl":
        if "%" not in words[1]:
            two, three = two / 100.0, three / 100.0
        return "sRGB", colorsys.hls_to_rgb(one / 360.0 % 1.0, three, two)
    if name in {"lch", "oklch"}:
        if name == "lch":
            return "LCHab", (one, two, three % 360.0)
        angle = math.radians(three)
        return "Oklab", (one, two * math.cos(angle), two * math.sin(angle))
    return ("CIELAB" if name == "lab" else "Oklab"), (one, two, three)


def _three(values: Iterable[float]) -> tuple[float, float, float]:
    one, two, three = values
    return one, two, three


def _value(word: str, full: float | None) -> float | None:
    """Return the number of a component; None if it is none."""
    if word == "none":
        return 0.0
    match = _VALUE.fullmatch(word)
    if not match:
        return None
    number, unit = float(match[1]), match[2]
    if full is None:
        return None if unit == "%" else number * _ANGLES[unit or "deg"]
    if unit in _ANGLES:
        return None
    return number * full / 100.0 if unit else number


PALETTE_MAGIC = b"ASEF"
_COLOUR, _GROUP, _GROUP_END = 0x0001, 0xC001, 0xC002
_COMPONENTS = {"RGB": 3, "LAB": 3, "CMYK": 4, "Gray": 1}


class Swatch(NamedTuple):
    """A colour: its name, its group, its model, and the components as in the file."""

    name: str
    group: str
    model: str
    values: tuple[float, ...]


def swatches(data: bytes) -> list[Swatch]:
    """Return the colours of a palette; errors have the number of the block, from 1."""
    palette: list[Swatch] = []
    group, place, block = "", 12, 0
    try:
        (count,) = struct.unpack_from(">I", data, 8)
        for block in range(1, count + 1):  # noqa: B007  # named in the error
            kind, size = struct.unpack_from(">HI", data, place)
            content = data[place + 6 : place + 6 + size]
            if len(content) != size:
                raise struct.error("the file ends within a block")  # noqa: TRY301
            place += 6 + size
            if kind == _GROUP:
                group, _ = _block_text(content)
            elif kind == _GROUP_END:
                group = ""
            elif kind == _COLOUR:
                name, end = _block_text(content)
                model = content[end : end + 4].decode("ascii").strip()
                if model not in _COMPONENTS:
                    raise struct.error(f"the colour model is {model!r}")  # noqa: TRY301
                values = struct.unpack_from(f">{_COMPONENTS[model]}f", content, end + 4)
                palette.append(Swatch(name, group, model, values))
    except (struct.error, UnicodeDecodeError) as error:
        raise MalformedFileError(
            f"The palette is damaged: {error}.",
            where={"block": block},
            remedy="Export the swatches again as Adobe Swatch Exchange (.ase).",
        ) from None
    return palette


def _block_text(content: bytes) -> tuple[str, int]:
    """Return the text at the start of a block, and where it ends."""
    (length,) = struct.unpack_from(">H", content)
    end = 2 + 2 * length
    if end > len(content):
        raise struct.error("a name is longer than its block")
    return content[2:end].decode("utf-16-be").rstrip("\0"), end
