"""Columns of a table of samples: their roles, spectral bands and measurement conditions, by name.

Names of device values follow CGATS.17: the set of channels and one channel (`CMYK_C`, `RGB_R`,
`7CLR_3`, `CMYKOGV_O`). Colours are `LAB_L LAB_A LAB_B`, `XYZ_X XYZ_Y XYZ_Z`, `LAB_L LAB_C LAB_H`,
`XYY_X XYY_Y XYY_CAPY`, or bands of a spectrum, whose names have the wavelength in nm (`SPEC_380`,
`SPECTRAL_NM380`, `NM_380`, `380`). Plain letters in their usual order (`R G B`, `L a b`,
`L* a* b*`, `x y Y`) are accepted, as spreadsheets write them. A name may state a measurement
condition (`M1_LAB_L`, `SPEC_380_M0`).

Fluorescent papers have different colours under the measurement conditions M0 to M3 of ISO 13655, so
conditions are never mixed. Data with several conditions is refused until one is chosen. Only
unambiguous statements are used: an instrument without a filter, for example, states nothing.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING

from gamutcore.errors import ConditionError, MissingColumnError, SampleLimitError

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from gamutcore.errors import Where

__all__ = [
    "CONDITION_KEYWORDS",
    "FEWEST_BANDS",
    "MAX_CHANNELS",
    "MAX_COLUMNS",
    "WHOLE_KEYWORDS",
    "ColumnRoles",
    "are_wavelengths",
    "chosen_condition",
    "column_roles",
    "condition_label",
    "is_reflective_condition",
    "spectral_columns",
    "spelt_out",
    "stated_condition",
    "wavelength",
]

MAX_LABEL_LENGTH = 60
MAX_SHOWN = 10

_CODE = re.compile(r"(?<![A-Z0-9])M([0-3])(?![A-Z0-9.])")
_ULTRAVIOLET_CUT = re.compile(r"UV[ _-]?(?:CUT|EXCLUDED|FILTER(?:ED)?)\b|NO[ _-]UV\b")
_POLARISED = re.compile(r"(?<!NO )(?<!NON-)(?<!UN)\bPOLARI[SZ](?:ED|ER|ING|ATION)\b")
WHOLE_KEYWORDS = (
    "MEASUREMENT_CONDITION",
    "MEASUREMENT_CONDITIONS",
    "MEASUREMENT_MODE",
    "ISO13655_CONDITION",
)
"""Keywords whose whole text is a measurement condition."""

_SEARCHED_KEYWORDS = (
    "FILTER",
    "INSTRUMENT_FILTER",
    "MEASUREMENT_FILTER",
    "MEASUREMENT_SOURCE",
    "ISIS_INFO",
    "INSTRUMENTATION",
    "WEIGHTING_FUNCTION",
    "MEASUREMENT_GEOMETRY",
)
CONDITION_KEYWORDS = frozenset({*WHOLE_KEYWORDS, *_SEARCHED_KEYWORDS})
"""Keywords that may state a measurement condition."""

_CHOOSE = "Choose one of them by the option `condition`."


def condition_label(text: str) -> str:
    """Return the name of a condition such as ``"m1"``, ``"M1_Daylight"`` or ``"UVcut"``.

    This is M0 to M3 (ISO 13655:2017, 4.2.2), else the text itself without surplus space.
    """
    upper = text.upper().replace("_", " ")
    match = _CODE.search(upper)
    if match:
        return f"M{match[1]}"
    if _ULTRAVIOLET_CUT.search(upper):
        return "M2"
    if _POLARISED.search(upper):
        return "M3"
    return " ".join(text.split())[:MAX_LABEL_LENGTH]


def is_reflective_condition(label: str | None) -> bool:
    """Return whether a condition is one of ISO 13655, which apply to reflecting samples."""
    return label is not None and re.match(r"M[0-3]\b", label) is not None


def stated_condition(keywords: Mapping[str, str]) -> str | None:
    """Return the measurement condition that keywords (upper case, to text) state; None for none.

    An ultraviolet filter means M2, a polariser M3. The absence of a filter means nothing, because
    the lamp is unknown.
    """
    for keyword in WHOLE_KEYWORDS:
        text = keywords.get(keyword, "").strip()
        if text:
            return condition_label(text)
    for keyword in _SEARCHED_KEYWORDS:
        label = condition_label(keywords.get(keyword, ""))
        if re.fullmatch(r"M[0-3]", label):
            return label
    return None


def chosen_condition(
    conditions: Iterable[str | None], asked: str | None, *, where: Where | None = None
) -> str | None:
    """Return the measurement condition to use; None if none is stated and none requested.

    `conditions` are those of the data, in order, with None for parts that state none. Several
    conditions and none requested, or a request for another one, raise `ConditionError`; `where` is
    the location of the conditions.
    """
    labels = list(dict.fromkeys(conditions))
    named = [label for label in labels if label is not None]
    place: Where = {**(where or {}), "field": "condition", "conditions": named[:MAX_SHOWN]}
    if asked is not None:
        folded = " ".join(asked.split()).lower()
        label = next((name for name in named if name.lower() == folded), condition_label(asked))
        if label in named:
            return label
        known = f"it has {_listed(named)}" if named else "it states none"
        raise ConditionError(
            f"The data has no measurements under the condition {label}: {known}.",
            where=place,
            remedy=_CHOOSE if named else "Leave the option `condition` out.",
        )
    if len(labels) > 1:
        also = ", and parts without one" if None in labels else ""
        raise ConditionError(
            f"The data was measured under several conditions: {_listed(named)}{also}.",
            where=place,
            remedy=_CHOOSE,
        )
    return labels[0] if labels else None


def _listed(labels: list[str]) -> str:
    shown = ", ".join(labels[:MAX_SHOWN])
    return shown if len(labels) <= MAX_SHOWN else f"{shown} and {len(labels) - MAX_SHOWN} more"


FEWEST_BANDS = 8
"""Minimum number of bands. Eight bands of 40 nm span the visible range."""

_BAND = re.compile(
    r"(?:(?:SPEC|SPECTRAL|SPECTRUM|SPECTRAL_NM|NM|R|REFL|REFLECTANCE|RADIANCE)[_ ]?)?"
    r"([1-9]\d{2,3}(?:\.\d{1,3})?)(?:[_ ]?NM)?",
    re.IGNORECASE,
)
_SHORTEST, _LONGEST = 200.0, 1200.0
"""Range of optical wavelengths in nm. Other numbers are not wavelengths."""

_REACHES = (430.0, 650.0)
"""Range in nm that a spectrum must cover. Less than 1 % of the luminance lies outside; the ends are
extended. The shortest ranges in CxF files end at 680 nm."""


def wavelength(name: str) -> float | None:
    """Return the wavelength in the name of a column, in nm; None for other names."""
    match = _BAND.fullmatch(name.strip())
    if match is None:
        return None
    number = float(match[1])
    return number if _SHORTEST <= number <= _LONGEST else None


def are_wavelengths(cells: Sequence[str]) -> bool:
    """Return whether a row of numbers consists of wavelengths, ascending in even steps."""
    bands = [wavelength(cell) for cell in cells]
    numbers = [number for number in bands if number is not None]
    if len(numbers) < max(FEWEST_BANDS, len(bands)):
        return False
    steps = {round(b - a, 3) for a, b in pairwise(numbers)}
    return len(steps) == 1 and min(steps) > 0


def spectral_columns(
    names: Sequence[str], where: Where | None = None
) -> tuple[tuple[int, ...], tuple[float, ...]]:
    """Return the columns of a spectrum by ascending wavelength, and the wavelengths in nm.

    Both are empty if fewer than `FEWEST_BANDS` columns are bands. Repeated bands, and bands that do
    not span the visible range, are refused; `where` is the location of the names.
    """
    bands = [
        (number, column)
        for column, name in enumerate(names)
        if (number := wavelength(name)) is not None
    ]
    if len(bands) < FEWEST_BANDS:
        return (), ()
    bands.sort()
    for (one, _), (other, column) in pairwise(bands):
        if one == other:
            raise MissingColumnError(
                f"The band of {one:g} nm appears twice.",
                where={**(where or {}), "field": names[column]},
                remedy="Keep one spectrum, of one measurement condition.",
            )
    wavelengths = tuple(number for number, _ in bands)
    if not spans_the_visible_range(wavelengths):
        raise MissingColumnError(
            f"The spectrum runs from {wavelengths[0]:g} to {wavelengths[-1]:g} nm only.",
            where={**(where or {}), "field": names[bands[0][1]]},
            remedy=f"A spectrum must reach from {_REACHES[0]:g} nm or less to {_REACHES[1]:g} nm "
            "or more.",
        )
    return tuple(column for _, column in bands), wavelengths


def spans_the_visible_range(wavelengths: Sequence[float]) -> bool:
    """Return whether ascending wavelengths in nm cover enough of the visible range."""
    return wavelengths[0] <= _REACHES[0] and wavelengths[-1] >= _REACHES[1]


MAX_CHANNELS = 15
"""Maximum number of channels of a device, as in ICC profiles (ICC.1:2022, 7.2.8: ``FCLR``)."""

MAX_COLUMNS = 2000
"""Maximum number of columns. A spectrum in steps of 1 nm takes 401."""

_LETTERS = re.compile(r"i?([CMYKORGBVWNcmykorgbvwn]{1,15})_([A-Za-z])")
_NUMBERED = re.compile(r"(\d{1,2})CLR_(\d{1,2})|PC(\d{1,2})_(\d{1,2})", re.IGNORECASE)
_GRAY = re.compile(r"GR[AE]Y(?:_\w+)?", re.IGNORECASE)
_LABELLED = re.compile(r"(M[0-3])[_ :.-]+(.+)|(.+?)[_ :.-]+\(?(M[0-3])\)?", re.IGNORECASE)
_CONDITION_COLUMNS = frozenset(
    {"CONDITION", "MEASUREMENT_CONDITION", "MEASUREMENT_MODE", "M_CONDITION"}
)
COLOUR_NAMES = {
    "lab": ("LAB_L", "LAB_A", "LAB_B"),
    "lch": ("LCH_L", "LCH_C", "LCH_H"),
    "xyz": ("XYZ_X", "XYZ_Y", "XYZ_Z"),
    "xyy": ("XYY_X", "XYY_Y", "XYY_CAPY"),
}
"""Names of the columns of each kind of colour."""

LAB_LCH = ("LAB_L", "LAB_C", "LAB_H")
"""Names of LCh in CGATS.17."""

_LAB, _LCH, _XYZ, _XYY = COLOUR_NAMES.values()
_COLOUR_NAMES = frozenset({*_LAB, *_XYZ, *_LCH, *LAB_LCH, *_XYY})
_LETTERS_ALONE = frozenset({"L", "a", "b", "L*", "a*", "b*", "X", "Y", "Z", "x", "y"})
_CASED: dict[tuple[str, ...], tuple[str, ...]] = {
    ("x", "y", "Y"): _XYY,
    ("Y", "x", "y"): (_XYY[2], _XYY[0], _XYY[1]),
}
"""Names that differ from tristimulus values only by the case of their letters."""

_BRACKETS = re.compile(r"\s*[(\[][^)\]]*[)\]]")
_PREFIXED = re.compile(
    r"(?:(CIE)[-_ .:]*)?(?:(L\*?a\*?b\*?|LCH|XYZ|S?RGB)[-_ .:]+)?"
    r"(L\*?|a\*?|b\*?|C\*?|h\*?|[XYZRG])",
    re.IGNORECASE,
)
_WORDS = {
    "red": "R",
    "green": "G",
    "blue": "B",
    "chroma": "C",
    "chroma*": "C*",
    "h°": "h",
    "cyan": "C",
    "magenta": "M",
    "yellow": "Y",
    "black": "K",
    "key": "K",
    "h_ab": "hab",
    "lightness": "L",
    "lightness*": "L*",
    "hue": "h",
    "hue°": "h",
    "c_ab": "C*ab",
    "h*": "h",
}
"""Words in the place of letters."""

_PLAIN = {
    ("L", "C", "H"): "LCH",
    ("L*", "C*", "H"): "LCH",
    ("L*", "C*", "H*"): "LCH",
    ("L*", "C*AB", "HAB"): "LCH",
    ("C", "M", "Y", "K"): "CMYK",
    ("C", "M", "Y"): "CMY",
    ("R", "G", "B"): "RGB",
    ("X", "Y", "Z"): "XYZ",
    ("L", "A", "B"): "LAB",
    ("L*", "A*", "B*"): "LAB",
}


@dataclass(frozen=True)
class ColumnRoles:
    """Columns of device values and colours.

    `names` has all columns, `device` those of `channels`, in order. `colours` maps the kinds
    ``"lab"``, ``"lch"``, ``"xyz"``, ``"xyy"`` and ``"spectrum"`` that are there to their columns.
    `wavelengths` of the bands ascend, in nm. `ignored` describes further columns that are not used.
    `condition` is the measurement condition in the names, and `condition_column` has that of each
    row.
    """

    names: tuple[str, ...]
    channels: tuple[str, ...]
    device: tuple[int, ...]
    colours: dict[str, tuple[int, ...]]
    wavelengths: tuple[float, ...] = ()
    ignored: tuple[str, ...] = ()
    condition: str | None = None
    condition_column: int | None = None

    @cached_property
    def _pairs(self) -> list[tuple[str, int]]:
        condition = {} if self.condition_column is None else {"condition": (self.condition_column,)}
        parts = {"device": self.device, **self.colours, **condition}
        return [(kind, column) for kind, columns in parts.items() for column in columns]

    @cached_property
    def selected(self) -> tuple[int, ...]:
        """Columns to read: device values, colours, and the condition last."""
        return tuple(column for _, column in self._pairs)

    @property
    def selected_names(self) -> tuple[str, ...]:
        """Names of the columns to read."""
        return tuple(self.names[column] for column in self.selected)

    @property
    def kinds(self) -> tuple[str, ...]:
        """``"device"``, ``"lab"``, ``"spectrum"`` and so on for each column to read."""
        return tuple(kind for kind, _ in self._pairs)


def column_roles(
    names: Sequence[str], *, condition: str | None = None, where: Where | None = None
) -> ColumnRoles:
    """Return the columns of device values and colours.

    `condition` is the measurement condition to read, if the names state several; `where` is the
    location of the names. Refused are names without a complete colour, incomplete or repeated
    device channels, an undecided condition, and too many columns or channels.
    """
    place: Where = dict(where or {})
    if len(names) > MAX_COLUMNS:
        raise SampleLimitError(
            f"The table has {len(names)} columns, more than {MAX_COLUMNS}.",
            where=place,
            remedy=f"Leave out columns that are not needed, down to {MAX_COLUMNS}.",
        )
    stripped, label, others = _of_one_condition(
        tuple(name.strip() for name in names), condition, place
    )
    cleaned = spelt_out(stripped)
    groups = _device_groups(cleaned)
    colours, wavelengths = _colours(cleaned, place)
    rows = next((i for i, name in enumerate(cleaned) if name.upper() in _CONDITION_COLUMNS), None)
    channels: tuple[str, ...] = ()
    device: tuple[int, ...] = ()
    if groups:
        prefix, members = next(iter(groups.items()))
        channels, device = _channels(prefix, members, place)
    return ColumnRoles(
        names=tuple(names),
        channels=channels,
        device=device,
        colours=colours,
        wavelengths=wavelengths,
        ignored=(*tuple(groups)[1:], *others),
        condition=label,
        condition_column=rows if label is None else None,
    )


def _colours(
    names: tuple[str, ...], where: Where
) -> tuple[dict[str, tuple[int, ...]], tuple[float, ...]]:
    """Return the columns of each kind of colour, and the wavelengths of the spectrum."""
    lch = _complete(names, _LCH) or _complete(names, LAB_LCH)
    present = {name.upper() for name in names}
    lab = _colour_columns(names, _LAB, where) if not lch or present & set(_LAB[1:]) else None
    xyz = _colour_columns(names, _XYZ, where)
    spectrum, wavelengths = spectral_columns(names, where)
    kinds = {
        "lab": lab,
        "lch": None if lab else lch,
        "xyz": xyz,
        "xyy": None if xyz else _complete(names, _XYY),
        "spectrum": spectrum,
    }
    columns_of_kinds = {kind: columns for kind, columns in kinds.items() if columns}
    if not columns_of_kinds:
        raise _no_colour(names, where)
    return columns_of_kinds, wavelengths


def _of_one_condition(
    names: tuple[str, ...], asked: str | None, where: Where
) -> tuple[tuple[str, ...], str | None, tuple[str, ...]]:
    """Return the names of one condition, the condition, and a description of the dropped columns.

    Names of other conditions become empty. If some colour columns state a condition, colour columns
    without one are dropped, because conditions must not be mixed.
    """
    labels: list[str | None] = []
    bare = []
    for name in names:
        match = _LABELLED.fullmatch(name)
        rest = (match[2] or match[3]) if match else ""
        is_colour = bool(rest) and (
            wavelength(rest) is not None or rest.upper() in _COLOUR_NAMES or rest in _LETTERS_ALONE
        )
        labels.append((match[1] or match[4]).upper() if match and is_colour else None)
        bare.append(rest if is_colour else name)
    stated = [label for label in labels if label is not None]
    if not stated:
        return names, None, ()
    chosen = chosen_condition(stated, asked, where=where)
    used_names, dropped = [], set()
    for name, label in zip(bare, labels, strict=True):
        colour = wavelength(name) is not None or name.upper() in _COLOUR_NAMES
        if label == chosen or (label is None and not colour):
            used_names.append(name)
        else:
            used_names.append("")
            dropped.add(f"columns of {label or 'no stated condition'}")
    return tuple(used_names), chosen, tuple(sorted(dropped))


def spelt_out(names: Sequence[str]) -> tuple[str, ...]:
    """Return names of columns as CGATS spells them, where they are known; the others as they are.

    Letters in their usual order belong together. The letters that are left may be in any order.

    Examples
    --------
    >>> spelt_out(["CIE-L", "b* (D50)", "a* (D50)", "note"])
    ('LAB_L', 'b* (D50)', 'a* (D50)', 'note')
    >>> spelt_out(["b*", "note", "L* (D50)", "a*"])
    ('LAB_B', 'note', 'LAB_L', 'LAB_A')
    """
    plain = tuple(_plain_name(name.strip()) for name in names)
    upper = tuple(name.upper() for name in plain)
    spelt, index = list(plain), 0
    free = dict.fromkeys(range(len(names)))
    while index < len(names):
        taken, sets = 1, [(_CASED.get(plain[index : index + 3]), 3)]
        sets += [
            (tuple(f"{prefix}_{letter[0]}" for letter in letters), len(letters))
            for letters, prefix in _PLAIN.items()
            if upper[index : index + len(letters)] == letters
        ]
        for spelling, size in sets:
            if spelling is not None:
                spelt[index : index + size] = spelling
                taken = size
                break
        if taken > 1:
            for place in range(index, index + taken):
                del free[place]
        index += taken
    for letters, prefix in _PLAIN.items():
        matches = [[place for place in free if upper[place] == letter] for letter in letters]
        if all(len(columns) == 1 for columns in matches):
            for (place,), letter in zip(matches, letters, strict=True):
                spelt[place] = f"{prefix}_{letter[0]}"
                del free[place]
    # names that are in no set stay as they are, for messages
    return tuple(
        names[place].strip() if place in free and "_" not in plain[place] else spelt[place]
        for place in range(len(names))
    )


def _plain_name(name: str) -> str:
    """Return a name without remarks in brackets, such as the illuminant, and without ``CIE``."""
    bare = _BRACKETS.sub("", name).strip() or name
    match = _PREFIXED.fullmatch(bare)
    if match is None or bare.upper() in _COLOUR_NAMES or not (match[1] or match[2]):
        return _WORDS.get(bare.lower(), bare)
    prefix, letter = (match[2] or "").upper().replace("*", "").removeprefix("S"), match[3]
    if not prefix and letter in "XYZxy":
        return letter
    if prefix in {"XYZ", "RGB"}:
        return f"{prefix}_{letter[0].upper()}"
    return f"LAB_{letter[0].upper()}"


def _colour_columns(
    names: tuple[str, ...], wanted: tuple[str, ...], where: Where
) -> tuple[int, ...] | None:
    """Return the columns of a colour; refuse an incomplete one."""
    places: dict[str, int] = {}
    for index, name in enumerate(names):
        upper = name.upper()
        if upper not in wanted:
            continue
        if upper in places:
            raise MissingColumnError(
                f"The column {name} appears twice.",
                where={**where, "field": name},
                remedy="Keep one set of colours, of one measurement condition.",
            )
        places[upper] = index
    if not places:
        return None
    missing = [name for name in wanted if name not in places]
    if missing:
        raise MissingColumnError(
            f"The column {missing[0]} is missing beside {', '.join(places)}.",
            where={**where, "field": missing[0], "columns": list(names)[:50]},
            remedy=f"Give all of {', '.join(wanted)}.",
        )
    return tuple(places[name] for name in wanted)


def _complete(names: tuple[str, ...], wanted: tuple[str, ...]) -> tuple[int, ...] | None:
    """Return the columns of a colour, or None if it is incomplete."""
    upper = [name.upper() for name in names]
    if any(upper.count(name) != 1 for name in wanted):
        return None
    return tuple(upper.index(name) for name in wanted)


def _no_colour(names: tuple[str, ...], where: Where) -> MissingColumnError:
    remedy = (
        "Give the columns LAB_L, LAB_A, LAB_B or XYZ_X, XYZ_Y, XYZ_Z, xyY, LCh, or a spectrum of "
        f"at least {FEWEST_BANDS} bands."
    )
    if _device_groups(names):
        remedy += " Device values alone are a chart: measure it, and give the measurements."
    message = "No columns hold a complete colour"
    bands = sum(wavelength(name) is not None for name in names)
    if bands:
        message += f"; the spectra in the table have too few bands, {bands}"
    return MissingColumnError(
        f"{message}. The columns are: {', '.join(names)[:300] or 'none'}.",
        where={**where, "columns": list(names)[:50]},
        remedy=remedy,
    )


def _device_groups(names: tuple[str, ...]) -> dict[str, dict[str, list[int]]]:
    groups: dict[str, dict[str, list[int]]] = {}
    for index, name in enumerate(names):
        numbered, letters = _NUMBERED.fullmatch(name), _LETTERS.fullmatch(name)
        if numbered:
            count, ink = numbered[1] or numbered[3], numbered[2] or numbered[4]
            prefix, channel = f"{int(count)}CLR", str(int(ink))
        elif letters and (channel := _letter_of(letters[1], letters[2])):
            prefix = letters[1].upper() if letters[1].islower() else letters[1]
        elif _GRAY.fullmatch(name):
            prefix, channel = "GRAY", "K" if name.upper().endswith("_K") else "W"
        else:
            continue
        groups.setdefault(prefix, {}).setdefault(channel, []).append(index)
    return groups


def _letter_of(letters: str, letter: str) -> str:
    # Lower case means a light ink in mixed sets (CMYKcm_c), and nothing elsewhere.
    if letter in letters and not letters.islower():
        return letter
    return letter.upper() if letter.upper() in letters.upper() else ""


def _channels(
    prefix: str, members: dict[str, list[int]], where: Where
) -> tuple[tuple[str, ...], tuple[int, ...]]:
    if prefix.endswith("CLR"):
        count = int(prefix[:-3])
        if count > MAX_CHANNELS:
            raise SampleLimitError(
                f"{prefix} has more than {MAX_CHANNELS} channels.",
                where={**where, "field": prefix},
                remedy=f"Send the data of a device with at most {MAX_CHANNELS} channels.",
            )
        wanted = [str(ink) for ink in range(1, count + 1)]
    else:
        wanted = list(members) if prefix == "GRAY" else list(prefix)
        if not set(wanted) & set(members):
            wanted = [letter.upper() for letter in wanted]
    for channel in [*wanted, *members]:
        places = members.get(channel, [])
        if len(places) != 1 or channel not in wanted:
            problem = "is missing" if not places else "appears twice or is not in the set"
            raise MissingColumnError(
                f"The device column {prefix}_{channel} {problem}.",
                where={**where, "field": f"{prefix}_{channel}"},
                remedy=f"Give each of {', '.join(f'{prefix}_{c}' for c in wanted)} once.",
            )
    return tuple(wanted), tuple(members[channel][0] for channel in wanted)
