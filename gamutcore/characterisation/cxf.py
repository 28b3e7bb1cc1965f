"""Samples from CxF3 files (.cxf, .mxf, .txf; ISO 17972-1), read by colour-cxf.

Such files have device values and measurements as separate objects that know each other by a tag:
SampleID, or the place on the chart. They are joined here, condition by condition: a file measured
under M0, M1 and M2 holds three characterisations, of which one has to be chosen.
"""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

import numpy as np

from gamutcore.characterisation.columns import ColumnRoles
from gamutcore.characterisation.conditions import chosen_condition
from gamutcore.characterisation.cxf_document import cxf_document, looks_like_cxf, looks_like_xml
from gamutcore.characterisation.cxf_objects import (
    ColourKey,
    CxfObject,
    cxf_objects,
    specifications,
)
from gamutcore.characterisation.samples import Samples, samples_from_values
from gamutcore.errors import MalformedFileError, MissingColumnError, SampleLimitError

if TYPE_CHECKING:
    from collections.abc import Iterable

    from gamutcore.characterisation.cxf_document import CxfDocument

__all__ = ["cxf_samples", "looks_like_cxf", "looks_like_xml"]

MAX_CHANNELS = 15
"""Channels of a device at most, as in ICC profiles (ICC.1:2022, 7.2.8)."""

_NAMES = {
    "lab": ("LAB_L", "LAB_A", "LAB_B"),
    "lch": ("LCH_L", "LCH_C", "LCH_H"),
    "xyz": ("XYZ_X", "XYZ_Y", "XYZ_Z"),
    "xyy": ("XYY_X", "XYY_Y", "XYY_CAPY"),
}
_IDENTITIES = ("sample", "location", "name")
"""What objects are joined by, the surest first."""


def cxf_samples(data: bytes, *, condition: str | None = None) -> Samples:
    """Return the samples in a CxF3 file.

    Parameters
    ----------
    data : bytes
        The file.
    condition : str, optional
        The measurement condition whose samples are wanted, if the file has several.

    Returns
    -------
    Samples
        Objects with device values, each with the measurements of its SampleID, else of its page,
        row and column, else of its name; without any device values, all colours.

    Raises
    ------
    UnrecognisedFormatError
        The XML is of another schema.
    MissingColumnError
        No object has a colour, or none of those that have one belongs to the device values.
    MalformedFileError
        The XML is broken or hostile, or a value is no number: with its line.
    ConditionError
        The file was measured under several conditions and none was chosen, or under another.
    SampleLimitError
        More elements than are accepted.
    """
    document = cxf_document(data)
    objects = list(cxf_objects(document))
    measurements = _measurements(objects)
    if not measurements:
        raise MissingColumnError(
            "The CxF file has no object with a measured colour or spectrum.",
            where={"field": "ObjectCollection"},
            remedy="Export the measurements, not the targets alone, as CxF3.",
        )
    labels, label = _labels(measurements, condition)
    targets = [entry for entry in objects if entry.device]
    rows, dropped = _joined(targets, measurements, labels, label)
    return _samples(document, rows, labels, label, dropped)


def _measurements(objects: list[CxfObject]) -> list[CxfObject]:
    # Where measurements are named as such, the colours of targets are aims or screen previews.
    named = [entry for entry in objects if entry.measured and entry.colours]
    return named or [entry for entry in objects if entry.colours]


def _labels(
    measurements: Iterable[CxfObject], asked: str | None
) -> tuple[dict[tuple[str, str], str | None], str | None]:
    """Return the name of each condition and backing, and the one that is to be used."""
    found = dict.fromkeys(
        (key.condition, key.backing) for entry in measurements for key in entry.colours
    )
    backings = {backing for _, backing in found}
    labels: dict[tuple[str, str], str | None] = {}
    for condition, backing in found:
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
    """Return targets with their measurements of one condition, and how many have no partner."""
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
    for identity in _IDENTITIES:
        pairs = _pairs(targets, alone, identity)
        if len(pairs) > len(best):
            best = pairs
        if len(best) == len(alone):
            break
    if not best:
        raise MissingColumnError(
            "No measurement belongs to any of the device values.",
            where={"line": alone[0].line, "field": "TagCollection"},
            remedy="Objects of one patch need the same tag SampleID, or the same tags Page, Row "
            "and Column.",
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
        if other.device != target.device and identity == "sample":
            raise MalformedFileError(
                f"Two objects with the SampleID {name[:40]} have different device values.",
                where={"line": target.line, "field": "SampleID"},
                remedy="Each device value needs a SampleID of its own.",
            )
    return [
        (known[name], entry)
        for entry in measurements
        if (name := entry.identity.get(identity)) is not None and name in known
    ]


def _samples(
    document: CxfDocument,
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
            f"The objects have no kind of colour in common; this one has no {most.kind} as others.",
            where={"line": lacking.line, "field": "ColorValues"},
            remedy="Every measurement needs the same kind of colour, or a spectrum of the same "
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
        for entry in specifications(document).values()
        if labels.get((entry.condition or "", entry.backing)) == label
    ]
    conditions = _conditions(document, keys)
    for specification in used:
        conditions = {**specification.facts, **conditions}
    emissive = {entry.emissive for entry in used} - {None}
    kind = "unknown"
    if len(emissive) == 1:
        kind = "emission" if True in emissive else "reflectance"
        conditions["DEVICE_CLASS"] = "DISPLAY" if True in emissive else "OUTPUT"
    warnings = []
    if dropped:
        warnings.append(f"{dropped} objects have device values or measurements only.")
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
    """Return one key per kind, colours for D50 and 2° first."""
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
    # One file states one illuminant: colours of another are left out.
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
            f"{len(channels)} channels are more than the {MAX_CHANNELS} that are accepted.",
            where={"field": "DeviceColorValues"},
        )
    for target, _ in rows:
        if target is not None and target.channels != channels:
            raise MalformedFileError(
                f"This object's device values are {', '.join(target.channels)}, others' are "
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
    places: dict[str, tuple[int, ...]] = {}
    wavelengths: tuple[float, ...] = ()
    for key in keys:
        if key.kind == "spectrum":
            wavelengths = tuple(key.start + key.step * band for band in range(key.bands))
            new = [f"SPEC_{wavelength:g}" for wavelength in wavelengths]
        else:
            new = list(_NAMES[key.kind])
        places[key.kind] = tuple(range(len(names), len(names) + len(new)))
        names += new
    return ColumnRoles(
        names=tuple(names),
        channels=channels,
        device=tuple(range(len(channels))),
        lab=places.get("lab"),
        lch=places.get("lch"),
        xyz=places.get("xyz"),
        xyy=places.get("xyy"),
        spectrum=places.get("spectrum", ()),
        wavelengths=wavelengths,
        condition=label,
    )


def _conditions(document: CxfDocument, keys: list[ColourKey]) -> dict[str, str]:
    information = document.root.file_information
    found = {
        "CREATOR": getattr(information, "creator", None),
        "DESCRIPTION": getattr(information, "description", None),
    }
    colour = next((key for key in keys if key.kind != "spectrum"), None)
    if colour is not None:
        found["ILLUMINANT"] = colour.illuminant
        found["OBSERVER"] = f"{colour.observer} degree" if colour.observer else None
    return {name: text for name, text in found.items() if isinstance(text, str) and text}
