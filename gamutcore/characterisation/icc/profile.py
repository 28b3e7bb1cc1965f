"""The header and tags of an ICC profile, and which of them make the transform of an intent.

Versions 2 and 4 of input, display, output and colour space profiles, with 1 to 15 device channels.
Tags are read when they are needed: a damaged tag matters only to those who need it.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from gamutcore.characterisation.icc.curves import curve_at
from gamutcore.characterisation.icc.element import Element
from gamutcore.characterisation.icc.lut import CurveSet, Matrix, Transform, lut_transform
from gamutcore.characterisation.samples import JSON
from gamutcore.errors import MalformedProfileError, UnsupportedProfileError

if TYPE_CHECKING:
    from gamutcore.arrays import FloatArray

__all__ = ["IccProfile", "icc_profile", "looks_like_icc"]

T = TypeVar("T")

HEADER_SIZE = 128
MAX_TAGS = 1000
"""Tags of a profile at most. Real ones have some tens; 100 is a common limit of readers."""

D50 = np.array([0.9642, 1.0, 0.8249])
"""XYZ of the profile connection space's illuminant (ICC.1:2022, 7.2.16)."""

CLASSES = {"scnr": "input", "mntr": "display", "prtr": "output", "spac": "colour space"}
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
LUT_TAGS = {
    # The tag of each intent, and those that stand in for it (ICC.1:2022, 8.10.2 and 9.2).
    "perceptual": ("A2B0", "A2B1"),
    "relative": ("A2B1", "A2B0"),
    "saturation": ("A2B2", "A2B0", "A2B1"),
    "absolute": ("A2B1", "A2B0"),
}


def looks_like_icc(data: bytes) -> bool:
    """Return whether bytes carry the signature of ICC profiles.

    Parameters
    ----------
    data : bytes
        The file.

    Returns
    -------
    bool
        ``acsp`` is at offset 36 (ICC.1:2022, 7.2.11).
    """
    return data[36:40] == b"acsp"


