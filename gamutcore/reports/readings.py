"""Readings of a device: their patches, the pairs of two readings, and the noise of one.

Patches are matched by device values. Colours are as measured: CIELAB with D50 and the perfect
diffuser for prints, and relative to the white of the first reading for displays. The noise of a
reading is its root mean square ΔE*ab, equal along L*, a* and b*. The squared difference of two
means of repeats then has a χ² distribution with three degrees of freedom, or an F distribution if
the noise is itself from repeats.
"""

from __future__ import annotations

import os
import re
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from gamutcore.building import parsed_input
from gamutcore.characterisation import DelimitedText, Samples, text_encoding
from gamutcore.characterisation.cgats import cgats_rows, looks_like_cgats
from gamutcore.characterisation.cxf import looks_like_xml
from gamutcore.colours import (
    ICC_D50,
    adaptation_matrix,
    consistent_samples,
    device_groups,
    lab_to_xyz,
    measured_colours,
    xyz_to_lab,
)
from gamutcore.content import content_of
from gamutcore.errors import (
    CharacterisationError,
    MissingColumnError,
    OptionError,
    UnrecognisedFormatError,
    errors_in,
)
from gamutcore.limits import Limits
from gamutcore.number_text import number_text
from gamutcore.options import Options
from gamutcore.search import delta_e_2000

if TYPE_CHECKING:
    from collections.abc import Sequence

    from gamutcore.arrays import BooleanArray, FloatArray
    from gamutcore.colours.measured import MeasuredColours

__all__ = [
    "SAME_PATCH",
    "Noise",
    "Reading",
    "ReadingPair",
    "condition_warnings",
    "device_text",
    "pair_readings",
    "read_reading",
    "reading_names",
    "stated_condition",
]

SAME_PATCH = 0.5 / 255.0 + 1e-6
"""Largest difference of matched device values: half a step of 8 bits, the rounding of one file."""

CHANCE = 0.01
"""Probability that noise alone counts as a change."""

EQUAL = 1e-12
"""Sum of squared ΔE*ab of repeats that are equal but for rounding."""

_NAME_COLUMNS = ("SAMPLE_NAME", "SAMPLENAME", "NAME", "SAMPLE_ID", "SAMPLEID", "ID", "SAMPLE_LOC")
_BACKING = re.compile(r"\b(white|black|self)[ -]back", re.IGNORECASE)
_SCALED_WHITES = (1.0, 100.0)
"""Y of a display's white in files that do not state cd/m²."""


@dataclass(frozen=True, eq=False)
class Reading:
    """Patches of a reading, one for each device value: means of `repeats` (n,) readings.

    `scatter` is the sum of the squared ΔE*ab of the repeats from their means, which has `freedom`
    degrees of freedom for each coordinate.
    """

    name: str
    content: bytes
    samples: Samples
    colours: MeasuredColours
    device: FloatArray
    lab: FloatArray
    repeats: FloatArray
    patches: list[str]
    scatter: float
    freedom: int


class Noise(NamedTuple):
    """Noise of two readings.

    `value` is the root mean square ΔE*ab of one reading, with its degrees of freedom and its
    source. `is_noisy` tells which of the two readings has it: averages do not.
    """

    value: float
    freedom: float
    source: str
    is_noisy: tuple[bool, bool] = (True, True)

    def bound(self, count: int, chance: float) -> float:
        """Return the largest ratio of mean squares of `count` patches to the noise's."""
        from scipy.special import chdtri, fdtri  # noqa: PLC0415  # slow to import

        upper = 3.0 * count
        if np.isinf(self.freedom):
            return float(chdtri(upper, chance) / upper)
        return float(fdtri(upper, 3.0 * self.freedom, 1.0 - chance))


