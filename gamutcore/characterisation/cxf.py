"""Samples from CxF3 files (.cxf, .mxf, .txf; ISO 17972-1): the XML within limits, and its objects.

Expat is driven directly, because only its own handlers report line numbers and can stop a hostile
file. Document type declarations are refused, and with them every entity. Depth, elements,
attributes and text are limited before the tree grows. Sections of vendors are skipped.

A file has device values and measurements as separate objects. Each colour refers to a colour
specification, which states the measurement condition (M0 to M3 of ISO 13655), the backing, the
illuminant and the observer. Tags join the objects: SampleID, or the position on the chart. A file
measured under M0, M1 and M2 holds three characterisations, and the caller chooses one of them.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NoReturn
from xml.etree.ElementTree import Element, TreeBuilder
from xml.parsers import expat

import numpy as np

from gamutcore.arrays import FloatArray
from gamutcore.characterisation.columns import (
    COLOUR_NAMES,
    FEWEST_BANDS,
    MAX_CHANNELS,
    ColumnRoles,
    chosen_condition,
    condition_label,
    spans_the_visible_range,
)
from gamutcore.characterisation.samples import Samples, samples_from_values
from gamutcore.characterisation.text import number
from gamutcore.errors import (
    MalformedFileError,
    MissingColumnError,
    SampleLimitError,
    UnrecognisedFormatError,
)

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping
    from xml.etree.ElementTree import Element

    from gamutcore.errors import Where

__all__ = ["cxf_samples", "looks_like_cxf", "looks_like_xml"]

CXF_NAMESPACE = "http://colorexchangeformat.com/CxF3-core"

MAX_ELEMENTS = 400_000
"""Maximum number of elements, skipped ones included: 22,000 patches under one condition. This many
take 1.5 s; a fuzz test allows 2 s."""

MAX_DEPTH = 32
"""Maximum depth. Outside vendors' sections, the schema has at most nine levels."""

MAX_ATTRIBUTES = 1000
"""Maximum number of attributes of an element. The schema has at most 5, but vendors add elements of
their own: X-Rite's i1Profiler writes one with 54."""

MAX_ATTRIBUTE_LENGTH = 10_000
MAX_TEXT_LENGTH = 100_000
MAX_TEXT_TOTAL = 16_000_000

_SKIPPED = frozenset({"CustomResources", "ProfileCollection"})
"""Elements that are skipped with their content, as all elements of other namespaces are."""

_LINE = ":line"
"""Key of the line number among the attributes. No attribute of a file can have this name."""

_START = re.compile(rb"(?:\xef\xbb\xbf)?\s*<")
_ROOT = re.compile(r"<(?:[\w.-]+:)?CxF[\s>/]")


def looks_like_xml(data: bytes) -> bool:
    r"""Return whether bytes begin as an XML or HTML document does.

    Examples
    --------
    >>> looks_like_xml(b"\n<a/>"), looks_like_xml(b"1 < 2")
    (True, False)
    """
    if data.startswith((b"\xff\xfe<\0", b"\xfe\xff\0<")):
        return True
    return _START.match(data[:1000]) is not None


def looks_like_cxf(data: bytes) -> bool:
    """Return whether an XML document contains a ``CxF`` element near its start."""
    start = data[:100_000]
    utf16 = start.startswith((b"\xff\xfe", b"\xfe\xff"))
    text = start.decode("utf-16" if utf16 else "latin-1", "replace")
    return _ROOT.search(text) is not None


