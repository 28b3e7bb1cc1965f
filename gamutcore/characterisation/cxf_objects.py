"""What the objects of a CxF3 file hold: device values, and colours under their conditions.

An object has device values, measured colours, or both. Each colour names a colour specification,
which says how it was measured (ISO 13655's M0 to M3, the backing) and for which illuminant and
observer it was computed. This module reads single objects; `cxf` joins them into samples.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from gamutcore.characterisation.conditions import condition_label
from gamutcore.characterisation.spectra import FEWEST_BANDS, spans_the_visible_range
from gamutcore.errors import MalformedFileError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from gamutcore.arrays import FloatArray
    from gamutcore.characterisation.cxf_document import CxfDocument

__all__ = ["ColourKey", "CxfObject", "Specification", "cxf_objects", "specifications"]

MAX_BANDS = 1000
MAX_NAME = 40

_INKS = ("cyan", "magenta", "yellow", "black")
_HEXACHROME = (*_INKS, "orange", "green")
_FILTERS = {"Filter_UVExcluded": "M2"}
_KINDS = {
    "ColorCielab": ("lab", ("l", "a", "b")),
    "ColorCielch": ("lch", ("l", "c", "h")),
    "ColorCiexyz": ("xyz", ("x", "y", "z")),
    "ColorEmissiveCiexyz": ("xyz", ("x", "y", "z")),
    "ColorCiexyY": ("xyy", ("x", "y", "colorexchangeformat_com_cx_f3_core_y")),
    "ColorEmissiveCiexyY": ("xyy", ("x", "y", "colorexchangeformat_com_cx_f3_core_y")),
}


@dataclass(frozen=True)
class Specification:
    """A colour specification: how colours were measured and computed.

    Parameters
    ----------
    condition : str or None
        ``"M0"`` to ``"M3"``, or None where it is not said.
    backing : str
        What lay under the samples, as the file says it.
    illuminant, observer : str
        What colours were computed for, ``"D50"`` and ``"2"``; empty where it is not said.
    increment : float or None
        Step of spectra in nm.
    start : float or None
        First wavelength of spectra in nm.
    emissive : bool or None
        Whether lights were measured; None where it is not said.
    facts : dict
        Instrument and so on, by keyword.
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
    """What distinguishes the colours that one object can have.

    Parameters
    ----------
    condition : str
        The measurement condition, empty where it is not said.
    backing : str
    kind : str
        ``"lab"``, ``"lch"``, ``"xyz"``, ``"xyy"`` or ``"spectrum"``.
    illuminant, observer : str
        Of colours; empty for spectra.
    start, step, bands : float, float, int
        Of spectra; zero for colours.
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
    """One object of a CxF3 file.

    Parameters
    ----------
    line : int
        Where it starts.
    identity : dict
        Texts that join it with others: ``"sample"``, ``"location"``, ``"name"``; those it has.
    measured : bool
        Whether the file calls it a measurement.
    channels : tuple of str
        Channel names of its device values; empty if it has none.
    device : tuple of float
        Device values, 0 to 1.
    colours : dict
        From `ColourKey` to numbers.
    """

    line: int
    identity: dict[str, str]
    measured: bool
    channels: tuple[str, ...]
    device: tuple[float, ...]
    colours: dict[ColourKey, FloatArray]


def specifications(document: CxfDocument) -> dict[str, Specification]:
    """Return the colour specifications of a file by their ids.

    Parameters
    ----------
    document : CxfDocument

    Returns
    -------
    dict
    """
    collection = getattr(document.root.resources, "color_specification_collection", None)
    found = {}
    for entry in getattr(collection, "color_specification", ()):
        identifier = str(entry.id or "")
        found[identifier] = _specification(entry, identifier)
    return found


def _specification(entry: Any, identifier: str) -> Specification:  # noqa: ANN401 (colour-cxf's)
    measurement, tristimulus = entry.measurement_spec, entry.tristimulus_spec
    device = getattr(measurement, "device", None)
    span = getattr(measurement, "wavelength_range", None)
    kind = _text(getattr(measurement, "measurement_type", None))
    illuminant = _text(getattr(tristimulus, "illuminant_or_custom_illuminant", None))
    observer = _text(getattr(tristimulus, "observer", None))
    facts = {
        "MANUFACTURER": _text(getattr(device, "manufacturer", None)),
        "INSTRUMENTATION": _text(getattr(device, "model", None)),
        "SAMPLE_BACKING": _text(getattr(measurement, "backing", None)),
        "MEASUREMENT_TYPE": kind,
        "FILTER": _text(getattr(device, "device_filter", None)),
    }
    return Specification(
        condition=_condition(device, identifier),
        backing=facts["SAMPLE_BACKING"].strip().lower(),
        illuminant=illuminant.upper() if len(illuminant) <= MAX_NAME else "",
        observer=observer.partition("_")[0] if observer.endswith("_Degree") else "",
        increment=_number(getattr(span, "increment", None)),
        start=_number(getattr(span, "start_wl", None)),
        emissive="Emissive" in kind if kind else None,
        facts={name: text for name, text in facts.items() if text},
    )


def _condition(device: Any, identifier: str) -> str | None:  # noqa: ANN401 (colour-cxf's Device)
    if getattr(device, "device_polarization", None) is True:
        return "M3"
    for text in (
        _text(getattr(device, "device_illumination", None)),
        _FILTERS.get(_text(getattr(device, "device_filter", None)), ""),
        identifier,
    ):
        label = condition_label(text)
        if label in {"M0", "M1", "M2", "M3"}:
            return label
    return None


def _text(value: Any) -> str:  # noqa: ANN401 (texts, enumerations, and elements around them)
    for _ in range(3):
        if isinstance(value, str):
            return value[:500]
        value = getattr(value, "value", None)
    return ""


def _number(value: object) -> float | None:
    # Texts that are no numbers, and infinities, are none.
    if isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e9:
        return float(value)
    return None


def cxf_objects(document: CxfDocument) -> Iterator[CxfObject]:
    """Yield the objects of a file that have device values or colours.

    Parameters
    ----------
    document : CxfDocument

    Yields
    ------
    CxfObject

    Raises
    ------
    MalformedFileError
        A value is missing or no number; the error has the line of its object.
    """
    specified = specifications(document)
    collection = getattr(document.root.resources, "object_collection", None)
    objects = getattr(collection, "object_value", ())
    for number, entry in enumerate(objects):
        line = document.lines[number] if number < len(document.lines) else 1
        kind = str(entry.object_type or "")
        channels, device = _device_values(entry.device_color_values, line)
        by_type = condition_label(kind) if "Measurement" in kind else ""
        colours: dict[ColourKey, FloatArray] = {}
        for value in getattr(entry.color_values, "choice", ()):
            specification = specified.get(
                value.color_specification or "",
                Specification(condition=_condition(None, value.color_specification or "")),
            )
            read = _colour(value, specification, by_type, document, line)
            if read is not None:
                colours.setdefault(*read)
        if device or colours:
            measured = "Measurement" in kind
            yield CxfObject(line, _identity(entry), measured, channels, device, colours)


def _identity(entry: Any) -> dict[str, str]:  # noqa: ANN401 (colour-cxf's Object)
    tags: dict[str, str] = {}
    for collection in entry.tag_collection:
        for tag in collection.tag:
            name = "".join(c for c in (tag.name or "").upper() if c.isalnum())
            tags.setdefault(name, (tag.value or "").strip())
    found = {}
    sample = tags.get("SAMPLEID") or tags.get("SAMPLENAME")
    if sample:
        found["sample"] = sample
    if tags.get("ROW") and tags.get("COLUMN"):
        found["location"] = "/".join(tags.get(name, "") for name in ("PAGE", "ROW", "COLUMN"))
    if entry.name:
        found["name"] = str(entry.name)
    return found


def _device_values(values: Any, line: int) -> tuple[tuple[str, ...], tuple[float, ...]]:  # noqa: ANN401
    for value in getattr(values, "choice", ()):
        kind = type(value).__name__
        if kind == "ColorRgb":
            full = _number(value.max_range) or 255.0
            parts = [(n.upper(), getattr(value, n)) for n in ("r", "g", "b")]
        elif kind in {"ColorCmyk", "ColorCmykplusN", "ColorPantoneHexachrome", "ColorCustom"}:
            full = 100.0
            names = {"ColorPantoneHexachrome": _HEXACHROME, "ColorCustom": ()}.get(kind, _INKS)
            parts = [("K" if n == "black" else n[0].upper(), getattr(value, n)) for n in names]
            parts += [
                (str(spot.name or "?")[:MAX_NAME], spot.percentage)
                for spot in getattr(value, "spot_color", ())
            ]
        else:
            continue
        if parts:
            numbers = [_required(number, f"device value {name}", line) for name, number in parts]
            return tuple(name for name, _ in parts), tuple(n / full for n in numbers)
    return (), ()


def _required(value: object, what: str, line: int) -> float:
    number = _number(value)
    if number is None:
        problem = "is missing" if value is None else f"is {str(value)[:40]!r}"
        raise MalformedFileError(
            f"The {what} of an object {problem}.",
            where={"line": line, "field": what},
            remedy="Every colour and device value must be a plain, finite number.",
        )
    return number


def _colour(
    value: Any,  # noqa: ANN401 (one of colour-cxf's colours)
    specification: Specification,
    by_type: str,
    document: CxfDocument,
    line: int,
) -> tuple[ColourKey, FloatArray] | None:
    condition = by_type if by_type in {"M0", "M1", "M2", "M3"} else specification.condition or ""
    kind = type(value).__name__
    if kind in _KINDS:
        name, members = _KINDS[kind]
        numbers = [_required(getattr(value, m), f"{kind} {m[-1]}", line) for m in members]
        return ColourKey(
            condition,
            specification.backing,
            name,
            illuminant=specification.illuminant,
            observer=specification.observer,
        ), np.array(numbers)
    if not kind.endswith("Spectrum"):
        return None
    bands = _spectrum(value, document, line)
    start = _number(value.start_wl) or specification.start
    step = specification.increment or 10.0
    if start is None or not 1.0 <= step <= 100.0 or not 100.0 <= start <= 1000.0:
        raise MalformedFileError(
            "The wavelengths of a spectrum are not stated, or not those of light.",
            where={"line": line, "field": "StartWL"},
            remedy="State StartWL with the spectrum, and StartWL and Increment in nm in the "
            "WavelengthRange of its specification.",
        )
    if len(bands) < FEWEST_BANDS or not spans_the_visible_range(
        (start, start + step * (len(bands) - 1))
    ):
        raise MalformedFileError(
            f"A spectrum has {len(bands)} bands from {start:g} nm in steps of {step:g} nm, which "
            "do not span the visible range.",
            where={"line": line, "field": kind},
            remedy="State the right Increment in the WavelengthRange of its specification.",
        )
    return ColourKey(
        condition, specification.backing, "spectrum", start=start, step=step, bands=len(bands)
    ), bands


def _spectrum(value: Any, document: CxfDocument, line: int) -> FloatArray:  # noqa: ANN401
    place = value.value[0] if value.value else None
    words = document.spectra[int(place)].split() if isinstance(place, int | float) else []
    try:
        numbers = [float(word) for word in words[: MAX_BANDS + 1]]
    except ValueError:
        numbers = []
    # float() knows nan, inf and underscores too
    plain = bool(numbers) and not any("_" in word for word in words)
    if not plain or len(numbers) > MAX_BANDS or not np.isfinite(numbers).all():
        raise MalformedFileError(
            "A spectrum holds something else than plain numbers, or none, or too many.",
            where={"line": line, "field": type(value).__name__},
            remedy=f"A spectrum is 8 to {MAX_BANDS} numbers, separated by spaces.",
        )
    return np.array(numbers)