@dataclass(frozen=True, eq=False)
class ReadingPair:
    """Two readings, the rows of the patches in both, and the differences second minus first."""

    first: Reading
    second: Reading
    rows: tuple[Any, Any]
    difference: FloatArray
    delta_e: FloatArray
    noise: Noise | None

    @property
    def squares(self) -> FloatArray:
        """Squared ΔE*ab of the patches, divided by what noise gives them on average."""
        assert self.noise is not None  # noqa: S101  # asked for with noise only
        shares = sum(
            is_noisy / reading.repeats[rows]
            for (reading, rows), is_noisy in zip(self._parts(), self.noise.is_noisy, strict=True)
        )
        expected = self.noise.value**2 * shares
        squares = np.square(self.difference[:, :3]).sum(axis=1)
        ratios: FloatArray = np.divide(
            squares, expected, out=np.where(squares > 0, np.inf, 0.0), where=expected > 0
        )
        return ratios

    def beyond_noise(self, *, any_of_all: bool = False) -> BooleanArray | None:
        """Return which patches changed by more than noise explains; None if it is not known.

        `any_of_all` bounds the chance that noise alone marks any patch, and not a given one.
        """
        if self.noise is None:
            return None
        chance = 1.0 - (1.0 - CHANCE) ** (1.0 / len(self.delta_e)) if any_of_all else CHANCE
        return np.asarray(self.squares > self.noise.bound(1, chance))

    @property
    def whole_is_beyond_noise(self) -> bool:
        """Whether the mean square of all patches is more than noise explains."""
        if self.noise is None:
            return False
        return float(self.squares.mean()) > self.noise.bound(len(self.delta_e), CHANCE)

    @property
    def larger_than_noise(self) -> bool | None:
        """Whether the whole or any patch changed by more than noise explains."""
        marked = self.beyond_noise(any_of_all=True)
        return None if marked is None else self.whole_is_beyond_noise or bool(marked.any())

    @property
    def names(self) -> list[str]:
        """Names of the patches in both readings."""
        return [self.first.patches[row] for row in self.rows[0]]

    @property
    def device(self) -> FloatArray:
        """Device values (n, k) of the patches in both readings."""
        device: FloatArray = self.first.device[self.rows[0]]
        return device

    def only_in(self, second: bool) -> list[str]:
        """Return the names of the patches of one reading that the other one does not have."""
        reading, rows = self._parts()[second]
        alone = np.setdiff1d(np.arange(len(reading.device)), rows)
        return [reading.patches[row] for row in alone]

    def _parts(self) -> tuple[tuple[Reading, Any], tuple[Reading, Any]]:
        return (self.first, self.rows[0]), (self.second, self.rows[1])


def reading_names(sources: Sequence[object], names: Sequence[str]) -> list[str]:
    """Return different names of the readings."""
    if names and len(names) != len(sources):
        raise OptionError.refusal(
            "names", list(names), f"{len(sources)} names, one for each reading"
        )
    titles = list(names)
    for number, source in enumerate(sources if not names else (), start=1):
        is_path = isinstance(source, str | os.PathLike)
        titles.append(Path(source).name if is_path else f"reading {number}")  # type: ignore[arg-type]
    counts = Counter(titles)
    return [
        f"{title} ({number})" if counts[title] > 1 else title
        for number, title in enumerate(titles, start=1)
    ]


def read_reading(source: object, name: str, options: Options) -> Reading:
    """Read measurements with device values, average the repeats, and name the patches."""
    content = content_of(source)
    with errors_in(source):
        samples = parsed_input(content, options, Limits())
        if not isinstance(samples, Samples):
            raise UnrecognisedFormatError(
                "The content is no reading: it has no measured patches.",
                remedy="Give measurements with device values: CGATS, CxF or CSV. gamut compare "
                "compares the gamuts of profiles, pictures and meshes.",
            )
        if samples.device is None:
            raise MissingColumnError(
                "The reading has no device values, by which patches are matched.",
                where={"field": "device"},
                remedy="Give a reading with the columns of the device, such as CMYK_C, CMYK_M, "
                "CMYK_Y and CMYK_K.",
            )
        patches = _patch_names(content, samples, options.condition)
        lines = samples.lines
        samples = consistent_samples(samples)
        if len(samples) < len(patches):  # failed readings of repeats are left out
            names = dict(zip([] if lines is None else lines.tolist(), patches, strict=False))
            used = [] if samples.lines is None else samples.lines.tolist()
            patches = [names[line] for line in used] or _patch_names(content, samples, None)
        colours = measured_colours(
            samples,
            "absolute",
            observer=options.observer,
            illuminant=options.illuminant,
            adaptation=options.adaptation or "Bradford",
        )
    assert samples.device is not None  # noqa: S101  # checked above
    groups = device_groups(samples.device)
    lab = np.array([colours.lab[rows].mean(axis=0) for rows in groups])
    rests = np.concatenate(
        [colours.lab[rows] - mean for rows, mean in zip(groups, lab, strict=True)]
    )
    scatter = float(np.square(rests).sum())
    return Reading(
        name,
        content,
        samples,
        colours,
        np.array([samples.device[rows].mean(axis=0) for rows in groups]),
        lab,
        np.array([len(rows) for rows in groups], dtype=np.float64),
        [patches[rows[0]] for rows in groups],
        scatter if scatter > EQUAL else 0.0,
        len(rests) - len(groups),
    )