class _TreeParser:
    """Expat handlers that build an element tree, without namespaces, and enforce the limits.

    A fault of the XML or an exceeded limit raises an error with line and column in ``where``.
    """

    def __init__(self) -> None:
        self.builder = TreeBuilder()
        self.depth = 0
        self.skipped_from = 0
        self.elements = 0
        self.text_length = 0
        self.text_total = 0
        self.expat = expat.ParserCreate(namespace_separator="}")
        self.expat.buffer_text = True
        self.expat.StartDoctypeDeclHandler = self._refuse_declaration
        self.expat.EntityDeclHandler = self._refuse_declaration
        self.expat.StartElementHandler = self._start
        self.expat.EndElementHandler = self._end
        self.expat.CharacterDataHandler = self._add_text

    def read(self, data: bytes) -> Element:
        try:
            self.expat.Parse(data, True)
        except expat.ExpatError as error:
            raise MalformedFileError(
                f"The XML is not well formed: {expat.ErrorString(error.code)}.",
                where={"line": error.lineno, "column": error.offset + 1},
                remedy="Send the file as the measuring software wrote it.",
            ) from None
        except (LookupError, ValueError) as error:
            raise MalformedFileError(
                f"The XML declares an unknown encoding: {str(error)[:80]}.",
                where={"line": 1},
                remedy="Write the file in UTF-8.",
            ) from None
        root: Element = self.builder.close()
        return root

    def _place(self) -> Where:
        return {
            "line": self.expat.CurrentLineNumber,
            "column": self.expat.CurrentColumnNumber + 1,
        }

    def _refuse(self, message: str) -> NoReturn:
        raise MalformedFileError(
            message,
            where=self._place(),
            remedy="Send plain elements with short texts and without a document type declaration.",
        )

    def _refuse_declaration(self, *_: object) -> NoReturn:
        self._refuse("The XML has a document type declaration.")

    def _start(self, name: str, attributes: Mapping[str, str]) -> None:
        self.depth += 1
        self.elements += 1
        if self.depth > MAX_DEPTH:
            self._refuse(f"The XML is nested more than {MAX_DEPTH} levels deep.")
        if self.elements > MAX_ELEMENTS:
            raise SampleLimitError(
                f"The file has more than {MAX_ELEMENTS} elements.",
                where=self._place(),
                remedy="Send fewer patches, or send the measurements as CGATS text.",
            )
        namespace, _, local = name.rpartition("}")
        if self.depth == 1 and (local != "CxF" or namespace != CXF_NAMESPACE):
            raise UnrecognisedFormatError(
                f"The XML is not a CxF3 file: its root is {local[:40]} of {namespace[:80] or 'no'} "
                "namespace.",
                where=self._place(),
                remedy=f"The root of a CxF3 file is CxF, of {CXF_NAMESPACE}.",
            )
        if not self.skipped_from and (local in _SKIPPED or namespace != CXF_NAMESPACE):
            self.skipped_from = self.depth
        if attributes:
            self._check_attributes(attributes)
        if not self.skipped_from:
            self.text_length = 0
            builder_attributes = dict(attributes)
            if local == "Object":
                builder_attributes[_LINE] = str(self.expat.CurrentLineNumber)
            self.builder.start(local, builder_attributes)

    def _check_attributes(self, attributes: Mapping[str, str]) -> None:
        if len(attributes) > MAX_ATTRIBUTES:
            self._refuse(
                f"An element has {len(attributes)} attributes, more than {MAX_ATTRIBUTES}."
            )
        if max(map(len, attributes.values())) > MAX_ATTRIBUTE_LENGTH:
            self._refuse(f"One of the attributes has more than {MAX_ATTRIBUTE_LENGTH} characters.")

    def _add_text(self, text: str) -> None:
        if self.skipped_from:
            return
        self.text_length += len(text)
        self.text_total += len(text)
        if self.text_length > MAX_TEXT_LENGTH or self.text_total > MAX_TEXT_TOTAL:
            self._refuse(
                f"An element has a text of more than {MAX_TEXT_LENGTH} characters, or all texts "
                f"together have more than {MAX_TEXT_TOTAL}."
            )
        self.builder.data(text)

    def _end(self, name: str) -> None:
        if not self.skipped_from:
            self.text_length = 0
            self.builder.end(name.rpartition("}")[2])
        elif self.depth == self.skipped_from:
            self.skipped_from = 0
        self.depth -= 1


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

    `condition` is ``"M0"`` to ``"M3"``; `backing` is in lower case; `illuminant` and `observer` are
    such as ``"D50"`` and ``"2"``. `increment` and `start` of spectra are in nm. `emissive` says
    whether the samples are lights. What is not stated is None or empty. `facts` has notes by
    keyword.
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


def cxf_objects(root: Element, specified: Mapping[str, Specification]) -> Iterator[CxfObject]:
    """Yield the objects of a file that have device values or colours.

    A value that is missing or no number raises an error with the line of its object.
    """
    for entry in root.iterfind("Resources/ObjectCollection/Object"):
        line = int(entry.get(_LINE, "1"))
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
            yield CxfObject(line, _identities(entry), measured, channels, device, colours)


def _identities(entry: Element) -> dict[str, str]:
    tags: dict[str, str] = {}
    for tag in entry.iterfind("TagCollection/Tag"):
        name = "".join(c for c in tag.get("Name", "").upper() if c.isalnum())
        value = tag.get("Value", "").strip()
        if value not in _UNSET:
            tags.setdefault(name, value)
    identities = {}
    sample = tags.get("SAMPLEID") or tags.get("SAMPLENAME")
    if sample:
        identities["sample"] = sample
    if tags.get("ROW") and tags.get("COLUMN"):
        identities["location"] = "/".join(tags.get(name, "") for name in ("PAGE", "ROW", "COLUMN"))
    if entry.get("Name"):
        identities["name"] = entry.get("Name", "")
    return identities


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


_IDENTITIES = {"sample": "SampleID", "location": "Page, Row and Column", "name": "Name"}
"""Keys by which objects are joined, the most reliable first, with their names in errors. A key is
not used if two objects with one value of the key have different device values."""


