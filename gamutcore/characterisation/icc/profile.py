"""Header and tags of an ICC profile, and the choice of tags for the transform of an intent.

Supported are input, display, output and colour space profiles of versions 2, 4 and 5 (iccMAX), with
1 to 15 device channels. Tags are read when needed. A damaged tag matters only if it is needed. The
description and the names of inks do not affect colours, so damage in them is not an error.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from gamutcore.characterisation.icc.transforms import (
    CurveSet,
    Matrix,
    Separation,
    TagData,
    Transform,
    curve_at,
    lut_transform,
    process_elements_transform,
    separation,
)
from gamutcore.characterisation.samples import JSON
from gamutcore.errors import MalformedProfileError, UnsupportedProfileError

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray

__all__ = ["IccProfile", "icc_profile", "looks_like_icc", "near_d50", "reduced_profile"]

LONGEST_NAME = 200
"""Maximum length of a name; longer names are cut."""


def _c_string(data: bytes) -> str:
    return data.decode("latin-1").partition("\0")[0]


def _printable(text: str) -> str:
    return "".join(c for c in text if c.isprintable()).strip()[:LONGEST_NAME]


T = TypeVar("T")

HEADER_SIZE = 128
MAX_TAGS = 1000
"""Maximum number of tags. Real profiles have some tens; other readers often accept 100."""

D50 = np.array([0.9642, 1.0, 0.8249])
"""XYZ of the profile connection space's illuminant (ICC.1:2022, 7.2.16)."""

CLASSES = {"scnr": "input", "mntr": "display", "prtr": "output", "spac": "colour space"}
BOUNDARIES = {"gbd0", "gbd1", "gbd2", "gbd3"}
ABSTRACT = "abstract"
"""A class without a device. Such a profile is accepted for its gamut boundary only."""

CHANNELS = {
    "GRAY": ("gray",),
    "RGB ": ("R", "G", "B"),
    "CMY ": ("C", "M", "Y"),
    "CMYK": ("C", "M", "Y", "K"),
    **{
        f"{digit}CLR": tuple(str(ink) for ink in range(1, int(digit, 16) + 1))
        for digit in "23456789ABCDEF"
    },
}
for _count in range(1, 16):
    # iccMAX writes the number of channels in the signature (ICC.2:2023, table 16).
    CHANNELS[f"nc\0{chr(_count)}"] = tuple(str(ink) for ink in range(1, _count + 1))
LUT_TAGS = {
    # The tag of each intent, and its substitutes (ICC.1:2022, 8.10.2 and 9.2).
    "perceptual": ("A2B0", "A2B1"),
    "relative": ("A2B1", "A2B0"),
    "saturation": ("A2B2", "A2B0", "A2B1"),
    "absolute": ("A2B1", "A2B0"),
}
PROCESS_TAGS = {
    # These take precedence (ICC.1:2022, 8.10.2). Absolute colours can be made from relative ones.
    "perceptual": ("D2B0",),
    "relative": ("D2B1",),
    "saturation": ("D2B2",),
    "absolute": ("D2B3", "D2B1"),
}
SEPARATION_TAGS = {
    # The tag of each intent, and its substitutes, as for A2B.
    "perceptual": ("B2A0", "B2A1"),
    "relative": ("B2A1", "B2A0"),
    "saturation": ("B2A2", "B2A0", "B2A1"),
    "absolute": ("B2A1", "B2A0"),
}
PROCESS_STAND_INS = ("D2B1", "D2B0", "D2B2")
"""Tags of other intents, for profiles without any other transform."""


def looks_like_icc(data: bytes) -> bool:
    """Return whether bytes have the signature of ICC profiles (ICC.1:2022, 7.2.11)."""
    return data[36:40] == b"acsp"