def _patch_names(content: bytes, samples: Samples, condition: str | None) -> list[str]:
    """Return the names of the samples in a text; of other data and nameless rows, device values."""
    names = [device_text(values) for values in np.asarray(samples.device)]
    encoding = None if looks_like_xml(content) else text_encoding(content)
    if encoding is None or samples.lines is None:
        return names
    text = content.decode(encoding)
    if looks_like_cgats(text):
        header, cells = cgats_rows(text, condition=condition)
        rows = cells if len(cells) == len(names) else []
    else:
        lines = dict(DelimitedText(content, encoding).rows())
        header = next(iter(lines.values()), [])
        rows = [lines.get(int(line), []) for line in samples.lines]
    upper = [name.strip().upper().replace(" ", "_") for name in header]
    column = next((upper.index(name) for name in _NAME_COLUMNS if name in upper), None)
    if column is None:
        return names
    for number, row in enumerate(rows):
        if column < len(row) and row[column].strip():
            names[number] = row[column].strip()
    return names


def device_text(values: FloatArray) -> str:
    """Return device values in per cent."""
    return " ".join(number_text(100.0 * float(value), 4) for value in values)


def pair_readings(first: Reading, second: Reading, noise: float | None) -> ReadingPair:
    """Match the patches of two readings of one device, and return their differences.

    `noise` replaces that of the repeats.
    """
    from scipy.spatial import cKDTree  # noqa: PLC0415  # slow to import

    device = second.device[:, _order_of_channels(first, second)]
    away, nearest = map(np.asarray, cKDTree(first.device).query(device, p=np.inf))
    # the nearest patch of the second reading keeps a patch of the first one
    order = np.lexsort([away, nearest])
    is_best = np.ones(len(order), dtype=bool)
    is_best[1:] = nearest[order][1:] != nearest[order][:-1]
    rows = order[is_best & (away[order] <= SAME_PATCH)]
    if not len(rows):
        raise CharacterisationError(
            f"{first.name} and {second.name} have no patch in common: their device values are "
            f"{100.0 * away.min():.2g} % of a channel apart at least.",
            where={"file": second.name, "field": "device"},
            remedy="Give readings of the same chart, or of charts with common patches. Device "
            "values are matched within half a step of 8 bits.",
        )
    one, two = _common_scale(first, second)
    one, two = one[nearest[rows]], two[rows]
    chroma, other_chroma = (np.hypot(lab[:, 1], lab[:, 2]) for lab in (one, two))
    across = one[:, 1] * two[:, 2] - one[:, 2] * two[:, 1]
    turn = np.square(two[:, 1:] - one[:, 1:]).sum(axis=1) - np.square(other_chroma - chroma)
    hue = np.sign(across) * np.sqrt(np.maximum(turn, 0.0))
    return ReadingPair(
        first,
        second,
        (nearest[rows], rows),
        np.column_stack([two - one, other_chroma - chroma, hue]),
        delta_e_2000(one, two),
        _noise(noise, first, second),
    )


