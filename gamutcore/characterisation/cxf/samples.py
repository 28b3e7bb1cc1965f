"""Samples from CxF3 files (.cxf, .mxf, .txf; ISO 17972-1).

A file has device values and measurements as separate objects. Tags join them: SampleID, or the
position on the chart. This module joins the objects of one measurement condition. A file measured
under M0, M1 and M2 holds three characterisations, and the caller chooses one of them.
"""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

import numpy as np

from gamutcore.characterisation.columns import ColumnRoles
from gamutcore.characterisation.conditions import chosen_condition
from gamutcore.characterisation.cxf.element_tree import cxf_root
from gamutcore.characterisation.cxf.objects import (
    ColourKey,
    CxfObject,
    cxf_objects,
    specifications,
)
from gamutcore.characterisation.samples import Samples, samples_from_values
from gamutcore.errors import MalformedFileError, MissingColumnError, SampleLimitError

if TYPE_CHECKING:
    from collections.abc import Iterable
    from xml.etree.ElementTree import Element

__all__ = ["cxf_samples"]

MAX_CHANNELS = 15
"""Maximum number of channels of a device, as in ICC profiles (ICC.1:2022, 7.2.8)."""

_NAMES = {
    "lab": ("LAB_L", "LAB_A", "LAB_B"),
    "lch": ("LCH_L", "LCH_C", "LCH_H"),
    "xyz": ("XYZ_X", "XYZ_Y", "XYZ_Z"),
    "xyy": ("XYY_X", "XYY_Y", "XYY_CAPY"),
}
_IDENTITIES = {"sample": "SampleID", "location": "Page, Row and Column", "name": "Name"}
"""Keys by which objects are joined, the most reliable first, with their names in errors. A key is
not used if two objects with one value of the key have different device values."""


def cxf_samples(data: bytes, *, condition: str | None = None) -> Samples:
    """Return the samples in a CxF3 file.

    Parameters
    ----------
    data : bytes
        The file.
    condition : str, optional
        The measurement condition to read, if the file has several.

    Returns
    -------
    Samples
        Device values with measurements. Objects are joined by SampleID, else by page, row and
        column, else by name. Without any device values, all colours.

    Raises
    ------
    UnrecognisedFormatError
        The XML has another schema.
    MissingColumnError
        No object has a colour, or no measurement matches the device values.
    MalformedFileError
        The XML is not well formed or exceeds a limit, or a value is not a number. ``where`` has
        the line.
    ConditionError
        The file has several conditions and none was chosen, or not the chosen one.
    SampleLimitError
        The file has too many elements.
    """
    root = cxf_root(data)
    objects = list(cxf_objects(root))
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
    return _samples(root, rows, labels, label, dropped)


def _measurements(objects: list[CxfObject]) -> list[CxfObject]:
    # If some objects are named measurements, the colours of targets are aims or previews.
    named = [entry for entry in objects if entry.measured and entry.colours]
    return named or [entry for entry in objects if entry.colours]


def _labels(
    measurements: Iterable[CxfObject], asked: str | None
) -> tuple[dict[tuple[str, str], str | None], str | None]:
    """Return the name of each pair of condition and backing, and the name to use."""
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
        for entry in specifications(root).values()
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


def _conditions(root: Element, keys: list[ColourKey]) -> dict[str, str]:
    found = {
        "CREATOR": root.findtext("FileInformation/Creator"),
        "DESCRIPTION": root.findtext("FileInformation/Description"),
    }
    colour = next((key for key in keys if key.kind != "spectrum"), None)
    if colour is not None:
        found["ILLUMINANT"] = colour.illuminant
        found["OBSERVER"] = f"{colour.observer} degree" if colour.observer else None
    return {name: text for name, text in found.items() if text}