@dataclass(frozen=True, eq=False)
class IccProfile:
    """An ICC profile with a checked header.

    Attributes
    ----------
    data : bytes
        The file.
    version : tuple of int
        Major, minor, bug fix.
    device_class : str
        A value of `CLASSES`, or `ABSTRACT`.
    channels : tuple of str
        Names of the device channels.
    pcs : str
        ``"XYZ"`` or ``"Lab"``.
    tags : dict
        Signature to offset and size. `element` checks these.
    provenance : dict
        Format, version, class, description, white; JSON-able.
    warnings : tuple of str
        Faults that the reader tolerated.
    """

    data: bytes
    version: tuple[int, int, int]
    device_class: str
    channels: tuple[str, ...]
    pcs: str
    tags: dict[str, tuple[int, int]]
    provenance: dict[str, JSON] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()

    @property
    def format(self) -> str:
        """``"icc"``."""
        return "icc"

    @property
    def inks(self) -> bool:
        """Whether the device channels are inks, rather than RGB or gray."""
        return self.data[16:20] not in {b"RGB ", b"GRAY"}

    def element(self, tag: str) -> TagData:
        """Return the data of a tag; refuse one that is missing or exceeds the file."""
        if tag not in self.tags:
            raise MalformedProfileError(
                f"The profile has no tag {tag}.",
                where={"tag": tag},
                remedy="Make the profile again.",
            )
        offset, size = self.tags[tag]
        if offset < HEADER_SIZE or size < 8 or offset + size > len(self.data):
            raise MalformedProfileError(
                f"The tag {tag} of {size} bytes at offset {offset} is not within the profile's "
                f"{len(self.data)} bytes.",
                where={"tag": tag},
                remedy="Send the whole profile, or make it again.",
            )
        return TagData(tag, self.data[offset : offset + size])

    @property
    def description(self) -> str:
        """Text of `desc`: textDescription (version 2) or multiLocalizedUnicode; empty without."""
        try:
            tag = self.element("desc")
            if tag.kind == "mluc":
                length, offset = tag.unsigned(20, 4), tag.unsigned(24, 4)
                return _printable(tag.raw(offset, length).decode("utf-16-be", "replace"))
            if tag.kind == "desc":
                return _printable(_c_string(tag.raw(12, tag.unsigned(8, 4))))
        except MalformedProfileError:
            pass
        return ""

    def colorant_names(self) -> tuple[str, ...]:
        """Return the names of the inks from the tag `clrt` (ICC.1:2022, 10.5).

        The result is empty if a name is missing or repeated.
        """
        count = len(self.channels)
        try:
            tag = self.element("clrt")
            if tag.kind != "clrt" or tag.unsigned(8, 4) != count:
                return ()
            names = tuple(_printable(_c_string(tag.raw(12 + 38 * i, 32))) for i in range(count))
        except MalformedProfileError:
            return ()
        return names if all(names) and len(set(names)) == count else ()

    def xyz(self, tag: str) -> FloatArray:
        """Return the X, Y, Z (3,) of a tag of the type XYZ, such as ``wtpt``."""
        element = self.element(tag)
        if element.kind != "XYZ ":
            raise element.malformed(f"has the type {element.kind!r}, not XYZ")
        return element.fixed(8, 3)

    @property
    def lights(self) -> bool:
        """Whether the profile is that of a display or of an RGB space, rather than of a print."""
        return self.device_class in {"display", "colour space"} and not self.inks

    def media_white(self) -> tuple[FloatArray, list[str]]:
        """Return the media white point (3,), D50 if the profile has none, and warnings.

        Y is 1 for lights, whose luminance is relative to that of the white. A white that the tag
        states on another scale, or as chromaticities, is corrected with a warning. One that no
        medium has raises `MalformedProfileError`.
        """
        if "wtpt" not in self.tags:
            return D50, ["The profile has no media white point; D50 is assumed."]
        stated = self.xyz("wtpt")
        white, why = _corrected_white(stated, lights=self.lights)
        values = " ".join(f"{value:.6g}" for value in stated)
        if white is None:
            raise MalformedProfileError(
                f"The media white point (tag wtpt) is {values}, {why}.",
                where={"tag": "wtpt"},
                remedy="Give the intent relative, or make the profile again with a white whose "
                "Y is 1 (displays) or the reflectance of the paper.",
            )
        warnings = []
        if why:
            taken = " ".join(f"{value:.4f}" for value in white)
            warnings.append(
                f"The media white point (tag wtpt) is {values}, {why}; {taken} is used."
            )
        if self.lights and self.version[0] >= 4 and not near_d50(white):
            values = " ".join(f"{value:.4f}" for value in white)
            warnings.append(
                f"The media white point (tag wtpt) is {values}. In version {self.version[0]} it is "
                "D50 (ICC.1:2022, 9.2.36); it is taken as the display's own white."
            )
        return white, warnings

    def native_white(self) -> tuple[FloatArray | None, list[str]]:
        """Return the white (3,) before chromatic adaptation, and warnings; None without `chad`.

        The tag maps this white of the display, or of the light on the print, to D50. The colours of
        the profile are already adapted (ICC.1:2022, 9.2.15 and annex E).
        """
        if "chad" not in self.tags:
            return None, []
        matrix = self.adaptation_to_d50()
        if matrix is None:
            return None, ["The chromatic adaptation tag (chad) is malformed; it is not used."]
        white: FloatArray = np.linalg.solve(matrix, D50)
        return white, []

    def adaptation_to_d50(self) -> FloatArray | None:
        """Return the matrix (3, 3) of the tag `chad`; None if it is missing or malformed."""
        if "chad" not in self.tags:
            return None
        try:
            element = self.element("chad")
            matrix: FloatArray = element.fixed(8, 9).reshape(3, 3)
            white = np.linalg.solve(matrix, D50) if element.kind == "sf32" else np.zeros(3)
        except (MalformedProfileError, np.linalg.LinAlgError):
            return None
        return matrix if ((white > 0) & (white < 10)).all() else None

    def transform(self, intent: str) -> tuple[Transform, list[str]]:
        """Return the transform to the connection space of a rendering intent, and warnings.

        It is made of the multi-process elements (D2Bx) of the intent if all kinds of elements are
        supported, else of a lookup table (A2Bx), else of matrix and curves. ``"absolute"`` is the
        relative transform, unless the profile has an absolute one.
        """
        if self.device_class == ABSTRACT:
            raise UnsupportedProfileError(
                "The profile is abstract: it has no device values.",
                where={"field": "device_class"},
                remedy="Give source=boundary to use its gamut boundary.",
            )
        refusals: list[UnsupportedProfileError] = []
        for tag in (*PROCESS_TAGS[intent], *self._lut_tags(intent)):
            if tag in self.tags:
                try:
                    transform = self._tag_transform(tag)
                except UnsupportedProfileError as error:
                    # The next tag in precedence replaces an unsupported one (ICC.1:2022, 9.2.17,
                    # note).
                    refusals.append(error)
                    continue
                return transform, self._stand_in_warnings(intent, tag, refusals)
        if len(self.channels) == 3 and "rXYZ" in self.tags:
            return self._matrix_transform(), [error.message for error in refusals]
        if len(self.channels) == 1 and "kTRC" in self.tags:
            return self._gray_transform(), [error.message for error in refusals]
        for tag in PROCESS_STAND_INS:
            if tag in self.tags and tag not in PROCESS_TAGS[intent]:
                transform = self._tag_transform(tag)
                return transform, self._stand_in_warnings(intent, tag, refusals)
        if refusals:
            raise refusals[0]
        wanted = LUT_TAGS[intent][0]
        raise MalformedProfileError(
            "The profile has no transform from device values to colour.",
            where={"tag": wanted},
            remedy="It needs A2B or D2B tags, or rXYZ, gXYZ, bXYZ and rTRC, gTRC, bTRC, or kTRC.",
        )

    def separation(self, intent: str) -> Separation | None:
        """Return the separation of a rendering intent, from the connection space to device values.

        None for matrix and curves, which reach all device values. ``"absolute"`` has the table of
        relative colours. A profile with neither raises `UnsupportedProfileError`.
        """
        for tag in SEPARATION_TAGS[intent]:
            if tag in self.tags:
                return separation(self.element(tag), len(self.channels), self.pcs)
        if "TRC" in self.transform(intent)[0].tag:
            return None
        wanted = SEPARATION_TAGS[intent][0]
        raise UnsupportedProfileError(
            f"The profile has no table {wanted} from colours to device values.",
            where={"tag": wanted},
            remedy="Leave source=usable out: without B2A, no conversion reaches the device.",
        )

    def _lut_tags(self, intent: str) -> tuple[str, ...]:
        # iccMAX profiles have a tag for absolute colours (ICC.2:2023, 9.2.4).
        own = ("A2B3",) if intent == "absolute" and self.version[0] == 5 else ()
        return own + LUT_TAGS[intent]

    def _stand_in_warnings(
        self, intent: str, used: str, refusals: list[UnsupportedProfileError]
    ) -> list[str]:
        warnings = [error.message for error in refusals]
        if refusals:
            warnings.append(f"{used} is used instead.")
        elif used not in (*PROCESS_TAGS[intent], LUT_TAGS[intent][0], "A2B3"):
            warnings.append(f"{LUT_TAGS[intent][0]} is missing; {used} is used.")
        return warnings

    def _tag_transform(self, tag: str) -> Transform:
        element = self.element(tag)
        if tag.startswith("D2B") or (self.version[0] == 5 and element.kind == "mpet"):
            transform = process_elements_transform(element, len(self.channels), self.pcs)
        else:
            transform = lut_transform(element, len(self.channels), self.pcs)
        return replace(transform, absolute=tag in {"D2B3", "A2B3"})

    def _matrix_transform(self) -> Transform:
        # ICC.1:2022, annex F.3: linear = TRC(device), XYZ = matrix of the colorants · linear.
        curves = tuple(curve_at(self.element(tag))[0] for tag in ("rTRC", "gTRC", "bTRC"))
        columns = np.column_stack([self.xyz(tag) for tag in ("rXYZ", "gXYZ", "bXYZ")])
        if self.pcs != "XYZ":
            raise MalformedProfileError(
                "The profile has matrix and curves, but Lab as its connection space.",
                where={"field": "pcs"},
                remedy="Matrix and curves need XYZ (ICC.1:2022, 8.3.3).",
            )
        stages = (CurveSet(curves), Matrix(columns, np.zeros(3)))
        return Transform("rXYZ, gXYZ, bXYZ, rTRC, gTRC, bTRC", stages, "XYZ")

    def _gray_transform(self) -> Transform:
        # ICC.1:2022, annex F.2: the achromatic scale of the connection space's white.
        white = D50 if self.pcs == "XYZ" else np.array([100.0, 0.0, 0.0])
        curve, _ = curve_at(self.element("kTRC"))
        stages = (CurveSet((curve,)), Matrix(white[:, np.newaxis], np.zeros(3)))
        return Transform("kTRC", stages, self.pcs)


