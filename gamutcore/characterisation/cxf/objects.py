"""Objects and colour specifications of a CxF3 file.

An object has device values, measured colours, or both. Each colour refers to a colour
specification. The specification states the measurement condition (M0 to M3 of ISO 13655), the
backing, the illuminant and the observer. `gamutcore.characterisation.cxf` joins objects to samples.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from xml.etree.ElementTree import Element

import numpy as np

from gamutcore.arrays import FloatArray
from gamutcore.characterisation.conditions import condition_label
from gamutcore.characterisation.cxf.element_tree import element_line
from gamutcore.characterisation.spectra import FEWEST_BANDS, spans_the_visible_range
from gamutcore.characterisation.table import number
from gamutcore.errors import MalformedFileError

__all__ = ["ColourKey", "CxfObject", "Specification", "cxf_objects", "specifications"]

MAX_BANDS = 1000
MAX_NAME = 40
MAX_FACT = 500

_CONDITIONS = frozenset({"M0", "M1", "M2", "M3"})
_INKS = {"Cyan": "C", "Magenta": "M", "Yellow": "Y", "Black": "K"}
_DEVICES: dict[str, dict[str, str]] = {
    "ColorRGB": {"R": "R", "G": "G", "B": "B"},
    "ColorCMYK": _INKS,
    "ColorCMYKPlusN": _INKS,
    "ColorPantoneHexachrome": {**_INKS, "Orange": "O", "Green": "G"},
    "ColorCustom": {},
}
"""Elements of device values: their child elements and the channel names of these. Elements
``SpotColor`` add further channels."""

_COLOURS = {
    "ColorCIELab": ("lab", ("L", "A", "B")),
    "ColorCIELCh": ("lch", ("L", "C", "H")),
    "ColorCIEXYZ": ("xyz", ("X", "Y", "Z")),
    "ColorEmissiveCIEXYZ": ("xyz", ("X", "Y", "Z")),
    "ColorCIExyY": ("xyy", ("x", "y", "Y")),
    "ColorEmissiveCIExyY": ("xyy", ("x", "y", "Y")),
}
"""Elements of colours: the kind of colour and the child elements with its coordinates."""

_UNSET = frozenset({"", "-1"})
"""Values of tags that identify nothing. Software of X-Rite writes -1 for a missing SampleID."""

_SPECTRA = frozenset({"ReflectanceSpectrum", "TransmittanceSpectrum", "EmissiveSpectrum"})


@dataclass(frozen=True)
class Specification:
    """A colour specification: how colours were measured and computed.

    Attributes
    ----------
    condition : str or None
        ``"M0"`` to ``"M3"``; None if not stated.
    backing : str
        The material under the samples, in lower case.
    illuminant, observer : str
        Of the colours, such as ``"D50"`` and ``"2"``; empty if not stated.
    increment, start : float or None
        Step and first wavelength of spectra in nm.
    emissive : bool or None
        Whether the samples are lights; None if not stated.
    facts : dict
        Instrument and other notes, by keyword.
    """

    condition: str | None = None
    backing: str = ""
    illuminant: str = ""
    observer: str = ""
    increment: float | None = None
    start: float | None = None
    emissive: bool | None = None
    facts: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True, order=True)
class ColourKey:
    """Kind of a colour and its conditions; one object can have a colour for each key.

    `kind` is ``"lab"``, ``"lch"``, ``"xyz"``, ``"xyy"`` or ``"spectrum"``. Illuminant and observer
    are empty for spectra. `start` and `step` (in nm) and `bands` are zero for colours.
    """

    condition: str
    backing: str
    kind: str
    illuminant: str = ""
    observer: str = ""
    start: float = 0.0
    step: float = 0.0
    bands: int = 0


@dataclass(frozen=True, eq=False)
class CxfObject:
    """One object of a CxF3 file, at the line of its start tag.

    `identity` has the texts by which objects are joined: ``"sample"``, ``"location"``, ``"name"``.
    Device values range from 0 to 1. `colours` holds coordinates or spectral bands.
    """

    line: int
    identity: dict[str, str]
    measured: bool
    channels: tuple[str, ...]
    device: tuple[float, ...]
    colours: dict[ColourKey, FloatArray]


def specifications(root: Element) -> dict[str, Specification]:
    """Return the colour specifications of a file by their ids."""
    path = "Resources/ColorSpecificationCollection/ColorSpecification"
    return {entry.get("Id", ""): _specification(entry) for entry in root.iterfind(path)}


def _specification(entry: Element) -> Specification:
    def text(path: str) -> str:
        return (entry.findtext(path) or "").strip()[:MAX_FACT]

    device = "MeasurementSpec/Device/"
    span = entry.find("MeasurementSpec/WavelengthRange")
    kind = text("MeasurementSpec/MeasurementType")
    backing = text("MeasurementSpec/Backing")
    illuminant = text("TristimulusSpec/Illuminant")
    observer = text("TristimulusSpec/Observer")
    facts = {
        "MANUFACTURER": text(device + "Manufacturer"),
        "INSTRUMENTATION": text(device + "Model"),
        "SAMPLE_BACKING": backing,
        "MEASUREMENT_TYPE": kind,
        "FILTER": text(device + "DeviceFilter"),
    }
    if text(device + "DevicePolarization") in {"true", "1"}:
        condition: str | None = "M3"
    else:
        uv_excluded = "M2" if facts["FILTER"] == "Filter_UVExcluded" else ""
        condition = _condition(
            text(device + "DeviceIllumination"), uv_excluded, entry.get("Id", "")
        )
    return Specification(
        condition=condition,
        backing=backing.lower(),
        illuminant=illuminant.upper() if len(illuminant) <= MAX_NAME else "",
        observer=observer.partition("_")[0] if observer.endswith("_Degree") else "",
        increment=None if span is None else _number(span.get("Increment")),
        start=None if span is None else _number(span.get("StartWL")),
        emissive="Emissive" in kind if kind else None,
        facts={name: fact for name, fact in facts.items() if fact},
    )


def _condition(*texts: str) -> str | None:
    """Return the first measurement condition that the texts state."""
    return next((label for text in texts if (label := condition_label(text)) in _CONDITIONS), None)


def _number(text: str | None) -> float | None:
    """Return the number that a text spells; None unless it is a plain number below 10⁹."""
    if text is None or "," in text:
        return None
    try:
        value = number(text.strip())
    except ValueError:
        return None
    return value if abs(value) < 1e9 else None


def cxf_objects(root: Element) -> Iterator[CxfObject]:
    """Yield the objects of a file that have device values or colours.

    A value that is missing or no number raises an error with the line of its object.
    """
    specified = specifications(root)
    for entry in root.iterfind("Resources/ObjectCollection/Object"):
        line = element_line(entry)
        kind = entry.get("ObjectType", "")
        measured = "Measurement" in kind
        condition = _condition(kind) if measured else None
        channels, device = _device_values(entry, line)
        colours: dict[ColourKey, FloatArray] = {}
        for value in entry.iterfind("ColorValues/*"):
            identifier = value.get("ColorSpecification", "")
            specification = specified.get(
                identifier, Specification(condition=_condition(identifier))
            )
            read = _colour(value, specification, condition or specification.condition or "", line)
            if read is not None:
                colours.setdefault(*read)
        if device or colours:
            yield CxfObject(line, _identity(entry), measured, channels, device, colours)


def _identity(entry: Element) -> dict[str, str]:
    tags: dict[str, str] = {}
    for tag in entry.iterfind("TagCollection/Tag"):
        name = "".join(c for c in tag.get("Name", "").upper() if c.isalnum())
        value = tag.get("Value", "").strip()
        if value not in _UNSET:
            tags.setdefault(name, value)
    found = {}
    sample = tags.get("SAMPLEID") or tags.get("SAMPLENAME")
    if sample:
        found["sample"] = sample
    if tags.get("ROW") and tags.get("COLUMN"):
        found["location"] = "/".join(tags.get(name, "") for name in ("PAGE", "ROW", "COLUMN"))
    if entry.get("Name"):
        found["name"] = entry.get("Name", "")
    return found


def _device_values(entry: Element, line: int) -> tuple[tuple[str, ...], tuple[float, ...]]:
    """Return channel names and device values, 0 to 1, of the first known element."""
    for value in entry.iterfind("DeviceColorValues/*"):
        if value.tag not in _DEVICES:
            continue
        full = 100.0
        if value.tag == "ColorRGB":
            full = _number(value.findtext("MaxRange")) or 255.0
        parts = [(name, value.findtext(child)) for child, name in _DEVICES[value.tag].items()]
        parts += [
            ((spot.findtext("Name") or "?")[:MAX_NAME], spot.findtext("Percentage"))
            for spot in value.iterfind("SpotColor")
        ]
        if parts:
            names = tuple(name for name, _ in parts)
            return names, tuple(
                _required(text, f"device value {name}", line) / full for name, text in parts
            )
    return (), ()


def _required(text: str | None, what: str, line: int) -> float:
    value = _number(text)
    if value is None:
        problem = "is missing" if text is None else f"is {text[:40]!r}"
        raise MalformedFileError(
            f"The {what} of an object {problem}.",
            where={"line": line, "field": what},
            remedy="Every colour and device value must be a plain, finite number.",
        )
    return value


def _colour(
    value: Element, specification: Specification, condition: str, line: int
) -> tuple[ColourKey, FloatArray] | None:
    if value.tag in _COLOURS:
        kind, coordinates = _COLOURS[value.tag]
        numbers = [_required(value.findtext(c), f"{value.tag} {c}", line) for c in coordinates]
        return ColourKey(
            condition,
            specification.backing,
            kind,
            illuminant=specification.illuminant,
            observer=specification.observer,
        ), np.array(numbers)
    if value.tag not in _SPECTRA:
        return None
    bands = _spectrum(value, line)
    start = _number(value.get("StartWL")) or specification.start
    step = specification.increment or 10.0
    if start is None or not 1.0 <= step <= 100.0 or not 100.0 <= start <= 1000.0:
        raise MalformedFileError(
            "The wavelengths of a spectrum are missing, or outside 100 to 1000 nm.",
            where={"line": line, "field": "StartWL"},
            remedy="State StartWL with the spectrum, and StartWL and Increment in nm in the "
            "WavelengthRange of its specification.",
        )
    if len(bands) < FEWEST_BANDS or not spans_the_visible_range(
        (start, start + step * (len(bands) - 1))
    ):
        raise MalformedFileError(
            f"A spectrum of {len(bands)} bands from {start:g} nm in steps of {step:g} nm does not "
            "span the visible range.",
            where={"line": line, "field": value.tag},
            remedy="State the right Increment in the WavelengthRange of its specification.",
        )
    return ColourKey(
        condition, specification.backing, "spectrum", start=start, step=step, bands=len(bands)
    ), bands


def _spectrum(value: Element, line: int) -> FloatArray:
    words = (value.text or "").split()
    try:
        numbers = np.array([float(word) for word in words[: MAX_BANDS + 1]])
    except ValueError:
        numbers = np.empty(0)
    # float() also accepts nan, inf and underscores.
    plain = 0 < len(numbers) <= MAX_BANDS and "_" not in (value.text or "")
    if not plain or not np.isfinite(numbers).all():
        raise MalformedFileError(
            f"A spectrum is not a list of 1 to {MAX_BANDS} finite numbers.",
            where={"line": line, "field": value.tag},
            remedy=f"A spectrum is {FEWEST_BANDS} to {MAX_BANDS} numbers, separated by spaces.",
        )
    return numbers