def cxf_samples(data: bytes, *, condition: str | None = None) -> Samples:
    """Return the samples in a CxF3 file under one measurement condition.

    Device values and measurements are joined by SampleID, else by page, row and column, else by
    name. Without any device values, all colours are samples. Errors have the line in ``where``.
    """
    root = _TreeParser().read(data)
    specified = specifications(root)
    objects = list(cxf_objects(root, specified))
    # If some objects are named measurements, the colours of targets are aims or previews.
    measurements = [entry for entry in objects if entry.measured and entry.colours]
    measurements = measurements or [entry for entry in objects if entry.colours]
    if not measurements:
        raise MissingColumnError(
            "The CxF file has no object with a measured colour or spectrum.",
            where={"field": "ObjectCollection"},
            remedy="Export the measurements, not the targets alone, as CxF3.",
        )
    labels, label = _labels(measurements, condition)
    targets = [entry for entry in objects if entry.device]
    rows, dropped = _joined(targets, measurements, labels, label)
    return _samples(root, specified, rows, labels, label, dropped)


def _labels(
    measurements: Iterable[CxfObject], asked: str | None
) -> tuple[dict[tuple[str, str], str | None], str | None]:
    """Return the name of each pair of condition and backing, and the name to use."""
    pairs = dict.fromkeys(
        (key.condition, key.backing) for entry in measurements for key in entry.colours
    )
    backings = {backing for _, backing in pairs}
    labels: dict[tuple[str, str], str | None] = {}
    for condition, backing in pairs:
        label = condition or None
        if len(backings) > 1 and backing:
            label = f"{condition}, {backing} backing" if condition else f"{backing} backing"
        labels[condition, backing] = label
    return labels, chosen_condition(labels.values(), asked)


def _joined(
    targets: list[CxfObject],
    measurements: list[CxfObject],
    labels: dict[tuple[str, str], str | None],
    label: str | None,
) -> tuple[list[tuple[CxfObject | None, CxfObject]], int]:
    """Return targets with their measurements of one condition, and the number left unmatched."""
    wanted = [
        entry
        for entry in measurements
        if any(labels[key.condition, key.backing] == label for key in entry.colours)
    ]
    if not targets:
        return [(None, entry) for entry in wanted], 0
    alone = [entry for entry in wanted if not entry.device]
    rows: list[tuple[CxfObject | None, CxfObject]] = [(e, e) for e in wanted if e.device]
    if not alone:
        return rows, len(targets) - len(rows)
    best: list[tuple[CxfObject | None, CxfObject]] = []
    clashes: list[MalformedFileError] = []
    for identity in _IDENTITIES:
        try:
            pairs = _pairs(targets, alone, identity)
        except MalformedFileError as clash:
            clashes.append(clash)
            continue
        if len(pairs) > len(best):
            best = pairs
        if len(best) == len(alone):
            break
    if not best:
        if clashes:
            raise clashes[0]
        raise MissingColumnError(
            "No measurement matches any of the device values.",
            where={"line": alone[0].line, "field": "TagCollection"},
            remedy="Give the objects of one patch the same tag SampleID, or the same tags Page, "
            "Row and Column.",
        )
    rows += best
    used = {id(target) for target, _ in rows}
    unmeasured = sum(id(target) not in used for target in targets)
    return rows, unmeasured + len(alone) - len(best)


def _pairs(
    targets: list[CxfObject], measurements: list[CxfObject], identity: str
) -> list[tuple[CxfObject | None, CxfObject]]:
    known: dict[str, CxfObject] = {}
    for target in targets:
        name = target.identity.get(identity)
        if name is None:
            continue
        other = known.setdefault(name, target)
        if other.device != target.device:
            field = _IDENTITIES[identity]
            raise MalformedFileError(
                f"Two objects with the {field} {name[:40]} have different device values.",
                where={"line": target.line, "field": field},
                remedy="Each device value needs a SampleID of its own, or a Page, Row and Column "
                "of its own.",
            )
    return [
        (known[name], entry)
        for entry in measurements
        if (name := entry.identity.get(identity)) is not None and name in known
    ]