def icc_profile(data: bytes) -> IccProfile:
    """Return the ICC profile of version 2, 4 or 5 in some bytes.

    A malformed header or tag table raises `MalformedProfileError`. `UnsupportedProfileError` is
    raised for other versions, classes and colour spaces, and for iccMAX profiles with viewing
    conditions other than D50 and 2°, or with spectra only.
    """
    if len(data) < HEADER_SIZE + 4:
        raise MalformedProfileError(
            f"The profile ends after {len(data)} bytes, within its header.",
            where={"field": "size"},
            remedy="Send the whole profile.",
        )
    version = (data[8], data[9] >> 4, data[9] & 15)
    if version[0] not in {2, 3, 4, 5}:
        raise UnsupportedProfileError(
            f"The profile has version {version[0]}.",
            where={"field": "version"},
            remedy="Profiles of versions 2, 4 and 5 (iccMAX) are supported.",
        )
    tags = _tag_table(data)
    space = data[16:20].decode("latin-1")
    channels: tuple[str, ...] = ()
    if data[12:16] == b"abst" and space in {"Lab ", "XYZ "} and BOUNDARIES & set(tags):
        device_class = ABSTRACT
    else:
        device_class = _known(data[12:16], CLASSES, "device class")
        channels = _known(data[16:20], CHANNELS, "device colour space")
    pcs = data[20:24].decode("latin-1").strip()
    if version[0] == 5 and not pcs.strip("\0"):
        raise UnsupportedProfileError(
            "The profile has only spectra as results.",
            where={"field": "pcs"},
            remedy="Give an iccMAX profile whose connection space is XYZ or Lab.",
        )
    if pcs not in {"XYZ", "Lab"}:
        raise MalformedProfileError(
            f"The profile's connection space is {pcs!r}.",
            where={"field": "pcs"},
            remedy="It is XYZ or Lab in device profiles.",
        )
    profile = IccProfile(data, version, device_class, channels, pcs, tags)
    if version[0] == 5:
        _refuse_other_conditions(profile)
    return _described(profile, space)


