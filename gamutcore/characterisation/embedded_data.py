"""What a profile carries besides its transforms: measurements, and ink limits that data states.

Profiling software stores the patches from which it made a profile in the tags `targ` (Argyll, GMG
and others: CGATS text with device values and colours) and `CxF `. Gretag and X-Rite use `CIED` with
`DevD`: colours and device values in one or two texts, as CGATS or CxF. The tags have the measured
values without the profile's smoothing, and the measurement conditions. `targ` may instead name a
data set of ICC's characterization data registry.

`stated_ink_limit` only reads the limit. `gamutcore.building.ink_limits` applies it, unless the
options give another one.
"""

from __future__ import annotations

import re
import zlib
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gamutcore.characterisation.icc import IccProfile, largest_output_sum
from gamutcore.characterisation.recognition import read_characterisation
from gamutcore.characterisation.samples import JSON, Samples
from gamutcore.errors import (
    CharacterisationError,
    GamutError,
    InvalidPointsError,
    MalformedProfileError,
    MissingColumnError,
    OptionError,
)

if TYPE_CHECKING:
    from gamutcore.characterisation.recognition import Characterisation

__all__ = [
    "embedded_measurements",
    "stated_ink_limit",
]

MEASUREMENT_TAGS = ("targ", "CIED", "CxF ")
"""Tags with colours, in order of preference."""

DEVICE_TAG = "DevD"
"""Tag with the device values, if `CIED` has colours only."""

MAX_TEXT = 64 * 1024 * 1024
"""Maximum size of an embedded text in bytes, unpacked. The largest targets take about 10 MB."""

_REGISTERED = b"ICCHDAT"
"""First characters of a reference to a registered data set (ICC.1:2022, charTargetTag)."""
_REGISTRY = "https://www.color.org/registry2.xalter"
MAX_NAME = 80

_PLAIN = ("text", "utf8", "data")
_PACKED = ("ZXML", "zut8")
_SECTION = re.compile(
    r"BEGIN_DATA_FORMAT\s(?P<names>.*?)\sEND_DATA_FORMAT.*?BEGIN_DATA\s(?P<rows>.*?)\sEND_DATA",
    re.DOTALL | re.IGNORECASE,
)
_VALUE = re.compile(r'"[^"\n]*"|\S+')
_IDENTITIES = ("SAMPLE_ID", "SAMPLEID", "SAMPLE_NAME", "SAMPLE_NO", "SAMPLE_LOC")


def embedded_measurements(data: Characterisation, *, condition: str | None = None) -> Samples:
    """Return the measurements embedded in a profile.

    The profile's names of inks apply where the text only numbers them, and its device class where
    the text has none. The provenance has the tag and the profile's name.

    Parameters
    ----------
    data : IccProfile
        Other data is refused.
    condition : str, optional
        The measurement condition to read.

    Raises
    ------
    OptionError
        The data is not a profile, or the profile has no measurements.
    CharacterisationError, InvalidPointsError
        The measurements are malformed; ``where["tag"]`` names the tag.
    """
    if not isinstance(data, IccProfile):
        raise OptionError(
            "source is 'measurements', but the data is not an ICC profile.",
            where={"field": "source"},
            remedy="Leave it out: only profiles have measurements besides their own content.",
        )
    tags = [tag for tag in MEASUREMENT_TAGS if tag in data.tags]
    data_set = _registered_data_set(data) if "targ" in tags else None
    if data_set is not None:
        tags.remove("targ")
    if not tags:
        raise _no_measurements(data_set)
    tag = tags[0]
    text = embedded_text(data, tag)
    try:
        if tag == "CIED" and DEVICE_TAG in data.tags:
            text = _with_device_values(text, data)
        samples = read_characterisation(text, condition=condition)
    except GamutError as error:
        if isinstance(error, CharacterisationError | InvalidPointsError):
            error.where.setdefault("tag", tag)
        raise
    if not isinstance(samples, Samples):
        raise MalformedProfileError(
            f"The tag {tag} has no measurements.",
            where={"tag": tag},
            remedy="It is a text with columns of device values and colours.",
        )
    return _described(samples, data, tag)