def _samples(
    root: Element,
    specified: Mapping[str, Specification],
    rows: list[tuple[CxfObject | None, CxfObject]],
    labels: dict[tuple[str, str], str | None],
    label: str | None,
    dropped: int,
) -> Samples:
    counts = Counter(
        key
        for _, entry in rows
        for key in entry.colours
        if labels[key.condition, key.backing] == label
    )
    keys = _used_keys([key for key, count in counts.items() if count == len(rows)])
    if not keys:
        (most, _), *_ = counts.most_common(1)
        lacking = next(entry for _, entry in rows if most not in entry.colours)
        raise MalformedFileError(
            f"The objects have no kind of colour in common. This object has no {most.kind}.",
            where={"line": lacking.line, "field": "ColorValues"},
            remedy="Give every measurement the same kind of colour, or a spectrum of the same "
            "wavelengths.",
        )
    channels = _channels(rows)
    values = np.array(
        [
            np.concatenate([target.device if target else (), *(entry.colours[key] for key in keys)])
            for target, entry in rows
        ]
    )
    roles = _roles(channels, keys, label)
    used = [
        entry
        for entry in specified.values()
        if labels.get((entry.condition or "", entry.backing)) == label
    ]
    conditions = _conditions(root, keys)
    for specification in used:
        conditions = {**specification.facts, **conditions}
    emissive = {entry.emissive for entry in used} - {None}
    kind = "unknown"
    if len(emissive) == 1:
        kind = "emission" if True in emissive else "reflectance"
        conditions["DEVICE_CLASS"] = "DISPLAY" if True in emissive else "OUTPUT"
    warnings = []
    if dropped:
        warnings.append(
            f"{dropped} objects have only device values or only measurements; they are not used."
        )
    return samples_from_values(
        "cxf",
        roles,
        values,
        lines=np.array([entry.line for _, entry in rows], dtype=np.int64),
        conditions=conditions,
        spectra_kind=kind,
        dropped=dropped,
        warnings=warnings,
    )


def _used_keys(keys: list[ColourKey]) -> list[ColourKey]:
    """Return one key per kind of colour, D50 and 2° preferred."""
    order = sorted(
        keys, key=lambda key: ((key.illuminant, key.observer) != ("D50", "2"), -key.bands)
    )
    used: dict[str, ColourKey] = {}
    for key in order:
        used.setdefault(key.kind, key)
    if "lab" in used:
        used.pop("lch", None)
    if "xyz" in used:
        used.pop("xyy", None)
    # Samples have one illuminant. Colours for another one are left out.
    first = next((key for key in used.values() if key.kind != "spectrum"), None)
    light = (first.illuminant, first.observer) if first is not None else None
    return [
        used[kind]
        for kind in ("lab", "lch", "xyz", "xyy", "spectrum")
        if kind in used
        and (kind == "spectrum" or (used[kind].illuminant, used[kind].observer) == light)
    ]


def _channels(rows: list[tuple[CxfObject | None, CxfObject]]) -> tuple[str, ...]:
    first = rows[0][0]
    channels = first.channels if first is not None else ()
    if len(channels) > MAX_CHANNELS:
        raise SampleLimitError(
            f"The device has {len(channels)} channels, more than {MAX_CHANNELS}.",
            where={"field": "DeviceColorValues"},
            remedy=f"Send the data of a device with at most {MAX_CHANNELS} channels.",
        )
    for target, _ in rows:
        if target is not None and target.channels != channels:
            raise MalformedFileError(
                f"This object has the channels {', '.join(target.channels)}; others have "
                f"{', '.join(channels)}.",
                where={"line": target.line, "field": "DeviceColorValues"},
                remedy="Send the measurements of one device.",
            )
    if len(set(channels)) != len(channels):
        raise MalformedFileError(
            f"A device channel appears twice among {', '.join(channels)}.",
            where={"line": rows[0][1].line, "field": "DeviceColorValues"},
            remedy="Name each ink once.",
        )
    return channels


def _roles(channels: tuple[str, ...], keys: list[ColourKey], label: str | None) -> ColumnRoles:
    names = [*channels]
    colours: dict[str, tuple[int, ...]] = {}
    wavelengths: tuple[float, ...] = ()
    for key in keys:
        if key.kind == "spectrum":
            wavelengths = tuple(key.start + key.step * band for band in range(key.bands))
            new = [f"SPEC_{wavelength:g}" for wavelength in wavelengths]
        else:
            new = list(COLOUR_NAMES[key.kind])
        colours[key.kind] = tuple(range(len(names), len(names) + len(new)))
        names += new
    return ColumnRoles(
        names=tuple(names),
        channels=channels,
        device=tuple(range(len(channels))),
        colours=colours,
        wavelengths=wavelengths,
        condition=label,
    )


def _conditions(root: Element, keys: list[ColourKey]) -> dict[str, str]:
    texts = {
        "CREATOR": root.findtext("FileInformation/Creator"),
        "DESCRIPTION": root.findtext("FileInformation/Description"),
    }
    colour = next((key for key in keys if key.kind != "spectrum"), None)
    if colour is not None:
        texts["ILLUMINANT"] = colour.illuminant
        texts["OBSERVER"] = f"{colour.observer} degree" if colour.observer else None
    return {name: text for name, text in texts.items() if text}