_SAME_WHITE = 0.001
"""Largest difference in X, Y and Z of a white that counts as D50; profilers round differently."""

_UNIT_LUMINANCE = 0.02
"""Largest difference from 1 of the Y of a display's white that is rounding."""

_WHITE_X, _WHITE_Y = (0.24, 0.56), (0.24, 0.46)
"""Chromaticities that a white can have: daylight of any temperature to candle light, and papers."""

_PAPER = (0.02, 1.2)
"""Luminances that an unprinted medium can have: black textile to bright fluorescent paper."""


def near_d50(white: FloatArray) -> bool:
    """Whether X, Y, Z of a white are those of D50."""
    return bool(np.abs(white - D50).max() <= _SAME_WHITE)


def _chromaticity_is_white(x: float, y: float) -> bool:
    return _WHITE_X[0] <= x <= _WHITE_X[1] and _WHITE_Y[0] <= y <= _WHITE_Y[1]


def _corrected_white(stated: FloatArray, *, lights: bool) -> tuple[FloatArray | None, str]:
    """Return the white that a tag means, and what is wrong with it: a predicate, empty if nothing.

    The white is None if nothing tells what is meant.
    """
    x, y, z = stated.tolist()
    total = x + y + z
    plausible = min(x, y, z) > 0 and _chromaticity_is_white(x / total, y / total)
    if not plausible and _chromaticity_is_white(x, y) and lights:
        # x, y and 1, 0 or a luminance in place of X, Y, Z
        return np.array([x / y, 1.0, (1.0 - x - y) / y]), "which are x, y and not X, Y, Z"
    if not plausible:
        return None, "which no white has"
    if lights:
        white = stated / y
        far = abs(y - 1.0) > _UNIT_LUMINANCE
        return white, "where Y is 1 for the white of a display" if far else ""
    if y > 10.0 and y / 100.0 <= _PAPER[1]:
        return stated / 100.0, "on a scale to 100"
    if not _PAPER[0] <= y <= _PAPER[1]:
        return None, "which is " + ("darker" if y < 1.0 else "lighter") + " than any paper"
    return stated, ""