def _no_measurements(data_set: str | None) -> OptionError:
    known = ", ".join(name.strip() for name in MEASUREMENT_TAGS)
    why, advice = f"the profile has none of the tags {known}", "send the measurements themselves"
    if data_set is not None:
        why = f"the profile only refers to the registered data set {data_set}"
        advice = f"send the data set, which the registry at {_REGISTRY} describes"
    return OptionError(
        f"source is 'measurements', and {why}.",
        where={"field": "source"},
        remedy=f"Leave it out, or {advice}.",
    )


def _registered_data_set(profile: IccProfile) -> str | None:
    """Return the registered name that the tag `targ` has in place of measurements, or None."""
    element = profile.element("targ")
    text = element.data[8:]
    if element.kind != "text" or not text.startswith(_REGISTERED):
        return None
    name = text[len(_REGISTERED) :].split(b"\0")[0].decode("latin-1").strip()
    return name[:MAX_NAME] or "without a name"


def _described(samples: Samples, profile: IccProfile, tag: str) -> Samples:
    conditions = dict(samples.conditions)
    stated = {"display": "DISPLAY", "output": "OUTPUT"}.get(profile.device_class)
    if stated is not None and samples.device is not None:
        conditions.setdefault("DEVICE_CLASS", stated)
    channels = samples.channels
    if len(channels) == len(profile.channels) and all(name.isdigit() for name in channels):
        channels = profile.channels
    provenance: dict[str, JSON] = {
        **samples.provenance,
        "channels": list[JSON](channels),
        "conditions": dict[str, JSON](conditions),
        "source": "measurements",
        "embedded": {
            "tag": tag.strip(),
            "description": profile.provenance.get("description", ""),
            "device_class": profile.device_class,
        },
    }
    return replace(samples, channels=channels, conditions=conditions, provenance=provenance)


def embedded_text(profile: IccProfile, tag: str) -> bytes:
    """Return the bytes of a text tag, unpacked where it is packed."""
    element = profile.element(tag)
    kind = element.kind
    if kind in _PLAIN:
        content = element.data[12 if kind == "data" else 8 :]
    elif kind in _PACKED:
        unpacker = zlib.decompressobj()
        try:
            content = unpacker.decompress(_packed_part(element.data), MAX_TEXT + 1)
        except zlib.error as cause:
            raise element.malformed(f"cannot be unpacked ({cause})") from cause
    else:
        raise element.malformed(
            f"is of the type {kind!r}",
            f"Measurements are a text of the type {', '.join((*_PLAIN, *_PACKED))}.",
        )
    if len(content) > MAX_TEXT:
        raise element.malformed(f"holds more than {MAX_TEXT} bytes of text")
    return content.rstrip(b"\0")


def _packed_part(data: bytes) -> bytes:
    """Return the zlib stream of a tag of packed text.

    Argyll's ``zut8`` and some writers of ``ZXML`` put it behind the type and its four reserved
    bytes. X-Rite's ``ZXML`` has four more, a number that is 1 in the profiles that are known. Where
    a stream begins is told by its header (RFC 1950, 2.2): method 8, and divisible by 31.
    """
    start, later = 8, 12
    header = data[start : start + 2]
    if len(header) == 2 and header[0] & 15 == 8 and int.from_bytes(header, "big") % 31 == 0:
        return data[start:]
    return data[later:]