@dataclass(frozen=True, eq=False)
class IccProfile:
    """An ICC profile whose header was checked.

    Parameters
    ----------
    data : bytes
        The file.
    version : tuple of int
        Major, minor, bug fix.
    device_class : str
        ``"input"``, ``"display"``, ``"output"`` or ``"colour space"``.
    channels : tuple of str
        Names of the device channels.
    pcs : str
        ``"XYZ"`` or ``"Lab"``.
    tags : dict
        Signature to offset and size, not checked yet.
    provenance : dict
        Format, version, class, description, white; JSON-able.
    warnings : tuple of str
        What was tolerated in reading.
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

    def element(self, tag: str) -> Element:
        """Return the data of a tag.

        Parameters
        ----------
        tag : str
            Its signature.

        Returns
        -------
        Element

        Raises
        ------
        MalformedProfileError
            The profile does not have it, or it is not within the file.
        """
        if tag not in self.tags:
            raise MalformedProfileError(
                f"The profile has no tag {tag}.", where={"tag": tag}, remedy="Make it anew."
            )
        offset, size = self.tags[tag]
        if offset < HEADER_SIZE or size < 8 or offset + size > len(self.data):
            raise MalformedProfileError(
                f"The tag {tag} of {size} bytes at offset {offset} is not within the profile's "
                f"{len(self.data)} bytes.",
                where={"tag": tag},
                remedy="Send the whole profile, or make it anew.",
            )
        return Element(tag, self.data[offset : offset + size])

    def xyz(self, tag: str) -> FloatArray:
        """Return the X, Y, Z of a tag of the type XYZ.

        Parameters
        ----------
        tag : str
            Its signature, such as ``"wtpt"``.

        Returns
        -------
        (3,) float

        Raises
        ------
        MalformedProfileError
            The tag is missing, broken or of another type.
        """
        element = self.element(tag)
        if element.kind != "XYZ ":
            raise element.malformed(f"is of the type {element.kind!r} and not XYZ")
        return element.fixed(8, 3)

    def media_white(self) -> tuple[FloatArray, list[str]]:
        """Return the media white point, and warnings about it.

        Returns
        -------
        white : (3,) float
            X, Y, Z; D50 where the profile states none.
        warnings : list of str

        Raises
        ------
        MalformedProfileError
            It is broken, or not positive.
        """
        if "wtpt" not in self.tags:
            return D50, ["The profile has no media white point; D50 is assumed."]
        white = self.xyz("wtpt")
        if not (white > 0).all() or (white > 10).any():
            raise MalformedProfileError(
                f"The media white point is {white.tolist()}.",
                where={"tag": "wtpt"},
                remedy="X, Y and Z of the white are near 1.",
            )
        return white, []

    def transform(self, intent: str) -> tuple[Transform, list[str]]:
        """Return the transform from device values to the connection space, and warnings.

        Parameters
        ----------
        intent : str
            ``"perceptual"``, ``"relative"``, ``"saturation"`` or ``"absolute"`` (which has the
            transform of relative).

        Returns
        -------
        transform : Transform
            By lookup table where the profile has one, else by matrix and curves.
        warnings : list of str
            Which tag stands in for a missing one.

        Raises
        ------
        MalformedProfileError
            A tag that is needed is missing or broken.
        UnsupportedProfileError
            The profile has only transforms of another kind.
        """
        wanted = LUT_TAGS[intent]
        for tag in wanted:
            if tag in self.tags:
                missing = [] if tag == wanted[0] else [f"{wanted[0]} is missing; {tag} is used."]
                return lut_transform(self.element(tag), len(self.channels), self.pcs), missing
        if len(self.channels) == 3 and "rXYZ" in self.tags:
            return self._matrix_transform(), []
        if len(self.channels) == 1 and "kTRC" in self.tags:
            return self._gray_transform(), []
        if any(tag.startswith("D2B") for tag in self.tags):
            raise UnsupportedProfileError(
                "The profile has transforms of multi-process elements (D2Bx) only.",
                where={"tag": "D2B1"},
                remedy="Send a profile with A2B tags, or with matrix and curves.",
            )
        raise MalformedProfileError(
            "The profile has no transform from device values to colour.",
            where={"tag": wanted[0]},
            remedy="It needs A2B tags, or rXYZ, gXYZ, bXYZ and rTRC, gTRC, bTRC, or kTRC.",
        )

    def _matrix_transform(self) -> Transform:
        # ICC.1:2022, annex F.3: linear = TRC(device), XYZ = matrix of the colorants · linear.
        curves = tuple(curve_at(self.element(tag))[0] for tag in ("rTRC", "gTRC", "bTRC"))
        columns = np.column_stack([self.xyz(tag) for tag in ("rXYZ", "gXYZ", "bXYZ")])
        if self.pcs != "XYZ":
            raise MalformedProfileError(
                "The profile has matrix and curves with Lab for its connection space.",
                where={"field": "pcs"},
                remedy="Matrix and curves lead to XYZ (ICC.1:2022, 8.3.3).",
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
    """Return the ICC profile in some bytes.

    Parameters
    ----------
    data : bytes
        The file, of version 2 or 4.

    Returns
    -------
    IccProfile

    Raises
    ------
    MalformedProfileError
        The header or the tag table is broken.
    UnsupportedProfileError
        The profile is of another version (such as iccMAX), class or colour space.
    """
    if len(data) < HEADER_SIZE + 4:
        raise MalformedProfileError(
            f"The profile ends after {len(data)} bytes, within its header.",
            where={"field": "size"},
            remedy="Send the whole profile.",
        )
    version = (data[8], data[9] >> 4, data[9] & 15)
    if version[0] not in {2, 4}:
        raise UnsupportedProfileError(
            f"The profile is of version {version[0]}{' (iccMAX)' if version[0] == 5 else ''}.",
            where={"field": "version"},
            remedy="Profiles of versions 2 and 4 are read.",
        )
    device_class = _known(data[12:16], CLASSES, "device class")
    space = data[16:20].decode("latin-1")
    channels = _known(data[16:20], CHANNELS, "device colour space")
    pcs = data[20:24].decode("latin-1").strip()
    if pcs not in {"XYZ", "Lab"}:
        raise MalformedProfileError(
            f"The profile's connection space is {pcs!r}.",
            where={"field": "pcs"},
            remedy="It is XYZ or Lab in device profiles.",
        )
    tags = _tag_table(data)
    profile = IccProfile(data, version, device_class, channels, pcs, tags)
    return _described(profile, space)


def _known(signature: bytes, known: dict[str, T], what: str) -> T:
    text = signature.decode("latin-1")
    if text not in known:
        raise UnsupportedProfileError(
            f"The profile's {what} is {text!r}.",
            where={"field": what.replace(" ", "_")},
            remedy=f"Evaluated are: {', '.join(name.strip() for name in known)}.",
        )
    return known[text]


def _tag_table(data: bytes) -> dict[str, tuple[int, int]]:
    count = int.from_bytes(data[128:132], "big")
    end = HEADER_SIZE + 4 + 12 * count
    if count > MAX_TAGS or end > len(data):
        raise MalformedProfileError(
            f"The profile says that it has {count} tags, and has {len(data)} bytes.",
            where={"field": "tag_count"},
            remedy="Send the whole profile, or make it anew.",
        )
    tags: dict[str, tuple[int, int]] = {}
    for signature, offset, size in struct.iter_unpack(">4sII", data[HEADER_SIZE + 4 : end]):
        # The first of several tags of the same signature counts, as for the reference.
        tags.setdefault(signature.decode("latin-1"), (offset, size))
    return tags


def _described(profile: IccProfile, space: str) -> IccProfile:
    warnings = []
    declared = int.from_bytes(profile.data[:4], "big")
    if declared != len(profile.data):
        warnings.append(
            f"The profile says that it has {declared} bytes, and has {len(profile.data)}."
        )
    if profile.device_class == "input":
        warnings.append(
            "An input profile describes the range of its encoding, not the gamut of a device."
        )
    channels = profile.channels
    if space.endswith("CLR"):
        channels = _colorant_names(profile) or channels
    provenance: dict[str, JSON] = {
        "format": "icc",
        "version": "{}.{}.{}".format(*profile.version),
        "device_class": profile.device_class,
        "colour_space": space.strip(),
        "connection_space": profile.pcs,
        "channels": list[JSON](channels),
        "description": _description(profile),
    }
    return IccProfile(
        profile.data,
        profile.version,
        profile.device_class,
        channels,
        profile.pcs,
        profile.tags,
        provenance,
        tuple(warnings),
    )


def _printable(text: str) -> str:
    return "".join(c for c in text if c.isprintable()).strip()[:200]


def _description(profile: IccProfile) -> str:
    """Return the profile's name for people, or nothing: it is no reason to refuse the rest."""
    try:
        element = profile.element("desc")
        if element.kind == "mluc":
            length, offset = element.unsigned(20, 4), element.unsigned(24, 4)
            return _printable(element.raw(offset, length).decode("utf-16-be", "replace"))
        if element.kind == "desc":
            length = element.unsigned(8, 4)
            return _printable(element.raw(12, length).decode("latin-1").partition("\0")[0])
    except MalformedProfileError:
        pass
    return ""


def _colorant_names(profile: IccProfile) -> tuple[str, ...]:
    try:
        element = profile.element("clrt")
        if element.kind != "clrt" or element.unsigned(8, 4) != len(profile.channels):
            return ()
        names = tuple(
            _printable(element.raw(12 + 38 * i, 32).decode("latin-1").partition("\0")[0])
            for i in range(len(profile.channels))
        )
    except MalformedProfileError:
        return ()
    return names if all(names) and len(set(names)) == len(names) else ()