_ALWAYS_NEEDED = ("wtpt", "chad", "svcn", "clrt")
"""Tags that the colours of a transform depend on besides its own, and names of inks."""


def reduced_profile(profile: IccProfile, intent: str) -> bytes:
    """Return a profile with only the tags that the transform of an intent needs."""
    transform, _ = profile.transform(intent)
    needed = (*transform.tag.split(", "), *_ALWAYS_NEEDED)
    contents = {tag: profile.element(tag).data for tag in needed if tag in profile.tags}
    table, body = b"", b""
    start = HEADER_SIZE + 4 + 12 * len(contents)
    for tag, data in contents.items():
        table += struct.pack(">4sII", tag.encode("latin-1"), start + len(body), len(data))
        body += data + bytes(-len(data) % 4)
    size = struct.pack(">I", start + len(body))
    count = struct.pack(">I", len(contents))
    return size + profile.data[4:HEADER_SIZE] + count + table + body


def _refuse_other_conditions(profile: IccProfile) -> None:
    """Refuse an iccMAX profile whose connection space has another illuminant or observer.

    The tag c2sp converts such colours to D50 and 2° (ICC.2:2023, 6.3.2). It is not supported, and
    the colours would be wrong without it.
    """
    illuminant = np.frombuffer(profile.data[68:80], dtype=">i4") / 65536.0
    if illuminant.any() and np.abs(illuminant - D50).max() > 0.001:
        raise UnsupportedProfileError(
            f"The profile's connection space has the illuminant {illuminant.round(4).tolist()}.",
            where={"field": "illuminant"},
            remedy="Give an iccMAX profile for D50.",
        )
    if "svcn" in profile.tags:
        observer = profile.element("svcn").unsigned(8, 4)
        if observer not in {0, 1}:  # 1 is CIE 1931 (ICC.2:2023, table 38)
            raise UnsupportedProfileError(
                f"The profile's connection space is for the observer number {observer}.",
                where={"tag": "svcn"},
                remedy="Give an iccMAX profile for the CIE 1931 observer (2°).",
            )