def _with_device_values(text: bytes, profile: IccProfile) -> bytes:
    """Return a CGATS text of colours with the columns of the device values' text put before them.

    Rows belong together by their sample's name, or by their order where either has no names.
    """
    colours = _SECTION.search(text.decode("latin-1"))
    devices = _SECTION.search(embedded_text(profile, DEVICE_TAG).decode("latin-1"))
    if colours is None or devices is None:
        return text  # another format, such as CxF, which has both
    names, device_names = colours["names"].split(), devices["names"].split()
    if {name.upper() for name in device_names} <= {name.upper() for name in names}:
        return text
    rows = _rows(colours["rows"], len(names), "CIED")
    device_rows = _rows(devices["rows"], len(device_names), DEVICE_TAG)
    sample_place, device_place = _identity(names), _identity(device_names)
    if sample_place is not None and device_place is not None:
        known = {row[device_place].strip('"'): row for row in device_rows}
        missing = [row[sample_place] for row in rows if row[sample_place].strip('"') not in known]
        if missing:
            raise MissingColumnError(
                f"The sample {missing[0][:40]} has no device values in the tag {DEVICE_TAG}.",
                where={"tag": DEVICE_TAG},
                remedy="Both tags name the same samples.",
            )
        device_rows = [known[row[sample_place].strip('"')] for row in rows]
    elif len(rows) != len(device_rows):
        raise MissingColumnError(
            f"The tag CIED has {len(rows)} samples and {DEVICE_TAG} {len(device_rows)}.",
            where={"tag": DEVICE_TAG},
            remedy="Both tags hold the same samples.",
        )
    taken = {name.upper() for name in names}
    device_columns = [i for i, name in enumerate(device_names) if name.upper() not in taken]
    header = text[: text.upper().index(b"BEGIN_DATA_FORMAT")].decode("latin-1")
    joined = [
        header,
        "BEGIN_DATA_FORMAT",
        " ".join([*names, *(device_names[i] for i in device_columns)]),
        "END_DATA_FORMAT",
        "BEGIN_DATA",
        *(
            " ".join([*row, *(device[i] for i in device_columns)])
            for row, device in zip(rows, device_rows, strict=True)
        ),
        "END_DATA\n",
    ]
    return "\n".join(joined).encode("latin-1")


def _rows(text: str, width: int, tag: str) -> list[list[str]]:
    values = _VALUE.findall(text)
    if not width or len(values) % width:
        raise MissingColumnError(
            f"The tag {tag} has {len(values)} values for {width} columns.",
            where={"tag": tag},
            remedy="Every row needs one value for each column.",
        )
    return [values[start : start + width] for start in range(0, len(values), width)]


def _identity(names: list[str]) -> int | None:
    upper = [name.upper() for name in names]
    return next((upper.index(name) for name in _IDENTITIES if name in upper), None)


KEYWORD = "TOTAL_INK_LIMIT"
"""Keyword of Argyll's targets and measurements (ArgyllCMS, File Formats, .ti1)."""

SEPARATIONS = ("B2A1", "B2A0")
"""Tables from colours to device values, in the order of preference: colorimetric, perceptual."""

_STATED = re.compile(rf'^\s*{KEYWORD}\s+"?(\d{{1,4}}(?:\.\d{{0,6}})?)', re.MULTILINE)
_PER_CENT = re.compile(r"\d{1,4}(\.\d*)?")


class StatedLimit(NamedTuple):
    """The largest sum of all inks by the data itself: per cent of one full ink, source."""

    total: float
    source: str


def stated_ink_limit(data: Characterisation) -> StatedLimit | None:
    """Return the total ink limit that data states itself; None without one below all inks.

    It is the keyword `TOTAL_INK_LIMIT` of measurements, also of those in a profile's tag `targ`,
    else the largest sum of device values in the profile's table from colours to device values.
    """
    if not isinstance(data, Samples | IccProfile) or not data.inks:
        return None
    if isinstance(data, Samples):
        text = data.conditions.get(KEYWORD, "").strip()
        limit = StatedLimit(float(text), KEYWORD) if _PER_CENT.fullmatch(text) else None
    else:
        limit = _of_profile(data)
    all_inks = 100.0 * len(data.channels)
    return limit if limit is not None and 0.0 < limit.total < all_inks - 0.5 else None


def _of_profile(profile: IccProfile) -> StatedLimit | None:
    # damage in tags that colours do not need does not matter
    if "targ" in profile.tags:
        with suppress(CharacterisationError):
            match = _STATED.search(embedded_text(profile, "targ").decode("latin-1"))
            if match is not None:
                return StatedLimit(float(match[1]), f"{KEYWORD} in the tag targ")
    for tag in SEPARATIONS:
        if tag in profile.tags:
            with suppress(CharacterisationError):
                total = largest_output_sum(profile.element(tag), len(profile.channels))
                if total is not None:
                    return StatedLimit(float(np.round(100.0 * total)), f"largest sum in {tag}")
    return None