def _order_of_channels(first: Reading, second: Reading) -> list[int]:
    one, two = first.samples.channels, second.samples.channels
    if sorted(one) == sorted(two):
        return [two.index(channel) for channel in one]
    raise CharacterisationError(
        f"The readings are of different devices: {first.name} has the channels {', '.join(one)}, "
        f"{second.name} has {', '.join(two)}.",
        where={"file": second.name, "field": "channels"},
        remedy="Give readings of one device. If only the names of inks differ, name them with inks "
        "(--inks). gamut compare compares the gamuts of different devices.",
    )


def _common_scale(first: Reading, second: Reading) -> tuple[FloatArray, FloatArray]:
    """Return CIELAB of two readings; of displays, relative to the white of the first one."""
    if not (first.colours.as_measured and second.colours.as_measured):
        return first.lab, second.lab
    white = np.array(first.colours.provenance["white"], dtype=np.float64)
    white /= white[1]
    one, two = lab_to_xyz(first.lab), lab_to_xyz(second.lab)
    luminances = _luminances(first, second)
    if luminances is not None:
        two = two * (luminances[1] / luminances[0])
    adaptation = adaptation_matrix(white, ICC_D50, "Bradford").T
    return xyz_to_lab(one @ adaptation), xyz_to_lab(two @ adaptation)


def _luminances(first: Reading, second: Reading) -> tuple[float, float] | None:
    """Return the luminances of two whites in cd/m² or one unit; None if the files scale them."""
    stated = [part.colours.provenance.get("white_luminance") for part in (first, second)]
    if all(stated):
        return float(stated[0]), float(stated[1])  # type: ignore[arg-type]
    whites = [np.array(part.colours.provenance["white"])[1] for part in (first, second)]
    scaled = any(np.isclose(whites, value, rtol=0.005).any() for value in _SCALED_WHITES)
    return None if scaled else (float(whites[0]), float(whites[1]))


def _noise(value: float | None, *readings: Reading) -> Noise | None:
    """Return the noise that is given, or that of repeats; None if it is not known.

    A reading whose repeats are all equal is an average, such as published data, and has no noise.
    """
    if value is not None:
        return Noise(float(value), np.inf, "given")
    repeated = [reading for reading in readings if reading.scatter > 0.0]
    freedom = sum(reading.freedom for reading in repeated)
    if not freedom:
        return None
    variance = sum(reading.scatter for reading in repeated) / freedom
    source = f"{freedom} repeat{'s' * (freedom > 1)} in the readings"
    source += "".join(
        f"; equal repeats of {reading.name} are averages"
        for reading in readings
        if reading.freedom and not reading.scatter
    )
    first, second = (not reading.freedom or reading.scatter > 0.0 for reading in readings)
    return Noise(float(np.sqrt(variance)), freedom, source, (first, second))


def condition_warnings(readings: Sequence[Reading]) -> list[str]:
    """Return a warning for each condition that the readings state and in which they differ."""
    warnings = []
    for name in ("measurement condition", "medium", "illuminant", "observer", "backing"):
        values = {reading.name: stated_condition(reading, name) for reading in readings}
        if len({value for value in values.values() if value}) > 1:
            stated = ", ".join(
                f"{value or 'not stated'} ({title})" for title, value in values.items()
            )
            warnings.append(f"The readings differ in their {name}: {stated}.")
    first = readings[0]
    for reading in readings[1:]:
        both = first.colours.as_measured and reading.colours.as_measured
        if both and _luminances(first, reading) is None:
            warnings.append(
                f"{first.name} or {reading.name} does not state the luminance of its white: a "
                "change of it is not seen."
            )
    return warnings


def stated_condition(reading: Reading, name: str) -> str:
    """Return a condition as the file states it; empty if it does not."""
    if name == "measurement condition":
        return (reading.samples.condition or "").partition(",")[0]
    if name == "backing":
        stated = reading.samples.conditions
        texts = (f"{stated.get('SAMPLE_BACKING', '')} backing", reading.samples.condition or "")
        match = _BACKING.search(" ".join((*texts, *stated.values())))
        return match[1].lower() if match else ""
    text = str(reading.colours.provenance[name])
    return "" if "assumed" in text and name != "medium" else text.partition(" (")[0]