def _known(signature: bytes, known: dict[str, T], what: str) -> T:
    text = signature.decode("latin-1")
    if text not in known:
        raise UnsupportedProfileError(
            f"The profile's {what} is {text!r}.",
            where={"field": what.replace(" ", "_")},
            remedy=f"Supported: {', '.join(n.strip() for n in known if n.isprintable())}.",
        )
    return known[text]


def _tag_table(data: bytes) -> dict[str, tuple[int, int]]:
    count = int.from_bytes(data[128:132], "big")
    end = HEADER_SIZE + 4 + 12 * count
    if count > MAX_TAGS or end > len(data):
        raise MalformedProfileError(
            f"The profile declares {count} tags, but has {len(data)} bytes.",
            where={"field": "tag_count"},
            remedy="Send the whole profile, or make it again.",
        )
    tags: dict[str, tuple[int, int]] = {}
    for signature, offset, size in struct.iter_unpack(">4sII", data[HEADER_SIZE + 4 : end]):
        # Of tags with one signature, the first counts, as in the reference implementation.
        tags.setdefault(signature.decode("latin-1"), (offset, size))
    return tags


def _described(profile: IccProfile, space: str) -> IccProfile:
    warnings = []
    if profile.version[0] == 3:
        warnings.append(
            "The profile declares version 3, which does not exist; it is read as version 2."
        )
    declared = int.from_bytes(profile.data[:4], "big")
    if declared != len(profile.data):
        warnings.append(f"The profile declares {declared} bytes, but has {len(profile.data)}.")
    if profile.device_class == "input":
        warnings.append(
            "An input profile describes the range of its encoding, not the gamut of a device."
        )
    channels = profile.channels
    if channels[:1] == ("1",):
        channels = profile.colorant_names() or channels
    provenance: dict[str, JSON] = {
        "format": "icc",
        "version": "{}.{}.{}".format(*profile.version),
        "device_class": profile.device_class,
        "colour_space": space.strip() if space.isprintable() else f"nc{ord(space[3]):04X}",
        "connection_space": profile.pcs,
        "channels": list[JSON](channels),
        "description": profile.description,
    }
    adapted, said = profile.native_white()
    warnings += said
    if adapted is not None:
        provenance["chromatic_adaptation"] = {
            "tag": "chad",
            "white": [round(float(value), 6) for value in adapted],
        }
    return replace(profile, channels=channels, provenance=provenance, warnings=tuple(warnings))
